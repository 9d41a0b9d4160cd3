"""Labeled datasets: file layout, contents of each shot, and resuming an interrupted run.

A single shot is written to the folder itself; several are written to ``NAME/camera-000/frame-000``, omitting levels
with only one entry. A shot's files are complete once its ``shot.json`` exists.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, frame_of, require, sub_progress
from scenelang.backends.files import atomic_write, atomic_write_all, new_folder, write_json
from scenelang.backends.labels import ground_truth
from scenelang.backends.labels.ground_truth import (
    VISIBLE,
    Boxes,
    Correspondence,
    Flow,
    Tracks,
    Truth,
    boxes_in,
    boxes_of,
    correspondence_of,
)
from scenelang.backends.labels.views import LabeledView, SceneFacts, labeled_view
from scenelang.backends.pictures.camera import Camera, Viewpoint, camera_to_json
from scenelang.backends.pictures.declared import View
from scenelang.backends.pictures.film import STILL_ENDINGS, PictureBackend, PictureOptions, save_picture, write_exr
from scenelang.backends.pictures.stage import box_of
from scenelang.backends.pictures.surroundings import settled
from scenelang.backends.surfaces.appearance import word_color
from scenelang.backends.surfaces.image_files import encode
from scenelang.backends.surfaces.solids import is_object
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.datum import dataclass, replace
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import setting, whole
from scenelang.interpreter.scene.entity import Scene

# Annotations in COCO's JSON format: one per visible instance, at every level of the hierarchy. Masks are column-wise
# run lengths, as in COCO. In addition to COCO's fields an annotation has ``depth`` (in the hierarchy), ``instance`` and
# ``parent`` (numbers in the maps), ``path`` (child positions from the root), ``handle``, ``bbox_full`` (exact,
# including hidden parts and parts outside the image), ``box3d`` (the entity's box in its frame, and the pose of that
# frame in the world).


IntArray = npt.NDArray[np.int64]


def annotations_of(truth: Truth, boxes: Boxes, handles: Sequence[str], most: int) -> list[dict[str, Any]]:
    """Return the annotations of one shot, without ids; ``category`` is a word.

    ``handles`` are those of all instances. At most ``most`` instances are annotated, topmost in the hierarchy first.
    """
    ancestry = truth.ancestry
    visible = np.flatnonzero(boxes.area > 0)[:most]
    low, high = boxes_of(ancestry, visible)
    masks = _masks(truth, visible, boxes)
    annotations = []
    for k, instance in enumerate(visible.tolist()):
        x0, y0, x1, y1 = (int(edge) for edge in boxes.visible[instance])
        entity = ancestry.entity(instance)
        full = boxes.full[instance]
        annotation = {
            "category": entity.word,
            "bbox": [x0, y0, x1 - x0, y1 - y0],
            "area": int(boxes.area[instance]),
            "segmentation": {"size": [truth.camera.height, truth.camera.width], "counts": masks[k]},
            "iscrowd": 0,
            "instance": instance,
            "parent": int(ancestry.parent[instance]),
            "depth": int(ancestry.depth[instance]),
            "path": list(ancestry.path(instance)),
            "handle": handles[instance],
            "bbox_full": None if np.isnan(full).any() else _corner_and_size(full),
            "box3d": {
                "min": low[k].tolist(),
                "max": high[k].tolist(),
                "pose": [*ancestry.poses[instance].tolist(), [0.0, 0.0, 0.0, 1.0]],
            },
        }
        annotations.append(annotation)
    return annotations


def _corner_and_size(box: npt.NDArray[np.float64]) -> list[float]:
    """Return a box x0, y0, x1, y1 as x, y, width and height, as COCO writes it."""
    x0, y0, x1, y1 = box.tolist()
    return [x0, y0, x1 - x0, y1 - y0]


def _masks(truth: Truth, instances: IntArray, boxes: Boxes) -> list[list[int]]:
    """Return the run lengths of the instances ``instances``, level by level, each computed inside its box."""
    run_lengths: dict[int, list[int]] = {}
    for depth in range(truth.ancestry.max_depth + 1):
        instance_map = truth.at_depth(depth)
        for instance in instances[truth.ancestry.depth[instances] == depth].tolist():
            run_lengths[instance] = _run_lengths(instance_map, instance, boxes.visible[instance])
    return [run_lengths[instance] for instance in instances.tolist()]


def _run_lengths(map_: IntArray, instance: int, box: IntArray) -> list[int]:
    """Return the run lengths of ``map_ == instance`` (H, W), column-wise and starting with zeros.

    This is COCO's uncompressed RLE (pycocotools, ``maskApi.c``). The mask is false outside ``box``.
    """
    height, width = map_.shape
    x0, y0, x1, y1 = (int(edge) for edge in box)
    columns, rows = np.nonzero((map_[y0:y1, x0:x1] == instance).T)
    places = (columns + x0) * height + rows + y0
    breaks = np.flatnonzero(np.diff(places) > 1)
    starts = np.concatenate([places[:1], places[breaks + 1]])
    ends = np.concatenate([places[breaks], places[-1:]]) + 1
    edges = np.stack([starts, ends], axis=1).reshape(-1)
    lengths: list[int] = np.diff(np.concatenate([[0], edges, [height * width]])).tolist()
    return lengths if lengths[-1] else lengths[:-1]


def dataset(images: Sequence[dict[str, Any]], annotations: Sequence[Sequence[dict[str, Any]]]) -> dict[str, Any]:
    """Return a COCO document of ``images`` (``file_name``, ``width``, ``height``) and the annotations of each."""
    words = sorted({annotation["category"] for image_annotations in annotations for annotation in image_annotations})
    number = {word: i + 1 for i, word in enumerate(words)}
    records: list[dict[str, Any]] = []
    for image, image_annotations in enumerate(annotations, start=1):
        for annotation in image_annotations:
            rest = {name: value for name, value in annotation.items() if name != "category"}
            records.append(
                {"id": len(records) + 1, "image_id": image, "category_id": number[annotation["category"]], **rest}
            )
    return {
        "info": {"description": "maps of scenes, written by scenelang"},
        "images": [{"id": i, **image} for i, image in enumerate(images, start=1)],
        "categories": [{"id": i, "name": word, "supercategory": "word"} for word, i in number.items()],
        "annotations": records,
    }


# Visualization of maps: colors for words, instances, depths and motions; boxes, tracks and legends.


Picture = npt.NDArray[np.uint8]

FloatArray = npt.NDArray[np.float64]
DrawnBox = tuple[Sequence[float], str, tuple[int, int, int]]  # x0, y0, x1, y1 in pixels; word; color

_BLACK = (0, 0, 0)
_LEGEND_ROW_PX = 18  # height of a row of the legend
_MAX_LEGEND_ROWS = 200  # of a legend: 3,600 pixels; further words are counted in the last row
_MAX_DRAWN_BOXES = 400  # drawn on an image; more cover it, and annotations list all of them


# Multiples of the inverse golden ratio (hue) and of the inverse plastic number (value), modulo 1, are low-discrepancy
# sequences, so that numbers close to each other get dissimilar colors.
def instance_color(number: int) -> tuple[int, int, int]:
    """Return a color for an instance; consecutive numbers get dissimilar colors ."""
    hue, value = (number * 0.618033988749895) % 1.0, 0.62 + 0.33 * ((number * 0.7548776662466927) % 1.0)
    angle = 2.0 * math.pi * hue
    channels = [0.5 + 0.5 * math.cos(angle - shift) for shift in (0.0, 2.0944, 4.1888)]
    red, green, blue = (round(255 * value * (0.25 + 0.75 * channel)) for channel in channels)
    return (red, green, blue)


def colored(numbers: IntArray, colors: Mapping[int, tuple[int, int, int]]) -> Picture:
    """Return an image of numbers (H, W) by a color table; numbers without a color are black."""
    used, inverse = np.unique(numbers, return_inverse=True)
    table = np.array([colors.get(int(number), _BLACK) for number in used], np.uint8)
    return np.asarray(table[inverse.reshape(-1)].reshape(*numbers.shape, 3))


def depth_picture(depth: FloatArray) -> Picture:
    """Return depths (H, W) as gray levels: nearest white, farthest dark, background black."""
    is_finite = np.isfinite(depth)
    level = np.zeros(depth.shape)
    if is_finite.any():
        near, far = float(depth[is_finite].min()), float(depth[is_finite].max())
        level[is_finite] = 1.0 - 0.85 * (depth[is_finite] - near) / max(far - near, 1e-12 * abs(far), 1e-300)
    return np.repeat(np.rint(255 * level).astype(np.uint8)[:, :, None], 3, axis=2)


def normal_picture(normal: FloatArray, is_visible: npt.NDArray[np.bool_]) -> Picture:
    """Map world normals (H, W, 3) from [-1, 1] to [0, 255]; black on the background."""
    return np.where(is_visible[:, :, None], np.rint(127.5 * (normal + 1.0)), 0.0).astype(np.uint8)


def flow_picture(flow: Flow) -> Picture:
    """Return motion as colors: hue for direction, saturation for length; black where undefined."""
    motion = np.nan_to_num(flow.motion.astype(np.float64))
    length = np.hypot(motion[:, :, 0], motion[:, :, 1])
    strength = np.sqrt(np.clip(length / max(float(length.max()), 1e-9), 0.0, 1.0))[:, :, None]
    angle = np.arctan2(motion[:, :, 1], motion[:, :, 0])[:, :, None]
    hue = 0.5 + 0.5 * np.cos(angle - np.array([0.0, 2.0944, 4.1888]))
    known = np.isfinite(flow.motion[:, :, :1])
    return np.where(known, np.rint(255 * (1.0 - strength * (1.0 - hue))), 0.0).astype(np.uint8)


def with_boxes(picture: Picture, boxes: Sequence[DrawnBox]) -> Picture:
    """Return a copy of ``picture`` with boxes x0, y0, x1, y1 and their words, in their colors."""
    image = require("PIL.Image", "pillow").fromarray(picture)
    pen = require("PIL.ImageDraw", "pillow").Draw(image)
    font = require("PIL.ImageFont", "pillow").load_default(11)
    for (x0, y0, x1, y1), word, color in boxes[:_MAX_DRAWN_BOXES]:
        pen.rectangle((x0, y0, max(x0, x1 - 1), max(y0, y1 - 1)), outline=color)
        if x1 - x0 > 24:
            pen.text((x0 + 2, y0 + 1), _plain(word)[:24], fill=color, font=font, stroke_width=1, stroke_fill=_BLACK)
    return np.asarray(image, np.uint8).copy()


def with_tracks(picture: Picture, tracks: Tracks, frame: int, trail: int = 12) -> Picture:
    """Return a copy of ``picture``, frame number ``frame`` of a video, with the recent trajectories of tracked
    points."""
    image = require("PIL.Image", "pillow").fromarray(picture)
    pen = require("PIL.ImageDraw", "pillow").Draw(image)
    first = max(0, frame - trail)
    size = max(1.0, min(picture.shape[:2]) / 160.0)
    for point in range(tracks.pixels.shape[1]):
        color = instance_color(point + 1)
        trail_points = [tuple(place) for place in tracks.pixels[first : frame + 1, point] if np.isfinite(place).all()]
        if len(trail_points) > 1:
            pen.line(trail_points, fill=color, width=max(1, round(size)))
        if trail_points and tracks.state[frame, point] == VISIBLE:
            x, y = trail_points[-1]
            pen.ellipse((x - size, y - size, x + size, y + size), fill=color, outline=_BLACK)
    return np.asarray(image, np.uint8).copy()


def legend_picture(rows: Sequence[tuple[str, tuple[int, int, int]]]) -> Picture:
    """Return an image of the legend: a color swatch next to each name."""
    module, draw = require("PIL.Image", "pillow"), require("PIL.ImageDraw", "pillow")
    font = require("PIL.ImageFont", "pillow").load_default(13)
    shown = list(rows[:_MAX_LEGEND_ROWS])
    if len(rows) > len(shown):
        shown.append((f"{len(rows) - len(shown):,} more", (255, 255, 255)))
    names = [_plain(name)[:48] for name, _ in shown]
    widest = max((font.getlength(name) for name in names), default=0.0)
    image = module.new("RGB", (int(widest) + 36, _LEGEND_ROW_PX * max(1, len(shown)) + 8), (255, 255, 255))
    pen: Any = draw.Draw(image)
    for i, (name, (_, color)) in enumerate(zip(names, shown, strict=True)):
        top = 4 + i * _LEGEND_ROW_PX
        pen.rectangle((6, top + 2, 20, top + _LEGEND_ROW_PX - 3), fill=color)
        pen.text((28, top), name, fill=(20, 20, 20), font=font)
    return np.asarray(image, np.uint8).copy()


def _plain(word: str) -> str:
    """Return a word with spaces for unprintable characters, so that it stays on one line."""
    return "".join(c if c.isprintable() else " " for c in word)


# Files of one labeled image: PNG for viewing; NPZ, EXR and JSON for processing.


FORMAT, VERSION = "scenelang-maps", 1
_MAX_MAP_LEVELS = 64  # levels of the hierarchy with separate maps; each is two images and an array (H, W)
_MIN_BOX_AREA_PX = 24  # smallest instance whose box is drawn; a box around fewer pixels would cover them


class ShotMaps:
    """Collects the maps of one shot and writes them."""

    def __init__(self, truth: Truth, picture: Picture) -> None:
        self.truth = truth
        self.boxes = boxes_in(truth)
        self._picture = picture
        self._levels = _levels(truth)
        self._matched = correspondence_of(truth)
        self.arrays, self._layers = _arrays_of(truth, self._levels, self._matched)
        self._flow: ground_truth.Flow | None = None
        self._tracks: tuple[ground_truth.Tracks, int] | None = None

    def add_flow(self, flow: ground_truth.Flow) -> None:
        """Add the dense motion to the next frame."""
        self._flow = flow
        self.arrays |= {"flow": flow.motion, "flow_world": flow.world, "flow_state": flow.state}
        self._layers["flow"] = flow.motion

    def add_identities(self, paths: npt.NDArray[np.int64]) -> None:
        """Add the maps that identify points across frames; ``paths`` are the path numbers of the instances."""
        self.arrays |= _identities(self.truth, paths)

    def add_tracks(self, tracks: ground_truth.Tracks, frame: int) -> None:
        """Add tracked points at frame index ``frame``."""
        self._tracks = tracks, frame

    def _drawn(self) -> Iterator[tuple[str, Picture]]:
        """Yield the maps as images, by name."""
        yield from _pictures_of(self.truth, self._levels, self._matched, self.boxes, self._picture)
        if self._flow is not None:
            yield "flow", flow_picture(self._flow)
        if self._tracks is not None:
            yield "tracks", with_tracks(self._picture, *self._tracks)

    def write(self, folder: Path, handles: Sequence[str], bodies: IntArray, annotations: int) -> None:
        """Write all files to ``folder``; raises SceneError.

        ``handles`` and ``bodies`` (M,) are those of all instances, of which at most ``annotations`` are annotated.
        """
        save_picture(self._picture, folder / "color.png")
        for name, drawn in self._drawn():
            save_picture(drawn, folder / f"{name}.png")
        with open(folder / "maps.npz", "wb") as file:
            np.savez_compressed(file, **self.arrays)  # type: ignore[arg-type]
        write_exr(self._layers, folder / "maps.exr", frozenset(("normal", "flow")))
        write_json(folder / "camera.json", camera_to_json(self.truth.camera))
        write_json(folder / "legend.json", _legend(self.truth, handles, bodies))
        save_picture(_legend_picture(self.truth), folder / "legend.png")
        records = annotations_of(self.truth, self.boxes, handles, annotations)
        write_json(folder / "annotations.json", records)


def _pictures_of(
    truth: Truth, levels: Sequence[IntArray], matched: Correspondence, boxes: Boxes, picture: Picture
) -> Iterator[tuple[str, Picture]]:
    """Yield the maps as images, by name; ``levels`` are the instances (H, W) at each depth of the hierarchy."""
    ancestry = truth.ancestry
    named = {"": truth.instance} | {f"-depth-{depth}": level for depth, level in enumerate(levels)}
    for ending, instance in named.items():
        used = np.unique(instance[instance >= 0]).tolist()
        words = {number: word_color(ancestry.entity(number).word) for number in used}
        yield f"semantic{ending}", colored(instance, words)
        yield f"instances{ending}", colored(instance, {n: instance_color(n) for n in used})
    if truth.solids.part_words:
        words = {number: word_color(word) for number, word in enumerate(truth.solids.part_words)}
        yield "parts", colored(truth.part, words)
    place = np.rint(255 * matched.place).astype(np.uint8)
    grey = np.where(truth.seen, 96, 0).astype(np.uint8)[:, :, None]
    yield "correspondence", np.where((matched.unit >= 0)[:, :, None], place, grey)
    yield "depth", depth_picture(truth.depth)
    yield "normals", normal_picture(truth.normal, truth.seen)
    yield "albedo", encode(truth.albedo)
    yield "boxes", with_boxes(picture, _drawn_boxes(truth, boxes))


def _drawn_boxes(truth: Truth, boxes: Boxes) -> list[DrawnBox]:
    """Return the boxes to draw: those of objects, or of all large instances if none counts as an object."""
    ancestry = truth.ancestry
    large = np.flatnonzero((boxes.area > _MIN_BOX_AREA_PX) & (ancestry.depth > 0)).tolist()
    instances = [i for i in large if is_object(ancestry.entity(i))] or large
    words = [ancestry.entity(i).word for i in instances]
    return [(boxes.visible[i].tolist(), word, word_color(word)) for i, word in zip(instances, words, strict=True)]


def _levels(truth: Truth) -> list[IntArray]:
    """Return the instances (H, W) at each depth of the hierarchy."""
    return [truth.at_depth(depth) for depth in range(min(truth.ancestry.max_depth, _MAX_MAP_LEVELS) + 1)]


def _arrays_of(
    truth: Truth, levels: Sequence[IntArray], matched: Correspondence
) -> tuple[dict[str, npt.NDArray[Any]], dict[str, npt.NDArray[np.float32]]]:
    """Return the maps as arrays for an NPZ file, and as layers for an EXR file."""
    words = word_numbers(truth)
    number = np.array([words[entity.word] for entity in truth.ancestry.nodes], np.int32)
    numbers = np.append(number[truth.ancestry.node], 0).astype(np.int32)  # NOTHING is the last entry
    instances = np.stack(levels).astype(np.int32)

    def word_of(instance: npt.NDArray[Any]) -> npt.NDArray[np.int32]:
        """Return the word numbers of instances, 0 on the background."""
        return np.asarray(numbers[instance])

    arrays: dict[str, npt.NDArray[Any]] = {
        "instance": truth.instance.astype(np.int32),
        "semantic": word_of(truth.instance),
        "instance_by_depth": instances,
        "semantic_by_depth": word_of(instances),
        "correspondence_instance": matched.unit.astype(np.int32),
        "correspondence_word": word_of(matched.unit),
        "correspondence_place": matched.place,
        "depth": truth.depth,
        "normal": truth.normal.astype(np.float32),
        "albedo": truth.albedo.astype(np.float32),
        "position": truth.position,
    }
    if truth.solids.part_words:
        arrays["part"] = truth.part.astype(np.int32)
    layers = {name: arrays[name].astype(np.float32) for name in ("depth", "normal", "albedo", "instance", "semantic")}
    layers[""] = layers.pop("albedo")
    return arrays, layers


def _identities(truth: Truth, paths: npt.NDArray[np.int64]) -> dict[str, npt.NDArray[Any]]:
    """Return maps that identify points across frames: pixels with equal path numbers and local positions show the
    same point."""
    pixels = np.flatnonzero(truth.seen)
    places = ground_truth.places_of(truth, paths, pixels)
    path = np.full(truth.instance.size, -1, np.int32)
    local = np.zeros((truth.instance.size, 3), np.float32)
    path[pixels], local[pixels] = places.path, places.local
    return {"path": path.reshape(truth.instance.shape), "local": local.reshape(*truth.instance.shape, 3)}


def word_numbers(truth: Truth) -> dict[str, int]:
    """Return the numbers of the words, from 1; 0 is the background."""
    return {word: i + 1 for i, word in enumerate(sorted({entity.word for entity in truth.ancestry.nodes}))}


def _legend(truth: Truth, handles: Sequence[str], bodies: IntArray) -> dict[str, Any]:
    """Return the legend of the maps' numbers and colors, for visible instances and their ancestors."""
    ancestry = truth.ancestry
    shown = sorted(
        {int(i) for depth in range(ancestry.max_depth + 1) for i in np.unique(truth.at_depth(depth)) if i >= 0}
    )
    words = word_numbers(truth)
    return {
        "format": FORMAT,
        "version": VERSION,
        "nothing": {"semantic": 0, "instance": -1, "depth": "inf"},
        "words": [{"id": i, "word": word, "color": word_color(word)} for word, i in words.items()],
        "instances": [
            {
                "id": i,
                "word": ancestry.entity(i).word,
                "handle": handles[i],
                "depth": int(ancestry.depth[i]),
                "parent": int(ancestry.parent[i]),
                "path": list(ancestry.path(i)),
                "body": int(bodies[i]),
                "color": instance_color(i),
            }
            for i in shown
        ],
        "parts": [{"id": i, "word": word, "color": word_color(word)} for i, word in enumerate(truth.solids.part_words)],
        "flow_state": {"gone": ground_truth.GONE, "hidden": ground_truth.HIDDEN, "visible": ground_truth.VISIBLE},
        "axes": "depth along the optical axis, in scene units; normals and positions in the world; pixels from the top "
        "left corner, their centers at half-integers",
    }


