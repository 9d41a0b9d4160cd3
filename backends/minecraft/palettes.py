"""Builds made whole: each state once in the palette, only those that stand somewhere, in the smallest box."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import AIR, AIR_STATE, BlockState, Build, Cells

_SLAB = 1 << 22  # cells that are looked at together


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
