"""
a ruler with exact marks
"""
from helper import *
from decimal import Decimal, ROUND_HALF_UP
from fractions import Fraction


@register()
def mark(height: float) -> Shape:
    return transform_shape(primitive_call('cube', color=(0, 0, 0), shape_kwargs={'scale': (.02, height, .02)}), translation_matrix((0, height / 2, 0)))


@register()
def ruler(inches: int = 3) -> Shape:
    shapes = [transform_shape(primitive_call('cube', color=(.9, .8, .4), shape_kwargs={'scale': (inches, .05, 1)}), translation_matrix((inches / 2, 0, 0)))]
    step = Fraction(1, 8)
    x = Fraction(0)
    while x <= inches:
        height = {1: .5, 2: .35, 4: .25, 8: .15}[x.denominator]
        shapes.append(transform_shape(library_call('mark', height=height), translation_matrix((float(x), 0, 0))))
        x += step
    price = (Decimal('19.99') * Decimal('1.0825')).quantize(Decimal('0.01'), rounding=ROUND_HALF_UP)
    shapes.append(transform_shape(primitive_call('cube', color=(1, 0, 0), shape_kwargs={'scale': .1}), translation_matrix((float(price) / 10, .5, 0))))
    return concat_shapes(*shapes)
