"""The Python API: scenes, their results, errors, threads, and the signatures that users rely on."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenelang as sl
from scenelang.interpreter.inspection.numbering import primitive_handles
from scenelang.interpreter.scene.flatten import flatten

ROOT = Path(__file__).parents[2]
ROW = '(bind "pair" (lambda () (union (call "red cup" :color [1 0 0]) (transform (call "cube") (translate [3 0 0])))))'
TEXT = """
(param width 2 "sizes")
(bind "peg" (lambda () (call "cylinder" :radius .25 :color [1 0 0])))
(bind "board" (lambda ()
  (union (call "cube" :scale [width .5 1])
         (transform (call "peg") (translate [-.5 .25 0]))
         (transform (call "peg") (translate [.5 .25 0])))))
"""
SPIN = """
(bind "spin" (lambda ()
  (map (lambda (i) (union (transform (call "cube") (translate [i 0 0])))) (iota 3))))
"""


@pytest.fixture(scope="module")
def board() -> sl.Scene:
    return sl.evaluate(TEXT, root="board")


def test_facts(board: sl.Scene) -> None:
    assert repr(board) == '<Scene "board": 3 primitives>'
    assert board.words == ["board", "cube", "cylinder", "peg"]
    assert board.count() == {"board": 1, "cube": 1, "peg": 2, "cylinder": 2}
    assert board.bounds is not None
    assert board.extents is not None
    np.testing.assert_allclose(board.bounds, [[-1, -0.25, -0.5], [1, 1.25, 0.5]])
    np.testing.assert_allclose(board.extents, [2, 1.5, 1])
    np.testing.assert_allclose(board.bounds_of("peg"), [[-0.75, 0.25, -0.25], [0.75, 1.25, 0.25]])
    assert board.tree(depth=1).splitlines()[0].startswith("board")
    assert board.tree_data()["word"] == "board"
    assert board.params == {"width": "2"}
    with pytest.raises(sl.SceneError):
        board.bounds_of("knight")


def test_flatten_gives_arrays(board: sl.Scene) -> None:
    found = board.flatten()
    assert len(found) == 3
    assert repr(found) == "<Primitives: 3 of 2 words>"
    assert found.matrix.shape == (3, 4, 4)
    assert found.color.shape == (3, 3)
    pegs = found[found.word == "cylinder"]
    assert sorted(pegs.matrix[:, 0, 3]) == [-0.5, 0.5]
    assert set(pegs.shape) == {"cylinder"}
    assert set(pegs.path) == {("board", "peg")}
    assert pegs.attribute("radius").tolist() == [0.25, 0.25]
    assert pegs.color.tolist() == [[1, 0, 0]] * 2
    assert all(re.fullmatch(r"<z\d+>", handle) for handle in found.handle)
    assert len(set(found.handle)) == 3


def test_a_rendered_picture_shows_the_scene(board: sl.Scene, tmp_path: Path) -> None:
    image = board.render(sl.Camera(azimuth=0, elevation=10), size=(96, 64))
    assert image.pixels.shape == (64, 96, 4)
    assert image.pixels.dtype == np.uint8
    assert image.size == (96, 64)
    assert (image.pixels[:, :, 3] == 255).all()
    red = (image.pixels[:, :, 0].astype(int) - image.pixels[:, :, 2] > 60).sum()
    assert red > 100
    from PIL import Image

    with Image.open(image.save(tmp_path / "a.png")) as saved:
        np.testing.assert_array_equal(np.asarray(saved.convert("RGB")), image.pixels[:, :, :3])
    assert np.asarray(image).shape == (64, 96, 4)
    assert image._repr_png_().startswith(b"\x89PNG")


def test_a_camera_pose_is_the_same_camera_in_both_conventions() -> None:
    pose = np.eye(4)
    pose[:3, 3] = 1.0, 2.0, 8.0
    opengl = sl.Camera.from_pose(pose, fov=40, size=(160, 120))
    opencv = sl.Camera.from_pose(pose @ np.diag([1.0, -1, -1, 1]), fov=40, size=(160, 120), convention="opencv")
    np.testing.assert_allclose(opengl.world_to_camera, opencv.world_to_camera)
    np.testing.assert_allclose(opengl.eye, [1, 2, 8])
    pixels, depth = opengl.project(np.array([[1.0, 2, 0], [1, 3, 0]]))
    np.testing.assert_allclose(pixels[0], [80, 60])
    assert pixels[1, 1] < 60, "up in the world is up in the picture"
    assert depth.tolist() == [8, 8]
    for wrong in (np.eye(3), 2 * np.eye(4), np.diag([1.0, 1, -1, 1])):
        with pytest.raises(sl.SceneError, match="pose"):
            sl.Camera.from_pose(wrong)


def test_maps_label_every_pixel(board: sl.Scene, tmp_path: Path) -> None:
    pose = np.eye(4)
    pose[:3, 3] = 0.0, 0.5, 6.0
    maps = board.maps(sl.Camera.from_pose(pose), size=(96, 64))
    assert maps["depth"].shape == (64, 96)
    assert maps["normal"].shape == (64, 96, 3)
    assert maps["depth"].min() == pytest.approx(5.5, abs=1e-6)
    pegs, boards = maps.mask("peg"), maps.mask("board")
    assert 0 < pegs.sum() < boards.sum()
    assert not (pegs & ~boards).any()
    assert set(np.unique(maps["semantic"])) - {0} <= set(maps.words)
    np.testing.assert_array_equal(maps["semantic"][pegs], {w: n for n, w in maps.words.items()}["cylinder"])
    assert len(maps.crops("peg")) == 2
    for crop in maps.crops("peg"):
        center = crop.pixels[crop.size[1] // 2, crop.size[0] // 2].astype(int)
        assert center[0] - center[2] > 60
    coco = maps.coco()
    assert [c["name"] for c in coco["categories"]] == board.words
    folder = maps.save(tmp_path / "maps")
    assert np.load(folder / "maps.npz")["depth"].shape == (64, 96)


def test_variants(board: sl.Scene) -> None:
    wide = board.with_params({"width": 4})
    assert wide.extents is not None
    assert wide.extents[0] == 4
    blue = board.restyled("peg", color=(0, 0, 1))
    changes = sl.diff(board, blue)
    assert not changes.equal
    assert changes.counts == {"recolored": 2}
    assert repr(changes) == "<Changes: 2 recolored; 1 primitives match>"
    assert repr(sl.diff(board, board)) == "<Changes: none, 3 primitives match>"
    assert set(map(tuple, board.flatten().color)) == {(1, 1, 1), (1, 0, 0)}, "the first scene stays what it was"
    assert board.restyled("peg", color="tomato").flatten().color[-1][0] == 1.0
    with pytest.raises(sl.SceneError, match="no entity"):
        board.restyled("knight", color="red")
    with pytest.raises(sl.SceneError):
        board.with_params({"hight": 2})


def test_four_dimensional_scenes(tmp_path: Path) -> None:
    scene = sl.evaluate(SPIN)
    assert scene.animated
    assert len(scene.frames) == 3
    assert scene.flatten(2).matrix[0, 0, 3] == 2
    assert scene.frame(1).flatten().matrix[0, 0, 3] == 1
    handles = primitive_handles(scene.graph, flatten(scene.graph))
    assert [[f"<{h}>" for h in frame] for frame in handles] == [list(scene.flatten(n).handle) for n in range(3)]
    film = scene.film(size=(32, 24))
    assert len(film) == 3
    assert repr(film) == "<Film of 3 pictures>"
    assert [image.size for image in film] == [(32, 24)] * 3
    assert film.save(tmp_path / "a.gif").stat().st_size > 100
    with pytest.raises(sl.SceneError, match="frame 3 does not exist"):
        scene.render(frame=3)


def test_export_writes_by_the_ending_and_json_reads_back(board: sl.Scene, tmp_path: Path) -> None:
    assert board.export(tmp_path / "a.glb") == [tmp_path / "a.glb"]
    board.export(tmp_path / "a.json")
    assert sl.diff(board, sl.load(tmp_path / "a.json")).equal
    assert board.to_json()["format"]
    with pytest.raises(sl.SceneError, match="does not write"):
        board.export(tmp_path / "a.doc")


def test_progress_may_cancel_and_leaves_no_file(board: sl.Scene, tmp_path: Path) -> None:
    class Cancelled(Exception):
        pass

    def stop(fraction: float) -> None:
        raise Cancelled

    seen: list[float] = []
    board.render(size=(32, 32), progress=seen.append)
    assert seen
    assert seen[-1] == 1.0
    assert seen == sorted(seen)
    with pytest.raises(Cancelled):
        board.render(size=(32, 32), progress=stop)
    with pytest.raises(Cancelled):
        board.film(frames=2, size=(16, 16)).save(tmp_path / "a.gif", progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_errors_show_the_place_and_a_hint() -> None:
    with pytest.raises(sl.SceneError) as caught:
        sl.evaluate('(bind "a"\n  (lambda () (cal "cube")))', "a.scene")
    text = str(caught.value)
    assert "E301" in text
    assert "a.scene:2:" in text
    assert '(cal "cube")' in text
    assert "call" in text.split("cal", 2)[2]
    with pytest.raises(sl.SceneError, match=r"nowhere\.scene"):
        sl.load("nowhere.scene")


def test_plain_values_become_params() -> None:
    text = '(param p 0) (bind "a" (lambda () (print p) (call "cube")))'
    for value, shown in ((3, "3"), (2.5, "2.5"), (True, "#t"), ("oak", "oak"), (np.array([1.0, 2.0]), "[1.0 2.0]")):
        assert sl.evaluate(text, defines={"p": value}).log == (shown,)
    with pytest.raises(sl.SceneError, match="dict"):
        sl.evaluate(text, defines={"p": {}})


def test_embeddings_beside_the_program_are_used(tmp_path: Path) -> None:
    from scenelang.files import beside
    from scenelang.files.zfile import set_entry
    from scenelang.interpreter.values.values import Vector

    program = tmp_path / "a.scene"
    program.write_text('(bind "a" (lambda () (call "cube" <z9>)))', "utf-8")
    set_entry(beside(str(program)), "z9", None, {"color": Vector([0.0, 0.0, 1.0])})
    assert sl.load(program).flatten().color.tolist() == [[0, 0, 1]]
    assert sl.load(program, embeddings=None).flatten().color.tolist() == [[1, 1, 1]]


def test_scenes_and_evaluations_are_safe_in_threads(board: sl.Scene) -> None:
    def work(number: int) -> tuple[Any, ...]:
        scene = sl.evaluate(TEXT, root="board", seed=number, defines={"width": number + 1})
        shared = board.flatten().matrix.sum(), board.render(size=(24, 24)).pixels.sum()
        assert scene.extents is not None
        return scene.extents[0], *shared

    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(work, range(24)))
    assert [width for width, *_ in found] == [max(1.5, n + 1) for n in range(24)]
    assert len({tuple(rest) for _, *rest in found}) == 1


def test_a_film_knows_its_scene(board: sl.Scene) -> None:
    film = board.film(frames=2, size=(8, 8))
    assert film.scene is board
    assert [picture.size for picture in film] == [(8, 8), (8, 8)]


def test_warnings_of_a_session_are_those_of_the_language_or_of_python() -> None:
    session = sl.Session()
    program = session.check(sl.Source("<text>", '(define unused 1) (bind "a" (lambda () (call "cube")))')).program
    assert program is not None
    assert [d.name for d in session.warnings(program)] == ["unused"]
    assert session.warnings(program, is_written=False) == []


SIGNATURES = ROOT / "tests" / "api" / "signatures.txt"


def signatures() -> str:
    """Every public name with its signature, and the public members of classes."""
    lines = []
    for name in sorted(sl.__all__):
        value = getattr(sl, name)
        if not callable(value):
            lines.append(f"{name} = {value}")
        elif not inspect.isclass(value):
            lines.append(f"{name}{inspect.signature(value)}")
        else:
            lines += [f"class {name}", *members(value)]
    return "\n".join(lines) + "\n"


def members(kind: type) -> list[str]:
    """The public members of a class, with those that it inherits from classes of ours."""
    lines = []
    ours = [base for base in kind.__mro__ if base.__module__.startswith("scenelang.")]
    inherited = {member: found for base in reversed(ours) for member, found in vars(base).items()}
    for member, found in sorted(inherited.items()):
        if member.startswith("_"):
            continue
        if isinstance(found, (staticmethod, classmethod)):
            found = getattr(kind, member)  # without the class
        shown = str(inspect.signature(found)) if inspect.isfunction(found) or inspect.ismethod(found) else ""
        lines.append(f"    {member}{shown}")
    return lines


def test_public_signatures_are_pinned() -> None:
    """A change of a public signature is made on purpose: write the new text into the file with the change."""
    assert signatures() == SIGNATURES.read_text("utf-8")


USED = {  # a call, and the module without which it is an error
    "render": (lambda scene: scene.render(), "backends.pictures.images"),
    "maps": (lambda scene: scene.maps(), "backends.labels.maps"),
    "html": (lambda scene: scene.html(), "backends.viewer.packet"),
    "save_graph": (lambda scene: scene.save_graph("a.svg"), "backends.pictures.call_graph"),
    "relations": (lambda scene: scene.relations(), "backends.geometry.arrangement"),
    "violations": (lambda scene: scene.violations('(count "pair" 1)'), "backends.geometry.relations"),
    "physics": (lambda scene: scene.physics(), "backends.physics.verdicts"),
    "repair": (lambda scene: sl.repair(ROW), "repairs.repairing"),
    "imagine": (lambda scene: sl.imagine(scene), "learning.neural"),
}


@pytest.mark.parametrize("name", USED)
def test_a_part_that_the_installation_lacks_is_an_error(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    call, module = USED[name]
    scene = sl.evaluate(ROW)
    monkeypatch.setitem(sys.modules, f"scenelang.{module}", None)
    with pytest.raises(sl.SceneError, match=rf"this installation lacks the part .*\(`scenelang\.{module}`\)") as caught:
        call(scene)
    assert caught.value.diagnostic.code == "E705"
    assert name != "render" or scene._repr_png_() is None


def test_all_names_can_be_imported_with_a_star() -> None:
    names: dict[str, Any] = {}
    exec("from scenelang import *", names)
    assert set(names) - {"__builtins__"} == set(sl.__all__) == set(sl._HOMES)


@pytest.mark.parametrize(
    "call", [lambda: sl.imagine("x"), lambda: sl.evaluate(ROW).diff("x"), lambda: sl.Embeddings.of("x")]
)
def test_errors_name_the_public_class_of_a_scene(call: Any) -> None:
    with pytest.raises(sl.SceneError, match="expected a Scene, got 'x'"):
        call()


def test_docstring_examples_run(monkeypatch: pytest.MonkeyPatch) -> None:
    import doctest

    import scenelang.api
    import scenelang.inference.generation
    import scenelang.scene
    import scenelang.session.loaded

    monkeypatch.chdir(ROOT)
    for module in (sl, scenelang.api, scenelang.scene, scenelang.session.loaded, scenelang.inference.generation):
        result = doctest.testmod(module, verbose=False)
        assert result.failed == 0
        assert module is sl or result.attempted > 0


def test_a_large_stack_needs_no_thread() -> None:
    """With `ulimit -s unlimited`, programs are evaluated in the main thread, deep ones too."""
    resource = pytest.importorskip("resource")
    if resource.getrlimit(resource.RLIMIT_STACK)[1] != resource.RLIM_INFINITY:
        pytest.skip("the stack of a process is limited here")
    program = """
import threading
import scenelang as sl
threading.Thread.start = None
deep = "(define (count n) (if (= n 0) 0 (+ 1 (count (- n 1)))))"
print(sl.evaluate(deep + '(bind "a" (lambda () (call "cube" :scale (count 60000))))').bounds[1][0])
try:
    sl.evaluate('(define (f n) (+ 1 (f n))) (bind "a" (lambda () (call "cube" :scale (f 1))))')
except sl.SceneError as error:
    print(error.diagnostic.code)
"""
    unlimited = lambda: resource.setrlimit(resource.RLIMIT_STACK, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, preexec_fn=unlimited, check=True)
    assert done.stdout.split() == ["30000.0", "E502"]
