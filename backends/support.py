"""The greatest and least value of a linear form over the points of a mesh, which is how far it reaches in a direction.

Points that are near one another stand in a block with a box of its own, so that only blocks that may hold the furthest
point are opened. The answer is that of all points, to the last bit; it needs no convex hull, whose computation can fail
or take long, and no more memory than the points.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_CELLS = 1023  # along each axis, by which points are sorted
_LEAST = 64  # points of a block


class PointSupport:
    """The reach of ``points`` (N, 3), at least one, which are copied."""

    __slots__ = ("_count", "_half", "_middle", "_points")

    def __init__(self, points: FloatArray) -> None:
        low, high = points.min(axis=0), points.max(axis=0)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            cell = np.nan_to_num((points - low) / (high - low) * _CELLS, nan=0.0)
        ordered = points[np.argsort(_interleaved(np.clip(cell, 0, _CELLS).astype(np.int64)), kind="stable")]
        is_new = np.ones(len(ordered), np.bool_)
        is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
        kept = ordered[is_new]
        self._count = len(kept)
        size = max(_LEAST, int(np.sqrt(self._count)))
        blocks = -(-self._count // size)
        padded = np.concatenate([kept, np.repeat(kept[-1:], blocks * size - self._count, axis=0)])
        self._points = np.ascontiguousarray(padded.reshape(blocks, size, 3).transpose(0, 2, 1))  # (B, 3, size)
        lows, highs = self._points.min(axis=2), self._points.max(axis=2)
        self._middle, self._half = 0.5 * lows + 0.5 * highs, 0.5 * highs - 0.5 * lows

    def __len__(self) -> int:
        return self._count

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        """The least and the greatest ``a x + b y + c z``."""
        with np.errstate(all="ignore"):  # numbers too large are told by what comes out
            return self._interval(np.array((a, b, c)))

    def _interval(self, direction: FloatArray) -> tuple[float, float]:
        reach = self._half @ np.abs(direction)
        middle = self._middle @ direction
        slack = 1e-14 * (np.abs(self._middle) @ np.abs(direction) + reach)  # what rounding may take off a bound
        return -self._greatest(-direction, reach + slack - middle), self._greatest(direction, reach + slack + middle)

    def _greatest(self, direction: FloatArray, bounds: FloatArray) -> float:
        """The greatest value, where ``bounds`` are those of each block."""
        best = self._most(int(np.argmax(bounds)), direction)
        others = np.flatnonzero(bounds > best)
        return max(best, self._most(others, direction)) if len(others) else best

    def _most(self, blocks: int | npt.NDArray[np.int64], direction: FloatArray) -> float:
        chosen = self._points[blocks]
        x, y, z = chosen[..., 0, :], chosen[..., 1, :], chosen[..., 2, :]
        return float((direction[0] * x + direction[1] * y + direction[2] * z).max())


def _interleaved(cells: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """The bits of three numbers of ten bits each, (N, 3), in turn: Morton's order."""
    spread = cells.copy()
    for shift, mask in ((16, 0x30000FF), (8, 0x300F00F), (4, 0x30C30C3), (2, 0x9249249)):
        spread = (spread | (spread << shift)) & mask
    return np.asarray(spread[:, 0] | (spread[:, 1] << 1) | (spread[:, 2] << 2), np.int64)
