"""a Sierpinski pyramid made of small cubes, with color by height"""
from helper import *
import numpy as np

APEX = np.array([[0, 1, 0], [-0.5, 0, -0.5], [0.5, 0, -0.5], [0.5, 0, 0.5], [-0.5, 0, 0.5]], dtype=float)


def centers(depth: int) -> np.ndarray:
    """(5**depth, 3) array of cell origins, by broadcasting."""
    pts = np.zeros((1, 3))
    for d in range(depth):
        offs = APEX * 2.0 ** (depth - 1 - d)
        pts = (pts[:, None, :] + offs[None, :, :]).reshape(-1, 3)
    return pts


@register()
def cell(size: float = 1.0, color=(1.0, 1.0, 1.0)) -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': (size, size, size)}, color=color)


@register()
def sierpinski(depth: int = 3) -> Shape:
    pts = np.unique(centers(depth), axis=0)
    y = pts[:, 1]
    t = (y - y.min()) / np.ptp(y)
    lo, hi = np.array([0.9, 0.4, 0.1]), np.array([0.2, 0.3, 0.9])
    colors = lo + t[:, np.newaxis] * (hi - lo)
    shapes = []
    for p, c in zip(pts, colors, strict=True):
        shapes.append(transform_shape(library_call('cell', size=0.9, color=tuple(c)), translation_matrix(p)))
    return concat_shapes(*shapes)


@register()
def monument() -> Shape:
    pyramid = library_call('sierpinski', depth=4)
    sx, _, sz = compute_shape_sizes(pyramid)
    slab = primitive_call('cube', shape_kwargs={'scale': (sx * 1.1, 0.5, sz * 1.1)}, color=(0.7, 0.68, 0.62))
    return concat_shapes(pyramid, transform_shape(slab, translation_matrix((0, compute_shape_min(pyramid)[1] - 0.25, 0))))
