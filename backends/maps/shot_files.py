"""The files of one labelled picture: PNG for people, NPZ, EXR and JSON for machines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.camera import camera_to_json
from scenelang.backends.exr import write_exr
from scenelang.backends.files import write_json
from scenelang.backends.maps import coco, motion, pictures
from scenelang.backends.maps.boxes import Boxes, boxes_in
from scenelang.backends.maps.truth import Correspondence, Truth, correspondence_of
from scenelang.backends.picture import save_picture
from scenelang.backends.solids import is_semantic
from scenelang.backends.studio import encode
from scenelang.interpreter.entity import Entity

IntArray = npt.NDArray[np.int64]

FORMAT, VERSION = "scenelang-maps", 1
_DEEPEST = 64  # levels of the hierarchy that have maps of their own
_LEAST_AREA = 24  # pixels of an instance whose box is drawn


class ShotMaps:
    """Gathers what is known of one shot, then writes it."""

    def __init__(self, truth: Truth, picture: pictures.Picture) -> None:
        self.truth = truth
        self._picture = picture
        self._boxes = boxes_in(truth)
        levels = [truth.at_depth(depth) for depth in range(min(truth.ancestry.deepest, _DEEPEST) + 1)]
        matched = correspondence_of(truth)
        self._arrays, self._layers = _arrays_of(truth, levels, matched)
        self._drawn = dict(_pictures_of(truth, levels, matched, self._boxes, picture))

    def add_flow(self, flow: motion.Flow) -> None:
        """The dense correspondence to the next frame."""
        self._drawn["flow"] = pictures.flow_picture(flow)
        self._arrays |= {"flow": flow.motion, "flow_world": flow.world, "flow_state": flow.state}
        self._layers["flow"] = flow.motion

    def add_tracks(self, tracks: motion.Tracks, frame: int, paths: npt.NDArray[np.int64]) -> None:
        """Tracked points at the ``frame``-th of their places; ``paths`` are the instances' path numbers."""
        self._drawn["tracks"] = pictures.with_tracks(self._picture, tracks, frame)
        self._arrays |= _identities(self.truth, paths)

    def write(self, folder: Path, handles: Sequence[str], annotations: int) -> None:
        """Write everything into ``folder``; ``handles`` are those of all instances, of which at most ``annotations``
        are annotated. Raises SceneError."""
        save_picture(self._picture, folder / "color.png")
        for name, drawn in self._drawn.items():
            save_picture(drawn, folder / f"{name}.png")
        with open(folder / "maps.npz", "wb") as file:
            np.savez_compressed(file, **self._arrays)  # type: ignore[arg-type]
        write_exr(self._layers, folder / "maps.exr", frozenset(("normal", "flow")))
        write_json(folder / "camera.json", camera_to_json(self.truth.camera))
        write_json(folder / "legend.json", _legend(self.truth, handles))
        save_picture(_legend_picture(self.truth), folder / "legend.png")
        found = coco.annotations_of(self.truth, self._boxes, handles, annotations)
        write_json(folder / "annotations.json", found)


def _pictures_of(
    truth: Truth, levels: Sequence[IntArray], matched: Correspondence, boxes: Boxes, picture: pictures.Picture
) -> Iterator[tuple[str, pictures.Picture]]:
    """The maps as pictures, by name. ``levels`` are the instances (H, W) at each depth of the hierarchy."""
    ancestry = truth.ancestry
    named = {"": truth.instance} | {f"-depth-{depth}": level for depth, level in enumerate(levels)}
    for ending, instance in named.items():
        used = np.unique(instance[instance >= 0]).tolist()
        words = {number: pictures.word_color(ancestry.entity(number).word) for number in used}
        yield f"semantic{ending}", pictures.colored(instance, words)
        yield f"instances{ending}", pictures.colored(instance, {n: pictures.instance_color(n) for n in used})
    place = np.rint(255 * matched.place).astype(np.uint8)
    grey = np.where(truth.seen, 96, 0).astype(np.uint8)[:, :, None]
    yield "correspondence", np.where((matched.unit >= 0)[:, :, None], place, grey)
    yield "depth", pictures.depth_picture(truth.depth)
    yield "normals", pictures.normal_picture(truth.normal, truth.seen)
    yield "albedo", encode(truth.albedo)
    yield "boxes", pictures.with_boxes(picture, _drawn_boxes(truth, boxes))


