from __future__ import annotations
from dataclasses import dataclass
from typing import Iterator, Union
from helper import *

"""
a crystal lattice of two kinds of ions, built with vector arithmetic
"""

Number = Union[int, float]


@dataclass(frozen=True)
class Vec:
    x: float
    y: float
    z: float

    def __add__(self, o: Vec) -> Vec:
        return Vec(self.x + o.x, self.y + o.y, self.z + o.z)

    def __sub__(self, o: Vec) -> Vec:
        return self + (-o)

    def __neg__(self) -> Vec:
        return -1 * self

    def __mul__(self, k: Number) -> Vec:
        if not isinstance(k, (int, float)):
            return NotImplemented
        return Vec(self.x * k, self.y * k, self.z * k)

    __rmul__ = __mul__

    def __truediv__(self, k: Number) -> Vec:
        return self * (1 / k)

    def __matmul__(self, o: Vec) -> float:
        return self.x * o.x + self.y * o.y + self.z * o.z

    def __abs__(self) -> float:
        return (self @ self) ** 0.5

    def __iter__(self) -> Iterator[float]:
        yield from (self.x, self.y, self.z)


X, Y, Z = Vec(1, 0, 0), Vec(0, 1, 0), Vec(0, 0, 1)


@register()
def ion(kind: int) -> Shape:
    return primitive_call('sphere', color=[(0.4, 0.8, 0.3), (0.6, 0.3, 0.8)][kind], shape_kwargs={'radius': 0.3 if kind else 0.18})


@register()
def bond(start: Vec, end: Vec) -> Shape:
    gap = (end - start) / abs(end - start) * 0.2
    return primitive_call('cylinder', color=(0.7, 0.7, 0.7), shape_kwargs={'radius': 0.04, 'p0': tuple(start + gap), 'p1': tuple(end - gap)})


@register()
def lattice(n: int = 3) -> Shape:
    center = (X + Y + Z) * (n - 1) / 2
    sites = [(i + j + k, i * X + j * Y + k * Z - center) for i in range(n) for j in range(n) for k in range(n)]
    shapes = [transform_shape(library_call('ion', kind=s % 2), translation_matrix(tuple(p))) for s, p in sites]
    for a in range(len(sites)):
        for b in range(a):
            if abs(abs(sites[a][1] - sites[b][1]) - 1) < 1e-9:
                shapes.append(library_call('bond', start=sites[b][1], end=sites[a][1]))
    return concat_shapes(*shapes)
