"""
a skyline whose towers follow different strategies
"""
from helper import *
import math
import random
from collections.abc import Callable
from typing import Protocol

Builder = Callable[[float, float, int], Shape]
BUILDERS: dict[str, tuple[Builder, float]] = {}


def style(name: str, weight: float = 1.0):
    def decorate(fn: Builder) -> Builder:
        BUILDERS[name] = (fn, weight)
        return fn
    return decorate


def block(w, h, d, color, y=0.0):
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (w, h, d)}), translation_matrix((0, y + h / 2, 0)))


@style('slab', weight=3)
def slab(width, height, seed):
    shade = 0.5 + (seed % 5) * 0.08
    return block(width, height, width * 0.6, (shade, shade, shade + 0.05))


@style('stepped', weight=2)
def stepped(width, height, seed):
    tiers = 3 + seed % 2
    parts, y = [], 0.0
    for i in range(tiers):
        h = height * (0.5 if i == 0 else 0.5 / (tiers - 1))
        w = width * (1 - 0.22 * i)
        parts.append(block(w, h, w, (0.75, 0.68, 0.55), y))
        y += h
    return concat_shapes(*parts)


@style('twisted')
def twisted(width, height, seed):
    n = max(4, round(height / 0.5))
    return loop(n, lambda i: transform_shape(block(width * 0.7, height / n, width * 0.7, (0.3, 0.5, 0.7), i * height / n), rotation_matrix(i * math.radians(6), (0, 1, 0), (0, 0, 0))))


@style('round')
def round_tower(width, height, seed):
    parts = [primitive_call('cylinder', color=(0.6, 0.7, 0.75), shape_kwargs={'radius': width * 0.4, 'p0': (0, 0, 0), 'p1': (0, height, 0)})]
    if seed % 2 == 0:
        parts += [primitive_call('cylinder', color=(0.8, 0.1, 0.1), shape_kwargs={'radius': 0.03, 'p0': (0, height, 0), 'p1': (0, height * 1.3, 0)})]
    return concat_shapes(*parts)


class Height(Protocol):
    def __call__(self, x: int, z: int) -> float: ...


def downtown(center: tuple[float, float], peak: float) -> Height:
    cx, cz = center

    def height(x: int, z: int) -> float:
        return 1 + peak * math.exp(-((x - cx) ** 2 + (z - cz) ** 2) / 12)
    return height


@register()
def building(kind: str, width: float, height: float, seed: int = 0) -> Shape:
    builder, _ = BUILDERS[kind]
    return builder(width, height, seed)


@register()
def skyline(n: int = 7) -> Shape:
    random.seed(99)
    height = downtown((n / 2, n / 2), 6.0)
    names = list(BUILDERS)
    weights = [w for _, w in BUILDERS.values()]
    shapes = []
    for x in range(n):
        for z in range(n):
            kind, = random.choices(names, weights=weights)
            h = height(x, z) * random.uniform(0.8, 1.2)
            tower = library_call('building', kind=kind, width=0.8, height=h, seed=random.randrange(10))
            shapes.append(transform_shape(tower, translation_matrix((x * 1.2, 0, z * 1.2))))
    return concat_shapes(*shapes)
