"""a farmers' market: stalls with awnings and heaps of fruit, from a price list"""
from helper import *
import math
import random
from functools import partial, reduce
from operator import attrgetter
from dataclasses import dataclass, field, InitVar

random.seed(2026)

PRICES = """
apples; 2.40; 0.85 0.15 0.12; 0.085; 26
oranges; 3.10; 0.98 0.55 0.10; 0.095; 22
limes; 4.80; 0.45 0.75 0.20; 0.065; 30
melons; 1.90; 0.55 0.70 0.35; 0.180; 7
plums; 3.60; 0.40 0.12 0.40; 0.060; 34
pumpkins; 1.20; 0.92 0.48 0.08; 0.240; 5
"""


@dataclass
class Goods:
    name: str
    price: float
    color: tuple[float, ...]
    radius: float
    amount: int
    sale: InitVar[bool] = False
    label: str = field(init=False)

    def __post_init__(self, sale: bool) -> None:
        if sale:
            self.price *= 0.5
        self.label = f"{self.name:<10}{self.price:>6.2f}"

    @classmethod
    def parse(cls, line: str) -> 'Goods':
        name, price, color, radius, amount = (part.strip() for part in line.split(';'))
        return cls(name, float(price), tuple(map(float, color.split())), float(radius), int(amount), sale=name == 'plums')


GOODS = sorted(map(Goods.parse, PRICES.strip().split('\n')), key=attrgetter('price'))


def box(size, at, color):
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}, color=color), translation_matrix(at))


wooden = partial(box, color=(0.58, 0.41, 0.24))


@register("fruit in layers within a crate; upper layers are smaller")
def heap(index: int = 0, width: float = 0.9, depth: float = 0.6) -> Shape:
    goods = GOODS[index % len(GOODS)]
    d = goods.radius * 2
    left, layer, shapes = goods.amount, 0, []
    while left > 0:
        columns = max(1, int(width / d) - layer)
        rows = max(1, int(depth / d) - layer)
        for k in range(min(left, columns * rows)):
            row, column = divmod(k, columns)
            jitter = random.uniform(-0.08, 0.08) * d
            x = (column - (columns - 1) / 2) * d + jitter
            z = (row - (rows - 1) / 2) * d
            fruit = primitive_call('sphere', shape_kwargs={'radius': goods.radius}, color=goods.color)
            shapes.append(transform_shape(fruit, translation_matrix((x, goods.radius + layer * d * 0.8, z))))
        left -= columns * rows
        layer += 1
    return concat_shapes(*shapes)


@register()
def crate(width: float = 1.0, depth: float = 0.7, height: float = 0.18) -> Shape:
    return concat_shapes(
        wooden((width, 0.03, depth), (0, 0, 0)),
        *(wooden((width, height, 0.03), (0, height / 2, s * depth / 2)) for s in (-1, 1)),
        *(wooden((0.03, height, depth), (s * width / 2, height / 2, 0)) for s in (-1, 1)))


@register("a striped awning that slopes toward the customer")
def awning(width: float = 2.4, stripes: int = 9, color: tuple[float, float, float] = (0.2, 0.5, 0.3)) -> Shape:
    pitch = width / stripes
    cloth = loop(stripes, lambda i: box((pitch, 0.03, 1.5), ((i + 0.5) * pitch - width / 2, 0, 0), color if i % 2 == 0 else (0.95, 0.94, 0.9)))
    return transform_shape(cloth, rotation_matrix(math.radians(15), (1, 0, 0), (0, 0, 0)))


@register("a stall that sells two kinds of goods")
def stall(first: int = 0, color: tuple[float, float, float] = (0.2, 0.5, 0.3)) -> Shape:
    table = wooden((2.3, 0.06, 0.9), (0, 0.8, 0))
    poles = [primitive_call('cylinder', shape_kwargs={'radius': 0.035, 'p0': (sx * 1.1, 0, sz * 0.42), 'p1': (sx * 1.1, 2.1 - 0.1 * sz, sz * 0.42)}, color=(0.4, 0.3, 0.2))
             for sx in (-1, 1) for sz in (-1, 1)]
    display = []
    for k in range(2):
        spot = translation_matrix((1.1 * k - 0.55, 0.86, 0))
        display.append(transform_shape(concat_shapes(library_call('crate'), library_call('heap', index=first + k)), spot))
        price = GOODS[(first + k) % len(GOODS)].price  # a tag as high as the price
        display.append(box((0.3, 0.05 * price, 0.02), (1.1 * k - 0.55, 1.1 + 0.025 * price, 0.42), (1.0, 0.95, 0.5)))
    return concat_shapes(table, *poles, *display, transform_shape(library_call('awning', color=color), translation_matrix((0, 2.15, 0.1))))


@register()
def farmers_market() -> Shape:
    print(*(g.label for g in GOODS), sep='\n')
    total = reduce(lambda sum_, g: sum_ + g.price * g.amount, GOODS, 0.0)
    colors = [(0.2, 0.5, 0.3), (0.75, 0.2, 0.2), (0.2, 0.35, 0.65)]
    stalls = [transform_shape(library_call('stall', first=2 * k, color=c), translation_matrix((3.0 * (k - 1), 0, 0))) for k, c in enumerate(colors)]
    ground = box((10, 0.1, 4), (0, -0.05, 0.5), (0.68, 0.66, 0.62))
    # a till whose coins stand for the value of all goods
    coins = loop(int(total // 50), lambda i: primitive_call('cylinder', shape_kwargs={'radius': 0.08, 'p0': (4.6, 0.03 * i, 1.2), 'p1': (4.6, 0.03 * i + 0.025, 1.2)}, color=(0.9, 0.75, 0.3)))
    return concat_shapes(ground, *stalls, coins)
