@register()
def steps(n: int) -> Shape:
    return loop(n, lambda i: transform_shape(
        primitive_call('cube', shape_kwargs={'scale': (1, .1, 1 / (n - 3))}),
        translation_matrix((0, i, 0))
    ))


@register()
def stairs() -> Shape:
    return concat_shapes(*[library_call('steps', n=n) for n in (5, 4, 3)])
