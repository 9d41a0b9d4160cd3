"""
tumbled dice
"""
from helper import *
import numpy as np
from scipy.spatial.transform import Rotation


@register()
def dice() -> Shape:
    shapes = []
    for i, rot in enumerate(Rotation.random(5, random_state=42)):
        m = np.eye(4)
        m[:3, :3] = rot.as_matrix()
        m[0, 3] = i * 1.5
        shapes.append(transform_shape(primitive_call('cube', color=(.9, .9, .9), shape_kwargs={'scale': .8}), m))
    return concat_shapes(*shapes)