def _legend_picture(truth: Truth) -> Picture:
    """Return the legend of the words of a shot."""
    words = sorted({truth.ancestry.nodes[i].word for i in np.unique(truth.ancestry.node).tolist()})
    return legend_picture([(word, word_color(word)) for word in words])


@dataclass(frozen=True, slots=True)
class MapOptions:
    """Options of labeled datasets.

    ``pictures`` sets size, lighting, backend options, seed and limit. ``views`` are the cameras; placed ones keep their
    size unless ``resize``. ``tracks`` is the number of tracked points of a 4D scene, ``annotations`` the maximum number
    of annotated instances of a shot. ``digest`` identifies the program and all inputs of its run.
    """

    pictures: PictureOptions
    views: tuple[View, ...]
    resize: bool = True
    tracks: int = setting(64, "number of tracked points of 4D scenes (default 64)", metavar="N", read=whole)
    annotations: int = setting(
        20_000, "maximum instances of a picture in coco.json (default 20,000)", metavar="N", read=whole
    )
    digest: str = ""


@dataclass(frozen=True, slots=True)
class DatasetItem:
    """One shot to write: ``view`` and ``frame`` are indices, ``folder`` is the destination."""

    name: str
    view: int
    frame: int
    folder: Path


def items_of(folder: Path, name: str, scene: Scene, views: int, alone: bool, frame: int | None) -> list[DatasetItem]:
    """Return the shots of one scene, camera by camera; ``alone`` if it is the only scene of its dataset."""
    frames = range(len(scene.frames)) if frame is None else [frame]
    items = []
    for view in range(views):
        for number in frames:
            parts = [] if alone else [name]
            parts += [f"camera-{view:03d}"] if views > 1 else []
            parts += [f"frame-{number:03d}"] if len(frames) > 1 else []
            items.append(DatasetItem(name, view, number, folder.joinpath(*parts)))
    return items


