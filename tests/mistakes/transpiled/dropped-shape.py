# expect W803
@register()
def box() -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': (1, 1, 1)}, color=(1, 0, 0))

@register()
def table() -> Shape:
    a = library_call('box')
    transform_shape(a, translation_matrix((1, 0, 0)))
    return concat_shapes(a, library_call('box'))
