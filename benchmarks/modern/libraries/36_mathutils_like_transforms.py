"""
flags that trimesh transforms place
"""
from helper import *
import numpy as np
from trimesh.transformations import rotation_matrix as tf_rotation, translation_matrix as tf_translation, euler_matrix


@register()
def flag() -> Shape:
    return primitive_call('cube', color=(.9, .1, .1), shape_kwargs={'scale': (1, .6, .05)})


@register()
def flags() -> Shape:
    shapes = []
    for k in range(6):
        m = tf_rotation(k * np.pi / 3, [0, 1, 0]) @ tf_translation([2, 1, 0]) @ euler_matrix(0, .3, .1 * k, 'sxyz')
        shapes.append(transform_shape(library_call('flag'), m))
    return concat_shapes(*shapes)
