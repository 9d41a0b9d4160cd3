"""
a vine along a b-spline
"""
from helper import *
import numpy as np
from scipy.interpolate import splprep, splev, interp1d


@register()
def vine() -> Shape:
    x = [0, .5, 0, -.5, 0, .5]
    y = [0, 1, 2, 3, 4, 5]
    z = [0, .3, .8, .3, 0, -.3]
    tck, u = splprep([x, y, z], s=0)
    xs, ys, zs = splev(np.linspace(0, 1, 30), tck)
    width = interp1d([0, 1], [.2, .05])
    shapes = []
    for k, (a, b, c) in enumerate(zip(xs, ys, zs)):
        shapes.append(transform_shape(primitive_call('sphere', color=(.2, .5, .2), shape_kwargs={'radius': float(width(k / 29))}), translation_matrix((a, b, c))))
    return concat_shapes(*shapes)
