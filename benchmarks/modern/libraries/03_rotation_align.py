"""
pencils that point at a target
"""
from helper import *
import numpy as np
from scipy.spatial.transform import Rotation as R

TARGET = np.array([0.0, 3.0, 0.0])


@register()
def pencil(length: float = 1.0) -> Shape:
    return primitive_call('cylinder', color=(.9, .7, .1), shape_kwargs={'radius': .06, 'p0': (0, 0, 0), 'p1': (0, 0, length)})


@register()
def pencils() -> Shape:
    shapes = []
    for angle in np.linspace(0, 2 * np.pi, 7, endpoint=False):
        origin = np.array([2 * np.cos(angle), 0, 2 * np.sin(angle)])
        direction = (TARGET - origin) / np.linalg.norm(TARGET - origin)
        rot, _ = R.align_vectors([direction], [[0, 0, 1]])
        quat = rot.as_quat()
        w = R.from_quat(quat / np.linalg.norm(quat))
        m = np.eye(4)
        m[:3, :3] = w.as_matrix()
        m[:3, 3] = origin
        shapes.append(transform_shape(library_call('pencil', length=1.4), m))
    return concat_shapes(*shapes)
