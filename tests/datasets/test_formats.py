"""Formats: each is read back by the library that people use for it, or checked against its documented schema."""

from __future__ import annotations

import io
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from scenelang.datasets.making import decoded
from scenelang.datasets.running import dataset, verify_dataset
from scenelang.datasets.store import Store, items_of


def items(folder: Path) -> Iterator[tuple[str, dict[str, Any], dict[str, bytes]]]:
    """Keys, records and files of a dataset."""
    for path in sorted(folder.glob("*-*.tar")):
        for key, files in items_of(Store(folder), path.name):
            yield key, json.loads(files["json"]), files


# --- shards ----------------------------------------------------------------------------------------------------------


def test_webdataset_reads_the_shards(made: Path) -> None:
    import webdataset

    urls = [str(path) for path in sorted(made.glob("train-*.tar"))]
    found = list(webdataset.WebDataset(urls, shardshuffle=False).decode("rgb8"))
    assert len(found) == sum(record["split"] == "train" for _, record, _ in items(made))
    sample = found[0]
    assert sample["color.png"].shape == (36, 48, 3)
    assert sample["depth.npy"].dtype == np.float32
    assert sample["json"]["key"] == sample["__key__"]
    assert isinstance(sample["txt"], str)


def test_torch_loads_webdataset_in_batches(made: Path) -> None:
    import webdataset

    torch = pytest.importorskip("torch")

    urls = [str(path) for path in sorted(made.glob("train-*.tar"))]
    reader = webdataset.WebDataset(urls, shardshuffle=False).decode("torchrgb").to_tuple("color.png", "depth.npy")
    pictures, depths = next(iter(torch.utils.data.DataLoader(reader, batch_size=2)))
    assert pictures.shape == (2, 3, 36, 48)
    assert depths.shape == (2, 36, 48)


@pytest.mark.slow
def test_datasets_reads_parquet(folder: Path, made: Path, tmp_path: Path) -> None:
    import datasets

    spec = folder / "parquet.toml"
    spec.write_text((folder / "spec.toml").read_text() + 'formats = "parquet"\n')
    dataset(spec, tmp_path / "out", jobs=0)
    assert verify_dataset(tmp_path / "out") == []
    dataset(spec, tmp_path / "two", jobs=2)
    for path in (tmp_path / "out").glob("*.parquet"):
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()
    read = datasets.load_dataset(str(tmp_path / "out"), cache_dir=str(tmp_path / "cache"))
    assert set(read) == {"train", "test"}
    assert len(read["train"]) + len(read["test"]) == 10
    by_key = {row["__key__"]: row for split in read.values() for row in split}
    for key, record, files in items(made):
        row = by_key[key]
        assert json.loads(row["json"]) == record
        assert (np.asarray(row["color_png"]) == decoded("color.png", files["color.png"])).all()
        assert (np.asarray(row["instance_png"]) == decoded("instance.png", files["instance.png"])).all()
        assert row["depth_npy"] == files["depth.npy"]
        assert row["txt"] == files["txt"].decode()


def test_the_card_describes_the_dataset(made: Path) -> None:
    text = (made / "README.md").read_text()
    head, _, body = text.removeprefix("---\n").partition("\n---\n")
    assert 'path: "train-*.tar"' in head
    assert "| samples | 10 of 10 |" in body
    assert "| param.balls | 1 to 4, mean" in body
    assert 'programs = ["room.scene"]' in body
    for _, record, _ in items(made):
        assert record["spec"] in body


@pytest.mark.parametrize(
    "licence",
    ["cc-by-4.0", 'see "terms": #1', "no", "1.0", "a\nlicense: mit", "[x, {y}]", "\\n\t\x85\u2028 ü 🙂", "- x", ""],
)
def test_any_licence_is_one_text_of_the_card(made: Path, licence: str) -> None:
    from dataclasses import replace

    import yaml

    from scenelang.datasets.describing import card_of
    from scenelang.datasets.store import read_plan, records_of

    store = Store(made)
    plan = read_plan(store)
    assert plan is not None
    text = card_of(replace(plan, licence=licence), list(records_of(store, plan)), "0" * 64)
    head = yaml.safe_load(text.removeprefix("---\n").partition("\n---\n")[0])
    assert head["license"] == (licence or "unknown")
    assert [each["split"] for each in head["configs"][0]["data_files"]] == ["test", "train"]


