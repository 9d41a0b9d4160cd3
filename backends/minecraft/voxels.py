"""Voxelisation: from an entity to the blocks that it lays (the paper, appendix "Minecraft Renderer").

The numbers are the reference's: a cuboid begins at its position, truncated toward zero, and has as many cells along
each axis as ``:scale`` times the pose's own scale. Cuboids are laid in the order of the program, later ones on top;
``delete-blocks`` and ``minecraft:air`` empty their cells, hollow cuboids keep what is inside them. What stands in a
cell is what the program asked for; ``settle`` makes whole block states of that.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import (
    AIR,
    AIR_STATE,
    NOTHING,
    BlockState,
    Build,
    Cells,
    numbers_in,
    smallest_box,
)
from scenelang.backends.minecraft.table import BlockKind, BlockTable, renamed, without_number
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.runtime.show import NotPlain, plain_value
from scenelang.interpreter.runtime.values import ANONYMOUS, Matrix, Pair
from scenelang.interpreter.scene.entity import Entity, descendants, instance_counts, primitive_count
from scenelang.interpreter.scene.flatten import FlatFrame, flatten_entity
from scenelang.interpreter.scene.primitives import block_words
from scenelang.interpreter.scene.primitives.blocks import SetCuboid

# What a primitive asks for: the block and the properties that the program names, before anything is known of them.


NAMESPACE = "minecraft:"
_WITH_STATE = re.compile(r"([^\[\]]+)\[([^\[\]]*)\]")  # as the game writes it: oak_log[axis=x]


def asked_state(entity: Entity) -> BlockState:
    """The block that a "set-cuboid" or "delete-blocks" lays, with only the properties that the program gives.

    Raises SceneError("attribute"), with the place in the program, where ``:block-type`` or ``:block-kwargs`` is
    missing or none.
    """
    if isinstance(entity.shape, SetCuboid) and entity.shape.lays_air:
        return AIR_STATE
    name = entity.embedding.attributes.get("block-type")
    if not isinstance(name, str) or not name.strip():
        raise _problem(entity, "block-type", 'the name of a block, such as "stone"')
    within = _WITH_STATE.fullmatch(name.strip())
    given = _pairs_of_text(within[2]) if within else {}
    state = tuple(sorted({**given, **properties_of(entity)}.items()))
    block = namespaced(within[1] if within else name)
    return AIR_STATE if block in NOTHING else BlockState(block, state)


def is_hollow(entity: Entity) -> bool:
    """Whether only the six faces are laid; raises SceneError("attribute") where ``:fill`` is neither true nor false."""
    fill = entity.embedding.attributes.get("fill")
    if fill is not None and not isinstance(fill, bool):
        raise _problem(entity, "fill", "#t or #f")
    return fill is False


def namespaced(name: str) -> str:
    """``Oak Planks`` as ``minecraft:oak_planks``: lower case, with underscores and the namespace; names with numbers,
    from before 1.13, as they are today."""
    plain = without_number(re.sub(r"\s+", "_", name.strip().lower()).removeprefix(NAMESPACE))
    return plain if ":" in plain else NAMESPACE + plain


def properties_of(entity: Entity) -> dict[str, str]:
    """The properties that ``:block-kwargs`` gives, values as the game writes them; raises SceneError("attribute")."""
    given = entity.embedding.attributes.get("block-kwargs")
    try:
        return _pairs(plain_value(given))
    except (NotPlain, ValueError):
        raise _problem(
            entity, "block-kwargs", 'an association list or table of properties, such as `\'(("facing" "north"))`'
        ) from None


def _pairs_of_text(text: str) -> dict[str, str]:
    pairs = [pair.partition("=") for pair in text.split(",") if pair.strip()]
    return {_text(name): _text(value) for name, _, value in pairs}


def _pairs(given: Any) -> dict[str, str]:
    if given is None:
        return {}
    if isinstance(given, Mapping):
        return {_text(name): _text(value) for name, value in given.items()}
    if isinstance(given, list) and all(isinstance(pair, list) and len(pair) == 2 for pair in given):
        return {_text(name): _text(value) for name, value in given}
    raise ValueError


def _text(value: Any) -> str:
    """A name or value as the game writes it: ``true``, ``7``, ``north``."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, (str, int)):
        return str(value).strip().lower().removeprefix(":")
    raise ValueError


