"""fireworks of different kinds over a city skyline reflected in a river"""
from helper import *
from collections.abc import Callable
from contextlib import ExitStack
from functools import singledispatch, wraps
from typing import NamedTuple, ParamSpec, TypeVar
import math
import random

P_ = ParamSpec('P_')
R = TypeVar('R')
LOG: list[str] = []


class Peony(NamedTuple):
    color: tuple
    stars: int = 48
    speed: float = 1.5


class Willow(NamedTuple):
    color: tuple
    arms: int = 14


class Ring(NamedTuple):
    color: tuple
    tilt: float = 0.6
    stars: int = 26


class Palette:
    """Context manager that lends colours and takes them back."""
    stack: list['Palette'] = []

    def __init__(self, *colors):
        self.colors = list(colors)

    def __enter__(self):
        Palette.stack.append(self)
        return self

    def __exit__(self, exc_type, exc, tb):
        Palette.stack.pop()
        return False

    @staticmethod
    def pick(k: int) -> tuple:
        colors = Palette.stack[-1].colors
        return colors[k % len(colors)]


def counted(function: Callable[P_, R]) -> Callable[P_, R]:
    calls = 0

    @wraps(function)
    def wrapper(*args: P_.args, **kwargs: P_.kwargs) -> R:
        nonlocal calls
        calls += 1
        LOG.append(f'{function.__name__} #{calls}')
        return function(*args, **kwargs)
    return wrapper


def spark(p, r, color):
    return transform_shape(primitive_call('sphere', shape_kwargs={'radius': r}, color=color), translation_matrix(p))


def ballistic(v, t, drag=0.7, g=0.6):
    """Position after t seconds with linear drag."""
    k = (1 - math.exp(-drag * t)) / drag
    return v[0] * k, v[1] * k - g * (t - k) / drag, v[2] * k


@singledispatch
def explode(shell, t: float) -> Shape:
    raise NotImplementedError(type(shell).__name__)


@explode.register
def _(shell: Peony, t: float) -> Shape:
    out = []
    for i in range(shell.stars):
        y = 1 - 2 * (i + 0.5) / shell.stars
        r, a = math.sqrt(1 - y * y), i * math.pi * (3 - math.sqrt(5))
        v = tuple(shell.speed * c for c in (r * math.cos(a), y, r * math.sin(a)))
        head, tail = ballistic(v, t), ballistic(v, t * 0.8)
        out.append(spark(head, 0.035, shell.color))
        out.append(primitive_call('cylinder', shape_kwargs={'radius': 0.01, 'p0': tail, 'p1': head}, color=tuple(c * 0.7 for c in shell.color)))
    return concat_shapes(*out)


@explode.register
def _(shell: Willow, t: float) -> Shape:
    out = []
    for i in range(shell.arms):
        a = math.tau * i / shell.arms
        v = (0.9 * math.cos(a), 1.1, 0.9 * math.sin(a))
        path = [ballistic(v, t * k / 8, g=1.6) for k in range(9)]
        out += [primitive_call('cylinder', shape_kwargs={'radius': 0.02 - 0.002 * k, 'p0': p, 'p1': q}, color=tuple(c * (1 - 0.06 * k) for c in shell.color)) for k, (p, q) in enumerate(zip(path, path[1:]))]
    return concat_shapes(*out)


@explode.register
def _(shell: Ring, t: float) -> Shape:
    stars = loop(shell.stars, lambda i: spark(ballistic((1.3 * math.cos(math.tau * i / shell.stars), 0, 1.3 * math.sin(math.tau * i / shell.stars)), t, g=0), 0.04, shell.color))
    return transform_shape(stars, rotation_matrix(shell.tilt, (1, 0, 0.4), (0, 0, 0)))


@register()
@counted
def burst(kind: str = 'peony', index: int = 0, age: float = 1.2) -> Shape:
    color = Palette.pick(index) if Palette.stack else (1.0, 0.8, 0.3)
    shell = {'peony': lambda: Peony(color, stars=40 + 4 * index), 'willow': lambda: Willow(color), 'ring': lambda: Ring(color, tilt=0.4 * index)}[kind]()
    return explode(shell, age)


@register()
def skyline(buildings: int = 16, width: float = 12.0, tallest: float = 3.0, seed: int = 2026) -> Shape:
    rnd = random.Random(seed)
    out, x = [], -width / 2
    heights = [rnd.betavariate(2, 3) * tallest + 0.5 for _ in range(buildings)]
    w = width / buildings
    for h in heights:
        x += w
        tower = transform_shape(primitive_call('cube', shape_kwargs={'scale': (w * 0.85, h, 0.8)}, color=(0.12, 0.13, 0.2)), translation_matrix((x - w / 2, h / 2, 0)))
        out.append(tower)
        out.append(transform_shape(tower, reflection_matrix((0, 0, 0), (0, 1, 0)) @ scale_matrix((1, 0.4, 1), (0, 0, 0))))
        for floor in range(int(h / 0.35)):
            for col in (-0.2, 0.0, 0.2):
                if rnd.random() < 0.55:
                    out.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.08, 0.12, 0.02)}, color=(1, 0.85, 0.5)), translation_matrix((x - w / 2 + col, 0.25 + 0.35 * floor, 0.41))))
    return concat_shapes(*out)


@register()
def show() -> Shape:
    program = [('peony', (-3.5, 5.5, 0), 1.3), ('ring', (-1, 6.6, -0.5), 1.0), ('willow', (1.8, 6.0, 0.3), 1.6), ('peony', (4, 5.0, -0.2), 0.8), ('ring', (0.4, 4.5, 0.5), 0.7)]
    shells = []
    with ExitStack() as stack:
        for theme in (Palette((1, 0.8, 0.3)), Palette((1, 0.3, 0.3), (0.4, 0.7, 1), (1, 0.85, 0.4), (0.5, 1, 0.5))):
            stack.enter_context(theme)
        for i, (kind, at, age) in enumerate(program):
            shells.append(transform_shape(library_call('burst', kind=kind, index=i, age=age), translation_matrix(at)))
            x, y, z = at
            shells.append(primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': (x * 0.9, 0, z), 'p1': (x, y, z)}, color=(0.5, 0.35, 0.2)))
    markers = loop(len(LOG) % 10, lambda i: spark((-5 + i, 0.05, 1.5), 0.06, (1, 0.9, 0.6)))
    river = transform_shape(primitive_call('cube', shape_kwargs={'scale': (13, 0.02, 5)}, color=(0.08, 0.12, 0.25)), translation_matrix((0, -0.01, 1.5)))
    return concat_shapes(river, library_call('skyline'), *shells, markers)
