from typing import NamedTuple
from helper import *

"""
boats moored along two piers
"""


class Point(NamedTuple):
    x: float
    z: float = 0.0

    def __add__(self, other):
        return Point(self.x + other[0], self.z + other[1])

    def lifted(self, y: float) -> tuple[float, float, float]:
        return (self.x, y, self.z)


class Boat(NamedTuple):
    length: float
    mast: float = 0.0
    hull: tuple[float, float, float] = (0.9, 0.9, 0.92)

    @property
    def is_sailboat(self) -> bool:
        return self.mast > 0

    @classmethod
    def dinghy(cls) -> "Boat":
        return cls(1.0, hull=(0.5, 0.3, 0.15))


FLEET = (Boat(2.2, 3), Boat.dinghy(), Boat(3, 4, (0.1, 0.2, 0.4)), Boat(1.6), Boat(2.6, mast=3.4), Boat.dinghy()._replace(length=1.3))


@register("boat")
def boat(length: float, mast: float, hull: tuple) -> Shape:
    body = transform_shape(primitive_call('sphere', color=hull, shape_kwargs={'radius': 0.5}), scale_matrix((0.8, 0.5, length), (0, 0, 0)))
    deck = transform_shape(primitive_call('cube', color=(0.7, 0.5, 0.3), shape_kwargs={'scale': (0.6, 0.04, length * 0.7)}), translation_matrix((0, 0.2, 0)))
    if not mast:
        return concat_shapes(body, deck)
    pole = primitive_call('cylinder', color=(0.6, 0.6, 0.6), shape_kwargs={'radius': 0.03, 'p0': (0, 0.2, 0.1), 'p1': (0, mast, 0.1)})
    boom = primitive_call('cylinder', color=(0.6, 0.6, 0.6), shape_kwargs={'radius': 0.025, 'p0': (0, 0.6, 0.1), 'p1': (0, 0.6, -length / 2)})
    return concat_shapes(body, deck, pole, boom)


@register("harbor")
def harbor() -> Shape:
    shapes = [transform_shape(primitive_call('cube', color=(0.15, 0.3, 0.45), shape_kwargs={'scale': (10, 0.1, 12)}), translation_matrix((3.5, -0.1, 0)))]
    origin, step = Point(0), Point(1.6, 0.1)
    for pier in range(2):
        here = origin + (0, 4 * pier - 2)
        for i, item in enumerate(FLEET[pier::2]):
            berth = here + (step.x * i, step.z * i)
            spot = berth.lifted(0.15)
            shapes.append(transform_shape(library_call('boat', **item._asdict()), translation_matrix(spot)))
            *_, last = spot
            shapes.append(primitive_call('cylinder', color=(0.3, 0.2, 0.1), shape_kwargs={'radius': 0.08, 'p0': (spot[0] + 0.7, -0.3, last), 'p1': (spot[0] + 0.7, 0.6, last)}))
        walkway = primitive_call('cube', color=(0.5, 0.4, 0.3), shape_kwargs={'scale': (6, 0.1, 0.6)})
        shapes.append(transform_shape(walkway, translation_matrix((2, 0.3, here.z + 1.9))))
    tall = [b for b in FLEET if b.is_sailboat]
    beacon = max(tall, key=lambda b: b.mast).mast + len(Boat._fields)
    light = primitive_call('cylinder', color=(0.9, 0.2, 0.2), shape_kwargs={'radius': 0.4, 'p0': (7, 0, 0), 'p1': (7, beacon, 0)})
    return concat_shapes(*shapes, light)
