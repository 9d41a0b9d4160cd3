"""
fallen dominoes turned by euler angles
"""
from helper import *
import numpy as np
from scipy.spatial.transform import Rotation as R


@register()
def domino() -> Shape:
    return primitive_call('cube', color=(.9, .9, .85), shape_kwargs={'scale': (.5, 1, .1)})


@register()
def dominoes(count: int = 8, step: float = 12.0) -> Shape:
    shapes = []
    for i in range(count):
        rot = R.from_euler('xyz', [i * step, i * 5, 0], degrees=True)
        pose = np.eye(4)
        pose[:3, :3] = rot.as_matrix()
        pose[:3, 3] = rot.apply([0, .5, 0]) + np.array([0, 0, i * .4])
        shapes.append(transform_shape(library_call('domino'), pose))
    return concat_shapes(*shapes)
