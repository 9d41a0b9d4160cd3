# expect E601
def leg(n):
    primitive_call('cube', shape_kwargs={'scale': (n, 1, 1)}, color=(1, 0, 0))

@register()
def table() -> Shape:
    return concat_shapes(leg(1))
