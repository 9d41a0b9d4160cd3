"""Maps are exact: against an independent ray tracer, against `count`, and against themselves."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import evaluate

from scenelang.backends.labels import ground_truth
from scenelang.backends.labels.dataset import annotations_of, dataset
from scenelang.backends.labels.ground_truth import (
    Truth,
    boxes_in,
    boxes_of,
    correspondence_of,
    into_local,
    rectangles_of,
    truth_of,
)
from scenelang.backends.pictures.camera import PRESETS, Camera, Viewpoint
from scenelang.backends.pictures.stage import film, still, unit_size
from scenelang.cli.main import main
from scenelang.interpreter.inspection.numbering import ancestry_of, frame_numbers, instance_handles, primitive_handles
from scenelang.interpreter.scene.entity import Scene, count_words
from scenelang.interpreter.scene.flatten import flatten
from scenelang.interpreter.scene.primitives import standard_forms

BALL, BLOCK, CYLINDER, CONE, TRIANGLE = standard_forms()
TABLE = """
(bind "leg" (lambda () (call "cylinder" :radius .08 :p1 [0 .7 0] :color [.4 .2 .1])))
(bind "table" (lambda ()
  (union (grid (call "leg") :nx 2 :nz 2 :spacing [1 0 1])
         (transform (call "cube" :scale [1.4 .1 1.4] :color [.6 .4 .2]) (translate [0 .75 0])))))
(bind "fruit" (lambda (:kind)
  (union (call "sphere" :radius .2 :color (if (= kind 0) [.8 .1 .1] [.9 .7 .1])))))
(bind "scene" (lambda ()
  (union (call "table")
         (for/union ((i (iota 4)))
           (transform (call "fruit" :kind (% i 2)) (@ (translate [(- (* .35 i) .5) 1 0]) (scale [1 1.3 .6]) (rotate .4 [0 0 1]))))
         (transform (call "cone" :radius .3 :p1 [0 .8 0]) (@ (translate [.9 0 .9]) (reflect [1 .2 0]) (scale [.6 1 1])))
         (transform (call "statue" :scale [.3 1 .3]) (translate [-1 .5 -.6])))))