# --- COCO ------------------------------------------------------------------------------------------------------------


def test_pycocotools_reads_instances(layouts: Path) -> None:
    from pycocotools.coco import COCO

    found = COCO(str(layouts / "coco" / "annotations" / "instances_train.json"))
    names = {each["name"] for each in found.loadCats(found.getCatIds())}
    assert names >= {"ball", "stool", "leg", "room"}
    files = {image["file_name"].removesuffix(".png"): image["id"] for image in found.loadImgs(found.getImgIds())}
    for key, record, own in items(layouts):
        ids = decoded("instance.png", own["instance.png"])
        parent = {thing["id"]: thing["parent"] for thing in record["things"]}
        annotations = found.loadAnns(found.getAnnIds(imgIds=files[key]))
        by_handle = {each["handle"]: each for each in annotations}
        for thing in record["things"]:
            whole = np.isin(ids, [i for i in parent if thing["id"] in _line(i, parent)])
            if not whole.any() or not thing["depth"]:
                assert thing["handle"] not in by_handle  # the whole scene is no object
                continue
            annotation = by_handle[thing["handle"]]
            assert (found.annToMask(annotation) == whole).all()
            assert annotation["area"] == whole.sum() == thing["area"]
            assert annotation["bbox"] == thing["bbox"]
        assert (layouts / "coco" / "train" / f"{key}.png").read_bytes() == own["color.png"]


def _line(number: int, parent: dict[int, int]) -> list[int]:
    """A thing and all that it is part of."""
    found = [number]
    while parent[found[-1]]:
        found.append(parent[found[-1]])
    return found


def test_panoptic_segments_are_those_of_the_schema(layouts: Path) -> None:
    folder = layouts / "coco" / "annotations"
    document = json.loads((folder / "panoptic_train.json").read_text())
    categories = {each["id"] for each in document["categories"]}
    assert all(set(each) >= {"id", "name", "supercategory", "isthing"} for each in document["categories"])
    images = {image["id"]: image for image in document["images"]}
    assert len(document["annotations"]) == len(images) == 12
    for annotation in document["annotations"]:
        with Image.open(folder / "panoptic_train" / annotation["file_name"]) as picture:
            colors = np.asarray(picture, np.int64)
        ids = colors[:, :, 0] + 256 * colors[:, :, 1] + 256**2 * colors[:, :, 2]
        assert ids.shape == (images[annotation["image_id"]]["height"], images[annotation["image_id"]]["width"])
        segments = {segment["id"]: segment for segment in annotation["segments_info"]}
        assert set(segments) == set(np.unique(ids[ids > 0]).tolist())
        for number, segment in segments.items():
            assert segment["area"] == (ids == number).sum()
            assert segment["category_id"] in categories
            assert segment["iscrowd"] == 0


# --- boxes and poses -------------------------------------------------------------------------------------------------


