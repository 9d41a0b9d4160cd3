# Kepler's equation by bisection and by Newton's method (Meeus, "Astronomical algorithms", chapter 30); 2026-11-29.
from __future__ import annotations

from collections.abc import Callable
from math import cos, sin, tau

Curve = Callable[[float], float]


def bisect(f: Curve, a: float, b: float, steps: int = 40) -> float:
    below = f(a) < 0
    for _ in range(steps):
        middle = 0.5 * (a + b)
        if below == (f(middle) < 0):
            a = middle
        else:
            b = middle
    return 0.5 * (a + b)


def newton(f: Curve, slope: Curve, x: float) -> float:
    for _ in range(6):
        x -= f(x) / slope(x)
    return x


def anomaly(m: float, eccentricity: float) -> float:
    def f(x: float) -> float:
        return x - eccentricity * sin(x) - m

    def slope(x: float) -> float:
        return 1 - eccentricity * cos(x)

    return bisect(f, 0, tau) + newton(f, slope, m)


def run(moments: int = 250) -> float:
    return round(sum(anomaly(tau * (i / moments), 0.3) for i in range(moments)), 6)
