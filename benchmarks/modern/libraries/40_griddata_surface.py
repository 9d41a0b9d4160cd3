"""
a surface between samples
"""
from helper import *
import numpy as np
from scipy.interpolate import griddata, RegularGridInterpolator, UnivariateSpline


@register()
def surface() -> Shape:
    rng = np.random.default_rng(1)
    known = rng.random((30, 2))
    values = np.sin(known[:, 0] * 6) + known[:, 1]
    gx, gy = np.mgrid[.2:.8:7j, .2:.8:7j]
    grid = griddata(known, values, (gx, gy), method='linear', fill_value=0.0)
    return concat_shapes(*[
        transform_shape(primitive_call('sphere', color=(.4, .6, .9), shape_kwargs={'radius': .06}), translation_matrix((gx[i, j] * 5, grid[i, j], gy[i, j] * 5)))
        for i in range(7) for j in range(7)
    ])
