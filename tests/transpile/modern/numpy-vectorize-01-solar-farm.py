import numpy as np
from helper import *

"""
a solar farm: panels aim at the sun, shading found with vectorized functions
"""


@np.vectorize
def terrain(x: float, z: float) -> float:
    if x < 2:
        return 0.2 * x
    return 0.4 + 0.1 * np.sin(z)


def sun_direction(hour: float) -> np.ndarray:
    a = np.pi * (hour - 6) / 12
    d = np.array([np.cos(a), np.sin(a), 0.3])
    return d / np.linalg.norm(d)


efficiency = np.vectorize(lambda angle, dusty=False: max(0.0, np.cos(angle)) * (0.7 if dusty else 1.0), otypes=[float])


def look_matrix(direction: np.ndarray) -> np.ndarray:
    """A pose whose y axis points along the direction."""
    up = direction
    side = np.cross(up, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2] = side, up, np.cross(side, up)
    return pose


@register()
def solar_panel(direction: np.ndarray, output: float) -> Shape:
    blue = (0.05, 0.1 + 0.3 * output, 0.3 + 0.6 * output)
    plate = primitive_call('cube', color=blue, shape_kwargs={'scale': (0.9, 0.04, 0.6)})
    pole = primitive_call('cylinder', color=(0.6, 0.6, 0.6), shape_kwargs={'radius': 0.04, 'p0': (0, -0.6, 0), 'p1': (0, 0, 0)})
    return concat_shapes(pole, transform_shape(plate, look_matrix(direction)))


@register()
def solar_farm(rows: int = 5, cols: int = 6) -> Shape:
    xs, zs = np.meshgrid(np.arange(cols, dtype=float), np.arange(rows, dtype=float))
    ys = terrain(xs, zs)
    hours = np.linspace(8, 16, rows)
    shapes = []
    for r in range(rows):
        direction = sun_direction(hours[r])
        angles = np.arccos(np.clip(direction[1] - 0.1 * np.abs(xs[r] - cols / 2), -1, 1))
        outputs = efficiency(angles, dusty=r % 2 == 1)
        for x, y, z, out in np.column_stack((xs[r], ys[r], zs[r], outputs)):
            shapes.append(transform_shape(library_call('solar_panel', direction=direction, output=out), translation_matrix((1.2 * x, y + 0.6, 1.2 * z))))
    steps = np.floor(ys * 10).astype(int)
    levels, inverse = np.unique(steps, return_inverse=True)
    order = inverse.reshape(-1)[:cols]
    posts = [transform_shape(primitive_call('sphere', color=(0.9, 0.5, 0.1), shape_kwargs={'radius': 0.05 + 0.02 * o}), translation_matrix((1.2 * i, 0.1 * levels[o], -1))) for i, o in enumerate(order)]
    sun = transform_shape(primitive_call('sphere', color=(1, 0.9, 0.3), shape_kwargs={'radius': 0.8}), translation_matrix(sun_direction(10.5) * 10))
    return concat_shapes(*shapes, *posts, sun)
