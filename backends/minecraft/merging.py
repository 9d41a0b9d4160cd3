"""Greedy merging: the cells of a grid as few cuboids of one number each.

Cells become runs along z, runs become sheets along y, sheets become cuboids along x, and the same in other orders of
the axes; the order that leaves the fewest cuboids is taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import AIR, Cells

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
