"""
a low-poly city on a river, skyline higher towards the centre
"""
from helper import *
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np


class Zone(Enum):
    DOWNTOWN = auto()
    MIDRISE = auto()
    SUBURB = auto()
    RIVER = auto()

    @property
    def tint(self) -> tuple[float, float, float]:
        return {
            Zone.DOWNTOWN: (0.45, 0.55, 0.68),
            Zone.MIDRISE: (0.72, 0.58, 0.48),
            Zone.SUBURB: (0.85, 0.78, 0.66),
            Zone.RIVER: (0.25, 0.45, 0.70),
        }[self]


def value_noise(x: float, z: float) -> float:
    def h(i: int, j: int) -> float:
        n = (i * 374761393 + j * 668265263) & 0xFFFFFFFF
        n = ((n ^ (n >> 13)) * 1274126177) & 0xFFFFFFFF
        return ((n ^ (n >> 16)) & 0xFFFF) / 0xFFFF
    i, j = math.floor(x), math.floor(z)
    u, v = x - i, z - j
    u, v = u * u * (3 - 2 * u), v * v * (3 - 2 * v)
    return ((1 - u) * (1 - v) * h(i, j) + u * (1 - v) * h(i + 1, j)
            + (1 - u) * v * h(i, j + 1) + u * v * h(i + 1, j + 1))


@dataclass
class Building(ABC):
    width: float
    height: float
    zone: Zone

    def __post_init__(self):
        if self.height <= 0:
            raise ValueError(f'bad height {self.height!r}')

    @abstractmethod
    def top(self) -> Shape: ...

    def body(self) -> Shape:
        b = primitive_call('cube', {'scale': (self.width, self.height, self.width)}, color=self.zone.tint)
        return transform_shape(b, translation_matrix((0, self.height / 2, 0)))

    def build(self) -> Shape:
        return concat_shapes(self.body(), transform_shape(self.top(), translation_matrix((0, self.height, 0))))


class Tower(Building):
    def top(self) -> Shape:
        return primitive_call('cylinder', {'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0, self.height * 0.25, 0)},
                              color=(0.8, 0.8, 0.85))


class Block(Building):
    def top(self) -> Shape:
        tank = primitive_call('cylinder', {'radius': self.width * 0.2, 'p0': (0, 0, 0), 'p1': (0, 0.15, 0)},
                              color=(0.5, 0.4, 0.35))
        return transform_shape(tank, translation_matrix((self.width * 0.2, 0, -self.width * 0.15)))


class Cottage(Building):
    def top(self) -> Shape:
        s = self.width / math.sqrt(2)
        gable = primitive_call('cube', {'scale': (s, s, self.width * 0.98)}, color=(0.6, 0.25, 0.2))
        return transform_shape(gable, rotation_matrix(math.pi / 4, (0, 0, 1), (0, 0, 0)))


def classify(x: float, z: float) -> Zone:
    if abs(z - 1.2 * math.sin(x * 0.5) - 2.5) < 0.6:
        return Zone.RIVER
    match math.hypot(x, z):
        case r if r < 2.5:
            return Zone.DOWNTOWN
        case r if r < 4.5:
            return Zone.MIDRISE
    return Zone.SUBURB


@register()
def building(zone_name: str = 'DOWNTOWN', height: float = 2.0, width: float = 0.7) -> Shape:
    zone = Zone[zone_name]
    kind = {Zone.DOWNTOWN: Tower, Zone.MIDRISE: Block}.get(zone, Cottage)
    return kind(width=width, height=height, zone=zone).build()


@register()
def city(n: int = 13, pitch: float = 1.0) -> Shape:
    axis = (np.arange(n) - (n - 1) / 2) * pitch
    shapes = []
    for x, z in np.stack(np.meshgrid(axis, axis, indexing='ij'), axis=-1).reshape(-1, 2):
        zone = classify(x, z)
        if zone is Zone.RIVER:
            water = primitive_call('cube', {'scale': (pitch, 0.05, pitch)}, color=zone.tint)
            shapes.append(transform_shape(water, translation_matrix((x, 0.03, z))))
            continue
        noise = value_noise(x * 0.9 + 20, z * 0.9 + 40)
        peak = {Zone.DOWNTOWN: 3.5, Zone.MIDRISE: 1.5, Zone.SUBURB: 0.5}[zone]
        h = peak * (0.5 + noise)
        shapes.append(transform_shape(library_call('building', zone_name=zone.name, height=h),
                                      translation_matrix((x, 0, z))))
    base = primitive_call('cube', {'scale': (n * pitch, 0.1, n * pitch)}, color=(0.35, 0.36, 0.35))
    return concat_shapes(transform_shape(base, translation_matrix((0, -0.05, 0))), *shapes)
