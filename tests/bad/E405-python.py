@register()
def book(color: tuple) -> Shape:
    return primitive_call('cube', color=color, shape_kwargs={'scale': (.1, .3, .2)})


@register()
def shelf(count: int) -> Shape:
    colors = [(1, 0, 0), (0, 1, 0)]

    def place(i):
        shape = library_call('book', color=colors[i])
        return transform_shape(shape, translation_matrix((i * .12, 0, 0)))

    return loop(count, place)


@register()
def library() -> Shape:
    return library_call('shelf', count=3)
