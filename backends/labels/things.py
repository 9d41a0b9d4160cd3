"""Things in a picture: the instances that count as objects, with masks, boxes, poses, visibility and keypoints.

A pixel shows a primitive; the thing that it belongs to is the nearest instance up the hierarchy whose word counts. By
default every word that the program binds and every semantic primitive counts, and plain primitives do not.
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

MAX_THINGS = 65_535  # ids of one picture, which are 16 bits
OTHER = 65_535  # class of words that the table of classes lacks
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64)


@dataclass(frozen=True, eq=False)
class Things:
    """Things of one shot.

    ``truth`` is its ground truth; ``owner`` (M,) is for every instance the thing that it belongs to, NOTHING if there
    is none; ``shown`` (K,) are the visible things in ascending order, whose ids are 1 to K.
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
        """Map (H, W) of the ids of things, 0 on the background and where nothing counts."""
        return self.numbered(self.owner, self.shown)

    def numbered(self, owner: IntArray, shown: IntArray) -> Uint16Array:
        """Return the map (H, W) of positions from 1 of ``owner[instance]`` in ``shown`` (K,), ascending; else 0."""
        table = np.zeros(len(owner) + 1, np.uint16)
        table[:-1] = np.where(owner >= 0, np.searchsorted(shown, owner) + 1, 0)
        return np.asarray(table[self.truth.instance])  # NOTHING is the last entry

    def classes(self, table: Mapping[str, int]) -> Uint16Array:
        """Return the map (H, W) of the classes of things by word, 0 on the background, OTHER for unknown words."""
        own = [table.get(self.truth.ancestry.entity(i).word, OTHER) for i in self.shown.tolist()]
        return np.asarray(np.array([0, *own], np.uint16)[self.ids])

    def shares(self, words: Collection[str]) -> dict[str, float]:
        """Return the share of the picture that shows each word or its parts."""
        ancestry, truth = self.truth.ancestry, self.truth
        total = dict.fromkeys(words, 0)
        for depth in range(ancestry.max_depth + 1):
            used, count = np.unique(truth.at_depth(depth), return_counts=True)
            for instance, pixels in zip(used.tolist(), count.tolist(), strict=True):
                is_own = instance >= 0 and ancestry.depth[instance] == depth
                if is_own and ancestry.entity(instance).word in total and not self._is_inside_own(instance):
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


def things_of(truth: Truth, words: Collection[str] = ()) -> Things:
    """Return the things of a shot; ``words`` are those that count (default: see the module).

    Raises LimitError if more than ``MAX_THINGS`` are visible.
    """
    ancestry = truth.ancestry
    counts = np.array([e.word in words if words else is_object(e) for e in ancestry.nodes], bool)
    owner = np.full(len(ancestry), NOTHING, np.int64)
    for depth in range(ancestry.max_depth + 1):
        rows = np.flatnonzero(ancestry.depth == depth)
        above = owner[ancestry.parent[rows]] if depth else np.full(len(rows), NOTHING)
        owner[rows] = np.where(counts[ancestry.node[rows]], rows, above)
    seen = np.unique(truth.instance)
    shown = np.unique(owner[seen[seen >= 0]])
    shown = with_parents(shown[shown >= 0], owner, ancestry.parent)
    if len(shown) > MAX_THINGS:
        raise LimitError(
            "primitives", f"{len(shown):,} things are visible, more than the {MAX_THINGS:,} that a map can number",
            hint="reduce the size of the pictures, or name the words that count in `words`",
        )  # fmt: skip
    return Things(truth, owner, shown)


def with_parents(shown: IntArray, owner: IntArray, parent: IntArray) -> IntArray:
    """Return the things ``shown`` and those that they are parts of, ascending."""
    known = shown
    while len(shown):
        above = parent[shown]
        shown = np.unique(np.where(above >= 0, owner[above], NOTHING))
        shown = np.setdiff1d(shown[shown >= 0], known)
        known = np.union1d(known, shown)
    return known


# --- records ---------------------------------------------------------------------------------------------------------


def things_data(
    things: Things, handles: Mapping[int, str], classes: Mapping[str, int], covered: IntArray | None
) -> list[dict[str, Any]]:
    """Return the record of each visible thing, in the order of their ids; ``handles`` are by instance.

    ``covered`` (M,) are the pixels that each instance would show without the others, or None to leave visibility out.
    """
    truth, boxes, ancestry = things.truth, things.boxes, things.truth.ancestry
    low, high = boxes_of(ancestry, things.shown)
    above = np.where(ancestry.parent[things.shown] >= 0, things.owner[ancestry.parent[things.shown]], NOTHING)
    oriented = oriented_boxes(ancestry.poses[things.shown], low, high)
    parents = np.where(above >= 0, np.searchsorted(things.shown, above) + 1, 0).tolist()
    truncated = _truncations(boxes.full[things.shown], truth)
    found = []
    for k, instance in enumerate(things.shown.tolist()):
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
        found.append(record)
    return found


