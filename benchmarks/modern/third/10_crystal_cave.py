"""
a cave floor with clusters of quartz crystals
"""
from helper import *
import numpy as np
import math
from functools import lru_cache
from typing import TypeAlias

Vec: TypeAlias = tuple[float, float, float]


def normalize(v: np.ndarray) -> np.ndarray:
    n = np.linalg.norm(v)
    return v if n == 0 else v / n


def fibonacci_dome(n: int) -> np.ndarray:
    i = np.arange(n) + 0.5
    phi = np.arccos(1 - i / n)
    theta = np.pi * (1 + 5 ** 0.5) * i
    return np.stack([np.cos(theta) * np.sin(phi), np.cos(phi), np.sin(theta) * np.sin(phi)], axis=1)


@lru_cache(maxsize=None)
def hue(k: int) -> Vec:
    h = (k * 0.618) % 1.0
    sector, f = divmod(h * 6, 1)
    p, q, t = 0.6, 1 - 0.4 * f, 0.6 + 0.4 * f
    return [(1.0, t, p), (q, 1.0, p), (p, 1.0, t), (p, q, 1.0), (t, p, 1.0), (1.0, p, q)][int(sector)]


@register()
def crystal(length: float = 1.0, radius: float = 0.12, color: tuple = (0.8, 0.7, 0.95)) -> Shape:
    steps = 4
    body = primitive_call('cylinder', color=color, shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, length * 0.75, 0)})
    tip = [primitive_call('cylinder', color=color, shape_kwargs={'radius': radius * (1 - (s + 1) / (steps + 1)), 'p0': (0, length * (0.75 + 0.25 * s / steps), 0), 'p1': (0, length * (0.75 + 0.25 * (s + 1) / steps), 0)}) for s in range(steps)]
    return concat_shapes(body, *tip)


@register()
def cluster(count: int = 9, size: float = 1.0, seed: int = 1) -> Shape:
    rng = np.random.RandomState(seed)
    directions = fibonacci_dome(count)
    lengths = size * (0.6 + 0.6 * rng.rand(count))
    up = np.array([0.0, 1.0, 0.0])
    spikes = []
    for k, (d, length) in enumerate(zip(directions, lengths)):
        d = normalize(d)
        axis = np.cross(up, d)
        angle = math.acos(float(np.clip(d @ up, -1, 1)))
        spike = library_call('crystal', length=float(length), color=hue(seed + k % 3))
        if np.linalg.norm(axis) > 1e-9:
            spike = transform_shape(spike, rotation_matrix(angle, tuple(axis), (0, 0, 0)))
        spikes.append(spike)
    return concat_shapes(*spikes)


@register()
def cave_floor() -> Shape:
    floor = transform_shape(primitive_call('cube', color=(0.3, 0.28, 0.3), shape_kwargs={'scale': (9, 0.3, 9)}), translation_matrix((0, -0.15, 0)))
    places = [(-2.5, -2, 1.4), (1.8, -1.2, 1.0), (0.2, 2.2, 1.8), (3, 2.4, 0.8)]
    groups = [transform_shape(library_call('cluster', count=6 + 2 * i, size=s, seed=i), translation_matrix((x, 0, z))) for i, (x, z, s) in enumerate(places)]
    return concat_shapes(floor, *groups)
