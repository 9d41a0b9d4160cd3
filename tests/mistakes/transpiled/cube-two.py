# expect E603
from helper import *

@register("leg")
def leg(height: float) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': 0.1, 'p0': (0, 0, 0), 'p1': (0, height, 0)})

@register("table")
def table() -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': (1, 1)})