def test_kitti_boxes_project_onto_the_things(layouts: Path) -> None:
    folder = layouts / "kitti" / "train"
    checked = 0
    for key, record, _ in items(layouts):
        calibration = dict(line.split(": ") for line in (folder / "calib" / f"{key}.txt").read_text().splitlines())
        projection = np.array(calibration["P2"].split(), float).reshape(3, 4)
        lines = (folder / "label_2" / f"{key}.txt").read_text().splitlines()
        things = [
            each for each in record["things"] if each["depth"] and each["area"] and each["truncation"] is not None
        ]
        assert len(lines) == len(things)
        for line, thing in zip(lines, things, strict=True):
            word, *values = line.split(" ")
            assert len(values) == 14
            truncated, occluded, _, *box = map(float, values[:7])
            assert word == thing["word"]
            assert 0.0 <= truncated <= 1.0
            assert occluded in (0.0, 1.0, 2.0)
            assert box == [thing["bbox"][0], thing["bbox"][1], thing["bbox"][0] + thing["bbox"][2] - 1, thing["bbox"][1] + thing["bbox"][3] - 1]  # fmt: skip
            height, width, length, x, y, z, yaw = map(float, values[7:])
            corners = np.array([[long, h, w] for long in (-length / 2, length / 2) for h in (0, -height) for w in (-width / 2, width / 2)])  # fmt: skip
            turn = np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
            level = corners @ turn.T + [x, y, z]
            pixels = np.hstack([level, np.ones((8, 1))]) @ projection.T
            pixels = pixels[:, :2] / pixels[:, 2:] + 0.5  # KITTI counts from the center of the first pixel
            full = np.array(thing["bbox_full"])
            # the box holds the thing, so its projection holds the thing's; a tight one for boxes
            assert (pixels.min(axis=0) <= full[:2] + 0.01).all()
            assert (pixels.max(axis=0) >= full[:2] + full[2:] - 0.01).all()
            if thing["word"] == "leg":
                assert np.allclose(pixels.min(axis=0), full[:2], atol=0.02)
                assert np.allclose(pixels.max(axis=0), full[:2] + full[2:], atol=0.02)
                checked += 1
    assert checked > 10


def test_bop_scenes_follow_the_schema(layouts: Path) -> None:
    """bop_toolkit's documented layout (docs/bop_datasets_format.md)."""
    records = {}
    for key, record, files in items(layouts):
        records[int(record["sample"]), record["view"]] = key, record, files
    folder = layouts / "bop" / "train"
    assert [path.name for path in sorted(folder.iterdir())] == [f"{i:06d}" for i in range(4)]
    for scene in range(4):
        own = folder / f"{scene:06d}"
        cameras, poses, infos = (
            json.loads((own / f"scene_{name}.json").read_text()) for name in ("camera", "gt", "gt_info")
        )
        assert set(cameras) == set(poses) == set(infos) == {"0", "1", "2"}
        for number in range(3):
            _, record, files = records[scene, number]
            camera = cameras[str(number)]
            depth = decoded("depth.npy", files["depth.npy"])
            with Image.open(own / "depth" / f"{number:06d}.png") as picture:
                found = np.asarray(picture) * camera["depth_scale"] / 1000.0
            assert np.abs(np.where(np.isfinite(depth), depth, 0) - found).max() <= camera["depth_scale"] / 1000.0
            world = np.array(camera["cam_R_w2c"]).reshape(3, 3), np.array(camera["cam_t_w2c"]) / 1000.0
            things = [thing for thing in record["things"] if thing["depth"]]
            assert len(poses[str(number)]) == len(infos[str(number)]) == len(things)
            for k, (pose, info, thing) in enumerate(zip(poses[str(number)], infos[str(number)], things, strict=True)):
                rotation = np.array(pose["cam_R_m2c"]).reshape(3, 3)
                assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
                assert np.linalg.det(rotation) == pytest.approx(1.0)
                center = world[0] @ np.array(thing["box3d"]["center"]) + world[1]
                assert np.allclose(np.array(pose["cam_t_m2c"]) / 1000.0, center)
                assert pose["obj_id"] == thing["class"]
                assert info["px_count_visib"] == thing["area"] <= info["px_count_all"]
                assert info["visib_fract"] == pytest.approx(thing["area"] / max(1, info["px_count_all"]))
                with Image.open(own / "mask_visib" / f"{number:06d}_{k:06d}.png") as mask:
                    assert (np.asarray(mask) == 255).sum() == thing["area"]
    models = json.loads((layouts / "bop" / "models" / "models_info.json").read_text())
    names = json.loads((layouts / "bop" / "classes.json").read_text())
    ball = next(models[number] for number, word in names.items() if word == "ball")
    assert ball["size_x"] == pytest.approx(600.0)


# --- several views ---------------------------------------------------------------------------------------------------


