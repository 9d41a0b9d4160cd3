# A scene in plain Python: what the scene programs make, for the measure of what the language costs; 2026-11-29.
from __future__ import annotations

from collections.abc import Iterable
from math import cos, sin
from typing import Any

# The first three rows of a 4 x 4 matrix for column vectors, row by row.
Pose = tuple[float, float, float, float, float, float, float, float, float, float, float, float]

AT_HOME: Pose = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)


class Thing:
    """A word with attributes, and what it is made of: things at their poses."""

    def __init__(self, word: str, children: Iterable[tuple[Thing, Pose]] = (), **attributes: Any) -> None:
        self.word = word
        self.attributes = attributes
        self.children = list(children)


def count(thing: Thing) -> int:
    """The number of primitives, things without parts."""
    return sum(count(child) for child, _ in thing.children) if thing.children else 1


def translate(x: float, y: float, z: float) -> Pose:
    return (1.0, 0.0, 0.0, float(x), 0.0, 1.0, 0.0, float(y), 0.0, 0.0, 1.0, float(z))


def scale(x: float, y: float, z: float) -> Pose:
    return (float(x), 0.0, 0.0, 0.0, 0.0, float(y), 0.0, 0.0, 0.0, 0.0, float(z), 0.0)


def turn_x(angle: float) -> Pose:
    c, s = cos(angle), sin(angle)
    return (1.0, 0.0, 0.0, 0.0, 0.0, c, -s, 0.0, 0.0, s, c, 0.0)


def turn_y(angle: float) -> Pose:
    c, s = cos(angle), sin(angle)
    return (c, 0.0, s, 0.0, 0.0, 1.0, 0.0, 0.0, -s, 0.0, c, 0.0)


def turn_z(angle: float) -> Pose:
    c, s = cos(angle), sin(angle)
    return (c, -s, 0.0, 0.0, s, c, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)


def product(p: Pose, q: Pose) -> Pose:
    """The pose that applies ``q`` first."""
    a, b, c, d, e, f, g, h, i, j, k, m = p
    r, s, t, u, v, w, x, y, z, o, n, l = q  # noqa: E741
    return (
        a * r + b * v + c * z, a * s + b * w + c * o, a * t + b * x + c * n, a * u + b * y + c * l + d,
        e * r + f * v + g * z, e * s + f * w + g * o, e * t + f * x + g * n, e * u + f * y + g * l + h,
        i * r + j * v + k * z, i * s + j * w + k * o, i * t + j * x + k * n, i * u + j * y + k * l + m,
    )  # fmt: skip
