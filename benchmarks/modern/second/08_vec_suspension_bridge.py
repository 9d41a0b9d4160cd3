"""
a suspension bridge over a strait, with cars on it
"""
from __future__ import annotations
from helper import *
import math
import random
from dataclasses import dataclass, astuple
from typing import Callable


@dataclass(frozen=True, slots=True)
class Vec:
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    def __add__(self, o: Vec) -> Vec:
        return Vec(self.x + o.x, self.y + o.y, self.z + o.z)

    def __sub__(self, o: Vec) -> Vec:
        return self + -o

    def __neg__(self) -> Vec:
        return -1 * self

    def __mul__(self, k: float) -> Vec:
        return Vec(self.x * k, self.y * k, self.z * k)

    __rmul__ = __mul__

    def __matmul__(self, o: Vec) -> float:
        return self.x * o.x + self.y * o.y + self.z * o.z

    def __abs__(self) -> float:
        return math.sqrt(self @ self)

    def __iter__(self):
        return iter((self.x, self.y, self.z))


def rod(a: Vec, b: Vec, r: float, color) -> Shape:
    return primitive_call('cylinder', {'radius': r, 'p0': tuple(a), 'p1': tuple(b)}, color=color)


def catenary(span: float, sag: float) -> Callable[[float], float]:
    """Bisection on the catenary parameter so the cable sags exactly `sag`."""
    lo, hi = 0.1, 1e4
    f = lambda a: a * (math.cosh(span / 2 / a) - 1) - sag
    lo = span / 40
    for _ in range(80):
        mid = (lo + hi) / 2
        if f(mid) > 0:
            lo = mid
        else:
            hi = mid
    a = (lo + hi) / 2
    return lambda x: a * (math.cosh(x / a) - 1)


RED = (0.75, 0.22, 0.15)
STEEL = (0.55, 0.57, 0.6)


@register()
def tower(height: float = 6.0, gap: float = 1.4) -> Shape:
    legs = [rod(Vec(0, -1, s * gap / 2), Vec(0, height, s * gap / 2), 0.14, RED) for s in (-1, 1)]
    braces = [transform_shape(primitive_call('cube', {'scale': (0.2, 0.25, gap)}, color=RED), translation_matrix((0, y, 0)))
              for y in (height * f for f in (0.3, 0.65, 0.97))]
    return concat_shapes(*legs, *braces)


@register()
def main_cable(span: float = 12.0, sag: float = 3.5, top: float = 6.0, z: float = 0.7, n: int = 24) -> Shape:
    curve = catenary(span, sag)
    xs = [-span / 2 + span * i / n for i in range(n + 1)]
    pts = [Vec(x, top - sag + curve(x), z) for x in xs]
    assert abs(pts[0] - Vec(-span / 2, top, z)) < 1e-6
    cable = [rod(a, b, 0.06, STEEL) for a, b in zip(pts, pts[1:])]
    hangers = [rod(p, Vec(p.x, 2.0, p.z), 0.02, STEEL) for p in pts[1:-1] if p.y > 2.05]
    stays = [rod(Vec(s * span / 2, top, z), Vec(s * span, 1.9, z), 0.06, STEEL) for s in (-1, 1)]
    return concat_shapes(*cable, *hangers, *stays)


@register()
def car(color: tuple[float, float, float] = (0.2, 0.4, 0.8)) -> Shape:
    body = primitive_call('cube', {'scale': (0.5, 0.14, 0.24)}, color=color)
    cab = transform_shape(primitive_call('cube', {'scale': (0.26, 0.12, 0.22)}, color=(0.7, 0.85, 0.9)), translation_matrix((0, 0.13, 0)))
    wheels = [rod(Vec(x, -0.08, -0.13), Vec(x, -0.08, 0.13), 0.06, (0.1, 0.1, 0.1)) for x in (-0.16, 0.16)]
    return concat_shapes(body, cab, *wheels)


@register()
def traffic(n: int = 12, length: float = 22.0, seed: int = 5) -> Shape:
    rng = random.Random(seed)
    lanes = {-1: [], 1: []}
    for i in range(n):
        side = rng.choice((-1, 1))
        x = -length / 2 + length * (i + rng.random() * 0.5) / n
        lanes[side].append(Vec(x, 2.2, side * 0.32))
    out = [transform_shape(library_call('car', color=tuple(rng.uniform(0.2, 0.9) for _ in range(3))), translation_matrix(tuple(p)))
           for lane in lanes.values() for p in lane]
    return concat_shapes(*out)


@register()
def suspension_bridge(span: float = 12.0) -> Shape:
    deck = transform_shape(primitive_call('cube', {'scale': (span * 2, 0.15, 1.5)}, color=(0.3, 0.3, 0.32)), translation_matrix((0, 2, 0)))
    towers = loop(2, lambda i: transform_shape(library_call('tower'), translation_matrix(((2 * i - 1) * span / 2, 0, 0))))
    cables = [library_call('main_cable', span=span, z=z) for z in (-0.7, 0.7)]
    sea = transform_shape(primitive_call('cube', {'scale': (span * 2, 0.2, 10)}, color=(0.2, 0.42, 0.58)), translation_matrix((0, -0.6, 0)))
    return concat_shapes(sea, deck, towers, *cables, library_call('traffic'))
