@register()
def leg(height: float = 1) -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': (.1, height, .1)})


@register()
def table() -> Shape:
    top = transform_shape(library_call('leg', height=2), translation_matrix((0, 1, 0)))
    return loop(4, lambda i: transform_shape(top, translation_matrix((i, 0, 0))))
