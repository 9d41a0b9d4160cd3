"""Exploded views: the parts of each entity move apart by hierarchy, as a transformation of the entity graph."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any

from scenelang.interpreter.scene.bounds import entity_box, parts_box
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.pose import AXES, compose, translation
from scenelang.interpreter.scene.primitives.base import Box
from scenelang.interpreter.values.values import IDENTITY, Matrix, Pair

_MIN_DETERMINANT = 1e-12  # of a pose, relative to the lengths of its rows; below it an axis has no direction in a part
_State = tuple[Entity, Matrix, int]


def with_frames(scene: Scene, frames: Sequence[Entity]) -> Scene:
    """Return a scene that has other frames and all else of ``scene``."""
    changed = copy(scene)
    changed.frames = tuple(frames)
    return changed


def exploded(scene: Scene, amount: float, axis: str | None = None, depth: int | None = None) -> Scene:
    """Return a scene whose parts are moved apart.

    The center of a part's box moves away from the center of the box around it, by ``amount`` times its offset from
    there; the parts of a part in the same way. An entity with one part does not count as a level of the hierarchy.

    Parameters
    ----------
    amount
        Times the offset of each part.
    axis
        Axis of the world, "x", "y" or "z", along which parts move; by default in the direction of their offsets.
    depth
        Number of levels whose parts move; by default all.

    Examples
    --------
    >>> import scenelang as sl
    >>> row = '(bind "row" (lambda () (for/union ((i 2)) (transform (call "cube") (translate [i 0 0])))))'
    >>> sl.Scene(exploded(sl.evaluate(row).graph, 1.0)).bounds.tolist()
    [[-1.0, -0.5, -0.5], [2.0, 0.5, 0.5]]
    """
    known: dict[Any, Entity] = {}
    frames = [_exploded(root, amount, axis, -1 if depth is None else depth, known) for root in scene.frames]
    return with_frames(scene, frames)


def _exploded(root: Entity, amount: float, axis: str | None, depth: int, known: dict[Any, Entity]) -> Entity:
    """Return a root with its parts moved; ``known`` are the entities that have been moved, by their keys.

    The stack is a list, because graphs can be deeper than Python's stack.
    """

    def key(state: _State) -> Any:
        """Return what the result for an entity depends on: with an axis, its orientation in the world too."""
        entity, world, left = state
        return id(entity), left, None if axis is None else tuple(round(x, 12) for k, x in enumerate(world) if k % 4 < 3)

    start = (root, IDENTITY, depth)
    stack = [start]
    while stack:
        entity, world, left = stack[-1]
        if key(stack[-1]) in known:
            stack.pop()
            continue
        if not left or not entity.children:
            known[key(stack.pop())] = entity
            continue
        below = left - (len(entity.children) > 1)
        states = [(part.car, compose(world, part.cdr), below) for part in entity.children]
        waiting = [state for state in states if key(state) not in known]
        if waiting:
            stack.extend(waiting)
            continue
        moved = [_moved(entity, part, amount, axis, world) for part in entity.children]
        parts = tuple(Pair(known[key(state)], pose) for state, pose in zip(states, moved, strict=True))
        known[key(stack.pop())] = rebuilt(entity, parts)
    return known[key(start)]


def rebuilt(entity: Entity, children: tuple[Any, ...]) -> Entity:
    """Return an entity like ``entity`` with other parts."""
    return Entity(entity.word, entity.embedding, children, entity.shape, entity.tainted, entity.call_sites)


def _moved(entity: Entity, part: Any, amount: float, axis: str | None, world: Matrix) -> Matrix:
    """Return the pose of a part of an entity, which has the pose ``world``, away from the entity's center."""
    around, own = entity_box(entity), parts_box((part,))
    if around is None or own is None:
        return Matrix(part.cdr)
    offset = [amount * (a - b) for a, b in zip(_center(own), _center(around), strict=True)]
    if axis is not None:
        offset = _along(offset, AXES.index(axis), world)
    return compose(translation(*offset), part.cdr)


def _center(box: Box) -> list[float]:
    """Return the center of a box."""
    return [(low + high) / 2.0 for low, high in zip(box[:3], box[3:], strict=True)]


def _along(offset: Sequence[float], axis: int, world: Matrix) -> list[float]:
    """Return the part of an offset, in a frame under the pose ``world``, that is along an axis of the world.

    It is the solution of ``linear part . result = (0, .., component, .., 0)``: a column of the adjugate matrix.
    """
    a, b, c, _, d, e, f, _, g, h, i, _ = world
    rows = ((a, b, c), (d, e, f), (g, h, i))
    adjugate = (
        (e * i - f * h, c * h - b * i, b * f - c * e),
        (f * g - d * i, a * i - c * g, c * d - a * f),
        (d * h - e * g, b * g - a * h, a * e - b * d),
    )
    determinant = sum(x * y for x, y in zip(rows[0], (column[0] for column in adjugate), strict=True))
    scale = max((sum(x * x for x in row) for row in rows), default=0.0) ** 1.5
    if abs(determinant) <= _MIN_DETERMINANT * scale or scale == 0.0:
        return [0.0, 0.0, 0.0]
    component = sum(x * y for x, y in zip(rows[axis], offset, strict=True))
    return [column[axis] * component / determinant for column in adjugate]
