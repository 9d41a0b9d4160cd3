"""
paving stones in voronoi cells
"""
from helper import *
import numpy as np
from scipy.spatial import Voronoi


@register()
def paving() -> Shape:
    np.random.seed(5)
    seeds = np.random.rand(24, 2) * 10
    vor = Voronoi(seeds)
    shapes = []
    for p1, p2 in vor.ridge_vertices:
        if p1 >= 0 and p2 >= 0:
            a, b = vor.vertices[p1], vor.vertices[p2]
            if np.all(np.abs(a) < 20) and np.all(np.abs(b) < 20):
                shapes.append(primitive_call('cylinder', color=(.3, .3, .3), shape_kwargs={'radius': .06, 'p0': (float(a[0]), 0, float(a[1])), 'p1': (float(b[0]), 0, float(b[1]))}))
    for x, z in seeds:
        shapes.append(transform_shape(primitive_call('sphere', color=(.8, .6, .4), shape_kwargs={'radius': .2}), translation_matrix((x, 0, z))))
    return concat_shapes(*shapes)
