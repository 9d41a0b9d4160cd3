"""glTF files pass the Khronos validator, where node is there and `make test` could install it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from sampling import one_in

from exports.oracle import EXAMPLES, example
from scenelang.backends.base import BackendOptions
from scenelang.backends.exports.gltf import GLTF
from scenelang.interpreter.values.values import Matrix

HERE = Path(__file__).parent
FOLDER = Path(os.environ.get("SCENELANG_GLTF_VALIDATOR", HERE.parent.parent / ".venv" / "gltf-validator"))
NODE = shutil.which("node")
LARGE = {"fractal-tree.scene", "menger-sponge.scene", "chessboard.scene", "toys.scene"}  # as all others, for seconds
ALL = sorted({path.name for path in EXAMPLES.glob("*.scene")} - LARGE)

pytestmark = pytest.mark.skipif(
    NODE is None or not (FOLDER / "node_modules" / "gltf-validator").is_dir(),
    reason="the Khronos validator is not installed: it needs node and npm, and `make test`",
)


def validated(*files: Path) -> list[dict[str, Any]]:
    command = [str(NODE), str(HERE / "validate.mjs"), str(FOLDER), *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    found: list[dict[str, Any]] = json.loads(done.stdout)
    assert len(found) == len(files)
    return found


@pytest.mark.parametrize("part", one_in(3, range(3)))
def test_examples_have_no_errors(part: int, tmp_path: Path) -> None:
    jobs: list[tuple[str, str, dict[str, Any]]] = [(name, ".glb", {}) for name in ALL[part::3]]
    for name in ("orrery.scene", "jenga.scene")[part : part + 1]:
        jobs += [(name, ".gltf", {}), (name, "-1.glb", {"depth": 1}), (name, "-2.glb", {"instance-limit": 50})]
    files = []
    for name, ending, settings in jobs:
        files.append(tmp_path / f"{Path(name).stem} é{ending}")
        GLTF.run(example(name), files[-1], BackendOptions(settings=settings))
    assert [one for one in validated(*files) if one["errors"] or one["warnings"]] == []


def test_odd_scenes_have_no_errors(make: Any, tmp_path: Path) -> None:
    flat = Matrix((1, 0, 0, 0, 0, 0, 0, 2, 0, 0, 1, 0))
    words = ("cube", "sphere", "cylinder", "cone")
    looks = [make.primitive(word, roughness=0.3, metallic=0.5, opacity=0.5, emission=7, ior=1.4) for word in words]
    things = [make.primitive(word) for word in words]
    line = make.primitive("cylinder", p1=(0, 0, 0))
    floor = make.primitive("cube", scale=(1, 0, 1))
    scenes = [
        make.odd(),
        make.scene(line),
        make.scene(
            floor, *looks, *[(thing, flat) for thing in things], *[(thing, Matrix((0,) * 12)) for thing in things]
        ),
    ]
    files = []
    for number, scene in enumerate(scenes):
        for depth in (None, 0):
            files.append(tmp_path / f"{number}-{depth}.glb")
            GLTF.run(scene, files[-1], BackendOptions(settings={"depth": depth}))
    assert [one for one in validated(*files) if one["errors"]] == []


@pytest.mark.parametrize("name", one_in(2, ["chessboard.scene", "making/bracket.scene"]))
def test_instances_have_no_errors(name: str, make: Any, tmp_path: Path) -> None:
    """The validator does not know the extension and says so; it checks all accessors."""
    mirrored, sheared = Matrix((-1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0)), Matrix((1, 1, 0, 9, 0, 1, 0, 0, 0, 0, 1, 0))
    turned = Matrix((0, 0, 2, 3, 0, 2, 0, 0, -2, 0, 0, 0))
    parts = [(make.primitive("cone"), place) for place in (mirrored, sheared, turned, turned)]
    files = [tmp_path / "a.glb", tmp_path / "b.gltf"]
    for scene, file in zip((example(name), make.scene(*parts)), files, strict=True):
        GLTF.run(scene, file, BackendOptions(settings={"instancing": 2}))
    known = {"UNSUPPORTED_EXTENSION", "UNUSED_OBJECT"}
    for one in validated(*files):
        assert (one["errors"], one["warnings"]) == (0, 0), one
        assert {message["code"] for message in one["messages"]} <= known


def test_the_validator_finds_errors(make: Any, tmp_path: Path) -> None:
    path = tmp_path / "a.gltf"
    GLTF.run(make.scene(make.primitive("cube")), path, BackendOptions())
    path.write_text(path.read_text().replace('"VEC3"', '"VEC4"', 1))
    assert validated(path)[0]["errors"] > 0
