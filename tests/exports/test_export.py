"""What all exports share: parts, files that come together, blocks, assets, errors."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from searching import many
from support import evaluate

from exports.gltf_reader import Gltf
from exports.oracle import EXAMPLES, corners_of, example, expected, obj_corners, same_points, scenes
from exports.test_meshes import ply_rows
from exports.usd_reader import complaints
from exports.usd_reader import seen as usd_seen
from scenelang.backends import files
from scenelang.backends.base import Backend, BackendOptions
from scenelang.backends.exports import export
from scenelang.backends.exports.gltf import GLTF
from scenelang.backends.exports.mesh_files import OBJ, PLY, STL
from scenelang.backends.exports.usd import USD
from scenelang.backends.mitsuba_export.mitsuba_xml import MITSUBA_XML
from scenelang.backends.surfaces.assets import AssetFiles
from scenelang.files.scene_json import JSON
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.primitives import shape_of
from scenelang.interpreter.values.values import Embedding, Matrix

MESHES = [GLTF, USD, OBJ, PLY, STL, MITSUBA_XML]


def run(backend: Backend, scene: Scene, path: Path, **given: Any) -> None:
    named = {name.replace("_", "-"): value for name, value in given.items()}
    backend.run(scene, path, BackendOptions(settings=named))


def vertices_of(path: Path) -> np.ndarray:
    """All vertices of an exported file, in the world."""
    if path.suffix == ".glb":
        rows = [one.vertices for one in Gltf(path).seen()]
    elif path.suffix == ".usdc":
        from pxr import Usd

        rows = [vertices for _, vertices, _ in usd_seen(Usd.Stage.Open(str(path)))]
    elif path.suffix == ".ply":
        rows = [ply_rows(path)[0][:, :3]]
    else:
        rows = [obj_corners(path)[:, :3]]
    return np.concatenate(rows) if rows else np.zeros((0, 3))


def points_of(scene: Scene, ending: str) -> np.ndarray:
    """What `vertices_of` is to return: OBJ files, where vertices are shared, are compared by corners."""
    return np.concatenate([corners_of(one) if ending == ".obj" else one.vertices for one in expected(scene)])


READABLE = [(GLTF, ".glb"), (USD, ".usdc"), (PLY, ".ply"), (OBJ, ".obj")]


# --- parts -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("backend", "ending"), READABLE)
def test_parts_are_one_file_each_where_they_stand(backend: Backend, ending: str, tmp_path: Path) -> None:
    scene = example("strict.scene")
    run(backend, scene, tmp_path / f"set{ending}", parts=True)
    files = sorted(path for path in tmp_path.iterdir() if path.suffix == ending)
    words = [export.safe_name(part.car.word) for part in scene.root.children]
    assert [path.name for path in files] == [f"set-{i:03d}-{word}{ending}" for i, word in enumerate(words, start=1)]
    points = np.concatenate([vertices_of(path) for path in files])
    assert same_points(points, points_of(scene, ending), 1e-5)


@pytest.mark.slow
@settings(max_examples=many(25), deadline=None)
@given(scenes())
def test_parts_of_any_scene_and_depth(scene: Scene) -> None:
    wanted = np.concatenate([one.vertices for one in expected(scene)] or [np.zeros((0, 3))])
    for depth in (0, 1, 2, 7):
        with tempfile.TemporaryDirectory() as folder:
            run(PLY, scene, Path(folder) / "a.ply", parts=True, depth=depth)
            rows = [vertices_of(path) for path in sorted(Path(folder).iterdir())]
        assert same_points(np.concatenate([*rows, np.zeros((0, 3))]), wanted, 2e-5)


def test_a_part_of_which_nothing_is_seen_is_an_empty_mesh(make: Any, tmp_path: Path) -> None:
    scene = make.scene(make.primitive("cube"), make.group("a", make.primitive("cube", opacity=0.0)))
    run(PLY, scene, tmp_path / "a.ply", parts=True)
    rows = [len(vertices_of(path)) for path in sorted(tmp_path.iterdir())]
    assert rows == [24, 0]


def test_a_part_keeps_its_animation(tmp_path: Path) -> None:
    scene = example("orrery.scene", **{"frame-count": 12})
    run(GLTF, scene, tmp_path / "a.glb", parts=True, depth=1)
    run(USD, scene, tmp_path / "a.usdc", parts=True, depth=1)
    files = sorted(tmp_path.glob("*.glb"))
    assert len(files) == len(scene.root.children)
    for frame in (0, 4, 11):
        points = np.concatenate([one.vertices for path in files for one in Gltf(path).seen(frame / 24)])
        assert same_points(points, np.concatenate([one.vertices for one in expected(scene, frame)]), 1e-5)


def test_names_of_parts_never_leave_the_folder(make: Any, tmp_path: Path) -> None:
    words = ["../../etc/passwd", "a/b", "..", "", "con", "日本", "a\0b", "x" * 500, "a", "A"]
    parts = [make.group(word, make.primitive("cube")) for word in words]
    folder = tmp_path / "inner"
    folder.mkdir()
    run(STL, make.scene(*parts), folder / "a.stl", parts=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["inner"]
    assert len(list(folder.iterdir())) == len(words)
    assert (folder / "a-001-etc-passwd.stl").exists()


def test_too_many_parts_are_refused(make: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(export, "MAX_FILES", 5)
    with pytest.raises(LimitError, match="parts"):
        run(STL, make.scene(*[make.primitive("cube")] * 6), tmp_path / "a.stl", parts=True)
    assert not list(tmp_path.iterdir())


# --- blocks, assets --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("backend", "ending"), READABLE)
def test_blocks_are_cubes_at_whole_cells(backend: Backend, ending: str, tmp_path: Path) -> None:
    scene = evaluate("""
      (bind "wall" (lambda () (for/union ((i '(0 1 2)))
        (transform (call "set-cuboid" :block-type "stone" :scale [2 1 1]) (translate [(* i 1.3) (* i -.7) 0])))))
      (bind "town" (lambda () (union (transform (call "wall") (translate [.6 .6 .6]))
        (transform (call "wall") (translate [-9.2 0 3.9]))
        (transform (call "cube") (translate [.25 9 0])))))""")
    same = evaluate("""
      (bind "town" (lambda () (union (transform (call "cube") (translate [.25 9 0]))
        (transform (call "cube" :scale [5 1 1]) (translate [2.5 .5 .5]))
        (transform (call "cube" :scale [4 1 1]) (translate [-7 .5 3.5]))
        (transform (call "cube" :scale [2 1 1]) (translate [-5 -.5 3.5])))))""")
    wanted = points_of(same, ending)
    for depth in (None, 0, 1, 2):
        run(backend, scene, tmp_path / f"a{ending}", depth=depth)
        assert same_points(vertices_of(tmp_path / f"a{ending}"), wanted, 1e-5), depth


@pytest.fixture
def painted(tmp_path: Path, make: Any) -> Callable[..., Scene]:
    """A scene with a mesh file whose faces have two colors, sheared; with or without a ``:color``."""
    red, blue = (make.primitive("cube", scale=(1, 2, 1.4), color=color) for color in ((1, 0, 0), (0, 0, 1)))
    halves = make.scene((red, pose.translation(0, 0, -0.75)), (blue, pose.translation(0, 0, 0.75)))
    run(PLY, halves, tmp_path / "box.ply")

    def made(**attributes: Any) -> Scene:
        given = {"file": str(tmp_path / "box.ply")}
        given |= {name: make.vector(*value) for name, value in attributes.items()}
        shape = shape_of("mesh", given, AssetFiles(tmp_path, tmp_path, False).measure("box.ply"))
        asset = Entity("mesh", Embedding(attributes=given), (), shape)
        from dataclasses import replace

        asset.shape = replace(shape, file=str(tmp_path / "box.ply"))
        return make.scene((asset, Matrix((1, 0.5, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0))), make.primitive("cube"))

    return made


@pytest.mark.parametrize("depth", [None, 0])
def test_assets_are_there_with_their_colors(depth: int | None, painted: Callable[..., Scene], tmp_path: Path) -> None:
    from pxr import Usd

    for scene, colors in (
        (painted(), {(1, 0, 0), (0, 0, 1), (1, 1, 1)}),
        (painted(color=(0, 1, 0)), {(0, 1, 0), (1, 1, 1)}),
    ):
        run(GLTF, scene, tmp_path / "a.glb", depth=depth)
        seen = Gltf(tmp_path / "a.glb").seen()
        assert {tuple(np.round(row, 4)) for one in seen for row in one.colors} == colors
        file = tmp_path / f"{len(colors)}.usdc"
        run(USD, scene, file, depth=depth)
        stage = Usd.Stage.Open(str(file))
        assert {tuple(np.round(row, 4)) for _, _, rows in usd_seen(stage) for row in rows} == colors
        assert complaints(stage) == []
        run(PLY, scene, tmp_path / "b.ply", depth=depth)
        assert {tuple(row) for row in ply_rows(tmp_path / "b.ply")[0][:, 3:]} == colors
        points = np.concatenate([one.vertices for one in expected(scene)])
        assert same_points(np.concatenate([one.vertices for one in seen]), points, 1e-5)


# --- errors ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("backend", [*MESHES, JSON], ids=lambda backend: backend.name)
def test_errors_are_one_line_and_leave_nothing(backend: Backend, make: Any, tmp_path: Path) -> None:
    path = tmp_path / f"a{backend.endings[0]}"
    cube = make.primitive("cube")
    huge = pose.scaling(1e200, 1e200, 1e200, (0, 0, 0))
    odd = [
        ("value", make.scene(cube), BackendOptions(frame=3)),
        ("value", make.scene(cube), BackendOptions(settings={"colour": 3})),
    ]
    if backend is not JSON:
        odd += [
            ("empty-scene", make.scene(), BackendOptions()),
            ("empty-scene", make.scene(make.primitive("delete-blocks")), BackendOptions()),
            ("pose", make.scene((make.group("a", (cube, huge)), huge)), BackendOptions()),
            ("attribute", make.scene(make.primitive("cube", ior=0.5)), BackendOptions()),
            ("value", make.scene(cube), BackendOptions(settings={"depth": -1})),
        ]
    for name, scene, options in odd:
        with pytest.raises(SceneError) as caught:
            backend.run(scene, path, options)
        assert caught.value.name == name
        assert "\n" not in caught.value.message
        assert not list(tmp_path.iterdir())
    with pytest.raises(SceneError) as caught:
        backend.run(make.scene(cube), tmp_path / "none" / path.name, BackendOptions())
    assert caught.value.name == "file"
    path.mkdir()
    with pytest.raises(SceneError) as caught:
        backend.run(make.scene(cube), path, BackendOptions())
    assert caught.value.name == "file"
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("backend", MESHES, ids=lambda backend: backend.name)
def test_singular_poses_and_things_without_extent(backend: Backend, make: Any, tmp_path: Path) -> None:
    flat = Matrix((1, 0, 0, 0, 0, 0, 0, 2, 0, 0, 1, 0))
    point = Matrix((0,) * 12)
    line = make.primitive("cylinder", p1=(0, 0, 0))
    dot = make.primitive("sphere", radius=0)
    things = [make.primitive(word) for word in ("cube", "sphere", "cylinder", "cone")]
    scene = make.scene(line, dot, *[(thing, flat) for thing in things], *[(thing, point) for thing in things])
    for depth in (None, 0):
        run(backend, scene, tmp_path / f"a{backend.endings[0]}", depth=depth)
        if backend.endings[0] == ".ply":
            assert np.isfinite(ply_rows(tmp_path / "a.ply")[0]).all()


def test_a_write_that_fails_half_way_changes_nothing(
    make: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = make.scene(make.primitive("cube"), make.primitive("sphere"))
    (tmp_path / "a.mtl").write_text("old")
    (tmp_path / "a.obj").write_text("old")
    real = os.replace
    calls: list[object] = []

    def second_fails(source: Any, target: Any) -> None:
        calls.append(target)
        if len(calls) == 2:
            raise OSError(28, "No space left on device", str(target))
        real(source, target)

    monkeypatch.setattr(files.os, "replace", second_fails)
    with pytest.raises(SceneError, match=r"a\.obj.*No space left"):
        run(OBJ, scene, tmp_path / "a.obj")
    assert sorted(os.listdir(tmp_path)) == ["a.mtl", "a.obj"]
    assert [(tmp_path / name).read_text() for name in ("a.mtl", "a.obj")] == ["old", "old"]


def test_an_interrupt_leaves_nothing(make: Any, tmp_path: Path) -> None:
    def stop(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        GLTF.run(make.scene(make.primitive("cube")), tmp_path / "a.glb", BackendOptions(progress=stop))
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_deep_scenes_need_no_recursion(make: Any, tmp_path: Path) -> None:
    entity = make.primitive("cube")
    for _ in range(5000):
        entity = make.group("nest", (entity, pose.translation(0, 1, 0)))
    scene = Scene("nest", [entity], False)
    run(GLTF, scene, tmp_path / "a.glb")
    run(PLY, scene, tmp_path / "a.ply")
    assert vertices_of(tmp_path / "a.ply")[:, 1].max() == pytest.approx(5000.5)
    assert len(Gltf(tmp_path / "a.glb").nodes) == 5001
    with pytest.raises(LimitError, match="nested deeper"):
        run(USD, scene, tmp_path / "a.usdc")
    run(USD, scene, tmp_path / "a.usdc", depth=100)


def test_an_unwritten_extra_is_one_line(make: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    for name in [name for name in sys.modules if name == "pxr" or name.startswith("pxr.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(SceneError, match="cannot be imported") as caught:
        run(USD, make.scene(make.primitive("cube")), tmp_path / "a.usdc")
    assert caught.value.hint == "install it with `pip install 'scenelang[usd]'`"


def test_every_example_has_geometry() -> None:
    assert all(next(expected(example(path.name)), None) is not None for path in EXAMPLES.glob("*.scene"))


def test_a_root_that_is_a_primitive(make: Any, tmp_path: Path) -> None:
    root = Entity("cube", Embedding(), (), shape_of("cube", {}))
    scene = Scene("cube", [root], False)
    for backend, ending in READABLE:
        for settings_ in ({}, {"parts": True}, {"depth": 0}):
            run(backend, scene, tmp_path / f"a{ending}", **settings_)
    assert (tmp_path / "a-001-cube.glb").exists()
    assert len(vertices_of(tmp_path / "a.glb")) == 24
