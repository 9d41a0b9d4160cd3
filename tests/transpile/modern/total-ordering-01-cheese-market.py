from functools import total_ordering, singledispatch, singledispatchmethod
from helper import *

"""
a cheese counter: wheels, wedges and blocks in order of weight
"""


@total_ordering
class Cheese:
    density = 1.1

    def __init__(self, name: str, volume: float) -> None:
        self.name, self.volume = name, volume

    @property
    def weight(self) -> float:
        return round(self.density * self.volume, 3)

    def __eq__(self, other):
        return self.weight == other.weight

    def __lt__(self, other):
        return self.weight < other.weight


class Wheel(Cheese):
    color = (0.95, 0.8, 0.35)


class Block(Cheese):
    color = (0.9, 0.6, 0.2)
    density = 1.3


class Ball(Wheel):
    color = (0.8, 0.15, 0.1)


@singledispatch
def draw(item) -> Shape:
    raise NotImplementedError(type(item).__name__)


@draw.register
def _(item: Wheel) -> Shape:
    r = (item.volume / 1.5) ** (1 / 3)
    return primitive_call('cylinder', color=item.color, shape_kwargs={'radius': r, 'p0': (0, 0, 0), 'p1': (0, r / 2, 0)})


@draw.register(Block)
def draw_block(item) -> Shape:
    a = item.volume ** (1 / 3)
    return transform_shape(primitive_call('cube', color=item.color, shape_kwargs={'scale': (a, a, a)}), translation_matrix((0, a / 2, 0)))


@draw.register(int)
@draw.register(float)
def price_tag(item) -> Shape:
    return primitive_call('cube', color=(1, 1, 1), shape_kwargs={'scale': (0.1 + item / 20, 0.2, 0.02)})


class Counter:
    def __init__(self):
        self.shapes, self.x = [], 0.0

    @singledispatchmethod
    def add(self, item):
        self.shapes.append(transform_shape(draw(item), translation_matrix((self.x, 0, 0))))
        self.x += 1.2

    @add.register
    def _(self, items: list):
        for item in items:
            self.add(item)


@register("cheese counter")
def cheese_counter() -> Shape:
    stock = [Wheel("gouda", 0.4), Block("cheddar", 0.2), Ball("edam", 0.1), Wheel("brie", 0.15), Block("feta", 0.12), Wheel("comte", 0.6)]
    stock.sort()
    counter = Counter()
    counter.add(stock[:3])
    counter.add([c for c in reversed(stock) if c >= stock[3] and c != stock[4]])
    tags = [transform_shape(draw(c.weight * 10 if k % 2 else int(c.weight * 10)), translation_matrix((1.2 * k, -0.3, 0.6))) for k, c in enumerate(stock)]
    try:
        draw("a string")
    except NotImplementedError as e:
        counter.x += len(str(e)) * 0.1
    table = transform_shape(primitive_call('cube', color=(0.5, 0.4, 0.3), shape_kwargs={'scale': (counter.x, 0.1, 1.5)}), translation_matrix((counter.x / 2 - 0.6, -0.05, 0)))
    return concat_shapes(table, *counter.shapes, *tags)
