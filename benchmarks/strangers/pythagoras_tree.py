# Pythagoras' tree of cubes (Bosman 1942), each with its own color, so that no two branches are equal; 2026-11-29.
from __future__ import annotations

from math import pi, sqrt

from things import Thing, count, product, scale, translate, turn_z


def square(level: int, hue: int) -> Thing:
    cube = Thing("cube", color=(hue % 256 / 256, hue % 17 / 17, level / 20))
    parts = [(cube, translate(0, 0.5, 0))]
    if level > 0:
        k = sqrt(0.5)
        left = product(product(translate(-0.25, 1.25, 0), turn_z(pi / 4)), scale(k, k, k))
        right = product(product(translate(0.25, 1.25, 0), turn_z(pi / -4)), scale(k, k, k))
        parts.append((square(level - 1, 2 * hue), left))
        parts.append((square(level - 1, 2 * hue + 1), right))
    return Thing("square", parts, level=level, hue=hue)


def run(levels: int = 13) -> int:
    return count(square(levels, 1))
