"""Voxelization of entities that place blocks (the paper, appendix "Minecraft Renderer").

The rules are those of the reference implementation: a cuboid begins at its position, truncated toward zero, and its
size in cells is ``:scale`` times the scale of its pose. Cuboids are placed in program order, later ones replacing
earlier ones; ``delete-blocks`` and ``minecraft:air`` empty their cells, hollow cuboids preserve their interior. The
resulting cells contain states as requested by the program; ``settled`` resolves them to complete block states.
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
    BlockKind,
    BlockState,
    BlockTable,
    Build,
    Cells,
    numbers_in,
    renamed,
    smallest_box,
    without_number,
)
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.runtime.show import NotPlain, plain_value
from scenelang.interpreter.scene.entity import Entity, descendants, instance_counts, primitive_count
from scenelang.interpreter.scene.flatten import FlatFrame, flatten_entity
from scenelang.interpreter.scene.primitives import block_words
from scenelang.interpreter.scene.primitives.blocks import SetCuboid
from scenelang.interpreter.values.values import ANONYMOUS, Matrix, Pair

# Requested states: the block and the properties given by the program, before validation.


NAMESPACE = "minecraft:"
_WITH_STATE = re.compile(r"([^\[\]]+)\[([^\[\]]*)\]")  # the game's notation: oak_log[axis=x]


def asked_state(entity: Entity) -> BlockState:
    """Return the block that a "set-cuboid" or "delete-blocks" places, with only the properties given by the program.

    Raises SceneError("attribute"), with the location in the program, if ``:block-type`` or ``:block-kwargs`` is missing
    or invalid.
    """
    if isinstance(entity.shape, SetCuboid) and entity.shape.removes_blocks:
        return AIR_STATE
    name = entity.embedding.attributes.get("block-type")
    if not isinstance(name, str) or not name.strip():
        raise _problem(entity, "block-type", 'the name of a block, such as "stone"')
    match = _WITH_STATE.fullmatch(name.strip())
    given = _pairs_of_text(match[2]) if match else {}
    state = tuple(sorted({**given, **properties_of(entity)}.items()))
    block = namespaced(match[1] if match else name)
    return AIR_STATE if block in NOTHING else BlockState(block, state)


def is_hollow(entity: Entity) -> bool:
    """Return whether only the six faces are placed; raises SceneError("attribute") if ``:fill`` is not a boolean."""
    fill = entity.embedding.attributes.get("fill")
    if fill is not None and not isinstance(fill, bool):
        raise _problem(entity, "fill", "#t or #f")
    return fill is False


def namespaced(name: str) -> str:
    """Normalise a block name: ``Oak Planks`` becomes ``minecraft:oak_planks``.

    Numeric variants from before 1.13 are converted to current names.
    """
    plain = without_number(re.sub(r"\s+", "_", name.strip().lower()).removeprefix(NAMESPACE))
    return plain if ":" in plain else NAMESPACE + plain


def properties_of(entity: Entity) -> dict[str, str]:
    """Return the properties given by ``:block-kwargs``, in the game's notation; raises SceneError("attribute")."""
    given = entity.embedding.attributes.get("block-kwargs")
    try:
        return _pairs(plain_value(given))
    except (NotPlain, ValueError):
        raise _problem(
            entity, "block-kwargs", 'an association list or table of properties, such as `\'(("facing" "north"))`'
        ) from None


def _pairs_of_text(text: str) -> dict[str, str]:
    """Return the properties in the game's notation: ``axis=x,lit=true``."""
    pairs = [pair.partition("=") for pair in text.split(",") if pair.strip()]
    return {_text(name): _text(value) for name, _, value in pairs}


def _pairs(given: Any) -> dict[str, str]:
    """Return properties from an association list or table; raises ValueError for other values."""
    if given is None:
        return {}
    if isinstance(given, Mapping):
        return {_text(name): _text(value) for name, value in given.items()}
    if isinstance(given, list) and all(isinstance(pair, list) and len(pair) == 2 for pair in given):
        return {_text(name): _text(value) for name, value in given}
    raise ValueError


