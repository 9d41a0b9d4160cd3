"""a pendulum wave machine with fifteen swinging balls"""
from helper import *
import numpy as np

G = 9.81
N = 15
PERIOD = 30.0  # seconds for the full cycle


def lengths(n: int = N, first: int = 20) -> np.ndarray:
    """Pendulum k makes (first + k) oscillations per cycle."""
    freq = (first + np.arange(n)) / PERIOD
    return G / (2 * np.pi * freq) ** 2


def integrate(length: np.ndarray, theta0: float, t_end: float, dt: float = 2e-3) -> np.ndarray:
    """Semi-implicit Euler for all pendulums at once."""
    theta = np.full_like(length, theta0)
    omega = np.zeros_like(length)
    for _ in range(round(t_end / dt)):
        omega -= dt * G / length * np.sin(theta)
        theta += dt * omega
    return theta


@register()
def pendulum(length: float, theta: float, hue: float, top: float = 1.0) -> Shape:
    bob = np.array([0, top, 0]) + length * np.array([0, -np.cos(theta), np.sin(theta)])
    rgb = 0.5 + 0.5 * np.cos(2 * np.pi * (hue + np.array([0, 1 / 3, 2 / 3])))
    strings = [primitive_call('cylinder', shape_kwargs={'radius': 0.004, 'p0': (dx, top, 0), 'p1': bob}, color=(0.9, 0.9, 0.9)) for dx in (-0.03, 0.03)]
    ball = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.035}, color=tuple(rgb.clip(0, 1))), translation_matrix(bob))
    return concat_shapes(*strings, ball)


@register()
def stand(width: float, height: float = 1.0, depth: float = 0.5) -> Shape:
    wood = (0.45, 0.3, 0.18)
    beam = transform_shape(primitive_call('cube', shape_kwargs={'scale': (width, 0.05, 0.05)}, color=wood), translation_matrix((0, height + 0.02, 0)))
    legs = [primitive_call('cylinder', shape_kwargs={'radius': 0.025, 'p0': (sx * width / 2, height, 0), 'p1': (sx * width / 2, 0, sz * depth)}, color=wood)
            for sx in (-1, 1) for sz in (-1, 1)]
    return concat_shapes(beam, *legs)


@register()
def pendulum_wave(t: float = 4.0, theta0: float = 0.45, gap: float = 0.1) -> Shape:
    L = lengths()
    theta = integrate(L, theta0, t)
    if not np.all(np.abs(theta) <= theta0 * 1.05):
        raise ArithmeticError("integration unstable")
    x = (np.arange(N) - (N - 1) / 2) * gap
    balls = [
        transform_shape(library_call('pendulum', length=float(l), theta=float(th), hue=i / N), translation_matrix((xi, 0, 0)))
        for i, (l, th, xi) in enumerate(zip(L, theta, x))
    ]
    return concat_shapes(library_call('stand', width=gap * (N + 1)), *balls)
