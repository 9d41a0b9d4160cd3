"""a level-2 Menger sponge with a shiny core"""
from helper import *
from itertools import product


def is_solid(cell: tuple[int, int, int]) -> bool:
    return sum(c == 0 for c in cell) < 2


def menger(level: int, center=(0.0, 0.0, 0.0), size: float = 1.0):
    if level == 0:
        yield center, size
        return
    third = size / 3
    for cell in filter(is_solid, product((-1, 0, 1), repeat=3)):
        yield from menger(level - 1, tuple(c + d * third for c, d in zip(center, cell)), third)


@register()
def little_cube(center, size) -> Shape:
    r, g, b = (0.5 + c / 2 for c in center)
    clamp = lambda v: max(0.0, min(1.0, v))
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': [size] * 3}, color=(clamp(r), clamp(g), clamp(b))), translation_matrix(center))


@register()
def sponge(level: int = 2, size: float = 1.0) -> Shape:
    pieces = [library_call('little_cube', center=c, size=s) for c, s in menger(level, size=size)]
    assert len(pieces) == 20 ** level
    return concat_shapes(*pieces)


@register()
def sponge_with_core() -> Shape:
    core = primitive_call('sphere', shape_kwargs={'radius': 0.16}, color=(1.0, 0.84, 0.0))
    s = transform_shape(library_call('sponge'), scale_matrix(2.0, (0, 0, 0)))
    return concat_shapes(s, core)
