"""
leaves around a stem by a stack of rotations
"""
from helper import *
import numpy as np
from scipy.spatial.transform import Rotation as R


@register()
def stem(leaves: int = 9) -> Shape:
    angles = np.arange(leaves) * 137.5
    rots = R.from_euler('y', angles[:, None], degrees=True)
    tips = rots.apply(np.array([1.0, .3, 0]))
    mats = rots.as_matrix()
    shapes = [primitive_call('cylinder', color=(.3, .5, .2), shape_kwargs={'radius': .08, 'p0': (0, 0, 0), 'p1': (0, leaves * .25, 0)})]
    for i in range(leaves):
        pose = np.block([[mats[i], (tips[i] + [0, i * .25, 0])[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])
        shapes.append(transform_shape(primitive_call('cube', color=(.2, .7, .3), shape_kwargs={'scale': (1, .05, .4)}), pose))
    euler = rots[2].as_euler('yxz', degrees=True)
    shapes.append(transform_shape(primitive_call('sphere', color=(1, .3, .5), shape_kwargs={'radius': .3}), translation_matrix((0, leaves * .25 + euler[0] / 1000, 0))))
    return concat_shapes(*shapes)
