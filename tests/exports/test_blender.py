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
from scenelang.backends.exports.usd import USD
from scenelang.interpreter.scene.bounds import entity_box

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
