"""a bonsai tree in a ceramic pot, grown by an L-system"""
from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Iterator

from helper import *

RULES = {'X': 'F[+X][-X][^X]FX', 'F': 'FF'}


def rewrite(axiom: str, rules: dict[str, str], times: int) -> str:
    return axiom if times == 0 else rewrite(''.join(rules.get(c, c) for c in axiom), rules, times - 1)


@dataclass(frozen=True)
class Turtle:
    """Position, heading (yaw around y, pitch from the vertical) and thickness."""
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    yaw: float = 0.0
    pitch: float = 0.0
    width: float = 0.07

    @property
    def place(self) -> tuple[float, float, float]:
        return (self.x, self.y, self.z)

    def forward(self, step: float) -> Turtle:
        p, w = math.radians(self.pitch), math.radians(self.yaw)
        return replace(self, x=self.x + step * math.sin(p) * math.cos(w), y=self.y + step * math.cos(p),
                       z=self.z + step * math.sin(p) * math.sin(w), width=self.width * 0.97)

    def turn(self, symbol: str) -> Turtle:
        match symbol:
            case '+':
                return replace(self, yaw=self.yaw + 70, pitch=self.pitch + 22, width=self.width * 0.7)
            case '-':
                return replace(self, yaw=self.yaw - 95, pitch=self.pitch + 28, width=self.width * 0.7)
            case '^':
                return replace(self, yaw=self.yaw + 190, pitch=self.pitch + 35, width=self.width * 0.6)
            case _:
                return self


def walk(program: str, step: float) -> Iterator[tuple[str, Turtle, Turtle]]:
    """Yield ('wood', from, to) and ('leaf', at, at)."""
    turtle, stack = Turtle(), []
    for symbol in program:
        if symbol == 'F':
            moved = turtle.forward(step)
            yield 'wood', turtle, moved
            turtle = moved
        elif symbol == '[':
            stack.append(turtle)
        elif symbol == ']':
            yield 'leaf', turtle, turtle
            turtle = stack.pop()
        else:
            turtle = turtle.turn(symbol)


@register("branches and leaves")
def bonsai(generations: int = 3, step: float = 0.11) -> Shape:
    shapes = []
    for number, (kind, a, b) in enumerate(walk(rewrite('X', RULES, generations), step)):
        if kind == 'wood':
            shapes.append(primitive_call('cylinder', shape_kwargs={'radius': b.width, 'p0': a.place, 'p1': b.place}, color=(0.38, 0.25, 0.15)))
        else:
            green = 0.4 + 0.08 * (number % 4)
            leaf = primitive_call('sphere', shape_kwargs={'radius': 0.11}, color=(0.15, green, 0.18))
            shapes.append(transform_shape(leaf, translation_matrix(a.place)))
    return concat_shapes(*shapes)


@register("a shallow pot with feet, earth and moss")
def pot(width: float = 1.2, depth: float = 0.8) -> Shape:
    glaze = (0.2, 0.32, 0.4)
    tub = primitive_call('cube', shape_kwargs={'scale': (width, 0.25, depth)}, color=glaze)
    lip = transform_shape(primitive_call('cube', shape_kwargs={'scale': (width + 0.1, 0.06, depth + 0.1)}, color=glaze), translation_matrix((0, 0.13, 0)))
    earth = transform_shape(primitive_call('cube', shape_kwargs={'scale': (width - 0.08, 0.04, depth - 0.08)}, color=(0.25, 0.18, 0.12)), translation_matrix((0, 0.15, 0)))
    feet = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.12, 0.08, 0.12)}, color=glaze),
                            translation_matrix((sx * width * 0.4, -0.16, sz * depth * 0.35))) for sx in (-1, 1) for sz in (-1, 1)]
    moss = loop(9, lambda i: transform_shape(
        primitive_call('sphere', shape_kwargs={'radius': 0.07}, color=(0.35, 0.5, 0.2)),
        translation_matrix((0.45 * math.cos(i * 2.2) * (0.5 + i / 18), 0.15, 0.28 * math.sin(i * 2.2)))))
    return concat_shapes(tub, lip, earth, *feet, moss)


@register()
def bonsai_in_pot() -> Shape:
    return concat_shapes(library_call('pot'), transform_shape(library_call('bonsai'), translation_matrix((-0.1, 0.15, 0))))
