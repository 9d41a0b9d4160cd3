"""GLB files, read back by trimesh and by hand."""

from __future__ import annotations

import json
import os
import struct
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenelang.backends.base import Options
from scenelang.backends.glb import export, node_poses
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter import pose
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Entity, Scene, count_words
from scenelang.interpreter.values import Embedding, Matrix, Pair


def document_of(path: Path) -> dict[str, Any]:
    data = path.read_bytes()
    magic, version, total, length, kind = struct.unpack_from("<4sIIII", data)
    assert (magic, version, total, kind) == (b"glTF", 2, len(data), 0x4E4F534A)
    return json.loads(data[20 : 20 + length])


def matrix_of(node: dict[str, Any]) -> np.ndarray:
    import trimesh

    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    out = trimesh.transformations.quaternion_matrix((w, x, y, z)) @ np.diag([*node.get("scale", (1, 1, 1)), 1])
    out[:3, 3] = node.get("translation", (0, 0, 0))
    return out


@pytest.fixture(scope="module")
def temple(make: Any) -> Scene:
    column = make.group(
        "column",
        make.primitive("cylinder", radius=0.3, p1=(0, 3, 0)),
        (make.primitive("cube", scale=(1, 0.2, 1), color=(0.9, 0.8, 0.7)), pose.translation(0, 3.1, 0)),
        (make.primitive("cone", radius=0.4), pose.translation(0, 3.2, 0)),
    )
    shear = Matrix((1, 0.5, 0, 9, 0, 1, 0, 0, 0, 0.2, 1, 1))
    mirror = pose.reflection((0, 0, 5), (0.2, 0, 1))
    parts = [(column, pose.translation(2 * i, 0, 0)) for i in range(3)]
    return make.scene(*parts, (column, shear), (column, mirror), (make.primitive("sphere"), make.chain(shear, mirror)))


def test_bounds_and_words_survive(temple: Scene, tmp_path: Path) -> None:
    import trimesh

    path = tmp_path / "temple.glb"
    export(temple, path)
    loaded = trimesh.load(path)
    assert loaded.bounds.reshape(-1) == pytest.approx(entity_box(temple.root), abs=0.01)
    document = document_of(path)
    words = Counter(node["extras"]["word"] for node in document["nodes"] if "extras" in node)
    assert words == count_words(temple.root)
    names = Counter(node["name"] for node in document["nodes"])
    assert names["column"] == 5
    assert len(document["meshes"]) == 4  # shared by all columns
    assert os.listdir(tmp_path) == ["temple.glb"]


def test_the_hierarchy_is_kept(temple: Scene, tmp_path: Path) -> None:
    export(temple, tmp_path / "a.glb")
    nodes = document_of(tmp_path / "a.glb")["nodes"]
    children = [child for node in nodes for child in node.get("children", ())]
    assert sorted(children) == list(range(1, len(nodes)))  # a tree whose root is node 0
    column = nodes[nodes[0]["children"][0]]
    assert column["name"] == "column"
    assert [nodes[child]["name"] for child in column["children"]] == ["cylinder", "cube", "cone"]


@pytest.mark.parametrize("seed", range(12))
def test_any_affine_pose_is_one_or_two_nodes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    linear = rng.normal(size=(3, 3))
    if seed % 4 == 1:
        linear[:, 0] = 0.0
    if seed % 4 == 2:
        linear = np.linalg.qr(linear)[0] * rng.normal(size=3)
    given = np.concatenate([linear, rng.normal(size=(3, 1))], axis=1)
    nodes = node_poses(given.ravel().tolist())
    product = matrix_of(nodes[0]) if len(nodes) == 1 else matrix_of(nodes[0]) @ matrix_of(nodes[1])
    assert product[:3] == pytest.approx(given, abs=1e-9)
    assert len(nodes) == (1 if seed % 4 == 2 else 2)


def test_meshes_are_solid_and_keep_their_volume(make: Any, tmp_path: Path) -> None:
    import trimesh

    volumes = {"cube": 1, "sphere": 4 / 3 * np.pi, "cylinder": np.pi, "cone": np.pi / 3}
    for word, volume in volumes.items():
        path = tmp_path / f"{word}.glb"
        export(make.scene((make.primitive(word), pose.reflection((0, 0, 0), (1, 2, 3)))), path)
        mesh = trimesh.load(path, force="mesh")
        mesh.merge_vertices(merge_norm=True)
        assert mesh.is_watertight, word
        assert abs(mesh.volume) == pytest.approx(volume, rel=0.01)


def test_materials(make: Any, tmp_path: Path) -> None:
    glass = make.primitive("cube", color=(0.1, 0.2, 0.3), opacity=0.25)
    lamp = make.primitive("sphere", color=(1, 0.5, 0), emission=4)
    export(make.scene(glass, lamp), tmp_path / "a.glb")
    first, second = document_of(tmp_path / "a.glb")["materials"]
    assert first["pbrMetallicRoughness"]["baseColorFactor"] == [0.1, 0.2, 0.3, 0.25]
    assert first["alphaMode"] == "BLEND"
    assert second["emissiveFactor"] == [1.0, 0.5, 0.0]
    assert second["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] == 4


def test_handles_and_texts_are_kept(make: Any, tmp_path: Path) -> None:
    cube = make.primitive("cube")
    root = Entity("scene", Embedding("z1", "a red one"), (Pair(cube, pose.translation(1, 2, 3)),))
    export(Scene("scene", [root], False), tmp_path / "a.glb")
    assert document_of(tmp_path / "a.glb")["nodes"][0]["extras"] == {
        "word": "scene",
        "handle": "z1",
        "text": "a red one",
    }


def test_a_deep_scene_needs_no_recursion(make: Any, tmp_path: Path) -> None:
    entity = make.primitive("cube")
    for _ in range(5000):
        entity = make.group("nest", (entity, pose.translation(0, 1, 0)))
    export(Scene("nest", [entity], False), tmp_path / "a.glb")
    assert len(document_of(tmp_path / "a.glb")["nodes"]) == 5001


def test_errors(make: Any, tmp_path: Path) -> None:
    cube = make.primitive("cube")
    with pytest.raises(SceneError) as caught:
        export(make.scene(), tmp_path / "a.glb")
    assert caught.value.name == "empty-scene"
    entity = cube
    for _ in range(7):
        entity = make.group("many", *[entity] * 10)
    with pytest.raises(LimitError):
        export(Scene("many", [entity], False), tmp_path / "a.glb")
    with pytest.raises(SceneError, match="no frame"):
        export(make.scene(cube), tmp_path / "a.glb", Options(frame=1))
    assert os.listdir(tmp_path) == []


def test_nothing_but_a_line_is_still_a_file(make: Any, tmp_path: Path) -> None:
    export(make.scene(make.primitive("cylinder", p1=(0, 0, 0))), tmp_path / "a.glb")
    assert "meshes" not in document_of(tmp_path / "a.glb")


def test_an_asset_keeps_its_mesh(make: Any, tmp_path: Path) -> None:
    import trimesh

    from scenelang.interpreter.shapes import shape_of

    trimesh.creation.box((1, 2, 3)).export(tmp_path / "box.ply")
    given = {"file": str(tmp_path / "box.ply")}
    asset = Entity("asset", Embedding(attributes=given), (), shape_of("asset", given, (-0.5, -1, -1.5, 0.5, 1, 1.5)))
    export(make.scene((asset, pose.translation(1, 1, 1))), tmp_path / "a.glb")
    assert trimesh.load(tmp_path / "a.glb").bounds.reshape(-1) == pytest.approx([0.5, 0, -0.5, 1.5, 2, 2.5])
