"""Grids of blocks, and their decomposition into cuboids.

Cells have integer coordinates: x to the right (the game's east), y up, z as in the program (the game's south). A cell
``(x, y, z)`` is the unit cube with this minimum corner.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
import numpy.typing as npt

Cells = npt.NDArray[np.uint32]
AIR = 0  # index of air in every palette
SIDES = ("north", "east", "south", "west")  # clockwise from above: +2 is opposite, +3 is left


@dataclass(frozen=True, slots=True, order=True)
class BlockState:
    """A block with its properties, sorted by name.

    For example ``minecraft:oak_stairs`` with ``(("facing", "north"), ("half", "top"))``.
    """

    name: str
    properties: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        """Return the game's notation: ``minecraft:oak_stairs[facing=north,half=top]``."""
        shown = ",".join(f"{name}={value}" for name, value in self.properties)
        return f"{self.name}[{shown}]" if shown else self.name


AIR_STATE = BlockState("minecraft:air")
# Blocks without content; when requested or read from a file they are treated as air.
NOTHING = frozenset({"minecraft:air", "minecraft:cave_air", "minecraft:void_air", "minecraft:structure_void"})


@dataclass(frozen=True, slots=True, eq=False)
class Build:
    """Blocks in a box of cells.

    ``cells[x, y, z]`` is the index in ``palette`` of the block at ``origin + (x, y, z)``. ``palette[0]`` is air; every
    other entry is unique and used.
    """

    origin: tuple[int, int, int]
    cells: Cells  # (X, Y, Z)
    palette: tuple[BlockState, ...]

    @property
    def size(self) -> tuple[int, int, int]:
        """Number of cells along x, y and z."""
        x, y, z = self.cells.shape
        return x, y, z


# Greedy merging: the cells of a grid as few uniform cuboids. Cells are merged into runs along z, runs into sheets along
# y, sheets into cuboids along x; other orders of the axes are tried too, and the result with the fewest cuboids is
# used.


IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

_SLAB = 1 << 22  # cells processed per batch
_MAX_FOR_ALL_ORDERS = 4_000_000  # cells; above this, only one order of the axes is tried


@dataclass(frozen=True, slots=True, eq=False)
class Cuboids:
    """Disjoint uniform cuboids of cells: the cells ``low <= c < low + size`` are all ``number``.

    Sorted by y, z, x of ``low``: from the ground up.
    """

    low: IntArray  # (N, 3)
    size: IntArray  # (N, 3)
    number: IntArray  # (N,)

    def __len__(self) -> int:
        return len(self.number)


def merged(cells: Cells, along: BoolArray | None = None) -> Cuboids:
    """Return all cells (X, Y, Z) that are not AIR as cuboids, in cells from the grid's corner.

    ``along[n]`` (3,) selects the axes along which cells with index ``n`` may be merged; by default all.
    """
    found = [_merged(cells, (2, 1, 0), along)]
    if len(found[0]) > 1 and np.count_nonzero(cells) <= _MAX_FOR_ALL_ORDERS:
        found += [_merged(cells, order, along) for order in permutations(range(3), 3) if order != (2, 1, 0)]
    best = min(found, key=len)
    order = np.lexsort((best.low[:, 0], best.low[:, 2], best.low[:, 1]))
    return _rows(best, order)


def _merged(cells: Cells, order: tuple[int, ...], along: BoolArray | None) -> Cuboids:
    first, second, third = order
    boxes = _runs(cells, first, along)
    return _joined(_joined(boxes, second, along), third, along)


