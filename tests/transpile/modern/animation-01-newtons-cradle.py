from __future__ import annotations
import math
from dataclasses import dataclass
from typing import Generator
from helper import *

"""
Newton's cradle
"""


@dataclass
class Cradle:
    balls: int = 5
    radius: float = 0.3
    length: float = 2.0
    amplitude: float = 0.7

    def angles(self, t: float) -> list[float]:
        swing = self.amplitude * math.cos(t)
        result = [0.0] * self.balls
        if swing < 0:
            result[0] = swing
        else:
            result[-1] = swing
        return result


@register()
def pendulum(angle: float, length: float, radius: float) -> Shape:
    tip = (length * math.sin(angle), -length * math.cos(angle), 0)
    strings = [primitive_call('cylinder', color=(0.7, 0.7, 0.7), shape_kwargs={'radius': 0.015, 'p0': (0, 0, z), 'p1': tip}) for z in (-0.6, 0.6)]
    ball = transform_shape(primitive_call('sphere', color=(0.75, 0.77, 0.8), shape_kwargs={'radius': radius}), translation_matrix(tip))
    return concat_shapes(*strings, ball)


@register()
def frame(width: float, height: float) -> Shape:
    bars = [primitive_call('cylinder', color=(0.2, 0.2, 0.22), shape_kwargs={'radius': 0.05, 'p0': (-width / 2, height, z), 'p1': (width / 2, height, z)}) for z in (-0.6, 0.6)]
    legs = [primitive_call('cylinder', color=(0.2, 0.2, 0.22), shape_kwargs={'radius': 0.05, 'p0': (x, 0, z), 'p1': (x, height, z)}) for x in (-width / 2, width / 2) for z in (-0.6, 0.6)]
    return concat_shapes(*bars, *legs)


@register_animation()
def newtons_cradle() -> Generator[Shape, None, None]:
    cradle = Cradle()
    width = 2 * cradle.radius * cradle.balls + 1
    stand = library_call('frame', width=width, height=2.6)
    for step in range(24):
        t = 2 * math.pi * step / 24
        balls = []
        for i, angle in enumerate(cradle.angles(t)):
            x = 2 * cradle.radius * (i - (cradle.balls - 1) / 2)
            balls.append(transform_shape(library_call('pendulum', angle=angle, length=cradle.length, radius=cradle.radius), translation_matrix((x, 2.6, 0))))
        yield concat_shapes(stand, *balls)
