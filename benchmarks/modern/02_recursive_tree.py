"""a fractal tree with autumn leaves"""
from helper import *
import math
import random
from typing import NamedTuple
import numpy as np


class Branch(NamedTuple):
    start: np.ndarray
    end: np.ndarray
    radius: float
    depth: int


def grow(start, direction, length, radius, depth, rng):
    """Yield branches recursively."""
    end = start + direction * length
    yield Branch(start, end, radius, depth)
    if depth == 0:
        return
    n_children = rng.choice([2, 3])
    azimuth = rng.uniform(0, 2 * math.pi)
    for k in range(n_children):
        phi = azimuth + 2 * math.pi * k / n_children + rng.uniform(-0.3, 0.3)
        tilt = rng.uniform(0.35, 0.7)
        helper_axis = np.array([1.0, 0, 0]) if abs(direction[0]) < 0.9 else np.array([0, 0, 1.0])
        u = np.cross(direction, helper_axis)
        u /= np.linalg.norm(u)
        v = np.cross(direction, u)
        new_dir = math.cos(tilt) * direction + math.sin(tilt) * (math.cos(phi) * u + math.sin(phi) * v)
        yield from grow(end, new_dir, length * rng.uniform(0.7, 0.82), radius * 0.65, depth - 1, rng)


@register()
def limb(branch: Branch, bark=(0.36, 0.24, 0.14)) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': branch.radius, 'p0': branch.start, 'p1': branch.end}, color=bark)


@register()
def leaf_cluster(center, size: float, hue: float) -> Shape:
    color = (0.75 + 0.2 * hue, 0.25 + 0.4 * hue, 0.08)
    ball = primitive_call('sphere', shape_kwargs={'radius': size}, color=color)
    return transform_shape(ball, translation_matrix(center))


@register()
def tree(seed: int = 7, depth: int = 5) -> Shape:
    rng = random.Random(seed)
    up = np.array([0.0, 1.0, 0.0])
    out = []
    for b in grow(np.zeros(3), up, 1.2, 0.16, depth, rng):
        out.append(library_call('limb', branch=b))
        if b.depth == 0:
            out.append(library_call('leaf_cluster', center=b.end, size=rng.uniform(0.1, 0.2), hue=rng.random()))
    return concat_shapes(*out)


@register()
def tree_scene() -> Shape:
    ground = primitive_call('cylinder', shape_kwargs={'radius': 3.0, 'p0': (0, -0.1, 0), 'p1': (0, 0, 0)}, color=(0.4, 0.5, 0.25))
    return concat_shapes(ground, library_call('tree', seed=11))
