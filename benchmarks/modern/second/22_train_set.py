"""
a wooden toy train with a locomotive, several wagons and an oval track
"""
from helper import *
import math
from abc import abstractmethod, ABC
from typing import Generic, Iterator, TypeVar, Self
from itertools import accumulate

C = TypeVar('C', bound='Car')


class Train(Generic[C]):
    def __init__(self, *cars: C, gap: float = 0.3):
        self._cars = list(cars)
        self.gap = gap

    def __rshift__(self, car: C) -> Self:
        return type(self)(*self._cars, car, gap=self.gap)

    def __len__(self):
        return len(self._cars)

    def __iter__(self) -> Iterator[tuple[C, float]]:
        ends = accumulate((c.length + self.gap for c in self._cars), initial=0.0)
        yield from ((c, s + c.length / 2) for c, s in zip(self._cars, ends))


class Car(ABC):
    length = 1.4
    paint = (0.8, 0.2, 0.2)

    @abstractmethod
    def load(self) -> Shape: ...

    def wheels(self) -> Shape:
        return concat_shapes(*(transform_shape(library_call('toy_wheel'), translation_matrix((x * self.length * 0.32, 0.18, z * 0.36)))
                               for x in (-1, 1) for z in (-1, 1)))

    def build(self) -> Shape:
        bed = transform_shape(primitive_call('cube', {'scale': (self.length, 0.15, 0.62)}, color=(0.75, 0.58, 0.38)), translation_matrix((0, 0.3, 0)))
        return concat_shapes(bed, self.wheels(), transform_shape(self.load(), translation_matrix((0, 0.38, 0))))


class Engine(Car):
    length = 1.8
    paint = (0.15, 0.35, 0.75)

    def load(self):
        boiler = primitive_call('cylinder', {'radius': 0.27, 'p0': (-0.2, 0.27, 0), 'p1': (-0.9, 0.27, 0)}, color=self.paint)
        cab = transform_shape(primitive_call('cube', {'scale': (0.7, 0.8, 0.6)}, color=(0.85, 0.2, 0.15)), translation_matrix((0.3, 0.4, 0)))
        roof = transform_shape(primitive_call('cube', {'scale': (0.85, 0.06, 0.7)}, color=(0.1, 0.1, 0.1)), translation_matrix((0.3, 0.83, 0)))
        funnel = primitive_call('cylinder', {'radius': 0.09, 'p0': (-0.7, 0.5, 0), 'p1': (-0.7, 0.9, 0)}, color=(0.1, 0.1, 0.1))
        return concat_shapes(boiler, cab, roof, funnel)


class LogWagon(Car):
    def load(self):
        stack = [(z, y) for y, row in enumerate((3, 2, 1)) for z in ((k - (row - 1) / 2) for k in range(row))]
        return concat_shapes(*(primitive_call('cylinder', {'radius': 0.1, 'p0': (-0.6, 0.1 + y * 0.17, z * 0.2), 'p1': (0.6, 0.1 + y * 0.17, z * 0.2)},
                                              color=(0.5, 0.33, 0.18)) for z, y in stack))


class Tanker(Car):
    def __init__(self, paint=(0.9, 0.75, 0.2)):
        self.paint = paint

    def load(self):
        tank = primitive_call('cylinder', {'radius': 0.3, 'p0': (-0.6, 0.3, 0), 'p1': (0.6, 0.3, 0)}, color=self.paint)
        hatch = primitive_call('cylinder', {'radius': 0.1, 'p0': (0, 0.55, 0), 'p1': (0, 0.68, 0)}, color=(0.3, 0.3, 0.3))
        return concat_shapes(tank, hatch)


class Caboose(Engine):
    length = 1.3

    def load(self):
        base = super().load()
        return base[1:3]  # only cab and roof


def oval(s: float, straight: float = 5.0, r: float = 2.0) -> tuple[float, float, float]:
    """arc length -> (x, z, heading)"""
    total = 2 * straight + 2 * math.pi * r
    s %= total
    if s < straight:
        return s - straight / 2, r, 0.0
    if (s := s - straight) < math.pi * r:
        a = s / r
        return straight / 2 + r * math.sin(a), r * math.cos(a), a
    if (s := s - math.pi * r) < straight:
        return straight / 2 - s, -r, math.pi
    a = (s - straight) / r
    return -straight / 2 - r * math.sin(a), -r * math.cos(a), math.pi + a


@register()
def toy_wheel(radius: float = 0.18) -> Shape:
    return primitive_call('cylinder', {'radius': radius, 'p0': (0, 0, -0.04), 'p1': (0, 0, 0.04)}, color=(0.25, 0.15, 0.1))


@register()
def track(ties: int = 50) -> Shape:
    total = 10.0 + 4 * math.pi
    def tie(i: int) -> Shape:
        x, z, h = oval(total * i / ties)
        plank = primitive_call('cube', {'scale': (0.18, 0.06, 1.0)}, color=(0.65, 0.5, 0.32))
        return transform_shape(plank, translation_matrix((x, -0.03, z)) @ rotation_matrix(h, (0, 1, 0), (0, 0, 0)))
    return loop(ties, tie)


@register()
def toy_train() -> Shape:
    train = Train(Engine()) >> LogWagon() >> Tanker() >> Tanker((0.3, 0.7, 0.4)) >> Caboose()
    assert len(train) == 5
    placed = []
    for car, s in train:
        x, z, h = oval(4.0 - s)
        placed.append(transform_shape(car.build(), translation_matrix((x, 0, z)) @ rotation_matrix(h + math.pi, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(library_call('track'), *placed)
