# The convex hull of seeded points in the plane by Andrew's monotone chain (1979), and its area; 2026-11-29.
from __future__ import annotations

from collections.abc import Iterable
from math import cos, sin, sqrt, tau

import numpy as np

Point = tuple[float, float]


def make_points(n: int) -> list[Point]:
    source = np.random.RandomState(11)
    points = []
    for _ in range(n):
        angle = source.uniform(0, tau)
        radius = sqrt(source.uniform())
        points.append((radius * cos(angle), radius * sin(angle)))
    return points


def turn(a: Point, b: Point, p: Point) -> float:
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def chain(points: Iterable[Point]) -> list[Point]:
    out: list[Point] = []
    for p in points:
        while len(out) >= 2 and turn(out[-2], out[-1], p) <= 0:
            out.pop()
        out.append(p)
    return out[:-1]


def run(size: int = 4000) -> float:
    points = sorted(make_points(size))
    corners = chain(points) + chain(reversed(points))
    area = sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(corners, corners[1:] + corners[:1]))
    return round(0.5 * area, 6)
