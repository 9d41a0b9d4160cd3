# A mountain ridge and a square of terrain by displaced midpoints (Fournier, Fussell and Carpenter 1982); 2026-11-29.
from __future__ import annotations

from itertools import pairwise
from random import Random

Line = list[float]


def ridge(source: Random, left: float, right: float, amount: float, level: int) -> Line:
    if level == 0:
        return [left]
    middle = 0.5 * (left + right) + source.uniform(-amount, amount)
    first = ridge(source, left, middle, 0.55 * amount, level - 1)
    return first + ridge(source, middle, right, 0.55 * amount, level - 1)


def squares(source: Random, heights: list[Line], half: int, amount: float) -> None:
    n = len(heights) - 1
    for x in range(half, n, 2 * half):
        for y in range(half, n, 2 * half):
            corners = heights[x - half][y - half] + heights[x + half][y - half]
            corners = corners + heights[x - half][y + half] + heights[x + half][y + half]
            heights[x][y] = source.uniform(-amount, amount) + 0.25 * corners


def diamonds(source: Random, heights: list[Line], half: int, amount: float) -> None:
    n = len(heights) - 1
    for x in range(0, n + 1, half):
        for y in range(0, n + 1, half):
            if (x // half + y // half) % 2 == 1:
                near = ((x + half, y), (x - half, y), (x, y + half), (x, y - half))
                around = [heights[a][b] for a, b in near if 0 <= a <= n and 0 <= b <= n]
                heights[x][y] = source.uniform(-amount, amount) + sum(around) / len(around)


def terrain(source: Random, n: int) -> list[Line]:
    heights = [[0.0] * (n + 1) for _ in range(n + 1)]
    step, amount = n, 1.0
    while step > 1:
        step //= 2
        squares(source, heights, step, amount)
        diamonds(source, heights, step, amount)
        amount *= 0.6
    return heights


def run(levels: int = 11, side: int = 32) -> float:
    source = Random(5)
    line = ridge(source, 0.0, 1.0, 1.0, levels)
    heights = terrain(source, side)
    total = sum(abs(a - b) for a, b in pairwise(line))
    return round(total + sum(abs(heights[x + 1][y] - heights[x][y]) for x in range(side) for y in range(side)), 6)
