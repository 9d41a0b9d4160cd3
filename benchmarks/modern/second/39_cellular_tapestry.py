"""
a woven tapestry showing the elementary cellular automaton rule 90, hanging from a rod
"""
from helper import *
from itertools import islice
import numpy as np


def automaton(rule: int, width: int):
    table = np.array([(rule >> k) & 1 for k in range(8)], dtype=np.uint8)
    row = np.zeros(width, dtype=np.uint8)
    row[width // 2] = 1
    while True:
        yield row
        code = np.roll(row, 1) * 4 + row * 2 + np.roll(row, -1)
        row = table[code]


@register()
def stitch(size: float = 0.15, on: bool = True, warp: bool = False) -> Shape:
    color = (0.7, 0.15, 0.2) if on else (0.93, 0.88, 0.76)
    dims = (size * 0.7, size, size * 0.4) if warp else (size, size * 0.7, size * 0.4)
    return primitive_call('cube', {'scale': dims}, color=color)


@register()
def tapestry(rule: int = 90, width: int = 31, rows: int = 16, size: float = 0.15) -> Shape:
    grid = np.array(list(islice(automaton(rule, width), rows)))
    y, x = np.indices(grid.shape)
    sag = 0.05 * np.sin(x / width * 4 * np.pi)
    weave = np.where((x + y) % 2 == 0, 0.02, -0.02)
    place = np.stack([(x - (width - 1) / 2) * size, -y * size, sag + weave], axis=-1)
    return [part
            for idx in np.ndindex(grid.shape)
            for part in transform_shape(library_call('stitch', size=size, on=bool(grid[idx]), warp=sum(idx) % 2 == 0), translation_matrix(place[idx]))]


@register()
def fringe(width: float = 4.6, threads: int = 24, length: float = 0.4) -> Shape:
    xs = np.linspace(-width / 2, width / 2, threads)
    ends = xs + 0.03 * (-1) ** np.arange(threads)
    return loop(threads, lambda i: primitive_call('cylinder', {'radius': 0.015, 'p0': (xs[i], 0, 0), 'p1': (ends[i], -length, 0)}, color=(0.85, 0.75, 0.5)))


@register()
def hanging_tapestry() -> Shape:
    cloth = library_call('tapestry')
    lo, hi = compute_shape_min(cloth), compute_shape_max(cloth)
    w = float(hi[0] - lo[0])
    tassels = transform_shape(library_call('fringe', width=w), translation_matrix((0, lo[1], 0)))
    rod = primitive_call('cylinder', {'radius': 0.07, 'p0': (-w / 2 - 0.4, hi[1] + 0.1, 0), 'p1': (w / 2 + 0.4, hi[1] + 0.1, 0)}, color=(0.4, 0.25, 0.12))
    knobs = [transform_shape(primitive_call('sphere', {'radius': 0.13}, color=(0.8, 0.65, 0.3)), translation_matrix((s * (w / 2 + 0.4), hi[1] + 0.1, 0))) for s in (-1, 1)]
    wall = transform_shape(primitive_call('cube', {'scale': (w + 2, 5, 0.1)}, color=(0.75, 0.76, 0.72)), translation_matrix((0, -1.2, -0.25)))
    return concat_shapes(wall, rod, *knobs, cloth, tassels)
