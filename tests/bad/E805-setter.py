from helper import *


class A:
    @property
    def w(self):
        return 2


@register()
def scene() -> Shape:
    a = A()
    a.w = 5
    return primitive_call('cube', shape_kwargs={'scale': a.w})
