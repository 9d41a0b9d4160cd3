from itertools import combinations, permutations, combinations_with_replacement, islice
import math
from helper import *

"""
molecule models: bonds between all pairs of near atoms
"""

ATOMS = {"H": ((0.95, 0.95, 0.95), 0.15), "C": ((0.2, 0.2, 0.2), 0.25), "O": ((0.9, 0.1, 0.1), 0.22), "N": ((0.2, 0.3, 0.9), 0.23)}

MOLECULES = {
    "water": [("O", 0, 0, 0), ("H", 0.6, 0.45, 0), ("H", -0.6, 0.45, 0)],
    "methane": [("C", 0, 0, 0)] + [("H", *(0.45 * s for s in signs)) for signs in [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]],
    "carbon dioxide": [("C", 0, 0, 0), ("O", 0.8, 0, 0), ("O", -0.8, 0, 0)],
    "ammonia": [("N", 0, 0.2, 0)] + [("H", 0.6 * math.cos(a), -0.1, 0.6 * math.sin(a)) for a in (0, 2.094, 4.189)],
}


def bonded(a, b, cutoff: float = 0.85) -> bool:
    return math.dist(a[1:], b[1:]) < cutoff


@register()
def molecule(name: str) -> Shape:
    atoms = MOLECULES[name]
    balls = []
    for symbol, x, y, z in atoms:
        color, radius = ATOMS[symbol]
        balls.append(transform_shape(primitive_call('sphere', color=color, shape_kwargs={'radius': radius}), translation_matrix((x, y, z))))
    sticks = [
        primitive_call('cylinder', color=(0.6, 0.6, 0.6), shape_kwargs={'radius': 0.06, 'p0': a[1:], 'p1': b[1:]})
        for a, b in combinations(atoms, 2) if bonded(a, b)
    ]
    return concat_shapes(*balls, *sticks)


@register()
def shelf_code(colors: tuple) -> Shape:
    return loop(len(colors), lambda i: transform_shape(primitive_call('cube', color=ATOMS[colors[i]][0], shape_kwargs={'scale': (0.2, 0.2, 0.2)}), translation_matrix((0.22 * i, 0, 0))))


@register()
def chemistry_shelf() -> Shape:
    shapes = []
    for k, name in enumerate(MOLECULES):
        shapes.append(transform_shape(library_call('molecule', name=name), translation_matrix((2 * k, 1, 0))))
    for k, code in enumerate(islice(permutations("HCON", 3), 0, 24, 3)):
        shapes.append(transform_shape(library_call('shelf_code', colors=code), translation_matrix((0.9 * k, -0.2, 0.5))))
    for k, code in enumerate(combinations_with_replacement("CO", 3)):
        shapes.append(transform_shape(library_call('shelf_code', colors=code), translation_matrix((0.9 * k, -0.6, 0.5))))
    board = primitive_call('cube', color=(0.6, 0.45, 0.3), shape_kwargs={'scale': (8, 0.1, 1.5)})
    return concat_shapes(transform_shape(board, translation_matrix((3, 0, 0))), *shapes)