def test_nerfstudio_views_agree_on_the_scene(layouts: Path) -> None:
    """Points of one view, from its depth and its OpenGL camera, have the depth that the others say."""
    samples = sorted((layouts / "nerfstudio").iterdir())
    assert [path.name for path in samples] == [f"{i:09d}" for i in range(4)]
    for sample in samples:
        document = json.loads((sample / "transforms.json").read_text())
        assert {"camera_model", "fl_x", "fl_y", "cx", "cy", "w", "h", "frames"} <= set(document)
        views = []
        for frame in document["frames"]:
            with Image.open(sample / frame["file_path"]) as picture:
                assert picture.size == (frame["w"], frame["h"])
            views.append((frame, np.load(sample / frame["depth_file_path"]) * document["depth_unit_scale_factor"]))
        frame, depth = views[0]
        rows, columns = np.nonzero(depth)
        d = depth[rows, columns]
        local = np.stack([(columns + 0.5 - frame["cx"]) / frame["fl_x"] * d, -(rows + 0.5 - frame["cy"]) / frame["fl_y"] * d, -d], axis=1)  # fmt: skip
        pose = np.array(frame["transform_matrix"])
        world = local @ pose[:3, :3].T + pose[:3, 3]
        for other, there in views[1:]:
            inverse = np.linalg.inv(np.array(other["transform_matrix"]))
            local = world @ inverse[:3, :3].T + inverse[:3, 3]
            x = other["fl_x"] * local[:, 0] / -local[:, 2] + other["cx"]
            y = -other["fl_y"] * local[:, 1] / -local[:, 2] + other["cy"]
            inside = (x > 0) & (x < other["w"]) & (y > 0) & (y < other["h"])
            seen = there[y[inside].astype(int), x[inside].astype(int)]
            same = np.abs(seen - -local[inside, 2]) < 0.05
            assert same.mean() > 0.3
            assert ((seen == 0) | same | (seen < -local[inside, 2] + 0.3)).mean() > 0.95  # what is not seen is behind


def test_pycolmap_reads_the_models(layouts: Path) -> None:
    import pycolmap

    for sample in sorted((layouts / "colmap").iterdir()):
        model = pycolmap.Reconstruction(str(sample / "sparse" / "0"))
        assert (model.num_cameras(), model.num_images()) == (3, 3)
        assert model.num_points3D() > 500
        assert model.compute_mean_track_length() > 1.3
        assert model.compute_mean_reprojection_error() < 1e-3
        for number, image in model.images.items():
            camera = model.cameras[image.camera_id]
            assert camera.model.name == "PINHOLE"
            for point in image.points2D[:50]:
                world = model.points3D[point.point3D_id].xyz
                projected = image.project_point(world)
                assert np.allclose(projected, point.xy, atol=1e-6), number


# --- films -----------------------------------------------------------------------------------------------------------


def test_trackeval_scores_the_truth_with_one(films: Path, tmp_path: Path) -> None:
    import shutil

    import trackeval

    results = tmp_path / "trackers" / "exact" / "data"
    results.mkdir(parents=True)
    sequences = sorted(path for path in (films / "mot" / "train").iterdir() if path.is_dir())
    for sequence in sequences:
        lines = [line.split(",") for line in (sequence / "gt" / "gt.txt").read_text().splitlines()]
        text = "".join(",".join([*line[:6], "1", "-1", "-1", "-1"]) + "\n" for line in lines)
        (results / f"{sequence.name}.txt").write_text(text)
    config = {
        "GT_FOLDER": str(films / "mot" / "train"), "TRACKERS_FOLDER": str(tmp_path / "trackers"),
        "SEQMAP_FILE": str(films / "mot" / "seqmaps" / "train.txt"), "SKIP_SPLIT_FOL": True, "PRINT_CONFIG": False,
        "TRACKERS_TO_EVAL": ["exact"],
    }  # fmt: skip
    source = trackeval.datasets.MotChallenge2DBox(config)
    quiet = {"PRINT_RESULTS": False, "PRINT_CONFIG": False, "OUTPUT_SUMMARY": False, "OUTPUT_DETAILED": False, "PLOT_CURVES": False, "TIME_PROGRESS": False, "LOG_ON_ERROR": None}  # fmt: skip
    evaluator = trackeval.Evaluator({**trackeval.Evaluator.get_default_eval_config(), **quiet})
    scores, _ = evaluator.evaluate([source], [trackeval.metrics.CLEAR({"PRINT_CONFIG": False})])
    found = scores["MotChallenge2DBox"]["exact"]["COMBINED_SEQ"]["pedestrian"]["CLEAR"]
    assert found["MOTA"] == 1.0
    assert found["IDSW"] == 0
    assert found["CLR_TP"] == 2 * 4 * 3  # two sequences of four frames with a wheel and two cubes
    shutil.rmtree(tmp_path / "trackers")


