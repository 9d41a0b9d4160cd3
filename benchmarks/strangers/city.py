# A city on a grid: lots with towers of random heights, houses with roofs, and parks; 2026-11-29.
from __future__ import annotations

from collections.abc import Callable
from math import floor, hypot

import numpy as np
from things import AT_HOME, Pose, Thing, count, translate

Draw = Callable[..., float]
Parts = list[tuple[Thing, Pose]]


def tower(height: float, uniform: Draw) -> Parts:
    body = Thing("cube", scale=(0.8, height, 0.8), color=(0.6, 0.6, uniform(0.6, 0.9)))
    parts = [(body, translate(0, height / 2, 0))]
    for k in range(1, floor(height), 2):
        parts.append((Thing("cube", scale=(0.84, 0.1, 0.84), color=(0.2, 0.2, 0.3)), translate(0, k, 0)))
    return parts


def house(uniform: Draw) -> Parts:
    wall = (uniform(0.6, 1), uniform(0.6, 1), 0.6)
    return [
        (Thing("cube", scale=(0.6, 0.5, 0.6), color=wall), translate(0, 0.25, 0)),
        (Thing("cone", radius=0.5, p1=(0, 0.4, 0), color=(0.6, 0.2, 0.1)), translate(0, 0.5, 0)),
    ]


def park(uniform: Draw) -> Parts:
    tree = Thing("sphere", radius=0.2, color=(0.1, 0.5, 0.1))
    return [
        (Thing("cube", scale=(0.9, 0.02, 0.9), color=(0.2, 0.6, 0.2)), AT_HOME),
        (tree, translate(uniform(-0.2, 0.2), 0.3, uniform(-0.2, 0.2))),
    ]


def lot(x: int, z: int, middle: float, uniform: Draw) -> Thing:
    height = uniform(0.5, 1.5) * max(1, 8 - 0.3 * hypot(x - middle, z - middle))
    if uniform() < 0.1:
        parts = park(uniform)
    else:
        parts = tower(height, uniform) if height > 2 else house(uniform)
    return Thing("lot", parts, x=x, z=z)


def run(side: int = 100) -> int:
    uniform = np.random.RandomState(0).uniform
    lots = [(lot(x, z, side / 2, uniform), translate(x, 0, z)) for x in range(side) for z in range(side)]
    return count(Thing("city", lots))
