"""Entities that stand in several places of a build: voxelised once, then laid as a whole.

That is sound where every pose from the root down to the entity, and below it, moves by whole cells only: truncation
then changes nothing, and the entity looks the same wherever it stands.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from scenelang.interpreter.entity import Entity, descendants, instance_counts
from scenelang.interpreter.shapes import Kind, Shape
from scenelang.interpreter.values import ANONYMOUS, Matrix, Pair

FARTHEST = 1 << 53  # cells from the origin: beyond it floats skip whole numbers
_FEWEST = 8  # primitives that are worth a stamp
_SPARSE = 64  # cells of a stamp's box for each of its primitives: more take longer than laying it anew
_LARGEST = 1 << 22  # cells of one stamp
_ALL = 1 << 25  # cells of all stamps together

Sizes = Mapping[int, tuple[int, int, int] | None]
Triple = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class CellBox:
    """The cells ``low <= c < high``."""

    low: Triple
    high: Triple

    @property
    def volume(self) -> int:
        """Cells in the box."""
        return (self.high[0] - self.low[0]) * (self.high[1] - self.low[1]) * (self.high[2] - self.low[2])


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """A repeated entity, the repeated ones in it closed, and the cells that it may touch in its own frame."""

    entity: Entity
    box: CellBox


@dataclass(frozen=True, slots=True, eq=False)
class Folded:
    """The DAG of an entity with its repeated entities closed, and without anything that lays no blocks.

    A closed entity is childless; ``numbers`` gives its place in ``patterns`` by ``id``. Patterns come before those
    that use them.
    """

    root: Entity
    numbers: Mapping[int, int]
    patterns: tuple[Pattern, ...]


def folded(root: Entity, sizes: Sizes) -> Folded:
    """``root`` with its repeated entities closed; ``sizes`` are the cells along each axis of every primitive that lays
    blocks, by ``id``, None where these are not whole."""
    order = list(descendants(root))
    boxes = _worth_closing(order, sizes)
    twins: dict[int, Entity] = {}
    numbers: dict[int, int] = {}
    patterns: list[Pattern] = []
    room = _ALL
    for entity in order:
        twin = entity if id(entity) in sizes else _without_others(entity, twins)
        if twin is None:
            continue
        box = boxes.get(id(entity))
        if box is not None and box.volume <= min(room, _LARGEST):
            room -= box.volume
            closed = Entity(entity.word, ANONYMOUS, (), Shape(Kind.CUBOID))
            numbers[id(closed)] = len(patterns)
            patterns.append(Pattern(twin, box))
            twin = closed
        twins[id(entity)] = twin
    return Folded(twins.get(id(root), Entity(root.word, ANONYMOUS, ())), numbers, tuple(patterns))


def _without_others(entity: Entity, twins: Mapping[int, Entity]) -> Entity | None:
    """The entity with the twins of its children; None where none of them lays blocks."""
    kept = [part for part in entity.children if id(part.car) in twins]
    if not kept:
        return None
    if len(kept) == len(entity.children) and all(twins[id(part.car)] is part.car for part in kept):
        return entity
    return Entity(entity.word, ANONYMOUS, tuple(Pair(twins[id(part.car)], part.cdr) for part in kept))


def _worth_closing(order: Sequence[Entity], sizes: Sizes) -> dict[int, CellBox]:
    """The cells of each entity that is worth a stamp, and may be one, by ``id``; ``order`` is children first."""
    counts = instance_counts(order)
    movable = _whole_from_the_root(order)
    boxes: dict[int, CellBox] = {}
    primitives: dict[int, int] = {}
    for entity in order:
        if counts[id(entity)] < 2:
            continue
        box = _own_box(sizes[id(entity)]) if id(entity) in sizes else _joined(entity, boxes, primitives)
        if box is not None:
            boxes[id(entity)] = box
            primitives[id(entity)] = sum(primitives.get(id(part.car), 0) for part in entity.children) or 1
        elif id(entity) not in sizes and not any(id(part.car) in primitives for part in entity.children):
            primitives[id(entity)] = 0  # nothing below it lays blocks
    return {
        key: box for key, box in boxes.items()
        if key in movable and primitives[key] >= _FEWEST and box.volume <= _SPARSE * primitives[key]
    }  # fmt: skip


def _whole_from_the_root(order: Sequence[Entity]) -> set[int]:
    """The entities with children, by ``id``, that stand at whole cells wherever they stand."""
    moved: set[int] = set()
    for entity in reversed(order):
        free = id(entity) in moved
        for part in entity.children:
            if part.car.children and (free or not is_whole_step(part.cdr)):
                moved.add(id(part.car))
    return {id(entity) for entity in order if entity.children and id(entity) not in moved}


def is_whole_step(m: Matrix) -> bool:
    """True where the pose moves by whole cells, and does nothing else."""
    x, y, z = m[3], m[7], m[11]
    return (
        m[0] == m[5] == m[10] == 1.0
        and not (m[1] or m[2] or m[4] or m[6] or m[8] or m[9])
        and x % 1.0 == y % 1.0 == z % 1.0 == 0.0
        and max(abs(x), abs(y), abs(z)) < FARTHEST
    )


def _own_box(size: Triple | None) -> CellBox | None:
    return None if size is None else CellBox((0, 0, 0), size)


def _joined(entity: Entity, boxes: Mapping[int, CellBox], primitives: Mapping[int, int]) -> CellBox | None:
    """The box around an entity's children; None where one of them stands or is anywhere but at whole cells."""
    found: list[tuple[Triple, Triple]] = []
    for part in entity.children:
        box, m = boxes.get(id(part.car)), part.cdr
        if box is None and primitives.get(id(part.car)) == 0:
            continue
        if box is None or not is_whole_step(m):
            return None
        x, y, z = int(m[3]), int(m[7]), int(m[11])
        (a, b, c), (d, e, f) = box.low, box.high
        found.append(((a + x, b + y, c + z), (d + x, e + y, f + z)))
    if not found:
        return None
    xs, ys, zs = (([low[i] for low, _ in found], [high[i] for _, high in found]) for i in range(3))
    return CellBox((min(xs[0]), min(ys[0]), min(zs[0])), (max(xs[1]), max(ys[1]), max(zs[1])))
