@register()
def leg(height: float) -> Shape:
    legs = library_call('leg', size=1)
    return primitive_call('pyramid', shape_kwargs={'scale': (.1, height, .1)})


@register()
def table() -> Shape:
    top = transform_shape(library_call('leg'))
    return loop(4, lambda i: transform_shape(top, translation_matrix((i, 0, 0)), 3))
