@register()
def scene(radius: float = 1.) -> Shape:
    ball = primitve_call('sphere', shape_kwargs={'radius': radius})
    return transform_shape(ball, translation_matrix((0, raduis, 0)))
