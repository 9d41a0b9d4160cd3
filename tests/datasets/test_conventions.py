"""Where formats put the centers of pixels: all that they say projects onto known balls and boxes, each by the rules of
its readers, within a tenth of a pixel and half a millimetre of a scene whose unit is a metre."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from known_room import FRAMES, MOVING, STILL, THINGS, in_film, off_surface, outline, seen
from PIL import Image

from scenelang.datasets.layouts import StoredItem, items
from scenelang.datasets.running import dataset
from scenelang.datasets.store import Store, read_plan, records_of

WIDTH, HEIGHT = 160, 120
PIXEL, LENGTH = 0.1, 5e-4
SPEC = """
programs = ["a.scene"]
count = 1
root = "room"
[cameras]
kind = "orbit"
views = VIEWS
azimuth = 20
elevation = 25
distance = 5
target = [0.03, 0.02, 0.01]
[pictures]
size = [160, 120]
[labels]
write = ["instance", "semantic", "depth", "boxes", "visibility", TRACKS]
words = ["ball", "crate"]
tracks = 64
[output]
formats = [FORMATS]
"""
Made = tuple[Path, list[StoredItem]]


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, int, str, str], Made]:
    def made(program: str, views: int, tracks: str, formats: str) -> Made:
        folder = tmp_path_factory.mktemp("conventions")
        (folder / "a.scene").write_text(program)
        text = SPEC.replace("VIEWS", str(views)).replace("TRACKS", tracks).replace("FORMATS", formats)
        (folder / "spec.toml").write_text(text)
        dataset(folder / "spec.toml", folder / "out", jobs=0)
        store = Store(folder / "out")
        plan = read_plan(store)
        assert plan is not None
        return folder / "out", list(items(store, list(records_of(store, plan)), is_named=True))

    return made


@pytest.fixture(scope="module")
def still(make: Any) -> Made:
    return make(STILL, 3, "", '"coco", "kitti", "bop", "nerfstudio", "colmap"')


@pytest.fixture(scope="module")
def film(make: Any) -> Made:
    return make(MOVING, 1, '"tracks"', '"tap"')


def image(path: Path) -> np.ndarray:
    with Image.open(path) as picture:
        return np.asarray(picture)


def lifted(depth: np.ndarray, first: float, k: np.ndarray) -> np.ndarray:
    """The points (N, 3) in the camera's frame of a depth image, 0 for none; the center of the first pixel is ``first``."""
    rows, columns = np.nonzero(depth)
    pixels = np.stack([columns + first, rows + first, np.ones(len(rows))], axis=1)
    return pixels @ np.linalg.inv(k).T * depth[rows, columns][:, None]


def test_samples_count_from_the_corner(still: Made) -> None:
    _, found = still
    assert len(found) == 3
    for item in found:
        assert item.intrinsics[:2, 2].tolist() == [80.0, 60.0]
        inverse = np.linalg.inv(item.world_to_camera)
        assert np.linalg.norm(inverse[:3, 3] - [0.03, 0.02, 0.01]) == pytest.approx(5.0)
        depth = np.where(np.isfinite(item["depth.npy"]), item["depth.npy"], 0.0)
        assert (depth > 0).sum() > 1_000
        points = lifted(depth, 0.5, item.intrinsics) @ inverse[:3, :3].T + inverse[:3, 3]
        assert off_surface(points).max() < LENGTH


def test_bop_lifts_whole_pixels(still: Made) -> None:
    """The toolkit: ``(u - cam_K[0, 2]) * depth / cam_K[0, 0]`` with u from 0 (bop_toolkit_lib.misc.depth_im_to_dist_im);
    ``K [R_w2c, t_w2c]`` and ``K [R_m2c, t_m2c]`` project millimetres of the world and of a model (docs/bop_datasets_format.md)."""
    own = still[0] / "bop" / "train" / "000000"
    cameras, truth = (json.loads((own / f"scene_{name}.json").read_text()) for name in ("camera", "gt"))
    classes = json.loads((still[0] / "bop" / "classes.json").read_text())
    assert len(cameras) == 3
    for number, camera in cameras.items():
        k, turn, move = (np.array(camera[name]) for name in ("cam_K", "cam_R_w2c", "cam_t_w2c"))
        k, turn = k.reshape(3, 3), turn.reshape(3, 3)
        assert k[:2, 2].tolist() == [79.5, 59.5]
        points = lifted(image(own / "depth" / f"{int(number):06d}.png") * camera["depth_scale"], 0.0, k)
        assert len(points) > 1_000
        assert off_surface((points - move) @ turn / 1000.0).max() < LENGTH
        assert len(truth[number]) == 2
        for index, thing in enumerate(truth[number]):
            own_turn, place = THINGS[classes[str(thing["obj_id"])]]
            assert np.allclose(thing["cam_t_m2c"], turn @ place * 1000.0 + move, atol=1000.0 * LENGTH)
            assert np.allclose(np.abs(np.reshape(thing["cam_R_m2c"], (3, 3)).T @ turn @ own_turn).max(axis=1), 1.0)
            mask = image(own / "mask_visib" / f"{int(number):06d}_{index:06d}.png") > 0
            assert (mask == _expected(k, 0.0, turn, move / 1000.0)[classes[str(thing["obj_id"])]]).all()


