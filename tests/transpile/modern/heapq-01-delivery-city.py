from __future__ import annotations
import heapq
import math
from dataclasses import dataclass, field
from helper import *

"""
a delivery robot's shortest way (Dijkstra) through a small city
"""

CITY = """
S.#....
..#.##.
.##.#..
....#.#
.##...E
"""


@dataclass(order=True)
class Entry:
    cost: float
    cell: tuple[int, int] = field(compare=True)
    came_from: tuple[int, int] | None = field(default=None, compare=False)


def read(text: str):
    rows = text.strip().splitlines()
    cells = {(x, z): ch for z, row in enumerate(rows) for x, ch in enumerate(row)}
    start = next(p for p, ch in cells.items() if ch == "S")
    end = next(p for p, ch in cells.items() if ch == "E")
    return cells, start, end


def dijkstra(cells, start, end):
    heap = [Entry(0.0, start)]
    parents: dict = {}
    while heap:
        entry = heapq.heappop(heap)
        if entry.cell in parents:
            continue
        parents[entry.cell] = entry.came_from
        if entry.cell == end:
            break
        x, z = entry.cell
        for dx, dz in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1)):
            nxt = (x + dx, z + dz)
            if cells.get(nxt, "#") != "#":
                heapq.heappush(heap, Entry(entry.cost + math.hypot(dx, dz), nxt, entry.cell))
    path, node = [], end
    while node is not None:
        path.append(node)
        node = parents[node]
    return path[::-1], len(parents)


@register()
def block(height: float) -> Shape:
    return transform_shape(primitive_call('cube', color=(0.5, 0.5, 0.55), shape_kwargs={'scale': (0.8, height, 0.8)}), translation_matrix((0, height / 2, 0)))


@register()
def city() -> Shape:
    cells, start, end = read(CITY)
    path, visited = dijkstra(cells, start, end)
    shapes = []
    for (x, z), ch in cells.items():
        if ch == "#":
            shapes.append(transform_shape(library_call('block', height=1 + 0.3 * ((x * 5 + z * 3) % 4)), translation_matrix((x, 0, z))))
    for a, b in zip(path, path[1:]):
        shapes.append(primitive_call('cylinder', color=(0.1, 0.8, 0.3), shape_kwargs={'radius': 0.06, 'p0': (a[0], 0.1, a[1]), 'p1': (b[0], 0.1, b[1])}))
    longest = heapq.nlargest(3, path, key=lambda p: math.dist(p, start))
    nearest = heapq.nsmallest(2, cells, key=lambda p: (math.dist(p, end), p))
    for k, (x, z) in enumerate([start, *longest, *nearest]):
        shapes.append(transform_shape(primitive_call('sphere', color=(0.9, 0.2 * k, 0.1), shape_kwargs={'radius': 0.15}), translation_matrix((x, 0.4, z))))
    ground = primitive_call('cube', color=(0.3, 0.3, 0.3), shape_kwargs={'scale': (7.5, 0.1, 5.5 + 0.01 * visited)})
    return concat_shapes(transform_shape(ground, translation_matrix((3, -0.05, 2))), *shapes)
