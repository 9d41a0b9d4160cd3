# expect W407
@register()
def box() -> Shape:
    cube = primitive_call('cube', shape_kwargs={'scale': (1, 1, 1)}, color=(1, 0, 0))
    return transform_shape(cube, translation_matrix((1, 0, 0)) * scale_matrix(2, (0, 0, 0)))
