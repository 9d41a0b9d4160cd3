# Conway's game of life on an endless plane, from the R pentomino (Gardner 1970); 2026-11-29.
from __future__ import annotations

Cells = set[tuple[int, int]]


def step(cells: Cells) -> Cells:
    counts: dict[tuple[int, int], int] = {}
    for x, y in cells:
        for dx in (-1, 0, 1):
            for dy in (-1, 0, 1):
                if dx or dy:
                    key = (x + dx, y + dy)
                    counts[key] = counts.get(key, 0) + 1
    return {cell for cell, n in counts.items() if n == 3 or (n == 2 and cell in cells)}


def run(generations: int = 40) -> int:
    cells = {(1, 0), (2, 0), (0, 1), (1, 1), (1, 2)}
    for _ in range(generations):
        cells = step(cells)
    return len(cells)
