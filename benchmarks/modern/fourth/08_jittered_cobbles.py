"""
a cobbled square with a fountain and random jitter
"""
from helper import *
import math
import random
from functools import partial, cached_property


def jitter(value, amount, rng=random):
    return value + rng.uniform(-amount, amount)


class Square:
    def __init__(self, size: int, spacing: float):
        self.size = size
        self.spacing = spacing

    @cached_property
    def extent(self) -> float:
        return (self.size - 1) * self.spacing / 2

    def cells(self):
        for i in range(self.size):
            for j in range(self.size):
                x, z = i * self.spacing - self.extent, j * self.spacing - self.extent
                if math.hypot(x, z) < 1.6:
                    continue
                yield x, z


@register()
def cobble(w: float, d: float, shade: float) -> Shape:
    return primitive_call('cube', color=(shade, shade * 0.97, shade * 0.92), shape_kwargs={'scale': (w, 0.2, d)})


@register()
def fountain(tiers: int = 3) -> Shape:
    parts = []
    y, r = 0.0, 1.4
    while tiers > 0:
        parts.append(primitive_call('cylinder', color=(0.7, 0.7, 0.72), shape_kwargs={'radius': r, 'p0': (0, y, 0), 'p1': (0, y + 0.25, 0)}))
        parts.append(primitive_call('cylinder', color=(0.3, 0.5, 0.9), shape_kwargs={'radius': r * 0.9, 'p0': (0, y + 0.25, 0), 'p1': (0, y + 0.28, 0)}))
        y += 0.7
        r *= 0.6
        tiers -= 1
    parts.append(primitive_call('cylinder', color=(0.7, 0.7, 0.72), shape_kwargs={'radius': 0.12, 'p0': (0, 0, 0), 'p1': (0, y, 0)}))
    return concat_shapes(*parts)


@register()
def town_square() -> Shape:
    wobble = partial(jitter, amount=0.04)
    stones = []
    for x, z in Square(12, 0.6).cells():
        size = 0.5
        shade = 0.45 + random.random() * 0.2
        stone = library_call('cobble', w=wobble(size), d=wobble(size), shade=shade)
        turn = rotation_matrix(random.gauss(0, 0.05), (0, 1, 0), (0, 0, 0))
        stones.append(transform_shape(transform_shape(stone, turn), translation_matrix((wobble(x), -0.1 + random.uniform(0, 0.03), wobble(z)))))
    return concat_shapes(*stones, library_call('fountain'))
