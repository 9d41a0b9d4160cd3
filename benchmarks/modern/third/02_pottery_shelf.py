"""
shelves of thrown pots whose outlines are bezier curves
"""
from helper import *
import math
from dataclasses import dataclass
from functools import reduce, partial
from typing import NamedTuple, Self


class Pt(NamedTuple):
    x: float
    y: float

    def __add__(self, other):
        return Pt(self.x + other.x, self.y + other.y)

    def __mul__(self, k: float):
        return Pt(self.x * k, self.y * k)

    def lerp(self, other, t: float):
        return self * (1 - t) + other * t


@dataclass(frozen=True)
class Bezier:
    points: tuple[Pt, ...]

    def __call__(self, t: float) -> Pt:
        pts = list(self.points)
        while len(pts) > 1:
            pts = [a.lerp(b, t) for a, b in zip(pts, pts[1:])]
        return pts[0]

    def sample(self, n: int) -> list[Pt]:
        return [self(i / n) for i in range(n + 1)]

    @classmethod
    def of(cls, *pairs: tuple[float, float]) -> Self:
        return cls(tuple(Pt(*p) for p in pairs))


PROFILES = {
    'vase': Bezier.of((0.18, 0), (0.55, 0.2), (0.35, 0.7), (0.12, 0.75), (0.22, 1.0)),
    'bowl': Bezier.of((0.15, 0), (0.5, 0.05), (0.55, 0.4)),
    'bottle': Bezier.of((0.25, 0), (0.3, 0.6), (0.02, 0.6), (0.08, 1.1)),
}
GLAZES = {'vase': (0.2, 0.4, 0.6), 'bowl': (0.85, 0.75, 0.55), 'bottle': (0.25, 0.45, 0.3)}


@register()
def pot(kind: str = 'vase', size: float = 1.0, slices: int = 12) -> Shape:
    curve = PROFILES[kind].sample(slices)
    layers = []
    for lower, upper in zip(curve, curve[1:]):
        r = (lower.x + upper.x) / 2 * size
        layers.append(primitive_call('cylinder', color=GLAZES[kind], shape_kwargs={'radius': r, 'p0': (0, lower.y * size, 0), 'p1': (0, upper.y * size, 0)}))
    return concat_shapes(*layers)


@register()
def board(length: float = 4.0) -> Shape:
    plank = primitive_call('cube', color=(0.5, 0.35, 0.2), shape_kwargs={'scale': (length, 0.08, 0.9)})
    return transform_shape(plank, translation_matrix((0, -0.04, 0)))


def place(shape: Shape, *, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Shape:
    return transform_shape(shape, translation_matrix((x, y, z)))


@register()
def shelf(kinds: tuple = ('vase', 'bowl', 'bottle'), pitch: float = 1.2, size: float = 0.9) -> Shape:
    n = len(kinds)
    row = [place(library_call('pot', kind=k, size=size), x=(i - (n - 1) / 2) * pitch) for i, k in enumerate(kinds)]
    return concat_shapes(library_call('board', length=n * pitch + 0.4), *row)


@register()
def pottery_shelf() -> Shape:
    rows = [('vase', 'bowl', 'vase'), ('bottle', 'bottle', 'bowl', 'bottle'), ('bowl', 'vase')]
    lift = partial(place, z=0.0)
    shelves = [lift(library_call('shelf', kinds=r), y=1.5 * i) for i, r in enumerate(rows)]
    sides = [place(primitive_call('cube', color=(0.42, 0.28, 0.16), shape_kwargs={'scale': (0.1, 4.6, 0.9)}), x=s * 2.7, y=2.2) for s in (-1, 1)]
    return reduce(lambda a, b: concat_shapes(a, b), shelves + sides)
