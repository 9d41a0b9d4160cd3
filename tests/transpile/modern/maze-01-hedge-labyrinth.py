from __future__ import annotations
import random
from collections import deque
from dataclasses import dataclass, field
from helper import *

"""
a hedge maze carved at random, with the shortest way as lanterns
"""

Cell = tuple[int, int]
DIRECTIONS: dict[str, Cell] = {"N": (0, -1), "E": (1, 0), "S": (0, 1), "W": (-1, 0)}


@dataclass
class Maze:
    width: int
    height: int
    links: dict[Cell, set[Cell]] = field(default_factory=dict)

    @classmethod
    def carved(cls, width: int, height: int) -> Maze:
        maze = cls(width, height)
        start = (0, 0)
        stack, seen = [start], {start}
        while stack:
            cell = stack[-1]
            options = [n for n in maze.neighbors(cell) if n not in seen]
            if not options:
                stack.pop()
                continue
            nxt = random.choice(options)
            maze.link(cell, nxt)
            seen.add(nxt)
            stack.append(nxt)
        return maze

    def neighbors(self, cell: Cell) -> list[Cell]:
        x, y = cell
        return [(x + dx, y + dy) for dx, dy in DIRECTIONS.values() if 0 <= x + dx < self.width and 0 <= y + dy < self.height]

    def link(self, a: Cell, b: Cell) -> None:
        self.links.setdefault(a, set()).add(b)
        self.links.setdefault(b, set()).add(a)

    def solve(self, start: Cell, goal: Cell) -> list[Cell]:
        queue, came = deque([start]), {start: None}
        while queue and goal not in came:
            cell = queue.popleft()
            for n in sorted(self.links.get(cell, ())):
                if n not in came:
                    came[n] = cell
                    queue.append(n)
        path = [goal]
        while (previous := came[path[-1]]) is not None:
            path.append(previous)
        return path[::-1]


@register()
def hedge(length: float, along_x: bool) -> Shape:
    scale = (length, 0.6, 0.15) if along_x else (0.15, 0.6, length)
    return primitive_call('cube', color=(0.15, random.uniform(0.35, 0.45), 0.15), shape_kwargs={'scale': scale})


@register()
def labyrinth(size: int = 8) -> Shape:
    maze = Maze.carved(size, size)
    shapes = []
    for y in range(size):
        for x in range(size):
            here = maze.links[x, y]
            if x + 1 < size and (x + 1, y) not in here:
                shapes.append(transform_shape(library_call('hedge', length=1.15, along_x=False), translation_matrix((x + 0.5, 0.3, y))))
            if y + 1 < size and (x, y + 1) not in here:
                shapes.append(transform_shape(library_call('hedge', length=1.15, along_x=True), translation_matrix((x, 0.3, y + 0.5))))
    m = (size - 1) / 2
    for sign in (-1, 1):
        shapes.append(transform_shape(library_call('hedge', length=size, along_x=True), translation_matrix((m, 0.3, m + sign * size / 2))))
        shapes.append(transform_shape(library_call('hedge', length=size, along_x=False), translation_matrix((m + sign * size / 2, 0.3, m))))
    path = maze.solve((0, 0), (size - 1, size - 1))
    lanterns = [transform_shape(primitive_call('sphere', color=(1, 0.8, 0.3), shape_kwargs={'radius': 0.08 + 0.04 * (i % 2)}), translation_matrix((x, 0.2, y))) for i, (x, y) in enumerate(path)]
    return concat_shapes(*shapes, *lanterns)
