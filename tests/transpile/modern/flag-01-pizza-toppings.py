from enum import Flag, auto
import math
from helper import *

"""
three pizzas with combined toppings
"""


class Topping(Flag):
    NONE = 0
    TOMATO = auto()
    CHEESE = auto()
    OLIVE = auto()
    SALAMI = auto()
    MARGHERITA = TOMATO | CHEESE
    DELUXE = MARGHERITA | OLIVE | SALAMI


SINGLE = [Topping.TOMATO, Topping.CHEESE, Topping.OLIVE, Topping.SALAMI]
LOOKS = {
    Topping.TOMATO: ((0.85, 0.2, 0.1), 0.12, 5, 0.9),
    Topping.CHEESE: ((1.0, 0.9, 0.55), 0.10, 6, 0.55),
    Topping.OLIVE: ((0.15, 0.15, 0.12), 0.05, 9, 0.75),
    Topping.SALAMI: ((0.6, 0.1, 0.12), 0.16, 4, 0.4),
}


@register()
def disc(radius: float, height: float, color: tuple) -> Shape:
    return primitive_call('cylinder', color=color, shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, height, 0)})


@register()
def pizza(toppings: Topping) -> Shape:
    layers = [library_call('disc', radius=1.3, height=0.1, color=(0.85, 0.65, 0.35))]
    y = 0.1
    for single in SINGLE:
        if single in toppings:
            color, r, count, ring = LOOKS[single]
            for k in range(count):
                a = 2 * math.pi * k / count + 0.3 * single.value
                piece = library_call('disc', radius=r, height=0.04, color=color)
                layers.append(transform_shape(piece, translation_matrix((ring * math.cos(a), y, ring * math.sin(a)))))
            y += 0.02
    return concat_shapes(*layers)


@register()
def pizza_table() -> Shape:
    orders = [
        Topping.MARGHERITA,
        Topping.DELUXE & ~Topping.OLIVE,
        Topping.DELUXE ^ Topping.CHEESE,
    ]
    board = transform_shape(primitive_call('cube', color=(0.45, 0.3, 0.18), shape_kwargs={'scale': (9.5, 0.2, 3.2)}), translation_matrix((0, -0.1, 0)))
    shapes = [board]
    for i, order in enumerate(orders):
        count = bin(order.value).count("1")
        plate = transform_shape(library_call('pizza', toppings=order), translation_matrix((3 * (i - 1), 0, 0)))
        shapes.append(plate)
        candle = primitive_call('cylinder', color=(1, 1, 0.9), shape_kwargs={'radius': 0.06, 'p0': (3 * i - 1.5, 0, -1.2), 'p1': (3 * i - 1.5, 0.2 * count, -1.2)})
        shapes.append(candle)
    if not (orders[0] & Topping.SALAMI) and bool(orders[1] & Topping.SALAMI):
        shapes.append(transform_shape(library_call('disc', radius=0.2, height=0.5, color=(0.2, 0.5, 0.3)), translation_matrix((-4.4, 0, 1.2))))
    return concat_shapes(*shapes)
