"""
a voxel ship made with set operations
"""
from helper import *
from collections import Counter, defaultdict
from functools import reduce
import operator

Voxel = tuple[int, int, int]


class Voxels(dict):
    pass


def box(x0, y0, z0, x1, y1, z1) -> set[Voxel]:
    return {(x, y, z) for x in range(x0, x1 + 1) for y in range(y0, y1 + 1) for z in range(z0, z1 + 1)}


def ball(cx, cy, cz, r) -> set[Voxel]:
    k = int(r) + 1
    return {
        (cx + dx, cy + dy, cz + dz)
        for dx in range(-k, k + 1) for dy in range(-k, k + 1) for dz in range(-k, k + 1)
        if dx * dx + dy * dy + dz * dz <= r * r
    }


def shell(cells: set[Voxel]) -> set[Voxel]:
    def hidden(c):
        x, y, z = c
        return all(n in cells for n in ((x + 1, y, z), (x - 1, y, z), (x, y + 1, z), (x, y - 1, z), (x, y, z + 1), (x, y, z - 1)))
    return {c for c in cells if not hidden(c)}


LAYERS = {
    'hull': (0.45, 0.3, 0.18),
    'deck': (0.75, 0.6, 0.4),
    'sail': (0.95, 0.95, 0.9),
}


@register()
def voxel(color) -> Shape:
    return primitive_call('cube', color=color, shape_kwargs={'scale': 0.98})


@register()
def ship() -> Shape:
    hull = reduce(operator.or_, (box(-5 + abs(y - 1), y, -2, 5 - abs(y - 1), y, 2) for y in range(3)))
    hull -= box(-3, 2, -1, 3, 2, 1)
    hull |= ball(5, 1, 0, 1.5)
    deck = box(-3, 1, -1, 3, 1, 1) - {(0, 1, 0)}
    mast = {(0, y, 0) for y in range(1, 9)}
    sail = {(1, y, z) for y in range(4, 8) for z in range(-2, 3) if abs(z) <= 8 - y}
    grid: dict[Voxel, str] = {}
    for name, cells in (('hull', shell(hull)), ('deck', deck), ('hull', mast), ('sail', sail)):
        for c in cells:
            grid[c] = name
    tally = Counter(grid.values())
    by_layer = defaultdict(list)
    for c in sorted(grid):
        by_layer[grid[c]].append(c)
    shapes = []
    for name, _ in tally.most_common():
        for c in by_layer[name]:
            shapes.append(transform_shape(library_call('voxel', color=LAYERS[name]), translation_matrix(c)))
    return concat_shapes(*shapes)
