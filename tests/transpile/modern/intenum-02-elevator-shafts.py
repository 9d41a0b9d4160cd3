from enum import IntEnum, unique
from typing import Iterable
from helper import *

"""
an office lobby cutaway with elevator shafts
"""


@unique
class Direction(IntEnum):
    DOWN = -1
    IDLE = 0
    UP = 1

    def __neg__(self):
        return Direction(-self.value)


class Elevator:
    FLOOR_HEIGHT = 1.2

    def __init__(self, start: int, direction: Direction, top: int = 6):
        self.floor = start
        self.direction = direction
        self.top = top
        self.visited = [start]

    def step(self) -> None:
        if self.floor + self.direction not in range(self.top + 1):
            self.direction = -self.direction
        self.floor += self.direction
        self.visited.append(self.floor)

    def run(self, steps: int) -> "Elevator":
        for _ in range(steps):
            self.step()
        return self


@register()
def shaft(floors: int) -> Shape:
    h = floors * Elevator.FLOOR_HEIGHT
    rails = loop(2, lambda i: primitive_call('cylinder', color=(0.4, 0.4, 0.45), shape_kwargs={
        'radius': 0.04, 'p0': ((-1) ** i * 0.5, 0, 0), 'p1': ((-1) ** i * 0.5, h, 0)}))
    return rails


@register()
def cabin(floor: int, direction: int) -> Shape:
    direction = Direction(direction)
    box = primitive_call('cube', color=(0.7, 0.6, 0.3), shape_kwargs={'scale': (0.9, 1.0, 0.8)})
    lamp_color = (0.2, 0.9, 0.2) if direction > 0 else (0.9, 0.2, 0.2) if direction < 0 else (0.6, 0.6, 0.6)
    arrow = transform_shape(primitive_call('sphere', color=lamp_color, shape_kwargs={'radius': 0.08}),
                            translation_matrix((0, 0.3 + 0.1 * direction, 0.42)))
    return transform_shape(concat_shapes(box, arrow), translation_matrix((0, (floor + 0.5) * Elevator.FLOOR_HEIGHT, 0)))


def visits(elevators: Iterable[Elevator], floor: int) -> int:
    return sum(e.visited.count(floor) for e in elevators)


@register()
def lobby() -> Shape:
    elevators = [Elevator(0, Direction.UP), Elevator(3, Direction.DOWN), Elevator(6, Direction.IDLE), Elevator(5, Direction.UP)]
    shapes = []
    for k, elevator in enumerate(elevators):
        elevator.run(5 + 2 * k)
        column = concat_shapes(library_call('shaft', floors=elevator.top + 1), library_call('cabin', floor=elevator.floor, direction=int(elevator.direction)))
        shapes.append(transform_shape(column, translation_matrix((1.5 * k, 0, 0))))
    for floor in range(7):
        n = visits(elevators, floor)
        slab = primitive_call('cube', color=(0.3 + 0.08 * min(n, 8), 0.4, 0.5), shape_kwargs={'scale': (6.5, 0.08, 0.3)})
        shapes.append(transform_shape(slab, translation_matrix((2.25, floor * Elevator.FLOOR_HEIGHT, -0.6))))
    return concat_shapes(*shapes)