def _text(value: Any) -> str:
    """Return a name or value in the game's notation: ``true``, ``7``, ``north``."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, (str, int)):
        return str(value).strip().lower().removeprefix(":")
    raise ValueError


def place_of(entity: Entity) -> Span | None:
    """Return the source location of a primitive, the first of several."""
    return entity.call_sites[0] if entity.call_sites else None


def _problem(entity: Entity, name: str, expected: str) -> SceneError:
    """Return the error about an invalid attribute."""
    message = f'the attribute `:{name}` of "{entity.word}" must be {expected}'
    return SceneError("attribute", message, span=place_of(entity))


# Placing cuboids of blocks in a grid of cells, in order, later ones replacing earlier ones.


IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_MAX_BATCHED_CELLS = 64  # smaller cuboids are placed in batches, larger ones with a slice assignment each
_BATCH_SMALL_CELLS = 1 << 20  # cells placed per batch


@dataclass(frozen=True, slots=True, eq=False)
class Stamp:
    """A precomputed block of cells (X, Y, Z), to be copied where ``touched``; None for all."""

    cells: Cells
    touched: BoolArray | None


@dataclass(frozen=True, slots=True, eq=False)
class Laid:
    """Cuboids in placement order.

    The cells ``low <= c < high`` become ``number``; with ``hollow`` only those of the six faces. ``stamp`` is the index
    of a stamp to copy there instead, -1 for none.
    """

    low: IntArray  # (N, 3)
    high: IntArray  # (N, 3)
    number: IntArray  # (N,)
    hollow: BoolArray  # (N,)
    stamp: IntArray  # (N,)


def paint(cells: Cells, origin: IntArray, laid: Laid, stamps: Sequence[Stamp]) -> None:
    """Place everything in ``cells``, whose first cell is ``origin`` (3,).

    Cuboids are clipped to the grid; stamps must be inside it.
    """
    laid = _as_slabs(laid)
    limit = np.array(cells.shape, np.int64)
    low = np.clip(laid.low - origin, 0, limit)
    high = np.clip(laid.high - origin, low, limit)
    volume = (high - low).prod(axis=1)
    single = (volume > _MAX_BATCHED_CELLS) | (laid.stamp >= 0)
    for first, last in _runs(single):
        if not single[first]:
            _paint_small(cells, low[first:last], high[first:last], volume[first:last], laid.number[first:last])
            continue
        for i in range(first, last):
            region = tuple(slice(a, b) for a, b in zip(low[i].tolist(), high[i].tolist()))
            if laid.stamp[i] >= 0:
                _copy_stamp(cells[region], stamps[int(laid.stamp[i])])
            else:
                cells[region] = laid.number[i]


def _as_slabs(laid: Laid) -> Laid:
    """Replace every hollow cuboid by its six faces."""
    is_hollow = laid.hollow & (laid.high - laid.low > 2).all(axis=1)
    if not is_hollow.any():
        return laid
    rows = np.repeat(np.arange(len(is_hollow)), np.where(is_hollow, 6, 1))
    low, high = laid.low[rows], laid.high[rows]
    first = np.flatnonzero(is_hollow[rows])[::6]
    for axis in range(3):
        high[first + 2 * axis, axis] = low[first + 2 * axis, axis] + 1
        low[first + 2 * axis + 1, axis] = high[first + 2 * axis + 1, axis] - 1
    return Laid(low, high, laid.number[rows], np.zeros(len(rows), np.bool_), laid.stamp[rows])


def _runs(mask: BoolArray) -> Iterator[tuple[int, int]]:
    """Yield the maximal runs in which the mask is constant."""
    edges = np.flatnonzero(np.diff(mask)) + 1
    bounds = [0, *edges.tolist(), len(mask)]
    yield from ((a, b) for a, b in pairwise(bounds) if a < b)


def _copy_stamp(target: Cells, stamp: Stamp) -> None:
    """Copy the touched cells of a stamp."""
    if stamp.touched is None:
        target[...] = stamp.cells
    else:
        np.copyto(target, stamp.cells, where=stamp.touched)


def _paint_small(cells: Cells, low: IntArray, high: IntArray, volume: IntArray, number: IntArray) -> None:
    """Place small cuboids, all their cells at once; for equal indices numpy keeps the last value."""
    flat = cells.reshape(-1)
    _, ny, nz = cells.shape
    ends = np.cumsum(volume)
    start = 0
    while start < len(volume):
        before = int(ends[start - 1]) if start else 0
        stop = max(start + 1, int(np.searchsorted(ends, before + _BATCH_SMALL_CELLS, side="right")))
        index = np.repeat(np.arange(start, stop), volume[start:stop])
        within = np.arange(before, int(ends[stop - 1])) - (ends - volume)[index]
        size = (high - low)[index]
        z, rest = within % size[:, 2], within // size[:, 2]
        y, x = rest % size[:, 1], rest // size[:, 1]
        at = ((low[index, 0] + x) * ny + low[index, 1] + y) * nz + low[index, 2] + z
        flat[at] = number[index]
        start = stop


# Instancing: entities that occur in several places of a build are voxelized once, then copied as a stamp. This is exact
# if every pose from the root to the entity, and below it, is a translation by whole cells: truncation then has no
# effect, and the entity has the same cells at every place.


MAX_COORDINATE = 1 << 53  # cells from the origin, beyond which floats do not represent all integers
_MIN_STAMP_PRIMITIVES = 8  # of a stamp: a smaller one costs more than placing its primitives
_MAX_STAMP_SPARSITY = 64  # cells of a stamp's box per primitive: a sparser one takes longer than placing its primitives
_MAX_STAMP_CELLS = 1 << 22  # cells of one stamp
_MAX_STAMPS_CELLS = 1 << 25  # cells of all stamps together: 128 MB

Sizes = Mapping[int, tuple[int, int, int] | None]
Triple = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class CellBox:
    """The cells ``low <= c < high``."""

    low: Triple
    high: Triple

    @property
    def volume(self) -> int:
        """Number of cells in the box."""
        return (self.high[0] - self.low[0]) * (self.high[1] - self.low[1]) * (self.high[2] - self.low[2])


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """Repeated entity, and the cells that it may touch in its frame.

    Repeated entities inside it are replaced by placeholders.
    """

    entity: Entity
    box: CellBox


@dataclass(frozen=True, slots=True, eq=False)
class Folded:
    """DAG of an entity with repeated entities replaced by placeholders, and without entities that place no blocks.

    ``numbers`` maps the ``id`` of a placeholder to its index in ``patterns``. Patterns come before those that use them.
    """

    root: Entity
    numbers: Mapping[int, int]
    patterns: tuple[Pattern, ...]


def folded(root: Entity, sizes: Sizes) -> Folded:
    """Replace repeated entities of ``root`` by placeholders.

    ``sizes`` maps the ``id`` of every primitive that places blocks to its number of cells along each axis, None if it
    is not an integer.
    """
    order = list(descendants(root))
    boxes = _worth_closing(order, sizes)
    replacements: dict[int, Entity] = {}
    numbers: dict[int, int] = {}
    patterns: list[Pattern] = []
    remaining_cells = _MAX_STAMPS_CELLS
    for entity in order:
        replacement = entity if id(entity) in sizes else _without_others(entity, replacements)
        if replacement is None:
            continue
        box = boxes.get(id(entity))
        if box is not None and box.volume <= min(remaining_cells, _MAX_STAMP_CELLS):
            remaining_cells -= box.volume
            placeholder = Entity(entity.word, ANONYMOUS, (), SetCuboid())
            numbers[id(placeholder)] = len(patterns)
            patterns.append(Pattern(replacement, box))
            replacement = placeholder
        replacements[id(entity)] = replacement
    return Folded(replacements.get(id(root), Entity(root.word, ANONYMOUS, ())), numbers, tuple(patterns))


def _without_others(entity: Entity, replacements: Mapping[int, Entity]) -> Entity | None:
    """Return the entity with its children replaced, None if none of them places blocks."""
    children = [part for part in entity.children if id(part.car) in replacements]
    if not children:
        return None
    if len(children) == len(entity.children) and all(replacements[id(part.car)] is part.car for part in children):
        return entity
    return Entity(entity.word, ANONYMOUS, tuple(Pair(replacements[id(part.car)], part.cdr) for part in children))


def _worth_closing(order: Sequence[Entity], sizes: Sizes) -> dict[int, CellBox]:
    """Return the cells of each entity that can and should be a stamp, by ``id``; children come first in ``order``."""
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
            primitives[id(entity)] = 0  # nothing below it places blocks
    return {
        key: box for key, box in boxes.items()
        if key in movable and primitives[key] >= _MIN_STAMP_PRIMITIVES
        and box.volume <= _MAX_STAMP_SPARSITY * primitives[key]
    }  # fmt: skip


def _whole_from_the_root(order: Sequence[Entity]) -> set[int]:
    """Return the ids of entities with children whose instances are all at whole cells."""
    moved: set[int] = set()
    for entity in reversed(order):
        free = id(entity) in moved
        for part in entity.children:
            if part.car.children and (free or not is_whole_step(part.cdr)):
                moved.add(id(part.car))
    return {id(entity) for entity in order if entity.children and id(entity) not in moved}


def is_whole_step(m: Matrix) -> bool:
    """Return whether the pose is a translation by whole cells."""
    x, y, z = m[3], m[7], m[11]
    return (
        m[0] == m[5] == m[10] == 1.0
        and not (m[1] or m[2] or m[4] or m[6] or m[8] or m[9])
        and x % 1.0 == y % 1.0 == z % 1.0 == 0.0
        and max(abs(x), abs(y), abs(z)) < MAX_COORDINATE
    )


def _own_box(size: Triple | None) -> CellBox | None:
    """Return the cells of a primitive in its own frame, None without whole sizes."""
    return None if size is None else CellBox((0, 0, 0), size)


def _joined(entity: Entity, boxes: Mapping[int, CellBox], primitives: Mapping[int, int]) -> CellBox | None:
    """Return the box around an entity's children, None if one of them is not at whole cells."""
    corners: list[tuple[Triple, Triple]] = []
    for part in entity.children:
        box, m = boxes.get(id(part.car)), part.cdr
        if box is None and primitives.get(id(part.car)) == 0:
            continue
        if box is None or not is_whole_step(m):
            return None
        x, y, z = int(m[3]), int(m[7]), int(m[11])
        (a, b, c), (d, e, f) = box.low, box.high
        corners.append(((a + x, b + y, c + z), (d + x, e + y, f + z)))
    if not corners:
        return None
    xs, ys, zs = (([low[i] for low, _ in corners], [high[i] for _, high in corners]) for i in range(3))
    return CellBox((min(xs[0]), min(ys[0]), min(zs[0])), (max(xs[1]), max(ys[1]), max(zs[1])))


