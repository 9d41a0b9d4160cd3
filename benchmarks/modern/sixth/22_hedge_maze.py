"""a hedge maze garden with the way to the fountain marked by stepping stones"""
from helper import *
import math
import random
from collections import deque

random.seed(7)

Cell = tuple[int, int]
SIDES = {'N': (0, -1), 'S': (0, 1), 'W': (-1, 0), 'E': (1, 0)}
OPPOSITE = dict(N='S', S='N', W='E', E='W')


class Maze:
    """A perfect maze, carved by a depth-first search."""

    def __init__(self, columns: int, rows: int):
        self.columns, self.rows = columns, rows
        self.open: dict[Cell, set[str]] = {(x, z): set() for x in range(columns) for z in range(rows)}
        self._carve((0, 0))

    def _carve(self, start: Cell) -> None:
        seen, stack = {start}, [start]
        while stack:
            x, z = stack[-1]
            choices = [(side, (x + dx, z + dz)) for side, (dx, dz) in SIDES.items() if (x + dx, z + dz) in self.open and (x + dx, z + dz) not in seen]
            if not choices:
                stack.pop()
                continue
            side, cell = random.choice(choices)
            self.open[(x, z)].add(side)
            self.open[cell].add(OPPOSITE[side])
            seen.add(cell)
            stack.append(cell)

    def neighbors(self, cell: Cell):
        for side in sorted(self.open[cell]):
            dx, dz = SIDES[side]
            yield cell[0] + dx, cell[1] + dz

    def route(self, start: Cell, goal: Cell) -> list[Cell]:
        """Breadth-first search; the cells from start to goal."""
        came: dict[Cell, Cell | None] = {start: None}
        queue = deque([start])
        while queue and goal not in came:
            cell = queue.popleft()
            for other in self.neighbors(cell):
                if other not in came:
                    came[other] = cell
                    queue.append(other)
        path, step = [], goal
        while step is not None:
            path.append(step)
            step = came[step]
        return path[::-1]

    def walls(self):
        """Yield (x, z, is_along_x) for each closed side, once."""
        for (x, z), sides in self.open.items():
            if 'N' not in sides:
                yield x, z - 0.5, True
            if 'W' not in sides:
                yield x - 0.5, z, False
            if z == self.rows - 1 and 'S' not in sides:
                yield x, z + 0.5, True
            if x == self.columns - 1 and 'E' not in sides:
                yield x + 0.5, z, False


maze = Maze(9, 7)


@register("one straight piece of hedge")
def hedge(along_x: bool = True, height: float = 0.6) -> Shape:
    size = (1.12, height, 0.2) if along_x else (0.2, height, 1.12)
    return primitive_call('cube', shape_kwargs={'scale': size}, color=(0.13, 0.38, 0.16))


@register("all hedges of the maze")
def hedges(height: float = 0.6) -> Shape:
    return concat_shapes(*(
        transform_shape(library_call('hedge', along_x=along, height=height), translation_matrix((x, height / 2, z)))
        for x, z, along in maze.walls()))


@register("flat stones on the way")
def stepping_stones() -> Shape:
    path = maze.route((0, 0), (maze.columns // 2, maze.rows // 2))
    stones = []
    for (x0, z0), (x1, z1) in zip(path, path[1:]):
        for t in (0.0, 0.5):
            x, z = x0 + (x1 - x0) * t, z0 + (z1 - z0) * t
            stones.append(primitive_call('cylinder', shape_kwargs={'radius': 0.13, 'p0': (x, 0, z), 'p1': (x, 0.04, z)}, color=(0.7, 0.68, 0.64)))
    return concat_shapes(*stones)


@register()
def fountain(jets: int = 6) -> Shape:
    basin = primitive_call('cylinder', shape_kwargs={'radius': 0.34, 'p0': (0, 0, 0), 'p1': (0, 0.2, 0)}, color=(0.8, 0.78, 0.74))
    water = primitive_call('cylinder', shape_kwargs={'radius': 0.29, 'p0': (0, 0.1, 0), 'p1': (0, 0.21, 0)}, color=(0.3, 0.6, 0.85))
    drops = [
        transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.025}, color=(0.8, 0.92, 1)),
                        translation_matrix((0.08 * k * math.cos(a), 0.5 + 0.12 * k - 0.06 * k * k, 0.08 * k * math.sin(a))))
        for a in (math.tau * j / jets for j in range(jets)) for k in range(4)
    ]
    return concat_shapes(basin, water, *drops)


@register()
def hedge_maze() -> Shape:
    w, d = maze.columns, maze.rows
    gravel = transform_shape(primitive_call('cube', shape_kwargs={'scale': (w + 1, 0.1, d + 1)}, color=(0.85, 0.8, 0.68)),
                             translation_matrix(((w - 1) / 2, -0.05, (d - 1) / 2)))
    goal = transform_shape(library_call('fountain'), translation_matrix((w // 2, 0, d // 2)))
    return concat_shapes(gravel, library_call('hedges'), library_call('stepping_stones'), goal)
