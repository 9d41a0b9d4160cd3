"""bubble sort visualized: each row of bars is a snapshot of the array"""
from helper import *
from itertools import islice
import random


def bubble_sort_snapshots(values):
    """Yields (array, swapped index or None) after each pass."""
    a = list(values)
    yield tuple(a), None
    while True:
        swapped = None
        for i in range(len(a) - 1):
            if a[i] > a[i + 1]:
                a[i], a[i + 1] = a[i + 1], a[i]
                swapped = i + 1
        yield tuple(a), swapped
        if swapped is None:
            return


def color_of(v: int, vmax: int) -> tuple[float, float, float]:
    t = v / vmax
    return (t, 0.3 + 0.4 * (1 - abs(2 * t - 1)), 1 - t)


@register()
def bar(value: int, vmax: int, unit: float = 0.2, highlight: bool = False) -> Shape:
    h = value * unit
    b = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.8, h, 0.5)}, color=color_of(value, vmax)), translation_matrix((0, h / 2, 0)))
    if not highlight:
        return b
    dot = primitive_call('sphere', shape_kwargs={'radius': 0.2}, color=(1, 1, 1))
    return concat_shapes(b, transform_shape(dot, translation_matrix((0, h + 0.3, 0))))


@register()
def snapshot(values: tuple, swapped: int | None = None) -> Shape:
    n, vmax = len(values), max(values)
    return loop(n, lambda i: transform_shape(
        library_call('bar', value=values[i], vmax=vmax, highlight=(i == swapped)),
        translation_matrix((i - (n - 1) / 2, 0, 0))))


@register()
def bubble_sort(n: int = 10, seed: int = 3) -> Shape:
    values = random.Random(seed).sample(range(1, n + 1), n)
    rows = []
    last = None
    for z, (arr, swapped) in enumerate(islice(bubble_sort_snapshots(values), 20)):
        rows.append(transform_shape(library_call('snapshot', values=arr, swapped=swapped), translation_matrix((0, 0, z * 1.2))))
        last = arr
    assert list(last) == sorted(values), f"not sorted: {last}"
    depth = len(rows) * 1.2
    base = primitive_call('cube', shape_kwargs={'scale': (n + 1, 0.1, depth + 0.5)}, color=(0.2, 0.2, 0.22))
    return concat_shapes(transform_shape(base, translation_matrix((0, -0.05, depth / 2 - 0.6))), *rows)
