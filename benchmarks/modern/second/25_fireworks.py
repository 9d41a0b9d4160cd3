"""
fireworks over a harbour at night
"""
from helper import *
import math
from dataclasses import dataclass, field
from enum import Enum
from random import Random
from typing import Iterator


class Burst(Enum):
    PEONY = 'peony'
    RING = 'ring'
    WILLOW = 'willow'

    def directions(self, n: int, rng: Random) -> Iterator[tuple[float, float, float]]:
        golden = math.pi * (3 - math.sqrt(5))
        for i in range(n):
            if self is Burst.RING:
                a = 2 * math.pi * i / n
                yield math.cos(a), 0.35 * math.sin(a), math.sin(a)
            else:
                y = 1 - 2 * (i + 0.5) / n
                r = math.sqrt(1 - y * y)
                yield r * math.cos(i * golden), y, r * math.sin(i * golden)


@dataclass
class Spark:
    pos: list[float]
    vel: list[float]
    trail: list[tuple[float, float, float]] = field(default_factory=list)

    def fly(self, steps: int, dt: float = 0.06, drag: float = 1.1, g: float = 1.6) -> 'Spark':
        for _ in range(steps):
            self.trail.append(tuple(self.pos))
            self.vel = [v - drag * v * dt for v in self.vel]
            self.vel[1] -= g * dt
            self.pos = [p + v * dt for p, v in zip(self.pos, self.vel)]
        self.trail.append(tuple(self.pos))
        return self


def fade(color, t):
    return tuple(c * (0.35 + 0.65 * t) for c in color)


@register()
def streak(trail: list, color: tuple = (1, 0.8, 0.4), radius: float = 0.025) -> Shape:
    n = len(trail) - 1
    assert n > 0
    segs = [primitive_call('cylinder', {'radius': radius * (0.4 + 0.6 * i / n), 'p0': a, 'p1': b}, color=fade(color, (i + 1) / n))
            for i, (a, b) in enumerate(zip(trail, trail[1:]))]
    tip = transform_shape(primitive_call('sphere', {'radius': radius * 1.8}, color=color), translation_matrix(trail[-1]))
    return concat_shapes(*segs, tip)


@register()
def firework(kind: str = 'peony', sparks: int = 30, power: float = 2.2, color: tuple = (1, 0.8, 0.4), steps: int = 6) -> Shape:
    burst = Burst(kind)
    rng = Random(f'{kind}-{sparks}')
    out = []
    for d in burst.directions(sparks, rng):
        speed = power * rng.gauss(1, 0.04)
        s = Spark([0.0, 0.0, 0.0], [c * speed for c in d])
        s.fly(steps + 3 if burst is Burst.WILLOW else steps)
        out.append(library_call('streak', trail=s.trail[1:], color=color))
    return concat_shapes(*out)


@register()
def rocket_trail(height: float = 6.0, sway: float = 0.2, n: int = 9) -> Shape:
    pts = [(sway * math.sin(2.4 * i / n), height * i / n, 0.0) for i in range(n + 1)]
    return library_call('streak', trail=pts, color=(0.8, 0.6, 0.4), radius=0.02)


@register()
def sailboat(hull: tuple = (0.35, 0.2, 0.12)) -> Shape:
    body = primitive_call('cube', {'scale': (1.4, 0.25, 0.45)}, color=hull)
    mast = primitive_call('cylinder', {'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0, 1.6, 0)}, color=(0.3, 0.25, 0.2))

    def strip(i):
        w = 0.8 * (1 - i / 8)
        return transform_shape(primitive_call('cube', {'scale': (w, 0.15, 0.02)}, color=(0.75, 0.75, 0.85)), translation_matrix((0.05 + w / 2, 0.3 + 0.15 * i, 0)))

    return concat_shapes(body, mast, loop(8, strip))


@register()
def fireworks_night(seed: int = 2025) -> Shape:
    rng = Random(seed)
    show = [('peony', (1.0, 0.35, 0.3)), ('ring', (0.4, 0.8, 1.0)), ('willow', (1.0, 0.85, 0.4)), ('peony', (0.6, 1.0, 0.5))]
    sky = []
    for i, (kind, color) in enumerate(show):
        x = (i - (len(show) - 1) / 2) * 4.0
        h = rng.uniform(5.0, 7.5)
        burst = library_call('firework', kind=kind, color=color)
        sky.append(transform_shape(burst, translation_matrix((x + 0.2 * math.sin(2.4), h, -2))))
        sky.append(transform_shape(library_call('rocket_trail', height=h), translation_matrix((x, 0, -2))))
    boats = loop(3, lambda i: transform_shape(library_call('sailboat'), translation_matrix((4 * i - 4, 0.1, 2.0 - (i % 2)))))
    water = primitive_call('cube', {'scale': (20, 0.1, 9)}, color=(0.05, 0.1, 0.22))
    return concat_shapes(water, boats, *sky)
