"""
hills of open simplex noise
"""
from helper import *
import opensimplex

opensimplex.seed(1234)


@register()
def tree(height: float = 1.0) -> Shape:
    trunk = primitive_call('cylinder', color=(.4, .25, .1), shape_kwargs={'radius': .1, 'p0': (0, 0, 0), 'p1': (0, height, 0)})
    crown = transform_shape(primitive_call('sphere', color=(.1, .5, .2), shape_kwargs={'radius': .4}), translation_matrix((0, height, 0)))
    return concat_shapes(trunk, crown)


@register()
def forest() -> Shape:
    shapes = []
    for x in range(8):
        for z in range(8):
            n = opensimplex.noise2(x=x * .31, y=z * .31)
            if n > 0:
                shapes.append(transform_shape(library_call('tree', height=.5 + n), translation_matrix((x, 0, z))))
    return concat_shapes(*shapes)
