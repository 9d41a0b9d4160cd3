# Solutions of the n queens by sets of bits (Richards, "Backtracking algorithms in MCPL", 1997); 2026-11-29.
from __future__ import annotations


def run(queens: int = 9) -> int:
    full = (1 << queens) - 1

    def place(columns: int, left: int, right: int) -> int:
        if columns == full:
            return 1
        free = full & ~(columns | left | right)
        total = 0
        while free:
            bit = free & -free
            free -= bit
            total += place(columns | bit, (left | bit) << 1, (right | bit) >> 1)
        return total

    return place(0, 0, 0)
