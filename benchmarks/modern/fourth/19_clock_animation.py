"""
a clock with gears whose hands move over frames
"""
from helper import *
import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Gear:
    teeth: int
    x: float
    y: float
    phase: float = 0.0
    module: float = 0.08

    @property
    def radius(self):
        return self.teeth * self.module / 2

    def meshing(self, teeth: int, direction: float) -> 'Gear':
        other = Gear(teeth, 0, 0, module=self.module)
        d = self.radius + other.radius
        return Gear(teeth, self.x + d * math.cos(direction), self.y + d * math.sin(direction), phase=math.pi / teeth, module=self.module)


TRAIN = [Gear(24, 0, 0)]
TRAIN.append(TRAIN[-1].meshing(12, math.radians(30)))
TRAIN.append(TRAIN[-1].meshing(18, math.radians(-40)))


@register()
def gear(teeth: int = 12, module: float = 0.08, color=(0.75, 0.6, 0.25)) -> Shape:
    r = teeth * module / 2
    disc = primitive_call('cylinder', color=color, shape_kwargs={'radius': r * 0.9, 'p0': (0, 0, -0.05), 'p1': (0, 0, 0.05)})
    tooth = transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (module * 1.6, module * 0.7, 0.1)}), translation_matrix((r * 0.95, 0, 0)))
    return concat_shapes(disc, loop(teeth, lambda i: transform_shape(tooth, rotation_matrix(2 * math.pi * i / teeth, (0, 0, 1), (0, 0, 0)))))


@register()
def hand(length: float, width: float = 0.06) -> Shape:
    return transform_shape(primitive_call('cube', color=(0.1, 0.1, 0.1), shape_kwargs={'scale': (width, length, 0.02)}), translation_matrix((0, length / 2, 0)))


@register()
def clock(t: float = 0.0) -> Shape:
    shapes = []
    speed = 1.0
    for previous, g in zip([None, *TRAIN], TRAIN):
        if previous is not None:
            speed *= -previous.teeth / g.teeth
        pose = translation_matrix((g.x, g.y, 0)) @ rotation_matrix(t * speed + g.phase, (0, 0, 1), (0, 0, 0))
        shapes.append(transform_shape(library_call('gear', teeth=g.teeth), pose))
    for length, rate in ((1.1, 1.0), (0.7, 1 / 12)):
        shapes.append(transform_shape(library_call('hand', length=length), translation_matrix((0, 0, 0.1)) @ rotation_matrix(-t * rate, (0, 0, 1), (0, 0, 0))))
    return concat_shapes(*shapes)


@register_animation()
def ticking():
    for frame in range(6):
        yield library_call('clock', t=frame * math.pi / 15)
