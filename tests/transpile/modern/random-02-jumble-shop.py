import random
from helper import *

"""
an antique shop window with shuffled shelves
"""

KINDS = ["vase", "clock", "box", "globe", "candle"]
WEIGHTS = [4, 1, 3, 1, 2]


def random_color(rng: random.Random, base: tuple) -> tuple:
    return tuple(min(1.0, max(0.0, c + rng.uniform(-0.1, 0.1))) for c in base)


@register()
def antique(kind: str, color: tuple, size: float) -> Shape:
    if kind == "vase":
        return concat_shapes(*[primitive_call('cylinder', color=color, shape_kwargs={'radius': size * r, 'p0': (0, size * y, 0), 'p1': (0, size * (y + 0.3), 0)}) for y, r in ((0, 0.3), (0.3, 0.4), (0.6, 0.15))])
    if kind == "clock":
        face = primitive_call('cylinder', color=(1, 1, 1), shape_kwargs={'radius': size * 0.3, 'p0': (0, size * 0.5, 0.2), 'p1': (0, size * 0.5, 0.25)})
        return concat_shapes(transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (size * 0.8, size, 0.4)}), translation_matrix((0, size / 2, 0))), face)
    if kind == "globe":
        return transform_shape(primitive_call('sphere', color=color, shape_kwargs={'radius': size * 0.4}), translation_matrix((0, size * 0.4, 0)))
    if kind == "candle":
        return primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.08, 'p0': (0, 0, 0), 'p1': (0, size, 0)})
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': size * 0.6}), translation_matrix((0, size * 0.3, 0)))


@register()
def shelf(items: list, width: float = 4.0) -> Shape:
    board = primitive_call('cube', color=(0.45, 0.3, 0.2), shape_kwargs={'scale': (width, 0.08, 0.8)})
    pitch = width / len(items)
    things = []
    for i, kind in enumerate(items):
        color = random_color(random, (0.6, 0.45, 0.35))
        size = random.triangular(0.4, 1.0, 0.7)
        turn = rotation_matrix(random.uniform(-0.3, 0.3), (0, 1, 0), (0, 0, 0))
        things.append(transform_shape(library_call('antique', kind=kind, color=color, size=size), translation_matrix(((i + 0.5) * pitch - width / 2, 0.04, 0)) @ turn))
    return concat_shapes(board, *things)


@register()
def shop_window() -> Shape:
    rng = random.Random(7)
    first = random.choices(KINDS, weights=WEIGHTS, k=6)
    second = KINDS[:]
    random.shuffle(second)
    third = random.sample(KINDS * 2, 4)
    fourth = [rng.choice(KINDS) for _ in range(rng.randrange(3, 7))]
    rng.shuffle(fourth)
    shelves = [transform_shape(library_call('shelf', items=items), translation_matrix((0, 1.3 * k, 0))) for k, items in enumerate((first, second, third, fourth))]
    stars = [transform_shape(primitive_call('sphere', color=(1, 0.9, 0.4), shape_kwargs={'radius': 0.03 + 0.04 * rng.random()}), translation_matrix((rng.uniform(-2, 2), 5.5 + 0.2 * rng.random(), 0))) for _ in range(10)]
    return concat_shapes(*shelves, *stars)
