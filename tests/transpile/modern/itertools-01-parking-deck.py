from itertools import product, cycle, chain, count, repeat, starmap
from helper import *

"""
a parking deck with cars in repeating colors
"""

PAINT = [(0.8, 0.1, 0.1), (0.1, 0.2, 0.7), (0.9, 0.9, 0.9), (0.15, 0.15, 0.15), (0.8, 0.7, 0.1)]
OCCUPIED = {(0, 0), (0, 2), (1, 1), (1, 3), (2, 0), (2, 1), (2, 2), (0, 5), (1, 4)}


@register()
def car(color: tuple) -> Shape:
    def box(w, h, d, y, tint):
        return transform_shape(primitive_call('cube', color=tint, shape_kwargs={'scale': (w, h, d)}), translation_matrix((0, y, 0)))
    body = list(starmap(box, [(0.8, 0.3, 1.6, 0.3, color), (0.7, 0.25, 0.8, 0.57, (0.6, 0.8, 0.9))]))
    wheels = [
        primitive_call('cylinder', color=(0.05, 0.05, 0.05), shape_kwargs={'radius': 0.15, 'p0': (x - 0.05, 0.15, z), 'p1': (x + 0.05, 0.15, z)})
        for x, z in product((-0.4, 0.4), (-0.5, 0.5))
    ]
    return concat_shapes(*body, *wheels)


@register()
def slot() -> Shape:
    lines = zip(repeat(0.0), (-0.55, 0.55))
    return concat_shapes(*[transform_shape(primitive_call('cube', color=(0.95, 0.95, 0.95), shape_kwargs={'scale': (0.05, 0.02, 2)}), translation_matrix((x, y, 0))) for y, x in lines])


@register()
def deck(level: int, rows: int = 3, cols: int = 6) -> Shape:
    paints = cycle(PAINT[level:] + PAINT[:level])
    floor = transform_shape(primitive_call('cube', color=(0.4, 0.4, 0.42), shape_kwargs={'scale': (cols * 1.2, 0.1, rows * 2.4)}), translation_matrix(((cols - 1) * 0.6, -0.06, (rows - 1) * 1.2)))
    parts = [floor]
    for r, c in product(range(rows), range(cols)):
        here = translation_matrix((1.2 * c, 0, 2.4 * r))
        parts.append(transform_shape(library_call('slot'), here))
        if ((r + level) % rows, c) in OCCUPIED:
            parts.append(transform_shape(library_call('car', color=next(paints)), here))
    return concat_shapes(*parts)


@register()
def parking() -> Shape:
    heights = zip(range(2), count(0, 2.5))
    decks = [transform_shape(library_call('deck', level=level), translation_matrix((0, y, 0))) for level, y in heights]
    pillars = [
        primitive_call('cylinder', color=(0.6, 0.6, 0.6), shape_kwargs={'radius': 0.12, 'p0': (x, 0, z), 'p1': (x, 2.5, z)})
        for x, z in chain(product((-0.6, 6.6), (-1, 2.4, 5.8)), [(3, 2.4)])
    ]
    return concat_shapes(*decks, *pillars)
