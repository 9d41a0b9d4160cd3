"""a hexagonal board game map with terrain and an A* route between two cities"""
from __future__ import annotations
from helper import *
import heapq
import math
import random
from dataclasses import dataclass, field
from enum import IntEnum


class Terrain(IntEnum):
    WATER = 0
    PLAIN = 1
    FOREST = 2
    MOUNTAIN = 3


COLOR = {Terrain.WATER: (0.2, 0.45, 0.8), Terrain.PLAIN: (0.75, 0.8, 0.4), Terrain.FOREST: (0.15, 0.45, 0.2), Terrain.MOUNTAIN: (0.55, 0.52, 0.5)}
COST = {Terrain.PLAIN: 1, Terrain.FOREST: 2, Terrain.MOUNTAIN: 5}
DIRS = [(1, 0), (1, -1), (0, -1), (-1, 0), (-1, 1), (0, 1)]


@dataclass(order=True)
class Node:
    priority: float
    pos: tuple[int, int] = field(compare=False)


def axial_distance(a, b):
    dq, dr = a[0] - b[0], a[1] - b[1]
    return (abs(dq) + abs(dr) + abs(dq + dr)) // 2


class HexMap(dict):
    def __init__(self, radius: int, seed: int):
        super().__init__()
        rng = random.Random(seed)
        for q in range(-radius, radius + 1):
            for r in range(max(-radius, -q - radius), min(radius, -q + radius) + 1):
                self[q, r] = rng.choices(list(Terrain), weights=[1.5, 5, 3, 1.5])[0]
        self.start, self.goal = (-radius, 0), (radius, 0)
        self[self.start] = self[self.goal] = Terrain.PLAIN

    def route(self) -> list[tuple[int, int]]:
        frontier = [Node(0, self.start)]
        cost, parent = {self.start: 0}, {}
        while frontier:
            cur = heapq.heappop(frontier).pos
            if cur == self.goal:
                path = [cur]
                while path[-1] in parent:
                    path.append(parent[path[-1]])
                return path
            for dq, dr in DIRS:
                nxt = (cur[0] + dq, cur[1] + dr)
                if self.get(nxt, Terrain.WATER) is Terrain.WATER:
                    continue
                new = cost[cur] + COST[self[nxt]]
                if new < cost.get(nxt, math.inf):
                    cost[nxt], parent[nxt] = new, cur
                    heapq.heappush(frontier, Node(new + axial_distance(nxt, self.goal), nxt))
        return []


def world(q, r, y=0.0):
    return (math.sqrt(3) * (q + r / 2), y, 1.5 * r)


@register()
def tile(terrain: int, q: int, r: int) -> Shape:
    x, _, z = world(q, r)
    h = 0.2 + 0.15 * int(terrain)
    base = primitive_call('cylinder', shape_kwargs={'radius': 0.83, 'p0': (x, 0, z), 'p1': (x, h, z)}, color=COLOR[Terrain(terrain)])
    if terrain == Terrain.FOREST:
        crown = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.3}, color=(0.1, 0.5, 0.15)), translation_matrix((x, h + 0.2, z)))
        return concat_shapes(base, crown)
    if terrain == Terrain.MOUNTAIN:
        peak = concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': 0.5 - 0.1 * i, 'p0': (x, h + 0.2 * i, z), 'p1': (x, h + 0.2 * (i + 1), z)},
                                              color=(0.5, 0.48, 0.46) if i < 3 else (1, 1, 1)) for i in range(4)])
        return concat_shapes(base, peak)
    return base


@register()
def road(path: list) -> Shape:
    pts = [world(q, r, 0.8) for q, r in path]
    return concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': 0.08, 'p0': a, 'p1': b}, color=(0.85, 0.2, 0.15)) for a, b in zip(pts, pts[1:])])


@register()
def hex_board(radius: int = 4, seed: int = 5) -> Shape:
    for attempt in range(50):
        grid = HexMap(radius, seed + attempt)
        if path := grid.route():
            break
    else:
        raise RuntimeError("no solvable map")
    tiles = [library_call('tile', terrain=t, q=q, r=r) for (q, r), t in grid.items()]
    return concat_shapes(*tiles, library_call('road', path=path))
