def chair():
    return primitive_call('cube', shape_kwargs={'scale': 1})
