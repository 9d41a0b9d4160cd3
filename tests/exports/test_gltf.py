"""glTF files, read back by a reader of their own and compared with ``flatten``."""

from __future__ import annotations

import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from searching import many
from support import calls

from exports.gltf_reader import Gltf
from exports.oracle import Expected, example, expected, on_examples, same_points, scenes
from scenelang.backends.base import BackendOptions
from scenelang.backends.exports.gltf import GLTF
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Scene, count_words


def written(scene: Scene, path: Path, frame: int | None = None, **settings_: Any) -> Gltf:
    named = {name.replace("_", "-"): value for name, value in settings_.items()}
    GLTF.run(scene, path, BackendOptions(frame=frame, settings=named))
    return Gltf(path)


def tolerance(wanted: list[Expected]) -> float:
    return 3e-6 * max((float(np.abs(one.vertices).max()) for one in wanted), default=1.0) + 1e-6


def check(gltf: Gltf, scene: Scene, frame: int = 0, fps: float = 24.0) -> None:
    """Every primitive at its place, in its color, under its words."""
    seen, wanted = gltf.seen(frame / fps if scene.animated else 0.0), list(expected(scene, frame))
    assert len(seen) == len(wanted)
    near = tolerance(wanted)
    for one, other in zip(seen, wanted, strict=True):
        assert tuple(name for name in one.path if "/" not in name) == other.path
        assert one.extras["word"] == other.entity.word
        assert np.allclose(one.vertices, other.vertices, rtol=0, atol=near)
        assert np.allclose(one.colors, other.color, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "ending"), [*on_examples(".glb"), ("orrery.scene", ".gltf"), ("jenga.scene", ".gltf")]
)
@pytest.mark.sampled(3)
def test_examples_keep_their_geometry_names_and_colors(name: str, ending: str, tmp_path: Path) -> None:
    scene = example(name)
    gltf = written(scene, tmp_path / f"a b{ending}")
    for frame in {0, len(scene.frames) // 3, len(scene.frames) - 1}:
        check(gltf, scene, frame)


@settings(max_examples=many(30), deadline=None)
@given(scenes())
def test_any_pose(scene: Scene) -> None:
    with tempfile.TemporaryDirectory() as folder:
        check(written(scene, Path(folder) / "a.glb"), scene)


@settings(max_examples=many(30), deadline=None)
@given(scenes(frames=4))
def test_any_animation_is_right_at_every_frame(scene: Scene) -> None:
    with tempfile.TemporaryDirectory() as folder:
        gltf = written(scene, Path(folder) / "a.glb", fps=10)
        for frame in range(4):
            seen, wanted = gltf.seen(frame / 10), list(expected(scene, frame))
            assert len(seen) == len(wanted)
            near = tolerance(wanted) * 4
            for one in wanted:  # paths that come and go may stand in another order
                assert any(
                    len(other.vertices) == len(one.vertices)
                    and np.allclose(other.vertices, one.vertices, rtol=0, atol=near)
                    and np.allclose(other.colors, one.color)
                    and other.extras["word"] == one.entity.word
                    for other in seen
                )


def test_static_nodes_have_no_tracks(tmp_path: Path) -> None:
    gltf = written(example("orrery.scene"), tmp_path / "a.glb")
    (animation,) = gltf.document["animations"]
    targets = {gltf.nodes[channel["target"]["node"]]["name"] for channel in animation["channels"]}
    assert "planet" in targets
    assert not targets & {"stand", "sun", "arm", "solar system"}
    assert {channel["target"]["path"] for channel in animation["channels"]} == {"rotation", "translation"}
    assert len(gltf.nodes) == sum(count_words(example("orrery.scene").root).values())


@settings(max_examples=many(30), deadline=None)
@given(scenes())
def test_merged_repetitions_keep_points_colors_and_counts(scene: Scene) -> None:
    with tempfile.TemporaryDirectory() as folder:
        gltf = written(scene, Path(folder) / "a.glb", instance_limit=4)
    wanted = list(expected(scene))
    seen = gltf.seen()
    if not wanted:
        assert not seen
        return
    points = np.concatenate([np.hstack([one.vertices, one.colors]) for one in seen])
    right = np.concatenate([np.hstack([o.vertices, np.tile(o.color, (len(o.vertices), 1))]) for o in wanted])
    assert same_points(points, right, 2e-5)
    words: Counter[str] = Counter()
    for node in gltf.nodes:
        if "/" not in node["name"]:
            words[node["extras"]["word"]] += 1
            words.update(node["extras"].get("words", {}))
    assert words == count_words(scene.root)


def test_what_is_not_repeated_is_not_merged(make: Any, tmp_path: Path) -> None:
    scene = make.scene(*[make.group("g", make.primitive("cube", scale=(1, 1, 1 + i))) for i in range(20)])
    assert len(written(scene, tmp_path / "a.glb", instance_limit=10).nodes) == 41


def test_depth_merges_each_entity_of_that_level(tmp_path: Path) -> None:
    scene = example("strict.scene")
    gltf = written(scene, tmp_path / "a.glb", depth=1)
    parts = [gltf.nodes[child] for child in gltf.nodes[0]["children"]]
    assert [part["name"] for part in parts] == [part.car.word for part in scene.root.children]
    assert all("children" not in part or "shear" in gltf.nodes[part["children"][0]]["name"] for part in parts)
    points = np.concatenate([one.vertices for one in gltf.seen()])
    assert same_points(points, np.concatenate([one.vertices for one in expected(scene)]), 1e-5)
    whole = written(scene, tmp_path / "b.glb", depth=0)
    assert len(whole.nodes) == 1


def test_the_base_color_is_the_color(make: Any, tmp_path: Path) -> None:
    cube = make.primitive("cube", color=(0.0123, 0.5, 0.9))
    (one,) = written(make.scene(cube), tmp_path / "a.glb").seen()
    assert one.material["pbrMetallicRoughness"]["baseColorFactor"] == [0.0123, 0.5, 0.9, 1.0]


def test_a_level_5_sponge_is_small_and_little_work(tmp_path: Path) -> None:
    scene = example("menger-sponge.scene", level=5)
    made = []
    assert calls(lambda: made.append(written(scene, tmp_path / "a.glb"))) < 1_000_000  # for 3,200,000 cubes
    (gltf,) = made
    assert (tmp_path / "a.glb").stat().st_size < 20_000_000
    corners, low, high = 0, np.full(3, np.inf), np.full(3, -np.inf)
    sizes = [gltf.document["accessors"][m["primitives"][0]["attributes"]["POSITION"]] for m in gltf.document["meshes"]]
    for mesh, world, _, _ in gltf.placed():
        corners += sizes[mesh]["count"]
        assert np.count_nonzero(world[:3, :3]) == 3  # axis-aligned, so that the box of the box is the box
        both = np.array([sizes[mesh]["min"], sizes[mesh]["max"]]) @ world[:3, :3].T + world[:3, 3]
        low, high = np.minimum(low, both.min(axis=0)), np.maximum(high, both.max(axis=0))
    assert corners == 24 * 20**5
    assert len(gltf.nodes) <= 100_000
    assert np.allclose([*low, *high], entity_box(scene.root), atol=1e-6)
    assert sum(node["extras"].get("words", {}).get("cube", 0) for node in gltf.nodes) == 20**5
    assert "COLOR_0" in gltf.document["meshes"][0]["primitives"][0]["attributes"]


def test_frames_that_do_not_exist_and_scenes_with_nothing(make: Any, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="frame 7 does not exist"):
        written(make.scene(make.primitive("cube")), tmp_path / "a.glb", frame=7)
    with pytest.raises(SceneError) as caught:
        written(make.scene(), tmp_path / "a.glb")
    assert caught.value.name == "empty-scene"
    assert not list(tmp_path.iterdir())
