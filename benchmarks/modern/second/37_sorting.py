"""
quicksort shown as rows of coloured bars, one row for every swap
"""
from helper import *
import random
from typing import Iterator, Sequence


def quicksort(a: list[int], lo: int = 0, hi: int | None = None) -> Iterator[tuple[list[int], set[int]]]:
    hi = len(a) - 1 if hi is None else hi
    if lo >= hi:
        return
    pivot, i = a[hi], lo
    for j in range(lo, hi):
        if a[j] < pivot:
            if i != j:
                a[i], a[j] = a[j], a[i]
                yield a.copy(), {i, j}
            i += 1
    if i != hi:
        a[i], a[hi] = a[hi], a[i]
        yield a.copy(), {i, hi}
    yield from quicksort(a, lo, i - 1)
    yield from quicksort(a, i + 1, hi)


@register()
def bar_row(values: Sequence[int] = (3, 1, 2), touched: frozenset = frozenset(), unit: float = 0.1) -> Shape:
    top = max(values)

    def one(i: int) -> Shape:
        v = values[i]
        t = v / top
        color = (1.0, 0.3, 0.2) if i in touched else (0.2 + 0.3 * t, 0.4 + 0.4 * t, 0.9 - 0.3 * t)
        b = primitive_call('cube', {'scale': (0.3, v * unit, 0.3)}, color=color)
        return transform_shape(b, translation_matrix((i * 0.36, v * unit / 2, 0)))

    return loop(len(values), one)


@register()
def sorting_landscape(n: int = 12, seed: int = 6) -> Shape:
    numbers = list(range(1, n + 1))
    random.Random(seed).shuffle(numbers)
    history = [(numbers.copy(), set()), *quicksort(numbers)]
    assert history[-1][0] == sorted(numbers)
    rows = [transform_shape(library_call('bar_row', values=v, touched=frozenset(t)), translation_matrix((0, 0, 0.5 * k)))
            for k, (v, t) in enumerate(history)]
    all_bars = concat_shapes(*rows)
    (cx, _, cz), (sx, _, sz) = compute_shape_center(all_bars), compute_shape_sizes(all_bars)
    base = transform_shape(primitive_call('cube', {'scale': (sx + 0.6, 0.1, sz + 0.6)}, color=(0.2, 0.2, 0.22)), translation_matrix((cx, -0.05, cz)))
    return base + all_bars
