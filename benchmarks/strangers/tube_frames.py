# Rotation-minimising frames along a curve by double reflection (Wang, Juettler, Zheng and Liu 2008); 2026-11-29.
from __future__ import annotations

from math import cos, sin, sqrt, tau

Vector = tuple[float, float, float]


def curve(t: float) -> Vector:
    return ((2 + cos(3 * t)) * cos(2 * t), (2 + cos(3 * t)) * sin(2 * t), sin(3 * t))


def minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def times(k: float, v: Vector) -> Vector:
    return (k * v[0], k * v[1], k * v[2])


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalize(v: Vector) -> Vector:
    return times(1 / sqrt(dot(v, v)), v)


def tangent(t: float) -> Vector:
    return normalize(minus(curve(t + 1e-4), curve(t - 1e-4)))


def reflected(v: Vector, axis: Vector) -> Vector:
    return minus(v, times(2 * dot(axis, v) / dot(axis, axis), axis))


def run(steps: int = 2000) -> float:
    dt = tau / steps
    x = curve(0)
    t = tangent(0)
    r = normalize(cross(t, (0.0, 0.0, 1.0)))
    total = 0.0
    for i in range(1, steps + 1):
        x2, t2 = curve(i * dt), tangent(i * dt)
        v1 = minus(x2, x)
        r2 = reflected(reflected(r, v1), minus(t2, reflected(t, v1)))
        total += 0.01 * cross(t2, r2)[2]
        x, t, r = x2, t2, r2
    return round(total + r[0], 6)