# Placement of cuboids: whole cells from the poses of primitives, and validation of poses.


_SUM_TOLERANCE = 1e-9  # in cells: rounding error of summed translations
_PRODUCT_TOLERANCE = 1e-6  # in cells: rounding error of multiplied poses


def first_cells(flat: FlatFrame) -> IntArray:
    """Return the first cell of each instance (N, 3): its position truncated toward zero, up to rounding errors."""
    position = flat.matrices[:, :, 3]
    nearest = np.rint(position)
    first: IntArray = np.where(np.abs(position - nearest) < _SUM_TOLERANCE, nearest, np.trunc(position)).astype(
        np.int64
    )
    return first


def off_cells(flat: FlatFrame) -> tuple[int, list[float], int] | None:
    """Detect instances between cells whose truncation changes their relative distances.

    Returns their number, the position (3,) of the first and its index; None if all are shifted equally.
    """
    position = flat.matrices[:, :, 3]
    if not len(position):
        return None
    shift = position - first_cells(flat)
    differs = (np.abs(shift - shift[0]) > _SUM_TOLERANCE).any(axis=1)
    if not differs.any():
        return None
    is_off = (np.abs(shift) > _SUM_TOLERANCE).any(axis=1)
    first = int(np.argmax(is_off))
    return int(is_off.sum()), position[first].tolist(), first


