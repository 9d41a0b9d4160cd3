"""
a greek temple made with a fluent builder
"""
from __future__ import annotations
from helper import *
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property, reduce
from operator import add, matmul


class Part(ABC):
    @abstractmethod
    def shape(self) -> Shape: ...

    @property
    @abstractmethod
    def height(self) -> float: ...

    def __add__(self, other: Part) -> Pile:
        return Pile([self, other])

    def at(self, x: float, y: float, z: float) -> Shape:
        return transform_shape(self.shape(), translation_matrix((x, y, z)))


@dataclass
class Slab(Part):
    width: float
    thickness: float
    depth: float
    color: tuple[float, float, float] = (0.9, 0.88, 0.82)

    @property
    def height(self) -> float:
        return self.thickness

    def shape(self) -> Shape:
        cube = primitive_call('cube', color=self.color, shape_kwargs={'scale': (self.width, self.thickness, self.depth)})
        return transform_shape(cube, translation_matrix((0, self.thickness / 2, 0)))


@dataclass
class Drum(Part):
    radius: float
    length: float

    @property
    def height(self) -> float:
        return self.length

    def shape(self) -> Shape:
        return primitive_call('cylinder', color=(0.93, 0.91, 0.86), shape_kwargs={'radius': self.radius, 'p0': (0, 0, 0), 'p1': (0, self.length, 0)})


@dataclass
class Pile(Part):
    parts: list[Part] = field(default_factory=list)

    def __add__(self, other: Part) -> Pile:
        return Pile([*self.parts, other])

    @cached_property
    def levels(self) -> list[float]:
        levels = [0.0]
        for part in self.parts:
            levels.append(levels[-1] + part.height)
        return levels

    @property
    def height(self) -> float:
        return self.levels[-1]

    def shape(self) -> Shape:
        return concat_shapes(*[part.at(0, y, 0) for part, y in zip(self.parts, self.levels)])


def column(height: float, radius: float, drums: int = 4) -> Part:
    base = Slab(radius * 3, 0.15, radius * 3)
    shaft = [Drum(radius * (1 - 0.05 * k), height / drums) for k in range(drums)]
    capital = Slab(radius * 3, 0.2, radius * 3)
    return reduce(add, [base, *shaft, capital])


@register()
def temple_column(height: float = 3.0, radius: float = 0.25) -> Shape:
    return column(height, radius).shape()


@register()
def steps(width: float = 8.0, depth: float = 5.0, count: int = 3) -> Shape:
    pile = Pile()
    for k in range(count):
        pile = pile + Slab(width + (count - k) * 0.5, 0.2, depth + (count - k) * 0.5)
    return pile.shape()


@register()
def pediment(width: float = 8.0, depth: float = 5.0, rise: float = 1.4, layers: int = 7) -> Shape:
    return reduce(add, (Slab(width * (1 - k / layers), rise / layers, depth) for k in range(layers))).shape()


@register()
def temple(front: int = 6, side: int = 4, width: float = 7.0, depth: float = 4.2) -> Shape:
    xs = [width * (i / (front - 1) - 0.5) for i in range(front)]
    zs = [depth * (j / (side - 1) - 0.5) for j in range(side)]
    ring = [(x, z) for x in xs for z in zs if x in (xs[0], xs[-1]) or z in (zs[0], zs[-1])]
    columns = [transform_shape(library_call('temple_column'), translation_matrix((x, 0.6, z))) for x, z in ring]
    top = 0.6 + column(3.0, 0.25).height
    beam = Slab(width + 1, 0.4, depth + 1).at(0, top, 0)
    roof = transform_shape(library_call('pediment', width=width + 1, depth=depth + 1), translation_matrix((0, top + 0.4, 0)))
    pose = reduce(matmul, [translation_matrix((0, 0.6, 0)), scale_matrix(0.8, (0, 0, 0))])
    statue = transform_shape(concat_shapes(Drum(0.3, 1.2).shape(), transform_shape(primitive_call('sphere', color=(0.8, 0.65, 0.3), shape_kwargs={'radius': 0.3}), translation_matrix((0, 1.5, 0)))), pose)
    return concat_shapes(library_call('steps', width=width, depth=depth), *columns, beam, roof, statue)
