"""Blocks in a grid: what stands in each cell of a build.

Cells are whole numbers: x to the right (the game's east), y up, z as in the program (the game's south). A cell ``(x, y,
z)`` is the unit cube from that corner on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
import numpy.typing as npt

Cells = npt.NDArray[np.uint32]
AIR = 0  # the number of what is empty in every palette
SIDES = ("north", "east", "south", "west")  # clockwise from above: opposite is 2 on, to the left 3 on


@dataclass(frozen=True, slots=True, order=True)
class BlockState:
    """A block with its properties, such as ``minecraft:oak_stairs`` with ``(("facing", "north"), ("half", "top"))``,
    sorted by name."""

    name: str
    properties: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        """As the game writes it: ``minecraft:oak_stairs[facing=north,half=top]``."""
        shown = ",".join(f"{name}={value}" for name, value in self.properties)
        return f"{self.name}[{shown}]" if shown else self.name


AIR_STATE = BlockState("minecraft:air")
# What stands for nothing, wherever it is asked for or read: it is laid as air.
NOTHING = frozenset({"minecraft:air", "minecraft:cave_air", "minecraft:void_air", "minecraft:structure_void"})


@dataclass(frozen=True, slots=True, eq=False)
class Build:
    """Blocks in a box of cells: ``cells[x, y, z]`` is the number in ``palette`` of what stands at ``origin + (x, y,
    z)``. ``palette[0]`` is air; every other entry is used and stands there once."""

    origin: tuple[int, int, int]
    cells: Cells  # (X, Y, Z)
    palette: tuple[BlockState, ...]

    @property
    def size(self) -> tuple[int, int, int]:
        """Cells along x, y and z."""
        x, y, z = self.cells.shape
        return x, y, z


# Greedy merging: the cells of a grid as few cuboids of one number each.
#
# Cells become runs along z, runs become sheets along y, sheets become cuboids along x, and the same in other orders of
# the axes; the order that leaves the fewest cuboids is taken.


IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

_SLAB = 1 << 22  # cells that are looked at together
_MANY = 4_000_000  # runs: with more, only one order of the axes is tried


@dataclass(frozen=True, slots=True, eq=False)
class Cuboids:
    """Cuboids of cells that do not overlap: ``low <= c < low + size`` has ``number`` everywhere. Sorted by y, z, x of
    ``low``: from the ground up."""

    low: IntArray  # (N, 3)
    size: IntArray  # (N, 3)
    number: IntArray  # (N,)

    def __len__(self) -> int:
        return len(self.number)


def merged(cells: Cells, along: BoolArray | None = None) -> Cuboids:
    """All cells (X, Y, Z) that are not AIR as cuboids, in cells from the grid's corner.

    ``along[n]`` (3,) says along which axes cells of number ``n`` may be joined; all of them where it is None.
    """
    found = [_merged(cells, (2, 1, 0), along)]
    if len(found[0]) > 1 and np.count_nonzero(cells) <= _MANY:
        found += [_merged(cells, order, along) for order in permutations(range(3), 3) if order != (2, 1, 0)]
    best = min(found, key=len)
    order = np.lexsort((best.low[:, 0], best.low[:, 2], best.low[:, 1]))
    return _rows(best, order)


def _merged(cells: Cells, order: tuple[int, ...], along: BoolArray | None) -> Cuboids:
    first, second, third = order
    boxes = _runs(cells, first, along)
    return _joined(_joined(boxes, second, along), third, along)


def _runs(cells: Cells, axis: int, along: BoolArray | None) -> Cuboids:
    """The stretches of equal numbers along ``axis``."""
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
    """Boxes of equal sides that stand behind each other along ``axis`` as one."""
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


# Builds made whole: each state once in the palette, only those that stand somewhere, in the smallest box.


# cells that are looked at together


def unified(origin: tuple[int, int, int], cells: Cells, states: Sequence[BlockState]) -> Build:
    """The build whose cell (x, y, z) holds ``states[cells[x, y, z]]``, with each state once in its palette, and only
    those that stand somewhere."""
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
    """``build`` in the smallest box that holds its blocks, a box of no cells where there are none."""
    box = smallest_box(build.cells)
    if not box[0].stop:
        return Build((0, 0, 0), np.zeros((0, 0, 0), np.uint32), (AIR_STATE,))
    x, y, z = (a + side.start for a, side in zip(build.origin, box))
    return Build((x, y, z), np.ascontiguousarray(build.cells[box]), build.palette)


def numbers_in(cells: Cells, count: int) -> npt.NDArray[np.bool_]:
    """Which of ``count`` numbers stand in some cell."""
    used = np.zeros(count, np.bool_)
    slab = _slab(cells)
    for start in range(0, len(cells), slab):
        used |= np.bincount(cells[start : start + slab].reshape(-1), minlength=count) > 0
    return used


def smallest_box(cells: Cells) -> tuple[slice, slice, slice]:
    """The smallest box that holds every cell with a block; empty slices from 0 on where there is none."""
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