def whole_sizes(flat: FlatFrame) -> IntArray:
    """Return the cells of each instance along each axis (N, 3); raises SceneError("blocks") for unsupported poses.

    Rotated, mirrored or fractionally scaled blocks are errors in images too, because no game file could hold them.
    Stairs, logs and doors are oriented by their properties.
    """
    primitive_sizes = np.array([_own_size(p) for p in flat.primitives], np.float64).reshape(-1, 3)
    linear, position = flat.matrices[:, :, :3], flat.matrices[:, :, 3]
    along = np.diagonal(linear, axis1=1, axis2=2)
    across = np.abs(linear * (1.0 - np.eye(3))).max(axis=(1, 2), initial=0.0)
    with np.errstate(invalid="ignore", over="ignore"):
        size = along * primitive_sizes[flat.index]
        whole = np.rint(size)
        is_far = np.asarray(~((np.abs(position) < MAX_COORDINATE).all(axis=1) & (size < MAX_COORDINATE).all(axis=1)))
        is_skewed = across > _PRODUCT_TOLERANCE * np.maximum(np.abs(along).max(axis=1, initial=0.0), _PRODUCT_TOLERANCE)
        is_rotated: BoolArray = ~is_far & (is_skewed | (along < 0.0).any(axis=1))
        is_fractional = ~is_far & (
            (np.abs(size - whole) > np.clip(_PRODUCT_TOLERANCE * whole, _PRODUCT_TOLERANCE, 0.01))
            | ((whole == 0) & (size > 0))
        ).any(axis=1)
    is_invalid = is_far | is_rotated | is_fractional
    if is_invalid.any():
        i = int(np.argmax(is_invalid))
        raise _pose_error(flat, i, "far" if is_far[i] else "turned" if is_rotated[i] else "broken", size[i])
    return whole.astype(np.int64)