def place_of(entity: Entity) -> Span | None:
    """Where the program made a primitive, the first of several places."""
    return entity.places[0] if entity.places else None


def _problem(entity: Entity, name: str, wanted: str) -> SceneError:
    message = f'the attribute `:{name}` of "{entity.word}" must be {wanted}'
    return SceneError("attribute", message, span=place_of(entity))


# Laying cuboids of blocks into a grid of cells, one after another, later ones on top of earlier ones.


IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_SMALL = 64  # cells: fewer are laid many cuboids at a time, more one cuboid at a time
_CHUNK = 1 << 20  # cells that are laid at once


@dataclass(frozen=True, slots=True, eq=False)
class Stamp:
    """Cells to lay as they are where ``touched``, all of the same shape (X, Y, Z); ``touched`` is None for all."""

    cells: Cells
    touched: BoolArray | None


@dataclass(frozen=True, slots=True, eq=False)
class Laid:
    """Cuboids in the order in which they are laid: cells ``low <= c < high`` become ``number``, those of the six faces
    only where ``hollow``. ``stamp`` is the number of a stamp to lay there instead, -1 for none."""

    low: IntArray  # (N, 3)
    high: IntArray  # (N, 3)
    number: IntArray  # (N,)
    hollow: BoolArray  # (N,)
    stamp: IntArray  # (N,)


def paint(cells: Cells, origin: IntArray, laid: Laid, stamps: Sequence[Stamp]) -> None:
    """Lay everything into ``cells``, whose first cell is ``origin`` (3,). What lies outside is left out; stamps lie
    inside."""
    laid = _as_slabs(laid)
    limit = np.array(cells.shape, np.int64)
    low = np.clip(laid.low - origin, 0, limit)
    high = np.clip(laid.high - origin, low, limit)
    volume = (high - low).prod(axis=1)
    single = (volume > _SMALL) | (laid.stamp >= 0)
    for first, last in _runs(single):
        if not single[first]:
            _paint_small(cells, low[first:last], high[first:last], volume[first:last], laid.number[first:last])
            continue
        for i in range(first, last):
            where = tuple(slice(a, b) for a, b in zip(low[i].tolist(), high[i].tolist()))
            if laid.stamp[i] >= 0:
                _press(cells[where], stamps[int(laid.stamp[i])])
            else:
                cells[where] = laid.number[i]


def _as_slabs(laid: Laid) -> Laid:
    """Every hollow cuboid as its six faces."""
    open_ = laid.hollow & (laid.high - laid.low > 2).all(axis=1)
    if not open_.any():
        return laid
    rows = np.repeat(np.arange(len(open_)), np.where(open_, 6, 1))
    low, high = laid.low[rows], laid.high[rows]
    first = np.flatnonzero(open_[rows])[::6]
    for axis in range(3):
        high[first + 2 * axis, axis] = low[first + 2 * axis, axis] + 1
        low[first + 2 * axis + 1, axis] = high[first + 2 * axis + 1, axis] - 1
    return Laid(low, high, laid.number[rows], np.zeros(len(rows), np.bool_), laid.stamp[rows])


def _runs(mask: BoolArray) -> Iterator[tuple[int, int]]:
    """The longest stretches in which the mask does not change."""
    edges = np.flatnonzero(np.diff(mask)) + 1
    bounds = [0, *edges.tolist(), len(mask)]
    yield from ((a, b) for a, b in pairwise(bounds) if a < b)


def _press(there: Cells, stamp: Stamp) -> None:
    if stamp.touched is None:
        there[...] = stamp.cells
    else:
        np.copyto(there, stamp.cells, where=stamp.touched)


