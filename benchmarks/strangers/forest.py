# A forest of fir trees and oaks of many ages, with parameters for each tree; 2026-11-29.
from __future__ import annotations

from collections.abc import Callable
from math import tau

import numpy as np
from things import AT_HOME, Pose, Thing, count, product, translate, turn_y


def fir(height: float, green: float = 0.5, layers: int = 3) -> Thing:
    parts = [(Thing("cylinder", radius=0.05 * height, p1=(0, 0.3 * height, 0), color=(0.35, 0.22, 0.1)), AT_HOME)]
    for i in range(layers):
        radius = height * (0.35 - 0.08 * i)
        cone = Thing("cone", radius=radius, p1=(0, 0.4 * height, 0), color=(0.1, green, 0.2))
        parts.append((cone, translate(0, height * (0.2 + 0.22 * i), 0)))
    return Thing("fir", parts, height=height, green=green, layers=layers)


def oak(height: float, green: float = 0.5) -> Thing:
    trunk = Thing("cylinder", radius=0.08 * height, p1=(0, 0.6 * height, 0), color=(0.4, 0.3, 0.15))
    crown = Thing("sphere", radius=0.35 * height, color=(0.2, green, 0.1))
    return Thing("oak", [(trunk, AT_HOME), (crown, translate(0, 0.75 * height, 0))], height=height, green=green)


def tree_at(i: int, j: int, uniform: Callable[..., float]) -> tuple[Thing, Pose]:
    height = uniform(1, 4)
    green = uniform(0.3, 0.7)
    place = translate(i + uniform(-0.3, 0.3), 0, j + uniform(-0.3, 0.3))
    spin = turn_y(uniform(0, tau))
    tree = fir(height, green, 4 if height > 3 else 3) if uniform() < 0.6 else oak(height, green)
    return tree, product(place, spin)


def run(side: int = 70) -> int:
    uniform = np.random.RandomState(0).uniform
    return count(Thing("forest", [tree_at(i, j, uniform) for i in range(side) for j in range(side)]))
