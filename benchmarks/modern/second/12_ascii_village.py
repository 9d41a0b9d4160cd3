"""
a small medieval village laid out from a map
"""
from helper import *
import math
from textwrap import dedent
from typing import Callable

MAP = dedent('''
    TT..T...TTT
    T.HH..H..TT
    ..=======..
    T.H.=W=.H~~
    ..H.=.=..~~
    T...=C=.~~T
    TT..=.=.~TT
''').strip()

BUILDERS: dict[str, Callable[[int, int], list]] = {}


def tile(symbol: str):
    """Registers a builder for a map symbol."""
    def wrap(fn):
        if symbol in BUILDERS:
            raise KeyError(f'{symbol!r} is already taken by {BUILDERS[symbol].__name__}')
        BUILDERS[symbol] = fn
        return fn
    return wrap


def cells(text: str):
    lines = text.splitlines()
    width = max(map(len, lines))
    for z, line in enumerate(lines):
        for x, ch in enumerate(line.ljust(width, '.')):
            yield x, z, ch


@register()
def pine(height: float = 1.2, layers: int = 3) -> Shape:
    trunk = primitive_call('cylinder', {'radius': 0.06, 'p0': (0, 0, 0), 'p1': (0, height * 0.4, 0)}, color=(0.4, 0.27, 0.15))
    crown = loop(layers, lambda i: primitive_call(
        'cylinder', {'radius': 0.34 * (1 - i / (layers + 0.5)), 'p0': (0, height * (0.3 + 0.2 * i), 0), 'p1': (0, height * (0.5 + 0.2 * i), 0)},
        color=(0.12, 0.35 + 0.05 * i, 0.18)))
    return concat_shapes(trunk, crown)


@register()
def cottage(width: float = 0.8, wall: float = 0.5, roof: tuple = (0.55, 0.35, 0.2)) -> Shape:
    base = transform_shape(primitive_call('cube', {'scale': (width, wall, width * 0.8)}, color=(0.9, 0.85, 0.72)),
                           translation_matrix((0, wall / 2, 0)))
    slabs = []
    for s in (-1, 1):
        slab = primitive_call('cube', {'scale': (width * 0.72, 0.06, width * 0.95)}, color=roof)
        slab = transform_shape(slab, rotation_matrix(-s * math.pi / 4.5, (0, 0, 1), (0, 0, 0)))
        slabs += transform_shape(slab, translation_matrix((s * width * 0.25, wall + width * 0.2, 0)))
    door = transform_shape(primitive_call('cube', {'scale': (0.18, 0.3, 0.04)}, color=(0.35, 0.2, 0.1)),
                           translation_matrix((0, 0.15, width * 0.4)))
    return concat_shapes(base, slabs, door)


@register()
def church(nave: float = 0.9, spire: float = 1.6) -> Shape:
    body = library_call('cottage', width=nave, wall=0.7, roof=(0.4, 0.4, 0.45))
    tower = transform_shape(primitive_call('cube', {'scale': (0.3, spire, 0.3)}, color=(0.8, 0.78, 0.74)), translation_matrix((0, spire / 2, -0.4)))
    cross = [primitive_call('cube', {'scale': s}, color=(0.9, 0.8, 0.3)) for s in ((0.04, 0.3, 0.04), (0.18, 0.04, 0.04))]
    cross = transform_shape(concat_shapes(*cross), translation_matrix((0, spire + 0.15, -0.4)))
    return concat_shapes(body, tower, cross)


@register()
def well(stones: int = 10, radius: float = 0.25) -> Shape:
    ring = loop(stones, lambda i: transform_shape(
        primitive_call('cube', {'scale': (0.12, 0.25, 0.12)}, color=(0.55, 0.55, 0.55)),
        rotation_matrix(i * 2 * math.pi / stones, (0, 1, 0), (0, 0, 0)) @ translation_matrix((radius, 0.12, 0))))
    posts = [primitive_call('cylinder', {'radius': 0.03, 'p0': (x, 0, 0), 'p1': (x, 0.7, 0)}, color=(0.4, 0.25, 0.15)) for x in (-0.25, 0.25)]
    beam = primitive_call('cylinder', {'radius': 0.03, 'p0': (-0.3, 0.65, 0), 'p1': (0.3, 0.65, 0)}, color=(0.4, 0.25, 0.15))
    return concat_shapes(ring, *posts, beam)


@tile('T')
def _tree(x, z):
    return library_call('pine', height=1.0 + 0.1 * ((x * 7 + z * 3) % 5))


@tile('H')
def _house(x, z):
    turn = ((x + 2 * z) % 4) * math.pi / 2
    return transform_shape(library_call('cottage'), rotation_matrix(turn, (0, 1, 0), (0, 0, 0)))


@tile('=')
def _road(x, z):
    return primitive_call('cube', {'scale': (1, 0.04, 1)}, color=(0.7, 0.62, 0.48))


@tile('~')
def _water(x, z):
    return primitive_call('cube', {'scale': (1, 0.06, 1)}, color=(0.3, 0.5, 0.75))


BUILDERS |= {'C': lambda x, z: library_call('church'), 'W': lambda x, z: library_call('well')}


@register()
def village(text: str = MAP) -> Shape:
    placed = []
    for x, z, ch in cells(text):
        try:
            built = BUILDERS[ch](x, z)
        except KeyError:
            continue
        placed.append(transform_shape(built, translation_matrix((x, 0, z))))
    all_ = concat_shapes(*placed)
    c, size = compute_shape_center(all_), compute_shape_sizes(all_)
    ground = transform_shape(primitive_call('cube', {'scale': (size[0] + 1, 0.1, size[2] + 1)}, color=(0.5, 0.66, 0.38)),
                             translation_matrix((c[0], -0.07, c[2])))
    return concat_shapes(ground, all_)
