"""
market stalls described by enums and frozen dataclasses
"""
from helper import *
from dataclasses import dataclass, replace
from enum import Enum, IntEnum, StrEnum
from itertools import cycle, islice, takewhile, count
import math


class Goods(StrEnum):
    FRUIT = 'fruit'
    BREAD = 'bread'
    FISH = 'fish'


class Size(IntEnum):
    SMALL = 1
    MEDIUM = 2
    LARGE = 3


class Palette(Enum):
    RED = (0.8, 0.2, 0.15)
    WHITE = (0.95, 0.95, 0.9)
    WOOD = (0.5, 0.35, 0.2)
    GREEN = (0.3, 0.6, 0.25)
    BROWN = (0.65, 0.45, 0.25)
    SILVER = (0.6, 0.65, 0.7)

    @property
    def rgb(self):
        return self.value

    def darker(self, f: float = 0.7):
        return tuple(c * f for c in self.value)


@dataclass(frozen=True)
class Stall:
    goods: Goods
    size: Size = Size.MEDIUM
    stripes: int = 6

    @property
    def width(self) -> float:
        return 1.0 + 0.5 * self.size

    def color(self) -> Palette:
        return {Goods.FRUIT: Palette.GREEN, Goods.BREAD: Palette.BROWN, Goods.FISH: Palette.SILVER}[self.goods]


def box(color, size, at):
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': size}), translation_matrix(at))


def awning(stall: Stall):
    step = stall.width / stall.stripes
    for color, i in zip(cycle((Palette.RED, Palette.WHITE)), range(stall.stripes)):
        x = -stall.width / 2 + (i + 0.5) * step
        yield transform_shape(
            primitive_call('cube', color=color.rgb, shape_kwargs={'scale': (step, 0.05, 1.4)}),
            translation_matrix((x, 2, 0)) @ rotation_matrix(0.25, (1, 0, 0), (0, 0, 0)))


def heap(stall: Stall):
    widths = list(takewhile(lambda w: w > 0.1, (stall.width * 0.8 - 0.3 * k for k in count())))
    for level, w in enumerate(widths):
        n = max(1, int(w / 0.3))
        for i in range(n):
            yield transform_shape(primitive_call('sphere', color=stall.color().rgb if i % 2 else stall.color().darker(), shape_kwargs={'radius': 0.14}),
                                  translation_matrix(((i - (n - 1) / 2) * 0.29, 1.05 + 0.24 * level, 0)))


@register()
def market_stall(goods: str = 'fruit', size: int = 2, stripes: int = 6) -> Shape:
    stall = Stall(Goods(goods), Size(size), stripes)
    table = box(Palette.WOOD.rgb, (stall.width, 0.1, 0.9), (0, 0.85, 0))
    posts = [box(Palette.WOOD.darker(), (0.08, 2, 0.08), (sx * stall.width / 2, 1, sz * 0.5)) for sx in (-1, 1) for sz in (-1, 1)]
    return concat_shapes(table, *posts, *awning(stall), *heap(stall))


@register()
def market() -> Shape:
    plan = [Stall(Goods.FRUIT, Size.LARGE), Stall(Goods.BREAD), replace(Stall(Goods.FISH), size=Size.SMALL, stripes=4)]
    shapes, x = [], 0.0
    for stall in plan:
        x += stall.width / 2
        shapes.append(transform_shape(library_call('market_stall', goods=stall.goods.value, size=stall.size, stripes=stall.stripes), translation_matrix((x, 0, 0))))
        x += stall.width / 2 + 0.6
    return concat_shapes(*shapes)
