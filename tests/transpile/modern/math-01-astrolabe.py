import math
from math import tau, radians, degrees, isclose, hypot, prod, comb, perm, factorial, floor, ceil, trunc, copysign, fmod, log2, log10, exp, sinh, cosh, tanh, atan2, acos, asin
from helper import *

"""
an astrolabe: rings, pointers and a catenary chain, with plenty of math functions
"""

BRASS = (0.8, 0.65, 0.3)

def polar(r: float, a: float, z: float = 0.0) -> tuple:
    return (r * math.cos(a), r * math.sin(a), z)

@register()
def ring(radius: float, n: int, thickness: float = 0.05) -> Shape:
    step = tau / n
    chord = 2 * radius * math.sin(step / 2)
    assert isclose(math.dist(polar(radius, 0), polar(radius, step)), chord, rel_tol=1e-9)
    return loop(n, lambda i: primitive_call('cylinder', color=BRASS, shape_kwargs={'radius': thickness, 'p0': polar(radius, i * step), 'p1': polar(radius, (i + 1) * step)}))

@register()
def pointer(angle: float, length: float, color: tuple) -> Shape:
    return primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.04, 'p0': polar(-0.2, angle), 'p1': polar(length, angle)})

@register()
def catenary(width: float, a: float, n: int = 12) -> Shape:
    y = lambda x: a * cosh(x / a) - a * cosh(width / (2 * a))
    xs = [width * (i / n - 0.5) for i in range(n + 1)]
    return concat_shapes(*[transform_shape(primitive_call('sphere', color=(0.5, 0.5, 0.5), shape_kwargs={'radius': 0.06}), translation_matrix((x, y(x), 0))) for x in xs])

@register()
def astrolabe() -> Shape:
    values = [
        degrees(atan2(-1, -1)), fmod(-7.5, 2), math.remainder(7.5, 2), copysign(3, -0.0), log2(1024), log10(5e3), exp(1.5),
        sinh(1), tanh(0.5) * 4, degrees(acos(0.3)) / 20, degrees(asin(-0.4)) / 10, comb(6, 2) / 3, perm(5, 2) / 5, factorial(5) / 40,
        floor(-2.5), ceil(-2.5), trunc(-2.7), round(2.5), round(-3.14159, 2), math.cbrt(27), math.gamma(4.5) / 3, math.erf(0.5) * 5, math.isqrt(50), prod([1.5, 2, 0.8]),
        math.expm1(1), math.log1p(2), math.log(100, 3), math.modf(3.75)[0] * 4, math.frexp(10)[1], math.ldexp(0.7, 2), math.fsum([0.1] * 10) * 3,
    ]
    bars = []
    for k, v in enumerate(values):
        h = abs(v) / 10 + 0.05
        color = (0.2, 0.5, 0.9) if v >= 0 else (0.9, 0.3, 0.2)
        angle = tau * k / len(values)
        bar = transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.1, 0.1, h)}), translation_matrix(polar(2.0, angle, h / 2)))
        bars.append(bar)
    pointers = [library_call('pointer', angle=radians(a), length=hypot(0.3 * a / 90, 1), color=(0.9, 0.9, 0.95)) for a in (15, 100, 230)]
    rings = [library_call('ring', radius=r, n=12 + 4 * i) for i, r in enumerate((1.0, 1.6, 2.4))]
    chain = transform_shape(library_call('catenary', width=5, a=1.5), translation_matrix((0, 3.6, 0)))
    return concat_shapes(*rings, *pointers, *bars, chain)
