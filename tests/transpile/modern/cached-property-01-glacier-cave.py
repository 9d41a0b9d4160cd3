from __future__ import annotations
from functools import cached_property
import math
from helper import *

"""
ice cave: stalactites with lazily computed geometry
"""


class Stalactite:
    evaluations = 0

    def __init__(self, index: int, length: float) -> None:
        self.index = index
        self.length = length

    @cached_property
    def position(self) -> tuple[float, float]:
        Stalactite.evaluations += 1
        angle = self.index * math.pi * (3 - math.sqrt(5))
        r = 0.5 * math.sqrt(self.index)
        return r * math.cos(angle), r * math.sin(angle)

    @cached_property
    def segments(self) -> list[tuple[float, float, float]]:
        n = max(2, math.ceil(self.length * 2))
        return [(0.2 * (1 - i / n), -self.length * i / n, -self.length * (i + 1) / n) for i in range(n)]

    @property
    def tip(self) -> float:
        return self.segments[-1][2]

    def draw(self) -> Shape:
        x, z = self.position
        parts = [primitive_call('cylinder', color=(0.7, 0.85, 0.95), shape_kwargs={'radius': r, 'p0': (x, a, z), 'p1': (x, b, z)}) for r, a, b in self.segments]
        return concat_shapes(*parts)


class Cave:
    def __init__(self, n: int, height: float = 4.0):
        self.height = height
        self.ice = [Stalactite(i, 0.5 + 1.5 * abs(math.sin(1.7 * i))) for i in range(1, n + 1)]

    @cached_property
    def longest(self) -> Stalactite:
        return min(self.ice, key=lambda s: s.tip)

    @cached_property
    def radius(self) -> float:
        return max(math.hypot(*s.position) for s in self.ice) + 0.5


@register("ice ceiling")
def ceiling(cave: Cave) -> Shape:
    slab = primitive_call('cylinder', color=(0.8, 0.9, 1.0), shape_kwargs={'radius': cave.radius, 'p0': (0, 0, 0), 'p1': (0, 0.3, 0)})
    return concat_shapes(slab, *[s.draw() for s in cave.ice])


@register("ice cave")
def ice_cave() -> Shape:
    cave = Cave(14)
    roof = transform_shape(library_call('ice ceiling', cave=cave), translation_matrix((0, cave.height, 0)))
    x, z = cave.longest.position
    puddle = primitive_call('cylinder', color=(0.3, 0.5, 0.7), shape_kwargs={'radius': 0.4, 'p0': (x, 0, z), 'p1': (x, 0.03, z)})
    # overwriting a cached value changes only later reads
    cave.radius = cave.radius + 0.5
    floor = primitive_call('cylinder', color=(0.6, 0.7, 0.75), shape_kwargs={'radius': cave.radius, 'p0': (0, -0.2, 0), 'p1': (0, 0, 0)})
    del cave.longest
    again = cave.longest
    drops = loop(Stalactite.evaluations, lambda i: transform_shape(
        primitive_call('sphere', color=(0.5, 0.7, 0.9), shape_kwargs={'radius': 0.05}), translation_matrix((again.position[0], 0.2 * i, again.position[1]))))
    return concat_shapes(roof, floor, puddle, drops)
