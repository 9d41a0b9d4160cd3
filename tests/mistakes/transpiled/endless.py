# expect W406
from helper import *

@register("tree")
def tree() -> Shape:
    return concat_shapes(primitive_call('cube', shape_kwargs={'scale': 1}), tree())
