"""
a spiral staircase around a stone column with lanterns on every fifth step
"""
from helper import *
import cmath
import math
from dataclasses import dataclass
from operator import attrgetter
from typing import Protocol, runtime_checkable

import numpy as np


@runtime_checkable
class Placeable(Protocol):
    def shape(self) -> Shape: ...
    def pose(self) -> np.ndarray: ...


@dataclass(frozen=True)
class OnHelix:
    index: int
    radius: float
    rise: float
    turn: float

    @property
    def polar(self) -> complex:
        return cmath.rect(self.radius, self.index * self.turn)

    @property
    def height(self) -> float:
        return self.index * self.rise

    def pose(self) -> np.ndarray:
        z = self.polar
        spin = rotation_matrix(-self.index * self.turn, (0, 1, 0), (0, 0, 0))
        return translation_matrix((z.real, self.height, z.imag)) @ spin


@dataclass(frozen=True)
class Step(OnHelix):
    width: float = 1.3

    def shape(self) -> Shape:
        return library_call('tread', width=self.width)


@dataclass(frozen=True)
class Lantern(OnHelix):
    glow: tuple[float, float, float] = (1.0, 0.85, 0.45)

    def shape(self) -> Shape:
        return library_call('lantern', glow=self.glow)


def place(item: Placeable) -> Shape:
    assert isinstance(item, Placeable)
    return transform_shape(item.shape(), item.pose())


@register()
def tread(width: float = 1.3, depth: float = 0.45, thickness: float = 0.08) -> Shape:
    return primitive_call('cube', {'scale': (width, thickness, depth)}, color=(0.6, 0.45, 0.3))


@register()
def lantern(glow: tuple = (1.0, 0.85, 0.45)) -> Shape:
    post = primitive_call('cylinder', {'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0, 0.9, 0)}, color=(0.15, 0.15, 0.15))
    light = transform_shape(primitive_call('cube', {'scale': (0.16, 0.22, 0.16)}, color=glow), translation_matrix((0, 1.0, 0)))
    cap = transform_shape(primitive_call('cube', {'scale': (0.22, 0.04, 0.22)}, color=(0.15, 0.15, 0.15)), translation_matrix((0, 1.13, 0)))
    return concat_shapes(post, light, cap)


@register()
def handrail(steps: int = 30, radius: float = 1.6, rise: float = 0.2, turn: float = math.pi / 10) -> Shape:
    stations = [OnHelix(i, radius, rise, turn) for i in range(steps)]
    lift = 0.9
    point = lambda s: (s.polar.real, s.height + lift, s.polar.imag)
    rails = [primitive_call('cylinder', {'radius': 0.035, 'p0': point(a), 'p1': point(b)}, color=(0.2, 0.2, 0.22))
             for a, b in zip(stations[:-1], stations[1:])]
    posts = [primitive_call('cylinder', {'radius': 0.02, 'p0': (*(s.polar.real, s.height), s.polar.imag), 'p1': point(s)}, color=(0.2, 0.2, 0.22))
             for s in stations]
    return sum(rails + posts, start=[])


@register()
def column(height: float = 6.0, radius: float = 0.35, drums: int = 10) -> Shape:
    def drum(i: int) -> Shape:
        gray = 0.62 if i & 1 else 0.56
        y0, y1 = (height * k / drums for k in (i, i + 1))
        return primitive_call('cylinder', {'radius': radius * (1.0 + 0.03 * (i & 1)), 'p0': (0, y0, 0), 'p1': (0, y1, 0)}, color=(gray, gray, gray * 0.95))
    return loop(drums, drum)


@register()
def spiral_staircase(steps: int = 30, rise: float = 0.2) -> Shape:
    turn = math.pi / 10
    items: list[OnHelix] = [Step(i, 0.95, rise, turn) for i in range(steps)]
    items += [Lantern(i, 1.55, rise, turn) for i in range(0, steps, 5)]
    items.sort(key=attrgetter('height', 'radius'))
    col = library_call('column', height=steps * rise + 1)
    rail = library_call('handrail', steps=steps, radius=1.6, rise=rise, turn=turn)
    landing = transform_shape(primitive_call('cylinder', {'radius': 2.4, 'p0': (0, -0.2, 0), 'p1': (0, -0.05, 0)}, color=(0.45, 0.43, 0.4)), identity_matrix())
    return concat_shapes(landing, col, rail, *map(place, items))
