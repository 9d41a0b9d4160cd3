import numpy as np
from helper import *

"""
a lunar surface: boolean masks carve craters in a height grid
"""

N = 14


def surface() -> np.ndarray:
    return np.full((N, N), 1.0)


def carve(height: np.ndarray, center: tuple, radius: float) -> int:
    """Changes the grid in place; gives the number of carved cells."""
    zz, xx = np.indices(height.shape)
    distance = np.sqrt((xx - center[0]) ** 2 + (zz - center[1]) ** 2)
    inside = distance < radius
    rim = (distance >= radius) & (distance < radius + 1)
    height[inside] -= 0.5 * (1 - distance[inside] / radius)
    height[rim & ~(height < 0.9)] += 0.2
    return int(inside.sum())


@register()
def cell(height: float, level: int) -> Shape:
    gray = (0.35, 0.5, 0.65, 0.8)[level]
    return transform_shape(primitive_call('cube', color=(gray, gray, gray * 0.95), shape_kwargs={'scale': (1, height, 1)}), translation_matrix((0, height / 2, 0)))


@register()
def moon() -> Shape:
    height = surface()
    carved = [carve(height, *spec) for spec in (((4, 4), 3.2), ((10, 8), 2.5), ((3, 11), 1.6))]
    levels = np.digitize(height, [0.7, 0.95, 1.1])
    edge = np.zeros_like(height, dtype=bool)
    edge[[0, -1], :] = True
    edge[:, [0, -1]] = True
    height = np.where(edge, 0.5, height)
    keep = ~edge | (levels > 1)
    shapes = []
    for z, x in np.argwhere(keep):
        shapes.append(transform_shape(library_call('cell', height=height[z, x], level=int(levels[z, x])), translation_matrix((x, 0, z))))
    deepest = np.unravel_index(np.argmin(height), height.shape)
    flag_z, flag_x = (int(v) for v in deepest)
    pole = primitive_call('cylinder', color=(0.8, 0.8, 0.8), shape_kwargs={'radius': 0.08, 'p0': (flag_x, 0.5, flag_z), 'p1': (flag_x, 3, flag_z)})
    banner = primitive_call('cube', color=(0.1, 0.3, 0.8), shape_kwargs={'scale': (0.05 * carved[0], 0.6, 0.05)})
    rocks = np.where((height > 1.1).any(axis=0), height.max(axis=0), 0)
    stones = [transform_shape(primitive_call('sphere', color=(0.4, 0.4, 0.42), shape_kwargs={'radius': 0.2 * r}), translation_matrix((i, 1.5, -1))) for i, r in enumerate(rocks) if r]
    count = np.count_nonzero(np.isclose(height, 1.0))
    base = primitive_call('cube', color=(0.2, 0.2, 0.2), shape_kwargs={'scale': (N, 0.01 * count, N)})
    return concat_shapes(*shapes, pole, transform_shape(banner, translation_matrix((flag_x + 0.5, 2.7, flag_z))), *stones, transform_shape(base, translation_matrix((N / 2 - 0.5, -0.5, N / 2 - 0.5))))
