"""
a tiled wave pool, its water surface computed with numpy broadcasting
"""
from helper import *
import numpy as np

SOURCES = np.array([[0.0, 0.0], [3.0, 4.0], [-4.0, 2.0]])
AMPLITUDES = np.array([0.3, 0.2, 0.25])


def surface(n: int = 14, extent: float = 5.0):
    axis = np.linspace(-extent, extent, n)
    gx, gz = np.meshgrid(axis, axis, indexing='ij')
    points = np.stack([gx, gz], axis=-1)
    delta = points[:, :, None, :] - SOURCES[None, None, :, :]
    r = np.linalg.norm(delta, axis=-1)
    height = (AMPLITUDES * np.cos(2.0 * r) / (1.0 + 0.3 * r)).sum(axis=-1)
    return gx, gz, height


def shade(h: np.ndarray) -> np.ndarray:
    lo, hi = h.min(), h.max()
    t = ((h - lo) / (hi - lo))[..., np.newaxis]
    deep, light = np.array([0.05, 0.2, 0.5]), np.array([0.6, 0.85, 0.95])
    return deep * (1 - t) + light * t


@register()
def water(n: int = 14, extent: float = 5.0) -> Shape:
    gx, gz, h = surface(n, extent)
    colors = shade(h)
    side = 2 * extent / (n - 1)
    columns = []
    for i in range(n):
        for j in range(n):
            tall = 1.0 + h[i, j]
            column = primitive_call('cube', color=tuple(colors[i, j]), shape_kwargs={'scale': (side, tall, side)})
            columns.append(transform_shape(column, translation_matrix((gx[i, j], tall / 2, gz[i, j]))))
    return concat_shapes(*columns)


@register()
def rim(extent: float = 5.6, height: float = 1.5, width: float = 0.4) -> Shape:
    sides = []
    for angle in np.arange(4) * np.pi / 2:
        wall = primitive_call('cube', color=(0.85, 0.85, 0.82), shape_kwargs={'scale': (2 * extent + width, height, width)})
        wall = transform_shape(wall, translation_matrix((0, height / 2, extent)))
        sides.append(transform_shape(wall, rotation_matrix(float(angle), (0, 1, 0), (0, 0, 0))))
    return concat_shapes(*sides)


@register()
def buoys(count: int = 7, radius: float = 3.5) -> Shape:
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
    ring = np.column_stack([radius * np.cos(angles), np.full(count, 1.4), radius * np.sin(angles)])
    return concat_shapes(*(transform_shape(primitive_call('sphere', color=(0.95, 0.4, 0.1), shape_kwargs={'radius': 0.2}), translation_matrix(p)) for p in ring))


@register()
def wave_pool() -> Shape:
    return concat_shapes(library_call('rim'), library_call('water', n=12), library_call('buoys'))
