"""
jellyfish with trailing tentacles, pulsing at different phases
"""
from helper import *
import math
import random
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count, takewhile, islice


@dataclass(slots=True)
class Spring:
    value: float = 0.0
    speed: float = 0.0
    stiffness: float = 4.0
    damping: float = 0.6

    def update(self, target: float, dt: float) -> float:
        self.speed += (self.stiffness * (target - self.value) - self.damping * self.speed) * dt
        self.value += self.speed * dt
        return self.value


def pulse(phase: float, dt: float = 0.15) -> Generator[float, None, None]:
    spring = Spring()
    for k in count():
        yield spring.update(math.sin(phase + k * dt), dt)


def smoothstep(edge0: float, edge1: float, x: float) -> float:
    t = min(max((x - edge0) / (edge1 - edge0), 0.0), 1.0)
    return t * t * (3 - 2 * t)


class Palette:
    def __init__(self, *stops: tuple[float, float, float]):
        self.stops = stops

    def __call__(self, t: float) -> tuple[float, float, float]:
        scaled = t * (len(self.stops) - 1)
        i = min(int(scaled), len(self.stops) - 2)
        f = scaled - i
        return tuple(a + (b - a) * f for a, b in zip(self.stops[i], self.stops[i + 1]))

    def __len__(self):
        return len(self.stops)


GLOW = Palette((0.9, 0.3, 0.6), (0.6, 0.4, 0.9), (0.3, 0.7, 0.95))


@register()
def bell(radius: float = 0.8, open_by: float = 0.0, layers: int = 7) -> Shape:
    rings = []
    for k in range(layers):
        t = k / (layers - 1)
        r = radius * math.sqrt(1 - (1 - t) ** 2 * 0.9) * (1 + open_by * t * 0.3)
        y = radius * (0.7 - 0.8 * t)
        rings.append(primitive_call('cylinder', color=GLOW(t), shape_kwargs={'radius': r, 'p0': (0, y, 0), 'p1': (0, y + radius * 0.12, 0)}))
    return concat_shapes(*rings)


@register()
def tentacle(phase: float = 0.0, length: float = 2.0, pieces: int = 10) -> Shape:
    sway = list(islice(pulse(phase), pieces + 1))
    ys = list(takewhile(lambda y: y <= length + 1e-9, (k * length / pieces for k in count())))
    parts = []
    for (x0, y0), (x1, y1), k in zip(zip(sway, ys), zip(sway[1:], ys[1:]), count()):
        thick = 0.06 * (1 - smoothstep(0, pieces, k) * 0.8)
        parts.append(primitive_call('cylinder', color=GLOW(k / pieces), shape_kwargs={'radius': thick, 'p0': (x0, -y0, 0), 'p1': (x1, -y1, 0)}))
    return concat_shapes(*parts)


@register()
def jellyfish(arms: int = 8, radius: float = 0.8, phase: float = 0.0) -> Shape:
    top = library_call('bell', radius=radius, open_by=math.sin(phase))
    trail = []
    for k in range(arms):
        a = math.tau * k / arms
        t = library_call('tentacle', phase=phase + k * 0.4)
        trail.append(transform_shape(t, translation_matrix((radius * 0.8 * math.cos(a), -0.1, radius * 0.8 * math.sin(a))) @ rotation_matrix(-a, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(top, *trail)


@register()
def bloom(n: int = 4) -> Shape:
    random.seed(2)
    swarm = []
    for k in range(n):
        x, y, z = (random.uniform(-3, 3) for _ in range(3))
        swarm.append(transform_shape(library_call('jellyfish', arms=5 + k, phase=k * 0.9), translation_matrix((x, y, z)) @ scale_matrix(0.7 + 0.15 * k, (0, 0, 0))))
    return concat_shapes(*swarm)
