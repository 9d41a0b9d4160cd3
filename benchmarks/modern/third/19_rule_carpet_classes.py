"""
carpets whose patterns come from one- and two-dimensional cellular automata
"""
from helper import *
from abc import abstractmethod
from collections.abc import Iterable
from itertools import product
from typing import ClassVar, Protocol, runtime_checkable


class Pattern:
    registry: ClassVar[dict[str, type['Pattern']]] = {}
    color: ClassVar[tuple[float, float, float]] = (0.5, 0.5, 0.5)

    def __init_subclass__(cls, /, key: str = '', **kwargs):
        super().__init_subclass__(**kwargs)
        Pattern.registry[key or cls.__name__.lower()] = cls

    def __init__(self, size: int):
        self.size = size

    def cells(self) -> set[tuple[int, int]]:
        raise NotImplementedError

    def __len__(self) -> int:
        return len(self.cells())

    def __contains__(self, cell: tuple[int, int]) -> bool:
        return cell in self.cells()


class Wolfram(Pattern, key='rule'):
    color = (0.7, 0.2, 0.25)
    rule = 110

    def cells(self):
        row = [0] * self.size
        row[-1] = 1
        found = set()
        for y in range(self.size):
            found |= {(x, y) for x, alive in enumerate(row) if alive}
            padded = [0, *row, 0]
            row = [self.rule >> (4 * a + 2 * b + c) & 1 for a, b, c in zip(padded, padded[1:], padded[2:])]
        return found


class Life(Pattern):
    color = (0.2, 0.45, 0.3)
    steps = 4

    def cells(self):
        alive = {(x, self.size // 2) for x in range(2, self.size - 2)}
        for _ in range(self.steps):
            near = {}
            for x, y in alive:
                for dx, dy in product((-1, 0, 1), repeat=2):
                    if dx or dy:
                        near[x + dx, y + dy] = near.get((x + dx, y + dy), 0) + 1
            alive = {c for c, n in near.items() if n == 3 or (n == 2 and c in alive)}
        return {(x, y) for x, y in alive if 0 <= x < self.size and 0 <= y < self.size}


class Checks(Pattern):
    color = (0.2, 0.3, 0.6)

    def cells(self):
        return {(x, y) for x, y in product(range(self.size), repeat=2) if (x // 2 + y // 2) % 2 == 0}


@register()
def knot(size: float = 0.2, color: tuple = (0.5, 0.5, 0.5)) -> Shape:
    return primitive_call('cube', color=color, shape_kwargs={'scale': (size * 0.95, 0.06, size * 0.95)})


@register()
def carpet(kind: str = 'rule', size: int = 13, pitch: float = 0.2) -> Shape:
    pattern = Pattern.registry[kind](size)
    half = (size - 1) / 2
    base = primitive_call('cube', color=(0.92, 0.88, 0.78), shape_kwargs={'scale': (size * pitch + 0.2, 0.04, size * pitch + 0.2)})
    knots = [transform_shape(library_call('knot', size=pitch, color=pattern.color), translation_matrix(((x - half) * pitch, 0.04, (y - half) * pitch))) for x, y in sorted(pattern.cells())]
    tassel_count = len(pattern) % 7 + 5
    tassels = [primitive_call('cylinder', color=pattern.color, shape_kwargs={'radius': 0.02, 'p0': (s * (size * pitch / 2 + 0.1), 0, (k / (tassel_count - 1) - 0.5) * size * pitch), 'p1': (s * (size * pitch / 2 + 0.3), 0, (k / (tassel_count - 1) - 0.5) * size * pitch)}) for s in (-1, 1) for k in range(tassel_count)]
    return concat_shapes(base, *knots, *tassels)


@register()
def bazaar() -> Shape:
    names = sorted(Pattern.registry)
    rugs = [transform_shape(library_call('carpet', kind=name), translation_matrix((3.6 * i, 0, 0))) for i, name in enumerate(names)]
    floor = transform_shape(primitive_call('cube', color=(0.6, 0.5, 0.4), shape_kwargs={'scale': (12, 0.1, 4)}), translation_matrix((3.6, -0.08, 0)))
    return concat_shapes(floor, *rugs)
