"""Pairs of boxes that overlap, found by sweeping along one axis."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from scenelang.backends.solids import FloatArray

IntArray = npt.NDArray[np.int64]


def neighbours(low: FloatArray, high: FloatArray, margin: float, most: int) -> tuple[IntArray, bool]:
    """Numbers (M, 2) of the boxes that come within ``margin`` of one another, the smaller number first, and whether
    these are all: there are at most ``most``."""
    low, high = low - margin / 2.0, high + margin / 2.0
    axis = int(np.argmax(np.var(low + high, axis=0))) if len(low) else 0
    order = np.argsort(low[:, axis], kind="stable")
    starts, ends = low[order], high[order]
    last = np.searchsorted(starts[:, axis], ends[:, axis], side="right")
    found: list[IntArray] = []
    total = 0
    for i in range(len(order)):
        others = np.arange(i + 1, last[i])
        if len(others):
            near = ((starts[others] <= ends[i]) & (ends[others] >= starts[i])).all(axis=1)
            chosen = order[others[near]]
            found.append(np.stack([np.full(len(chosen), order[i]), chosen], axis=1))
            total += len(chosen)
            if total > most:
                break
    pairs = np.concatenate(found) if found else np.zeros((0, 2), np.int64)
    return np.sort(pairs, axis=1)[:most], total <= most
