"""a small town street with different kinds of buildings: house, shop, church and skyscraper"""
from __future__ import annotations

from abc import ABC, abstractmethod
from itertools import accumulate, cycle
from helper import *
import math

RGB = tuple[float, float, float]


def box(w: float, h: float, d: float, color: RGB, x: float = 0, y: float = 0, z: float = 0) -> Shape:
    """A box with the middle of its underside at (x, y, z)."""
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': (w, h, d)}, color=color), translation_matrix((x, y + h / 2, z)))


class Building(ABC):
    wall: RGB = (0.8, 0.75, 0.65)
    glass: RGB = (0.55, 0.75, 0.9)
    depth: float = 2.0

    def __init__(self, width: float, floors: int, *, wall: RGB | None = None):
        self.width = width
        self.floors = floors
        if wall is not None:
            self.wall = wall

    floor_height = 0.9

    @property
    def height(self) -> float:
        return self.floors * self.floor_height

    def windows(self, columns: int = 2) -> list[Shape]:
        pitch = self.width / columns
        return [box(pitch * 0.5, self.floor_height * 0.5, 0.06, self.glass, (c + 0.5) * pitch - self.width / 2, f * self.floor_height + 0.25, self.depth / 2)
                for f in range(self.floors) for c in range(columns) if (f, c) != (0, 0)]

    def door(self) -> Shape:
        return box(0.4, 0.7, 0.08, (0.35, 0.2, 0.12), -self.width / 4, 0, self.depth / 2)

    @abstractmethod
    def roof(self) -> list[Shape]: ...

    def build(self) -> Shape:
        body = box(self.width, self.height, self.depth, self.wall)
        return concat_shapes(body, self.door(), *self.windows(), *self.roof())

    def __add__(self, extra: float) -> float:
        return self.width + extra


class House(Building):
    def roof(self) -> list[Shape]:
        layers = 6
        return [box(self.width * 1.1 * (1 - k / layers), 0.15, self.depth * 1.1, (0.65, 0.25, 0.18), y=self.height + 0.15 * k) for k in range(layers)]


class Shop(House):
    """A house whose ground floor has an awning."""
    def build(self) -> Shape:
        stripes = cycle([(0.9, 0.2, 0.2), (0.95, 0.95, 0.95)])
        pitch = self.width / 8
        awning = [box(pitch, 0.06, 0.6, color, (k + 0.5) * pitch - self.width / 2, 0.82, self.depth / 2 + 0.3) for k, color in zip(range(8), stripes)]
        return concat_shapes(super().build(), *awning)


class Church(Building):
    wall = (0.92, 0.9, 0.86)

    def roof(self) -> list[Shape]:
        top = self.height
        spire = [primitive_call('cylinder', shape_kwargs={'radius': 0.5 - 0.06 * k, 'p0': (0, top + 1.2 + 0.3 * k, 0), 'p1': (0, top + 1.5 + 0.3 * k, 0)}, color=(0.3, 0.4, 0.4))
                 for k in range(8)]
        cross = [box(0.06, 0.5, 0.06, (0.9, 0.75, 0.2), 0, top + 3.6), box(0.3, 0.06, 0.06, (0.9, 0.75, 0.2), 0, top + 3.85)]
        return [box(0.9, 1.2, 0.9, self.wall, 0, top), *spire, *cross]


class Skyscraper(Building):
    glass = (0.35, 0.5, 0.65)

    def windows(self, columns: int = 4) -> list[Shape]:
        return super().windows(columns)

    def roof(self) -> list[Shape]:
        mast = primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (0, self.height, 0), 'p1': (0, self.height + 1.5, 0)}, color=(0.7, 0.7, 0.7))
        return [box(self.width * 0.6, 0.4, self.depth * 0.6, (0.5, 0.5, 0.52), y=self.height), mast]


STREET: list[Building] = [
    House(2.0, 2), Shop(2.4, 2, wall=(0.85, 0.6, 0.4)), Church(2.6, 2),
    Skyscraper(2.2, 8, wall=(0.6, 0.65, 0.7)), House(1.8, 3, wall=(0.6, 0.7, 0.55)), Shop(2.2, 1),
]


@register("a lamp at the kerb")
def lamp(height: float = 1.4) -> Shape:
    pole = primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=(0.2, 0.2, 0.2))
    return concat_shapes(pole, transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=(1, 0.95, 0.7)), translation_matrix((0, height, 0))))


@register()
def town(gap: float = 0.3) -> Shape:
    edges = [0.0, *accumulate(b + gap for b in STREET)]
    placed = [transform_shape(b.build(), translation_matrix((left + b.width / 2, 0, 0))) for left, b in zip(edges, STREET)]
    total = edges[-1]
    pavement = box(total, 0.1, 1.0, (0.7, 0.7, 0.68), total / 2, -0.1, 1.5)
    road = box(total, 0.08, 2.0, (0.22, 0.22, 0.24), total / 2, -0.1, 3.0)
    lamps = loop(math.floor(total / 2), lambda i: transform_shape(library_call('lamp'), translation_matrix((1 + 2 * i, 0, 1.8))))
    return concat_shapes(pavement, road, lamps, *placed)
