import functools
import math
from helper import *

"""
a fountain with jets; decorators repeat, mirror and color parts
"""


def radial(n: int):
    """Decorator factory: n copies about the y axis."""
    def decorate(fn):
        @functools.wraps(fn)
        def wrapper(*args, **kwargs):
            part = fn(*args, **kwargs)
            return loop(n, lambda i: transform_shape(part, rotation_matrix(2 * math.pi * i / n, (0, 1, 0), (0, 0, 0))))
        return wrapper
    return decorate


def raised(height):
    return lambda fn: functools.wraps(fn)(lambda *a, **k: transform_shape(fn(*a, **k), translation_matrix((0, height, 0))))


def counted(fn):
    @functools.wraps(fn)
    def wrapper(*args, **kwargs):
        wrapper.calls += 1
        return fn(*args, **kwargs)
    wrapper.calls = 0
    return wrapper


@counted
def drop(radius: float = 0.04) -> Shape:
    """A drop of water."""
    return primitive_call('sphere', color=(0.6, 0.8, 1.0), shape_kwargs={'radius': radius})


@register("jets")
@radial(8)
def jets(drops: int = 6) -> Shape:
    def position(t):
        return (1.6 * t, 1.2 + 1.6 * t - 2.6 * t * t, 0)
    return concat_shapes(*[transform_shape(drop(0.03 + 0.005 * k), translation_matrix(position((k + 1) / drops))) for k in range(drops)])


@register("basin wall")
@radial(n=12)
def basin(radius: float = 2.0) -> Shape:
    stone = primitive_call('cube', color=(0.65, 0.63, 0.6), shape_kwargs={'scale': (0.25, 0.5, 2 * radius * math.tan(math.pi / 12))})
    return transform_shape(stone, translation_matrix((radius, 0.25, 0)))


@register("bowl on a pillar")
@raised(0.2)
def bowl() -> Shape:
    pillar = primitive_call('cylinder', color=(0.7, 0.68, 0.65), shape_kwargs={'radius': 0.2, 'p0': (0, 0, 0), 'p1': (0, 0.8, 0)})
    dish = primitive_call('cylinder', color=(0.7, 0.68, 0.65), shape_kwargs={'radius': 0.7, 'p0': (0, 0.8, 0), 'p1': (0, 0.95, 0)})
    return concat_shapes(pillar, dish)


@register("fountain")
def fountain() -> Shape:
    shape = concat_shapes(library_call('basin'), library_call('bowl'), library_call('jets', drops=5))
    print(drop.__name__, drop.__doc__, drop.calls)
    overflow = loop(drop.calls, lambda i: transform_shape(drop(), translation_matrix((0, 1.3 + 0.1 * i, 0))))
    return concat_shapes(shape, overflow)