"""


VIEW = Viewpoint()


def truth(scene: Scene, view: Viewpoint | Camera = VIEW, size: tuple[int, int] = (160, 120), frame: int = 0) -> Truth:
    return truth_of(scene, still(scene, view, frame, *size), 100_000, *unit_size(scene))


@pytest.fixture(scope="module")
def table() -> Scene:
    return evaluate(TABLE)


def mitsuba_hits(found: Truth) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Solid, depth and normal by pixel, from Mitsuba's own shapes (unit shapes under instances)."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    transform = mi.ScalarTransform4f
    scene: dict[str, Any] = {"type": "scene"}
    disk = {"top": {"type": "disk", "to_world": transform().translate([0, 1, 0]).rotate([1, 0, 0], -90)}}
    disk["bottom"] = {"type": "disk", "to_world": transform().translate([0, -1, 0]).rotate([1, 0, 0], 90)}
    side = {"type": "cylinder", "p0": [0, -1, 0], "p1": [0, 1, 0], "radius": 1.0}
    groups = {
        BALL: {"a": {"type": "sphere"}},
        BLOCK: {"a": {"type": "cube"}},
        CYLINDER: {"a": side, **disk},
    }
    for i in range(len(found.solids)):
        form, _ = found.solids.form(i)
        if form is CONE:
            continue
        scene[f"g{i}"] = {"type": "shapegroup", **groups[form]}
        pose = transform(np.concatenate([found.solids.matrices[i], [[0, 0, 0, 1]]]))
        scene[f"i{i}"] = {"type": "instance", "id": f"i{i}", "g": {"type": "ref", "id": f"g{i}"}, "to_world": pose}
    loaded = mi.load_dict(scene)
    camera = found.camera
    height, width = found.instance.shape
    who, depth, normal = np.full((height, width), -1), np.full((height, width), np.inf), np.zeros((height, width, 3))
    (fx, fy), (cx, cy) = camera.focal, camera.principal
    for row in range(height):
        for column in range(width):
            direction = camera.forward + (column + 0.5 - cx) / fx * camera.right - (row + 0.5 - cy) / fy * camera.up
            ray = mi.Ray3f(mi.Point3f(*camera.eye), mi.Vector3f(*direction))
            hit = loaded.ray_intersect(ray)
            if hit.is_valid():
                who[row, column] = int(hit.instance.id()[1:]) if hit.instance else -1
                depth[row, column], normal[row, column] = hit.t, hit.n
    return who, depth, normal


def test_instances_depth_and_normals_agree_with_an_independent_ray_caster() -> None:
    text = TABLE.replace(
        '(transform (call "cone" :radius .3 :p1 [0 .8 0])', '(transform (call "cylinder" :radius .3 :p1 [0 .8 0])'
    )
    found = truth(evaluate(text), Viewpoint(40, 15), (120, 90))
    who, depth, normal = mitsuba_hits(found)
    expected = np.where(who >= 0, found.ancestry.primitives[found.solids.instance[np.maximum(who, 0)]], -1)
    same = found.instance == expected
    assert same.mean() > 0.9995  # a pixel center may lie on an edge
    both = same & found.seen
    assert both.sum() > 1500
    assert found.depth[both] == pytest.approx(depth[both], rel=2e-5)
    cosine = np.abs((found.normal * normal).sum(axis=2))[both]
    assert (cosine > 0.999).mean() > 0.998


def test_what_is_hidden_is_not_seen(table: Scene) -> None:
    found = truth(table, Viewpoint(0, 0))
    boxes = boxes_in(found)
    words = [found.ancestry.entity(i).word for i in range(len(found.ancestry))]
    statue = words.index("statue")
    assert 0 < boxes.area[statue] < np.prod(boxes.full[statue, 2:] - boxes.full[statue, :2])
    assert boxes.area[0] == found.seen.sum()
    for i in range(len(words)):
        if boxes.area[i]:
            assert (boxes.visible[i, :2] >= np.floor(boxes.full[i, :2] - 0.5)).all()
            assert (boxes.visible[i, 2:] <= np.ceil(boxes.full[i, 2:] + 0.5)).all()


@pytest.mark.parametrize("view", [Viewpoint(25, 30), PRESETS["isometric"], Viewpoint(fov=110)])
def test_full_boxes_are_tight(table: Scene, view: Viewpoint) -> None:
    """Against dense points of each solid's surface, projected one by one."""
    found = truth(table, view)
    random = np.random.default_rng(1)
    direction = random.normal(size=(20_000, 3))
    ball = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    angle = random.uniform(0, 2 * math.pi, 20_000)
    rim = np.stack([np.cos(angle), np.where(np.arange(20_000) % 2, 1.0, -1.0), np.sin(angle)], axis=1)
    cone = np.where(rim[:, 1:2] > 0, [0.0, 1.0, 0.0], rim)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    points = {BALL: ball, BLOCK: corners, CYLINDER: rim, CONE: cone}
    exact = rectangles_of(found.solids, found.camera)
    for i in range(len(found.solids)):
        matrix = found.solids.matrices[i]
        world = points[found.solids.form(i)[0]] @ matrix[:, :3].T + matrix[:, 3]
        pixels, _ = found.camera.project(world)
        dense = [*pixels.min(axis=0), *pixels.max(axis=0)]
        assert exact[i] == pytest.approx(dense, abs=0.35)
        assert (exact[i, :2] <= pixels.min(axis=0) + 1e-6).all()
        assert (exact[i, 2:] >= pixels.max(axis=0) - 1e-6).all()


def test_every_level_of_the_hierarchy_covers_the_same_pixels(table: Scene) -> None:
    found = truth(table)
    for depth in range(found.ancestry.max_depth + 1):
        level = found.at_depth(depth)
        assert ((level >= 0) == found.seen).all()
        assert (found.ancestry.depth[level[found.seen]] <= depth).all()
    assert set(np.unique(found.at_depth(0))) == {-1, 0}
    words = {found.ancestry.entity(i).word for i in np.unique(found.at_depth(1)) if i >= 0}
    assert words == {"table", "fruit", "cone", "statue"}