def _own_size(primitive: Entity) -> tuple[float, float, float]:
    """Return the size of a primitive in its own frame, in cells."""
    assert isinstance(primitive.shape, SetCuboid)
    return primitive.shape.size


def _pose_error(flat: FlatFrame, i: int, reason: str, size: FloatArray) -> SceneError:
    """Return the error about a pose that blocks do not support."""
    entity = flat.primitives[int(flat.index[i])]
    path = " > ".join((*flat.paths[int(flat.path_index[i])], entity.word))
    shown = " x ".join(f"{n:.6g}" for n in size)
    problem, hint = {
        "far": ("is too far from the origin", None),
        "turned": (
            "is rotated, mirrored or sheared, which blocks do not support",
            "use only `translate` and integer `scale` with blocks; rotate stairs and logs with `:block-kwargs`",
        ),
        "broken": (f"is {shown} cells large, but blocks fill whole cells", "scale blocks by whole numbers"),
    }[reason]
    return SceneError("blocks", f'"{entity.word}" at {path} {problem}', hint=hint, span=place_of(entity))


def cells_around(laid: Laid, most_cells: int) -> tuple[IntArray, tuple[int, ...]]:
    """Return the first cell (3,) and the size of the box around everything placed; raises LimitError."""
    is_placed = ((laid.number != AIR) | (laid.stamp >= 0)) & (laid.high > laid.low).all(axis=1)
    if not is_placed.any():
        return np.zeros(3, np.int64), (0, 0, 0)
    low, high = laid.low[is_placed].min(axis=0), laid.high[is_placed].max(axis=0)
    size = tuple((high - low).tolist())
    if size[0] * size[1] * size[2] > most_cells:
        shown = " x ".join(f"{n:,}" for n in size)
        raise LimitError(
            "size",
            f"the build's box is {shown} cells, more than the limit of {most_cells:,}",
            hint="move its parts closer together, or place smaller cuboids",
        )
    return low, size


