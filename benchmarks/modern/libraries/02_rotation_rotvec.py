"""
a satellite whose panels turn about an axis
"""
from helper import *
import numpy as np
from scipy.spatial.transform import Rotation

AXIS = np.array([1.0, 1.0, 0.0]) / np.sqrt(2)


def place(shape, rotation: Rotation, offset):
    m = np.identity(4)
    m[:3, :3] = rotation.as_matrix()
    m[:3, 3] = offset
    return transform_shape(shape, m)


@register()
def satellite(panels: int = 6, radius: float = 2.0) -> Shape:
    body = primitive_call('sphere', color=(.7, .7, .75), shape_kwargs={'radius': .6})
    parts = [body]
    tilt = Rotation.from_rotvec(np.deg2rad(30) * AXIS)
    for k in range(panels):
        spin = Rotation.from_rotvec(2 * np.pi * k / panels * np.array([0, 1, 0]))
        total = tilt * spin
        panel = primitive_call('cube', color=(.1, .2, .6), shape_kwargs={'scale': (1, .05, .5)})
        parts.append(place(panel, total, total.apply(np.array([radius, 0, 0]))))
    return concat_shapes(*parts)