def names_of(files: Sequence[str]) -> list[str]:
    """Return a distinct name for each program of a dataset."""
    names: list[str] = []
    for path in files:
        stem = Path(path).stem if path != "-" else "scene"
        name, number = stem, 2
        while name in names:
            name, number = f"{stem}-{number}", number + 1
        names.append(name)
    return names


def check_set_folder(folder: Path) -> None:
    """Raise SceneError if ``folder`` cannot be created as a directory."""
    if folder.suffix.lower() in (*STILL_ENDINGS, ".zip") and not folder.exists():
        hint = f"labels are several files: `-o {folder.with_suffix('')}`"
        raise SceneError("file", f"{folder} is a name of a file", hint)
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        raise SceneError("file", f"cannot write to {folder}: {existing} is not a folder")


@dataclass(frozen=True, slots=True)
class LabeledScene:
    """Scene of a dataset; ``fingerprint`` is its program and all inputs of its run, to detect changes."""

    name: str
    scene: Scene
    fingerprint: tuple[str, ...]


def write_set(
    scenes: Iterable[LabeledScene],
    folder: Path,
    options: MapOptions,
    backend_of: Callable[[Scene], PictureBackend],
    *,
    alone: bool = False,
    frame: int | None = None,
    progress: Callable[[str], Progress | None] | None = None,
    skipped: Callable[[DatasetItem], None] | None = None,
) -> list[DatasetItem]:
    """Label the scenes one after the other and list all in ``coco.json``; existing shots are reused. Raises SceneError.

    ``backend_of`` returns the backend that draws a scene. With ``alone``, the only scene of a dataset gets no separate
    folder.
    """
    items: list[DatasetItem] = []
    with new_folder(folder):
        for labeled in scenes:
            backend = backend_of(labeled.scene)
            fingerprint = "\0".join((*labeled.fingerprint, backend.name))
            digest = hashlib.sha256(fingerprint.encode("utf-8", "surrogatepass")).hexdigest()
            if frame is not None:
                frame_of(labeled.scene, frame)
            scene_items = items_of(folder, labeled.name, labeled.scene, len(options.views), alone, frame)
            scene_progress = progress(labeled.name) if progress is not None else None
            write_maps(labeled.scene, scene_items, replace(options, digest=digest), backend, scene_progress, skipped)
            items += scene_items
        if items:
            write_coco(folder, items)
    return items