def _paint_small(cells: Cells, low: IntArray, high: IntArray, volume: IntArray, number: IntArray) -> None:
    """Lay cuboids of few cells, all cells of many cuboids at once; numpy keeps the last of equal indices."""
    flat = cells.reshape(-1)
    _, ny, nz = cells.shape
    ends = np.cumsum(volume)
    start = 0
    while start < len(volume):
        before = int(ends[start - 1]) if start else 0
        stop = max(start + 1, int(np.searchsorted(ends, before + _CHUNK, side="right")))
        index = np.repeat(np.arange(start, stop), volume[start:stop])
        within = np.arange(before, int(ends[stop - 1])) - (ends - volume)[index]
        size = (high - low)[index]
        z, rest = within % size[:, 2], within // size[:, 2]
        y, x = rest % size[:, 1], rest // size[:, 1]
        at = ((low[index, 0] + x) * ny + low[index, 1] + y) * nz + low[index, 2] + z
        flat[at] = number[index]
        start = stop


# Entities that stand in several places of a build: voxelised once, then laid as a whole.
#
# That is sound where every pose from the root down to the entity, and below it, moves by whole cells only: truncation
# then changes nothing, and the entity looks the same wherever it stands.


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
            closed = Entity(entity.word, ANONYMOUS, (), SetCuboid())
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


# Where cuboids of blocks stand: whole cells from the poses of primitives, or what is wrong with these.


_NEAR = 1e-9  # cells: what sums of poses may be off
_SLACK = 1e-6  # cells: what multiplied poses may be off


def first_cells(flat: FlatFrame) -> IntArray:
    """The first cell of each instance (N, 3): its position, truncated toward zero. What rounding of floats left beside
    a whole number is that number."""
    position = flat.matrices[:, :, 3]
    whole = np.rint(position)
    first: IntArray = np.where(np.abs(position - whole) < _NEAR, whole, np.trunc(position)).astype(np.int64)
    return first


def off_cells(flat: FlatFrame) -> tuple[int, list[float], int] | None:
    """How many instances stand between cells where truncation does not move all alike, so that distances change, the
    position (3,) of the first of them, and its number; None where it moves all alike."""
    position = flat.matrices[:, :, 3]
    if not len(position):
        return None
    moved = position - first_cells(flat)
    unlike = (np.abs(moved - moved[0]) > _NEAR).any(axis=1)
    if not unlike.any():
        return None
    apart = (np.abs(moved) > _NEAR).any(axis=1)
    first = int(np.argmax(apart))
    return int(apart.sum()), position[first].tolist(), first


def whole_sizes(flat: FlatFrame) -> IntArray:
    """The cells of each instance along each axis (N, 3); raises SceneError("blocks") for the first pose that blocks
    cannot have."""
    own = np.array([_own_size(p) for p in flat.primitives], np.float64).reshape(-1, 3)
    linear, position = flat.matrices[:, :, :3], flat.matrices[:, :, 3]
    along = np.diagonal(linear, axis1=1, axis2=2)
    across = np.abs(linear * (1.0 - np.eye(3))).max(axis=(1, 2), initial=0.0)
    with np.errstate(invalid="ignore", over="ignore"):
        size = along * own[flat.index]
        whole = np.rint(size)
        far = np.asarray(~((np.abs(position) < FARTHEST).all(axis=1) & (size < FARTHEST).all(axis=1)))
        leans = across > _SLACK * np.maximum(np.abs(along).max(axis=1, initial=0.0), _SLACK)
        turned: BoolArray = ~far & (leans | (along < 0.0).any(axis=1))
        broken = ~far & (
            (np.abs(size - whole) > np.clip(_SLACK * whole, _SLACK, 0.01)) | ((whole == 0) & (size > 0))
        ).any(axis=1)
    wrong = far | turned | broken
    if wrong.any():
        i = int(np.argmax(wrong))
        raise _misplaced(flat, i, "far" if far[i] else "turned" if turned[i] else "broken", size[i])
    return whole.astype(np.int64)


def _own_size(primitive: Entity) -> tuple[float, float, float]:
    assert isinstance(primitive.shape, SetCuboid)
    return primitive.shape.size


def _misplaced(flat: FlatFrame, i: int, reason: str, size: FloatArray) -> SceneError:
    entity = flat.primitives[int(flat.index[i])]
    path = " > ".join((*flat.paths[int(flat.path_index[i])], entity.word))
    shown = " x ".join(f"{n:.6g}" for n in size)
    problem, hint = {
        "far": ("stands farther from the origin than cells can be counted", None),
        "turned": (
            "is turned, mirrored or sheared, which blocks cannot be",
            "compose blocks with `translate` and whole `scale` only; stairs and logs turn with `:block-kwargs`",
        ),
        "broken": (f"is {shown} cells large, and blocks fill whole cells", "scale blocks by whole numbers"),
    }[reason]
    return SceneError("blocks", f'"{entity.word}" at {path} {problem}', hint=hint, span=place_of(entity))


