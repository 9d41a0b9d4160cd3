"""Labels: against an independent ray tracer and exact geometry, and what comes of unusual scenes."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import evaluate

from scenelang.backends.labels.ground_truth import Truth, truth_of
from scenelang.backends.labels.object_labels import (
    keypoint_records,
    levels_data,
    object_records,
    objects_of,
    oriented_boxes,
    pixels_alone,
)
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.stage import still, unit_size
from scenelang.datasets.making import Maker, Sample, SampleFailure, decoded
from scenelang.datasets.spec import Spec, spec_of
from scenelang.interpreter.scene.entity import Scene

Read = Callable[..., Spec]
ROW = """
(bind "knob" (lambda () (call "sphere" :radius .15 :color [1 0 0])))
(bind "drawer" (lambda () (union (call "cube" :scale [1 .4 .6]) (transform (call "knob") (translate [0 0 .35])))))
(bind "chest" (lambda () (union (transform (call "drawer") (translate [0 .2 0])) (transform (call "drawer") (translate [0 .7 0])))))
(bind "room" (lambda () (union (transform (call "chest") (rotate .3 [0 1 0])) (transform (call "cube" :scale .5) (translate [.3 .25 1])))))
"""
VIEW = Viewpoint(azimuth=15.0, elevation=20.0)


def truth(scene: Scene, size: tuple[int, int] = (96, 72)) -> Truth:
    return truth_of(scene, still(scene, VIEW, 0, *size), 100_000, *unit_size(scene))


@pytest.fixture(scope="module")
def row() -> Scene:
    return evaluate(ROW)


def test_things_are_the_nearest_words_of_the_program(row: Scene) -> None:
    found = objects_of(truth(row))
    words = [found.truth.ancestry.entity(i).word for i in found.shown]
    assert sorted(set(words)) == ["chest", "drawer", "knob", "room"]
    shown = {words[number - 1] for number in np.unique(found.ids[found.ids > 0])}
    assert shown == {"drawer", "knob", "room"}  # the chest shows its drawers only
    only = objects_of(found.truth, ["chest"])
    assert set(np.unique(only.ids)) == {0, 1}
    assert only.shares(["chest", "drawer"])["chest"] == pytest.approx((only.ids > 0).mean())


def nearest_triangles(triangles: np.ndarray, eye: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangle that each ray hits first and the ray parameter there (Moller and Trumbore, 1997)."""
    a, edges = triangles[:, 0], (triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    found, away = np.zeros(len(directions), np.int64), np.full(len(directions), np.inf)
    for k, direction in enumerate(directions):
        across = np.cross(direction, edges[1])
        with np.errstate(all="ignore"):
            scale = 1.0 / np.einsum("ni,ni->n", edges[0], across)
            u = np.einsum("ni,ni->n", eye - a, across) * scale
            other = np.cross(eye - a, edges[0])
            v = other @ direction * scale
            t = np.einsum("ni,ni->n", edges[1], other) * scale
        t = np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0), t, np.inf)
        found[k], away[k] = np.argmin(t), t.min()
    return found, away


def test_labels_agree_with_an_independent_ray_tracer(read: Read) -> None:
    """Boxes of the things, as triangles of trimesh, hit by rays of the recorded camera."""
    import trimesh

    sample = Maker(read('programs = "room.scene"\nseeds = 3\n[params]\nballs = 3\n[pictures]\nsize = [40, 30]')).make(1)
    files, record = sample.items[0].files, json.loads(sample.items[0].files["json"])
    depth, ids = decoded("depth.npy", files["depth.npy"]), decoded("instance.png", files["instance.png"])
    normals = decoded("normals.png", files["normals.png"]).astype(float) / 127.5 - 1.0
    meshes, owners = [], []
    for thing in record["things"]:
        if thing["word"] not in ("ball", "leg"):
            continue
        box = thing["box3d"]
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = np.array(box["rotation"]), box["center"]
        form = trimesh.creation.icosphere(4, 0.3) if thing["word"] == "ball" else trimesh.creation.box(box["size"])
        form.apply_transform(pose)
        meshes.append(form)
        owners += [thing["id"]] * len(form.faces)
    joined = trimesh.util.concatenate(meshes)
    camera = record["camera"]
    world = np.linalg.inv(np.array(camera["world_to_camera"]))
    rows, columns = np.nonzero(np.isin(ids, owners))
    local = np.stack([columns + 0.5, rows + 0.5, np.ones(len(rows))], axis=1) @ np.linalg.inv(np.array(camera["K"])).T
    directions = local @ world[:3, :3].T
    faces, away = nearest_triangles(joined.triangles, world[:3, 3], directions)
    hit = np.isfinite(away)
    assert hit.mean() > 0.97
    rows, columns, faces = rows[hit], columns[hit], faces[hit]
    assert np.median(np.abs(away[hit] - depth[rows, columns])) < 2e-3
    assert (np.array(owners)[faces] == ids[rows, columns]).mean() > 0.98
    facing = np.einsum("ni,ni->n", joined.face_normals[faces], normals[rows, columns])
    assert np.median(facing) > 0.99


