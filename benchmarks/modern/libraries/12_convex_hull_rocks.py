"""
pegs around the hull of points
"""
from helper import *
import numpy as np
from scipy.spatial import ConvexHull


@register()
def fence() -> Shape:
    rng = np.random.default_rng(3)
    points = rng.uniform(-3, 3, size=(20, 2))
    hull = ConvexHull(points)
    shapes = []
    for x, z in points:
        shapes.append(transform_shape(primitive_call('sphere', color=(.5, .5, .5), shape_kwargs={'radius': .15}), translation_matrix((x, 0, z))))
    loop_points = points[hull.vertices]
    for a, b in zip(loop_points, np.roll(loop_points, -1, axis=0)):
        shapes.append(primitive_call('cylinder', color=(.6, .4, .2), shape_kwargs={'radius': .05, 'p0': (a[0], .3, a[1]), 'p1': (b[0], .3, b[1])}))
    shapes.append(primitive_call('cylinder', color=(.2, .7, .2), shape_kwargs={'radius': np.sqrt(hull.volume / np.pi), 'p0': (0, -.1, 0), 'p1': (0, 0, 0)}))
    return concat_shapes(*shapes)
