from __future__ import annotations
from dataclasses import dataclass, replace
import math
from helper import *

"""
ferns from an L-system with a turtle and a stack
"""


@dataclass(frozen=True)
class LSystem:
    axiom: str
    rules: dict[str, str]
    angle: float

    def expand(self, generations: int) -> str:
        text = self.axiom
        for _ in range(generations):
            text = "".join(self.rules.get(ch, ch) for ch in text)
        return text


@dataclass
class Turtle:
    x: float = 0.0
    y: float = 0.0
    heading: float = 90.0
    width: float = 0.06

    def ahead(self, distance: float) -> Turtle:
        a = math.radians(self.heading)
        return replace(self, x=self.x + distance * math.cos(a), y=self.y + distance * math.sin(a))


SYSTEMS = {
    "fern": LSystem("X", {"X": "F[+X]F[-X]+X", "F": "FF"}, 20),
    "bush": LSystem("F", {"F": "F[+F]F[-F][F]"}, 25),
    "weed": LSystem("F", {"F": "F[+F]F[-F]F"}, 30),
}


def interpret(text: str, angle: float, step: float):
    turtle, stack = Turtle(), []
    for command in text:
        match command:
            case "F":
                moved = turtle.ahead(step)
                yield (turtle.x, turtle.y), (moved.x, moved.y), turtle.width
                turtle = moved
            case "+" | "-":
                turtle.heading += angle if command == "+" else -angle
            case "[":
                stack.append(replace(turtle))
                turtle.width *= 0.7
            case "]":
                yield (turtle.x, turtle.y), None, turtle.width
                turtle = stack.pop()


@register()
def plant(name: str, generations: int, step: float) -> Shape:
    system = SYSTEMS[name]
    parts = []
    for start, end, width in interpret(system.expand(generations), system.angle, step):
        if end is None:
            parts.append(transform_shape(primitive_call('sphere', color=(0.3, 0.8, 0.3), shape_kwargs={'radius': width * 1.2}), translation_matrix((*start, 0))))
        else:
            parts.append(primitive_call('cylinder', color=(0.2, 0.45, 0.15), shape_kwargs={'radius': width, 'p0': (*start, 0), 'p1': (*end, 0)}))
    return concat_shapes(*parts)


@register()
def fern_bank() -> Shape:
    beds = [("fern", 3, 0.15), ("bush", 2, 0.3), ("weed", 2, 0.3), ("fern", 2, 0.3), ("bush", 3, 0.1)]
    soil = primitive_call('cube', color=(0.35, 0.25, 0.15), shape_kwargs={'scale': (12, 0.2, 2)})
    return concat_shapes(transform_shape(soil, translation_matrix((4, -0.1, 0))), *[
        transform_shape(library_call('plant', name=n, generations=g, step=s), translation_matrix((2 * k, 0, 0))) for k, (n, g, s) in enumerate(beds)])
