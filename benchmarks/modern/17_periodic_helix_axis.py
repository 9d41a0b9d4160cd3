"""a spiral staircase around a central column with a handrail"""
import math
from typing import Final
import numpy as np
from helper import *

STEPS: Final = 24
RISE: Final = 0.18
TURN: Final = math.radians(18)
WOOD: Final = np.array([0.55, 0.36, 0.2])


def polar(r: float, angle: float, y: float) -> np.ndarray:
    return np.array([r * np.cos(angle), y, r * np.sin(angle)])


@register()
def tread(inner: float = 0.15, outer: float = 1.2, thickness: float = 0.05, tone: float = 1.0) -> Shape:
    length = outer - inner
    slab = primitive_call('cube', shape_kwargs={'scale': (length, thickness, 0.34)}, color=tuple(np.clip(WOOD * tone, 0, 1)))
    return transform_shape(slab, translation_matrix((inner + length / 2, 0, 0)))


@register()
def baluster(height: float = 0.9, radius: float = 0.02) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=(0.15, 0.15, 0.17))


@register()
def handrail(radius: float = 1.15, height: float = 0.9, n: int = STEPS) -> Shape:
    pts = [polar(radius, -i * TURN, i * RISE + height) for i in range(n)]
    return concat_shapes(*(primitive_call('cylinder', shape_kwargs={'radius': 0.035, 'p0': a, 'p1': b}, color=(0.3, 0.18, 0.1))
                           for a, b in zip(pts, pts[1:])))


@register()
def flight(n: int = STEPS) -> Shape:
    def one(i: int) -> Shape:
        pose = translation_matrix((0, i * RISE, 0)) @ rotation_matrix(i * TURN, (0, 1, 0), (0, 0, 0))
        step = library_call('tread', tone=0.9 + 0.2 * (i % 2))
        post = transform_shape(library_call('baluster'), translation_matrix((1.15, 0, 0)))
        return transform_shape(concat_shapes(step, post), pose)
    return loop(n, one)


@register()
def spiral_staircase() -> Shape:
    top = STEPS * RISE
    column = primitive_call('cylinder', shape_kwargs={'radius': 0.15, 'p0': (0, 0, 0), 'p1': (0, top + 1, 0)}, color=(0.85, 0.85, 0.85))
    landing = transform_shape(primitive_call('cube', shape_kwargs={'scale': (1.4, 0.1, 1.4)}, color=tuple(WOOD)),
                              translation_matrix(polar(1.0, -STEPS * TURN, top)))
    return concat_shapes(column, library_call('flight'), library_call('handrail'), landing)
