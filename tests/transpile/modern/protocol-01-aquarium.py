from dataclasses import dataclass
from typing import Protocol, Sequence, runtime_checkable
import math
from helper import *

"""
an aquarium whose inhabitants only share a protocol
"""


@runtime_checkable
class Drawable(Protocol):
    def draw(self) -> Shape: ...


class Movable(Protocol):
    position: tuple[float, float, float]

    def moved(self, dx: float, dy: float, dz: float) -> "Movable": ...


@dataclass(frozen=True)
class Fish:
    position: tuple[float, float, float]
    color: tuple[float, float, float] = (1.0, 0.5, 0.1)
    heading: float = 0.0

    def moved(self, dx, dy, dz):
        x, y, z = self.position
        return Fish((x + dx, y + dy, z + dz), self.color, self.heading + 0.2)

    def draw(self) -> Shape:
        body = transform_shape(primitive_call('sphere', color=self.color, shape_kwargs={'radius': 0.2}), scale_matrix((1.6, 1, 0.6), (0, 0, 0)))
        tail = transform_shape(primitive_call('cube', color=self.color, shape_kwargs={'scale': (0.16, 0.24, 0.03)}), translation_matrix((-0.38, 0, 0)))
        pose = translation_matrix(self.position) @ rotation_matrix(self.heading, (0, 1, 0), (0, 0, 0))
        return transform_shape(concat_shapes(body, tail), pose)


@dataclass(frozen=True)
class Seaweed:
    x: float
    segments: int

    def draw(self) -> Shape:
        def at(i): return (self.x + 0.1 * math.sin(i), 0.25 * i, -0.6)
        return loop(self.segments, lambda i: primitive_call('cylinder', color=(0.1, 0.5, 0.2), shape_kwargs={'radius': 0.03, 'p0': at(i), 'p1': at(i + 1)}))


class Rock:
    """Has no draw method on purpose."""


def school(leader: Movable, n: int) -> list[Movable]:
    members = [leader]
    while len(members) < n:
        members.append(members[-1].moved(-0.7, 0.15 * (-1) ** len(members), 0.2))
    return members


@register()
def inhabitants(items: Sequence[object]) -> Shape:
    return concat_shapes(*(item.draw() for item in items if isinstance(item, Drawable)))


@register()
def aquarium() -> Shape:
    fish = school(Fish((1.5, 1.2, 0)), 5) + school(Fish((1.2, 0.6, 0.3), (0.2, 0.6, 1.0), math.pi), 3)
    plants = [Seaweed(x / 2, 3 + x % 3) for x in range(-4, 5, 2)]
    sand = primitive_call('cube', color=(0.85, 0.78, 0.55), shape_kwargs={'scale': (5, 0.1, 2)})
    edges = [primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.04, 'p0': (x, 0, z), 'p1': (x, 2.4, z)}) for x in (-2.5, 2.5) for z in (-1, 1)]
    return concat_shapes(sand, *edges, library_call('inhabitants', items=[*fish, Rock(), *plants]))
