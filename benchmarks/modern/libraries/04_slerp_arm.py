"""
an arm whose links turn gradually
"""
from helper import *
import numpy as np
from scipy.spatial.transform import Rotation as R, Slerp


@register()
def link() -> Shape:
    return primitive_call('cube', color=(.8, .3, .2), shape_kwargs={'scale': (.3, .3, .8)})


@register()
def arm() -> Shape:
    keys = R.from_euler('zyx', [[0, 0, 0], [90, 30, 0], [180, 0, 45]], degrees=True)
    slerp = Slerp([0, 1, 2], keys)
    times = np.linspace(0, 2, 9)
    rotations = slerp(times)
    position = np.zeros(3)
    shapes = []
    for r in rotations:
        m = np.eye(4)
        m[:3, :3] = r.as_matrix()
        m[:3, 3] = position
        shapes.append(transform_shape(library_call('link'), m))
        position = position + r.apply([0, 0, .9])
    return concat_shapes(*shapes)
