"""
fireworks whose particles follow gravity and drag
"""
from helper import *
import math
import random
from dataclasses import dataclass
from typing import Iterator


@dataclass(slots=True)
class Vec3:
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    def __add__(self, o: 'Vec3') -> 'Vec3':
        return Vec3(self.x + o.x, self.y + o.y, self.z + o.z)

    def __sub__(self, o: 'Vec3') -> 'Vec3':
        return self + o * -1

    def __mul__(self, k: float) -> 'Vec3':
        return Vec3(self.x * k, self.y * k, self.z * k)

    __rmul__ = __mul__

    def __iter__(self) -> Iterator[float]:
        yield from (self.x, self.y, self.z)

    @property
    def length(self) -> float:
        return math.sqrt(self.x ** 2 + self.y ** 2 + self.z ** 2)

    def normalized(self) -> 'Vec3':
        n = self.length
        return self * (1 / n) if n else Vec3()


GRAVITY = Vec3(0, -1.5, 0)


@dataclass
class Particle:
    position: Vec3
    velocity: Vec3
    age: float = 0.0

    def advance(self, dt: float) -> None:
        drag = self.velocity * (-0.6 * self.velocity.length)
        self.velocity = self.velocity + (GRAVITY + drag) * dt
        self.position = self.position + self.velocity * dt
        self.age += dt


def burst(center: Vec3, n: int, speed: float) -> list[Particle]:
    out = []
    for _ in range(n):
        direction = Vec3(random.gauss(0, 1), random.gauss(0, 1), random.gauss(0, 1)).normalized()
        out.append(Particle(center, speed * direction))
    return out


@register()
def spark(color, radius: float = 0.06) -> Shape:
    return primitive_call('sphere', color=color, shape_kwargs={'radius': radius})


@register()
def firework(color, height: float = 5.0, n: int = 18, seed: int = 1) -> Shape:
    random.seed(seed)
    particles = burst(Vec3(0, height, 0), n, 3.0)
    shapes = [primitive_call('cylinder', color=(0.5, 0.5, 0.5), shape_kwargs={'radius': 0.02, 'p0': (0, 0, 0), 'p1': (0, height, 0)})]
    for frame in range(8):
        for p in particles:
            p.advance(0.1)
            fade = 1 - frame / 10
            shapes.append(transform_shape(library_call('spark', color=tuple(c * fade for c in color), radius=0.03 + 0.05 * fade), translation_matrix(tuple(p.position))))
    return concat_shapes(*shapes)


@register()
def show() -> Shape:
    return concat_shapes(
        library_call('firework', color=(1.0, 0.3, 0.2), seed=3),
        transform_shape(library_call('firework', color=(0.3, 0.6, 1.0), height=6.5, n=12, seed=5), translation_matrix((4, 0, 1))))
