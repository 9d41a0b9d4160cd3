"""USD files, opened with usd-core and compared with ``flatten``."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from searching import many
from support import calls

from exports.oracle import corners_of, example, expected, on_examples, same_points, scenes
from exports.usd_reader import complaints, seen
from scenelang.backends.base import BackendOptions
from scenelang.backends.exports.plan import surface_of
from scenelang.backends.exports.usd import USD, PrimNames
from scenelang.backends.surfaces.appearance import look_of
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.values.values import IDENTITY, Embedding, Pair

pytest.importorskip("pxr", reason="usd-core is not installed")


def written(scene: Scene, path: Path, **settings_: Any) -> Any:
    from pxr import Usd

    USD.run(scene, path, BackendOptions(settings=settings_))
    return Usd.Stage.Open(str(path))


def check(stage: Any, scene: Scene, frame: int = 0) -> None:
    got, wanted = list(seen(stage, float(frame))), list(expected(scene, frame))
    assert [words for words, _, _ in got] == [one.path for one in wanted]
    for (_, vertices, colors), one in zip(got, wanted, strict=True):
        points = one.vertices if look_of(one.entity).texture is None else corners_of(one)  # which have coordinates
        assert np.allclose(vertices, points, rtol=1e-6, atol=1e-6 * max(1.0, np.abs(points).max()))
        assert np.allclose(colors, one.color, atol=1e-7)


@pytest.mark.parametrize("name", on_examples())
@pytest.mark.sampled(3)
def test_examples_keep_their_geometry_words_and_colors(name: str, tmp_path: Path) -> None:
    scene = example(name)
    stage = written(scene, tmp_path / "a.usda")
    for frame in {0, len(scene.frames) // 3, len(scene.frames) - 1}:
        check(stage, scene, frame)
    assert complaints(stage) == []


@pytest.mark.parametrize("ending", [".usd", ".usdc", ".usdz"])
def test_every_ending(ending: str, tmp_path: Path) -> None:
    scene = example("jenga.scene")
    stage = written(scene, tmp_path / f"a{ending}")
    check(stage, scene)
    assert complaints(stage) == []
    assert [path.name for path in tmp_path.iterdir()] == [f"a{ending}"]


@settings(max_examples=many(30), deadline=None)
@given(scenes())
def test_any_pose(scene: Scene) -> None:
    with tempfile.TemporaryDirectory() as folder:
        stage = written(scene, Path(folder) / "a.usdc")
        check(stage, scene)
        assert complaints(stage) == []


@settings(max_examples=many(30), deadline=None)
@given(scenes(frames=4))
def test_any_animation_is_right_at_every_frame(scene: Scene) -> None:
    with tempfile.TemporaryDirectory() as folder:
        stage = written(scene, Path(folder) / "a.usdc")
        for frame in range(4):
            got, wanted = list(seen(stage, float(frame))), list(expected(scene, frame))
            assert len(got) == len(wanted)
            for one in wanted:  # paths that come and go may stand in another order
                assert any(
                    words == one.path
                    and vertices.shape == one.vertices.shape
                    and np.allclose(vertices, one.vertices, rtol=1e-5, atol=1e-5)
                    and np.allclose(colors, one.color)
                    for words, vertices, colors in got
                )
        assert complaints(stage) == []


def test_the_stage_says_how_it_is_to_be_read(tmp_path: Path) -> None:
    from pxr import UsdGeom

    scene = example("orrery.scene")
    stage = written(scene, tmp_path / "a.usda", fps=12)
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == ("Y", 1.0)
    assert (stage.GetTimeCodesPerSecond(), stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (12, 0, 47)
    root = stage.GetDefaultPrim()
    assert root.GetName() == "solar_system"
    for frame in (0, 7, 47):
        hint = np.array(root.GetAttribute("extentsHint").Get(frame)).ravel()
        assert hint == pytest.approx(entity_box(scene.frames[frame]), abs=1e-6)


def test_words_handles_and_embeddings_are_attributes(make: Any, tmp_path: Path) -> None:
    cube = make.primitive("cube", color=(0.25, 0.5, 1))
    root = Entity("the root", Embedding("z1", "a red one"), (Pair(cube, IDENTITY), Pair(cube, make.chain())))
    stage = written(Scene("the root", [root], False), tmp_path / "a.usda")
    prim = stage.GetDefaultPrim()
    said = {a.GetName(): a.Get() for a in prim.GetAttributes() if a.GetName().startswith("scenelang:")}
    assert said["scenelang:word"] == "the root"
    assert said["scenelang:handle"] == "z1"
    assert said["scenelang:embedding"] == '{"handle": "z1", "text": "a red one"}'
    children = [child for child in prim.GetChildren() if child.HasAttribute("scenelang:word")]
    assert [(c.GetName(), c.IsInstance()) for c in children] == [("cube", True), ("cube_2", True)]
    assert children[1].GetAttribute("scenelang:embedding").Get() == '{"attributes": {"color": [0.25, 0.5, 1.0]}}'
    assert len(stage.GetPrototypes()) == 1


def test_materials_are_bound(make: Any, tmp_path: Path) -> None:
    from pxr import UsdShade

    cube = make.primitive("cube", color=(0.25, 0.5, 1), opacity=0.5, emission=2)
    stage = written(make.scene(cube, (cube, IDENTITY)), tmp_path / "a.usda")
    (prim,) = stage.GetPrototypes()[0].GetChildren()
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    shader = material.ComputeSurfaceSource()[0]
    assert shader.GetIdAttr().Get() == "UsdPreviewSurface"
    values = {i.GetBaseName(): i.Get() for i in shader.GetInputs()}
    assert tuple(values["diffuseColor"]) == (0.25, 0.5, 1)
    assert tuple(values["emissiveColor"]) == (0.5, 1, 2)
    assert values["opacity"] == 0.5


def test_a_level_5_sponge_keeps_its_nested_instancing(tmp_path: Path) -> None:
    from pxr import Usd, UsdGeom

    scene = example("menger-sponge.scene", level=5)
    made = []
    assert calls(lambda: made.append(written(scene, tmp_path / "a.usdc"))) < 100_000  # for 3,200,000 cubes
    (stage,) = made
    assert (tmp_path / "a.usdc").stat().st_size < 100_000
    box = UsdGeom.BBoxCache(0, [UsdGeom.Tokens.default_]).ComputeWorldBound(stage.GetDefaultPrim())
    low, high = box.ComputeAlignedRange().GetMin(), box.ComputeAlignedRange().GetMax()
    assert [*low, *high] == pytest.approx(entity_box(scene.root), abs=1e-6)
    counts: dict[Any, int] = {}

    def cubes(prim: Any) -> int:
        root = prim.GetPrototype() if prim.IsInstance() else prim
        if root.GetPath() not in counts:
            counts[root.GetPath()] = root.IsA(UsdGeom.Mesh) + sum(map(cubes, root.GetChildren()))
        return counts[root.GetPath()]

    assert cubes(stage.GetDefaultPrim()) == 20**5
    assert len(list(Usd.PrimRange.AllPrims(stage.GetPseudoRoot()))) < 300


def test_depth_merges_each_entity_of_that_level(tmp_path: Path) -> None:
    scene = example("strict.scene")
    stage = written(scene, tmp_path / "a.usdc", depth=1)
    got = list(seen(stage))
    assert {words for words, _, _ in got} == {(scene.word, part.car.word) for part in scene.root.children}
    points = np.concatenate([np.hstack([vertices, colors]) for _, vertices, colors in got])
    wanted = [np.hstack([one.vertices, np.tile(one.color, (len(one.vertices), 1))]) for one in expected(scene)]
    assert same_points(points, np.concatenate(wanted), 1e-5)
    assert complaints(stage) == []


def test_flat_things_are_meshes(make: Any, tmp_path: Path) -> None:
    floor = make.primitive("cube", scale=(2, 0, 2))
    (one,) = seen(written(make.scene(floor), tmp_path / "a.usdc"))
    surface = surface_of(floor)
    assert surface is not None
    assert one[1] == pytest.approx(surface.vertices)


def test_names_are_valid_and_unique() -> None:
    names = PrimNames()
    assert [names.fresh(word) for word in ("a", "a", "a_2", "a", "3 cubes", "été", "", "a_2", "日本")] == [
        "a", "a_2", "a_2_2", "a_3", "_3_cubes", "t", "entity", "a_2_3", "entity_2",
    ]  # fmt: skip
