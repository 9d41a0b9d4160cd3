"""
a fitted kitchen laid out by a builder with a fluent interface
"""
from helper import *
from typing import Self
import math

WHITE, STEEL, STONE, OAK = (0.95, 0.95, 0.93), (0.7, 0.72, 0.75), (0.25, 0.25, 0.27), (0.65, 0.48, 0.3)


def cuboid(w, h, d, color, at=(0, 0, 0)):
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (w, h, d)}), translation_matrix(at))


@register()
def cabinet(width: float = 0.6, drawers: int = 0) -> Shape:
    body = cuboid(width, 0.85, 0.6, WHITE, (0, 0.425, 0))
    fronts = []
    if drawers:
        gap = 0.8 / drawers
        for i in range(drawers):
            fronts.append(cuboid(width * 0.94, gap * 0.9, 0.02, OAK, (0, 0.05 + gap * (i + 0.5), 0.31)))
            fronts.append(cuboid(width * 0.3, 0.02, 0.03, STEEL, (0, 0.05 + gap * (i + 0.5), 0.33)))
    else:
        fronts = [cuboid(width * 0.94, 0.78, 0.02, OAK, (0, 0.45, 0.31)), cuboid(0.02, 0.2, 0.03, STEEL, (width * 0.35, 0.6, 0.33))]
    return concat_shapes(body, *fronts)


@register()
def hob(width: float = 0.6) -> Shape:
    base = library_call('cabinet', width=width, drawers=2)
    plates = [primitive_call('cylinder', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': r, 'p0': (x, 0.89, z), 'p1': (x, 0.9, z)})
              for x, z, r in [(-0.14, -0.13, 0.1), (0.14, -0.13, 0.08), (-0.14, 0.13, 0.08), (0.14, 0.13, 0.1)]]
    return concat_shapes(base, *plates)


@register()
def sink(width: float = 0.8) -> Shape:
    tap = [primitive_call('cylinder', color=STEEL, shape_kwargs={'radius': 0.02, 'p0': (0, 0.88, -0.2), 'p1': (0, 1.2, -0.2)}),
           primitive_call('cylinder', color=STEEL, shape_kwargs={'radius': 0.02, 'p0': (0, 1.2, -0.2), 'p1': (0, 1.15, 0)})]
    return concat_shapes(library_call('cabinet', width=width), cuboid(width * 0.6, 0.02, 0.35, STEEL, (0, 0.9, 0)), *tap)


class Run:
    """A row of units along one wall."""

    def __init__(self, angle: float = 0.0):
        self._angle = angle
        self._cursor = 0.0
        self._units: list[tuple[float, float, str, dict]] = []

    def unit(self, name: str, width: float = 0.6, **options) -> Self:
        self._units.append((self._cursor + width / 2, width, name, options))
        self._cursor += width
        return self

    def gap(self, width: float) -> Self:
        self._cursor += width
        return self

    @property
    def length(self) -> float:
        return self._cursor

    def build(self, height: float = 0.87) -> Shape:
        shapes = []
        for center, width, name, options in self._units:
            shapes.append(transform_shape(library_call(name, width=width, **options), translation_matrix((center, 0, 0))))
        shapes.append(cuboid(self.length, 0.03, 0.62, STONE, (self.length / 2, height, 0)))
        return transform_shape(concat_shapes(*shapes), rotation_matrix(self._angle, (0, 1, 0), (0, 0, 0)))


@register()
def kitchen() -> Shape:
    long_run = (
        Run()
        .unit('cabinet', 0.6, drawers=3)
        .unit('hob')
        .unit('cabinet', 0.5)
        .gap(0.05)
        .unit('sink', width=0.8)
        .unit('cabinet', 0.4, drawers=4)
    )
    short_run = Run(-math.pi / 2).unit('cabinet').unit('cabinet', 0.9, drawers=2)
    tall = cuboid(0.7, 2.0, 0.65, STEEL, (long_run.length + 0.4, 1.0, 0))
    return concat_shapes(long_run.build(), transform_shape(short_run.build(height=0.87), translation_matrix((-0.35, 0, 0.35))), tall)
