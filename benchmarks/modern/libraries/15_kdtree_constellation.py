"""
stars that are joined to their neighbours
"""
from helper import *
import numpy as np
from scipy.spatial import KDTree, cKDTree


@register()
def constellation() -> Shape:
    rng = np.random.default_rng(8)
    stars = rng.normal(size=(25, 3)) * 2
    tree = KDTree(stars)
    shapes = []
    for i, star in enumerate(stars):
        dist, idx = tree.query(star, k=3)
        near = len(tree.query_ball_point(star, r=1.5))
        shapes.append(transform_shape(primitive_call('sphere', color=(1, 1, .7), shape_kwargs={'radius': .05 + .02 * near}), translation_matrix(star)))
        for j in idx[1:]:
            if i < j:
                shapes.append(primitive_call('cylinder', color=(.5, .5, .8), shape_kwargs={'radius': .02, 'p0': tuple(star), 'p1': tuple(stars[j])}))
    return concat_shapes(*shapes)