def _runs(cells: Cells, axis: int, along: BoolArray | None) -> Cuboids:
    """Return the runs of equal indices along ``axis``."""
    lines = np.moveaxis(cells, axis, -1)
    slab = max(1, _SLAB // max(1, lines[:1].size))
    lows, ends, numbers = [], [], []
    for start in range(0, len(lines), slab):
        part = lines[start : start + slab]
        begins = part != AIR
        same = part[..., 1:] == part[..., :-1]
        if along is not None:
            same &= along[part[..., 1:], axis]
        begins[..., 1:] &= ~same
        stops = part != AIR
        stops[..., :-1] &= ~same
        at = np.argwhere(begins)
        lows.append(at + np.array([start, 0, 0]))
        ends.append(np.nonzero(stops)[2] + 1)
        numbers.append(part[tuple(at.T)])
    rotated, end = np.concatenate(lows or [np.zeros((0, 3), np.int64)]), np.concatenate(ends or [np.zeros(0, np.int64)])
    low = np.empty_like(rotated)
    others = [a for a in range(3) if a != axis]
    low[:, others], low[:, axis] = rotated[:, :2], rotated[:, 2]
    size = np.ones_like(low)
    size[:, axis] = end - rotated[:, 2]
    return Cuboids(low, size, np.concatenate(numbers or [np.zeros(0, np.uint32)]).astype(np.int64))


def _joined(boxes: Cuboids, axis: int, along: BoolArray | None) -> Cuboids:
    """Merge boxes with equal cross-sections that are adjacent along ``axis``."""
    if len(boxes) < 2:
        return boxes
    b, c = (a for a in range(3) if a != axis)
    sides = (boxes.number, boxes.low[:, b], boxes.low[:, c], boxes.size[:, b], boxes.size[:, c])
    order = np.lexsort((boxes.low[:, axis], *sides))
    rows = _rows(boxes, order)
    same = rows.low[1:, axis] == rows.low[:-1, axis] + rows.size[:-1, axis]
    for side in sides:
        same &= side[order][1:] == side[order][:-1]
    if along is not None:
        same &= along[rows.number[1:], axis]
    begins = np.flatnonzero(np.concatenate(([True], ~same)))
    size = rows.size[begins]
    size[:, axis] = np.add.reduceat(rows.size[:, axis], begins)
    return Cuboids(rows.low[begins], size, rows.number[begins])


def _rows(boxes: Cuboids, rows: IntArray) -> Cuboids:
    return Cuboids(boxes.low[rows], boxes.size[rows], boxes.number[rows])


# Normalisation of builds: a palette of distinct, used states, and the smallest bounding box.


def unified(origin: tuple[int, int, int], cells: Cells, states: Sequence[BlockState]) -> Build:
    """Return the build whose cell (x, y, z) is ``states[cells[x, y, z]]``, with a palette of distinct, used states."""
    used = numbers_in(cells, len(states))
    palette: dict[BlockState, int] = {AIR_STATE: AIR}
    number = np.zeros(len(states), np.uint32)
    for i in np.flatnonzero(used).tolist():
        number[i] = palette.setdefault(states[i], len(palette))
    fresh = np.empty_like(cells)
    slab = _slab(cells)
    for start in range(0, len(cells), slab):
        fresh[start : start + slab] = number[cells[start : start + slab]]
    return Build(origin, fresh, tuple(palette))


def trimmed(build: Build) -> Build:
    """Crop ``build`` to the smallest box that contains its blocks; empty if there are none."""
    box = smallest_box(build.cells)
    if not box[0].stop:
        return Build((0, 0, 0), np.zeros((0, 0, 0), np.uint32), (AIR_STATE,))
    x, y, z = (a + side.start for a, side in zip(build.origin, box))
    return Build((x, y, z), np.ascontiguousarray(build.cells[box]), build.palette)


def numbers_in(cells: Cells, count: int) -> npt.NDArray[np.bool_]:
    """Return the mask of the ``count`` indices that occur in some cell."""
    used = np.zeros(count, np.bool_)
    slab = _slab(cells)
    for start in range(0, len(cells), slab):
        used |= np.bincount(cells[start : start + slab].reshape(-1), minlength=count) > 0
    return used


def smallest_box(cells: Cells) -> tuple[slice, slice, slice]:
    """Return the smallest box that contains every block; empty slices at 0 if there are none."""
    seen = [np.zeros(n, np.bool_) for n in cells.shape]
    slab = _slab(cells)
    for start in range(0, len(cells), slab):
        solid = cells[start : start + slab] != AIR
        seen[0][start : start + slab] = solid.any(axis=(1, 2))
        seen[1] |= solid.any(axis=(0, 2))
        seen[2] |= solid.any(axis=(0, 1))
    x, y, z = (np.flatnonzero(axis) for axis in seen)
    return _span(x), _span(y), _span(z)


def _span(places: npt.NDArray[np.int64]) -> slice:
    return slice(int(places[0]), int(places[-1]) + 1) if len(places) else slice(0, 0)


def _slab(cells: Cells) -> int:
    return max(1, _SLAB // max(1, cells[:1].size))
