"""Voxelisation: from an entity to the blocks that it lays (the paper, appendix "Minecraft Renderer").

The numbers are the reference's: a cuboid begins at its position, truncated toward zero, and has as many cells along
each axis as ``:scale`` times the pose's own scale. Cuboids are laid in the order of the program, later ones on top;
``delete-blocks`` and ``minecraft:air`` empty their cells, hollow cuboids keep what is inside them. What stands in a
cell is what the program asked for; ``settle`` makes whole block states of that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from scenelang.backends.minecraft.asked import asked_state, is_hollow, place_of
from scenelang.backends.minecraft.blocks import AIR, AIR_STATE, BlockState, Build, Cells
from scenelang.backends.minecraft.painting import IntArray, Laid, Stamp, paint
from scenelang.backends.minecraft.palettes import numbers_in, smallest_box
from scenelang.backends.minecraft.placing import cells_around, first_cells, off_cells, whole_sizes
from scenelang.backends.minecraft.repeats import FARTHEST, Folded, Sizes, Triple, folded
from scenelang.grammar.diagnostics import Diagnostic, LimitError
from scenelang.grammar.source import Span
from scenelang.interpreter.entity import Entity, descendants, primitive_count
from scenelang.interpreter.flatten import FlatFrame, flatten_entity
from scenelang.interpreter.shapes import BLOCK_WORDS

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
    message = f"only {' and '.join(BLOCK_WORDS)} lay blocks; left out: {shown}"
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
