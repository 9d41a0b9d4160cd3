from helper import *


@register()
def chair(height: float = .5) -> Shape:
    seat = primitive_call('cube', shape_kwargs={'scale': (1, .1, 1)}
    return transform_shape(seat, translation_matrix((0, height, 0)))


@register()
def stool() -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': .3 'p0': (0, 0, 0), 'p1': (0, .5, 0)})