def test_tap_tracks_stay_on_their_things(films: Path) -> None:
    files = {key: (record, own) for key, record, own in items(films)}
    found = sorted((films / "tap" / "train").glob("*.npz"))
    assert len(found) == 2
    for path in found:
        with np.load(path) as tracks:
            video, points, occluded = tracks["video"], tracks["points"], tracks["occluded"]
        assert video.shape == (4, 48, 64, 3)
        assert points.shape == (16, 4, 2)
        assert occluded.shape == (16, 4)
        assert occluded.mean() < 0.5
        assert not occluded[:, 0].any()
        shown: list[set[str]] = [set() for _ in points]
        for frame in range(4):
            record, own = files[f"{path.stem}-f{frame:04d}"]
            assert (video[frame] == decoded("color.png", own["color.png"])).all()
            ids = decoded("instance.png", own["instance.png"])
            handles = {thing["id"]: json.dumps(thing["path"]) for thing in record["things"]}
            for k in np.flatnonzero(~occluded[:, frame]):
                x, y = (points[k, frame] * [64, 48]).astype(int)
                near = ids[max(0, y - 1) : y + 2, max(0, x - 1) : x + 2]
                shown[k] |= {handles.get(int(number), "") for number in np.unique(near)}
        assert all(shown)
    record, own = files["000000000-f0000"]
    flow = np.load(io.BytesIO(own["flow.npy"]))
    moving = np.isfinite(flow[:, :, 0])
    wheel = next(thing["id"] for thing in record["things"] if thing["word"] == "wheel")
    ids = decoded("instance.png", own["instance.png"])
    assert np.abs(flow[moving & (ids == wheel)]).mean() > 2.0
    assert np.abs(flow[moving & (ids != wheel)]).mean() < 1.0


# --- what a format cannot say by itself ------------------------------------------------------------------------------

COMPUTED = (
    '(bind "room" (lambda () (union (call "ball") (transform (call (string-append "o" "dd")) (translate [2 0 0])))))\n'
    '(bind "ball" (lambda () (call "sphere")))\n(bind (string-append "o" "dd") (lambda () (call "cube")))'
)
PASSING = (
    '(bind "wall" (lambda () (transform (call "cube" :scale [2 2 .1]) (translate [0 0 1]))))\n'
    '(bind "ball" (lambda () (call "sphere" :radius .3)))\n'
    '(bind "film" (lambda () (frames (for/list ((x [-2 0 2])) (union (call "wall") (transform (call "ball") (translate [x 0 0])))))))'
)


def _made(tmp_path: Path, program: str, spec: str) -> Path:
    from scenelang.datasets.running import dataset

    (tmp_path / "a.scene").write_text(program)
    (tmp_path / "spec.toml").write_text(f"programs = 'a.scene'\n{spec}")
    dataset(tmp_path / "spec.toml", tmp_path / "out", jobs=0)
    return tmp_path / "out"