MAX_CELLS = 200_000_000  # of a build's box
_UNTOUCHED = np.uint32(0xFFFFFFFF)  # in a stamp: a cell that is not changed
_BATCH_CELLS = 1 << 22  # cells processed per batch


@dataclass(frozen=True, slots=True, eq=False)
class Voxels:
    """Result of voxelization.

    Attributes
    ----------
    build
        Requested states, with only the properties given by the program.
    places
        Source location of the request of each entry of ``build.palette``.
    others
        Sorted words of primitives that place no blocks.
    off_cells
        Warning if blocks are between cells with different offsets.
    """

    build: Build
    places: tuple[Span | None, ...]
    others: tuple[str, ...]
    off_cells: Diagnostic | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Requested:
    """The primitives that place blocks, by ``id``.

    ``sizes`` are their sizes if integer, ``numbers`` the index of their block in ``palette``; ``places`` are the source
    locations of the palette's entries.
    """

    sizes: Sizes
    numbers: Mapping[int, int]
    palette: tuple[BlockState, ...]
    places: tuple[Span | None, ...]
    others: tuple[str, ...]


def voxelised(root: Entity, limit: int = 2_000_000, most_cells: int = MAX_CELLS) -> Voxels:
    """Return the blocks of ``root``, in the smallest box that contains them; the box is empty if nothing is placed.

    Raises SceneError: "attribute" for an invalid block, "blocks" for a pose that is not a translation and an integer
    scale; and LimitError for more than ``limit`` primitives, with repeated entities counted once, or a box of more than
    ``most_cells`` cells.
    """
    requested = _requested(root)
    tree = folded(root, requested.sizes)
    _check_count((tree.root, *(pattern.entity for pattern in tree.patterns)), limit)
    stamps: list[Stamp] = []
    for pattern in tree.patterns:
        origin = np.array(pattern.box.low, np.int64)
        cells = np.full(np.array(pattern.box.high, np.int64) - origin, _UNTOUCHED, np.uint32)
        paint(cells, origin, _cuboids_of(pattern.entity, tree, requested), stamps)
        touched = cells != _UNTOUCHED
        stamps.append(Stamp(cells, None if touched.all() else touched))
    flat = flatten_entity(tree.root, snap_blocks=False)
    laid = _laid_of(flat, tree, requested)
    origin, size = cells_around(laid, most_cells)
    cells = np.zeros(size, np.uint32)
    paint(cells, origin, laid, stamps)
    return replace(_finished(cells, origin, requested), off_cells=_off_cells(flat))


def ignored(voxels: Voxels) -> Diagnostic | None:
    """Return the warning that lists the words which place no blocks, None if there are none."""
    if not voxels.others:
        return None
    shown = ", ".join(f'"{word}"' for word in voxels.others[:8]) + (", .." if len(voxels.others) > 8 else "")
    message = f"only {' and '.join(block_words())} place blocks; ignored: {shown}"
    return Diagnostic("no-block", message, hint="voxelise the shapes of the whole scene with --voxelize 64")


def _off_cells(flat: FlatFrame) -> Diagnostic | None:
    """Return the warning about blocks between cells whose distances change; patterns are always at whole cells."""
    misaligned = off_cells(flat)
    if misaligned is None:
        return None
    count, position, number = misaligned
    entity = flat.primitives[int(flat.index[number])]
    cell = first_cells(flat)[number].tolist()
    actual, placed = " ".join(f"{n:.6g}" for n in position), " ".join(map(str, cell))
    message = f"{count:,} cuboids are not aligned to cells, such as the one at [{actual}], placed"
    message += f" at [{placed}]; distances between them change"
    return Diagnostic("off-cells", message, place_of(entity), hint="translate blocks by integers")


# --- requested blocks ------------------------------------------------------------------------------------------------


