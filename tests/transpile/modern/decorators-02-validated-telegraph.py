from functools import wraps
from typing import Callable, ParamSpec, TypeVar
from helper import *

"""
telegraph line: decorators validate arguments and memoize pieces
"""

P_ = ParamSpec("P_")
R = TypeVar("R")
TRACE: list[str] = []


def traced(fn: Callable[P_, R]) -> Callable[P_, R]:
    depth = 0

    @wraps(fn)
    def inner(*args: P_.args, **kwargs: P_.kwargs) -> R:
        nonlocal depth
        TRACE.append("  " * depth + fn.__name__)
        depth += 1
        try:
            return fn(*args, **kwargs)
        finally:
            depth -= 1

    return inner


def in_range(**limits):
    def decorate(fn):
        @wraps(fn)
        def inner(**kwargs):
            for name, (low, high) in limits.items():
                if name in kwargs:
                    kwargs[name] = min(max(kwargs[name], low), high)
            return fn(**kwargs)
        return inner
    return decorate


class memoized:
    def __init__(self, fn):
        self.fn, self.cache, self.hits = fn, {}, 0

    def __call__(self, *args):
        if args in self.cache:
            self.hits += 1
        else:
            self.cache[args] = self.fn(*args)
        return self.cache[args]


@memoized
def insulator(arm: int):
    return transform_shape(primitive_call('sphere', color=(0.3, 0.7, 0.6), shape_kwargs={'radius': 0.07}), translation_matrix((0.25 * arm, 0.1, 0)))


@register("telegraph pole")
@in_range(height=(2.0, 4.0), arms=(1, 3))
def pole(height: float = 3.0, arms: int = 2) -> Shape:
    trunk = primitive_call('cylinder', color=(0.4, 0.28, 0.18), shape_kwargs={'radius': 0.08, 'p0': (0, 0, 0), 'p1': (0, height, 0)})
    beams = []
    for k in range(arms):
        beam = primitive_call('cube', color=(0.4, 0.28, 0.18), shape_kwargs={'scale': (1.2, 0.08, 0.08)})
        beams.append(transform_shape(concat_shapes(beam, insulator(-2), insulator(2), insulator(k - 1)), translation_matrix((0, height - 0.3 - 0.4 * k, 0))))
    return concat_shapes(trunk, *beams)


@traced
def wires(n: int) -> Shape:
    if n == 0:
        return concat_shapes()
    z = 4.0 * (n - 1)
    sag = [primitive_call('cylinder', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': 0.015, 'p0': (x, 2.5, z), 'p1': (x, 2.5, z + 4)}) for x in (-0.5, 0.5)]
    return concat_shapes(*sag, wires(n - 1))


@register("telegraph line")
def line(n: int = 4) -> Shape:
    poles = [transform_shape(library_call('pole', height=1.0 + k, arms=k), translation_matrix((0, 0, 4 * k))) for k in range(n + 1)]
    cable = wires(n)
    birds = loop(insulator.hits, lambda i: transform_shape(primitive_call('sphere', color=(0.2, 0.2, 0.25), shape_kwargs={'radius': 0.1}), translation_matrix((0.5, 2.6, 0.6 * i))))
    ground = primitive_call('cube', color=(0.4, 0.5, 0.3), shape_kwargs={'scale': (3, 0.05, len(TRACE[-1]) + 8)})
    return concat_shapes(*poles, cable, birds, ground)