def _expected(k: np.ndarray, first: float, turn: np.ndarray, move: np.ndarray) -> dict[str, np.ndarray]:
    """The masks of STILL in a camera of OpenCV's axes in which the center of the first pixel is ``first``."""
    points = lifted(np.ones((HEIGHT, WIDTH)), first, k)
    which = seen(-move @ turn, points @ turn, THINGS)[0].reshape(HEIGHT, WIDTH)
    return {word: which == number for number, word in enumerate(THINGS, start=1)}


def test_kitti_counts_whole_pixels(still: Made) -> None:
    """The devkit: boxes have a "0-based index" (devkit_object/readme.txt), and x = P2 * R0_rect * Tr_velo_to_cam * y
    projects a point; labels are in the frame that P2 projects, their place in the middle of the bottom."""
    out, found = still
    for item in found:
        lines = (out / "kitti" / "train" / "calib" / f"{item.key}.txt").read_text().splitlines()
        rows = {name: np.array(row.split(), float) for name, row in (line.split(": ") for line in lines if line)}
        p2, r0, velo = rows["P2"].reshape(3, 4), rows["R0_rect"].reshape(3, 3), rows["Tr_velo_to_cam"].reshape(3, 4)
        k = p2[:, :3] @ r0
        assert k[:2, 2] == pytest.approx([79.5, 59.5], abs=1e-6)
        masks = _expected(k, 0.0, velo[:, :3], velo[:, 3])
        labels = (out / "kitti" / "train" / "label_2" / f"{item.key}.txt").read_text().splitlines()
        assert len(labels) == 2
        for word, *values in (line.split() for line in labels):
            box, (high, _, _, *place) = np.array(values[3:7], float), map(float, values[7:13])
            y, x = np.nonzero(masks[word])
            assert box.tolist() == [x.min(), y.min(), x.max(), y.max()]
            center = np.append(r0 @ (velo[:, :3] @ THINGS[word][1] + velo[:, 3]), 1.0)
            told = np.append(np.array(place) - [0.0, high / 2.0, 0.0], 1.0)
            assert np.linalg.norm(told - center) < LENGTH
            pixels = [(p2 @ point)[:2] / (p2 @ point)[2] for point in (told, center)]
            assert np.abs(pixels[0] - pixels[1]).max() < PIXEL


def test_coco_masks_and_boxes_are_of_pixel_edges(still: Made) -> None:
    """A pixel of a mask covers [x, x + 1], and is of what its center shows; boxes are of edges, as pycocotools has them."""
    from pycocotools import mask as masks
    from pycocotools.coco import COCO

    out, found = still
    coco = COCO(str(out / "coco" / "annotations" / "instances_train.json"))
    names = {each["id"]: each["name"] for each in coco.loadCats(coco.getCatIds())}
    own = {f"{item.key}.png": item for item in found}
    assert len(coco.getImgIds()) == 3
    for record in coco.loadImgs(coco.getImgIds()):
        item = own[record["file_name"]]
        pose_ = item.world_to_camera
        expected = _expected(item.intrinsics, 0.5, pose_[:3, :3], pose_[:3, 3])
        annotations = coco.loadAnns(coco.getAnnIds(imgIds=record["id"]))
        assert {names[each["category_id"]] for each in annotations} == set(expected)
        for each in annotations:
            word = names[each["category_id"]]
            assert (coco.annToMask(each) == expected[word]).all()
            assert masks.toBbox(coco.annToRLE(each)).tolist() == each["bbox"]
            (thing,) = (thing for thing in item.instances if thing["word"] == word)
            pixels = outline(word, pose_) @ item.intrinsics.T
            pixels = pixels[:, :2] / pixels[:, 2:]
            ends = np.append(pixels.min(axis=0), pixels.max(axis=0))
            boxes = [np.append(box[:2], np.add(box[:2], box[2:])) for box in (thing["bbox_full"], each["bbox"])]
            assert np.abs(boxes[0] - ends).max() < PIXEL
            if thing["visibility"] == 1.0:  # the outermost centers are within half a pixel of the outline
                assert np.abs(boxes[1] - ends).max() < 0.5 + PIXEL


