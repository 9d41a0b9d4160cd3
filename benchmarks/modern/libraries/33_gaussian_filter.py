"""
smooth hills
"""
from helper import *
import numpy as np
from scipy.ndimage import gaussian_filter


@register()
def hills() -> Shape:
    rng = np.random.default_rng(0)
    field = gaussian_filter(rng.random((9, 9)), sigma=1.5)
    field = (field - field.min()) / np.ptp(field)
    return concat_shapes(*[
        transform_shape(primitive_call('cube', color=(.3, .3 + .5 * h, .2), shape_kwargs={'scale': (1, .2 + 2 * h, 1)}), translation_matrix((i, .1 + h, j)))
        for (i, j), h in np.ndenumerate(field)
    ])
