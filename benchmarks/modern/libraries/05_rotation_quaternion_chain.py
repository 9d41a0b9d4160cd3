"""
a tumbling cube
"""
from helper import *
import numpy as np
from scipy.spatial.transform import Rotation as R


@register()
def tumbling() -> Shape:
    spin = R.from_quat([0, np.sin(np.pi / 16), 0, np.cos(np.pi / 16)])
    roll = R.from_euler('x', 20, degrees=True)
    now = R.identity()
    shapes = []
    for i in range(10):
        axis_angle = now.as_rotvec()
        angle = np.linalg.norm(axis_angle)
        cube = primitive_call('cube', color=(i / 10, .4, 1 - i / 10), shape_kwargs={'scale': .7})
        if angle > 1e-9:
            cube = transform_shape(cube, rotation_matrix(angle, axis_angle / angle, (0, 0, 0)))
        shapes.append(transform_shape(cube, translation_matrix((i * 1.2, now.magnitude() * .2, 0))))
        now = spin * now if i % 2 else now * roll.inv()
    return concat_shapes(*shapes)
