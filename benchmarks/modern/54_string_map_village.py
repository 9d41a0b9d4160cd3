"""a small snowy village at night from a character map"""
from helper import *
from functools import partial
from typing import Callable
import zlib

MAP = """\
TTTTTTTTTTTT
T..H...H..TT
T....#####.T
T.H..#..L#.T
T..###.C.#HT
T..#L....#.T
TH.#######.T
T......H..TT
TTTTTTTTTTTT
"""

CELL = 2.0
BUILDERS: dict[str, Callable[..., Shape]] = {}


def tile(char: str):
    """Class-free dispatch table: binds a map character to a builder."""
    def bind(fn):
        BUILDERS[char] = fn
        return fn
    return bind


def hash01(*key) -> float:
    return zlib.crc32(repr(key).encode()) / 0xFFFFFFFF


def cone(base: float, height: float, n: int, color, y0: float = 0.0) -> Shape:
    return loop(n, lambda i: primitive_call('cylinder', shape_kwargs={
        'radius': base * (n - i) / n, 'p0': (0, y0 + height * i / n, 0), 'p1': (0, y0 + height * (i + 1) / n, 0)}, color=color))


@register()
@tile('T')
def fir(size: float = 1.0) -> Shape:
    trunk = primitive_call('cylinder', shape_kwargs={'radius': 0.1 * size, 'p0': (0, 0, 0), 'p1': (0, 0.5 * size, 0)}, color=(0.35, 0.23, 0.13))
    crown = cone(0.7 * size, 2.0 * size, 5, (0.1, 0.35, 0.22), 0.4 * size)
    snow = cone(0.2 * size, 0.5 * size, 3, (0.97, 0.98, 1.0), 2.1 * size)
    return concat_shapes(trunk, crown, snow)


@register()
@tile('H')
def house(size: float = 1.0) -> Shape:
    walls = transform_shape(primitive_call('cube', shape_kwargs={'scale': (1.4 * size, size, 1.2 * size)}, color=(0.55, 0.38, 0.28)), translation_matrix((0, 0.5 * size, 0)))
    slabs = [primitive_call('cube', shape_kwargs={'scale': (1.5 * size, 0.15 * size, (1.3 - 0.24 * k) * size)}, color=(0.95, 0.97, 1.0)) for k in range(5)]
    roof = [transform_shape(s, translation_matrix((0, (1.07 + 0.15 * k) * size, 0))) for k, s in enumerate(slabs)]
    glow = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.25 * size, 0.3 * size, 0.02)}, color=(1.0, 0.85, 0.4)), translation_matrix((x * size, 0.55 * size, 0.61 * size))) for x in (-0.4, 0.4)]
    return concat_shapes(walls, *roof, *glow)


@register()
@tile('L')
def lantern(size: float = 1.0) -> Shape:
    post = primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (0, 0, 0), 'p1': (0, 1.4 * size, 0)}, color=(0.1, 0.1, 0.1))
    return concat_shapes(post, transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.18}, color=(1, 0.9, 0.55)), translation_matrix((0, 1.5 * size, 0))))


@register()
@tile('C')
def church(size: float = 1.0) -> Shape:
    nave = library_call('house', size=1.2 * size)
    tower = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.7, 2.6, 0.7)}, color=(0.8, 0.78, 0.75)), translation_matrix((-0.9, 1.3, 0)))
    spire = transform_shape(cone(0.5, 1.4, 6, (0.3, 0.35, 0.4), 2.6), translation_matrix((-0.9, 0, 0)))
    return concat_shapes(nave, tower, spire)


@register()
@tile('#')
def road(size: float = 1.0) -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': (CELL, 0.04, CELL)}, color=(0.55, 0.55, 0.6))


@register()
def village() -> Shape:
    rows = MAP.splitlines()
    h, w = len(rows), max(map(len, rows))
    out = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (w * CELL, 0.2, h * CELL)}, color=(0.93, 0.95, 1.0)), translation_matrix((0, -0.1, 0)))]
    for r, row in enumerate(rows):
        for c, ch in enumerate(row):
            if (builder := BUILDERS.get(ch)) is None:
                continue
            make = partial(library_call, builder.__name__)
            size = 0.8 + 0.4 * hash01(r, c) if ch in 'TH' else 1.0
            out.append(transform_shape(make(size=size), translation_matrix(((c - w / 2 + 0.5) * CELL, 0, (r - h / 2 + 0.5) * CELL))))
    return concat_shapes(*out)