def test_words_outside_of_the_classes_have_categories(tmp_path: Path) -> None:
    spec = "count = 1\nroot = 'room'\n[pictures]\nsize = 32\n[cameras]\nazimuth = 0\nelevation = 20\n"
    spec += "[labels]\nwrite = ['instance', 'depth', 'boxes', 'visibility']\n[output]\nformats = ['coco', 'bop']"
    out = _made(tmp_path, COMPUTED, spec)
    for name in ("instances_train", "panoptic_train"):
        document = json.loads((out / "coco" / "annotations" / f"{name}.json").read_text())
        numbers = {each["name"]: each["id"] for each in document["categories"]}
        assert numbers["odd"] == max(numbers.values()) < 100
        used = {
            each["category_id"] for one in document["annotations"] for each in one.get("segments_info", [one])
        }  # fmt: skip
        assert numbers["odd"] in used <= set(numbers.values())
    classes = json.loads((out / "bop" / "classes.json").read_text())
    truth = json.loads((out / "bop" / "train" / "000000" / "scene_gt.json").read_text())
    assert {classes[str(each["obj_id"])] for each in truth["0"]} == {"ball", "odd"}
    assert set(json.loads((out / "bop" / "models" / "models_info.json").read_text())) <= set(classes)


WALLED = (
    '(bind "wall" (lambda () (call "cube" :scale [9 9 .1])))\n'
    '(bind "yard" (lambda () (union (transform (call "wall") (translate [0 0 -9])) (call "cube" :scale .5))))'
)


@pytest.mark.parametrize(
    ("program", "root", "words", "azimuth", "found"),
    [
        (WALLED, "yard", "", 0, {"wall"}),
        (WALLED, "yard", "words = ['yard']", 0, {"yard"}),
        (WALLED, "yard", "words = ['yard', 'wall']", 0, {"yard", "wall"}),
        (WALLED, "yard", "", "close", set()),  # the wall is not seen
        (WALLED, "wall", "", 0, {"wall"}),  # the scene has no other thing
    ],
)
def test_the_whole_scene_is_an_object_if_it_is_named_or_alone(
    program: str, root: str, words: str, azimuth: int | str, found: set[str], tmp_path: Path
) -> None:
    cameras = "distance = 0.6\nelevation = 0" if azimuth == "close" else "distance = 12\nelevation = 10"
    spec = f"count = 1\nroot = '{root}'\n[pictures]\nsize = 32\n[cameras]\nazimuth = 0\ntarget = [0, 0, 0]\n{cameras}\n"
    spec += f"[labels]\nwrite = ['instance', 'depth', 'boxes', 'visibility']\n{words}\n"
    spec += "[output]\nformats = ['coco', 'kitti', 'bop', 'mot']"
    out = _made(tmp_path, program, spec)
    for name in ("instances", "panoptic"):
        document = json.loads((out / "coco" / "annotations" / f"{name}_train.json").read_text())
        names = {each["id"]: each["name"] for each in document["categories"]}
        told = [one for each in document["annotations"] for one in each.get("segments_info", [each])]
        assert {names[each["category_id"]] for each in told} == found
    lines = (out / "kitti" / "train" / "label_2" / "000000000.txt").read_text().splitlines()
    assert {line.split()[0] for line in lines} == found
    classes = json.loads((out / "bop" / "classes.json").read_text())
    (truth,) = json.loads((out / "bop" / "train" / "000000" / "scene_gt.json").read_text()).values()
    assert {classes[str(each["obj_id"])] for each in truth} == found
    assert set(json.loads((out / "mot/train/000000000/gt/words.json").read_text()).values()) == found


def test_hidden_things_stay_in_their_films(tmp_path: Path) -> None:
    spec = "count = 1\nroot = 'film'\n[pictures]\nsize = 64\n[cameras]\nazimuth = 0\nelevation = 0\ndistance = 9\ntarget = [0, 0, 0]\n"
    spec += (
        "[labels]\nwrite = ['instance', 'boxes', 'visibility']\nwords = ['ball', 'wall']\n[output]\nformats = ['mot']"
    )
    own = _made(tmp_path, PASSING, spec) / "mot" / "train" / "000000000" / "gt"
    words = json.loads((own / "words.json").read_text())
    (ball,) = (int(number) for number, word in words.items() if word == "ball")
    rows = np.array([[float(x) for x in line.split(",")] for line in (own / "gt.txt").read_text().splitlines()])
    balls = rows[rows[:, 1] == ball]
    assert balls[:, 0].tolist() == [1, 2, 3]
    assert balls[:, 8].tolist() == [1.0, 0.0, 1.0]
    x, _, width, height = balls[1, 2:6]
    assert x - 1 + width / 2 == pytest.approx(32, abs=0.02)  # of the middle, counted from 0
    assert np.allclose(balls[:, 4:6], [width, height], rtol=0.2)


