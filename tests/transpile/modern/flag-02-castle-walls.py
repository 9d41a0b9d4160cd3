from enum import IntFlag
from functools import reduce
import operator
from helper import *

"""
castle courtyards: each cell has walls on some of its sides
"""

class Side(IntFlag):
    NORTH = 1
    EAST = 2
    SOUTH = 4
    WEST = 8

OFFSETS = {Side.NORTH: (0, -1), Side.EAST: (1, 0), Side.SOUTH: (0, 1), Side.WEST: (-1, 0)}
OPPOSITE = {Side.NORTH: Side.SOUTH, Side.SOUTH: Side.NORTH, Side.EAST: Side.WEST, Side.WEST: Side.EAST}
FOOTPRINT = """
.###.
#####
##.##
.###.
"""

def parse(text: str) -> set[tuple[int, int]]:
    rows = [line for line in text.splitlines() if line]
    return {(x, z) for z, row in enumerate(rows) for x, ch in enumerate(row) if ch == "#"}

def walls_of(cell: tuple[int, int], cells: set[tuple[int, int]]) -> Side:
    free = [side for side, (dx, dz) in OFFSETS.items() if (cell[0] + dx, cell[1] + dz) not in cells]
    return reduce(operator.or_, free, Side(0))

@register()
def wall(side: int, height: float = 1.0) -> Shape:
    dx, dz = OFFSETS[Side(side)]
    slab = primitive_call('cube', color=(0.6, 0.58, 0.55), shape_kwargs={'scale': (0.1 if dx else 1.1, height, 0.1 if dz else 1.1)})
    return transform_shape(slab, translation_matrix((0.5 * dx, height / 2, 0.5 * dz)))

@register()
def tower() -> Shape:
    body = primitive_call('cylinder', color=(0.5, 0.48, 0.46), shape_kwargs={'radius': 0.22, 'p0': (0, 0, 0), 'p1': (0, 1.6, 0)})
    roof = primitive_call('sphere', color=(0.6, 0.15, 0.1), shape_kwargs={'radius': 0.24})
    return concat_shapes(body, transform_shape(roof, translation_matrix((0, 1.6, 0))))

@register()
def castle() -> Shape:
    cells = parse(FOOTPRINT)
    shapes = []
    for cell in sorted(cells):
        sides = walls_of(cell, cells)
        here = translation_matrix((cell[0], 0, cell[1]))
        floor = primitive_call('cube', color=(0.45, 0.5, 0.35) if sides else (0.3, 0.6, 0.3), shape_kwargs={'scale': (1, 0.05, 1)})
        parts = [floor]
        for side in Side:
            if sides & side:
                parts.append(library_call('wall', side=side.value))
                if sides & OPPOSITE[side]:
                    parts.append(transform_shape(library_call('tower'), translation_matrix((0.5 * OFFSETS[side][0], 0, 0.5 * OFFSETS[side][1]))))
        # a corner tower where north and west are both walled
        if sides & (Side.NORTH | Side.WEST) == Side.NORTH | Side.WEST:
            parts.append(transform_shape(library_call('tower'), translation_matrix((-0.5, 0, -0.5))))
        shapes.append(transform_shape(concat_shapes(*parts), here))
    return concat_shapes(*shapes)
