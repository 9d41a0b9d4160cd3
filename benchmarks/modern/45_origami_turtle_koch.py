"""a Koch snowflake ornament hanging on a ribbon"""
from helper import *
import cmath
import math
from functools import reduce

EDGE = [1, cmath.exp(1j * math.pi / 3), cmath.exp(-1j * math.pi / 3), 1]


def refine(points: list[complex]) -> list[complex]:
    """Replace each segment by four."""
    out = []
    for a, b in zip(points, points[1:]):
        step = (b - a) / 3
        p = a
        for e in EDGE:
            out.append(p)
            p += step * e
    return out + points[-1:]


def snowflake(order: int, size: float) -> list[complex]:
    corners = [size * cmath.exp(1j * (math.pi / 2 - 2 * math.pi * k / 3)) for k in range(4)]
    return reduce(lambda pts, _: refine(pts), range(order), corners)


def to3(z: complex, depth: float = 0.0) -> tuple[float, float, float]:
    return (z.real, z.imag, depth)


@register()
def outline(order: int = 3, size: float = 1.0, radius: float = 0.015) -> Shape:
    pts = snowflake(order, size)
    return concat_shapes(*[
        primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': to3(a), 'p1': to3(b)}, color=(0.75, 0.88, 1.0))
        for a, b in zip(pts, pts[1:]) if abs(b - a) > 1e-9
    ])


@register()
def spokes(n: int = 6, length: float = 0.55) -> Shape:
    arm = primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (0, 0, 0), 'p1': (0, length, 0)}, color=(0.9, 0.95, 1.0))
    twigs = [primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': (0, length * f, 0), 'p1': (s * 0.15, length * f + 0.15, 0)}, color=(0.9, 0.95, 1.0))
             for f in (0.4, 0.65) for s in (-1, 1)]
    whole = concat_shapes(arm, *twigs)
    return loop(n, lambda i: transform_shape(whole, rotation_matrix(i * math.tau / n, (0, 0, 1), (0, 0, 0))))


@register()
def ribbon(top: float = 2.0, bottom: float = 1.0) -> Shape:
    band = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.06, top - bottom, 0.01)}, color=(0.8, 0.1, 0.15)), translation_matrix((0, (top + bottom) / 2, 0)))
    bow = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.09}, color=(0.8, 0.1, 0.15)), translation_matrix((s * 0.1, bottom + 0.05, 0))) for s in (-1, 1)]
    return concat_shapes(band, *bow)


@register()
def ornament() -> Shape:
    center = primitive_call('sphere', shape_kwargs={'radius': 0.08}, color=(1, 1, 1))
    return concat_shapes(library_call('outline'), library_call('spokes'), center, library_call('ribbon'))