def hidden_data(things: Things, rows: IntArray) -> list[dict[str, Any]]:
    """Return word, depth, path and full box of the instances ``rows``, which are not seen, inside the picture."""
    ancestry, camera = things.truth.ancestry, things.truth.camera
    found = []
    for instance in rows.tolist():
        x0, y0, x1, y1 = (float(edge) for edge in things.boxes.full[instance])
        if x1 > 0 and y1 > 0 and x0 < camera.width and y0 < camera.height:  # false for NaN: behind the camera
            found.append({
                "word": ancestry.entity(instance).word, "depth": int(ancestry.depth[instance]),
                "path": list(ancestry.path(instance)), "bbox_full": [x0, y0, x1 - x0, y1 - y0],
            })  # fmt: skip
    return found


def _truncations(full: FloatArray, truth: Truth) -> list[float | None]:
    """Return the shares of the rectangles (K, 4) that are outside of the picture, None if one is partly behind."""
    size = np.array([truth.camera.width, truth.camera.height])
    whole = np.prod(full[:, 2:] - full[:, :2], axis=1)
    inside = np.prod(np.clip(full[:, 2:], 0, size) - np.clip(full[:, :2], 0, size), axis=1)
    with np.errstate(all="ignore"):
        share = np.where(whole > 0.0, np.maximum(0.0, 1.0 - inside / whole), 0.0)
    behind: list[bool] = np.asarray(np.isnan(full).any(axis=1)).tolist()
    return [None if hidden else value for hidden, value in zip(behind, share.tolist(), strict=True)]


