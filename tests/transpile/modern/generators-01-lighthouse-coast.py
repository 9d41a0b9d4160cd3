import math
from itertools import islice, takewhile, count
from typing import Iterator
from helper import *

"""
a rocky coast with a lighthouse; points come from infinite generators
"""


def halton(base: int) -> Iterator[float]:
    """Low discrepancy numbers, for ever."""
    for index in count(1):
        f, result, i = 1.0, 0.0, index
        while i:
            f /= base
            i, digit = divmod(i, base)
            result += f * digit
        yield result


def points(width: float, depth: float):
    xs, zs = halton(2), halton(3)
    while True:
        yield (next(xs) - 0.5) * width, (next(zs) - 0.5) * depth


def shrinking(size: float, factor: float):
    while True:
        yield size
        size *= factor


def stripes(a, b):
    while True:
        yield a
        yield b


@register()
def rock(size: float) -> Shape:
    stone = primitive_call('sphere', color=(0.4, 0.38, 0.36), shape_kwargs={'radius': size})
    return transform_shape(stone, scale_matrix((1, 0.6, 1), (0, 0, 0)))


@register()
def lighthouse() -> Shape:
    colors = stripes((0.9, 0.15, 0.1), (0.95, 0.95, 0.95))
    y, shapes = 0.0, []
    for radius, color in zip(takewhile(lambda r: r > 0.3, shrinking(0.8, 0.88)), colors):
        shapes.append(primitive_call('cylinder', color=color, shape_kwargs={'radius': radius, 'p0': (0, y, 0), 'p1': (0, y + 0.6, 0)}))
        y += 0.6
    lamp = transform_shape(primitive_call('sphere', color=(1, 0.95, 0.5), shape_kwargs={'radius': 0.25}), translation_matrix((0, y + 0.2, 0)))
    return concat_shapes(*shapes, lamp)


@register()
def coast() -> Shape:
    far = (p for p in points(10, 6) if math.hypot(*p) > 1.5)
    shapes = [library_call('lighthouse')]
    for (x, z), size in zip(islice(far, 2, 60, 2), shrinking(0.6, 0.95)):
        if size < 0.15:
            break
        shapes.append(transform_shape(library_call('rock', size=size), translation_matrix((x, 0, z))))
    total = sum(1 for _ in islice(far, 5))
    sea = transform_shape(primitive_call('cube', color=(0.1, 0.35, 0.5), shape_kwargs={'scale': (12, 0.1, 3 + total)}), translation_matrix((0, -0.3, 0)))
    return concat_shapes(sea, *shapes)
