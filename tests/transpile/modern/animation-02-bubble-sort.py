from typing import Iterator
import random
from helper import *

"""
bubble sort and insertion sort racing each other
"""

def bubble_sort(values: list[int]) -> Iterator[tuple[list[int], set[int]]]:
    values = values[:]
    n = len(values)
    while n > 1:
        last = 0
        for i in range(1, n):
            if values[i - 1] > values[i]:
                values[i - 1], values[i] = values[i], values[i - 1]
                last = i
                yield values[:], {i - 1, i}
        n = last
    yield values, set()

def insertion_sort(values: list[int]) -> Iterator[tuple[list[int], set[int]]]:
    values = values[:]
    for i in range(1, len(values)):
        key, j = values[i], i
        while j > 0 and values[j - 1] > key:
            values[j] = values[j - 1]
            j -= 1
        values[j] = key
        yield list(values), {i, j}
    yield values, set()

def hold_last(stream):
    """Repeats the last item for ever."""
    item = None
    for item in stream:
        yield item, False
    while True:
        yield item, True

@register()
def bars(values: list, active: set, done: bool) -> Shape:
    shapes = []
    for i, v in enumerate(values):
        color = (0.2, 0.8, 0.3) if done else (0.9, 0.3, 0.2) if i in active else (0.3, 0.5, 0.8)
        bar = primitive_call('cube', color=color, shape_kwargs={'scale': (0.8, 0.3 * v, 0.8)})
        shapes.append(transform_shape(bar, translation_matrix((i, 0.15 * v, 0))))
    return concat_shapes(*shapes)

@register_animation()
def sorting_race() -> Iterator[Shape]:
    data = list(range(1, 9))
    random.shuffle(data)
    lanes = [hold_last(bubble_sort(data)), hold_last(insertion_sort(data))]
    frame = 0
    while True:
        states = [next(lane) for lane in lanes]
        yield concat_shapes(*[
            transform_shape(library_call('bars', values=values, active=active, done=done), translation_matrix((0, 0, 2 * k)))
            for k, ((values, active), done) in enumerate(states)
        ])
        frame += 1
        if all(done for _, done in states) or frame >= 40:
            return
