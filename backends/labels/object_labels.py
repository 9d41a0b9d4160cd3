"""Objects in an image: masks, boxes, poses, visibility and keypoints of the instances that count as objects.

A pixel shows a primitive; its object is the nearest instance up the hierarchy whose word counts. By default every word
that the program binds and every semantic primitive counts, and plain primitives do not: a pixel of a rook is "rook",
not "cylinder". (``maps`` keeps the primitive, for the paper's hierarchy; a dataset writes both.)
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.labels.ground_truth import NOTHING, Boxes, Truth, boxes_in, boxes_of
from scenelang.backends.pictures.rays import camera_rays, caster_for
from scenelang.backends.surfaces.solids import is_object, normalized
from scenelang.grammar.diagnostics import LimitError

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Uint16Array = npt.NDArray[np.uint16]

MAX_OBJECTS = 65_535  # ids of an image are 16-bit PNG values; 0 is the background
OTHER = 65_535  # class of words that are missing from the table of classes
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64)  # corners of the unit cube


@dataclass(frozen=True, eq=False)
class ObjectLabels:
    """Objects of one shot.

    Attributes
    ----------
    truth : Truth
        Ground truth of the shot.
    owner : (M,) int64
        The object of each instance, NOTHING if it belongs to none.
    shown : (K,) int64
        The visible objects, ascending; their ids are 1 to K.
    """

    truth: Truth
    owner: IntArray
    shown: IntArray

    @cached_property
    def boxes(self) -> Boxes:
        """Boxes of all instances, in pixels."""
        return boxes_in(self.truth)

    @cached_property
    def ids(self) -> Uint16Array:
        """Map (H, W) of object ids, 0 on the background and on pixels without an object."""
        return self.numbered(self.owner, self.shown)

    def numbered(self, owner: IntArray, shown: IntArray) -> Uint16Array:
        """Return the map (H, W) of positions from 1 of ``owner[instance]`` in ``shown`` (K,), ascending; else 0."""
        table = np.zeros(len(owner) + 1, np.uint16)
        table[:-1] = np.where(owner >= 0, np.searchsorted(shown, owner) + 1, 0)
        return np.asarray(table[self.truth.instance])  # NOTHING is the last entry

    def classes(self, table: Mapping[str, int]) -> Uint16Array:
        """Return the map (H, W) of object classes by word, 0 on the background, OTHER for unknown words."""
        class_ids = [table.get(self.truth.ancestry.entity(i).word, OTHER) for i in self.shown.tolist()]
        return np.asarray(np.array([0, *class_ids], np.uint16)[self.ids])

    def shares(self, words: Collection[str]) -> dict[str, float]:
        """Return the share of the image that shows each word or its parts."""
        ancestry, truth = self.truth.ancestry, self.truth
        total = dict.fromkeys(words, 0)
        for depth in range(ancestry.max_depth + 1):
            instances, areas = np.unique(truth.at_depth(depth), return_counts=True)
            for instance, pixels in zip(instances.tolist(), areas.tolist(), strict=True):
                is_at_depth = instance >= 0 and ancestry.depth[instance] == depth
                if is_at_depth and ancestry.entity(instance).word in total and not self._is_inside_own(instance):
                    total[ancestry.entity(instance).word] += pixels
        return {word: pixels / truth.instance.size for word, pixels in total.items()}

    def _is_inside_own(self, instance: int) -> bool:
        """Return whether an instance is part of another one of its word, which counts its pixels already."""
        ancestry = self.truth.ancestry
        word, above = ancestry.entity(instance).word, int(ancestry.parent[instance])
        while above >= 0:
            if ancestry.entity(above).word == word:
                return True
            above = int(ancestry.parent[above])
        return False


def objects_of(truth: Truth, words: Collection[str] = ()) -> ObjectLabels:
    """Return the objects of a shot.

    ``words`` are the words that count as objects, by default those that the module names. Raises LimitError if more
    than ``MAX_OBJECTS`` are visible.
    """
    ancestry = truth.ancestry
    is_counted = np.array([e.word in words if words else is_object(e) for e in ancestry.nodes], bool)
    owner = np.full(len(ancestry), NOTHING, np.int64)
    for depth in range(ancestry.max_depth + 1):
        rows = np.flatnonzero(ancestry.depth == depth)
        above = owner[ancestry.parent[rows]] if depth else np.full(len(rows), NOTHING)
        owner[rows] = np.where(is_counted[ancestry.node[rows]], rows, above)
    visible = np.unique(truth.instance)
    shown = np.unique(owner[visible[visible >= 0]])
    shown = with_ancestors(shown[shown >= 0], owner, ancestry.parent)
    if len(shown) > MAX_OBJECTS:
        raise LimitError(
            "primitives", f"{len(shown):,} things are visible, more than the {MAX_OBJECTS:,} that a map can number",
            hint="reduce the size of the pictures, or name the words that count in `words`",
        )  # fmt: skip
    return ObjectLabels(truth, owner, shown)


def with_ancestors(shown: IntArray, owner: IntArray, parent: IntArray) -> IntArray:
    """Return the objects ``shown`` and the objects that contain them, ascending."""
    known = shown
    while len(shown):
        above = parent[shown]
        shown = np.unique(np.where(above >= 0, owner[above], NOTHING))
        shown = np.setdiff1d(shown[shown >= 0], known)
        known = np.union1d(known, shown)
    return known


# --- records ---------------------------------------------------------------------------------------------------------


def object_records(
    objects: ObjectLabels, handles: Mapping[int, str], classes: Mapping[str, int], covered: IntArray | None
) -> list[dict[str, Any]]:
    """Return the JSON record of each visible object, in the order of their ids.

    Parameters
    ----------
    objects : ObjectLabels
        Objects of the shot.
    handles : Mapping[int, str]
        Handles by instance.
    classes : Mapping[str, int]
        Class ids by word.
    covered : (M,) int64, optional
        Pixels that each instance would cover without the others; None omits the visibility.
    """
    truth, boxes, ancestry = objects.truth, objects.boxes, objects.truth.ancestry
    low, high = boxes_of(ancestry, objects.shown)
    above = np.where(ancestry.parent[objects.shown] >= 0, objects.owner[ancestry.parent[objects.shown]], NOTHING)
    oriented = oriented_boxes(ancestry.poses[objects.shown], low, high)
    parents = np.where(above >= 0, np.searchsorted(objects.shown, above) + 1, 0).tolist()
    truncated = _truncations(boxes.full[objects.shown], truth)
    records = []
    for k, instance in enumerate(objects.shown.tolist()):
        x0, y0, x1, y1 = (int(edge) for edge in boxes.visible[instance])
        entity, full, area = ancestry.entity(instance), boxes.full[instance], int(boxes.area[instance])
        record: dict[str, Any] = {
            "id": k + 1,
            "word": entity.word,
            "class": classes.get(entity.word, OTHER),
            "handle": handles[instance],
            "parent": parents[k],
            "depth": int(ancestry.depth[instance]),
            "path": list(ancestry.path(instance)),
            "area": area,
            "bbox": [x0, y0, x1 - x0, y1 - y0],
            "bbox_full": None if np.isnan(full).any() else [float(v) for v in (*full[:2], *(full[2:] - full[:2]))],
            "pose": ancestry.poses[instance].tolist(),
            "box": [low[k].tolist(), high[k].tolist()],
            "box3d": oriented[k],
            "truncation": truncated[k],
        }
        if covered is not None:
            record["visibility"] = min(1.0, area / max(1, int(covered[instance])))
            record["area_alone"] = int(covered[instance])
        records.append(record)
    return records


def hidden_records(objects: ObjectLabels, rows: IntArray) -> list[dict[str, Any]]:
    """Return the word, depth, path and full box of the hidden instances ``rows`` that project into the image."""
    ancestry, camera = objects.truth.ancestry, objects.truth.camera
    records = []
    for instance in rows.tolist():
        x0, y0, x1, y1 = (float(edge) for edge in objects.boxes.full[instance])
        if x1 > 0 and y1 > 0 and x0 < camera.width and y0 < camera.height:  # false for NaN: behind the camera
            records.append({
                "word": ancestry.entity(instance).word, "depth": int(ancestry.depth[instance]),
                "path": list(ancestry.path(instance)), "bbox_full": [x0, y0, x1 - x0, y1 - y0],
            })  # fmt: skip
    return records


def _truncations(full: FloatArray, truth: Truth) -> list[float | None]:
    """Return the fraction of each rectangle (K, 4) outside the image, None if it is partly behind the camera."""
    size = np.array([truth.camera.width, truth.camera.height])
    areas = np.prod(full[:, 2:] - full[:, :2], axis=1)
    visible_areas = np.prod(np.clip(full[:, 2:], 0, size) - np.clip(full[:, :2], 0, size), axis=1)
    with np.errstate(all="ignore"):
        share = np.where(areas > 0.0, np.maximum(0.0, 1.0 - visible_areas / areas), 0.0)
    behind: list[bool] = np.asarray(np.isnan(full).any(axis=1)).tolist()
    return [None if hidden else value for hidden, value in zip(behind, share.tolist(), strict=True)]


def oriented_boxes(poses: FloatArray, low: FloatArray, high: FloatArray) -> list[dict[str, Any]]:
    """Return the oriented boxes of entities in the world.

    ``poses`` (K, 3, 4) map the entities' frames, in which the boxes extend from ``low`` to ``high`` (K, 3), to the
    world. Each box has ``center`` (3,), ``rotation`` (3, 3) from the box's axes, and ``size`` (3,). A sheared pose
    gives the nearest rotation and the extent along its axes.
    """
    corners = low[:, None] + _CORNERS * (high - low)[:, None]
    world = np.einsum("nij,nkj->nki", poses[:, :, :3], corners) + poses[:, None, :, 3]
    rotation = rigid_parts(poses[:, :, :3])
    along = np.einsum("nki,nij->nkj", world, rotation)
    near, far = along.min(axis=1), along.max(axis=1)
    center = np.einsum("nij,nj->ni", rotation, (near + far) / 2.0)
    columns = center.tolist(), rotation.tolist(), (far - near).tolist()
    return [{"center": c, "rotation": r, "size": s} for c, r, s in zip(*columns, strict=True)]


def rigid_parts(linear: FloatArray) -> FloatArray:
    """Return the rotations (K, 3, 3) nearest to linear maps (K, 3, 3) without their scales.

    Those of reflections have a mirrored z axis. The result is the orthogonal polar factor, computed by a singular value
    decomposition (Higham, "Computing the polar decomposition", 1986).
    """
    lengths = np.linalg.norm(linear, axis=1, keepdims=True)
    u, _, vt = np.linalg.svd(linear / np.where(lengths > 1e-300, lengths, 1.0))
    rotation = u @ vt
    rotation[:, :, 2] *= np.where(np.linalg.det(rotation) < 0.0, -1.0, 1.0)[:, None]
    return np.asarray(rotation, np.float64)


def pixels_alone(objects: ObjectLabels, center: FloatArray, scale: float) -> IntArray:
    """Return the pixels (M,) that each object would cover if nothing else were in the scene; 0 for other instances.

    ``center`` (3,) and ``scale`` bring the scene to unit size.
    """
    truth, ancestry = objects.truth, objects.truth.ancestry
    camera = truth.camera.rescaled(center, scale)
    caster = caster_for(normalized(truth.solids, center, scale), camera_rays(camera))
    counts = np.zeros(len(ancestry), np.int64)
    levels = _levels_of(objects)
    owner = objects.owner[ancestry.primitives[truth.solids.instance]]
    for nesting in range(int(levels.max(initial=-1)), -1, -1):  # pixels of a part count for its containers too
        is_at_level = (owner >= 0) & (levels[owner] == nesting)
        for group, pixels in caster.covered(np.where(is_at_level, owner, NOTHING)):
            counts[group] = pixels
        above = ancestry.parent[owner]
        owner = np.where(is_at_level, np.where(above >= 0, objects.owner[above], NOTHING), owner)
    return counts


def _levels_of(objects: ObjectLabels) -> IntArray:
    """Return for every object (M,) how many objects contain it; -1 for other instances."""
    ancestry = objects.truth.ancestry
    level = np.full(len(ancestry), -1, np.int64)
    rows = np.flatnonzero(objects.owner == np.arange(len(ancestry)))
    above = np.where(ancestry.parent[rows] >= 0, objects.owner[ancestry.parent[rows]], NOTHING)
    for instance, container in zip(rows.tolist(), above.tolist(), strict=True):  # parents precede their children
        level[instance] = level[container] + 1 if container >= 0 else 0
    return level


def keypoint_records(objects: ObjectLabels, words: Collection[str], limit: int = 10_000) -> list[dict[str, Any]]:
    """Return the keypoints of a shot: the box centers of all instances of ``words``, at most ``limit``.

    ``visible`` is 2 if the instance is visible at its center, 1 if it is hidden, 0 outside the image, as in COCO.
    """
    truth, ancestry = objects.truth, objects.truth.ancestry
    is_keypoint = np.array([entity.word in words for entity in ancestry.nodes], bool)
    rows = np.flatnonzero(is_keypoint[ancestry.node])[:limit]
    low, high = boxes_of(ancestry, rows)
    poses = ancestry.poses[rows]
    world = np.einsum("nij,nj->ni", poses[:, :, :3], (low + high) / 2.0) + poses[:, :, 3]
    pixels, depth = truth.camera.project(world)
    records = []
    for k, instance in enumerate(rows.tolist()):
        x, y = pixels[k].tolist()
        owner = int(objects.owner[instance])
        slot = int(np.searchsorted(objects.shown, owner)) if owner >= 0 else len(objects.shown)
        is_shown = slot < len(objects.shown) and objects.shown[slot] == owner
        inside = depth[k] > 0.0 and 0.0 <= x < truth.camera.width and 0.0 <= y < truth.camera.height
        records.append(
            {
                "word": ancestry.entity(instance).word,
                "thing": slot + 1 if is_shown else 0,
                "point": [x, y] if depth[k] > 0.0 else None,
                "world": world[k].tolist(),
                "visible": 0 if not inside else 2 if _shows(truth, int(y), int(x), instance) else 1,
            }
        )
    return records


def _shows(truth: Truth, row: int, column: int, instance: int) -> bool:
    """Return whether a pixel shows an instance or one of its parts."""
    shown = int(truth.instance[row, column])
    while shown > instance:  # parents have smaller numbers
        shown = int(truth.ancestry.parent[shown])
    return shown == instance


def levels_data(objects: ObjectLabels, most: int) -> list[tuple[Uint16Array, list[dict[str, Any]]]]:
    """Return the map (H, W) and the id records of each level of the hierarchy below the root, at most ``most``.

    The id of a pixel is that of its ancestor at the level, or of the primitive itself if it is higher up. The last
    level, if any are visible, has the parts of computed solids, by the words of their operands.
    """
    truth, ancestry = objects.truth, objects.truth.ancestry
    levels = []
    for depth in range(1, min(ancestry.max_depth, most) + 1):
        ancestors = ancestry.at_depth(depth)
        visible = np.unique(truth.instance)
        shown = np.unique(ancestors[visible[visible >= 0]])
        if len(shown) > MAX_OBJECTS:
            raise LimitError("primitives", f"{len(shown):,} instances are visible at level {depth}, more than 65,535")
        records = [
            {"id": k + 1, "word": ancestry.entity(i).word, "path": list(ancestry.path(i))}
            for k, i in enumerate(shown.tolist())
        ]
        levels.append((objects.numbered(ancestors, shown), records))
    parts = _parts_level(truth)
    return [*levels, parts] if parts is not None and len(levels) < most else levels


def _parts_level(truth: Truth) -> tuple[Uint16Array, list[dict[str, Any]]] | None:
    """Return the map (H, W) and the records of the parts of computed solids, None if none is visible."""
    words = truth.solids.part_words
    if not (truth.part >= 0).any():
        return None
    key = np.where(truth.seen, truth.instance * (len(words) + 1) + truth.part + 1, NOTHING)
    shown, place = np.unique(key, return_inverse=True)
    first = int(shown[0] == NOTHING)
    if len(shown) > MAX_OBJECTS:
        raise LimitError("primitives", f"{len(shown):,} parts are visible, more than 65,535")
    records = []
    for k, number in enumerate(shown[first:].tolist()):
        instance, part = divmod(number, len(words) + 1)
        word = words[part - 1] if part else truth.ancestry.entity(instance).word
        records.append({"id": k + 1, "word": word, "path": list(truth.ancestry.path(instance)), "part": part > 0})
    return (place.reshape(key.shape) + 1 - first).astype(np.uint16), records


def graph_data(
    truth: Truth,
    handles: Callable[[Sequence[int]], Mapping[int, str]],
    words: Collection[str] = (),
    limit: int = 20_000,
) -> dict[str, Any]:
    """Return the scene graph of a frame: its objects in breadth-first order, at most ``limit``, with poses and boxes.

    ``handles`` maps instances to their handles. ``parent`` is the position of the containing object in the list, -1 for
    none; ``more`` is the number of omitted objects.
    """
    ancestry = truth.ancestry
    is_counted = np.array([e.word in words if words else is_object(e) for e in ancestry.nodes], bool)
    candidates = np.flatnonzero(is_counted[ancestry.node])
    rows = candidates[:limit]
    handle_of = handles(rows.tolist())
    position_of = {instance: k for k, instance in enumerate(rows.tolist())}
    low, high = boxes_of(ancestry, rows)
    nodes = []
    for k, instance in enumerate(rows.tolist()):
        above = int(ancestry.parent[instance])
        while above >= 0 and above not in position_of:
            above = int(ancestry.parent[above])
        nodes.append(
            {
                "word": ancestry.entity(instance).word,
                "handle": handle_of[instance],
                "parent": position_of.get(above, -1),
                "pose": ancestry.poses[instance].tolist(),
                "box": [low[k].tolist(), high[k].tolist()],
            }
        )
    return {"nodes": nodes, "more": len(candidates) - len(rows)}
