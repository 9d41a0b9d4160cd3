"""
a three-tier wedding cake with cream swirls, strawberries and candles
"""
from helper import *
import math
from typing import TypedDict, NotRequired, Final
from itertools import zip_longest

TAU: Final = 2 * math.pi


class Tier(TypedDict):
    radius: float
    height: float
    icing: tuple[float, float, float]
    topping: NotRequired[str]


TIERS: list[Tier] = [
    {'radius': 1.6, 'height': 0.8, 'icing': (0.98, 0.94, 0.9), 'topping': 'strawberry'},
    {'radius': 1.1, 'height': 0.7, 'icing': (0.97, 0.8, 0.84), 'topping': 'swirl'},
    {'radius': 0.65, 'height': 0.6, 'icing': (0.98, 0.94, 0.9)},
]


class RingOf:
    """RingOf(n, r) @ fn places fn(i) around a ring."""

    def __init__(self, n: int, radius: float, y: float = 0.0):
        self.n, self.radius, self.y = n, radius, y

    def __matmul__(self, fn) -> Shape:
        def one(i: int) -> Shape:
            a = TAU * i / self.n
            return transform_shape(transform_shape(fn(i), rotation_matrix(-a, (0, 1, 0), (0, 0, 0))),
                                   translation_matrix((self.radius * math.cos(a), self.y, self.radius * math.sin(a))))
        return loop(self.n, one)


@register()
def strawberry(size: float = 0.13) -> Shape:
    flesh = [transform_shape(primitive_call('sphere', {'radius': size * k}, color=(0.85, 0.1, 0.15)), translation_matrix((0, size * y, 0)))
             for k, y in ((1.0, 0.6), (0.75, 1.0), (0.45, 1.4))]
    cap = primitive_call('cylinder', {'radius': size * 0.5, 'p0': (0, -size * 0.3, 0), 'p1': (0, -size * 0.2, 0)}, color=(0.2, 0.55, 0.2))
    return concat_shapes(*flesh, cap)


@register()
def swirl(size: float = 0.12, turns: int = 3) -> Shape:
    steps = turns * 6
    def bead(i: int) -> Shape:
        t = i / steps
        r = size * (1 - t) * 0.6
        a = TAU * turns * t
        b = primitive_call('sphere', {'radius': size * (0.45 - 0.3 * t)}, color=(1.0, 0.97, 0.93))
        return transform_shape(b, translation_matrix((r * math.cos(a), size * 1.4 * t, r * math.sin(a))))
    return loop(steps, bead)


@register()
def candle(height: float = 0.5, lit: bool = True, color: tuple = (0.5, 0.75, 0.95)) -> Shape:
    wax = primitive_call('cylinder', {'radius': 0.04, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=color)
    if not lit:
        return wax
    flame = transform_shape(primitive_call('sphere', {'radius': 0.05}, color=(1.0, 0.75, 0.2)), translation_matrix((0, height + 0.07, 0)))
    return concat_shapes(wax, flame)


@register()
def cake_tier(radius: float = 1.0, height: float = 0.7, icing: tuple = (1, 1, 1), topping: str = '', inner: float = 0.0) -> Shape:
    body = primitive_call('cylinder', {'radius': radius, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=icing)
    drops = RingOf(int(radius * 16), radius, height) @ (lambda i: primitive_call(
        'cylinder', {'radius': 0.06, 'p0': (0, 0, 0), 'p1': (0, -0.15 - 0.12 * ((i * 7) % 5) / 5, 0)}, color=(0.45, 0.26, 0.15)))
    pearls = RingOf(int(radius * 20), radius, 0.06) @ (lambda i: primitive_call('sphere', {'radius': 0.06}, color=(1, 0.98, 0.95)))
    extra: Shape = []
    if topping:
        mid = (radius + inner) / 2
        extra = RingOf(round(mid * 8), mid, height + 0.02) @ (lambda i: library_call(topping))
    return concat_shapes(body, drops, pearls, extra)


@register()
def wedding_cake(candles: int = 7) -> Shape:
    y, shapes = 0.1, []
    for tier, above in zip_longest(TIERS, TIERS[1:]):
        inner = above['radius'] if above else 0.0
        part = library_call('cake_tier', **{'topping': '', **tier}, inner=inner)
        shapes.append(transform_shape(part, translation_matrix((0, y, 0))))
        y += tier['height']
    lights = RingOf(candles, 0.45, y) @ (lambda i: library_call('candle', lit=i != 3))
    plate = primitive_call('cylinder', {'radius': 2.1, 'p0': (0, 0, 0), 'p1': (0, 0.1, 0)}, color=(0.85, 0.87, 0.9))
    return concat_shapes(plate, *shapes, lights)
