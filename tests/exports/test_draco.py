"""GLB files whose meshes are compressed: decoded by DracoPy they are those of files that are not, to 16 bits."""

from __future__ import annotations

import importlib
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from exports.gltf_reader import Gltf
from exports.oracle import example
from exports.test_khronos import pytestmark as needs_validator
from exports.test_khronos import validated
from scenelang.backends.base import BackendOptions
from scenelang.backends.exports.gltf import DRACO, GLTF
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene

NAMES = ["jenga.scene", "making/mug.scene", "making/terrain.scene"]


def pair(scene: Scene, folder: Path, **settings: Any) -> tuple[Gltf, Gltf]:
    """A file of a scene without and with compression."""
    for draco in (False, True):
        GLTF.run(scene, folder / f"{draco}.glb", BackendOptions(settings=settings | {"draco": draco}))
    return Gltf(folder / "False.glb"), Gltf(folder / "True.glb")


def decoded(document: Gltf, primitive: dict[str, Any]) -> dict[str, np.ndarray]:
    """The columns and the faces of a compressed mesh."""
    extension = primitive["extensions"][DRACO]
    view = document.document["bufferViews"][extension["bufferView"]]
    data = document.buffer[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    mesh = importlib.import_module("DracoPy").decode(data)
    columns = {
        name: next(one["data"] for one in mesh.attributes if one["unique_id"] == number)
        for name, number in extension["attributes"].items()
    }
    for name, column in columns.items():
        accessor = document.document["accessors"][primitive["attributes"][name]]
        assert (accessor["count"], "bufferView" in accessor) == (len(column), False)
        assert accessor["min"] == column.min(axis=0).tolist()
    assert document.document["accessors"][primitive["indices"]]["count"] == mesh.faces.size
    return columns | {"faces": mesh.faces}


@pytest.mark.parametrize(
    ("name", "settings"),
    [*product(NAMES, [{}, {"depth": 1}, {"solid": True}]), ("still-life.scene", {})],
)
def test_meshes_are_the_same_to_16_bits(name: str, settings: dict[str, Any], tmp_path: Path) -> None:
    pytest.importorskip("DracoPy", reason="DracoPy is not installed")
    plain, small = pair(example(name), tmp_path, **settings)
    assert small.document["extensionsRequired"] == [DRACO]
    assert plain.nodes == small.nodes
    for one, other in zip(plain.document["meshes"], small.document["meshes"], strict=True):
        for a, b in zip(one["primitives"], other["primitives"], strict=True):
            wanted = {key: plain.array(number) for key, number in a["attributes"].items()}
            faces, read = plain.array(a["indices"]).reshape(-1, 3), decoded(small, b)
            assert set(wanted) | {"faces"} == set(read)
            assert len(read["faces"]) == len(faces)
            for key, column in wanted.items():
                size = 2.0 if key == "NORMAL" else max(float(np.ptp(column, axis=0).max()), 1e-6)
                near = size / (2**10 if key == "NORMAL" else 2**16) * 2.0
                own = read[key] / 65535.0 if key == "COLOR_0" else read[key]
                got, due = (np.sort(c[f.ravel()], axis=0) for c, f in ((own, read["faces"]), (column, faces)))
                assert np.abs(got - due).max() < (1e-9 if key == "COLOR_0" else near), key
                numbers = (plain, a["attributes"][key]), (small, b["attributes"][key])
                assert len({each.document["accessors"][k]["componentType"] for each, k in numbers}) == 1


def test_files_are_smaller(tmp_path: Path) -> None:
    pytest.importorskip("DracoPy", reason="DracoPy is not installed")
    pair(example("making/mug.scene"), tmp_path)
    assert (tmp_path / "True.glb").stat().st_size * 10 < (tmp_path / "False.glb").stat().st_size


@pytest.mark.skipif(*needs_validator.args, **needs_validator.kwargs)
def test_the_validator_has_no_errors(tmp_path: Path) -> None:
    """It does not decode meshes, but checks what is said of them."""
    pytest.importorskip("DracoPy", reason="DracoPy is not installed")
    pair(example("still-life.scene"), tmp_path)
    (found,) = validated(tmp_path / "True.glb")
    assert (found["errors"], found["warnings"]) == (0, 0), found["messages"]


def test_what_to_install_is_said(monkeypatch: pytest.MonkeyPatch, make: Any, tmp_path: Path) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "DracoPy", None)
    with pytest.raises(SceneError) as caught:
        GLTF.run(make.scene(make.primitive("cube")), tmp_path / "a.glb", BackendOptions(settings={"draco": True}))
    assert caught.value.name == "backend"
    assert "scenelang[draco]" in str(caught.value.hint)
    assert not list(tmp_path.iterdir())
