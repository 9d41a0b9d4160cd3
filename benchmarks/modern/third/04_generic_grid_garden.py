"""
a vegetable garden in raised beds, planned on a grid
"""
from helper import *
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
import math


class Crop(StrEnum):
    CARROT = 'c'
    LETTUCE = 'l'
    TOMATO = 't'
    PATH = '.'

    @property
    def color(self) -> tuple[float, float, float]:
        match self:
            case Crop.CARROT:
                return (0.95, 0.5, 0.1)
            case Crop.LETTUCE:
                return (0.45, 0.75, 0.25)
            case Crop.TOMATO:
                return (0.85, 0.15, 0.1)
            case _:
                return (0.7, 0.65, 0.5)


@dataclass
class Grid[T]:
    width: int
    height: int
    cells: list[T]

    def __getitem__(self, key: tuple[int, int]) -> T:
        x, y = key
        return self.cells[y * self.width + x]

    def __iter__(self) -> Iterator[tuple[int, int, T]]:
        for i, cell in enumerate(self.cells):
            y, x = divmod(i, self.width)
            yield x, y, cell

    def map[U](self, f: Callable[[T], U]) -> 'Grid[U]':
        return Grid(self.width, self.height, [f(c) for c in self.cells])

    def count(self, predicate: Callable[[T], bool]) -> int:
        return sum(1 for c in self.cells if predicate(c))


PLAN = """
cccc.ttt
llll.ttt
.....ttt
cclltttt
"""


def parse(text: str) -> Grid[Crop]:
    rows = text.split()
    return Grid(len(rows[0]), len(rows), [Crop(ch) for row in rows for ch in row])


@register()
def plant(kind: str = 'c', size: float = 0.3) -> Shape:
    crop = Crop(kind)
    if crop is Crop.TOMATO:
        stake = primitive_call('cylinder', color=(0.5, 0.4, 0.2), shape_kwargs={'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0, 3 * size, 0)})
        fruits = [transform_shape(primitive_call('sphere', color=crop.color, shape_kwargs={'radius': size * 0.35}),
                                  translation_matrix((size * 0.4 * math.cos(k * 2.4), size * (0.8 + 0.5 * k), size * 0.4 * math.sin(k * 2.4)))) for k in range(4)]
        return concat_shapes(stake, *fruits)
    if crop is Crop.LETTUCE:
        return primitive_call('sphere', color=crop.color, shape_kwargs={'radius': size})
    tops = [primitive_call('cylinder', color=(0.3, 0.6, 0.2), shape_kwargs={'radius': 0.03, 'p0': (0, 0.1, 0), 'p1': (dx, size * 1.6, 0)}) for dx in (-0.12, 0.0, 0.12)]
    root = primitive_call('sphere', color=crop.color, shape_kwargs={'radius': size * 0.5})
    return concat_shapes(root, *tops)


@register()
def garden(cell: float = 1.0) -> Shape:
    grid = parse(PLAN)
    heights = grid.map(lambda c: 0.1 if c == Crop.PATH else 0.4)
    parts = []
    for x, y, crop in grid:
        h = heights[x, y]
        soil = primitive_call('cube', color=crop.color if crop is Crop.PATH else (0.35, 0.22, 0.12), shape_kwargs={'scale': (cell * 0.98, h, cell * 0.98)})
        parts.append(transform_shape(soil, translation_matrix((x * cell, h / 2, y * cell))))
        if crop is not Crop.PATH:
            parts.append(transform_shape(library_call('plant', kind=crop.value), translation_matrix((x * cell, h, y * cell))))
    planted = grid.count(lambda c: c is not Crop.PATH)
    sign = transform_shape(primitive_call('cube', color=(0.9, 0.85, 0.7), shape_kwargs={'scale': (0.05 * planted, 0.4, 0.05)}), translation_matrix((grid.width / 2 - 0.5, 1.6, -1)))
    return concat_shapes(*parts, sign)
