@register()
@(lambda f: print('hello') or f)
def scene() -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': 1})