def cells_around(laid: Laid, most_cells: int) -> tuple[IntArray, tuple[int, ...]]:
    """The first cell (3,) and the size of the box around all that is laid; raises LimitError for too many cells."""
    lays = ((laid.number != AIR) | (laid.stamp >= 0)) & (laid.high > laid.low).all(axis=1)
    if not lays.any():
        return np.zeros(3, np.int64), (0, 0, 0)
    low, high = laid.low[lays].min(axis=0), laid.high[lays].max(axis=0)
    size = tuple((high - low).tolist())
    if size[0] * size[1] * size[2] > most_cells:
        shown = " x ".join(f"{n:,}" for n in size)
        raise LimitError(
            "size",
            f"the build's box is {shown} cells, more than the {most_cells:,} that one build may have",
            hint="bring its parts nearer to one another, or lay smaller cuboids",
        )
    return low, size


MOST_CELLS = 200_000_000
_UNTOUCHED = np.uint32(0xFFFFFFFF)  # of a stamp: what it leaves as it is
_SLAB = 1 << 22  # cells that are looked at together


@dataclass(frozen=True, slots=True, eq=False)
class Voxels:
    """``build`` holds the states that the program asks for, with the properties that it gives and no others;
    ``places[n]`` is where the program asks for ``build.palette[n]``. ``others`` are the words of the primitives that
    lay no blocks, sorted; ``off_cells`` is the warning where blocks stand between cells, and not all alike."""

    build: Build
    places: tuple[Span | None, ...]
    others: tuple[str, ...]
    off_cells: Diagnostic | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Asked:
    """The primitives that lay blocks, by ``id``: their sizes, where whole, and the number of their block in
    ``palette``, of which ``places`` are the places."""

    sizes: Sizes
    numbers: Mapping[int, int]
    palette: tuple[BlockState, ...]
    places: tuple[Span | None, ...]
    others: tuple[str, ...]


def voxelised(root: Entity, limit: int = 2_000_000, most_cells: int = MOST_CELLS) -> Voxels:
    """The blocks of ``root``, in the smallest box that holds them; a box of no cells where nothing stands.

    Raises SceneError: "attribute" for a block that is no block, "blocks" for a pose that is more than a move and a
    whole scale; and LimitError for more than ``limit`` primitives, repeated entities counted once, or a box of more
    than ``most_cells`` cells.
    """
    asked = _asked(root)
    tree = folded(root, asked.sizes)
    _check_count((tree.root, *(pattern.entity for pattern in tree.patterns)), limit)
    stamps: list[Stamp] = []
    for pattern in tree.patterns:
        origin = np.array(pattern.box.low, np.int64)
        cells = np.full(np.array(pattern.box.high, np.int64) - origin, _UNTOUCHED, np.uint32)
        paint(cells, origin, _laid(pattern.entity, tree, asked), stamps)
        touched = cells != _UNTOUCHED
        stamps.append(Stamp(cells, None if touched.all() else touched))
    flat = flatten_entity(tree.root, whole_cells=False)
    laid = _laid_of(flat, tree, asked)
    origin, size = cells_around(laid, most_cells)
    cells = np.zeros(size, np.uint32)
    paint(cells, origin, laid, stamps)
    return replace(_finished(cells, origin, asked), off_cells=_off_cells(flat))


def ignored(voxels: Voxels) -> Diagnostic | None:
    """The warning that names the words which lay no blocks; None where there are none."""
    if not voxels.others:
        return None
    shown = ", ".join(f'"{word}"' for word in voxels.others[:8]) + (", .." if len(voxels.others) > 8 else "")
    message = f"only {' and '.join(block_words())} lay blocks; left out: {shown}"
    return Diagnostic("no-block", message, hint="fill the shapes of the whole scene with blocks: --voxelize 64")


