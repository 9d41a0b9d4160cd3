"""
a cave from a cellular automaton on a numpy grid
"""
from helper import *
import numpy as np

rng = np.random.default_rng(17)
SIZE = (14, 18)


def neighbours(grid: np.ndarray) -> np.ndarray:
    padded = np.pad(grid, 1, constant_values=1)
    return sum(
        np.roll(np.roll(padded, dy, axis=0), dx, axis=1)[1:-1, 1:-1]
        for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dy, dx) != (0, 0)
    )


def cave(steps: int = 4) -> np.ndarray:
    grid = (rng.random(SIZE) < 0.42).astype(int)
    for _ in range(steps):
        n = neighbours(grid)
        grid = np.where(n >= 5, 1, np.where(n <= 2, 0, grid))
    return grid


def largest_room(grid: np.ndarray) -> set[tuple[int, int]]:
    seen: set[tuple[int, int]] = set()
    best: set[tuple[int, int]] = set()
    for start in map(tuple, np.argwhere(grid == 0).tolist()):
        if start in seen:
            continue
        room, todo = set(), [start]
        while todo:
            cell = todo.pop()
            if cell in room:
                continue
            room.add(cell)
            y, x = cell
            todo += [(a, b) for a, b in ((y + 1, x), (y - 1, x), (y, x + 1), (y, x - 1))
                     if 0 <= a < SIZE[0] and 0 <= b < SIZE[1] and grid[a, b] == 0 and (a, b) not in room]
        seen |= room
        best = max(best, room, key=len)
    return best


@register()
def rock(height: float) -> Shape:
    return transform_shape(primitive_call('cube', color=(0.35, 0.32, 0.3), shape_kwargs={'scale': (1, height, 1)}), translation_matrix((0, height / 2, 0)))


@register()
def cavern() -> Shape:
    grid = cave()
    room = largest_room(grid)
    shapes = []
    for y, row in enumerate(grid):
        for x, value in enumerate(row):
            if value:
                walls = int(grid[max(y - 1, 0):y + 2, max(x - 1, 0):x + 2].sum())
                shapes.append(transform_shape(library_call('rock', height=0.5 + 0.2 * walls), translation_matrix((x, 0, y))))
            else:
                tint = (0.3, 0.5, 0.6) if (y, x) in room else (0.5, 0.45, 0.35)
                shapes.append(transform_shape(primitive_call('cube', color=tint, shape_kwargs={'scale': (1, 0.1, 1)}), translation_matrix((x, 0, y))))
    return concat_shapes(*shapes)
