"""Scripts and examples in Blender: imports and exports have its boxes and volumes. Needs `make test-blender`."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from scenelang.backends.base import BackendOptions
from scenelang.backends.blender.script import BPY
from scenelang.backends.exports.plan import surface_of
from scenelang.backends.surfaces.appearance import look_of
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count
from scenelang.session.session import Session

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
PYTHON = Path(os.environ.get("SCENELANG_BLENDER", ROOT / ".venv" / "blender" / "bin" / "python"))
FloatArray = npt.NDArray[np.float64]
Row = dict[str, Any]

pytestmark = pytest.mark.skipif(not PYTHON.exists(), reason="Blender's module is not installed: `make test-blender`")

# Of blocks, and files that are no scene of their own.
EXAMPLES = sorted(path for path in (ROOT / "examples").rglob("*.scene") if "minecraft" not in path.as_posix())
_MOST = 300  # objects of a script: more take Blender minutes


def measured(*scripts: Path) -> dict[str, list[Row]]:
    """The measures of the first frame of scripts in Blender, by file."""
    table = scripts[0].parent / "measures.json"
    command = [str(PYTHON), str(ROOT / "benchmarks" / "blender_reference.py"), str(table), *map(str, scripts), "--once"]
    subprocess.run(command, check=True, timeout=3600)
    found = json.loads(table.read_text())
    for name, result in found.items():
        assert "frames" in result["as is"], f"{name}: {result['as is']['error']}"
    return {name: next(iter(result["as is"]["frames"].values())) for name, result in found.items()}


def expected(entity: Entity, matrix: FloatArray) -> Iterator[tuple[str, Entity, FloatArray]]:
    """The primitives of a scene with the names of their objects, and their poses in Blender's axes."""
    shown = [(pair.car, matrix @ _rows(pair.cdr)) for pair in entity.children]
    shown = [(e, m) for e, m in shown if not e.is_primitive or _is_seen(e)]
    is_one = len(shown) == 1 and shown[0][0].is_primitive and np.allclose(shown[0][1], matrix)
    for part, pose in shown:
        if part.is_primitive:
            yield entity.word if is_one else part.word, part, pose
        else:
            yield from expected(part, pose)


def _is_seen(entity: Entity) -> bool:
    return entity.shape is not None and entity.shape.has_geometry and look_of(entity).opacity > 0


def _rows(pose: Any) -> FloatArray:
    made = np.eye(4)
    made[:3] = np.array(list(pose), np.float64)[:12].reshape(3, 4)
    return made


UP = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])


def differences(scene: Scene, rows: list[Row]) -> list[str]:
    """What differs between a scene and what its script builds in Blender."""
    by_name: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        name = row["name"]
        stem, _, end = name.rpartition(".")
        by_name[stem if end.isdigit() and len(end) >= 3 else name].append(row)
    found = []
    for name, entity, pose in expected(scene.frames[0], UP):
        surface = surface_of(entity, 256)
        if surface is None:
            continue
        points = surface.vertices @ pose[:3, :3].T + pose[:3, 3]
        a, b, c = np.moveaxis(points[surface.faces], 1, 0)
        center = points.mean(axis=0)
        volume = abs(float(np.einsum("ij,ij->", a - center, np.cross(b - center, c - center)) / 6))
        box = np.array([points.min(axis=0), points.max(axis=0)])
        extent = float(np.ptp(points, axis=0).max())
        near = [
            row
            for row in by_name[name[:63]]
            if np.abs(np.array([row["low"], row["high"]]) - box).max() <= 1e-3 * extent + 1e-5
        ]
        if not near:
            found.append(f"{name}: no box {box.round(4).tolist()}")
        elif not any(row["volume"] is not None and abs(row["volume"] - volume) <= 1e-3 * volume + 1e-9 for row in near):
            found.append(f"{name}: volume {volume:.6g}, not {[row['volume'] for row in near][:3]}")
    return found


def test_examples_as_scripts(tmp_path: Path) -> None:
    scenes: dict[str, Scene] = {}
    for path in EXAMPLES:
        session = Session()
        result = session.evaluate(session.source(str(path)))
        if result.scene is None or primitive_count(result.scene.frames[0]) > _MOST:
            continue
        with contextlib.suppress(LimitError):  # of vertices of a script
            BPY.run(result.scene, tmp_path / f"{path.stem}.py", BackendOptions(settings={"segments": 256}))
        if not (tmp_path / f"{path.stem}.py").exists():
            continue
        scenes[f"{path.stem}.py"] = result.scene
    assert len(scenes) > 20
    rows = measured(*(tmp_path / name for name in scenes))
    wrong = {name: differences(scene, rows[name])[:3] for name, scene in scenes.items()}
    assert {name: reasons for name, reasons in wrong.items() if reasons} == {}


def test_scripts_as_scenes() -> None:
    """The scripts of the goldens, which the ordinary suite compares with recorded measures."""
    command = [
        sys.executable,
        str(ROOT / "benchmarks" / "blender_scripts.py"),
        str(HERE / "scripts"),
        "--bpy",
        str(PYTHON),
    ]
    done = subprocess.run([*command, "--quiet"], capture_output=True, text=True, timeout=3600, check=True)
    assert set(done.stdout.split()) & {"different", "invalid", "refused"} == set(), done.stdout
