"""Laying cuboids of blocks into a grid of cells, one after another, later ones on top of earlier ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import Cells

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
