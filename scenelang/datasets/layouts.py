"""Formats that are derived from the shards: COCO, KITTI, BOP, nerfstudio, COLMAP, MOT and TAP (docs/datasets.md).

Camera frames are OpenCV's (x right, y down, z forward) unless a format says otherwise. Lengths are scene units; BOP's
are millimeters, a scene unit being a meter.

The records of a dataset count pixels from the corner of the image, so that the center of the first pixel is at
(0.5, 0.5). COLMAP, nerfstudio and TAP do so too; the readers of BOP and KITTI put it at (0, 0) (``_of_centers``).
"""

from __future__ import annotations

import io
import json
import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.files import replaced_folder
from scenelang.backends.labels.object_labels import OTHER, rigid_parts
from scenelang.backends.surfaces.trs import quaternions
from scenelang.datasets.making import decoded, png
from scenelang.datasets.spec import CODE
from scenelang.datasets.store import Plan, Store, items_of
from scenelang.grammar.diagnostics import SceneError

FloatArray = npt.NDArray[np.float64]
Record = dict[str, Any]
_MM_PER_UNIT = 1_000.0  # per scene unit, which BOP takes as a meter
_MAX_COLMAP_POINTS = 2_000  # of a COLMAP model
_MAX_DEPTH_CODE = 65_535  # of a 16-bit depth image
_MIN_DEPTH_STEP_MM = 0.1  # step of depth images, if the depths of a scene allow it
_DEPTH_TOLERANCE = 0.01  # relative difference of the depths of one point within a pixel of a slope
_HIDDEN, _LARGELY = 0.9, 0.5  # visibility above which KITTI calls an object fully visible or partly occluded
_MIN_TRUNCATION = 0.005  # less is written as 0, since it is rounding at the border of the image
FILMS = ("tap",)  # formats of videos, which still scenes lack


class StoredItem:
    """Image with its labels, decoded on access; ``is_named`` if the spec names the words of objects."""

    def __init__(self, key: str, split: str, files: Mapping[str, bytes], is_named: bool = False) -> None:
        self.key, self.split, self._files, self._is_named = key, split, files, is_named
        self.record: Record = json.loads(files["json"])

    def __getitem__(self, name: str) -> Any:
        return decoded(name, self._files[name])

    def __contains__(self, name: str) -> bool:
        return name in self._files

    @property
    def picture(self) -> bytes:
        """The encoded image."""
        return self._files["color.png"]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.record["camera"]["width"], self.record["camera"]["height"]

    @property
    def intrinsics(self) -> FloatArray:
        """Intrinsic matrix (3, 3) in pixels."""
        return np.array(self.record["camera"]["K"], np.float64)

    @property
    def world_to_camera(self) -> FloatArray:
        """Pose (4, 4) of the world in the camera's frame."""
        return np.array(self.record["camera"]["world_to_camera"], np.float64)

    @property
    def instances(self) -> list[Record]:
        """Records of all labeled instances."""
        return list(self.record["things"])

    @property
    def objects(self) -> list[Record]:
        """Records of the instances that are objects of the scene."""
        return [instance for instance in self.instances if self.is_object(instance)]

    def is_object(self, instance: Record) -> bool:
        """Return whether an instance is an object: not the root, unless the spec names it or it is the only one."""
        if instance["depth"] or self._is_named:
            return True
        return len(self.instances) == 1 and sum(self.record["counts"].values()) <= 1

    @property
    def sample(self) -> str:
        """Key of the sample that the image belongs to."""
        return self.key.partition("-")[0]

    @property
    def is_of_film(self) -> bool:
        """Whether the image is a frame of a video."""
        return "-f" in self.key

    @property
    def sequence(self) -> str:
        """Name of the video that the image belongs to: its sample and camera."""
        return self.key.partition("-f")[0]


def items(
    store: Store, records: Sequence[Mapping[str, Any]], split: str | None = None, is_named: bool = False
) -> Iterator[StoredItem]:
    """Yield the items of a dataset in order, of one split if it is given; ``is_named`` as of ``StoredItem``."""
    for record in records:
        for file in record["files"]:
            if split in (None, file["split"]):
                for key, files in items_of(store, file["name"]):
                    yield StoredItem(key, file["split"], files, is_named)


