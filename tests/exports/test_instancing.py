"""Copies as instances of one node: EXT_mesh_gpu_instancing in glTF, PointInstancer in USD; and sides of shared meshes."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from searching import many

from exports.gltf_reader import Gltf
from exports.oracle import example, expected, same_points, scenes
from exports.usd_reader import complaints, seen
from scenelang.backends.base import BackendOptions
from scenelang.backends.exports.gltf import GLTF
from scenelang.backends.exports.usd import INSTANCER_COPIES, USD
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.values.values import Embedding, Pair

EXTENSION = "EXT_mesh_gpu_instancing"
MIRRORED = pose.reflection((0, 0, 0), (1, 2, 0))
SHEARED = pose.compose(pose.scaling(1, 2, 1, (0, 0, 0)), pose.rotation(0.5, (0, 0, 1), (0, 0, 0)))


def glb(scene: Scene, path: Path, **given_: Any) -> Gltf:
    GLTF.run(scene, path, BackendOptions(settings=given_))
    return Gltf(path)


def stage_of(scene: Scene, path: Path, **given_: Any) -> Any:
    pxr = pytest.importorskip("pxr.Usd", reason="usd-core is not installed")
    USD.run(scene, path, BackendOptions(settings=given_))
    return pxr.Stage.Open(str(path))


def usd_rows(stage: Any) -> list[tuple[tuple[str, ...], np.ndarray, np.ndarray]]:
    return list(seen(stage))


def same_scene(got: Sequence[tuple[str, np.ndarray, np.ndarray]], scene: Scene) -> None:
    """``got`` has the last word, vertices and colors of each primitive, in any order."""
    wanted = list(expected(scene))
    assert Counter(word for word, _, _ in got) == Counter(one.path[-1] for one in wanted)
    points = [np.hstack([vertices, colors]) for _, vertices, colors in got]
    rows = [np.hstack([one.vertices, np.tile(one.color, (len(one.vertices), 1))]) for one in wanted]
    assert same_points(np.concatenate(points), np.concatenate(rows), 2e-5)


@settings(max_examples=many(40), deadline=None)
@given(scenes())
def test_glb_of_any_pose(scene: Scene) -> None:
    with tempfile.TemporaryDirectory() as folder:
        found = glb(scene, Path(folder) / "a.glb", instancing=2)
    same_scene([(one.extras["word"], one.vertices, one.colors) for one in found.seen()], scene)


@settings(max_examples=many(40), deadline=None)
@given(scenes())
def test_usd_of_any_pose(scene: Scene) -> None:
    pytest.importorskip("pxr", reason="usd-core is not installed")
    with tempfile.TemporaryDirectory() as folder:
        stage = stage_of(scene, Path(folder) / "a.usdc", instancing=2)
        rows = usd_rows(stage)
        assert complaints(stage) == []
    same_scene([(words[-1], vertices, colors) for words, vertices, colors in rows], scene)
    assert Counter(words for words, _, _ in rows) == Counter(one.path for one in expected(scene))


@settings(max_examples=many(15), deadline=None)
@given(scenes(frames=3))
def test_glb_of_any_animation(scene: Scene) -> None:
    with tempfile.TemporaryDirectory() as folder:
        found = glb(scene, Path(folder) / "a.glb", instancing=2, fps=1.0)
    for frame in range(3):
        points = np.concatenate([one.vertices for one in found.seen(float(frame))] or [np.zeros((0, 3))])
        wanted = np.concatenate([one.vertices for one in expected(scene, frame)] or [np.zeros((0, 3))])
        assert same_points(points, wanted, 2e-5)


@pytest.fixture
def bolts(make: Any) -> Scene:
    """Five bolts with a handle, one of them mirrored and one sheared, each of a cylinder and two cubes."""
    cube = make.primitive("cube", color=(1, 0.5, 0))
    parts = [Pair(make.primitive("cylinder"), pose.translation(0, -1, 0)), Pair(cube, pose.translation(0, 1, 0))]
    bolt = Entity("bolt", Embedding("z7", "a brass bolt"), (*parts, Pair(cube, pose.translation(0, 2, 0))))
    places = [pose.translation(3 * i, 0, 0) for i in range(3)]
    return make.scene(*((bolt, place) for place in (*places, MIRRORED, SHEARED)))


def test_copies_of_a_group_are_one_node_for_each_mesh(bolts: Scene, tmp_path: Path) -> None:
    found = glb(bolts, tmp_path / "a.glb", instancing=3)
    document = found.document
    assert document["extensionsUsed"] == document["extensionsRequired"] == [EXTENSION]
    group = next(node for node in found.nodes if node["name"] == "bolt")
    assert group["extras"] == {"word": "bolt", "handle": "z7", "text": "a brass bolt", "instances": 5}
    instanced = [node for node in found.nodes if EXTENSION in node.get("extensions", {})]
    assert [(node["name"], node["extras"]["instances"]) for node in instanced] == [("cylinder", 3), ("cube", 6)]
    cube = instanced[1]
    assert cube["extras"]["attributes"] == {"color": [1.0, 0.5, 0.0]}
    attributes = cube["extensions"][EXTENSION]["attributes"]
    assert set(attributes) == {"TRANSLATION", "SCALE", "_INSTANCE"}  # nothing is turned
    assert found.array(attributes["_INSTANCE"]).tolist() == [0, 1, 2, 3, 4, 5]  # two of each of the first three bolts
    ordinary = [node["name"] for node in found.nodes if "mesh" in node and node not in instanced]
    assert len(ordinary) == 6  # three of the mirrored bolt and three of the sheared one
    assert document["scenes"][0]["nodes"] == [0]


def test_few_copies_are_ordinary_nodes(bolts: Scene, tmp_path: Path) -> None:
    plain = glb(bolts, tmp_path / "a.glb")
    for least in (0, 6):
        assert glb(bolts, tmp_path / "b.glb", instancing=least).document == plain.document
    assert "extensionsRequired" not in plain.document


def test_instances_are_limited(bolts: Scene, tmp_path: Path) -> None:
    with pytest.raises(LimitError, match="15 instances"):
        GLTF.run(bolts, tmp_path / "a.glb", BackendOptions(limit=14, settings={"instancing": 2}))


def test_usd_instancers_have_what_shear_allows(bolts: Scene, tmp_path: Path) -> None:
    stage = stage_of(bolts, tmp_path / "a.usda", instancing=3)
    (made,) = [prim for prim in stage.Traverse() if prim.GetTypeName() == "PointInstancer"]
    assert list(made.GetAttribute("ids").Get()) == [0, 1, 2, 3]
    (prototype,) = made.GetChildren()
    assert prototype.GetAttribute("scenelang:word").Get() == "bolt"
    assert prototype.GetAttribute("scenelang:handle").Get() == "z7"
    turns = np.array([[*q.GetImaginary(), q.GetReal()] for q in made.GetAttribute("orientationsf").Get()])
    near = np.array([[*q.GetImaginary(), q.GetReal()] for q in made.GetAttribute("orientations").Get()])
    assert np.allclose(turns, near, atol=1e-3)
    low, high = np.array(made.GetAttribute("extent").Get())
    points = np.concatenate([one.vertices for one in list(expected(bolts))[:12]])
    assert (low <= points.min(axis=0) + 1e-5).all()
    assert (high >= points.max(axis=0) - 1e-5).all()


@pytest.mark.slow
def test_usd_instances_very_many_copies_by_default(make: Any, tmp_path: Path) -> None:
    cube = make.primitive("cube")
    places = [(cube, pose.translation(2 * i, 0, 0)) for i in range(INSTANCER_COPIES)]
    for scene, kinds in ((make.scene(*places), 1), (make.scene(*places[1:]), 0)):
        stage = stage_of(scene, tmp_path / f"{kinds}.usdc")
        assert sum(prim.GetTypeName() == "PointInstancer" for prim in stage.Traverse()) == kinds
    stage = stage_of(make.scene(*places), tmp_path / "never.usdc", instancing=0)
    assert not any(prim.GetTypeName() == "PointInstancer" for prim in stage.Traverse())


def test_what_is_invisible_has_no_instances(make: Any, tmp_path: Path) -> None:
    glass = make.primitive("cube", opacity=0.0)
    scene = make.scene((glass, pose.translation(1, 0, 0)), (glass, MIRRORED), make.primitive("sphere"))
    found = glb(scene, tmp_path / "a.glb", instancing=2)
    assert len(found.seen()) == 1
    assert EXTENSION not in found.document.get("extensionsUsed", ())


@pytest.mark.parametrize("instancing", [0, 2])
def test_segments_and_tolerance(instancing: int, make: Any, tmp_path: Path) -> None:
    small = make.primitive("sphere", radius=0.01)
    large = make.primitive("sphere", radius=10.0)
    group = make.group("pair", small, (small, pose.translation(3, 0, 0)))
    scene = make.scene(group, (group, pose.scaling(5, 5, 5, (0, 0, 0))), large, (large, pose.translation(30, 0, 0)))
    for given_, sides in (({"segments": 12}, (12, 12)), ({"tolerance": 0.01}, (12, 71)), ({}, (64, 64))):
        wanted = sorted(len(one.vertices) for n in sides for one in expected(scene, segments=n))
        for found in (
            [one.vertices for one in glb(scene, tmp_path / "a.glb", instancing=instancing, **given_).seen()],
            [
                vertices
                for _, vertices, _ in usd_rows(
                    stage_of(scene, tmp_path / f"{sides}.usdc", instancing=instancing, **given_)
                )
            ],
        ):
            if sides[0] == sides[1]:
                assert [len(vertices) for vertices in found] == [wanted[0]] * 6
            else:  # within the tolerance, and not far below it
                sizes = sorted(len(vertices) for vertices in found)
                assert sizes[3] < 0.1 * sizes[4]
            for vertices in found:
                middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
                assert np.allclose(np.linalg.norm(vertices - middle, axis=1).std(), 0.0, atol=0.02)


@pytest.mark.slow
def test_examples_keep_their_words(tmp_path: Path) -> None:
    scene = example("chessboard.scene")
    found = glb(scene, tmp_path / "a.glb", instancing=2)
    same_scene([(one.extras["word"], one.vertices, one.colors) for one in found.seen()], scene)