def _is_thing(entity: Entity) -> bool:
    """Whether an entity has a name of its own, rather than being one of the primitives that things are made of."""
    return not entity.is_primitive or is_semantic(entity)


def _drawn_boxes(truth: Truth, boxes: Boxes) -> list[pictures.DrawnBox]:
    """The boxes that are drawn: of things and their parts rather than of the primitives that these are made of."""
    ancestry = truth.ancestry
    large = np.flatnonzero((boxes.area > _LEAST_AREA) & (ancestry.depth > 0)).tolist()
    things = [i for i in large if _is_thing(ancestry.entity(i))] or large
    words = [ancestry.entity(i).word for i in things]
    return [(boxes.visible[i].tolist(), word, pictures.word_color(word)) for i, word in zip(things, words, strict=True)]


def _arrays_of(
    truth: Truth, levels: Sequence[IntArray], matched: Correspondence
) -> tuple[dict[str, npt.NDArray[Any]], dict[str, npt.NDArray[np.float32]]]:
    """The maps as arrays for an NPZ file, and as layers for an EXR file."""
    words = _words(truth)
    number = np.array([words[entity.word] for entity in truth.ancestry.nodes], np.int32)
    instances = np.stack(levels).astype(np.int32)

    def word_of(instance: npt.NDArray[Any]) -> npt.NDArray[np.int32]:
        own = number[truth.ancestry.node[np.maximum(instance, 0)]]
        return np.where(instance >= 0, own, 0).astype(np.int32)

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
    layers = {name: arrays[name].astype(np.float32) for name in ("depth", "normal", "albedo", "instance", "semantic")}
    layers[""] = layers.pop("albedo")
    return arrays, layers


def _identities(truth: Truth, paths: npt.NDArray[np.int64]) -> dict[str, npt.NDArray[Any]]:
    """What is the same in all frames: pixels with equal path numbers and places in the object show the same point."""
    pixels = np.flatnonzero(truth.seen)
    places = motion.places_of(truth, paths, pixels)
    path = np.full(truth.instance.size, -1, np.int32)
    local = np.zeros((truth.instance.size, 3), np.float32)
    path[pixels], local[pixels] = places.path, places.local
    return {"path": path.reshape(truth.instance.shape), "local": local.reshape(*truth.instance.shape, 3)}


def _words(truth: Truth) -> dict[str, int]:
    """Numbers of the words, from 1: 0 is where nothing is seen."""
    return {word: i + 1 for i, word in enumerate(sorted({entity.word for entity in truth.ancestry.nodes}))}


def _legend(truth: Truth, handles: Sequence[str]) -> dict[str, Any]:
    """What the numbers and colours of the maps mean; of the instances those that are seen, and their ancestors."""
    ancestry = truth.ancestry
    shown = sorted(
        {int(i) for depth in range(ancestry.deepest + 1) for i in np.unique(truth.at_depth(depth)) if i >= 0}
    )
    words = _words(truth)
    return {
        "format": FORMAT,
        "version": VERSION,
        "nothing": {"semantic": 0, "instance": -1, "depth": "inf"},
        "words": [{"id": i, "word": word, "color": pictures.word_color(word)} for word, i in words.items()],
        "instances": [
            {
                "id": i,
                "word": ancestry.entity(i).word,
                "handle": handles[i],
                "depth": int(ancestry.depth[i]),
                "parent": int(ancestry.parent[i]),
                "path": list(ancestry.path(i)),
                "color": pictures.instance_color(i),
            }
            for i in shown
        ],
        "flow_state": {"gone": motion.GONE, "hidden": motion.HIDDEN, "visible": motion.VISIBLE},
        "axes": "depth along the axis of view, in scene units; normals and positions in the world; pixels from the top "
        "left corner, their centres at halves",
    }


def _legend_picture(truth: Truth) -> pictures.Picture:
    words = sorted({truth.ancestry.entity(int(i)).word for i in np.unique(truth.ancestry.node)})
    return pictures.legend_picture([(word, pictures.word_color(word)) for word in words])
