from operator import itemgetter, attrgetter, methodcaller, mul, add, sub, truediv, neg
from functools import reduce
from dataclasses import dataclass
from helper import *

"""
a formal garden planted in sorted order
"""


@dataclass
class Spot:
    x: float
    z: float


@dataclass
class Plant:
    name: str
    height: float
    spot: Spot
    month: int = 5


PLANTS = [
    Plant("boxwood", 0.8, Spot(0, 0)),
    Plant("rose", 0.6, Spot(1, 2), 6),
    Plant("cypress", 2.4, Spot(-2, 1)),
    Plant("lavender", 0.4, Spot(2, -1), 7),
    Plant("tulip", 0.3, Spot(-1, -2), 4),
    Plant("yew", 1.5, Spot(3, 1)),
]

ROWS = [("oak", 3, 1.5), ("elm", 2, 2.5), ("ash", 3, 0.5), ("fir", 1, 3.0)]


@register()
def shrub(height: float, color: tuple) -> Shape:
    trunk = primitive_call('cylinder', color=(0.4, 0.3, 0.2), shape_kwargs={'radius': 0.06, 'p0': (0, 0, 0), 'p1': (0, height / 2, 0)})
    crown = transform_shape(primitive_call('sphere', color=color, shape_kwargs={'radius': 0.35}), translation_matrix((0, 0, 0)) @ np.diag([1, height, 1, 1]))
    return concat_shapes(trunk, transform_shape(crown, translation_matrix((0, height / 2, 0))))


@register()
def formal_garden() -> Shape:
    by_height = sorted(PLANTS, key=attrgetter("height"), reverse=True)
    by_spot = sorted(PLANTS, key=attrgetter("month", "spot.x"))
    tallest = max(PLANTS, key=attrgetter("height"))
    names = list(map(methodcaller("upper"), map(attrgetter("name"), by_height)))
    shapes = []
    for k, plant in enumerate(by_height):
        place = tuple(map(mul, (plant.spot.x, 0, plant.spot.z), (1.2, 0, 1.1)))
        shapes.append(transform_shape(library_call('shrub', height=plant.height, color=(0.1 * k, 0.5, 0.2)), translation_matrix(place)))
    for k, plant in enumerate(by_spot):
        offset = list(map(sub, (3.0, 0.0, k), (6.0, 0.0, 3.0)))
        sign = primitive_call('cube', color=(0.9, 0.9, 0.8), shape_kwargs={'scale': (0.08 * len(names[k]), 0.2, 0.02)})
        shapes.append(transform_shape(sign, translation_matrix(list(map(add, offset, (0, 0.5, 0))))))
    for k, (count, size) in enumerate(map(itemgetter(1, -1), sorted(ROWS, key=itemgetter(1, 2)))):
        hedge = primitive_call('cube', color=(0.1, 0.35, 0.15), shape_kwargs={'scale': (size, 0.4, 0.3)})
        shapes.append(loop(count, lambda i: transform_shape(hedge, translation_matrix((4.5 + k, 0.2 + 0.4 * i, neg(k))))))
    factorial = reduce(mul, range(1, 5), 1)
    wall = primitive_call('cube', color=(0.6, 0.4, 0.35), shape_kwargs={'scale': (truediv(factorial, 2), 0.5, 0.2)})
    gate_height = itemgetter("h")({"h": tallest.height})
    gate = primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.1, 'p0': (0, 0, -3.5), 'p1': (0, gate_height, -3.5)})
    return concat_shapes(transform_shape(wall, translation_matrix((0, 0.25, -3.5))), gate, *shapes)