def write_maps(
    scene: Scene,
    items: Sequence[DatasetItem],
    options: MapOptions,
    backend: PictureBackend,
    progress: Progress | None = None,
    skipped: Callable[[DatasetItem], None] | None = None,
) -> None:
    """Write the shots ``items`` of one scene that do not exist yet; calls ``skipped`` for each that does.

    Raises SceneError. No shot is left half-written.
    """
    box_of(scene)  # report an empty scene before anything is written
    scene = drawn_scene(scene, options.pictures.limit, options.pictures.warn)  # label the drawn geometry
    facts, total = SceneFacts(scene), len(items)
    for view in dict.fromkeys(item.view for item in items):
        view_items = [item for item in items if item.view == view]
        missing = [item for item in view_items if not _is_done(item, options)]
        for item in view_items:
            if item not in missing and skipped is not None:
                skipped(item)
        if missing:
            start = items.index(view_items[0]) / total
            share = sub_progress(progress, start, start + len(view_items) / total)
            _write_view(facts, view_items, missing, options, backend, share)
    if progress is not None:
        progress(1.0)


def _is_done(item: DatasetItem, options: MapOptions) -> bool:
    """Return whether a shot is complete and was made from the same program with the same options."""
    try:
        record = json.loads((item.folder / "shot.json").read_text("utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(record, dict) and record.get("digest") == _digest(item, options)


def _digest(item: DatasetItem, options: MapOptions) -> str:
    """Return the digest of everything that determines the files of a shot."""
    settings = replace(options.pictures, progress=None, warn=None, camera=Viewpoint())
    view = options.views[item.view]
    view_text = json.dumps(camera_to_json(view)) if isinstance(view, Camera) else repr(view)
    map_settings = (options.digest, options.resize, options.tracks, options.annotations)
    fingerprint = repr((FORMAT, VERSION, map_settings, settings, view_text, item.frame))
    return hashlib.sha256(fingerprint.encode()).hexdigest()


def _write_view(
    facts: SceneFacts,
    items: Sequence[DatasetItem],
    missing: Sequence[DatasetItem],
    options: MapOptions,
    backend: PictureBackend,
    progress: Progress | None,
) -> None:
    """Write the ``missing`` shots of one view, whose shots are ``items``, and its tracks."""
    camera = options.views[items[0].view]
    picture_options = settled(facts.scene, replace(options.pictures, camera=camera))
    if isinstance(camera, Camera) and not options.resize:
        picture_options = replace(picture_options, width=camera.width, height=camera.height)
    view = labeled_view(facts, picture_options, backend, [item.frame for item in items], options.tracks)
    for i, item in enumerate(missing):
        _write_shot(view, item, options, sub_progress(progress, i / len(missing), (i + 1) / len(missing)))
    if view.tracks is not None:
        write_tracks(items[0].folder.parent, view.tracks)


def write_tracks(folder: Path, tracks: ground_truth.Tracks) -> None:
    """Write ``tracks.npz``; raises SceneError."""
    with atomic_write(folder / "tracks.npz") as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, pixels=tracks.pixels, world=tracks.world, state=tracks.state)


# --- one shot --------------------------------------------------------------------------------------------------


def _write_shot(view: LabeledView, item: DatasetItem, options: MapOptions, progress: Progress | None) -> None:
    """Write the files of one shot; its ``shot.json`` is written last and marks it as complete."""
    picture = view.image(item.frame, sub_progress(progress, 0.0, 0.7)).picture
    maps = ShotMaps(view.truth(item.frame), picture)
    flow = view.flow(item.frame)
    if flow is not None:
        maps.add_flow(flow)
    if view.tracks is not None:
        maps.add_identities(view.paths(item.frame))
        maps.add_tracks(view.tracks, list(view.shots).index(item.frame))
    handles = view.handles(item.frame)
    shot = {"format": FORMAT, "version": VERSION, "name": item.name, "camera": item.view, "frame": item.frame}
    with new_folder(item.folder):
        _mark_incomplete(item.folder)
        with atomic_write_all(item.folder) as target:
            maps.write(target, handles, view.bodies(item.frame), options.annotations)
        write_json(item.folder / "shot.json", shot | {"digest": _digest(item, options)})
    if progress is not None:
        progress(1.0)


# --- files -----------------------------------------------------------------------------------------------------


def _mark_incomplete(folder: Path) -> None:
    """Mark the folder of a shot as incomplete."""
    try:
        (folder / "shot.json").unlink(missing_ok=True)
    except OSError as error:
        raise SceneError("file", f"cannot write to `{folder}`: {error.strerror or error}") from error


def write_coco(folder: Path, items: Sequence[DatasetItem]) -> None:
    """Write ``coco.json`` for all shots of a dataset, from their annotations; raises SceneError."""
    images, annotations = [], []
    for item in items:
        camera = json.loads((item.folder / "camera.json").read_text("utf-8"))
        name = (item.folder / "color.png").relative_to(folder).as_posix()
        size = {"width": camera["width"], "height": camera["height"]}
        images.append({"file_name": name, **size, "scene": item.name, "camera": camera, "frame": item.frame})
        annotations.append(json.loads((item.folder / "annotations.json").read_text("utf-8")))
    write_json(folder / "coco.json", dataset(images, annotations))
