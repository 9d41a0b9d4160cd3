from __future__ import annotations
import random
from dataclasses import dataclass, field
from itertools import count
from helper import *

"""
a roundabout after two minutes of simulated traffic
"""

_ids = count(1)


@dataclass
class Car:
    angle: float
    speed: float
    lane: int = 0
    id: int = field(default_factory=lambda: next(_ids))
    laps: float = 0.0

    @property
    def color(self) -> tuple[float, float, float]:
        return ((self.id * 37 % 100) / 100, 0.3, (self.id * 61 % 100) / 100)


class Roundabout:
    RADII = (3.0, 4.0)

    def __init__(self, capacity: int):
        self.capacity = capacity
        self.cars: list[Car] = []
        self.log: dict[str, int] = {"in": 0, "out": 0, "waits": 0}

    def gap_ahead(self, car: Car) -> float:
        others = [(o.angle - car.angle) % (2 * math.pi) for o in self.cars if o is not car and o.lane == car.lane]
        return min(others, default=2 * math.pi)

    def step(self, dt: float = 0.1) -> None:
        if len(self.cars) < self.capacity and random.random() < 0.3:
            newcomer = Car(angle=random.choice([0, 1, 2, 3]) * math.pi / 2, speed=random.uniform(0.5, 1.5), lane=random.randint(0, 1))
            if self.gap_ahead(newcomer) > 0.4:
                self.cars.append(newcomer)
                self.log["in"] += 1
            else:
                self.log["waits"] += 1
        for car in self.cars:
            gap = self.gap_ahead(car)
            factor = 1.0 if gap > 0.6 else max(0.0, (gap - 0.3) / 0.3)
            move = car.speed * factor * dt
            car.angle = (car.angle + move) % (2 * math.pi)
            car.laps += move / (2 * math.pi)
        leaving = [c for c in self.cars if c.laps > 2]
        self.log["out"] += len(leaving)
        self.cars[:] = [c for c in self.cars if c not in leaving]


@register()
def car(color: tuple) -> Shape:
    body = primitive_call('cube', color=color, shape_kwargs={'scale': (0.4, 0.25, 0.8)})
    roof = primitive_call('cube', color=(0.7, 0.85, 0.95), shape_kwargs={'scale': (0.35, 0.18, 0.4)})
    return concat_shapes(transform_shape(body, translation_matrix((0, 0.2, 0))), transform_shape(roof, translation_matrix((0, 0.4, 0))))


@register()
def roundabout() -> Shape:
    site = Roundabout(capacity=12)
    for _ in range(1200):
        site.step()
    road = primitive_call('cylinder', color=(0.3, 0.3, 0.3), shape_kwargs={'radius': 4.6, 'p0': (0, -0.1, 0), 'p1': (0, 0, 0)})
    island = primitive_call('cylinder', color=(0.3, 0.55, 0.3), shape_kwargs={'radius': 2.4, 'p0': (0, 0, 0), 'p1': (0, 0.1, 0)})
    shapes = []
    for c in sorted(site.cars, key=lambda c: c.id):
        r = Roundabout.RADII[c.lane]
        pose = rotation_matrix(-c.angle, (0, 1, 0), (0, 0, 0)) @ translation_matrix((r, 0, 0))
        shapes.append(transform_shape(library_call('car', color=c.color), pose))
    stats = [primitive_call('cylinder', color=(0.8, 0.7, 0.2), shape_kwargs={'radius': 0.15, 'p0': (0.5 * i - 0.5, 0.1, 0), 'p1': (0.5 * i - 0.5, 0.2 + n / 50, 0)}) for i, n in enumerate(site.log.values())]
    return concat_shapes(road, island, *shapes, *stats)
