from __future__ import annotations
import heapq
import numpy as np
from typing import Iterable, NamedTuple
from helper import *

"""
a warehouse robot plans with A* between random shelves
"""


class Step(NamedTuple):
    row: int
    col: int

    def distance(self, other: Step) -> int:
        return abs(self.row - other.row) + abs(self.col - other.col)

    def around(self) -> Iterable[Step]:
        for dr, dc in ((0, 1), (1, 0), (0, -1), (-1, 0)):
            yield Step(self.row + dr, self.col + dc)


class NoPath(Exception):
    pass


def make_floor(rows: int, cols: int, density: float) -> np.ndarray:
    floor = np.random.random((rows, cols)) < density
    floor[0, 0] = floor[-1, -1] = False
    floor[rows // 2, :] = False
    return floor


def astar(blocked: np.ndarray, start: Step, goal: Step) -> list[Step]:
    frontier: list[tuple[int, int, Step]] = [(start.distance(goal), 0, start)]
    cost = {start: 0}
    parent: dict[Step, Step] = {}
    while frontier:
        _, so_far, here = heapq.heappop(frontier)
        if here == goal:
            path = [here]
            while here in parent:
                here = parent[here]
                path.append(here)
            return path[::-1]
        for nxt in here.around():
            if not (0 <= nxt.row < blocked.shape[0] and 0 <= nxt.col < blocked.shape[1]) or blocked[nxt]:
                continue
            if (new := so_far + 1) < cost.get(nxt, 10 ** 6):
                cost[nxt] = new
                parent[nxt] = here
                heapq.heappush(frontier, (new + nxt.distance(goal), new, nxt))
    raise NoPath(f"{start} -> {goal} after {len(cost)} cells")


@register()
def rack() -> Shape:
    levels = loop(2, lambda i: transform_shape(primitive_call('cube', color=(0.8, 0.5, 0.2), shape_kwargs={'scale': (0.8, 0.3, 0.8)}), translation_matrix((0, 0.2 + 0.5 * i, 0))))
    post = primitive_call('cylinder', color=(0.3, 0.3, 0.5), shape_kwargs={'radius': 0.05, 'p0': (0.4, 0, 0.4), 'p1': (0.4, 1, 0.4)})
    return concat_shapes(levels, post)


@register()
def warehouse() -> Shape:
    attempts = 0
    while True:
        attempts += 1
        floor = make_floor(9, 11, 0.3)
        try:
            path = astar(floor, Step(0, 0), Step(8, 10))
            break
        except NoPath as problem:
            print(problem)
    shapes = [transform_shape(library_call('rack'), translation_matrix((c, 0, r))) for r, c in np.argwhere(floor)]
    for a, b in zip(path, path[1:]):
        shapes.append(primitive_call('cylinder', color=(0.1, 0.7, 0.9), shape_kwargs={'radius': 0.06, 'p0': (a.col, 0.05, a.row), 'p1': (b.col, 0.05, b.row)}))
    turns = sum((b.row - a.row, b.col - a.col) != (c.row - b.row, c.col - b.col) for a, b, c in zip(path, path[1:], path[2:]))
    robot = concat_shapes(primitive_call('cube', color=(0.9, 0.9, 0.2), shape_kwargs={'scale': (0.5, 0.3, 0.5)}), primitive_call('cylinder', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0, 0.1 * turns + 0.2, 0)}))
    middle = path[len(path) // 2]
    tries = loop(attempts, lambda i: transform_shape(primitive_call('sphere', color=(0.9, 0.1, 0.1), shape_kwargs={'radius': 0.15}), translation_matrix((0.4 * i, 1, -1))))
    return concat_shapes(*shapes, transform_shape(robot, translation_matrix((middle.col, 0.2, middle.row))), tries)
