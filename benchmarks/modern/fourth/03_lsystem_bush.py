"""
a bush grown by an L-system with a turtle in three dimensions
"""
from __future__ import annotations
from helper import *
import math
from typing import Iterator, NamedTuple
import numpy as np

RULES = {'X': 'F[+X][-X][^X]F[&X]X', 'F': 'FF'}


def rewrite(axiom: str, rules: dict[str, str], n: int) -> str:
    for _ in range(n):
        axiom = ''.join(rules.get(c, c) for c in axiom)
    return axiom


def rot(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = axis
    c, s = math.cos(angle), math.sin(angle)
    t = 1 - c
    return np.array([[t * x * x + c, t * x * y - s * z, t * x * z + s * y],
                     [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
                     [t * x * z - s * y, t * y * z + s * x, t * z * z + c]])


class Segment(NamedTuple):
    start: tuple
    end: tuple
    depth: int


class Turtle:
    def __init__(self, step: float, angle: float):
        self.pos = np.zeros(3)
        self.frame = np.eye(3)
        self.step = step
        self.angle = angle
        self.stack: list[tuple[np.ndarray, np.ndarray]] = []

    def turn(self, axis: int, sign: int) -> None:
        self.frame = rot(self.frame[:, axis], sign * self.angle) @ self.frame

    def run(self, program: str) -> Iterator[Segment]:
        for symbol in program:
            match symbol:
                case 'F':
                    old = self.pos.copy()
                    self.pos += self.step * self.frame[:, 1]
                    yield Segment(tuple(old), tuple(self.pos), len(self.stack))
                case '+' | '-':
                    self.turn(2, 1 if symbol == '+' else -1)
                case '^' | '&':
                    self.turn(0, 1 if symbol == '^' else -1)
                case '[':
                    self.stack.append((self.pos.copy(), self.frame.copy()))
                case ']':
                    self.pos, self.frame = self.stack.pop()
                case _:
                    pass


@register()
def twig(start, end, radius: float = 0.05) -> Shape:
    return primitive_call('cylinder', color=(0.35, 0.25, 0.12), shape_kwargs={'radius': radius, 'p0': start, 'p1': end})


@register()
def leaf(at, size: float = 0.1) -> Shape:
    return transform_shape(primitive_call('sphere', color=(0.2, 0.55, 0.15), shape_kwargs={'radius': size}), translation_matrix(at))


@register()
def bush() -> Shape:
    turtle = Turtle(step=0.25, angle=math.radians(28))
    segments = list(turtle.run(rewrite('X', RULES, 3)))
    deepest = max(s.depth for s in segments)
    shapes = [library_call('twig', start=s.start, end=s.end, radius=0.06 * 0.6 ** s.depth) for s in segments]
    leaves = [library_call('leaf', at=s.end, size=0.08 + 0.02 * s.depth) for s in segments if s.depth == deepest]
    return concat_shapes(*shapes, *leaves)
