"""
a mandala of lamps placed by complex numbers
"""
from helper import *
import cmath
import math
from functools import reduce
from itertools import product, chain
from typing import Iterator

TAU = 2 * math.pi


def roots(n: int, radius: float = 1.0, turn: float = 0.0) -> list[complex]:
    return [cmath.rect(radius, turn + TAU * k / n) for k in range(n)]


def mobius(z: complex, a: complex, b: complex, c: complex, d: complex) -> complex:
    return (a * z + b) / (c * z + d)


def orbit(z: complex, steps: int) -> Iterator[complex]:
    for _ in range(steps):
        yield z
        z = mobius(z, 1, 0.4j, 0.2, 1.1)


def polyval(coefficients: list[complex], z: complex) -> complex:
    return reduce(lambda total, c: total * z + c, coefficients, 0j)


def lift(z: complex) -> tuple[float, float, float]:
    return (z.real, 0.05 * abs(z), z.imag)


@register()
def lamp(size: float = 0.15, warm: float = 0.5) -> Shape:
    foot = primitive_call('cylinder', color=(0.3, 0.25, 0.2), shape_kwargs={'radius': size * 0.8, 'p0': (0, 0, 0), 'p1': (0, size * 0.3, 0)})
    glow = transform_shape(primitive_call('sphere', color=(1.0, 0.6 + 0.4 * warm, warm), shape_kwargs={'radius': size * 0.6}), translation_matrix((0, size * 0.8, 0)))
    return concat_shapes(foot, glow)


@register()
def petal_ring(n: int = 8, radius: float = 2.0, twist: float = 0.2) -> Shape:
    lamps = []
    for z in roots(n, radius, twist):
        r, phi = cmath.polar(z)
        one = library_call('lamp', size=0.1 + 0.03 * r, warm=abs(math.sin(phi)))
        lamps.append(transform_shape(one, translation_matrix(lift(z))))
    return concat_shapes(*lamps)


@register()
def swirl(arms: int = 5, steps: int = 7) -> Shape:
    beads = []
    for start in roots(arms, 0.8):
        for k, z in enumerate(orbit(start, steps)):
            w = polyval([1, 0, -0.1j], z) * 2
            beads.append(transform_shape(primitive_call('sphere', color=(0.4, 0.3 + 0.08 * k, 0.8), shape_kwargs={'radius': 0.12 - 0.01 * k}), translation_matrix((w.real, 0.1, w.imag))))
    return concat_shapes(*beads)


@register()
def mandala() -> Shape:
    rings = [library_call('petal_ring', n=6 + 4 * k, radius=2.2 + 0.9 * k, twist=0.1 * k) for k in range(3)]
    plate = primitive_call('cylinder', color=(0.15, 0.12, 0.2), shape_kwargs={'radius': 5.0, 'p0': (0, -0.1, 0), 'p1': (0, 0, 0)})
    return concat_shapes(plate, *rings, library_call('swirl'))
