from __future__ import annotations
from functools import cached_property
import numpy as np
from helper import *

"""
a tower whose floors are generations of cellular automata
"""


class Elementary:
    """A one dimensional automaton with a Wolfram rule number."""

    def __init__(self, rule: int, cells: list[int]):
        self.rule, self.cells = rule, cells

    @cached_property
    def table(self) -> dict[tuple[int, int, int], int]:
        return {(n >> 2 & 1, n >> 1 & 1, n & 1): self.rule >> n & 1 for n in range(8)}

    def __iter__(self):
        row = self.cells
        while True:
            yield row
            padded = [row[-1], *row, row[0]]
            row = [self.table[triple] for triple in zip(padded, padded[1:], padded[2:])]


def life_step(grid: np.ndarray) -> np.ndarray:
    neighbors = sum(np.roll(grid, (dy, dx), axis=(0, 1)) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dy, dx) != (0, 0))
    return ((neighbors == 3) | ((grid == 1) & (neighbors == 2))).astype(int)


@register()
def block(color: tuple) -> Shape:
    return primitive_call('cube', color=color, shape_kwargs={'scale': (0.9, 0.9, 0.9)})


@register()
def facade(rule: int, width: int, height: int) -> Shape:
    start = [int(i == width // 2) for i in range(width)]
    shapes = []
    for y, row in zip(range(height), Elementary(rule, start)):
        for x, cell in enumerate(row):
            if cell:
                shapes.append(transform_shape(library_call('block', color=(0.9 - 0.05 * y, 0.4, 0.2 + 0.06 * y)), translation_matrix((x - width // 2, height - y, 0))))
    return concat_shapes(*shapes)


@register()
def life_floors(generations: int, size: int = 7) -> Shape:
    grid = np.zeros((size, size), int)
    grid[1:4, 2:5] = [[0, 1, 0], [0, 0, 1], [1, 1, 1]]
    shapes = []
    for g in range(generations):
        for z, x in zip(*np.nonzero(grid)):
            shapes.append(transform_shape(library_call('block', color=(0.2, 0.5 + 0.08 * g, 0.8)), translation_matrix((x - size // 2, g, z - size // 2))))
        grid = life_step(grid)
    return concat_shapes(*shapes)


@register()
def cellular_city() -> Shape:
    facades = [transform_shape(library_call('facade', rule=rule, width=13, height=8), translation_matrix((0, 0, 6 * k))) for k, rule in enumerate((90, 30, 110))]
    return concat_shapes(*facades, transform_shape(library_call('life_floors', generations=6), translation_matrix((14, 0, 6))))