def write_layout(name: str, store: Store, plan: Plan, records: Sequence[Mapping[str, Any]]) -> bool:
    """Write one format to the folder of its name, whole or not at all; return whether there is anything to write.

    Raises SceneError("unsupported") for a remote store and "dataset" for items of another form.
    """
    if store.local is None:
        raise SceneError("unsupported", f"`{name}` is written to local folders only; {store.address} keeps the shards")
    try:
        return _write(name, store, plan, records)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        message = f"`{name}` cannot be made: an item has another form: {type(error).__name__}: {error}"
        raise SceneError(CODE, message, "`dataset verify` finds damaged shards") from error


def _write(name: str, store: Store, plan: Plan, records: Sequence[Mapping[str, Any]]) -> bool:
    """Write a format to a new folder that replaces its old one."""
    is_named = bool(tomllib.loads(plan.text).get("labels", {}).get("words"))

    def read(split: str | None = None) -> Iterator[StoredItem]:
        """Yield the items of a split, or of all."""
        return items(store, records, split, is_named)

    if name in FILMS and not any(item.is_of_film for item in read()):
        return False
    with replaced_folder(store.path(name)) as folder:
        _LAYOUTS[name](folder, plan, read, _splits(records))
    return True


def _splits(records: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the splits of the records, sorted."""
    return sorted({file["split"] for record in records for file in record["files"]})


def _folder(*parts: Path | str) -> Path:
    """Create a folder and return it."""
    folder = Path(*parts)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _write_json(path: Path, data: Any) -> None:
    """Write JSON data to a file."""
    path.write_text(json.dumps(data, indent=1), "utf-8")


# --- COCO ------------------------------------------------------------------------------------------------------------


def _coco(folder: Path, plan: Plan, read: Any, splits: Sequence[str]) -> None:
    """Write ``annotations/instances_SPLIT.json`` and ``panoptic_SPLIT.json``, images in ``SPLIT/``."""
    categories = _Categories(plan)
    annotations = _folder(folder, "annotations")
    for split in splits:
        pictures, masks = _folder(folder, split), _folder(annotations, f"panoptic_{split}")
        with (
            _Document(annotations / f"instances_{split}.json", categories) as instances,
            _Document(annotations / f"panoptic_{split}.json", categories) as panoptic,
        ):
            for number, item in enumerate(read(split), start=1):
                (pictures / f"{item.key}.png").write_bytes(item.picture)
                image = {"id": number, "file_name": f"{item.key}.png", "width": item.size[0], "height": item.size[1]}
                for document in (instances, panoptic):
                    document.images.append(image)
                for annotation in _instances(item, number, categories):
                    instances.add(annotation)
                segments, mask = _panoptic(item, categories)
                panoptic.add({"image_id": number, "file_name": f"{item.key}.png", "segments_info": segments}, False)
                (masks / f"{item.key}.png").write_bytes(png(mask))


class _Categories:
    """Categories by word: the classes of the plan, and further words in the order of their occurrence."""

    def __init__(self, plan: Plan) -> None:
        self.numbers = dict(plan.classes)
        self._last = max(self.numbers.values(), default=0)

    def __getitem__(self, instance: Record) -> int:
        """Return the number of an instance's category, a new one for a word without a class."""
        if instance["class"] != OTHER:
            return int(instance["class"])
        if instance["word"] not in self.numbers:
            self._last += 1
            self.numbers[instance["word"]] = self._last
        return self.numbers[instance["word"]]

    def records(self) -> list[Record]:
        """Return the categories as COCO writes them."""
        return [{"id": n, "name": word, "supercategory": "word", "isthing": 1} for word, n in self.numbers.items()]


class _Document:
    """COCO file whose annotations are written one by one, since there may be too many for the memory."""

    def __init__(self, path: Path, categories: _Categories) -> None:
        self.images: list[Record] = []
        self._path, self._categories, self._count = path, categories, 0

    def __enter__(self) -> _Document:
        self._file = open(self._path, "w", encoding="utf-8")
        self._file.write('{"annotations": [')
        return self

    def add(self, annotation: Record, numbered: bool = True) -> None:
        """Write an annotation, with a number unless it has its own."""
        self._count += 1
        record = {"id": self._count, **annotation} if numbered else annotation
        self._file.write((",\n" if self._count > 1 else "\n") + json.dumps(record))

    def __exit__(self, *_: object) -> None:
        rest = {"info": {"description": "made with scenelang"}, "licenses": [], "images": self.images}
        self._file.write("\n],\n" + json.dumps({**rest, "categories": self._categories.records()})[1:])
        self._file.close()


def _instances(item: StoredItem, image: int, categories: _Categories) -> Iterator[Record]:
    """Yield an annotation for each visible object; its mask includes the instances that are parts of it."""
    ids = item["instance.png"].astype(np.int64)
    members = _parts(item.instances)
    for instance in item.objects:
        mask = np.isin(ids, members[instance["id"]])
        if not mask.any():
            continue
        rows, columns = np.nonzero(mask)
        x, y = int(columns.min()), int(rows.min())
        yield {
            "image_id": image,
            "category_id": categories[instance],
            "bbox": [x, y, int(columns.max()) - x + 1, int(rows.max()) - y + 1],
            "area": int(mask.sum()),
            "iscrowd": 0,
            "segmentation": {"size": list(mask.shape), "counts": run_lengths(mask)},
            "handle": instance["handle"],
            "parent": instance["parent"],
        }


def _parts(instances: Sequence[Record]) -> dict[int, list[int]]:
    """Return for each instance its id and the ids of its parts."""
    members = {instance["id"]: [instance["id"]] for instance in instances}
    parent = {instance["id"]: instance["parent"] for instance in instances}
    for number in members:
        container = parent[number]
        while container:
            members[container].append(number)
            container = parent[container]
    return members


def run_lengths(mask: npt.NDArray[np.bool_]) -> list[int]:
    """Return COCO's column-wise run lengths of a mask (H, W), zeros first.

    Examples
    --------
    >>> run_lengths(np.array([[False, True], [True, True]]))
    [1, 3]
    """
    flat = mask.reshape(-1, order="F")
    edges = np.flatnonzero(np.diff(flat)) + 1
    ends = np.concatenate([[0], edges, [len(flat)]])
    lengths: list[int] = np.diff(ends).tolist()
    return [0, *lengths] if flat[0] else lengths


def _panoptic(item: StoredItem, categories: _Categories) -> tuple[list[Record], npt.NDArray[np.uint8]]:
    """Return the segments of an image and its map of ids as colors; pixels without an object are 0."""
    ids = item["instance.png"].astype(np.int64)
    ids = np.where(np.isin(ids, [instance["id"] for instance in item.objects]), ids, 0)
    segments = []
    for instance in item.objects:
        rows, columns = np.nonzero(ids == instance["id"])
        if len(rows):
            x, y = int(columns.min()), int(rows.min())
            box = [x, y, int(columns.max()) - x + 1, int(rows.max()) - y + 1]
            segment = {
                "id": instance["id"],
                "category_id": categories[instance],
                "area": len(rows),
                "bbox": box,
                "iscrowd": 0,
            }
            segments.append(segment)
    return segments, np.stack([ids % 256, ids // 256, np.zeros_like(ids)], axis=2).astype(np.uint8)


# --- KITTI -----------------------------------------------------------------------------------------------------------


def _kitti(folder: Path, plan: Plan, read: Any, splits: Sequence[str]) -> None:
    """Write ``SPLIT/image_2``, ``label_2`` and ``calib``: 2D boxes, and 3D boxes with a yaw in a level frame."""
    for split in splits:
        pictures, labels, calib = (_folder(folder, split, name) for name in ("image_2", "label_2", "calib"))
        for item in read(split):
            (pictures / f"{item.key}.png").write_bytes(item.picture)
            lines = [line for instance in item.objects if (line := _kitti_line(item, instance))]
            (labels / f"{item.key}.txt").write_text("".join(f"{line}\n" for line in lines), "utf-8")
            (calib / f"{item.key}.txt").write_text(_kitti_calibration(item), "utf-8")


def _of_centers(intrinsics: FloatArray) -> FloatArray:
    """Return intrinsics for pixel coordinates in which the center of the first pixel is (0, 0)."""
    shifted = intrinsics.copy()
    shifted[:2, 2] -= 0.5
    return shifted


def _level(item: StoredItem) -> FloatArray:
    """Return the rotation (3, 3) from the camera to a level one at the same point: x right, y down, z ahead."""
    down = item.world_to_camera[:3, :3] @ np.array([0.0, -1.0, 0.0])
    ahead = np.array([0.0, 0.0, 1.0]) if abs(down[2]) < 0.999 else np.array([0.0, -1.0, 0.0])
    ahead = ahead - down * (down @ ahead)
    ahead /= np.linalg.norm(ahead)
    return np.stack([np.cross(down, ahead), down, ahead])


def _kitti_line(item: StoredItem, instance: Record) -> str | None:
    """Return the 15 columns of an object, None if it is not visible or partly behind the camera."""
    x, y, width, height = instance["bbox"]
    if not instance["area"] or instance["truncation"] is None:
        return None
    box, pose, level = instance["box3d"], item.world_to_camera, _level(item)
    rotation = level @ pose[:3, :3] @ np.array(box["rotation"])
    size = np.abs(np.array(box["size"]))
    up = int(np.argmax(np.abs(rotation[1])))  # the box's axis nearest to the vertical
    long, wide = [k for k in range(3) if k != up]
    yaw = -math.atan2(rotation[2, long], rotation[0, long])
    center = level @ (pose[:3, :3] @ np.array(box["center"]) + pose[:3, 3])
    bottom = center + np.array([0.0, size[up] / 2.0, 0.0])
    alpha = yaw - math.atan2(center[0], center[2])
    alpha = (alpha + math.pi) % (2.0 * math.pi) - math.pi
    share = instance["visibility"]
    occluded = 0 if share > _HIDDEN else 1 if share > _LARGELY else 2
    truncated = instance["truncation"] if instance["truncation"] > _MIN_TRUNCATION else 0.0
    numbers = [alpha, x, y, x + width - 1, y + height - 1, size[up], size[wide], size[long], *bottom, yaw]
    word = "".join(c if not c.isspace() else "_" for c in instance["word"]) or "_"
    return f"{word} {truncated:.2f} {occluded} {' '.join(f'{number:.6f}' for number in numbers)}"


def _kitti_calibration(item: StoredItem) -> str:
    """Return the calibration: ``P2`` projects the level frame of the labels; ``velo`` is the world.

    KITTI's boxes count whole pixels from 0 (devkit_object/readme.txt: "0-based index"), so ``P2`` does.
    """
    level, pose = _level(item), item.world_to_camera
    projection = np.hstack([_of_centers(item.intrinsics) @ level.T, np.zeros((3, 1))])

    def row(values: npt.ArrayLike) -> str:
        return " ".join(f"{value:.12e}" for value in np.asarray(values).reshape(-1))

    lines = [f"P{camera}: {row(projection)}" for camera in range(4)]
    lines += [f"R0_rect: {row(level)}", f"Tr_velo_to_cam: {row(pose[:3])}"]
    return "\n".join([*lines, f"Tr_imu_to_velo: {row(np.eye(4)[:3])}", ""])


# --- BOP -------------------------------------------------------------------------------------------------------------


def _bop(folder: Path, plan: Plan, read: Any, splits: Sequence[str]) -> None:
    """Write ``SPLIT/NNNNNN`` with a scene for each sample: images, visible masks, cameras, poses, visibility."""
    models = _folder(folder, "models")
    sizes: dict[str, Record] = {}
    categories = _Categories(plan)
    for split in splits:
        scene: _BopScene | None = None
        number = -1
        for item in read(split):
            if scene is None or scene.sample != item.sample:
                if scene is not None:
                    scene.close()
                number += 1
                scene = _BopScene(_folder(folder, split, f"{number:06d}"), item.sample)
            scene.add(item, sizes, categories)
        if scene is not None:
            scene.close()
    _write_json(models / "models_info.json", sizes)
    _write_json(folder / "classes.json", {str(number): word for word, number in categories.numbers.items()})


class _BopScene:
    """One scene of a BOP dataset.

    The toolkit lifts the depth of column x by ``(x - cam_K[0, 2]) * depth / cam_K[0, 0]``, x counted from 0
    (``bop_toolkit_lib.misc.depth_im_to_dist_im``).
    """

    def __init__(self, folder: Path, sample: str) -> None:
        self.sample = sample
        self._folder = folder
        self._tables: dict[str, Record] = {name: {} for name in ("scene_camera", "scene_gt", "scene_gt_info")}
        for name in ("rgb", "depth", "mask_visib"):
            _folder(folder, name)

    def add(self, item: StoredItem, sizes: dict[str, Record], categories: _Categories) -> None:
        """Add an image; ``sizes`` collects the extents of each class."""
        number = len(self._tables["scene_camera"])
        depth, ids = item["depth.npy"], item["instance.png"]
        finite = np.where(np.isfinite(depth), depth * _MM_PER_UNIT, 0.0)
        scale = max(_MIN_DEPTH_STEP_MM, float(finite.max(initial=0.0)) / _MAX_DEPTH_CODE)
        (self._folder / "rgb" / f"{number:06d}.png").write_bytes(item.picture)
        code = np.rint(finite / scale).astype(np.uint16)
        (self._folder / "depth" / f"{number:06d}.png").write_bytes(png(code))
        pose = item.world_to_camera
        self._tables["scene_camera"][str(number)] = {
            "cam_K": _of_centers(item.intrinsics).reshape(-1).tolist(),
            "cam_R_w2c": pose[:3, :3].reshape(-1).tolist(),
            "cam_t_w2c": (pose[:3, 3] * _MM_PER_UNIT).tolist(),
            "depth_scale": scale,
        }
        poses, infos, members = list[Record](), list[Record](), _parts(item.instances)
        for instance in item.objects:
            mask = np.isin(ids, members[instance["id"]])
            name = f"{number:06d}_{len(poses):06d}.png"
            (self._folder / "mask_visib" / name).write_bytes(png(np.where(mask, 255, 0).astype(np.uint8)))
            poses.append({**_bop_pose(instance, pose), "obj_id": categories[instance]})
            infos.append(_bop_info(item, instance, mask, depth))
            _note_size(sizes, instance, str(categories[instance]))
        self._tables["scene_gt"][str(number)] = poses
        self._tables["scene_gt_info"][str(number)] = infos

    def close(self) -> None:
        """Write the tables."""
        for name, table in self._tables.items():
            _write_json(self._folder / f"{name}.json", table)


def _bop_pose(instance: Record, camera: FloatArray) -> Record:
    """Return the pose of an object's box in the camera's frame, in millimeters."""
    box = instance["box3d"]
    rotation = camera[:3, :3] @ np.array(box["rotation"])
    place = camera[:3, :3] @ np.array(box["center"]) + camera[:3, 3]
    return {
        "cam_R_m2c": rotation.reshape(-1).tolist(),
        "cam_t_m2c": (place * _MM_PER_UNIT).tolist(),
    }


def _bop_info(item: StoredItem, instance: Record, mask: npt.NDArray[np.bool_], depth: FloatArray) -> Record:
    """Return the boxes and the visibility of an object, as BOP defines them."""
    full, visible = instance["bbox_full"], instance["bbox"] if instance["area"] else [-1, -1, -1, -1]
    return {
        "bbox_obj": [round(value) for value in full] if full is not None else [-1, -1, -1, -1],
        "bbox_visib": visible,
        "px_count_all": max(instance["area_alone"], instance["area"]),
        "px_count_valid": int((mask & np.isfinite(depth)).sum()),
        "px_count_visib": instance["area"],
        "visib_fract": instance["visibility"],
    }


def _note_size(sizes: dict[str, Record], instance: Record, number: str) -> None:
    """Update the largest extents of a class, in millimeters, which describe its BOP model."""
    size = np.array(instance["box3d"]["size"]) * _MM_PER_UNIT
    previous = sizes.get(number)
    if previous is not None:
        size = np.maximum(size, [previous["size_x"], previous["size_y"], previous["size_z"]])
    low = dict(zip(("min_x", "min_y", "min_z"), (-size / 2.0).tolist(), strict=True))
    axes = dict(zip(("size_x", "size_y", "size_z"), size.tolist(), strict=True))
    sizes[number] = {"diameter": float(np.linalg.norm(size)), **low, **axes}


# --- several views: nerfstudio and COLMAP ----------------------------------------------------------------------------


def _nerfstudio(folder: Path, plan: Plan, read: Any, splits: Sequence[str]) -> None:
    """Write a folder for each sample with ``transforms.json`` (OpenGL cameras), ``images`` and ``depths``.

    Depths are arrays of thousandths, nerfstudio's default unit: its data parser reads no other from the file, and
    16-bit images would round them by half a millimeter and end at 65 meters.
    """
    for place, views in _samples(plan, read, splits):
        sample_folder = _folder(folder, place)
        _folder(sample_folder, "images"), _folder(sample_folder, "depths")
        frames = []
        for item in views:
            name = f"{item.key}.png"
            depth = item["depth.npy"]
            (sample_folder / "images" / name).write_bytes(item.picture)
            np.save(
                sample_folder / "depths" / f"{item.key}.npy",
                np.where(np.isfinite(depth), depth, 0.0) * np.float32(_MM_PER_UNIT),
            )
            pose = np.linalg.inv(item.world_to_camera) @ np.diag([1.0, -1.0, -1.0, 1.0])
            frame: Record = {"file_path": f"images/{name}", "depth_file_path": f"depths/{item.key}.npy"}
            frames.append(frame | {"transform_matrix": pose.tolist(), **_pinhole(item)})
        document = {"camera_model": "OPENCV", "depth_unit_scale_factor": 1.0 / _MM_PER_UNIT, "aabb_scale": 16}
        first = _pinhole(views[0])  # written once if it is equal in all frames
        shared = first if all(_pinhole(item) == first for item in views) else {}
        _write_json(sample_folder / "transforms.json", document | shared | {"frames": frames})


def _pinhole(item: StoredItem) -> Record:
    """Return the intrinsics of an image as nerfstudio writes them."""
    k = item.intrinsics
    width, height = item.size
    parameters = {"fl_x": k[0, 0], "fl_y": k[1, 1], "cx": k[0, 2], "cy": k[1, 2]}
    return {name: float(value) for name, value in parameters.items()} | {"w": width, "h": height}


def _samples(plan: Plan, read: Any, splits: Sequence[str]) -> Iterator[tuple[Path, list[StoredItem]]]:
    """Yield the first frames of the views of each sample, with its folder.

    If the spec has splits, the folder is in that of its split. An image without views is a sample of one.
    """
    has_splits = "splits" in tomllib.loads(plan.text)
    for split in splits:
        for sample, frames_of_sample in groupby(read(split), key=lambda item: item.sample):
            views = [next(frames) for _, frames in groupby(frames_of_sample, key=lambda item: item.record["view"])]
            yield Path(split if has_splits else "", sample), views


def _colmap(folder: Path, plan: Plan, read: Any, splits: Sequence[str]) -> None:
    """Write a folder for each sample with ``images`` and ``sparse/0``: cameras, images and points as text."""
    for sample_folder, views in _samples(plan, read, splits):
        model, pictures = _folder(folder, sample_folder, "sparse", "0"), _folder(folder, sample_folder, "images")
        cameras, images = (
            ["# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]"],
            ["# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ ..."],
        )
        points, colors, tracks, keypoints = _points(views)
        for number, item in enumerate(views, start=1):
            (pictures / f"{item.key}.png").write_bytes(item.picture)
            k, (width, height) = item.intrinsics, item.size
            cameras.append(f"{number} PINHOLE {width} {height} {k[0, 0]!s} {k[1, 1]!s} {k[0, 2]!s} {k[1, 2]!s}")
            turn = " ".join(map(str, _quaternion(item.world_to_camera[:3, :3])))
            move = " ".join(map(str, item.world_to_camera[:3, 3].tolist()))
            images.append(f"{number} {turn} {move} {number} {item.key}.png")
            images.append(" ".join(f"{x!s} {y!s} {point}" for x, y, point in keypoints[number]))
        lines = ["# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)"]
        for i in range(len(points)):
            place, color = " ".join(map(str, points[i].tolist())), " ".join(map(str, colors[i].tolist()))
            track = " ".join(f"{image} {index}" for image, index in tracks[i])
            lines.append(f"{i + 1} {place} {color} 0 {track}")
        for name, text in (("cameras", cameras), ("images", images), ("points3D", lines)):
            (model / f"{name}.txt").write_text("\n".join(text) + "\n", "utf-8")


def _points(
    views: Sequence[StoredItem],
) -> tuple[FloatArray, npt.NDArray[np.uint8], list[list[tuple[int, int]]], dict[int, list[tuple[float, float, int]]]]:
    """Return exact points of the views: positions (N, 3), colors (N, 3), their tracks, and the keypoints of each view.

    They are pixel centers of each view, and are in the track of every view that shows them.
    """
    places, colors = [], []
    share = max(1, _MAX_COLMAP_POINTS // len(views))
    for item in views:
        depth, picture = item["depth.npy"], item["color.png"]
        rows, columns = np.nonzero(np.isfinite(depth))
        chosen = np.unique(np.linspace(0, max(0, len(rows) - 1), min(share, len(rows))).astype(np.int64))
        rows, columns = rows[chosen], columns[chosen]
        places.append(
            _unprojected(
                item,
                columns.astype(np.float64) + 0.5,
                rows.astype(np.float64) + 0.5,
                depth[rows, columns].astype(np.float64),
            )
        )
        colors.append(picture[rows, columns])
    points, shades = np.concatenate(places), np.concatenate(colors)
    tracks: list[list[tuple[int, int]]] = [[] for _ in points]
    keypoints: dict[int, list[tuple[float, float, int]]] = {}
    for number, item in enumerate(views, start=1):
        keypoints[number] = []
        pixels, is_visible = _seen(item, points)
        for i in np.flatnonzero(is_visible).tolist():
            tracks[i].append((number, len(keypoints[number])))
            keypoints[number].append((float(pixels[i, 0]), float(pixels[i, 1]), i + 1))
    return points, shades, tracks, keypoints


def _unprojected(item: StoredItem, x: FloatArray, y: FloatArray, depth: FloatArray) -> FloatArray:
    """Return the points (N, 3) in the world at pixel positions (N,) and depths (N,) of an image."""
    local = np.stack([x, y, np.ones_like(x)], axis=1) @ np.linalg.inv(item.intrinsics).T * depth[:, None]
    pose = item.world_to_camera
    return np.asarray((local - pose[:3, 3]) @ pose[:3, :3], np.float64)


def _seen(item: StoredItem, points: FloatArray) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """Return the pixels at which an image projects points (N, 3) of the world, and whether it shows them."""
    pose, depth = item.world_to_camera, item["depth.npy"]
    local = points @ pose[:3, :3].T + pose[:3, 3]
    ahead = np.maximum(local[:, 2], 1e-12)
    pixels = (local @ item.intrinsics.T)[:, :2] / ahead[:, None]
    column, row = np.floor(pixels).astype(np.int64).T
    width, height = item.size
    inside = (local[:, 2] > 0) & (column >= 0) & (row >= 0) & (column < width) & (row < height)
    visible_depth = depth[np.where(inside, row, 0), np.where(inside, column, 0)]
    return pixels, inside & (np.abs(visible_depth - local[:, 2]) < _DEPTH_TOLERANCE * local[:, 2])


def _quaternion(rotation: FloatArray) -> list[float]:
    """Return the unit quaternion (w, x, y, z) of a rotation (3, 3), w not negative."""
    x, y, z, w = quaternions(rigid_parts(rotation[None]))[0].tolist()
    return [w, x, y, z]


# --- videos: MOT and TAP ----------------------------------------------------------------------------------------------


def _mot(folder: Path, plan: Plan, read: Any, splits: Sequence[str]) -> None:
    """Write ``SPLIT/SEQUENCE`` with ``img1``, ``gt/gt.txt`` and ``seqinfo.ini``; an object keeps its number.

    The class of all is 1, as the benchmark's readers expect; ``gt/words.json`` has the word of each number.
    """
    for split in splits:
        names = []
        for sequence, frames in _sequences(read(split)):
            names.append(sequence)
            sequence_folder = _folder(folder, split, sequence)
            _folder(sequence_folder, "img1"), _folder(sequence_folder, "gt")
            numbers: dict[tuple[int, ...], int] = {}
            words: dict[int, str] = {}
            lines = []
            for frame, item in enumerate(frames, start=1):
                (sequence_folder / "img1" / f"{frame:06d}.png").write_bytes(item.picture)
                for instance in (*item.instances, *item.record.get("hidden", ())):
                    if item.is_object(instance):
                        number = numbers.setdefault(tuple(instance["path"]), len(numbers) + 1)
                        lines.append(f"{frame},{number},{_mot_columns(instance)}")
                        words[number] = instance["word"]
                size = item.size
            (sequence_folder / "gt" / "gt.txt").write_text("".join(f"{line}\n" for line in lines), "utf-8")
            _write_json(sequence_folder / "gt" / "words.json", words)
            info = {"name": sequence, "imDir": "img1", "frameRate": 24, "seqLength": frame, "imWidth": size[0]}
            info |= {"imHeight": size[1], "imExt": ".png"}
            text = "".join(f"{name}={value}\n" for name, value in info.items())
            (sequence_folder / "seqinfo.ini").write_text(f"[Sequence]\n{text}", "utf-8")
        seqmaps = _folder(folder, "seqmaps")
        (seqmaps / f"{split}.txt").write_text("".join(f"{name}\n" for name in ["name", *names]), "utf-8")


def _mot_columns(instance: Record) -> str:
    """Return the columns of an object from its box on: its full box, counted from 1, and its visibility."""
    x, y, width, height = instance["bbox_full"] or instance["bbox"]  # partly behind the camera: the visible box
    share = instance.get("visibility", 1.0) if instance.get("area") else 0.0
    return f"{x + 1:.2f},{y + 1:.2f},{width:.2f},{height:.2f},1,1,{share:.4f}"


def _sequences(frames: Iterator[StoredItem]) -> Iterator[tuple[str, Iterator[StoredItem]]]:
    """Yield the frames of each video."""
    yield from groupby(frames, key=lambda item: item.sequence)


def _tap(folder: Path, plan: Plan, read: Any, splits: Sequence[str]) -> None:
    """Write ``SPLIT/SEQUENCE.npz`` as TAP-Vid.

    Arrays are ``video`` (F, H, W, 3), ``points`` (N, F, 2) as fractions of the image, and ``occluded`` (N, F).
    """
    for split in splits:
        split_folder = _folder(folder, split)
        for sequence, frames in _sequences(read(split)):
            video, tracks = [], None
            for item in frames:
                video.append(item["color.png"])
                size = np.array(item.size)
                if "tracks.npz" in item:
                    tracks = item["tracks.npz"]
            if tracks is None:
                continue  # a single frame has no tracks
            points = np.swapaxes(tracks["pixels"], 0, 1) / size
            hidden = np.swapaxes(tracks["state"], 0, 1) != 2
            buffer = io.BytesIO()
            np.savez_compressed(
                buffer, video=np.stack(video), points=np.nan_to_num(points).astype(np.float32), occluded=hidden
            )
            (split_folder / f"{sequence}.npz").write_bytes(buffer.getvalue())


_LAYOUTS: Mapping[str, Callable[[Path, Plan, Any, Sequence[str]], None]] = {
    "coco": _coco, "kitti": _kitti, "bop": _bop, "nerfstudio": _nerfstudio, "colmap": _colmap, "mot": _mot, "tap": _tap,
}  # fmt: skip
