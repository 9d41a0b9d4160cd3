import random
import math
from contextlib import contextmanager
from helper import *

"""
fireflies that fall into step with each other (coupled oscillators)
"""

class Firefly:
    population: list = []

    def __init__(self):
        self.phase = random.uniform(0, 2 * math.pi)
        self.frequency = random.gauss(1.0, 0.05)
        self.home = tuple(random.uniform(-1.5, 1.5) for _ in range(3))
        Firefly.population.append(self)

    def __lt__(self, other):
        return self.phase < other.phase

    @property
    def glow(self) -> float:
        return max(0.0, math.cos(self.phase)) ** 2

    @classmethod
    def coupling(cls) -> tuple[float, float]:
        n = len(cls.population)
        return sum(math.cos(f.phase) for f in cls.population) / n, sum(math.sin(f.phase) for f in cls.population) / n

    @staticmethod
    def order() -> float:
        return math.hypot(*Firefly.coupling())

    def advance(self, strength: float, dt: float, mean: tuple) -> None:
        c, s = mean
        self.phase += dt * (self.frequency + strength * (s * math.cos(self.phase) - c * math.sin(self.phase)))
        self.phase %= 2 * math.pi

@contextmanager
def fresh_population(n: int):
    Firefly.population.clear()
    for _ in range(n):
        Firefly()
    try:
        yield Firefly.population
    finally:
        Firefly.population.clear()

@register()
def firefly(glow: float) -> Shape:
    color = (0.3 + 0.7 * glow, 0.3 + 0.6 * glow, 0.1)
    return primitive_call('sphere', color=color, shape_kwargs={'radius': 0.05 + 0.08 * glow})

@register()
def jar(order: float) -> Shape:
    rims = [primitive_call('cylinder', color=(0.7, 0.8, 0.85), shape_kwargs={'radius': r, 'p0': (0, y, 0), 'p1': (0, y + 0.1, 0)}) for r, y in ((2.0, -2.1), (1.2, 2.0))]
    gauge = primitive_call('cylinder', color=(0.9, 0.6, 0.1), shape_kwargs={'radius': 0.1, 'p0': (2.5, -2, 0), 'p1': (2.5, -2 + 4 * order, 0)})
    return concat_shapes(*rims, gauge)

@register_animation()
def synchronising_fireflies() -> Generator[Shape, None, None]:
    with fresh_population(20) as flies:
        for frame in range(30):
            mean = Firefly.coupling()
            for fly in flies:
                fly.advance(1.5, 0.4, mean)
            wobble = lambda fly: tuple(h + 0.1 * math.sin(frame + 3 * i) for i, h in enumerate(fly.home))
            lights = [transform_shape(library_call('firefly', glow=f.glow), translation_matrix(wobble(f))) for f in sorted(flies)]
            yield concat_shapes(library_call('jar', order=Firefly.order()), *lights)