def _requested(root: Entity) -> _Requested:
    """Collect the primitives that place blocks, and the states that they request."""
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
    return _Requested(sizes, numbers, tuple(states), tuple(places), tuple(sorted(others)))


def _whole_size(entity: Entity) -> Triple | None:
    """Return the size of a primitive in cells, None if it is fractional or too large."""
    assert isinstance(entity.shape, SetCuboid)
    x, y, z = entity.shape.size
    return (int(x), int(y), int(z)) if all(n == int(n) and n < MAX_COORDINATE for n in (x, y, z)) else None


def _check_count(entities: Sequence[Entity], limit: int) -> None:
    """Raise LimitError for more than ``limit`` primitives."""
    count = sum(primitive_count(entity) for entity in entities)
    if count > limit:
        raise LimitError(
            "primitives",
            f"the scene places {count:,} cuboids of blocks, more than the limit of {limit:,}",
            hint="place larger cuboids, or a part of the scene",
        )


# --- placement -------------------------------------------------------------------------------------------------------


def _cuboids_of(entity: Entity, tree: Folded, requested: _Requested) -> Laid:
    """Return the cuboids and stamps that ``entity`` places, in order; raises SceneError("blocks")."""
    return _laid_of(flatten_entity(entity, snap_blocks=False), tree, requested)


def _laid_of(flat: FlatFrame, tree: Folded, requested: _Requested) -> Laid:
    """Return the cuboids and stamps of a flattened entity; placeholders become stamps."""
    primitives = flat.primitives
    stamp = np.array([tree.numbers.get(id(p), -1) for p in primitives], np.int64)
    size = whole_sizes(flat)
    low = first_cells(flat)
    for i in np.flatnonzero(stamp >= 0).tolist():  # a pattern's box may begin away from its origin
        box = tree.patterns[int(stamp[i])].box
        rows = flat.index == i
        low[rows] += box.low
        size[rows] = np.array(box.high) - box.low
    number = np.array([requested.numbers.get(id(p), AIR) for p in primitives], np.int64)
    hollow = np.array([is_hollow(p) for p in primitives], np.bool_)
    index = flat.index
    return Laid(low, low + size, number[index], hollow[index], stamp[index])


# --- the grid --------------------------------------------------------------------------------------------------------


