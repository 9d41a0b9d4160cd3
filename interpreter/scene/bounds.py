"""Exact axis-aligned bounding boxes on the DAG, without expanding it.

The box of a node is the union of the boxes of its parts. A part under an axis-aligned pose, and a primitive under any
pose, have a closed form. For a part under any other pose, each of the six extremes is found by best-first branch and
bound (Land and Doig, 1960): the transformed box of a subtree is an upper bound, and only subtrees whose bound exceeds
the best value so far are opened. Boxes are cached on entities, which are immutable.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import dist, isfinite
from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.part_columns import distinct_entities
from scenelang.interpreter.scene.primitives.base import Box
from scenelang.interpreter.values.values import IDENTITY, Pair

UNIT_BOX: Box = (-0.5, -0.5, -0.5, 0.5, 0.5, 0.5)
_INFINITY = float("inf")
_TOLERANCE = 1e-12  # relative to the extreme: subtrees that could exceed it by rounding errors only are not opened
Charge = Callable[[int], None]


def _no_charge(work: int) -> None:
    """Ignore the work: outside an evaluation there is no step limit."""


def _cost(entity: Entity) -> int:
    """Return the number of steps that one support query of an entity costs; a mesh has many vertices."""
    return 1 if entity.shape is None else entity.shape.cost


def box_diagonal(box: Box | None) -> float:
    """Return the length of the diagonal of a box, 0 for None.

    >>> box_diagonal((0.0, 0.0, 0.0, 3.0, 4.0, 0.0))
    5.0
    """
    return dist(box[:3], box[3:]) if box is not None else 0.0


def entity_box(entity: Entity, charge: Charge = _no_charge) -> Box | None:
    """Return the smallest axis-aligned box of ``entity`` in its local frame, or None if it has no geometry.

    ``charge`` is called with the number of steps while the box is computed.
    """
    if entity.box is None:
        _compute_boxes(entity, charge)
    return entity.box or None


def parts_box(parts: Sequence[Any], charge: Charge = _no_charge) -> Box | None:
    """Return the smallest axis-aligned box of parts in the frame that their poses map to, or None without geometry.

    ``parts`` are pairs ``(Entity . Matrix)``; the box is (minimum x, y, z, maximum x, y, z), exact up to rounding
    errors. ``charge`` is called with the number of steps while the box is computed.
    """
    charge(len(parts) >> 4)
    for part in parts:
        if part.car.box is None:
            _compute_boxes(part.car, charge)
    return _union_box(parts, charge) or None


def _compute_boxes(root: Entity, charge: Charge) -> None:
    """Compute the missing boxes of ``root`` and its descendants, children before parents."""
    stack = [root]
    while stack:
        entity = stack[-1]
        if entity.box is not None:
            stack.pop()
            continue
        charge(1 + (len(entity.children) >> 3))
        pending = [child for child in distinct_entities(entity.children) if child.box is None]
        if pending:
            stack.extend(pending)
            continue
        stack.pop()
        if entity.shape is not None:
            entity.box = entity.shape.box_under(IDENTITY) if entity.shape.has_geometry else ()
        else:
            entity.box = _union_box(entity.children, charge)


def _transformed_box(box: Box, m: Sequence[float]) -> Box:
    """Return the bounding box of ``box`` under ``m``, an upper bound for the contents of the box.

    Center and half sizes are transformed, the latter by the absolute values of ``m`` (Arvo, "Transforming Axis-Aligned
    Bounding Boxes", Graphics Gems, 1990).
    """
    x0, y0, z0, x1, y1, z1 = box
    cx, cy, cz = 0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.5 * (z0 + z1)
    hx, hy, hz = x1 - cx, y1 - cy, z1 - cz
    a, b, c, t, d, e, f, u, g, h, i, v = m
    px, py, pz = a * cx + b * cy + c * cz + t, d * cx + e * cy + f * cz + u, g * cx + h * cy + i * cz + v
    rx = abs(a) * hx + abs(b) * hy + abs(c) * hz
    ry = abs(d) * hx + abs(e) * hy + abs(f) * hz
    rz = abs(g) * hx + abs(h) * hy + abs(i) * hz
    return (px - rx, py - ry, pz - rz, px + rx, py + ry, pz + rz)


def _row_is_aligned(a: float, b: float, c: float) -> bool:
    """Return whether (a, b, c) is a multiple of an axis, so that the box of a child is exact in this direction."""
    return (a != 0.0) + (b != 0.0) + (c != 0.0) <= 1


def _is_aligned(m: Sequence[float]) -> bool:
    """Return whether every row of the linear part is a multiple of an axis."""
    return (
        _row_is_aligned(m[0], m[1], m[2]) and _row_is_aligned(m[4], m[5], m[6]) and _row_is_aligned(m[8], m[9], m[10])
    )


def _union_box(parts: Sequence[Any], charge: Charge) -> Box | tuple[()]:
    """Return the exact box of the parts, or ``()`` if they have no geometry."""
    x0 = y0 = z0 = _INFINITY
    x1 = y1 = z1 = -_INFINITY
    open_parts: list[tuple[Any, Box]] = []
    for index, part in enumerate(parts):
        if not index & 1023:
            charge(min(1024, len(parts) - index) >> 2)
        child, pose = part.car, part.cdr
        if not child.box:
            continue
        charge(_cost(child))
        if child.shape is not None:
            box = child.box if pose == IDENTITY else child.shape.box_under(pose)
        else:
            box = child.box if pose == IDENTITY else _transformed_box(child.box, pose)
            if not _is_aligned(pose):
                open_parts.append((part, box))
                continue
        x0, y0, z0 = min(x0, box[0]), min(y0, box[1]), min(z0, box[2])
        x1, y1, z1 = max(x1, box[3]), max(y1, box[4]), max(z1, box[5])
    if open_parts:
        limits = [-x0, -y0, -z0, x1, y1, z1]
        for axis in range(3):
            limits[axis] = _maximize(open_parts, axis, -1.0, limits[axis], charge)
            limits[axis + 3] = _maximize(open_parts, axis, 1.0, limits[axis + 3], charge)
        x0, y0, z0, x1, y1, z1 = -limits[0], -limits[1], -limits[2], limits[3], limits[4], limits[5]
    return (x0, y0, z0, x1, y1, z1) if x0 <= x1 else ()


def _maximize(open_parts: Sequence[tuple[Any, Box]], axis: int, sign: float, best: float, charge: Charge) -> float:
    """Return the maximum of ``sign * coordinate[axis]`` over ``open_parts``, at least ``best``, by branch and bound.

    The heap orders subtrees by upper bound, and deeper ones first on ties. Each entry has the coordinate as a function
    of a point p in the frame of the subtree: ``(a, b, c) . p + t``.
    """
    from heapq import heappop, heappush  # needed for turned parts only

    heap: list[tuple[float, int, int, Entity, float, float, float, float]] = []
    serial = 0
    for part, box in open_parts:
        bound = box[axis + 3] if sign > 0 else -box[axis]
        if bound > best:
            m = part.cdr
            a, b, c, t = (sign * x for x in m[4 * axis : 4 * axis + 4])
            serial += 1
            heappush(heap, (-bound, 0, serial, part.car, a, b, c, t))
    while heap:
        bound, depth, _, entity, a, b, c, t = heappop(heap)
        if -bound <= best + _TOLERANCE * max(1.0, abs(best)):
            break
        charge(1 + (len(entity.children) >> 2))
        for part in entity.children:
            child, m = part.car, part.cdr
            if not child.box:
                continue
            charge(_cost(child))
            # The direction (a, b, c) in the frame of the child.
            i = a * m[0] + b * m[4] + c * m[8]
            j = a * m[1] + b * m[5] + c * m[9]
            k = a * m[2] + b * m[6] + c * m[10]
            offset = a * m[3] + b * m[7] + c * m[11] + t
            exact = child.shape is not None
            if exact:
                upper = offset + child.shape.interval(i, j, k)[1]
            else:
                x0, y0, z0, x1, y1, z1 = child.box
                upper = offset + i * (x1 if i > 0 else x0) + j * (y1 if j > 0 else y0) + k * (z1 if k > 0 else z0)
                exact = _row_is_aligned(i, j, k)
            if upper <= best:
                continue
            if exact:
                best = upper
            else:
                serial += 1
                heappush(heap, (-upper, depth - 1, serial, child, i, j, k, offset))
    return best


# Bounding boxes of all entities of a word, in world space.


def word_box(scene: Scene, word: str | None) -> Box | None:
    """Return the exact world-space box of the scene over all frames, or of all entities of a word.

    Returns None if there is no geometry. For a word, a filtered copy of the DAG is measured, so that nothing is
    expanded.
    """
    boxes = []
    for root in scene.frames:
        selected = root if word is None else _filter_by_word(root, word)
        box = entity_box(selected) if selected is not None else None
        if box is not None:
            boxes.append(box)
    if not boxes:
        return None
    if not all(map(isfinite, (x for box in boxes for x in box))):
        raise SceneError("pose", "pose overflow: the bounding box exceeds the float range")
    return (
        min(b[0] for b in boxes), min(b[1] for b in boxes), min(b[2] for b in boxes),
        max(b[3] for b in boxes), max(b[4] for b in boxes), max(b[5] for b in boxes),
    )  # fmt: skip


def box_data(box: Box) -> dict[str, list[float]]:
    """Return the corners, center and side lengths of a box as plain data."""
    low, high = list(box[:3]), list(box[3:])
    return {
        "min": low,
        "max": high,
        "center": [(a + b) / 2 for a, b in zip(low, high)],
        "sizes": [b - a for a, b in zip(low, high)],
    }


def _filter_by_word(root: Entity, word: str) -> Entity | None:
    """Return a copy of the DAG with only the entities of ``word`` and their subtrees, or None if it has none."""
    filtered: dict[int, Entity | None] = {}
    for entity in descendants(root):
        if entity.word == word:
            filtered[id(entity)] = entity
            continue
        remaining = ((filtered[id(part.car)], part.cdr) for part in entity.children)
        parts = tuple(Pair(child, pose) for child, pose in remaining if child is not None)
        filtered[id(entity)] = Entity(entity.word, entity.embedding, parts) if parts else None
    return filtered[id(root)]
