"""a wall clock showing 10:08:42 with hour markers"""
from helper import *
from datetime import time
from dataclasses import dataclass
import math


@dataclass(frozen=True)
class Hand:
    angle: float
    length: float
    width: float
    color: tuple[float, float, float]

    @classmethod
    def from_fraction(cls, frac: float, **style) -> "Hand":
        return cls(angle=-2 * math.pi * frac, **style)


def hands(t: time) -> list[Hand]:
    s = t.second / 60
    m = (t.minute + s) / 60
    h = (t.hour % 12 + m) / 12
    return [
        Hand.from_fraction(h, length=0.5, width=0.07, color=(0.1, 0.1, 0.1)),
        Hand.from_fraction(m, length=0.75, width=0.05, color=(0.1, 0.1, 0.1)),
        Hand.from_fraction(s, length=0.85, width=0.02, color=(0.85, 0.1, 0.1)),
    ]


@register()
def hand(spec: Hand, layer: int = 0) -> Shape:
    bar = primitive_call('cube', shape_kwargs={'scale': (spec.width, spec.length, 0.02)}, color=spec.color)
    bar = transform_shape(bar, translation_matrix((0, spec.length / 2 - 0.08, 0.05 + 0.025 * layer)))
    return transform_shape(bar, rotation_matrix(spec.angle, (0, 0, 1), (0, 0, 0)))


@register()
def dial(radius: float = 1.0) -> Shape:
    rim = primitive_call('cylinder', shape_kwargs={'radius': radius * 1.1, 'p0': (0, 0, -0.1), 'p1': (0, 0, 0)}, color=(0.35, 0.2, 0.1))
    face = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, 0, 0.02)}, color=(0.97, 0.96, 0.92))

    def mark(i: int) -> Shape:
        major = i % 5 == 0
        size = (0.04, 0.12, 0.02) if major else (0.015, 0.05, 0.02)
        m = primitive_call('cube', shape_kwargs={'scale': size}, color=(0.1, 0.1, 0.1))
        m = transform_shape(m, translation_matrix((0, radius * 0.95 - size[1] / 2, 0.03)))
        return transform_shape(m, rotation_matrix(i * math.pi / 30, (0, 0, 1), (0, 0, 0)))

    return concat_shapes(rim, face, loop(60, mark))


@register()
def wall_clock(hour: int = 10, minute: int = 8, second: int = 42) -> Shape:
    t = time(hour, minute, second)
    cap = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.05}, color=(0.8, 0.7, 0.3)), translation_matrix((0, 0, 0.1)))
    return concat_shapes(library_call('dial'), *[library_call('hand', spec=h, layer=i) for i, h in enumerate(hands(t))], cap)
