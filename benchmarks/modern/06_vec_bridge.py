"""a red suspension bridge over a river"""
from __future__ import annotations
from helper import *
from dataclasses import dataclass
import math


@dataclass(frozen=True, slots=True)
class Vec:
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    def __add__(self, o: Vec) -> Vec:
        return Vec(self.x + o.x, self.y + o.y, self.z + o.z)

    def __sub__(self, o: Vec) -> Vec:
        return self + (-o)

    def __neg__(self) -> Vec:
        return Vec(-self.x, -self.y, -self.z)

    def __mul__(self, k: float) -> Vec:
        return Vec(self.x * k, self.y * k, self.z * k)

    __rmul__ = __mul__

    def __abs__(self) -> float:
        return math.hypot(self.x, self.y, self.z)

    def __iter__(self):
        yield from (self.x, self.y, self.z)


RED = (0.75, 0.22, 0.15)


def rod(a: Vec, b: Vec, r: float, color=RED) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': tuple(a), 'p1': tuple(b)}, color=color)


def catenary(a: Vec, b: Vec, sag: float, n: int = 16):
    for i in range(n + 1):
        t = i / n
        yield a * (1 - t) + b * t - Vec(y=4 * sag * t * (1 - t))


@register()
def tower(x: float, height: float = 8.0, width: float = 3.0) -> Shape:
    legs = [rod(Vec(x, -3, s * width / 2), Vec(x, height, s * width / 2), 0.3) for s in (-1, 1)]
    beams = [rod(Vec(x, y, -width / 2), Vec(x, y, width / 2), 0.2) for y in (2.5, 5, height - 0.5)]
    return concat_shapes(*legs, *beams)


@register()
def cable(x0: float, x1: float, z: float, *_, top: float = 8.0, sag: float = 6.0) -> Shape:
    pts = list(catenary(Vec(x0, top, z), Vec(x1, top, z), sag))
    segs = [rod(a, b, 0.12) for a, b in zip(pts, pts[1:])]
    hangers = [rod(p, Vec(p.x, 0.2, p.z), 0.04, color=(0.6, 0.6, 0.62)) for p in pts[1:-1] if abs(p - Vec(p.x, 0.2, p.z)) > 0.1]
    return concat_shapes(*segs, *hangers)


@register()
def deck(length: float = 40.0, width: float = 3.0) -> Shape:
    road = primitive_call('cube', shape_kwargs={'scale': (length, 0.3, width)}, color=(0.25, 0.25, 0.27))
    dashes = loop(int(length // 2), lambda i: transform_shape(
        primitive_call('cube', shape_kwargs={'scale': (0.9, 0.02, 0.1)}, color=(1, 1, 0.8)),
        translation_matrix((-length / 2 + 1 + 2 * i, 0.16, 0))))
    return concat_shapes(road, dashes)


@register()
def suspension_bridge(span: float = 20.0) -> Shape:
    water = transform_shape(primitive_call('cube', shape_kwargs={'scale': (44, 0.2, 24)}, color=(0.2, 0.45, 0.7)), translation_matrix((0, -3, 0)))
    half = span / 2
    towers = [library_call('tower', x=s * half) for s in (-1, 1)]
    cables = [library_call('cable', x0=-half, x1=half, z=z) for z in (-1.5, 1.5)]
    backstays = [rod(Vec(s * half, 8, z), Vec(s * 20, 0, z), 0.12) for s in (-1, 1) for z in (-1.5, 1.5)]
    return concat_shapes(water, library_call('deck'), *towers, *cables, *backstays)
