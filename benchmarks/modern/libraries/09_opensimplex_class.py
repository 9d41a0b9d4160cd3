"""
a cloud of spheres that noise displaces
"""
from helper import *
import math
from opensimplex import OpenSimplex


@register()
def cloud(count: int = 40) -> Shape:
    gen = OpenSimplex(seed=7)
    shapes = []
    golden = math.pi * (3 - math.sqrt(5))
    for i in range(count):
        y = 1 - 2 * i / (count - 1)
        r = math.sqrt(max(0, 1 - y * y))
        x, z = r * math.cos(golden * i), r * math.sin(golden * i)
        d = 1.5 + .5 * gen.noise3(x * 1.5, y * 1.5, z * 1.5)
        shapes.append(transform_shape(primitive_call('sphere', color=(1, 1, 1), shape_kwargs={'radius': .25}), translation_matrix((x * d, y * d, z * d))))
    return concat_shapes(*shapes)
