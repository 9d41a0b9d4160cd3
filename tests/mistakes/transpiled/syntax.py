# expect E801
from helper import *

@register("table")
def table() -> Shape
    return primitive_call('cube', shape_kwargs={'scale': 1})
