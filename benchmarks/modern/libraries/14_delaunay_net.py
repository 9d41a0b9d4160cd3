"""
a net over random posts
"""
from helper import *
import numpy as np
from scipy.spatial import Delaunay


@register()
def net() -> Shape:
    rng = np.random.default_rng(42)
    pts = rng.random((18, 2)) * 6
    heights = 1 + rng.random(18)
    tri = Delaunay(pts)
    edges = set()
    for simplex in tri.simplices:
        for i in range(3):
            a, b = sorted((int(simplex[i]), int(simplex[(i + 1) % 3])))
            edges.add((a, b))
    nodes = [(pts[i, 0], heights[i], pts[i, 1]) for i in range(len(pts))]
    rods = [primitive_call('cylinder', color=(.7, .2, .2), shape_kwargs={'radius': .03, 'p0': nodes[a], 'p1': nodes[b]}) for a, b in sorted(edges)]
    balls = [transform_shape(primitive_call('sphere', color=(.2, .2, .7), shape_kwargs={'radius': .12}), translation_matrix(n)) for n in nodes]
    return concat_shapes(*rods, *balls)
