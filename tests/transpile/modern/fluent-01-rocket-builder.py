from __future__ import annotations
from helper import *

"""
rockets assembled with a fluent builder
"""


class RocketBuilder:
    def __init__(self) -> None:
        self._parts: list = []
        self._height = 0.0
        self._radius = 0.4
        self._color = (0.9, 0.9, 0.92)

    def paint(self, r: float, g: float, b: float) -> RocketBuilder:
        self._color = (r, g, b)
        return self

    def width(self, radius: float) -> RocketBuilder:
        self._radius = radius
        return self

    def stage(self, length: float, /, *, taper: float = 1.0) -> RocketBuilder:
        top = self._height + length
        self._parts.append(primitive_call('cylinder', color=self._color, shape_kwargs={'radius': self._radius, 'p0': (0, self._height, 0), 'p1': (0, top, 0)}))
        self._height = top
        self._radius *= taper
        return self

    def fins(self, count: int = 4) -> RocketBuilder:
        r, y = self._radius, self._height
        for i in range(count):
            fin = primitive_call('cube', color=(0.8, 0.15, 0.1), shape_kwargs={'scale': (0.5, 0.6, 0.05)})
            fin = transform_shape(fin, translation_matrix((r + 0.2, y + 0.3, 0)))
            self._parts.append(transform_shape(fin, rotation_matrix(2 * math.pi * i / count, (0, 1, 0), (0, 0, 0))))
        return self

    def booster(self, count: int, length: float) -> RocketBuilder:
        reach = self._radius + 0.2
        for i in range(count):
            a = 2 * math.pi * i / count
            x, z = reach * math.cos(a), reach * math.sin(a)
            self._parts.append(primitive_call('cylinder', color=(0.85, 0.6, 0.2), shape_kwargs={'radius': 0.15, 'p0': (x, 0, z), 'p1': (x, length, z)}))
        return self

    def nose(self) -> RocketBuilder:
        cone = transform_shape(primitive_call('sphere', color=self._color, shape_kwargs={'radius': self._radius}), scale_matrix((1, 2, 1), (0, 0, 0)))
        self._parts.append(transform_shape(cone, translation_matrix((0, self._height, 0))))
        return self

    def repeat(self, n: int, step) -> RocketBuilder:
        for i in range(n):
            step(self, i)
        return self

    def build(self) -> Shape:
        return concat_shapes(*self._parts)


@register("small rocket")
def small() -> Shape:
    return RocketBuilder().fins(3).stage(2).paint(0.2, 0.3, 0.8).nose().build()


@register("heavy rocket")
def heavy(boosters: int = 4) -> Shape:
    return (
        RocketBuilder()
        .width(0.6)
        .booster(boosters, 1.8)
        .stage(2.5, taper=0.8)
        .repeat(3, lambda b, i: b.paint(0.3 + 0.2 * i, 0.3, 0.3).stage(0.3, taper=0.95))
        .paint(0.95, 0.95, 0.95)
        .stage(1.5, taper=0.7)
        .nose()
        .build()
    )


@register("launch site")
def launch_site() -> Shape:
    pad = primitive_call('cube', color=(0.45, 0.45, 0.45), shape_kwargs={'scale': (9, 0.2, 4)})
    rockets = [library_call('small'), library_call('heavy'), library_call('heavy', boosters=6)]
    return concat_shapes(transform_shape(pad, translation_matrix((3, -0.1, 0))), *[transform_shape(r, translation_matrix((3 * k, 0, 0))) for k, r in enumerate(rockets)])
