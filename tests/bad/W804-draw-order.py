def heights(n):
    for _ in range(n):
        yield np.random.uniform(1, 2)


@register()
def scene() -> Shape:
    posts = []
    for x, h in enumerate(heights(5)):
        posts.append(primitive_call('sphere', shape_kwargs={'radius': h}))
    for h in heights(3):
        ball = primitive_call('sphere', shape_kwargs={'radius': h})
        posts.append(transform_shape(ball, translation_matrix((np.random.uniform(0, 9), 0, 0))))
    return concat_shapes(*posts)
