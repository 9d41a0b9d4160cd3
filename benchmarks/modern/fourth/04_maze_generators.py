"""
a maze carved by depth first search with the solution marked
"""
from helper import *
import random
from collections import deque
from itertools import islice, product
from typing import Generator

Cell = tuple[int, int]
DIRS: dict[str, Cell] = {'N': (0, -1), 'S': (0, 1), 'E': (1, 0), 'W': (-1, 0)}
OPPOSITE = {'N': 'S', 'S': 'N', 'E': 'W', 'W': 'E'}


class Maze:
    def __init__(self, width: int, height: int, seed: int = 0):
        self.width, self.height = width, height
        self.links: dict[Cell, set[str]] = {c: set() for c in product(range(width), range(height))}
        self._rng = random.Random(seed)
        for _ in self._carve():
            pass

    def __contains__(self, cell: Cell) -> bool:
        return cell in self.links

    def __len__(self) -> int:
        return self.width * self.height

    def _carve(self) -> Generator[Cell, None, None]:
        stack = [(0, 0)]
        visited = {(0, 0)}
        while stack:
            x, y = stack[-1]
            options = [(d, (x + dx, y + dy)) for d, (dx, dy) in DIRS.items() if (x + dx, y + dy) in self and (x + dx, y + dy) not in visited]
            if not options:
                stack.pop()
                continue
            d, nxt = self._rng.choice(options)
            self.links[(x, y)].add(d)
            self.links[nxt].add(OPPOSITE[d])
            visited.add(nxt)
            stack.append(nxt)
            yield nxt

    def solve(self, start: Cell, goal: Cell) -> list[Cell]:
        parent: dict[Cell, Cell | None] = {start: None}
        queue = deque([start])
        while queue:
            cell = queue.popleft()
            if cell == goal:
                break
            for d in sorted(self.links[cell]):
                dx, dy = DIRS[d]
                nxt = (cell[0] + dx, cell[1] + dy)
                if nxt not in parent:
                    parent[nxt] = cell
                    queue.append(nxt)
        path = []
        cell: Cell | None = goal
        while cell is not None:
            path.append(cell)
            cell = parent[cell]
        return path[::-1]

    def walls(self) -> Generator[tuple[float, float, bool], None, None]:
        for (x, y), open_sides in self.links.items():
            if 'E' not in open_sides:
                yield x + 0.5, y, True
            if 'S' not in open_sides:
                yield x, y + 0.5, False
        for y in range(self.height):
            yield -0.5, y, True
        for x in range(self.width):
            yield x, -0.5, False


@register()
def hedge(vertical: bool, height: float = 0.8) -> Shape:
    size = (0.12, height, 1.12) if vertical else (1.12, height, 0.12)
    return transform_shape(primitive_call('cube', color=(0.15, 0.45, 0.2), shape_kwargs={'scale': size}), translation_matrix((0, height / 2, 0)))


@register()
def maze_garden() -> Shape:
    maze = Maze(9, 7, seed=21)
    hedges = [transform_shape(library_call('hedge', vertical=v), translation_matrix((x, 0, y))) for x, y, v in maze.walls()]
    path = maze.solve((0, 0), (8, 6))
    marks = []
    for i, (x, y) in enumerate(islice(path, 0, None, 2)):
        marks.append(transform_shape(primitive_call('sphere', color=(0.9, 0.8 - 0.02 * i, 0.2), shape_kwargs={'radius': 0.15}), translation_matrix((x, 0.15, y))))
    ground = transform_shape(primitive_call('cube', color=(0.7, 0.65, 0.5), shape_kwargs={'scale': (maze.width, 0.1, maze.height)}),
                             translation_matrix(((maze.width - 1) / 2, -0.05, (maze.height - 1) / 2)))
    return concat_shapes(ground, *hedges, *marks)
