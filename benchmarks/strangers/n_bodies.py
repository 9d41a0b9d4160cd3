# Planets on leapfrog steps, in the spirit of "nbody" of the Computer Language Benchmarks Game; 2026-11-29.
from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

Vector = tuple[float, float, float]


@dataclass(eq=False)
class Body:
    mass: float
    place: Vector
    speed: Vector


def start() -> list[Body]:
    return [
        Body(1000, (0, 0, 0), (0, 0, 0)),
        Body(1, (10, 0, 0), (0, 10, 0)),
        Body(2, (0, 20, 1), (-7, 0, 0)),
        Body(0.5, (-30, 0, 2), (0, -6, 0.2)),
        Body(3, (0, -45, -1), (4.7, 0, 0)),
    ]


def step(bodies: list[Body], dt: float) -> None:
    for b in bodies:
        x, y, z = b.place
        u, v, w = b.speed
        for other in bodies:
            if other is not b:
                p, q, r = other.place
                a, c, d = p - x, q - y, r - z
                length = sqrt(a * a + c * c + d * d)
                k = other.mass / (length * length * length)
                u, v, w = u + dt * (k * a), v + dt * (k * c), w + dt * (k * d)
        b.speed = (u, v, w)
    for b in bodies:
        b.place = tuple(x + dt * s for x, s in zip(b.place, b.speed))


def run(steps: int = 300) -> float:
    bodies = start()
    for _ in range(steps):
        step(bodies, 0.01)
    return round(sum(0.5 * b.mass * sum(s * s for s in b.speed) for b in bodies), 6)
