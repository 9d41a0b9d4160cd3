"""
a model railway of straights and curves placed one after the other
"""
from __future__ import annotations
from helper import *
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Iterable, Iterator


@dataclass(frozen=True, slots=True)
class Pose:
    x: float = 0.0
    z: float = 0.0
    heading: float = 0.0

    def forward(self, d: float) -> Pose:
        return Pose(self.x + d * math.cos(self.heading), self.z + d * math.sin(self.heading), self.heading)

    def turned(self, a: float) -> Pose:
        return Pose(self.x, self.z, self.heading + a)

    def matrix(self):
        return translation_matrix((self.x, 0, self.z)) @ rotation_matrix(-self.heading, (0, 1, 0), (0, 0, 0))


class Track(ABC):
    @abstractmethod
    def poses(self, start: Pose) -> Iterator[Pose]: ...

    def end(self, start: Pose) -> Pose:
        *_, last = self.poses(start)
        return last


class Straight(Track):
    def __init__(self, length: int) -> None:
        self.length = length

    def poses(self, start):
        pose = start
        for _ in range(self.length):
            yield pose
            pose = pose.forward(0.5)
        yield pose


class Curve(Track):
    def __init__(self, degrees: float, steps: int = 8) -> None:
        self.turn = math.radians(degrees) / steps
        self.steps = steps

    def poses(self, start):
        pose = start
        for _ in range(self.steps):
            yield pose
            pose = pose.turned(self.turn).forward(0.5)
        yield pose


@register()
def sleeper() -> Shape:
    wood = primitive_call('cube', color=(0.35, 0.22, 0.12), shape_kwargs={'scale': (0.2, 0.08, 1.2)})
    rails = [transform_shape(primitive_call('cube', color=(0.6, 0.6, 0.65), shape_kwargs={'scale': (0.55, 0.08, 0.07)}), translation_matrix((0, 0.08, s * 0.4))) for s in (-1, 1)]
    return concat_shapes(wood, *rails)


@register()
def wagon(color=(0.2, 0.4, 0.7)) -> Shape:
    body = transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (1.4, 0.7, 0.9)}), translation_matrix((0, 0.75, 0)))
    wheels = [transform_shape(primitive_call('cylinder', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': 0.2, 'p0': (0, 0, -0.45), 'p1': (0, 0, 0.45)}), translation_matrix((dx, 0.3, 0))) for dx in (-0.4, 0.4)]
    return concat_shapes(body, *wheels)


def lay(pieces: Iterable[Track]) -> list[Pose]:
    poses: list[Pose] = []
    here = Pose()
    for piece in pieces:
        laid = list(piece.poses(here))
        poses.extend(laid[:-1])
        here = laid[-1]
    return poses


@register()
def railway() -> Shape:
    layout = [Straight(6), Curve(90), Straight(3), Curve(90), Straight(6), Curve(180, 16)]
    poses = lay(layout)
    shapes = [transform_shape(library_call('sleeper'), p.matrix()) for p in poses]
    train = [transform_shape(library_call('wagon', color=c), poses[i].matrix()) for i, c in zip(range(1, 20, 4), [(0.7, 0.1, 0.1), (0.2, 0.4, 0.7), (0.2, 0.6, 0.3)])]
    return concat_shapes(*shapes, *train)