def _off_cells(flat: FlatFrame) -> Diagnostic | None:
    """The warning for blocks between cells; what all stands as far from its cells keeps its distances. Patterns stand
    and are at whole cells."""
    found = off_cells(flat)
    if found is None:
        return None
    count, at, number = found
    entity = flat.primitives[int(flat.index[number])]
    cell = first_cells(flat)[number].tolist()
    message = (
        f"{count:,} cuboids stand between cells, such as that at [{' '.join(f'{n:.6g}' for n in at)}], which is laid"
    )
    message += f" at [{' '.join(map(str, cell))}]; gaps between them change"
    return Diagnostic("off-cells", message, place_of(entity), hint="move blocks by whole numbers")


# --- what is asked for -----------------------------------------------------------------------------------------------


def _asked(root: Entity) -> _Asked:
    states: dict[BlockState, int] = {AIR_STATE: AIR}
    places: list[Span | None] = [None]
    sizes: dict[int, Triple | None] = {}
    numbers: dict[int, int] = {}
    others: set[str] = set()
    for entity in descendants(root):
        if not entity.is_primitive:
            continue
        if not entity.is_block:
            others.add(entity.word)
            continue
        state = asked_state(entity)
        if state not in states:
            states[state] = len(states)
            places.append(place_of(entity))
        numbers[id(entity)] = states[state]
        sizes[id(entity)] = _whole_size(entity)
    return _Asked(sizes, numbers, tuple(states), tuple(places), tuple(sorted(others)))


def _whole_size(entity: Entity) -> Triple | None:
    assert isinstance(entity.shape, SetCuboid)
    x, y, z = entity.shape.size
    return (int(x), int(y), int(z)) if all(n == int(n) and n < FARTHEST for n in (x, y, z)) else None


def _check_count(entities: Sequence[Entity], limit: int) -> None:
    count = sum(primitive_count(entity) for entity in entities)
    if count > limit:
        raise LimitError(
            "primitives",
            f"the scene lays {count:,} cuboids of blocks, more than the {limit:,} that one build may have",
            hint="lay larger cuboids, or a part of the scene",
        )


# --- where it stands -------------------------------------------------------------------------------------------------


def _laid(entity: Entity, tree: Folded, asked: _Asked) -> Laid:
    """The cuboids and stamps that ``entity`` lays, in order; raises SceneError("blocks")."""
    return _laid_of(flatten_entity(entity, whole_cells=False), tree, asked)


def _laid_of(flat: FlatFrame, tree: Folded, asked: _Asked) -> Laid:
    primitives = flat.primitives
    stamp = np.array([tree.numbers.get(id(p), -1) for p in primitives], np.int64)
    size = whole_sizes(flat)
    low = first_cells(flat)
    for i in np.flatnonzero(stamp >= 0).tolist():  # a pattern's box need not begin at its origin
        box = tree.patterns[int(stamp[i])].box
        rows = flat.index == i
        low[rows] += box.low
        size[rows] = np.array(box.high) - box.low
    number = np.array([asked.numbers.get(id(p), AIR) for p in primitives], np.int64)
    hollow = np.array([is_hollow(p) for p in primitives], np.bool_)
    index = flat.index
    return Laid(low, low + size, number[index], hollow[index], stamp[index])


# --- the grid --------------------------------------------------------------------------------------------------------


