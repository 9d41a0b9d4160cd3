@register()
def scene(radius: float = 1.) -> Shape:
    ball = primitive_call('sphere', shape_kwargs={'radius': radius})
    return transform_shape(ball, translation_matrix((0, radius, 0)))