def test_nerfstudio_lifts_the_centers_of_pixels(still: Made) -> None:
    """nerfstudio's rays: ((x + 0.5 - cx) / fl_x, -(y + 0.5 - cy) / fl_y, -1) in OpenGL's axes (cameras.py)."""
    (own,) = (still[0] / "nerfstudio").iterdir()
    document = json.loads((own / "transforms.json").read_text())
    assert len(document["frames"]) == 3
    for frame in document["frames"]:
        assert (frame["cx"], frame["cy"], frame["w"], frame["h"]) == (80.0, 60.0, 160, 120)
        depth = np.load(own / frame["depth_file_path"]) * document["depth_unit_scale_factor"]
        k = np.array([[frame["fl_x"], 0, frame["cx"]], [0, frame["fl_y"], frame["cy"]], [0, 0, 1]])
        points, matrix = lifted(depth, 0.5, k) * [1, -1, -1], np.array(frame["transform_matrix"])
        assert len(points) > 1_000
        assert off_surface(points @ matrix[:3, :3].T + matrix[:3, 3]).max() < LENGTH


def test_nerfstudio_reads_depth_in_its_default_unit(still: Made) -> None:
    """nerfstudio multiplies depth by its option --depth-unit-scale-factor, 0.001 by default, and reads none of a file
    (nerfstudio_dataparser.py)."""
    (own,) = (still[0] / "nerfstudio").iterdir()
    for frame, item in zip(json.loads((own / "transforms.json").read_text())["frames"], still[1], strict=True):
        is_seen = np.isfinite(item["depth.npy"])
        depth = np.load(own / frame["depth_file_path"])[is_seen] * 0.001
        assert np.abs(depth - item["depth.npy"][is_seen]).max() < 1e-3 * LENGTH


def test_colmap_projects_points_to_keypoints(still: Made) -> None:
    import pycolmap

    (own,) = (still[0] / "colmap").iterdir()
    model = pycolmap.Reconstruction(str(own / "sparse" / "0"))
    assert off_surface(np.array([point.xyz for point in model.points3D.values()])).max() < LENGTH
    assert len(model.images) == 3
    for shot in model.images.values():
        camera = model.cameras[shot.camera_id]
        assert camera.params[2:].tolist() == [80.0, 60.0]
        world = np.array([model.points3D[point.point3D_id].xyz for point in shot.points2D])
        stored = np.array([point.xy for point in shot.points2D])
        local = np.array([shot.cam_from_world() * each for each in world])
        assert np.abs(np.array([camera.img_from_cam(each) for each in local]) - stored).max() < PIXEL
        rays = np.column_stack([np.array([camera.cam_from_img(each) for each in stored]), np.ones(len(stored))])
        turn, move = shot.cam_from_world().matrix()[:, :3], shot.cam_from_world().matrix()[:, 3]
        which, there = seen(-move @ turn, rays @ turn, THINGS)
        at_edges = np.linalg.norm(there - world, axis=1) > 10 * LENGTH
        assert (which > 0).mean() > 0.98
        assert at_edges.mean() < 0.02
        centers = (np.abs(stored % 1.0 - 0.5) < 1e-6).all(axis=1)  # those of this view
        assert centers.mean() > 0.2


def test_tap_tracks_are_raster_coordinates(film: Made) -> None:
    """TAP-Vid: (0, 0) is the upper left corner of the upper left pixel, and (1, 1) the lower right corner of the lower
    right one ("a note on coordinates" of its README)."""
    out, found = film
    (path,) = (out / "tap" / "train").glob("*.npz")
    with np.load(path) as tracks:
        video, pixels, hidden = tracks["video"], tracks["points"] * [WIDTH, HEIGHT], tracks["occluded"]
    assert video.shape == (FRAMES, HEIGHT, WIDTH, 3)
    assert len(pixels) == 64
    k, camera = found[0].intrinsics, found[0].world_to_camera
    turn, move = camera[:3, :3], camera[:3, 3]
    rays = np.column_stack([pixels[:, 0], np.ones(len(pixels))]) @ np.linalg.inv(k).T @ turn
    which, points = seen(-move @ turn, rays, in_film(0))
    assert set(which) == {1, 2}
    assert not hidden[:, 0].any()
    for frame in range(FRAMES):
        for number, word in enumerate(("ball", "crate"), start=1):
            (first, start), (then, end) = in_film(0)[word], in_film(frame)[word]
            moved = (points[which == number] - start) @ first @ then.T + end
            local = (moved @ turn.T + move) @ k.T
            assert np.abs(local[:, :2] / local[:, 2:] - pixels[which == number, frame]).max() < PIXEL
            away = np.linalg.norm(seen(-move @ turn, moved + move @ turn, in_film(frame))[1] - moved, axis=1)
            assert ((away > 20 * LENGTH) == hidden[which == number, frame]).mean() > 0.95
