# expect E601
from helper import *

@register("table")
def table() -> Shape:
    shape = primitive_call('cube', shape_kwargs={'scale': (1, 1, 1)})
