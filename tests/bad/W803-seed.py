np.random.seed(42)


@register()
def scene() -> Shape:
    return primitive_call('sphere', shape_kwargs={'radius': np.random.uniform(1, 2)})