def _finished(cells: Cells, origin: IntArray, requested: _Requested) -> Voxels:
    """Return the build in the smallest box, with a palette of used states."""
    used = numbers_in(cells, len(requested.palette))
    used[AIR] = True
    box = smallest_box(cells)
    cropped = np.ascontiguousarray(cells[box])
    if not used.all():
        number = (np.cumsum(used) - 1).astype(np.uint32)
        batch = max(1, _BATCH_CELLS // max(1, cropped[:1].size))
        for start in range(0, len(cropped), batch):
            cropped[start : start + batch] = number[cropped[start : start + batch]]
    x, y, z = (int(a) + side.start for a, side in zip(origin.tolist(), box))
    chosen = np.flatnonzero(used).tolist()
    palette = tuple(requested.palette[i] for i in chosen)
    places = tuple(requested.places[i] for i in chosen)
    return Voxels(Build((x, y, z), cropped, palette), places, requested.others)


# Properties of earlier versions of the game, or that moved to another block: conversion to the current version. A rule
# applies only if the current block does not accept the property as given, so that valid properties are unchanged.
# Properties dropped or moved since 1.13 are those in `history.tsv.gz`; before 1.13, variants of a block were
# properties: its color, wood or stone.


# properties that distinguished the variants of a block before 1.13
_VARIANT_KEYS = ("variant", "type", "color", "wood_type", "material", "block_type")
_STANDING = ("torch", "redstone_torch", "soul_torch", "copper_torch")
_WALL_HEIGHTS = {"true": "low", "false": "none"}  # before 1.16 the arms of walls were boolean
_VALUE_ALIASES = {"silver": "light_gray", "wood_old": "oak", "normal": "", "default": "", "all": "", "y": ""}
_FAMILIES = (  # blocks whose variants had unrelated names
    "stone", "dirt", "sand", "planks", "log", "tallgrass", "short_grass", "double_plant", "sunflower", "red_flower",
    "poppy", "yellow_flower", "dandelion", "prismarine", "stonebrick", "stone_bricks", "quartz_block",
)  # fmt: skip
# Variants that became another block: old block and variant, new block and the property that it sets.
_VARIANT_BLOCKS = {
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
}


@dataclass(frozen=True, slots=True)
class Modern:
    """Block in the current version, its properties, and the given properties that it lacks."""

    kind: BlockKind
    given: dict[str, str]
    dropped: dict[str, str]


def modern(name: str, kind: BlockKind, given: Mapping[str, str], table: BlockTable) -> Modern:
    """Convert a block and its properties to the current version.

    ``kind`` is the block that the version has for ``name``.
    """
    accepted: dict[str, str] = {}
    dropped: dict[str, str] = {}
    # Properties that determine the block come first.
    for key, value in sorted(given.items(), key=lambda pair: pair[0] not in _VARIANT_KEYS):
        if value in kind.values.get(key, ()):
            accepted[key] = value
            continue
        change = _moved(name, kind, key, value, table)
        if change is None:
            dropped[key] = value
            continue
        kind, more = change
        accepted |= more
    outdated = {key: value for key, value in accepted.items() if value not in kind.values.get(key, ())}
    return Modern(kind, {key: value for key, value in accepted.items() if key not in outdated}, dropped | outdated)


Change = tuple[BlockKind, dict[str, str]]


def _moved(name: str, kind: BlockKind, key: str, value: str, table: BlockTable) -> Change | None:
    """Return the block and the properties that now represent the property ``key``, None if there are none."""
    plain = kind.name.removeprefix(NAMESPACE)
    if key in _VARIANT_KEYS:
        return _kind_of(name.removeprefix(NAMESPACE), plain, value, table)
    if plain == "cauldron" and key == "level":  # filled ones are separate blocks since 1.17
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
    renamed_properties = dict(_renamed(kind, key, value))
    return (
        (kind, renamed_properties)
        if renamed_properties and all(v in kind.values.get(k, ()) for k, v in renamed_properties.items())
        else None
    )


def _renamed(kind: BlockKind, key: str, value: str) -> Iterator[tuple[str, str]]:
    """Yield the current property of the same block that replaces ``key``."""
    if key in kind.values and value in _WALL_HEIGHTS:
        yield key, _WALL_HEIGHTS[value]
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
    """Return a wall torch, a separate block since 1.13, or the standing torch for `up`."""
    if value == "up":
        return kind, {}
    wall = f"{plain.removesuffix('torch')}wall_torch"
    on_wall = table.blocks.get(NAMESPACE + wall)
    return (on_wall, {"facing": value}) if on_wall is not None and value in on_wall.values["facing"] else None


def _kind_of(requested: str, plain: str, value: str, table: BlockTable) -> Change | None:
    """Return the variant ``value`` of the block ``requested``, whose current name is ``plain``."""
    value = value.replace(" ", "_")
    variant_block = _VARIANT_BLOCKS.get((requested, value)) or _VARIANT_BLOCKS.get((plain, value))
    if variant_block is not None:
        block = table.blocks.get(NAMESPACE + variant_block[0])
        return None if block is None else (block, dict([variant_block[1]] if variant_block[1] is not None else []))
    variant = _VALUE_ALIASES.get(value, value)
    if not variant:
        return table.blocks[NAMESPACE + plain], {}
    for base in dict.fromkeys((plain, requested)):
        for name in _named(variant, base):
            full = NAMESPACE + name if NAMESPACE + name in table.blocks else None
            if full is None:
                newer = renamed(name, {known.removeprefix(NAMESPACE) for known in table.blocks})
                full = None if newer is None else NAMESPACE + newer
            if full is not None:
                return table.blocks[full], {}
    return None


def _named(value: str, base: str) -> Iterator[str]:
    """Yield candidate names for the variant ``value`` of ``base``, most likely first."""
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