def test_nerfstudio_has_millimetres_and_shared_intrinsics_only(layouts: Path, tmp_path: Path) -> None:
    own = layouts / "nerfstudio" / "000000000"
    document = json.loads((own / "transforms.json").read_text())
    assert document["depth_unit_scale_factor"] == 0.001
    assert document["fl_x"] == document["frames"][0]["fl_x"]
    assert 1_000 < np.load(own / document["frames"][0]["depth_file_path"]).max() < 60_000
    spec = "count = 1\n[pictures]\nsize = 16\n[cameras]\nviews = 2\nazimuth = { uniform = [0, 9] }\nfov = { uniform = [20, 60] }\n"
    spec += "[output]\nformats = ['nerfstudio']"
    out = _made(tmp_path, '(bind "a" (lambda () (call "cube")))', spec)
    varied = json.loads((out / "nerfstudio" / "000000000" / "transforms.json").read_text())
    assert not {"fl_x", "fl_y", "cx", "cy"} & set(varied)
    assert varied["frames"][0]["fl_x"] != varied["frames"][1]["fl_x"]


@pytest.mark.parametrize("has_splits", [False, True])
def test_formats_by_sample_are_in_folders_by_split(tmp_path: Path, has_splits: bool) -> None:
    spec = "count = 6\n[pictures]\nsize = 16\n[output]\nformats = ['nerfstudio', 'colmap']\n"
    spec += "[splits]\ntrain = 0.5\ntest = 0.5\n" if has_splits else ""
    text = '(bind "a" (lambda () (call "cube" :scale (uniform 1 2))))'
    out = _made(tmp_path, text, spec)
    splits = {path.name.partition("-")[0]: path for path in out.glob("*.tar")}
    assert set(splits) == ({"train", "test"} if has_splits else {"train"})
    for name in ("nerfstudio", "colmap"):
        parents = [out / name / split for split in splits] if has_splits else [out / name]
        assert {path.name for path in (out / name).iterdir()} == ({*splits} if has_splits else _keys_of(range(6)))
        assert {path.name for parent in parents for path in parent.iterdir()} == _keys_of(range(6))
    assert not has_splits or (out / "nerfstudio" / "test").is_dir()


def _keys_of(numbers: Iterable[int]) -> set[str]:
    return {f"{number:09d}" for number in numbers}


def test_films_of_still_scenes_are_not_written(tmp_path: Path) -> None:
    from scenelang.datasets.running import dataset, verify_dataset

    (tmp_path / "a.scene").write_text('(bind "a" (lambda () (call "cube")))')
    (tmp_path / "spec.toml").write_text(
        "programs = 'a.scene'\ncount = 1\n[pictures]\nsize = 8\n[labels]\nwrite = ['tracks']\n[output]\nformats = ['tap']"
    )
    report = dataset(tmp_path / "spec.toml", tmp_path / "out", jobs=0)
    told = "warning: `tap` is not written, since it is made of films and all scenes are still"
    assert told in str(report).splitlines()
    assert report.data()["notes"] == [told]
    assert not (tmp_path / "out" / "tap").exists()
    assert verify_dataset(tmp_path / "out") == []


@pytest.mark.parametrize(("word", "written"), [("", "_"), (" ", "_"), ("a\\tb c", "a_b_c")])
def test_words_of_kitti_are_one_column(tmp_path: Path, word: str, written: str) -> None:
    spec = "count = 1\n[pictures]\nsize = 32\n[labels]\nwrite = ['boxes', 'visibility']\n[output]\nformats = ['kitti']"
    out = _made(tmp_path, f'(bind "{word}" (lambda () (call "cube")))', spec)
    (line,) = (out / "kitti" / "train" / "label_2" / "000000000.txt").read_text().splitlines()
    assert (line.split()[0], len(line.split())) == (written, 15)
