# expect E602
from helper import *

@register("leg")
def leg(height: float) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': 0.1, 'p0': (0, 0, 0), 'p1': (0, height, 0)})

@register("table")
def table() -> Shape:
    return transform_shape(translation_matrix((0, 1, 0)), library_call('leg', height=1))
