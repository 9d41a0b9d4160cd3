"""Solids on disk: what is read equals what was computed, and whatever cannot be read is computed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import scenelang as sl
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter import loading
from scenelang.interpreter.scene.entity import descendants
from scenelang.interpreter.scene.modelling import computing, stored
from scenelang.interpreter.scene.modelling.computing import ComputedSolid, computed
from scenelang.interpreter.scene.modelling.operations import Expression
from scenelang.interpreter.scene.modelling.solid import SolidShape, compute_all

PROGRAM = """
(bind "part" (lambda (:size)
  (difference (call "cube" :color [1 0 0]) (call "sphere" :radius size :color [0 0 1]))))
(bind "scene" (lambda () (call "part" :size {size})))
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache folder, in which every solid is worth storing."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(computing, "_MIN_STORED_SECONDS", -1.0)
    monkeypatch.setattr(computing, "_surfaces", computing._TriangleCache(1 << 20))
    return tmp_path / "scenelang" / "solids"


def expression_of(size: float) -> Expression:
    roots = sl.evaluate(PROGRAM.format(size=size)).graph.frames
    (shape,) = (entity.shape for entity in descendants(*roots) if isinstance(entity.shape, SolidShape))
    return shape.expression


def again(expression: Expression, monkeypatch: pytest.MonkeyPatch) -> ComputedSolid:
    """Return the surface as a new process finds it, which may not compute."""
    with monkeypatch.context() as patch:
        patch.setattr(computing, "_surfaces", computing._TriangleCache(1 << 20))
        patch.setattr(computing, "manifold_of", lambda _: pytest.fail("computed"))
        return computed(expression)


def test_what_is_read_is_what_was_computed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expression = expression_of(0.601)
    before = computed(expression)
    after = again(expression, monkeypatch)
    assert after is not before
    for name in ("vertices", "normals", "faces", "colors", "joints", "part"):
        np.testing.assert_array_equal(getattr(after.mesh, name), getattr(before.mesh, name))
    np.testing.assert_array_equal(after.hull, before.hull)
    assert (after.mesh.part_words, after.volume, after.area) == (before.mesh.part_words, before.volume, before.area)
    assert len(list(folder.glob("*/*"))) == 1


@pytest.mark.parametrize("damage", ["empty", "cut", "other", "indices", "size"])
def test_damaged_files_are_not_used(damage: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expression = expression_of(0.602)
    before = computed(expression)
    (path,) = folder.glob("*/*.npz")
    whole = path.read_bytes()
    if damage in ("empty", "cut"):
        path.write_bytes(whole[: 0 if damage == "empty" else len(whole) // 2])
    elif damage == "other":
        path.write_text(json.dumps({"vertices": []}))
    else:
        with np.load(path) as file:
            data = dict(file)
        data["faces"] = data["faces"] + 1 if damage == "indices" else data["faces"][:-1]
        np.savez(path, **data)
    assert stored.load(expression.digest) is None
    with monkeypatch.context() as patch:
        patch.setattr(computing, "_surfaces", computing._TriangleCache(1 << 20))
        assert computed(expression).volume == before.volume


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "file"
    file.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(file))
    assert computed(expression_of(0.603)).volume > 0.0


def test_a_home_that_is_unknown_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(purpose: str) -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(loading, "user_folder", nowhere)
    assert computed(expression_of(0.604)).volume > 0.0


def test_files_used_longest_ago_are_deleted_first(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    expressions = [expression_of(size) for size in (0.605, 0.606, 0.607)]
    for number, expression in enumerate(expressions[:2]):
        computed(expression)
        (path,) = folder.glob(f"*/{expression.digest}.npz")
        os.utime(path, (1_000 + number, 1_000 + number))
    again(expressions[0], monkeypatch)  # is now the newest
    monkeypatch.setattr(loading, "MAX_CACHED_BYTES", int(2.5 * path.stat().st_size))
    computed(expressions[2])
    assert {path.stem for path in folder.glob("*/*.npz")} == {expressions[0].digest, expressions[2].digest}


def test_only_what_took_long_is_stored(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computing, "_MIN_STORED_SECONDS", 1e9)
    computed(expression_of(0.608))
    assert not folder.exists()


def test_solids_of_the_evaluation_are_stored_when_it_has_ended(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:  # as the confined thread does
        patch.setattr(stored, "save", lambda digest, solid: None)
        expression = expression_of(0.609)
        computed(expression)
    scene = sl.evaluate(PROGRAM.format(size=0.609))
    compute_all(scene.graph.frames)
    assert [path.stem for path in folder.glob("*/*.npz")] == [expression.digest]


def test_errors_are_not_stored(folder: Path) -> None:
    expression = expression_of(2.0)
    for _ in range(2):
        with pytest.raises(SceneError, match="leaves nothing"):
            computed(expression)
    assert not folder.exists()


def test_another_process_reads_them(tmp_path: Path, folder: Path) -> None:
    """A confined evaluation measures a part: the first process stores it, the second reads it."""
    program = tmp_path / "a.scene"
    program.write_text('(bind "scene" (lambda () (call "cube" :scale (volume (rounded (call "cube") .2)))))')
    told = []
    for _ in range(2):
        command = [sys.executable, "-m", "scenelang", "measure", str(program), "--json"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        told.append(done.stdout)
    assert told[0] == told[1]


THREADS = """
import os, sys
os.sched_setaffinity(0, {int(part) for part in sys.argv[1].split(",")})
import hashlib
import scenelang as sl
from scenelang.interpreter.scene.entity import descendants
scene = sl.load(sys.argv[2])
for entity in descendants(*scene.graph.frames):
    computed = getattr(entity.shape, "computed", None)
    if computed is not None:
        mesh = computed.mesh
        print(hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest(), computed.volume, computed.area)
"""
MANY = """
(bind "all" (lambda () (union
  (solid-union (grid (call "sphere" :radius .6) :nx 4 :nz 4 :spacing 1))
  (difference (call "cube" :scale 3) (call "sphere" :radius 1.8) (call "cylinder" :radius .4 :p1 [0 4 0]))
  (hull (call "sphere" :radius .6) (call "cone" :radius .2 :p1 [3 1 0]))
  (rounded (difference (call "cube") (call "cylinder" :radius .2 :p1 [0 2 0]) :segments 12) .1 :segments 6)
  (minkowski (call "cube") (call "sphere" :radius .2) :segments 8))))
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity") or len(os.sched_getaffinity(0)) < 2, reason="one processor")
@pytest.mark.slow
def test_surfaces_do_not_depend_on_the_number_of_threads(tmp_path: Path) -> None:
    program = tmp_path / "a.scene"
    program.write_text(MANY)
    one, *others = sorted(os.sched_getaffinity(0))
    told = []
    for number, processors in enumerate(([one], [one, *others])):
        environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / f"cache{number}")}
        command = [sys.executable, "-c", THREADS, ",".join(map(str, processors)), str(program)]
        told.append(subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout)
    assert len(told[0].splitlines()) == 5
    assert told[0] == told[1]
