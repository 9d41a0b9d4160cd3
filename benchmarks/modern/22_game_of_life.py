"""Conway's Game of Life as a tower: each generation is one layer of cubes"""
from helper import *
import numpy as np

GLIDER_GUN_SEED = """
.##.....
#.#..#..
..#.##..
....#...
.##.....
.#.#....
..#..##.
......#.
"""


def parse(text: str) -> np.ndarray:
    return np.array([[ch == '#' for ch in row] for row in text.split()], dtype=np.uint8)


def evolve(grid: np.ndarray):
    """Infinite generator of toroidal Life generations."""
    while True:
        yield grid
        neighbors = sum(
            np.roll(grid, (dy, dx), axis=(0, 1))
            for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dy, dx) != (0, 0)
        )
        grid = ((neighbors == 3) | ((grid == 1) & (neighbors == 2))).astype(np.uint8)


@register()
def cell(age: float, size: float = 0.9) -> Shape:
    color = (0.1 + 0.8 * age, 0.8 - 0.5 * age, 0.9 - 0.6 * age)
    return primitive_call('cube', shape_kwargs={'scale': (size,) * 3}, color=color)


@register()
def layer(grid: np.ndarray, age: float) -> Shape:
    rows, cols = np.nonzero(grid)
    h, w = grid.shape
    shapes = [
        transform_shape(library_call('cell', age=age), translation_matrix((c - w / 2, 0, r - h / 2)))
        for r, c in zip(rows, cols)
    ]
    return concat_shapes(*shapes) if shapes else []


@register()
def life_tower(generations: int = 12) -> Shape:
    out = []
    for g, grid in enumerate(evolve(parse(GLIDER_GUN_SEED))):
        if g >= generations or not grid.any():
            break
        floor = library_call('layer', grid=grid, age=g / generations)
        out.append(transform_shape(floor, translation_matrix((0, g, 0))))
    plate = primitive_call('cube', shape_kwargs={'scale': (10, 0.3, 10)}, color=(0.2, 0.2, 0.2))
    return concat_shapes(transform_shape(plate, translation_matrix((-0.5, -0.8, -0.5))), *out)