def test_equal_places_of_repeated_instances_correspond(table: Scene) -> None:
    found = truth(table)
    matched = correspondence_of(found)
    units = [i for i in np.unique(matched.unit) if i >= 0]
    assert {found.ancestry.entity(i).word for i in units} == {"leg", "fruit", "cube"} - {"cube"}
    low, high = boxes_of(found.ancestry, np.array(units))
    for k, unit in enumerate(units):
        rows = matched.unit == unit
        local = into_local(found.position[rows], found.ancestry.poses[unit][None], np.zeros(rows.sum(), int))
        assert matched.place[rows] == pytest.approx((local - low[k]) / (high[k] - low[k]), abs=1e-5)


def test_coco_counts_are_those_of_count(table: Scene) -> None:
    """A scene in which everything is visible, there and back through pycocotools."""
    pycocotools = pytest.importorskip("pycocotools.coco")
    text = (
        '(bind "row" (lambda () (row (for/list ((i (iota 5))) (call "pair" :i i)) :gap .3)))'
        '(bind "pair" (lambda (:i) (union (call "sphere" :radius .3) (transform (call "cone" :radius .2 :p1 [0 .5 0]) (translate [0 .5 0])))))'
    )
    scene = evaluate(text)
    found = truth(scene, Viewpoint(0, 10))
    boxes = boxes_in(found)
    annotations = annotations_of(found, boxes, instance_handles(scene, found.ancestry), 1000)
    document = dataset([{"file_name": "a.png", "width": 160, "height": 120}], [annotations])
    coco = pycocotools.COCO()
    coco.dataset = json.loads(json.dumps(document))
    coco.createIndex()
    names = {category["id"]: category["name"] for category in coco.loadCats(coco.getCatIds())}
    counts: dict[str, int] = {}
    for annotation in coco.loadAnns(coco.getAnnIds()):
        counts[names[annotation["category_id"]]] = counts.get(names[annotation["category_id"]], 0) + 1
        mask = coco.annToMask(annotation).astype(bool)
        assert (mask == (found.at_depth(annotation["depth"]) == annotation["instance"])).all()
        assert mask.sum() == annotation["area"]
        rows, columns = np.nonzero(mask)
        assert annotation["bbox"] == [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
    assert counts == count_words(scene.root)


SWING = """
(bind "ball" (lambda (:x) (transform (call "sphere" :radius .4 :color [.8 .1 .1]) (translate [x 1 0]))))
(bind "film" (lambda () (frames (for/list ((i (iota 4)))
  (union (call "cube" :scale [3 .2 1])
         (transform (call "ball" :x (- (* .5 i) .75)) (rotate (* .1 i) [0 0 1]))
         (if (< i 2) (transform (call "cone" :radius .2) (translate [0 0 1])) (union)))))))
"""


def test_flow_is_where_the_same_place_is_in_the_next_frame() -> None:
    scene = evaluate(SWING)
    shots = film(scene, Viewpoint(20, 20), 120, 90, None, None)
    truths = [truth_of(scene, shot, 1000, *unit_size(scene)) for shot in shots]
    numbers = ground_truth.PathNumbers()
    paths = [numbers.of(one.ancestry) for one in truths]
    flow = ground_truth.flow_between(truths[0], truths[1], paths[0], paths[1])
    words = np.array([entity.word for entity in truths[0].ancestry.nodes])
    seen = np.where(truths[0].seen, words[truths[0].ancestry.node[np.maximum(truths[0].instance, 0)]], "")
    assert np.abs(flow.motion[seen == "cube"]).max() < 1e-4
    assert np.nanmean(flow.motion[seen == "sphere"][:, 0]) > 5
    # what is visible shows the same place there: the same path, and the same local coordinates
    visible = np.flatnonzero((flow.state == ground_truth.VISIBLE).reshape(-1) & (seen == "sphere").reshape(-1))
    places = ground_truth.places_of(truths[0], paths[0], visible)
    row, column = np.divmod(visible, 120)
    there = flow.motion.reshape(-1, 2)[visible] + np.stack([column, row], axis=1) + 0.5
    target = np.floor(there).astype(int)
    landed = target[:, 1] * 120 + target[:, 0]
    hit = truths[1].instance.reshape(-1)[landed] >= 0
    again = ground_truth.places_of(truths[1], paths[1], landed[hit])
    same = again.path == places.path[hit]
    assert same.mean() > 0.95
    assert np.linalg.norm(again.local - places.local[hit], axis=1)[same].mean() < 0.05
    gone = ground_truth.flow_between(truths[1], truths[2], paths[1], paths[2])
    cone = np.where(truths[1].seen, words[truths[1].ancestry.node[np.maximum(truths[1].instance, 0)]], "") == "cone"
    assert cone.any()
    assert (gone.state[cone] == ground_truth.GONE).all()
    assert np.isnan(gone.motion[cone]).all()


def test_tracks_follow_points_and_know_when_they_are_hidden() -> None:
    scene = evaluate(
        '(bind "film" (lambda () (frames (for/list ((i (iota 3)))'
        ' (union (call "sphere" :radius .2) (transform (call "cube") (translate [(- i 1) 0 (if (= i 1) 1 -3)])))))))'
    )
    shots = film(scene, Viewpoint(0, 0), 100, 100, None, None)
    truths = [truth_of(scene, shot, 1000, *unit_size(scene)) for shot in shots]
    numbers = ground_truth.PathNumbers()
    paths = [numbers.of(one.ancestry) for one in truths]
    words = np.array([entity.word for entity in truths[0].ancestry.nodes])
    ball = np.flatnonzero(
        (truths[0].seen & (words[truths[0].ancestry.node[np.maximum(truths[0].instance, 0)]] == "sphere")).reshape(-1)
    )
    places = ground_truth.places_of(truths[0], paths[0], ball)
    tracks = ground_truth.tracks_of([ground_truth.locate(places, one, path) for one, path in zip(truths, paths)])
    assert tracks.pixels[0] == pytest.approx(tracks.pixels[2])
    assert (tracks.state[0] == ground_truth.VISIBLE).all()
    assert (tracks.state[1] == ground_truth.HIDDEN).all()
    assert (tracks.state[2] == ground_truth.VISIBLE).all()


# --- the command -----------------------------------------------------------------------------------------------


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_the_command_writes_a_complete_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.scene").write_text(TABLE)
    out = tmp_path / "out"
    assert main(["labels", str(tmp_path / "a.scene"), "-o", str(out), "--size", "64x48"]) == 0
    found = files(out)
    names = ["color", "semantic", "instances", "correspondence", "depth", "normals", "albedo", "boxes", "legend"]
    assert {f"{name}.png" for name in names} <= found
    assert {"maps.npz", "maps.exr", "coco.json", "camera.json", "legend.json", "annotations.json", "shot.json"} <= found
    assert {f"semantic-depth-{d}.png" for d in range(4)} <= found
    arrays = np.load(out / "maps.npz")
    assert arrays["depth"].shape == (48, 64)
    assert arrays["normal"].shape == arrays["albedo"].shape == arrays["position"].shape == (48, 64, 3)
    assert ((arrays["instance"] >= 0) == np.isfinite(arrays["depth"])).all()
    legend = json.loads((out / "legend.json").read_text())
    words = {row["id"]: row["word"] for row in legend["words"]}
    by_instance = {row["id"]: row["word"] for row in legend["instances"]}
    for instance, word in zip(arrays["instance"].ravel(), arrays["semantic"].ravel()):
        assert (instance < 0 and word == 0) or by_instance[instance] == words[word]
    bodies = {word: {row["body"] for row in legend["instances"] if row["word"] == word} for word in ("leg", "table")}
    assert len(bodies["table"]) == 1
    assert bodies["leg"] == bodies["table"] != {-1}  # one object, its parts included
    assert {row["body"] for row in legend["instances"] if row["word"] == "scene"} == {-1}
    # the camera that was written gives the same picture again
    again = tmp_path / "again"
    assert main(["labels", str(tmp_path / "a.scene"), "-o", str(again), "--camera", str(out / "camera.json")]) == 0
    assert (np.load(again / "maps.npz")["instance"] == arrays["instance"]).all()


def test_exr_layers_are_the_arrays(tmp_path: Path) -> None:
    import mitsuba as mi

    (tmp_path / "a.scene").write_text(TABLE)
    assert main(["labels", str(tmp_path / "a.scene"), "-o", str(tmp_path), "--size", "32x24"]) == 0
    layers = dict(mi.Bitmap(str(tmp_path / "maps.exr")).split())
    arrays = np.load(tmp_path / "maps.npz")
    depth = np.array(layers["depth"]).reshape(24, 32)
    seen = np.isfinite(arrays["depth"])
    assert depth[seen] == pytest.approx(arrays["depth"][seen], rel=1e-6)
    normals = np.array(layers["normal"]).reshape(24, 32, 3)
    assert normals == pytest.approx(arrays["normal"])


def test_a_set_goes_on_where_it_stopped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, text in (("a", TABLE), ("b", SWING)):
        (tmp_path / f"{name}.scene").write_text(text)
    out = tmp_path / "set"
    command = [
        "labels",
        str(tmp_path / "a.scene"),
        str(tmp_path / "b.scene"),
        "-o",
        str(out),
        "--views",
        "2",
        "--size",
        "32x24",
    ]
    assert main(command) == 0
    shots = sorted(path.parent.relative_to(out).as_posix() for path in out.rglob("shot.json"))
    assert shots == [
        *(f"a/camera-00{v}" for v in (0, 1)),
        *(f"b/camera-00{v}/frame-00{f}" for v in (0, 1) for f in range(4)),
    ]
    assert (out / "b/camera-001/tracks.npz").exists()
    document = json.loads((out / "coco.json").read_text())
    assert len(document["images"]) == 10
    cameras = [json.dumps(image["camera"]["world_to_camera"]) for image in document["images"]]
    assert len(set(cameras)) == 4  # random, and the same for all frames of one film
    kept = out / "b/camera-000/frame-001/color.png"
    stamp = kept.stat().st_mtime_ns
    (out / "b/camera-001/frame-002/shot.json").unlink()
    capsys.readouterr()
    assert main(command) == 0
    assert capsys.readouterr().err.count("already exists") == 9
    assert kept.stat().st_mtime_ns == stamp
    assert json.loads((out / "coco.json").read_text()) == document
    assert main([*command, "--seed", "5", "-q"]) == 0  # other cameras: all is made anew
    assert kept.stat().st_mtime_ns != stamp


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["--views", "0"], 2, "--views"),
        (["--views", "2", "--camera", "top", "--camera", "isometric"], 2, "at most one viewpoint"),
        (["--camera", "nowhere.json"], 2, "nowhere.json"),
        (["--frame", "3"], 1, "frame 3 does not exist"),
        (["--size", "9000x9000"], 2, "8192"),
    ],
)
def test_wrong_uses_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], code: int, said: str
) -> None:
    (tmp_path / "a.scene").write_text(TABLE)
    assert main(["labels", str(tmp_path / "a.scene"), "-o", str(tmp_path / "out"), *arguments]) == code
    assert said in capsys.readouterr().err
    assert not list((tmp_path / "out").rglob("*.png")) if (tmp_path / "out").exists() else True


def test_an_empty_scene_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.scene").write_text('(bind "nothing" (lambda () (union)))')
    assert main(["labels", str(tmp_path / "a.scene"), "-o", str(tmp_path / "out")]) == 1
    assert "has no primitives" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    (tmp_path / "file").write_text("")
    assert main(["labels", str(tmp_path / "a.scene"), "-o", str(tmp_path / "file" / "x")]) == 1


@pytest.mark.parametrize("text", [TABLE, SWING])
def test_handles_of_primitives_are_those_of_flatten(text: str) -> None:
    scene = evaluate(text)
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    for root, wanted in zip(scene.frames, primitive_handles(scene, flatten(scene))):
        ancestry = ancestry_of(root)
        handles = instance_handles(scene, ancestry, numbers)
        assert [handles[i] for i in ancestry.primitives] == list(wanted)
        assert handles[0] == "z1"
