"""
beacons coloured by distances
"""
from helper import *
import numpy as np
from scipy.spatial.distance import cdist, pdist, squareform, euclidean


@register()
def beacons() -> Shape:
    pts = np.array([[np.cos(a) * r, np.sin(a) * r, 0] for r in (1, 2) for a in np.linspace(0, 5, 6)])
    hubs = np.array([[0, 0, 1.0], [2, 0, 0]])
    d = cdist(pts, hubs)
    nearest = d.argmin(axis=1)
    table = squareform(pdist(pts))
    shapes = []
    for i, p in enumerate(pts):
        far = table[i].max()
        shapes.append(transform_shape(primitive_call('sphere', color=(1, 0, 0) if nearest[i] else (0, 0, 1), shape_kwargs={'radius': far / 20 + .01 * euclidean(p, hubs[0])}), translation_matrix(p)))
    return concat_shapes(*shapes)
