"""
a roller coaster on a spline
"""
from helper import *
import numpy as np
from scipy.interpolate import CubicSpline


@register()
def coaster() -> Shape:
    t = np.array([0, 1, 2, 3, 4, 5, 6])
    pts = np.array([[0, 1, 0], [2, 3, 1], [4, 1, 3], [5, 4, 5], [3, 2, 6], [1, 1, 3], [0, 1, 0]], dtype=float)
    curve = CubicSpline(t, pts, bc_type='periodic')
    samples = curve(np.linspace(0, 6, 60))
    tangents = curve(np.linspace(0, 6, 60), 1)
    shapes = []
    for p, v in zip(samples, tangents):
        shapes.append(transform_shape(primitive_call('cube', color=(.7, .1, .1), shape_kwargs={'scale': .1 + .02 * np.linalg.norm(v)}), translation_matrix(p)))
        shapes.append(primitive_call('cylinder', color=(.4, .4, .4), shape_kwargs={'radius': .03, 'p0': (p[0], 0, p[2]), 'p1': tuple(p)}))
    return concat_shapes(*shapes)
