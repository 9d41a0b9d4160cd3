"""
a hanging chain
"""
from helper import *
import numpy as np
from scipy.optimize import brentq, fsolve

SPAN, LENGTH = 4.0, 6.0


@register()
def chain(links: int = 15) -> Shape:
    a = brentq(lambda a: 2 * a * np.sinh(SPAN / (2 * a)) - LENGTH, .1, 10)
    shapes = []
    for x in np.linspace(-SPAN / 2, SPAN / 2, links):
        y = a * np.cosh(x / a) - a
        shapes.append(transform_shape(primitive_call('sphere', color=(.5, .5, .55), shape_kwargs={'radius': .12}), translation_matrix((x, y, 0))))
    return concat_shapes(*shapes)
