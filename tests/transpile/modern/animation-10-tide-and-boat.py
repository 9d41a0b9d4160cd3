import numpy as np
from functools import partial
from helper import *

"""
a boat rides on a sum of waves
"""


class WaveField:
    """Sum of plane waves; the arrays have one entry for each wave."""

    def __init__(self, amplitudes, wavelengths, directions, speeds):
        self.a = np.asarray(amplitudes)
        self.k = 2 * np.pi / np.asarray(wavelengths)
        angles = np.deg2rad(directions)
        self.d = np.stack([np.cos(angles), np.sin(angles)])
        self.w = np.asarray(speeds)

    def height(self, x, z, t):
        x, z = np.asarray(x, float)[..., None], np.asarray(z, float)[..., None]
        phase = self.k * (x * self.d[0] + z * self.d[1]) - self.w * t
        return (self.a * np.sin(phase)).sum(axis=-1)

    def slope(self, x, z, t, eps=1e-3):
        h = partial(self.height, t=t)
        return (h(x + eps, z) - h(x - eps, z)) / (2 * eps), (h(x, z + eps) - h(x, z - eps)) / (2 * eps)


SEA = WaveField([0.25, 0.12, 0.06], [4.0, 2.5, 1.3], [20, 80, -35], [1.0, 1.7, 2.3])


@register()
def sea(t: float, n: int = 12) -> Shape:
    axis = np.linspace(-3, 3, n)
    x, z = np.meshgrid(axis, axis, indexing="ij")
    y = SEA.height(x, z, t)
    pitch = axis[1] - axis[0]
    foam = y > np.quantile(y, 0.9)
    shapes = []
    for index, h in np.ndenumerate(y):
        color = (0.85, 0.95, 1.0) if foam[index] else (0.1, 0.3 + 0.4 * float(h), 0.6)
        column = primitive_call('cube', color=color, shape_kwargs={'scale': (pitch, 0.3, pitch)})
        shapes.append(transform_shape(column, translation_matrix((x[index], h, z[index]))))
    return concat_shapes(*shapes)


@register()
def boat() -> Shape:
    hull = transform_shape(primitive_call('sphere', color=(0.7, 0.2, 0.15), shape_kwargs={'radius': 0.5}), scale_matrix((1.6, 0.5, 0.7), (0, 0, 0)))
    mast = primitive_call('cylinder', color=(0.5, 0.35, 0.2), shape_kwargs={'radius': 0.04, 'p0': (0, 0, 0), 'p1': (0, 1.4, 0)})
    sail = transform_shape(primitive_call('cube', color=(0.95, 0.95, 0.9), shape_kwargs={'scale': (0.7, 0.9, 0.03)}), translation_matrix((-0.35, 0.8, 0)))
    return concat_shapes(hull, mast, sail)


@register_animation()
def boat_on_waves() -> Generator[Shape, None, None]:
    for t in np.arange(0, 2 * np.pi, np.pi / 6):
        x, z = 1.5 * np.cos(t / 2), 0.5 * np.sin(t)
        sx, sz = SEA.slope(x, z, t)
        tilt = rotation_matrix(np.arctan(sx), (0, 0, 1), (0, 0, 0)) @ rotation_matrix(-np.arctan(sz), (1, 0, 0), (0, 0, 0))
        ship = transform_shape(library_call('boat'), translation_matrix((x, SEA.height(x, z, t) + 0.3, z)) @ tilt)
        yield concat_shapes(library_call('sea', t=t), ship)
