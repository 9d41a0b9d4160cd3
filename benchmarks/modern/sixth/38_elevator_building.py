"""an elevator that serves calls in a six-storey building; a frame for each step of its controller"""
from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import ClassVar, Deque, Iterator
from helper import *

FLOORS, STOREY = 6, 1.0


class State(Enum):
    IDLE = auto()
    UP = auto()
    DOWN = auto()
    DOORS = auto()

    @property
    def lamp(self) -> tuple[float, float, float]:
        return {State.IDLE: (0.5, 0.5, 0.5), State.UP: (0.2, 0.8, 0.3), State.DOWN: (0.9, 0.3, 0.2)}.get(self, (1.0, 0.85, 0.2))


@dataclass
class Passenger:
    start: int
    goal: int
    color: tuple[float, float, float]
    aboard: bool = False
    arrived: bool = False


@dataclass
class Elevator:
    passengers: list[Passenger]
    floor: int = 0
    state: State = State.IDLE
    queue: Deque[int] = field(default_factory=deque)
    capacity: ClassVar[int] = 2

    def __post_init__(self):
        for p in self.passengers:
            self.request(p.start)

    def request(self, floor: int) -> None:
        if floor not in self.queue:
            self.queue.append(floor)

    def step(self) -> None:
        match self.state:
            case State.DOORS:
                self._exchange()
                self.state = State.IDLE
            case _ if not self.queue:
                self.state = State.IDLE
            case _:
                target = self.queue[0]
                if target == self.floor:
                    self.queue.popleft()
                    self.state = State.DOORS
                else:
                    self.state = State.UP if target > self.floor else State.DOWN
                    self.floor += 1 if self.state is State.UP else -1

    def _exchange(self) -> None:
        for p in self.passengers:
            if p.aboard and p.goal == self.floor:
                p.aboard, p.arrived = False, True
        for p in self.passengers:
            room = self.capacity - sum(q.aboard for q in self.passengers)
            if not p.aboard and not p.arrived and p.start == self.floor and room > 0:
                p.aboard = True
                self.request(p.goal)

    def run(self, limit: int = 40) -> Iterator[int]:
        for clock in range(limit):
            yield clock
            if all(p.arrived for p in self.passengers):
                return
            self.step()


@register("a person as tall as 0.5")
def person(color: tuple[float, float, float] = (0.8, 0.2, 0.2)) -> Shape:
    body = primitive_call('cylinder', shape_kwargs={'radius': 0.09, 'p0': (0, 0, 0), 'p1': (0, 0.36, 0)}, color=color)
    return concat_shapes(body, transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.08}, color=(0.95, 0.8, 0.65)), translation_matrix((0, 0.44, 0))))


@register("floors, back wall and the shaft")
def building(floors: int = FLOORS) -> Shape:
    slabs = loop(floors + 1, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (3.2, 0.06, 1.2)}, color=(0.75, 0.73, 0.7)), translation_matrix((1.4, i * STOREY - 0.03, 0))))
    wall = transform_shape(primitive_call('cube', shape_kwargs={'scale': (4.4, floors * STOREY, 0.06)}, color=(0.88, 0.86, 0.8)), translation_matrix((0.8, floors * STOREY / 2, -0.6)))
    return concat_shapes(slabs, wall)


@register("the cabin with its cable and a lamp for the state")
def cabin(floor: int = 0, open_doors: bool = False, lamp: tuple[float, float, float] = (0.5, 0.5, 0.5)) -> Shape:
    y, steel = floor * STOREY, (0.55, 0.6, 0.66)
    plates = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.8, 0.05, 0.8)}, color=steel), translation_matrix((-0.7, y + h, 0))) for h in (0.0, 0.8)]
    gap = 0.36 if open_doors else 0.2
    doors = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.38 if not open_doors else 0.08, 0.75, 0.03)}, color=(0.7, 0.72, 0.75)), translation_matrix((-0.7 + s * gap, y + 0.4, 0.4))) for s in (-1, 1)]
    cable = primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (-0.7, y + 0.8, 0), 'p1': (-0.7, FLOORS * STOREY + 0.3, 0)}, color=(0.1, 0.1, 0.1))
    signal = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.08}, color=lamp), translation_matrix((-0.7, y + 0.9, 0.4)))
    return concat_shapes(*plates, *doors, cable, signal)


def snapshot(e: Elevator) -> Shape:
    shapes = [library_call('building'), library_call('cabin', floor=e.floor, open_doors=e.state is State.DOORS, lamp=e.state.lamp)]
    for k, p in enumerate(e.passengers):
        waiting = (2.4 if p.arrived else 0.3 + 0.3 * k, (p.goal if p.arrived else p.start) * STOREY, 0)
        at = (-0.9 + 0.2 * k, e.floor * STOREY + 0.03, 0) if p.aboard else waiting
        shapes.append(transform_shape(library_call('person', color=p.color), translation_matrix(at)))
    return concat_shapes(*shapes)


@register_animation()
def elevator_building():
    people = [Passenger(2, 4, (0.8, 0.2, 0.2)), Passenger(1, 0, (0.2, 0.4, 0.8)), Passenger(4, 1, (0.2, 0.6, 0.3))]
    elevator = Elevator(people)
    for _ in elevator.run():
        yield snapshot(elevator)
