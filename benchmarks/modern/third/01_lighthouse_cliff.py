"""
a striped lighthouse on a rocky cliff with a keeper's cottage
"""
from __future__ import annotations
from helper import *
import math
import random
from dataclasses import dataclass, field
from itertools import pairwise, accumulate
from typing import Protocol, Iterator


class Profile(Protocol):
    def radius(self, t: float) -> float: ...


@dataclass(frozen=True, slots=True)
class Taper:
    bottom: float
    top: float

    def radius(self, t: float) -> float:
        return self.bottom + (self.top - self.bottom) * t


@dataclass(frozen=True, slots=True)
class Flare:
    base: Taper
    amount: float = 0.3

    def radius(self, t: float) -> float:
        return self.base.radius(t) + self.amount * math.exp(-6 * t)


@dataclass
class Tower:
    profile: Profile
    heights: list[float] = field(default_factory=lambda: [0.9, 0.8, 0.8, 0.7, 0.7, 0.6])

    @property
    def levels(self) -> list[float]:
        return [0.0, *accumulate(self.heights)]

    @property
    def height(self) -> float:
        return self.levels[-1]

    def bands(self) -> Iterator[tuple[int, float, float, float]]:
        for i, (lo, hi) in enumerate(pairwise(self.levels)):
            yield i, lo, hi, self.profile.radius((lo + hi) / 2 / self.height)


def cylinder(radius, y0, y1, color, x=0.0, z=0.0):
    return primitive_call('cylinder', color=color, shape_kwargs={'radius': radius, 'p0': (x, y0, z), 'p1': (x, y1, z)})


def box(size, at, color):
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': size}), translation_matrix(at))


@register()
def tower(bottom: float = 1.0, top: float = 0.6) -> Shape:
    t = Tower(Flare(Taper(bottom, top)))
    stripes = [cylinder(r, lo, hi, (0.8, 0.1, 0.1) if i % 2 else (0.95, 0.95, 0.93)) for i, lo, hi, r in t.bands()]
    gallery = cylinder(top * 1.4, t.height, t.height + 0.1, (0.2, 0.2, 0.22))
    lamp = cylinder(top * 0.7, t.height + 0.1, t.height + 0.7, (1.0, 0.95, 0.6))
    posts = [
        cylinder(0.03, t.height + 0.1, t.height + 0.4, (0.2, 0.2, 0.22), top * 1.3 * math.cos(a), top * 1.3 * math.sin(a))
        for a in (k * math.tau / 12 for k in range(12))
    ]
    cap = transform_shape(primitive_call('sphere', color=(0.7, 0.1, 0.1), shape_kwargs={'radius': top * 0.8}), translation_matrix((0, t.height + 0.75, 0)))
    return concat_shapes(*stripes, gallery, lamp, *posts, cap)


@register()
def cottage(width: float = 1.6) -> Shape:
    walls = box((width, 0.9, 1.1), (0, 0.45, 0), (0.93, 0.9, 0.85))
    roof = [box((width * 1.1, 0.12, 1.2 - 0.2 * k), (0, 0.95 + 0.12 * k, 0), (0.5, 0.25, 0.2)) for k in range(5)]
    windows = [box((0.25, 0.3, 0.05), (x, 0.5, 0.56), (0.4, 0.6, 0.8)) for x in (-width / 3, width / 3)]
    return concat_shapes(walls, *roof, *windows)


@register()
def cliff(count: int = 30, radius: float = 4.0) -> Shape:
    random.seed(11)
    rocks = []
    for _ in range(count):
        r, a = radius * math.sqrt(random.random()), random.uniform(0, math.tau)
        size = random.uniform(0.4, 1.1)
        rocks.append(transform_shape(primitive_call('cube', color=(0.4, 0.38, 0.35), shape_kwargs={'scale': size}),
                                     translation_matrix((r * math.cos(a), -size / 2, r * math.sin(a))) @ rotation_matrix(a, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(*rocks)


@register()
def lighthouse_scene() -> Shape:
    hut = transform_shape(library_call('cottage', width=1.8), translation_matrix((2.2, 0, 0.5)))
    sea = box((14, 0.1, 14), (0, -1.4, 0), (0.2, 0.4, 0.6))
    return concat_shapes(sea, library_call('cliff'), library_call('tower'), hut)
