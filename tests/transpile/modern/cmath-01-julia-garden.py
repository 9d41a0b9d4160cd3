import cmath
import math
from helper import *

"""
a Julia set as a relief of columns, with the roots of unity around it
"""


def escape(z: complex, c: complex, limit: int = 12) -> int:
    for n in range(limit):
        if abs(z) > 2:
            return n
        z = z * z + c
    return limit


def roots_of_unity(n: int) -> list[complex]:
    return [cmath.exp(2j * cmath.pi * k / n) for k in range(n)]


def newton(z: complex, steps: int = 8) -> complex:
    """Newton's method for z**3 - 1."""
    for _ in range(steps):
        z -= (z ** 3 - 1) / (3 * z ** 2)
    return z


@register()
def column(n: int, limit: int) -> Shape:
    t = n / limit
    h = 0.1 + 1.2 * t
    return transform_shape(primitive_call('cube', color=(t, 0.3, 1 - t), shape_kwargs={'scale': (0.2, h, 0.2)}), translation_matrix((0, h / 2, 0)))


@register()
def julia(c: complex, n: int = 15, limit: int = 12) -> Shape:
    parts = []
    for i in range(n):
        for j in range(n):
            z = complex(3 * i / (n - 1) - 1.5, 2.4 * j / (n - 1) - 1.2)
            if (k := escape(z, c, limit)) > 2:
                parts.append(transform_shape(library_call('column', n=k, limit=limit), translation_matrix((2 * z.real, 0, 2 * z.imag))))
    return concat_shapes(*parts)


@register()
def garden() -> Shape:
    posts = []
    for k, root in enumerate(roots_of_unity(10)):
        r, phi = cmath.polar(root * 4.2)
        w = cmath.rect(r, phi + 0.1)
        posts.append(primitive_call('cylinder', color=(0.6, 0.5, 0.3), shape_kwargs={'radius': 0.1, 'p0': (w.real, 0, w.imag), 'p1': (w.real, 1 + abs(root.imag), w.imag)}))
        basin = cmath.phase(newton(root + 0.1)) % (2 * math.pi)
        lamp = primitive_call('sphere', color=(basin / 7, 0.8, 0.2), shape_kwargs={'radius': 0.15})
        posts.append(transform_shape(lamp, translation_matrix((w.real, 1.2 + abs(root.imag), w.imag))))
    s = cmath.sqrt(-2)
    product = (1 + 2j) * (3 - 1j) / (1 - 1j) + s.conjugate()
    statue = primitive_call('sphere', color=(0.9, 0.9, 0.9), shape_kwargs={'radius': abs(product) / 8})
    return concat_shapes(library_call('julia', c=-0.4 + 0.6j), *posts, transform_shape(statue, translation_matrix((product.real, 0.5, 5))))