def test_pixels_alone_are_those_of_a_scene_of_the_thing_alone(row: Scene) -> None:
    found = objects_of(truth(row))
    alone = pixels_alone(found, *unit_size(row))
    boxes = found.boxes
    for instance in found.shown.tolist():
        entity, pose = found.truth.ancestry.entity(instance), found.truth.ancestry.poses[instance]
        single = Scene("one", [_placed(entity, pose)], False)
        shot = still(row, VIEW, 0, 96, 72)
        whole = truth_of(single, shot, 1000, *unit_size(row))
        assert alone[instance] == whole.seen.sum(), entity.word
        assert alone[instance] >= boxes.area[instance]


def _placed(entity: Any, matrix: np.ndarray) -> Any:
    from scenelang.interpreter.scene.entity import Entity
    from scenelang.interpreter.values.values import ANONYMOUS, Matrix, Pair

    return Entity("one", ANONYMOUS, (Pair(entity, Matrix(matrix.reshape(-1).tolist())),))


def test_handles_of_some_are_those_of_all(row: Scene) -> None:
    from scenelang.interpreter.inspection.numbering import frame_numbers, instance_handles, some_handles

    found = truth(row).ancestry
    rows = [len(found) - 1, 0, *range(2, len(found), 3)]
    every = instance_handles(row, found)
    assert some_handles(row, found, rows) == {i: every[i] for i in rows}
    film = evaluate('(bind "a" (lambda () (frames (for/list ((i (iota 3))) (union (call "cube") (call "sphere"))))))')
    shot = still(film, VIEW, 2, 16, 12)
    later = truth_of(film, shot, 1000, *unit_size(film)).ancestry
    numbers = frame_numbers(film)
    every = instance_handles(film, later, numbers)
    assert some_handles(film, later, range(len(later)), numbers) == dict(enumerate(every))


def test_records_of_things_are_exact(row: Scene) -> None:
    found = objects_of(truth(row))
    classes = {"chest": 1, "drawer": 2, "knob": 3}
    records = object_records(
        found, dict.fromkeys(found.shown.tolist(), "h"), classes, pixels_alone(found, *unit_size(row))
    )
    by_id = {each["id"]: each for each in records}
    for each in records:
        assert 0.0 <= each["visibility"] <= 1.0
        assert each["class"] == classes.get(each["word"], 65_535)
        if each["word"] == "drawer":
            assert by_id[each["parent"]]["word"] == "chest"
            assert np.allclose(sorted(each["box3d"]["size"]), sorted([1.0, 0.4, 0.8]))
            corners = np.array(each["box3d"]["center"])
            assert corners[1] in (pytest.approx(0.2), pytest.approx(0.7))
    knobs = [each for each in records if each["word"] == "knob"]
    assert knobs
    assert all(np.allclose(each["box3d"]["size"], [0.3] * 3) for each in knobs)


def test_oriented_boxes_hold_sheared_and_reflected_things() -> None:
    random = np.random.default_rng(4)
    poses = np.concatenate([random.normal(size=(20, 3, 3)), random.normal(size=(20, 3, 1))], axis=2)
    low, high = np.tile([-1.0, -0.5, 0.0], (20, 1)), np.tile([1.0, 0.5, 2.0], (20, 1))
    for box, pose in zip(oriented_boxes(poses, low, high), poses, strict=True):
        rotation = np.array(box["rotation"])
        assert np.allclose(rotation @ rotation.T, np.eye(3))
        assert np.linalg.det(rotation) == pytest.approx(1.0)
        points = random.uniform(low[0], high[0], (50, 3)) @ pose[:, :3].T + pose[:, 3]
        local = (points - np.array(box["center"])) @ rotation
        assert (np.abs(local) <= np.array(box["size"]) / 2 + 1e-9).all()


def test_keypoints_know_whether_they_are_seen(row: Scene) -> None:
    found = objects_of(truth(row))
    points = keypoint_records(found, ["knob", "drawer"])
    assert sorted(each["word"] for each in points) == ["drawer", "drawer", "knob", "knob"]
    for each in points:
        pixel, _ = found.truth.camera.project(np.array([each["world"]]))
        assert np.allclose(each["point"], pixel[0])
    upper = max((each for each in points if each["word"] == "knob"), key=lambda each: each["world"][1])
    assert upper["visible"] == 2
    lower = min((each for each in points if each["word"] == "knob"), key=lambda each: each["world"][1])
    assert lower["visible"] == 1  # behind the cube


def test_levels_cover_the_same_pixels(row: Scene) -> None:
    found = objects_of(truth(row))
    levels = levels_data(found, 8)
    assert [sorted({record["word"] for record in records}) for _, records in levels] == [
        ["chest", "cube"], ["cube", "drawer"], ["cube", "knob"], ["cube", "sphere"],
    ]  # fmt: skip
    for ids, _ in levels:
        assert ((ids > 0) == found.truth.seen).all()


