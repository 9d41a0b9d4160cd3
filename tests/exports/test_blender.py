"""GLB and USD files in Blender have the bounds and colours of the scene. Needs `make test-blender`."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sampling import one_in

from exports.oracle import example, expected
from scenelang.backends.base import BackendOptions
from scenelang.backends.exports.gltf import GLTF
from scenelang.backends.exports.plan import surface_of
from scenelang.backends.exports.usd import USD
from scenelang.grammar.datum import Source
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.primitives.mesh import volume_of
from scenelang.session.session import Session

HERE = Path(__file__).parent
PYTHON = Path(os.environ.get("SCENELANG_BLENDER", HERE.parent.parent / ".venv" / "blender" / "bin" / "python"))

pytestmark = pytest.mark.skipif(not PYTHON.exists(), reason="Blender's module is not installed: `make test-blender`")


def imported(frame: int, *files: Path) -> list[dict[str, Any]]:
    command = [str(PYTHON), str(HERE / "blender_bounds.py"), str(frame), *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    lines = [line for line in done.stdout.splitlines() if line.startswith("RESULT ")]
    assert lines, done.stdout[-2000:] + done.stderr[-2000:]
    found: list[dict[str, Any]] = json.loads(lines[0].removeprefix("RESULT "))
    return found


@pytest.mark.parametrize(
    ("name", "frame", "defines"),
    one_in(
        6,
        [
            ("orrery.scene", 11, {}),
            ("chessboard.scene", 0, {}),
            ("jenga.scene", 0, {}),
            ("nesting-dolls.scene", 0, {}),
            ("orrery.scene", 0, {}),
            ("menger-sponge.scene", 0, {"level": 2}),
        ],
    ),
)
def test_bounds_in_blender(name: str, frame: int, defines: dict[str, Any], tmp_path: Path) -> None:
    scene = example(name, **defines)
    GLTF.run(scene, tmp_path / "a.glb", BackendOptions())
    USD.run(scene, tmp_path / "a.usdc", BackendOptions())
    wanted = entity_box(scene.frames[frame])
    assert wanted is not None
    size = max(high - low for low, high in zip(wanted[:3], wanted[3:], strict=True))
    # Blender makes polygons of USD's exact cylinders and spheres, of as few as ten sides
    near = (0.003, 0.03)
    for found, share in zip(imported(frame, tmp_path / "a.glb", tmp_path / "a.usdc"), near, strict=True):
        assert found["meshes"] == len(list(expected(scene, frame)))
        assert found["box"] == pytest.approx(wanted, abs=share * size)


@pytest.mark.parametrize("name", one_in(4, ["materials.scene", "jenga.scene", "chessboard.scene", "orrery.scene"]))
def test_colours_in_blender(name: str, tmp_path: Path) -> None:
    """Every mesh of a USD file has a material, in the colour that the scene says."""
    scene = example(name)
    USD.run(scene, tmp_path / "a.usdc", BackendOptions())
    (found,) = imported(0, tmp_path / "a.usdc")
    wanted = list(expected(scene, 0))
    assert found["meshes"] == len(wanted)
    assert None not in found["colors"]
    assert sorted(np.round(found["colors"], 4).tolist()) == sorted(np.round([one.color for one in wanted], 4).tolist())


SOLIDS = """
(bind "plate" (lambda () (call "cube" :scale [3 .4 2] :color [.1 .3 .8])))
(bind "hole" (lambda () (call "cylinder" :radius .3 :p0 [0 -1 0] :p1 [0 1 0] :color [.8 .4 .05])))
(bind "part" (lambda () (difference (call "plate") (call "hole"))))
(bind "bar" (lambda () (extrude (star 5 1 .5) .7 :color [.2 .6 .2])))
(bind "both" (lambda () (solid-union (call "cube" :color [.7 .1 .1]) (call "sphere" :radius .6 :color [.7 .1 .1]))))
(bind "name" (lambda () (text "Ab" :color [.9 .9 .2])))
(bind "peg" (lambda () (call "cone" :radius .5 :p1 [0 1.3 0] :color [.4 .2 .6])))
(bind "scene" (lambda () (union
  (call "part")
  (transform (call "bar") (translate [5 0 0]))
  (transform (call "both") (translate [0 5 0]))
  (transform (call "name") (translate [0 0 5]))
  (transform (call "part") (@ (translate [9 0 0]) (reflect [1 2 0])))
  (transform (call "bar") (@ (translate [0 9 0]) (@ (scale [1 2 1]) (rotate .5 [0 0 1]))))
  (for/union ((i '(0 1 2 3))) (transform (call "peg") (@ (translate (vector (* 2 i) -5 0)) (rotate i [1 1 0]))))
  (for/union ((i '(0 1 2))) (transform (call "part") (@ (translate (vector (* 4 i) -9 0)) (scale [1 2 .5])))))))
"""


@pytest.mark.parametrize("instancing", [0, 2])
def test_solids_have_their_volumes_and_colours(instancing: int, tmp_path: Path) -> None:
    """Every solid and primitive, also mirrored, sheared and as an instance, in USD and GLB."""
    scene = Session().evaluate(Source("<test>", SOLIDS)).scene
    assert scene is not None
    given = BackendOptions(settings={"instancing": instancing})
    GLTF.run(scene, tmp_path / "a.glb", given)
    USD.run(scene, tmp_path / "a.usdc", given)
    wanted = sorted(map(_solid, expected(scene)), key=lambda row: row[0])
    for found in imported(0, tmp_path / "a.glb", tmp_path / "a.usdc"):
        rows = sorted(((one["volume"], one["colors"]) for one in found["solids"]), key=lambda row: row[0])
        assert len(rows) == len(wanted)
        for (volume, colors), (true, own) in zip(rows, wanted, strict=True):
            assert volume == pytest.approx(true, rel=0.01)
            # Blender keeps the vertex colours of glTF in 8 bits of sRGB
            assert np.array(sorted(colors)) == pytest.approx(np.array(sorted(own)), abs=4e-3)


def _solid(one: Any) -> tuple[float, list[list[float]]]:
    """The volume and the distinct colours of a primitive."""
    surface = surface_of(one.entity)
    assert surface is not None
    colors = np.array([one.color]) if surface.colors is None else surface.colors * np.array(one.color)
    return abs(volume_of(one.vertices[surface.faces])), np.unique(np.round(colors, 3), axis=0).tolist()
