"""three meshing gears on a brass plate"""
from __future__ import annotations
from helper import *
from dataclasses import dataclass
from functools import cached_property
import math


@dataclass
class Gear:
    teeth: int
    module: float = 0.1
    center: tuple[float, float] = (0.0, 0.0)
    phase: float = 0.0
    color: tuple[float, float, float] = (0.6, 0.6, 0.65)

    @cached_property
    def pitch_radius(self) -> float:
        return self.teeth * self.module / 2

    @property
    def root_radius(self) -> float:
        return self.pitch_radius - 1.1 * self.module

    @property
    def outer_radius(self) -> float:
        return self.pitch_radius + self.module

    def mesh(self, teeth: int, direction: float, **style) -> Gear:
        """Return a gear meshing with this one in the given direction (radians)."""
        other = Gear(teeth, self.module, **style)
        d = self.pitch_radius + other.pitch_radius
        cx, cy = self.center
        other.center = (cx + d * math.cos(direction), cy + d * math.sin(direction))
        ratio = self.teeth / teeth
        other.phase = direction + math.pi + math.pi / teeth + ratio * (direction - self.phase)
        return other


@register()
def gear(spec: Gear, thickness: float = 0.15) -> Shape:
    disc = primitive_call('cylinder', shape_kwargs={'radius': spec.root_radius, 'p0': (0, 0, 0), 'p1': (0, 0, thickness)}, color=spec.color)
    tooth_len = spec.outer_radius - spec.root_radius
    w = math.pi * spec.module / 2

    def tooth(i: int) -> Shape:
        t = primitive_call('cube', shape_kwargs={'scale': (tooth_len, w, thickness)}, color=spec.color)
        t = transform_shape(t, translation_matrix((spec.root_radius + tooth_len / 2, 0, thickness / 2)))
        return transform_shape(t, rotation_matrix(spec.phase + i * 2 * math.pi / spec.teeth, (0, 0, 1), (0, 0, 0)))

    hub = primitive_call('cylinder', shape_kwargs={'radius': spec.module * 2, 'p0': (0, 0, 0), 'p1': (0, 0, thickness * 1.6)}, color=(0.25, 0.25, 0.28))
    return transform_shape(concat_shapes(disc, hub, loop(spec.teeth, tooth)), translation_matrix((*spec.center, 0)))


@register()
def gear_train() -> Shape:
    a = Gear(24, color=(0.75, 0.6, 0.25))
    b = a.mesh(12, math.radians(30), color=(0.6, 0.6, 0.65))
    c = b.mesh(18, math.radians(-40), color=(0.7, 0.4, 0.3))
    gears = [library_call('gear', spec=g) for g in (a, b, c)]
    train = concat_shapes(*gears)
    ctr, size = compute_shape_center(train), compute_shape_sizes(train)
    plate = primitive_call('cube', shape_kwargs={'scale': (size[0] + 0.4, size[1] + 0.4, 0.1)}, color=(0.8, 0.65, 0.3))
    return concat_shapes(train, transform_shape(plate, translation_matrix((ctr[0], ctr[1], -0.06))))
