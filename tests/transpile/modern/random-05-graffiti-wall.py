from helper import *
from contextlib import contextmanager
from random import Random, choice, choices, random, seed, uniform, randint, sample

"""
a brick wall with splashes of paint
"""

seed(123)

BRICKS = [(0.6, 0.25, 0.2), (0.55, 0.22, 0.18), (0.65, 0.3, 0.22)]
SPRAY = {"pink": (1, 0.3, 0.6), "cyan": (0.2, 0.8, 0.9), "lime": (0.6, 0.9, 0.2), "gold": (0.9, 0.8, 0.2)}

@contextmanager
def stream(number: int):
    """A private stream that does not disturb the global one."""
    yield Random(number)

@register()
def brick(width: float) -> Shape:
    tint = choice(BRICKS)
    depth = 0.3 + 0.05 * random()
    return primitive_call('cube', color=tint, shape_kwargs={'scale': (width - 0.04, 0.26, depth)})

@register()
def wall(rows: int, width: float) -> Shape:
    shapes = []
    for row in range(rows):
        x = 0.0
        lengths = []
        while x < width - 1e-9:
            length = min(choices([0.3, 0.6, 0.9], weights=[1, 5, 1] if row % 2 else [2, 3, 2])[0], width - x)
            lengths.append(length)
            shapes.append(transform_shape(library_call('brick', width=length), translation_matrix((x + length / 2, 0.3 * row, 0))))
            x += length
        if row == 0:
            print(lengths)
    return concat_shapes(*shapes)

@register()
def splash(color: tuple, drops: int) -> Shape:
    center = primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.25, 'p0': (0, 0, 0.2), 'p1': (0, 0, 0.22)})
    def drop(_):
        angle, distance = uniform(0, 2 * math.pi), uniform(0.2, 0.5)
        dot = primitive_call('sphere', color=color, shape_kwargs={'radius': uniform(0.02, 0.08)})
        return transform_shape(dot, translation_matrix((distance * math.cos(angle), distance * math.sin(angle), 0.2)))
    runs = [primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.02, 'p0': (x, 0, 0.22), 'p1': (x, -uniform(0.2, 0.7), 0.22)}) for x in (-0.15, 0.1)]
    return concat_shapes(center, loop(drops, drop), *runs)

@register()
def graffiti() -> Shape:
    shapes = [library_call('wall', rows=8, width=5.4)]
    for name in sample(sorted(SPRAY), k=3):
        x, y = uniform(0.6, 4.8), uniform(0.6, 1.8)
        shapes.append(transform_shape(library_call('splash', color=SPRAY[name], drops=randint(4, 9)), translation_matrix((x, y, 0))))
    with stream(9) as private, stream(9) as same:
        assert [private.randint(0, 99) for _ in range(5)] == [same.randint(0, 99) for _ in range(5)]
        for i in range(4):
            can = primitive_call('cylinder', color=private.choice(list(SPRAY.values())), shape_kwargs={'radius': 0.1, 'p0': (0, -0.15, 0), 'p1': (0, 0.2 + private.random() * 0.1, 0)})
            shapes.append(transform_shape(can, translation_matrix((private.uniform(0, 5), 0, 0.8 + 0.2 * i))))
    return concat_shapes(*shapes)
