import numpy as np
from helper import *

"""
a pebble mosaic: nearest seeds color each pebble
"""


def relax(points: np.ndarray, rounds: int = 4, push: float = 0.05) -> np.ndarray:
    """Push points away from each other."""
    points = points.copy()
    for _ in range(rounds):
        delta = points[:, None, :] - points[None, :, :]
        distance = np.sqrt((delta ** 2).sum(axis=-1))
        np.fill_diagonal(distance, np.inf)
        force = (delta / distance[..., None] ** 2).sum(axis=1)
        norm = np.linalg.norm(force, axis=1, keepdims=True)
        points += push * force / np.maximum(norm, 1e-9)
    return points


def nearest(points: np.ndarray, seeds: np.ndarray) -> np.ndarray:
    return np.argmin(np.linalg.norm(points[:, np.newaxis] - seeds, axis=2), axis=1)


@register()
def pebble(radius: float, color: tuple) -> Shape:
    stone = primitive_call('sphere', color=color, shape_kwargs={'radius': radius})
    return transform_shape(stone, scale_matrix((1, 0.5, 1), (0, 0, 0)))


@register()
def mosaic(n: int = 120, regions: int = 5) -> Shape:
    rng = np.random.default_rng(seed=5)
    points = relax(rng.random((n, 2)) * 6 - 3)
    seeds = rng.uniform(-3, 3, size=(regions, 2))
    colors = rng.random((regions, 3)) * 0.6 + 0.3
    label = nearest(points, seeds)
    sizes = np.bincount(label, minlength=regions)
    largest = int(np.argmax(sizes))
    shapes = []
    for (x, z), k in zip(points, label):
        shade = rng.uniform(0.85, 1.15)
        radius = 0.14 if k == largest else 0.11 + 0.03 * rng.beta(2, 2)
        shapes.append(transform_shape(library_call('pebble', radius=radius, color=tuple(np.minimum(colors[k] * shade, 1))), translation_matrix((x, 0.05, z))))
    for k, (x, z) in enumerate(seeds):
        shapes.append(primitive_call('cylinder', color=tuple(colors[k]), shape_kwargs={'radius': 0.05, 'p0': (x, 0, z), 'p1': (x, 0.02 * sizes[k] + 0.1, z)}))
    order = rng.permutation(regions)
    frame = [transform_shape(primitive_call('cube', color=tuple(colors[order[i]]), shape_kwargs={'scale': (6.8, 0.2, 0.2)}), rotation_matrix(i * np.pi / 2, (0, 1, 0), (0, 0, 0)) @ translation_matrix((0, 0.1, 3.4))) for i in range(4)]
    return concat_shapes(*shapes, *frame)
