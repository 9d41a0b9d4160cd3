from functools import partial, reduce, lru_cache
import math
from helper import *

"""
a pipe organ
"""

pipe = partial(primitive_call, 'cylinder', color=(0.8, 0.78, 0.7))
wooden = partial(primitive_call, 'cube', color=(0.45, 0.28, 0.15))


@lru_cache(maxsize=None)
def frequency(key: int) -> float:
    """Recursive on purpose: each semitone from the one below."""
    if key == 0:
        return 55.0
    return frequency(key - 1) * 2 ** (1 / 12)


def compose(*functions):
    return reduce(lambda f, g: lambda x: g(f(x)), functions, lambda x: x)


length_of = compose(frequency, lambda f: 343 / (2 * f), lambda l: max(l, 0.2), partial(round, ndigits=3))


@register()
def rank(first: int, count: int, *, fade: float = 0.0) -> Shape:
    keys = list(range(first, first + count))
    # tallest in the middle: alternate left and right
    order = reduce(lambda acc, k: [k] + acc if k % 2 else acc + [k], reversed(keys), [])
    shapes = []
    for slot, key in enumerate(order):
        length = length_of(key)
        radius = 0.05 + 0.02 * length
        shiny = tuple(c * (1 - fade) for c in (0.85, 0.82, 0.7))
        body = pipe(color=shiny, shape_kwargs={'radius': radius, 'p0': (0, 0.3, 0), 'p1': (0, 0.3 + length, 0)})
        foot = pipe(shape_kwargs={'radius': radius / 2, 'p0': (0, 0, 0), 'p1': (0, 0.3, 0)})
        x = 0.25 * (slot - (count - 1) / 2)
        shapes.append(transform_shape(concat_shapes(body, foot), translation_matrix((x, 0, 0))))
    return concat_shapes(*shapes)


@register()
def organ() -> Shape:
    ranks = [(0, 13), (12, 11), (24, 9)]
    poses = [translation_matrix((0, 0.8 - 0.1 * k, 0.4 * k)) for k in range(len(ranks))]
    rows = [transform_shape(library_call('rank', first=f, count=n, fade=0.1 * k), poses[k]) for k, (f, n) in enumerate(ranks)]
    info = frequency.cache_info()
    stops = loop(min(info.currsize // 3, 12), lambda i: transform_shape(
        primitive_call('sphere', color=(0.95, 0.95, 0.9), shape_kwargs={'radius': 0.05}), translation_matrix((0.2 * (i - 5), 0.6, 1.4))))
    case = transform_shape(wooden(shape_kwargs={'scale': (3.6, 0.8, 1.6)}), translation_matrix((0, 0.4, 0.4)))
    keys = loop(14, lambda i: transform_shape(wooden(color=(1, 1, 1), shape_kwargs={'scale': (0.12, 0.04, 0.4)}), translation_matrix((0.14 * (i - 6.5), 0.7, 1.35))))
    total = reduce(lambda a, b: a + b, map(length_of, range(5)))
    bench = transform_shape(wooden(shape_kwargs={'scale': (total / 8, 0.4, 0.5)}), translation_matrix((0, 0.2, 2.2)))
    return concat_shapes(case, keys, stops, bench, *rows)