# --- unusual scenes --------------------------------------------------------------------------------------------------


def made(tmp_path: Path, text: str, spec: str, index: int = 0) -> Sample:
    (tmp_path / "a.scene").write_text(text)
    return Maker(spec_of(f"programs = 'a.scene'\n{spec}", "spec.toml", tmp_path)).make(index)


def test_minecraft_scenes_are_labeled_as_cubes(tmp_path: Path) -> None:
    text = '(bind "hut" (lambda () (union (call "oak_planks" :block_type "oak_planks" :scale [2 1 2]) (call "roof"))))\n(bind "roof" (lambda () (transform (call "stone" :block_type "stone" :scale [1 1 1]) (translate [0 1 0]))))'
    files = made(tmp_path, text, "[pictures]\nsize = 32").items[0].files
    record = json.loads(files["json"])
    words = {thing["word"] for thing in record["things"] if thing["area"]}
    assert "hut" in words
    assert np.isfinite(decoded("depth.npy", files["depth.npy"])).any()


def test_semantic_primitives_are_things_without_drawn_words(tmp_path: Path) -> None:
    text = '(bind "desk" (lambda () (union (call "lamp" :scale [.2 .5 .2]) (transform (call "book" :scale [.4 .1 .3]) (translate [.5 0 0])))))'
    files = made(tmp_path, text, "[pictures]\nsize = 48").items[0].files
    record = json.loads(files["json"])
    seen = {thing["word"]: thing for thing in record["things"]}
    assert {"desk", "lamp", "book"} == set(seen)
    assert np.allclose(seen["lamp"]["box3d"]["size"], [0.2, 0.5, 0.2])
    assert files["txt"] in (b"1 lamp and 1 book", b"1 book and 1 lamp")


def test_an_empty_view_is_a_sample_without_things(tmp_path: Path) -> None:
    text = '(bind "a" (lambda () (call "ball-word")))'
    spec = "[pictures]\nsize = 16\n[cameras]\nkind = 'trajectory'\neyes = [[0, 0, 9], [1, 0, 9]]\ntarget = [0, 0, 20]\n[labels]\nwrite = ['instance', 'semantic', 'levels', 'depth', 'normals', 'boxes', 'visibility', 'keypoints', 'graph', 'captions']\nkeypoints = 'ball-word'"
    files = made(tmp_path, text, spec).items[0].files
    record = json.loads(files["json"])
    assert record["things"] == []
    assert not decoded("instance.png", files["instance.png"]).any()
    assert np.isinf(decoded("depth.npy", files["depth.npy"])).all()
    with pytest.raises(SampleFailure, match="no draw passes the filters"):
        made(tmp_path, text, spec + "\n[filters.visible]\nball-word = 0.01")


def test_an_empty_scene_fails_with_its_code(tmp_path: Path) -> None:
    with pytest.raises(SampleFailure) as caught:
        made(tmp_path, '(bind "a" (lambda () (union)))', "[pictures]\nsize = 16")
    assert caught.value.diagnostic.name == "empty-scene"


MILLION = """
(param n 100)
(bind "dot" (lambda () (call "cube" :scale .8)))
(bind "row" (lambda () (for/union ((i (iota n))) (transform (call "dot") (translate [i 0 0])))))
(bind "sheet" (lambda () (for/union ((i (iota n))) (transform (call "row") (translate [0 0 i])))))
(bind "block" (lambda () (for/union ((i (iota 100))) (transform (call "sheet") (translate [0 i 0])))))
"""


@pytest.mark.parametrize("n", [15, pytest.param(100, marks=pytest.mark.slow)])
def test_a_million_instances_are_labeled(tmp_path: Path, n: int) -> None:
    spec = "[params]\nn = {n}\n[pictures]\nsize = 32\n[labels]\nwrite = ['instance', 'semantic', 'depth']\n"
    files = made(tmp_path, MILLION, spec.format(n=n)).items[0].files
    record = json.loads(files["json"])
    assert record["counts"]["dot"] == 100 * n * n
    ids = decoded("instance.png", files["instance.png"])
    assert len(np.unique(ids)) > 100
    assert all(thing["word"] in ("dot", "row", "sheet", "block") for thing in record["things"])
    with pytest.raises(SampleFailure) as caught:
        made(tmp_path, MILLION, spec.format(n=n + 1) + f"[limits]\nprimitives = {100 * n * n}\n")
    assert caught.value.diagnostic.code == "E504"


def test_more_things_than_a_map_can_number_are_told(row: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.backends.labels import object_labels
    from scenelang.grammar.diagnostics import LimitError

    monkeypatch.setattr(object_labels, "MAX_OBJECTS", 2)
    with pytest.raises(LimitError, match="things are visible, more than the 2"):
        objects_of(truth(row))
