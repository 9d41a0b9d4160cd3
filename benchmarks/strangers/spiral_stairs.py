# Spiral stairs without end: each step with its tread, its baluster and a piece of the rail; 2026-11-29.
from __future__ import annotations

from math import cos, radians, sin

from things import AT_HOME, Pose, Thing, count, product, translate, turn_y

TURN = radians(17)
RISE = 0.18


def on_rail(i: int) -> tuple[float, float, float]:
    return (1.1 * cos(i * TURN), 0.9 + i * RISE, -1.1 * sin(i * TURN))


def step(i: int) -> list[tuple[Thing, Pose]]:
    shade = 0.5 + 0.3 * sin(0.1 * i)
    pose = product(translate(0, i * RISE, 0), turn_y(i * TURN))
    tread = Thing("cube", scale=(1, 0.05, 0.35), color=(shade, 0.4, 0.2))
    baluster = Thing("cylinder", radius=0.015, p1=(0, 0.9, 0), color=(0.3, 0.3, 0.3))
    rail = Thing("cylinder", radius=0.03, p0=on_rail(i), p1=on_rail(i + 1), color=(0.6, 0.4, 0.2))
    return [
        (tread, product(pose, translate(0.6, 0, 0))),
        (baluster, product(pose, translate(1.1, 0, 0))),
        (rail, AT_HOME),
    ]


def run(steps: int = 5000) -> int:
    return count(Thing("stairs", [part for i in range(steps) for part in step(i)]))
