"""a toy sorting machine: colored columns are sorted by insertion sort, one frame for each exchange"""
from helper import *
import random
from functools import wraps
from typing import Callable, Iterator

random.seed(11)
VALUES = random.sample(range(1, 9), 7)

Step = tuple[list[int], int]
ALGORITHMS: dict[str, Callable[[list[int]], Iterator[Step]]] = {}


def algorithm(name: str):
    """Keep a generator of steps under a name; it works on a copy of the list."""
    def decorate(function):
        @wraps(function)
        def wrapper(values):
            return function(list(values))
        ALGORITHMS[name] = wrapper
        return wrapper
    return decorate


@algorithm('insertion')
def insertion_sort(values: list[int]) -> Iterator[Step]:
    """Move each value left until it fits."""
    for end in range(1, len(values)):
        k = end
        while k > 0 and values[k - 1] > values[k]:
            values[k - 1], values[k] = values[k], values[k - 1]
            k -= 1
            yield values[:], k


@algorithm('selection')
def selection_sort(values: list[int]) -> Iterator[Step]:
    for begin in range(len(values) - 1):
        least = min(range(begin, len(values)), key=values.__getitem__)
        if least != begin:
            values[begin], values[least] = values[least], values[begin]
            yield values[:], begin


def inversions(values: list[int]) -> int:
    return sum(a > b for i, a in enumerate(values) for b in values[i + 1:])


@register("a column of stacked discs, one for each unit of the value")
def column(value: int = 3, active: bool = False) -> Shape:
    t = value / 8
    color = (1.0, 0.9, 0.3) if active else (0.2 + 0.7 * t, 0.3, 0.9 - 0.7 * t)
    discs = loop(value, lambda i: primitive_call('cylinder', shape_kwargs={'radius': 0.34, 'p0': (0, 0.25 * i, 0), 'p1': (0, 0.25 * i + 0.22, 0)}, color=color))
    cap = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.14}, color=(1, 1, 1)), translation_matrix((0, 0.25 * value + 0.06, 0)))
    return concat_shapes(discs, cap)


@register("a hand that points down on the value that moves")
def pointer(height: float = 2.6) -> Shape:
    rod = primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (0, height, 0), 'p1': (0, height + 0.6, 0)}, color=(0.3, 0.3, 0.35))
    tip = loop(4, lambda i: primitive_call('cylinder', shape_kwargs={'radius': 0.04 + 0.04 * i, 'p0': (0, height - 0.2 + 0.05 * i, 0), 'p1': (0, height - 0.15 + 0.05 * i, 0)}, color=(0.85, 0.15, 0.15)))
    return concat_shapes(rod, tip)


@register("the bench with a lamp for each inversion that is left")
def bench(places: int = 7, lamps: int = 0) -> Shape:
    top = transform_shape(primitive_call('cube', shape_kwargs={'scale': (places + 0.4, 0.2, 1.4)}, color=(0.4, 0.28, 0.2)), translation_matrix(((places - 1) / 2, -0.1, 0)))
    lights = []
    for k in range(places * (places - 1) // 2):
        on = k < lamps
        lamp = primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=(1.0, 0.3, 0.2) if on else (0.25, 0.25, 0.25))
        lights.append(transform_shape(lamp, translation_matrix((0.3 * k, 0.05, 0.6))))
    return concat_shapes(top, *lights)


@register("one state of the machine")
def state(values: list[int] = VALUES, active: int = -1) -> Shape:
    columns = [transform_shape(library_call('column', value=v, active=i == active), translation_matrix((i, 0, 0))) for i, v in enumerate(values)]
    base = library_call('bench', places=len(values), lamps=inversions(values))
    if active >= 0:
        columns.append(transform_shape(library_call('pointer'), translation_matrix((active, 0, 0))))
    return concat_shapes(base, *columns)


@register_animation("the frames of one algorithm")
def sorting_machine(method: str = 'insertion') -> list[Shape]:
    frames = [library_call('state', values=VALUES)]
    frames += [library_call('state', values=values, active=at) for values, at in ALGORITHMS[method](VALUES)]
    frames.append(library_call('state', values=sorted(VALUES)))
    return frames
