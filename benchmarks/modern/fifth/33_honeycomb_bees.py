"""a honeycomb with filled and empty cells and worker bees flying around it"""
from helper import *
from collections import Counter
from dataclasses import dataclass
from enum import StrEnum
from typing import Iterator, Self
import math
import random


@dataclass(frozen=True, order=True)
class Hex:
    """Axial coordinates on a grid with pointy tops."""
    q: int
    r: int

    def __add__(self, other: Self) -> Self:
        return type(self)(self.q + other.q, self.r + other.r)

    def __sub__(self, other: Self) -> Self:
        return self + -other

    def __neg__(self) -> Self:
        return type(self)(-self.q, -self.r)

    def __mul__(self, k: int) -> Self:
        return type(self)(self.q * k, self.r * k)

    __rmul__ = __mul__

    def __abs__(self) -> int:
        return (abs(self.q) + abs(self.r) + abs(self.q + self.r)) // 2

    def __iter__(self) -> Iterator[float]:
        yield math.sqrt(3) * (self.q + self.r / 2)
        yield 1.5 * self.r

    def ring(self, radius: int) -> Iterator[Self]:
        if radius == 0:
            yield self
            return
        here = self + DIRECTIONS[4] * radius
        for d in DIRECTIONS:
            for _ in range(radius):
                yield here
                here = here + d


DIRECTIONS = [Hex(1, 0), Hex(1, -1), Hex(0, -1), Hex(-1, 0), Hex(-1, 1), Hex(0, 1)]


class Content(StrEnum):
    EMPTY = 'empty'
    NECTAR = 'nectar'
    HONEY = 'honey'
    BROOD = 'brood'
    CAPPED = 'capped'

    @property
    def fill(self) -> float:
        return {'empty': 0.0, 'nectar': 0.35, 'honey': 0.75, 'brood': 0.5, 'capped': 1.0}[self]

    @property
    def color(self) -> tuple[float, float, float]:
        match self:
            case Content.NECTAR | Content.HONEY:
                return 0.95, 0.65 - 0.2 * self.fill, 0.1
            case Content.BROOD:
                return 0.97, 0.95, 0.88
            case _:
                return 0.75, 0.55, 0.3


def spiral(radius: int) -> Iterator[Hex]:
    for k in range(radius + 1):
        yield from Hex(0, 0).ring(k)


def stock(cells: list[Hex], rnd: random.Random) -> dict[Hex, Content]:
    """Brood in the middle, honey around it, empty cells at the edge."""
    largest = max(map(abs, cells))
    table = {}
    for cell in cells:
        t = abs(cell) / largest
        weights = [max(0.05, t - 0.5), 0.3, 0.6 * t, max(0.0, 0.9 - 1.6 * t), 0.5 * t]
        table[cell], = rnd.choices(list(Content), weights)
    return table


@register()
def wax_cell(content: str = 'honey', size: float = 0.2, depth: float = 0.25, wall: float = 0.02) -> Shape:
    c = Content(content)
    apothem = size * math.sqrt(3) / 2
    def side(i: int) -> Shape:
        panel = primitive_call('cube', shape_kwargs={'scale': (wall, size, depth)}, color=(0.88, 0.68, 0.3))
        return transform_shape(panel, rotation_matrix(i * math.pi / 3, (0, 0, 1), (0, 0, 0)) @ translation_matrix((apothem, 0, 0)))
    walls = loop(6, side)
    if c is Content.EMPTY:
        return walls
    filling = primitive_call('cylinder', shape_kwargs={'radius': apothem * 0.95, 'p0': (0, 0, -depth / 2), 'p1': (0, 0, -depth / 2 + depth * c.fill)}, color=c.color)
    if c == 'brood':
        larva = transform_shape(primitive_call('sphere', shape_kwargs={'radius': size * 0.4}, color=c.color), scale_matrix((1, 0.6, 0.5), (0, 0, 0)))
        return concat_shapes(walls, larva)
    return concat_shapes(walls, filling)


@register()
def bee(size: float = 0.12, stripes: int = 5, wing_lift: float = 0.6) -> Shape:
    def slice_(i: int) -> Shape:
        t = (i + 0.5) / stripes * 2 - 1
        color = (0.98, 0.78, 0.1) if i % 2 else (0.12, 0.1, 0.08)
        return primitive_call('cylinder', shape_kwargs={'radius': size * 0.5 * math.sqrt(1 - t * t * 0.85), 'p0': (size * (t - 1 / stripes), 0, 0), 'p1': (size * (t + 1 / stripes), 0, 0)}, color=color)
    head = transform_shape(primitive_call('sphere', shape_kwargs={'radius': size * 0.4}, color=(0.12, 0.1, 0.08)), translation_matrix((size * 1.2, 0, 0)))
    wings = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 1.0}, color=(0.85, 0.92, 0.97)),
                             translation_matrix((0, size * 0.5, 0)) @ rotation_matrix(-s * wing_lift, (1, 0, 0), (0, 0, 0)) @ translation_matrix((0, 0, s * size * 0.8)) @ scale_matrix((size * 0.35, size * 0.03, size * 0.75), (0, 0, 0)))
             for s in (-1, 1)]
    sting = primitive_call('cylinder', shape_kwargs={'radius': size * 0.05, 'p0': (-size, 0, 0), 'p1': (-size * 1.35, 0, 0)}, color=(0.1, 0.1, 0.1))
    return concat_shapes(loop(stripes, slice_), head, *wings, sting)


@register()
def honeycomb(radius: int = 4, size: float = 0.2, seed: int = 6) -> Shape:
    rnd = random.Random(seed)
    table = stock(list(spiral(radius)), rnd)
    cells = []
    for cell in sorted(table):
        x, y = (c * size for c in cell)
        cells.append(transform_shape(library_call('wax_cell', content=table[cell].value, size=size), translation_matrix((x, y, 0))))
    tally = Counter(table.values())
    # a drop of honey below the comb for every third honey cell
    drops = loop(tally[Content.HONEY] // 3, lambda i: transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.05 + 0.01 * (i % 3)}, color=Content.HONEY.color), translation_matrix((0.25 * (i - 2), -1.5 * size * radius - 0.35 - 0.12 * (i % 2), 0))))
    return concat_shapes(*cells, drops)


@register()
def apiary(bees: int = 9) -> Shape:
    flight = []
    for i in range(bees):
        a = math.tau * i / bees
        p = (2.0 * math.cos(a), 0.9 * math.sin(2 * a), 0.8 + 0.4 * math.sin(a))
        flight.append(transform_shape(library_call('bee', wing_lift=0.3 + 0.1 * (i % 4)), translation_matrix(p) @ rotation_matrix(a + math.pi / 2, (0, 0, 1), (0, 0, 0))))
    frame = [transform_shape(primitive_call('cube', shape_kwargs={'scale': s}, color=(0.6, 0.42, 0.25)), translation_matrix(p))
             for s, p in (((3.6, 0.15, 0.3), (0, 1.75, 0)), ((0.15, 3.4, 0.3), (-1.75, 0, 0)), ((0.15, 3.4, 0.3), (1.75, 0, 0)))]
    return concat_shapes(*frame, library_call('honeycomb'), *flight)
