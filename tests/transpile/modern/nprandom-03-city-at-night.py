import numpy as np
from helper import *

"""
a city block at night with lit windows
"""

STATE = np.random.RandomState(11)
LIT, DARK = (1.0, 0.9, 0.5), (0.15, 0.17, 0.22)

@register()
def facade(floors: int, columns: int, probability: float) -> Shape:
    lit = STATE.rand(floors, columns) < probability
    warmth = STATE.uniform(0.8, 1.0, (floors, columns))
    windows = []
    for f in range(floors):
        if lit[f].any():
            for c in np.flatnonzero(lit[f]):
                color = np.array(LIT) * warmth[f, c]
                window = primitive_call('cube', color=tuple(color), shape_kwargs={'scale': (0.14, 0.18, 0.03)})
                windows.append(transform_shape(window, translation_matrix((0.22 * (c - (columns - 1) / 2), 0.3 * f + 0.2, 0))))
    return concat_shapes(*windows)

@register()
def building(floors: int, columns: int) -> Shape:
    height, width = floors * 0.3 + 0.1, columns * 0.22 + 0.1
    body = transform_shape(primitive_call('cube', color=DARK, shape_kwargs={'scale': (width, height, width)}), translation_matrix((0, height / 2, 0)))
    front = transform_shape(library_call('facade', floors=floors, columns=columns, probability=0.35), translation_matrix((0, 0, width / 2)))
    parts = [body, front]
    if STATE.randint(0, 3) == 0:
        parts.append(primitive_call('cylinder', color=(0.8, 0.1, 0.1), shape_kwargs={'radius': 0.03, 'p0': (0, height, 0), 'p1': (0, height + STATE.uniform(0.3, 0.8), 0)}))
    return concat_shapes(*parts)

@register()
def city_block(n: int = 4) -> Shape:
    heights = STATE.poisson(5, size=(n, 3)) + 2
    order = STATE.permutation(n)
    shapes = []
    for i, row in enumerate(heights[order]):
        for j, floors in enumerate(row):
            columns = int(STATE.choice([3, 4, 5]))
            jitter = STATE.normal(0, 0.05, 2)
            shapes.append(transform_shape(library_call('building', floors=int(floors), columns=columns), translation_matrix((1.6 * i + jitter[0], 0, -1.6 * j + jitter[1]))))
    cars = STATE.multinomial(6, [0.5, 0.3, 0.2])
    for lane, count in enumerate(cars):
        for k in range(count):
            car = primitive_call('cube', color=tuple(STATE.rand(3)), shape_kwargs={'scale': (0.3, 0.15, 0.15)})
            shapes.append(transform_shape(car, translation_matrix((0.8 * k, 0.08, 1.2 + 0.3 * lane))))
    ground = primitive_call('cube', color=(0.1, 0.1, 0.1), shape_kwargs={'scale': (8, 0.05, 7)})
    return concat_shapes(transform_shape(ground, translation_matrix((2.4, -0.03, -1))), *shapes)
