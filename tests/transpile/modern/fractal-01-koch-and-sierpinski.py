from __future__ import annotations
from typing import Iterator
import math
from helper import *

"""
a snowflake on a pole above a Sierpinski pyramid
"""

Point = tuple[float, float]


def koch(a: Point, b: Point, depth: int) -> Iterator[tuple[Point, Point]]:
    """Four thirds of the line, recursively."""
    if depth == 0:
        yield a, b
        return
    (ax, ay), (bx, by) = a, b
    dx, dy = (bx - ax) / 3, (by - ay) / 3
    p, q = (ax + dx, ay + dy), (ax + 2 * dx, ay + 2 * dy)
    c, s = math.cos(math.pi / 3), math.sin(math.pi / 3)
    tip = (p[0] + dx * c - dy * s, p[1] + dx * s + dy * c)
    for start, end in ((a, p), (p, tip), (tip, q), (q, b)):
        yield from koch(start, end, depth - 1)


@register()
def snowflake(radius: float, depth: int) -> Shape:
    corners = [(radius * math.cos(t), radius * math.sin(t)) for t in (math.pi / 2 - 2 * math.pi * k / 3 for k in range(3))]
    edges = (edge for k in range(3) for edge in koch(corners[k], corners[(k + 1) % 3], depth))
    return concat_shapes(*[primitive_call('cylinder', color=(0.6, 0.85, 1), shape_kwargs={'radius': 0.03, 'p0': (*a, 0), 'p1': (*b, 0)}) for a, b in edges])


@register()
def pyramid(depth: int, size: float = 1.0) -> Shape:
    if depth == 0:
        base = primitive_call('cube', color=(0.85, 0.7, 0.4), shape_kwargs={'scale': (size, size / 2, size)})
        cap = primitive_call('cube', color=(0.75, 0.6, 0.35), shape_kwargs={'scale': (size / 2, size / 2, size / 2)})
        return concat_shapes(transform_shape(base, translation_matrix((0, size / 4, 0))), transform_shape(cap, translation_matrix((0, 3 * size / 4, 0))))
    child = transform_shape(library_call('pyramid', depth=depth - 1, size=size), scale_matrix(0.5, origin=(0, 0, 0)))
    q = size / 4
    spots = [(-q, 0, -q), (q, 0, -q), (-q, 0, q), (q, 0, q), (0, size / 2, 0)]
    return concat_shapes(*(transform_shape(child, translation_matrix(p)) for p in spots))


@register()
def monument() -> Shape:
    base = transform_shape(library_call('pyramid', depth=2), scale_matrix(4, origin=(0, 0, 0)))
    top = float(compute_shape_max(base)[1])
    star = library_call('snowflake', radius=1.2, depth=2)
    center = compute_shape_center(star)
    star = transform_shape(star, translation_matrix(-center))
    lift = top + compute_shape_sizes(star)[1] / 2 + 0.5
    pole = primitive_call('cylinder', color=(0.4, 0.4, 0.4), shape_kwargs={'radius': 0.05, 'p0': (0, top, 0), 'p1': (0, lift, 0)})
    return concat_shapes(base, pole, transform_shape(star, translation_matrix((0, lift, 0))))
