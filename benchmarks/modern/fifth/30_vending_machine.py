"""a vending machine stocked from a JSON inventory, with coins on the floor"""
from helper import *
from collections import ChainMap
from dataclasses import dataclass, asdict
from decimal import Decimal, ROUND_HALF_UP
from enum import IntEnum
import json
import math
import textwrap

INVENTORY = json.loads(textwrap.dedent('''
    {
      "machine": {"columns": 5, "shelf_height": 0.36, "lights": true},
      "defaults": {"shape": "can", "stock": 4, "price": "1.20"},
      "slots": [
        {"code": "A1", "name": "cola", "color": [0.8, 0.1, 0.1]},
        {"code": "A2", "name": "lemon soda", "color": [0.95, 0.9, 0.2], "stock": 3},
        {"code": "A3", "name": "iced tea", "color": [0.7, 0.45, 0.2], "price": "1.45"},
        {"code": "A5", "name": "tonic", "color": [0.7, 0.8, 0.85], "stock": 1},
        {"code": "B1", "name": "chips", "shape": "bag", "color": [0.95, 0.6, 0.1], "price": "1.80"},
        {"code": "B2", "name": "pretzels", "shape": "bag", "color": [0.3, 0.5, 0.8], "stock": 2},
        {"code": "B4", "name": "nuts", "shape": "bag", "color": [0.5, 0.7, 0.3], "price": "2.10"},
        {"code": "C1", "name": "chocolate", "shape": "bar", "color": [0.4, 0.2, 0.12], "price": "0.95", "stock": 5},
        {"code": "C2", "name": "gum", "shape": "bar", "color": [0.9, 0.5, 0.7], "price": "0.50", "stock": 5},
        {"code": "C3", "name": "water", "shape": "bottle", "color": [0.6, 0.8, 0.95], "price": "0.85"},
        {"code": "C5", "name": "juice", "shape": "bottle", "color": [0.95, 0.6, 0.2], "stock": 0}
      ]
    }
'''))


class Coin(IntEnum):
    """Value in cents."""
    TWO_EURO = 200
    EURO = 100
    FIFTY = 50
    TWENTY = 20
    TEN = 10
    FIVE = 5

    @property
    def radius(self) -> float:
        return 0.02 + 0.003 * math.log2(self.value)


@dataclass(slots=True, kw_only=True)
class Slot:
    code: str
    name: str
    shape: str
    stock: int
    price: Decimal
    color: tuple

    @classmethod
    def parse(cls, entry: dict) -> 'Slot':
        merged = ChainMap(entry, INVENTORY['defaults'])
        price = Decimal(merged['price']).quantize(Decimal('0.05'), rounding=ROUND_HALF_UP)
        return cls(code=merged['code'], name=merged['name'], shape=merged['shape'], stock=merged['stock'], price=price, color=tuple(merged['color']))

    @property
    def row(self) -> int:
        return ord(self.code[0]) - ord('A')

    @property
    def column(self) -> int:
        return int(self.code[1:]) - 1


SLOTS = [Slot.parse(e) for e in INVENTORY['slots']]


def change(amount: Decimal) -> list[Coin]:
    cents, coins = int(amount * 100), []
    for coin in Coin:
        n, cents = divmod(cents, coin)
        coins.extend([coin] * n)
    return coins


@register()
def product(shape: str = 'can', color: tuple = (0.8, 0.1, 0.1)) -> Shape:
    match shape, color:
        case 'can', c:
            return concat_shapes(primitive_call('cylinder', shape_kwargs={'radius': 0.055, 'p0': (0, 0, 0), 'p1': (0, 0.2, 0)}, color=c),
                                 primitive_call('cylinder', shape_kwargs={'radius': 0.045, 'p0': (0, 0.2, 0), 'p1': (0, 0.21, 0)}, color=(0.8, 0.8, 0.82)))
        case 'bag', c:
            bag = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=c), translation_matrix((0, 0.12, 0)) @ scale_matrix((0.8, 1.1, 0.4), (0, 0, 0)))
            return concat_shapes(bag, *[transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.13, 0.02, 0.01)}, color=c), translation_matrix((0, y, 0))) for y in (0.01, 0.23)])
        case 'bar', c:
            return transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.08, 0.18, 0.03)}, color=c), translation_matrix((0, 0.09, 0)))
        case 'bottle', c:
            return concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, y0, 0), 'p1': (0, y1, 0)}, color=k) for r, y0, y1, k in ((0.05, 0, 0.16, c), (0.035, 0.16, 0.2, c), (0.018, 0.2, 0.24, c), (0.022, 0.24, 0.27, (1, 1, 1)))])
        case other, _:
            raise ValueError(f'no product shape {other!r}')


