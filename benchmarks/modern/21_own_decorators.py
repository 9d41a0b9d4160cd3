"""a carousel with galloping horses"""
import functools
import inspect
import math
from typing import Callable, ParamSpec
from helper import *

Params = ParamSpec("Params")


def centered(fn: Callable[Params, Shape]) -> Callable[Params, Shape]:
    """Center the result in x and z and put it on the ground."""
    @functools.wraps(fn)
    def wrapper(*args: Params.args, **kwargs: Params.kwargs) -> Shape:
        shape = fn(*args, **kwargs)
        c, lo = compute_shape_center(shape), compute_shape_min(shape)
        return transform_shape(shape, translation_matrix((-c[0], -lo[1], -c[2])))
    return wrapper


def repeated_around(n: int, radius: float):
    def decorate(fn):
        @functools.wraps(fn)
        def wrapper(**kwargs):
            def one(i):
                a = 2 * math.pi * i / n
                shape = fn(i=i, **kwargs)
                pose = rotation_matrix(a, (0, 1, 0), (0, 0, 0)) @ translation_matrix((radius, 0, 0))
                return transform_shape(shape, pose)
            return loop(n, one)
        return wrapper
    return decorate


@register()
@centered
def horse(color: tuple = (0.95, 0.92, 0.85)) -> Shape:
    body = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.25, 0.3, 0.8)}, color=color), translation_matrix((0, 0.6, 0)))
    neck = primitive_call('cylinder', shape_kwargs={'radius': 0.09, 'p0': (0, 0.65, 0.35), 'p1': (0, 1.0, 0.55)}, color=color)
    head = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.14, 0.16, 0.32)}, color=color), translation_matrix((0, 1.02, 0.65)))
    legs = [primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (x, 0.5, z), 'p1': (x, 0, z + 0.15)}, color=color)
            for x in (-0.09, 0.09) for z in (-0.35, 0.3)]
    saddle = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.28, 0.05, 0.25)}, color=(0.8, 0.1, 0.15)), translation_matrix((0, 0.77, 0)))
    return concat_shapes(body, neck, head, saddle, *legs)


@register()
@repeated_around(8, radius=2.0)
def riders(i: int = 0, lift: float = 0.4) -> Shape:
    y = 0.4 + lift * (0.5 + 0.5 * math.sin(i * math.pi / 2))
    tint = [(0.95, 0.92, 0.85), (0.35, 0.22, 0.15), (0.2, 0.2, 0.22)][i % 3]
    pole = primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': (0, 0.2, 0), 'p1': (0, 3, 0)}, color=(0.9, 0.75, 0.2))
    return concat_shapes(pole, transform_shape(library_call('horse', color=tint), translation_matrix((0, y, 0))))


@register()
def canopy(radius: float = 2.8, layers: int = 6) -> Shape:
    return loop(layers, lambda k: primitive_call('cylinder', shape_kwargs={
        'radius': radius * (1 - k / layers), 'p0': (0, 3 + 0.2 * k, 0), 'p1': (0, 3.2 + 0.2 * k, 0)},
        color=(0.85, 0.15, 0.2) if k % 2 == 0 else (0.98, 0.95, 0.85)))


@register()
def carousel() -> Shape:
    assert 'lift' in inspect.signature(riders).parameters
    base = primitive_call('cylinder', shape_kwargs={'radius': 2.8, 'p0': (0, 0, 0), 'p1': (0, 0.2, 0)}, color=(0.5, 0.3, 0.5))
    core = primitive_call('cylinder', shape_kwargs={'radius': 0.6, 'p0': (0, 0.2, 0), 'p1': (0, 3, 0)}, color=(0.9, 0.8, 0.5))
    return concat_shapes(base, core, library_call('riders'), library_call('canopy'))
