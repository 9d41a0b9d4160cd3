"""Voxelisation: from an entity to the blocks that it lays (the paper, appendix "Minecraft Renderer").

The numbers are the reference's: a cuboid begins at its position, truncated toward zero, and has as many cells along
each axis as ``:scale`` times the pose's own scale. Cuboids are laid in the order of the program, later ones on top;
``delete-blocks`` and ``minecraft:air`` empty their cells, hollow cuboids keep what is inside them. What stands in a
cell is what the program asked for; ``settle`` makes whole block states of that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from scenelang.backends.minecraft.asked import asked_state, place_of
from scenelang.backends.minecraft.blocks import AIR, AIR_STATE, BlockState, Build, Cells
from scenelang.backends.minecraft.painting import BoolArray, FloatArray, IntArray, Laid, Stamp, paint
from scenelang.backends.minecraft.repeats import FARTHEST, Folded, Sizes, Triple, folded
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.entity import Entity, descendants, primitive_count
from scenelang.interpreter.flatten import FlatFrame, flatten_entity
from scenelang.interpreter.shapes import BLOCK_WORDS

MOST_CELLS = 200_000_000
_UNTOUCHED = np.uint32(0xFFFFFFFF)  # of a stamp: what it leaves as it is
_SLACK = 1e-6  # cells: what multiplied poses may be off
_SLAB = 1 << 22  # cells that are looked at together


@dataclass(frozen=True, slots=True, eq=False)
class Voxels:
    """``build`` holds the states that the program asks for, with the properties that it gives and no others;
    ``places[n]`` is where the program asks for ``build.palette[n]``. ``others`` are the words of the primitives that
    lay no blocks, sorted."""

    build: Build
    places: tuple[Span | None, ...]
    others: tuple[str, ...]


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
    laid = _laid(tree.root, tree, asked)
    origin, size = _box(laid, most_cells)
    cells = np.zeros(size, np.uint32)
    paint(cells, origin, laid, stamps)
    return _finished(cells, origin, asked)


def ignored(voxels: Voxels) -> Diagnostic | None:
    """The warning that names the words which lay no blocks; None where there are none."""
    if not voxels.others:
        return None
    shown = ", ".join(f'"{word}"' for word in voxels.others[:8]) + (", .." if len(voxels.others) > 8 else "")
    message = f"only {' and '.join(BLOCK_WORDS)} lay blocks; left out: {shown}"
    return Diagnostic("no-block", message)


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
        if entity.word not in BLOCK_WORDS:
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
    assert entity.shape is not None
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
    flat = flatten_entity(entity, whole_cells=False)
    primitives = flat.primitives
    stamp = np.array([tree.numbers.get(id(p), -1) for p in primitives], np.int64)
    own = np.array([_own_size(p) for p in primitives], np.float64).reshape(-1, 3)
    size = _sizes(flat, own)
    low = np.trunc(flat.matrices[:, :, 3]).astype(np.int64)
    for i in np.flatnonzero(stamp >= 0).tolist():  # a pattern's box need not begin at its origin
        box = tree.patterns[int(stamp[i])].box
        rows = flat.index == i
        low[rows] += box.low
        size[rows] = np.array(box.high) - box.low
    number = np.array([asked.numbers.get(id(p), AIR) for p in primitives], np.int64)
    hollow = np.array([p.embedding.attributes.get("fill", True) is False for p in primitives], np.bool_)
    index = flat.index
    return Laid(low, low + size, number[index], hollow[index], stamp[index])


def _own_size(primitive: Entity) -> tuple[float, float, float]:
    assert primitive.shape is not None
    return primitive.shape.size


def _sizes(flat: FlatFrame, own: FloatArray) -> IntArray:
    """The cells of each instance along each axis (N, 3); raises SceneError("blocks") for the first pose that blocks
    cannot have."""
    linear, position = flat.matrices[:, :, :3], flat.matrices[:, :, 3]
    along = np.diagonal(linear, axis1=1, axis2=2)
    across = np.abs(linear * (1.0 - np.eye(3))).max(axis=(1, 2), initial=0.0)
    with np.errstate(invalid="ignore", over="ignore"):
        size = along * own[flat.index]
        whole = np.rint(size)
        far = np.asarray(~((np.abs(position) < FARTHEST).all(axis=1) & (size < FARTHEST).all(axis=1)))
        leans = across > _SLACK * np.maximum(np.abs(along).max(axis=1, initial=0.0), _SLACK)
        turned: BoolArray = ~far & (leans | (along < 0.0).any(axis=1))
        broken = ~far & (np.abs(size - whole) > np.clip(_SLACK * whole, _SLACK, 0.01)).any(axis=1)
    wrong = far | turned | broken
    if wrong.any():
        i = int(np.argmax(wrong))
        raise _misplaced(flat, i, "far" if far[i] else "turned" if turned[i] else "broken", size[i])
    return whole.astype(np.int64)


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


# --- the grid --------------------------------------------------------------------------------------------------------


def _box(laid: Laid, most_cells: int) -> tuple[IntArray, tuple[int, ...]]:
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


def _finished(cells: Cells, origin: IntArray, asked: _Asked) -> Voxels:
    """The smallest box, and a palette of what stands in it."""
    used = np.zeros(len(asked.palette), np.bool_)
    used[AIR] = True
    seen = [np.zeros(n, np.bool_) for n in cells.shape]
    slab = max(1, _SLAB // max(1, cells[:1].size))
    for start in range(0, len(cells), slab):
        part = cells[start : start + slab]
        used |= np.bincount(part.reshape(-1), minlength=len(used)) > 0
        solid = part != AIR
        seen[0][start : start + slab] = solid.any(axis=(1, 2))
        seen[1] |= solid.any(axis=(0, 2))
        seen[2] |= solid.any(axis=(0, 1))
    spans = [np.flatnonzero(axis) for axis in seen]
    low = [int(axis[0]) if len(axis) else 0 for axis in spans]
    high = [int(axis[-1]) + 1 if len(axis) else 0 for axis in spans]
    if not used.all():
        number = (np.cumsum(used) - 1).astype(np.uint32)
        for start in range(0, len(cells), slab):
            cells[start : start + slab] = number[cells[start : start + slab]]
    kept = cells[tuple(slice(a, b) for a, b in zip(low, high))]
    x, y, z = (int(a) + b for a, b in zip(origin.tolist(), low))
    chosen = np.flatnonzero(used).tolist()
    palette = tuple(asked.palette[i] for i in chosen)
    places = tuple(asked.places[i] for i in chosen)
    return Voxels(Build((x, y, z), np.ascontiguousarray(kept), palette), places, asked.others)
