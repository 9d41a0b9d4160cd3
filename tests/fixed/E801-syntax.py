from helper import *


@register()
def chair(height: float = .5) -> Shape:
    seat = primitive_call('cube', shape_kwargs={'scale': (1, .1, 1)})
    return transform_shape(seat, translation_matrix((0, height, 0)))
