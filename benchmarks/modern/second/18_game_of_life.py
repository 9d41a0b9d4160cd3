"""
a tower made of the generations of Conway's game of life, stacked as coloured layers
"""
from helper import *
import colorsys
from collections import Counter
from itertools import islice, product, takewhile
from typing import Iterator

Cells = frozenset[tuple[int, int]]

R_PENTOMINO = """
.XX
XX.
.X.
"""

GLIDER = """
.X.
..X
XXX
"""


def parse(art: str, at: tuple[int, int] = (0, 0)) -> Cells:
    ox, oz = at
    return frozenset((x + ox, z + oz) for z, row in enumerate(art.strip().splitlines()) for x, ch in enumerate(row) if ch == 'X')


def evolve(cells: Cells) -> Iterator[Cells]:
    while cells:
        yield cells
        around = Counter((x + dx, z + dz) for x, z in cells for dx, dz in product((-1, 0, 1), repeat=2) if dx or dz)
        cells = frozenset(c for c, n in around.items() if n == 3 or (n == 2 and c in cells))


def rainbow(i: int, n: int) -> tuple[float, float, float]:
    return colorsys.hsv_to_rgb(0.55 + 0.4 * i / max(n - 1, 1), 0.65, 0.95)


@register()
def cell_block(size: float = 0.9, height: float = 0.9, color: tuple = (0.4, 0.6, 0.9)) -> Shape:
    return primitive_call('cube', {'scale': (size, height, size)}, color=color)


@register()
def layer(cells: Cells = parse(GLIDER), color: tuple = (0.4, 0.6, 0.9), size: float = 0.9) -> Shape:
    if not cells:
        raise ValueError('a layer needs a living cell')
    return concat_shapes(*(transform_shape(library_call('cell_block', size=size, color=color), translation_matrix((x, 0, z)))
                           for x, z in sorted(cells)))


@register()
def life_tower(generations: int = 16, seed_art: str = R_PENTOMINO) -> Shape:
    history = list(islice(takewhile(lambda c: len(c) < 200, evolve(parse(seed_art))), generations))
    layers = []
    for i, cells in enumerate(history):
        level = library_call('layer', cells=cells, color=rainbow(i, len(history)))
        layers.append(transform_shape(level, translation_matrix((0, i, 0))))
    return concat_shapes(*layers)


@register()
def base_plate(width: float = 8.0, depth: float = 8.0, studs: int = 5) -> Shape:
    plate = primitive_call('cube', {'scale': (width, 0.5, depth)}, color=(0.2, 0.2, 0.23))
    dots = []
    for i, j in product(range(studs), repeat=2):
        u, v = ((k + 0.5) / studs - 0.5 for k in (i, j))
        stud = primitive_call('cylinder', {'radius': 0.2, 'p0': (0, 0.25, 0), 'p1': (0, 0.35, 0)}, color=(0.3, 0.3, 0.33))
        dots.append(transform_shape(stud, translation_matrix((u * width, 0, v * depth))))
    return concat_shapes(plate, *dots)


@register()
def life_sculpture(generations: int = 14) -> Shape:
    tower = library_call('life_tower', generations=generations)
    lo, hi = compute_shape_min(tower), compute_shape_max(tower)
    mid = (lo + hi) / 2
    tower = transform_shape(tower, translation_matrix((-mid[0], -lo[1], -mid[2])))
    plate = library_call('base_plate', width=float(hi[0] - lo[0]) + 2, depth=float(hi[2] - lo[2]) + 2)
    plate = transform_shape(plate, translation_matrix((0, -0.25, 0)))
    glider = library_call('layer', cells=parse(GLIDER), color=(0.95, 0.8, 0.2), size=0.5)
    glider = transform_shape(transform_shape(glider, scale_matrix(0.5, (0, 0, 0))), translation_matrix((hi[0] - mid[0], 0.3, hi[2] - mid[2])))
    return concat_shapes(plate, tower, glider)