def oriented_boxes(poses: FloatArray, low: FloatArray, high: FloatArray) -> list[dict[str, Any]]:
    """Return entities' boxes in the world: ``center`` (3,), ``rotation`` (3, 3) from the box's axes, ``size`` (3,).

    ``poses`` (K, 3, 4) are those of the frames of the boxes from ``low`` to ``high`` (K, 3). A sheared pose gives the
    rotation nearest to it and the extent along that.
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
    """Return the rotations (K, 3, 3) nearest to linear maps (K, 3, 3); of reflections, with mirrored z axes."""
    lengths = np.linalg.norm(linear, axis=1, keepdims=True)
    left, _, right = np.linalg.svd(linear / np.where(lengths > 1e-300, lengths, 1.0))
    rotation = left @ right
    rotation[:, :, 2] *= np.where(np.linalg.det(rotation) < 0.0, -1.0, 1.0)[:, None]
    return np.asarray(rotation, np.float64)


def pixels_alone(things: Things, center: FloatArray, scale: float) -> IntArray:
    """Return the pixels (M,) that each thing would show if nothing else were there; 0 for what is no visible thing.

    ``center`` (3,) and ``scale`` bring the scene to unit size.
    """
    truth, ancestry = things.truth, things.truth.ancestry
    camera = truth.camera.rescaled(center, scale)
    caster = caster_for(normalized(truth.solids, center, scale), camera_rays(camera))
    counts = np.zeros(len(ancestry), np.int64)
    level = _levels_of(things)
    thing = things.owner[ancestry.primitives[truth.solids.instance]]
    for number in range(int(level.max(initial=-1)), -1, -1):  # a thing's pixels are also those of what it is part of
        is_here = (thing >= 0) & (level[thing] == number)
        for group, pixels in caster.covered(np.where(is_here, thing, NOTHING)):
            counts[group] = pixels
        above = ancestry.parent[thing]
        thing = np.where(is_here, np.where(above >= 0, things.owner[above], NOTHING), thing)
    return counts


def _levels_of(things: Things) -> IntArray:
    """Return for every thing (M,) how many things it is part of; -1 for other instances."""
    ancestry = things.truth.ancestry
    level = np.full(len(ancestry), -1, np.int64)
    rows = np.flatnonzero(things.owner == np.arange(len(ancestry)))
    above = np.where(ancestry.parent[rows] >= 0, things.owner[ancestry.parent[rows]], NOTHING)
    for instance, other in zip(rows.tolist(), above.tolist(), strict=True):  # parents precede their children
        level[instance] = level[other] + 1 if other >= 0 else 0
    return level


def keypoints_data(things: Things, words: Collection[str], limit: int = 10_000) -> list[dict[str, Any]]:
    """Return the keypoints of a shot: the centres of the boxes of all instances of ``words``, at most ``limit``.

    ``visible`` is 2 where the instance is seen at its centre, 1 where it is hidden, 0 outside of the picture.
    """
    truth, ancestry = things.truth, things.truth.ancestry
    own = np.array([entity.word in words for entity in ancestry.nodes], bool)
    rows = np.flatnonzero(own[ancestry.node])[:limit]
    low, high = boxes_of(ancestry, rows)
    poses = ancestry.poses[rows]
    world = np.einsum("nij,nj->ni", poses[:, :, :3], (low + high) / 2.0) + poses[:, :, 3]
    pixels, depth = truth.camera.project(world)
    found = []
    for k, instance in enumerate(rows.tolist()):
        x, y = pixels[k].tolist()
        thing = int(things.owner[instance])
        at = int(np.searchsorted(things.shown, thing)) if thing >= 0 else len(things.shown)
        is_shown = at < len(things.shown) and things.shown[at] == thing
        inside = depth[k] > 0.0 and 0.0 <= x < truth.camera.width and 0.0 <= y < truth.camera.height
        found.append(
            {
                "word": ancestry.entity(instance).word,
                "thing": at + 1 if is_shown else 0,
                "point": [x, y] if depth[k] > 0.0 else None,
                "world": world[k].tolist(),
                "visible": 0 if not inside else 2 if _shows(truth, int(y), int(x), instance) else 1,
            }
        )
    return found


def _shows(truth: Truth, row: int, column: int, instance: int) -> bool:
    """Return whether a pixel shows an instance or one of its parts."""
    found = int(truth.instance[row, column])
    while found > instance:  # parents have smaller numbers
        found = int(truth.ancestry.parent[found])
    return found == instance


def levels_data(things: Things, most: int) -> list[tuple[Uint16Array, list[dict[str, Any]]]]:
    """Return for each level of the hierarchy below the root, at most ``most``, its map (H, W) and the records of ids.

    A pixel's id is that of its ancestor at the level, or of the primitive itself if it is at a higher level. The last
    level has the parts of computed solids, by the words of their operands, if any are seen.
    """
    truth, ancestry = things.truth, things.truth.ancestry
    found = []
    for depth in range(1, min(ancestry.max_depth, most) + 1):
        up = ancestry.at_depth(depth)
        seen = np.unique(truth.instance)
        shown = np.unique(up[seen[seen >= 0]])
        if len(shown) > MAX_THINGS:
            raise LimitError("primitives", f"{len(shown):,} instances are visible at level {depth}, more than 65,535")
        records = [
            {"id": k + 1, "word": ancestry.entity(i).word, "path": list(ancestry.path(i))}
            for k, i in enumerate(shown.tolist())
        ]
        found.append((things.numbered(up, shown), records))
    parts = _parts_level(truth)
    return [*found, parts] if parts is not None and len(found) < most else found


def _parts_level(truth: Truth) -> tuple[Uint16Array, list[dict[str, Any]]] | None:
    """Return the map (H, W) and the records of the parts of primitives, None if no computed solid shows several."""
    words = truth.solids.part_words
    if not (truth.part >= 0).any():
        return None
    key = np.where(truth.seen, truth.instance * (len(words) + 1) + truth.part + 1, NOTHING)
    shown, place = np.unique(key, return_inverse=True)
    first = int(shown[0] == NOTHING)
    if len(shown) > MAX_THINGS:
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
    """Return the scene graph of a frame: its things in breadth-first order, at most ``limit``, with poses and boxes.

    ``handles`` gives the handles of instances. ``parent`` is the position of the thing that a thing is part of, -1 for
    none; ``more`` counts what is left out.
    """
    ancestry = truth.ancestry
    counts = np.array([e.word in words if words else is_object(e) for e in ancestry.nodes], bool)
    every = np.flatnonzero(counts[ancestry.node])
    rows = every[:limit]
    named = handles(rows.tolist())
    place = {instance: k for k, instance in enumerate(rows.tolist())}
    low, high = boxes_of(ancestry, rows)
    nodes = []
    for k, instance in enumerate(rows.tolist()):
        above = int(ancestry.parent[instance])
        while above >= 0 and above not in place:
            above = int(ancestry.parent[above])
        nodes.append(
            {
                "word": ancestry.entity(instance).word,
                "handle": named[instance],
                "parent": place.get(above, -1),
                "pose": ancestry.poses[instance].tolist(),
                "box": [low[k].tolist(), high[k].tolist()],
            }
        )
    return {"nodes": nodes, "more": len(every) - len(rows)}
