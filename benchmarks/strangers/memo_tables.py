# Collatz lengths and paths in a grid, both by tables of known results, as in any course on recursion; 2026-11-29.
from __future__ import annotations


def longest(n: int) -> int:
    known = {1: 1}

    def steps(k: int) -> int:
        if k not in known:
            known[k] = 1 + steps(k // 2 if k % 2 == 0 else 3 * k + 1)
        return known[k]

    return max(range(1, n), key=steps)


def paths(n: int) -> int:
    known: dict[tuple[int, int], int] = {}

    def ways(x: int, y: int) -> int:
        if x == 0 or y == 0:
            return 1
        if (x, y) not in known:
            known[x, y] = (ways(x - 1, y) + ways(x, y - 1)) % 1000003
        return known[x, y]

    return ways(n, n)


def run(limit: int = 4000, side: int = 60) -> int:
    return longest(limit) + paths(side)
