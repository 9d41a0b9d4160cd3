"""a sculpture garden: phyllotaxis dome, twisted column, torus knot and a spiral stair of slabs"""
from helper import *
import math
from functools import partial, reduce
from typing import Callable, Iterable

Point = tuple[float, float, float]
Curve = Callable[[float], Point]
GOLDEN = math.pi * (3 - math.sqrt(5))


def compose(*functions):
    """compose(f, g)(x) is f(g(x))."""
    return reduce(lambda f, g: lambda x: f(g(x)), functions)


def lift(height: float) -> Callable[[Point], Point]:
    return lambda p: (p[0], p[1] + height, p[2])


def stretch(kx: float = 1.0, ky: float = 1.0, kz: float = 1.0) -> Callable[[Point], Point]:
    return lambda p: (p[0] * kx, p[1] * ky, p[2] * kz)


def torus_knot(p: int, q: int, major: float = 1.0, minor: float = 0.4) -> Curve:
    def at(t: float) -> Point:
        a = math.tau * t
        r = major + minor * math.cos(q * a)
        return (r * math.cos(p * a), minor * math.sin(q * a), r * math.sin(p * a))
    return at


def sample(curve: Curve, n: int) -> list[Point]:
    return [curve(i / n) for i in range(n)] + [curve(1.0)]


def rainbow(t: float) -> Point:
    """A smooth color for t from 0 to 1."""
    wave = lambda phase: 0.55 + 0.4 * math.cos(math.tau * (t - phase))
    return tuple(map(wave, (0.0, 1 / 3, 2 / 3)))


def wire(points: Iterable[Point], radius: float, color: Callable[[float], Point]) -> Shape:
    points = list(points)
    n = len(points) - 1
    return concat_shapes(*[
        primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': a, 'p1': b}, color=color(i / n))
        for i, (a, b) in enumerate(zip(points, points[1:]))
    ])


@register("balls on a dome at the golden angle")
def dome(seeds: int = 90, radius: float = 1.2) -> Shape:
    def seed(i: int) -> Shape:
        y = 1 - (i + 0.5) / seeds
        r = math.sqrt(1 - y * y)
        at = (radius * r * math.cos(GOLDEN * i), radius * y, radius * r * math.sin(GOLDEN * i))
        ball = primitive_call('sphere', shape_kwargs={'radius': 0.05 + 0.06 * (1 - y)}, color=rainbow(y))
        return transform_shape(ball, translation_matrix(at))
    return loop(seeds, seed)


@register("square slabs, each turned a little more than the one below")
def twisted_column(slabs: int = 24, turn: float = 7.5, side: float = 0.8) -> Shape:
    shapes = []
    for i in range(slabs):
        waist = 1 - 0.4 * math.sin(math.pi * i / (slabs - 1))
        slab = primitive_call('cube', shape_kwargs={'scale': (side * waist, 0.12, side * waist)}, color=(0.8, 0.78 - 0.01 * i, 0.72))
        slab = transform_shape(slab, rotation_matrix(math.radians(turn * i), (0, 1, 0), (0, 0, 0)))
        shapes.append(transform_shape(slab, translation_matrix((0, 0.06 + 0.12 * i, 0))))
    return concat_shapes(*shapes)


@register("a closed wire that winds around a ring")
def knot(p: int = 2, q: int = 3, pieces: int = 120) -> Shape:
    shape_it = compose(lift(1.4), stretch(ky=1.3), torus_knot(p, q))
    return wire(sample(shape_it, pieces), 0.12, rainbow)


@register("treads around a post")
def stair(steps: int = 20, rise: float = 0.14, per_turn: int = 14) -> Shape:
    post = primitive_call('cylinder', shape_kwargs={'radius': 0.1, 'p0': (0, 0, 0), 'p1': (0, steps * rise + 0.8, 0)}, color=(0.25, 0.25, 0.28))
    tread = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.95, 0.05, 0.35)}, color=(0.6, 0.4, 0.25)), translation_matrix((0.5, 0, 0)))
    place = lambda i: transform_shape(transform_shape(tread, rotation_matrix(math.tau * i / per_turn, (0, 1, 0), (0, 0, 0))), translation_matrix((0, (i + 1) * rise, 0)))
    rail = lambda t: (0.95 * math.cos(math.tau * steps * t / per_turn), 0.7 + steps * rise * t, -0.95 * math.sin(math.tau * steps * t / per_turn))
    return concat_shapes(post, loop(steps, place), wire(sample(rail, 40), 0.03, lambda t: (0.85, 0.7, 0.3)))


@register()
def sculpture_garden(radius: float = 3.0) -> Shape:
    pedestal = partial(primitive_call, 'cylinder', color=(0.85, 0.85, 0.82))
    shapes = [primitive_call('cylinder', shape_kwargs={'radius': 5.0, 'p0': (0, -0.2, 0), 'p1': (0, 0, 0)}, color=(0.4, 0.6, 0.35))]
    for k, word in enumerate(['dome', 'twisted_column', 'knot', 'stair']):
        a = math.tau * k / 4
        x, z = radius * math.cos(a), radius * math.sin(a)
        shapes.append(pedestal(shape_kwargs={'radius': 1.3, 'p0': (x, 0, z), 'p1': (x, 0.2, z)}))
        shapes.append(transform_shape(library_call(word), translation_matrix((x, 0.2, z))))
    return concat_shapes(*shapes)
