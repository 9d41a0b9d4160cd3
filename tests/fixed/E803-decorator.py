@register()
def scene() -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': 1})