def _finished(cells: Cells, origin: IntArray, asked: _Asked) -> Voxels:
    """The smallest box, and a palette of what stands in it."""
    used = numbers_in(cells, len(asked.palette))
    used[AIR] = True
    box = smallest_box(cells)
    kept = np.ascontiguousarray(cells[box])
    if not used.all():
        number = (np.cumsum(used) - 1).astype(np.uint32)
        slab = max(1, _SLAB // max(1, kept[:1].size))
        for start in range(0, len(kept), slab):
            kept[start : start + slab] = number[kept[start : start + slab]]
    x, y, z = (int(a) + side.start for a, side in zip(origin.tolist(), box))
    chosen = np.flatnonzero(used).tolist()
    palette = tuple(asked.palette[i] for i in chosen)
    places = tuple(asked.places[i] for i in chosen)
    return Voxels(Build((x, y, z), kept, palette), places, asked.others)


# Properties that blocks had in earlier versions of the game, or that another block has now: what they mean today.
#
# A rule applies only where the block that the version knows does not take the property as it is given, so that nothing
# that is right today is changed. The properties that were dropped or given to another block since 1.13 are those of
# `history.tsv.gz`; before 1.13, kinds of one block were properties of it: its colour, wood or stone.


_KINDS = ("variant", "type", "color", "wood_type", "material", "block_type")  # what told kinds of a block apart
_STANDING = ("torch", "redstone_torch", "soul_torch", "copper_torch")
_WALLS = {"true": "low", "false": "none"}  # until 1.16 an arm was there or not
_SAID = {"silver": "light_gray", "wood_old": "oak", "normal": "", "default": "", "all": "", "y": ""}
_FAMILIES = (  # blocks whose kinds had names of their own
    "stone", "dirt", "sand", "planks", "log", "tallgrass", "short_grass", "double_plant", "sunflower", "red_flower",
    "poppy", "yellow_flower", "dandelion", "prismarine", "stonebrick", "stone_bricks", "quartz_block",
)  # fmt: skip
_WHOLE = {
    ("quartz_block", "lines_x"): ("quartz_pillar", ("axis", "x")),
    ("quartz_block", "lines_y"): ("quartz_pillar", ("axis", "y")),
    ("quartz_block", "lines_z"): ("quartz_pillar", ("axis", "z")),
    ("stonebrick", "mossy_stonebrick"): ("mossy_stone_bricks", None),
    ("stonebrick", "cracked_stonebrick"): ("cracked_stone_bricks", None),
    ("stonebrick", "chiseled_stonebrick"): ("chiseled_stone_bricks", None),
    ("dirt", "podzol"): ("podzol", None),
    ("stone_slab", "wood_old"): ("petrified_oak_slab", None),
    ("sandstone", "smooth_sandstone"): ("cut_sandstone", None),
    ("red_sandstone", "smooth_red_sandstone"): ("cut_red_sandstone", None),
    ("prismarine", "dark_prismarine"): ("dark_prismarine", None),
    ("prismarine", "prismarine_bricks"): ("prismarine_bricks", None),
    ("tallgrass", "dead_bush"): ("dead_bush", None),
    ("double_plant", "syringa"): ("lilac", None),
    ("double_plant", "double_rose"): ("rose_bush", None),
    ("double_plant", "paeonia"): ("peony", None),
    ("double_plant", "double_grass"): ("tall_grass", None),
    ("double_plant", "double_fern"): ("large_fern", None),
    ("red_flower", "houstonia"): ("azure_bluet", None),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Modern:
    """A block as the version has it: its ``kind``, the properties that it takes, and those of the given ones that mean
    nothing to it."""

    kind: BlockKind
    given: dict[str, str]
    dropped: dict[str, str]


def modern(name: str, kind: BlockKind, given: Mapping[str, str], table: BlockTable) -> Modern:
    """What the block asked for as ``name``, which the version has as ``kind``, is with the properties ``given``."""
    kept: dict[str, str] = {}
    dropped: dict[str, str] = {}
    for key, value in sorted(given.items(), key=lambda pair: pair[0] not in _KINDS):  # which block it is comes first
        if value in kind.values.get(key, ()):
            kept[key] = value
            continue
        change = _moved(name, kind, key, value, table)
        if change is None:
            dropped[key] = value
            continue
        kind, more = change
        kept |= more
    late = {key: value for key, value in kept.items() if value not in kind.values.get(key, ())}
    return Modern(kind, {key: value for key, value in kept.items() if key not in late}, dropped | late)


Change = tuple[BlockKind, dict[str, str]]


def _moved(name: str, kind: BlockKind, key: str, value: str, table: BlockTable) -> Change | None:
    """The block that now has what ``key`` said of the block, and the properties that say it there; None where there is
    none."""
    plain = kind.name.removeprefix(NAMESPACE)
    if key in _KINDS:
        return _kind_of(name.removeprefix(NAMESPACE), plain, value, table)
    if plain == "cauldron" and key == "level":  # filled ones are blocks of their own since 1.17
        filled = table.blocks.get(NAMESPACE + "water_cauldron")
        if value == "0":
            return kind, {}
        return (filled, {"level": value}) if filled is not None and value in filled.values.get("level", ()) else None
    if plain in _STANDING and key == "facing":
        return _torch(kind, plain, value, table)
    if plain == "sponge" and key == "wet":
        wet = table.blocks.get(NAMESPACE + "wet_sponge")
        return (kind, {}) if value == "false" else (wet, {}) if wet is not None and value == "true" else None
    if key == "axis" and value == "none" and plain.endswith("_log"):
        bark = table.blocks.get(NAMESPACE + plain.removesuffix("log") + "wood")
        return None if bark is None else (bark, {})
    same = dict(_renamed(kind, key, value))
    return (kind, same) if same and all(v in kind.values.get(k, ()) for k, v in same.items()) else None


def _renamed(kind: BlockKind, key: str, value: str) -> Iterator[tuple[str, str]]:
    """The property of the same block that says today what ``key`` did."""
    if key in kind.values and value in _WALLS:
        yield key, _WALLS[value]
    elif key == "half" and kind.shape == "slab":
        yield "type", value
    elif key == "half" and value in ("top", "bottom", "upper", "lower"):
        yield "half", {"top": "upper", "bottom": "lower", "upper": "top", "lower": "bottom"}[value]
    elif key == "decayable":
        yield "persistent", {"true": "false", "false": "true"}.get(value, "")
    elif key == "facing" and value in ("up", "down") and "face" in kind.values:
        yield "face", {"up": "floor", "down": "ceiling"}[value]
    elif key == "rotation" and "facing" in kind.values and value.isdecimal() and int(value) < 16:
        yield "facing", ("south", "west", "north", "east")[(int(value) + 2) // 4 % 4]
    elif key == "facing" and "rotation" in kind.values and value in ("south", "west", "north", "east"):
        yield "rotation", str(4 * ("south", "west", "north", "east").index(value))
    elif key == "facing" and "axis" in kind.values and "facing" not in kind.values:
        yield "axis", {"north": "z", "south": "z", "east": "x", "west": "x"}.get(value, "y")
    elif key == "axis" and "facing" in kind.values and value in "xyz":
        yield "facing", {"x": "east", "y": "up", "z": "south"}[value]


def _torch(kind: BlockKind, plain: str, value: str, table: BlockTable) -> Change | None:
    """Torches on walls are blocks of their own since 1.13."""
    if value == "up":
        return kind, {}
    wall = f"{plain.removesuffix('torch')}wall_torch"
    on_wall = table.blocks.get(NAMESPACE + wall)
    return (on_wall, {"facing": value}) if on_wall is not None and value in on_wall.values["facing"] else None


def _kind_of(asked: str, plain: str, value: str, table: BlockTable) -> Change | None:
    """The block that is the kind ``value`` of the block ``asked``, which is called ``plain`` today."""
    value = value.replace(" ", "_")
    whole = _WHOLE.get((asked, value)) or _WHOLE.get((plain, value))
    if whole is not None:
        found = table.blocks.get(NAMESPACE + whole[0])
        return None if found is None else (found, dict([whole[1]] if whole[1] is not None else []))
    said = _SAID.get(value, value)
    if not said:
        return table.blocks[NAMESPACE + plain], {}
    for base in dict.fromkeys((plain, asked)):
        for name in _named(said, base):
            full = NAMESPACE + name if NAMESPACE + name in table.blocks else None
            if full is None:
                newer = renamed(name, {known.removeprefix(NAMESPACE) for known in table.blocks})
                full = None if newer is None else NAMESPACE + newer
            if full is not None:
                return table.blocks[full], {}
    return None


def _named(value: str, base: str) -> Iterator[str]:
    """How a block may be called that is the kind ``value`` of ``base``, the likeliest first."""
    last = base.rpartition("_")[2]
    yield f"{value}_{base}"
    if "smooth_" in value:
        yield value.replace("smooth_", "polished_")
    for word in ("oak_", "white_", "red_", "stone_", "cobblestone_"):
        if base.startswith(word):
            yield f"{value}_{base.removeprefix(word)}"
    yield f"{value}_{last}"
    if value.endswith(("s", "es")):
        yield f"{value.removesuffix('s')}_{last}"
    if base in _FAMILIES:
        yield value
