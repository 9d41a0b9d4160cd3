@register()
def scene() -> Shape:
    size = 1 + 1
    return primitive_call('cube', shape_kwargs={'scale': size})
