@register()
def leg(height: float, color: tuple = (1, 0, 0)) -> Shape:
    return primitive_call('cube', color=color, shape_kwargs={'scale': (.1, height, .1)})


@register()
def table() -> Shape:
    def at(x, z):
        return translation_matrix((x, 0, z))

    return concat_shapes(
        library_call('leg', heigth=1),
        library_call('leg'),
        library_call('leg', 1),
        transform_shape(library_call('leg', height=1)),
        transform_shape(library_call('leg', height=1), at(1, 2, 3)),
        transform_shape(library_call('leg', height=1), rotation_matrix(1, axis=(0, 1, 0))),
        primitive_call('ball', shape_kwargs={'radius': 1}),
    )