@register()
def shelves(pitch: float = 0.22) -> Shape:
    machine = INVENTORY['machine']
    height, columns = machine['shelf_height'], machine['columns']
    out = []
    for slot in SLOTS:
        x = (slot.column - (columns - 1) / 2) * pitch
        y = (2 - slot.row) * height
        for k in range(slot.stock):
            p = library_call('product', **{key: v for key, v in asdict(slot).items() if key in {'shape', 'color'}})
            out.append(transform_shape(p, translation_matrix((x, y, -0.12 * k))))
        # price label: one tick for every 50 cents
        ticks = int(slot.price / Decimal('0.5'))
        out += [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.015, 0.025, 0.005)}, color=(0.2, 1, 0.4)), translation_matrix((x - 0.03 + 0.025 * t, y - 0.025, 0.08))) for t in range(ticks)]
    boards = loop(3, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (columns * pitch, 0.02, 0.6)}, color=(0.75, 0.75, 0.78)), translation_matrix((0, i * height - 0.01, -0.2))))
    return concat_shapes(boards, *out)


@register()
def cabinet(width: float = 1.6, height: float = 2.0, depth: float = 0.8) -> Shape:
    body = (0.15, 0.25, 0.5)
    panels = [((width, 0.08, depth), (0, height, 0)), ((width, 0.5, depth), (0, 0.25, 0)), ((0.08, height, depth), (-width / 2, height / 2, 0)), ((0.4, height, depth), (width / 2 - 0.16, height / 2, 0)), ((width, height, 0.05), (0, height / 2, -depth / 2))]
    keypad = loop(12, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.06, 0.05, 0.02)}, color=(0.9, 0.9, 0.9)), translation_matrix((width / 2 - 0.24 + 0.08 * (i % 3), 1.3 - 0.08 * (i // 3), depth / 2))))
    tubes = [primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (x, 0.55, depth / 2 - 0.1), 'p1': (x, height - 0.1, depth / 2 - 0.1)}, color=(0.95, 1, 1)) for x in (-width / 2 + 0.07, width / 2 - 0.4)] if INVENTORY['machine']['lights'] else []
    return concat_shapes(*[transform_shape(primitive_call('cube', shape_kwargs={'scale': s}, color=body), translation_matrix(p)) for s, p in panels], keypad, *tubes)


@register()
def coins(paid: str = '20', bought: str = 'A3') -> Shape:
    slot = next((s for s in SLOTS if s.code == bought), SLOTS[0])
    out = []
    for i, coin in enumerate(change(Decimal(paid) - slot.price)):
        x, z = 0.16 * (i % 6) - 0.4, 0.7 + 0.15 * (i // 6)
        color = (0.85, 0.7, 0.3) if coin < Coin.EURO else (0.8, 0.8, 0.78)
        out.append(primitive_call('cylinder', shape_kwargs={'radius': coin.radius, 'p0': (x, 0, z), 'p1': (x, 0.012, z)}, color=color))
    return concat_shapes(*out)


@register()
def vending_corner() -> Shape:
    floor = transform_shape(primitive_call('cube', shape_kwargs={'scale': (3, 0.06, 3)}, color=(0.6, 0.6, 0.58)), translation_matrix((0, -0.03, 0.3)))
    goods = transform_shape(library_call('shelves'), translation_matrix((-0.2, 0.65, 0.2)))
    return concat_shapes(floor, library_call('cabinet'), goods, library_call('coins'))
