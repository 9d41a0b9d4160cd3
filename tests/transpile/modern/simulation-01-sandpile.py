from __future__ import annotations
import numpy as np
from collections import deque
from helper import *

"""
an abelian sandpile after it came to rest
"""


class Sandpile:
    def __init__(self, size: int):
        self.grid = np.zeros((size, size), dtype=int)
        self.lost = 0
        self.topples = 0

    def drop(self, row: int, col: int, grains: int = 1) -> Sandpile:
        self.grid[row, col] += grains
        queue = deque([(row, col)] if self.grid[row, col] > 3 else [])
        while queue:
            r, c = queue.popleft()
            if self.grid[r, c] <= 3:
                continue
            share, self.grid[r, c] = divmod(int(self.grid[r, c]), 4)
            self.topples += 1
            for dr, dc in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                y, x = r + dr, c + dc
                if not (0 <= y < len(self.grid) and 0 <= x < len(self.grid)):
                    self.lost += share
                    continue
                self.grid[y, x] += share
                if self.grid[y, x] > 3:
                    queue.append((y, x))
        return self


LEVELS = [(0.9, 0.85, 0.7), (0.85, 0.7, 0.4), (0.75, 0.5, 0.2), (0.55, 0.3, 0.1)]


@register()
def grain_column(n: int) -> Shape:
    h = 0.25 * n
    return transform_shape(primitive_call('cube', color=LEVELS[n], shape_kwargs={'scale': (0.9, h, 0.9)}), translation_matrix((0, h / 2, 0)))


@register()
def sandbox(size: int = 13) -> Shape:
    pile = Sandpile(size)
    middle = size // 2
    pile.drop(middle, middle, 300)
    for k in range(40):
        pile.drop((5 * k) % size, (3 * k + 1) % size)
    total = int(pile.grid.sum()) + pile.lost
    assert total == 340 and pile.grid.max() <= 3
    shapes = [transform_shape(library_call('grain_column', n=int(n)), translation_matrix((c - middle, 0, r - middle))) for (r, c), n in np.ndenumerate(pile.grid) if n > 0]
    frame = [transform_shape(primitive_call('cube', color=(0.5, 0.35, 0.2), shape_kwargs={'scale': (size + 0.6, 0.8, 0.3)}), rotation_matrix(k * np.pi / 2, (0, 1, 0), (0, 0, 0)) @ translation_matrix((0, 0.4, size / 2 + 0.15))) for k in range(4)]
    spill = loop(pile.lost // 10, lambda i: transform_shape(primitive_call('sphere', color=LEVELS[1], shape_kwargs={'radius': 0.2}), translation_matrix((0.5 * i - 4, 0.2, size / 2 + 1))))
    gauge = primitive_call('cylinder', color=(0.2, 0.4, 0.7), shape_kwargs={'radius': 0.2, 'p0': (-size / 2 - 1, 0, 0), 'p1': (-size / 2 - 1, pile.topples / 50, 0)})
    return concat_shapes(*frame, *shapes, spill, gauge)
