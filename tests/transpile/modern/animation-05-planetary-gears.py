from __future__ import annotations
import math
from abc import ABC, abstractmethod
from helper import *

"""
a planetary gear set in motion
"""


class Gear(ABC):
    module = 0.1

    def __init__(self, teeth: int, color: tuple[float, float, float]):
        self.teeth = teeth
        self.color = color

    @property
    def pitch_radius(self) -> float:
        return self.module * self.teeth / 2

    @abstractmethod
    def tooth_offset(self) -> float: ...

    def tooth(self) -> Shape:
        return transform_shape(primitive_call('cube', color=self.color, shape_kwargs={'scale': (0.16, self.module * 1.2, 0.2)}), translation_matrix((self.pitch_radius + self.tooth_offset(), 0, 0)))

    def draw(self, angle: float) -> Shape:
        step = 2 * math.pi / self.teeth
        return loop(self.teeth, lambda i: transform_shape(self.tooth(), rotation_matrix(angle + i * step, (0, 0, 1), (0, 0, 0))))


class Spur(Gear):
    def tooth_offset(self) -> float:
        return 0.0

    def draw(self, angle: float) -> Shape:
        disc = primitive_call('cylinder', color=self.color, shape_kwargs={'radius': self.pitch_radius - 0.05, 'p0': (0, 0, -0.1), 'p1': (0, 0, 0.1)})
        return concat_shapes(disc, super().draw(angle))


class Ring(Gear):
    def tooth_offset(self) -> float:
        return 0.08


SUN, PLANET = Spur(12, (0.9, 0.7, 0.2)), Spur(9, (0.3, 0.5, 0.8))
RING = Ring(SUN.teeth + 2 * PLANET.teeth, (0.5, 0.5, 0.55))


@register("the whole gear set at one moment")
def gear_set(sun_angle: float, planets: int = 3) -> Shape:
    carrier = sun_angle * SUN.teeth / (SUN.teeth + RING.teeth)
    spin = carrier - (sun_angle - carrier) * SUN.teeth / PLANET.teeth
    reach = SUN.pitch_radius + PLANET.pitch_radius
    parts = [SUN.draw(sun_angle), RING.draw(0.0)]
    for k in range(planets):
        a = carrier + 2 * math.pi * k / planets
        parts.append(transform_shape(PLANET.draw(spin), translation_matrix((reach * math.cos(a), reach * math.sin(a), 0))))
    return concat_shapes(*parts)


@register_animation("planetary gears")
def gears_turning() -> Generator[Shape, None, None]:
    yield from (library_call('gear_set', sun_angle=2 * math.pi * f / 16) for f in range(16))
