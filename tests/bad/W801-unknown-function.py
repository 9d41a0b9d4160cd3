@register()
def wheel() -> Shape:
    return primitive_call('sphere', shape_kwargs={'radius': 1})


@register()
def car() -> Shape:
    return concat_shapes(library_call('wheel'), library_call('wheels'), library_call('spoiler', size=2))
