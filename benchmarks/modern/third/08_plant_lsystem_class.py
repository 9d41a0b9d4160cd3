"""
potted ferns and shrubs grown from L-systems
"""
from helper import *
import math
from contextlib import contextmanager
from dataclasses import dataclass, replace, field


@dataclass(frozen=True)
class Turtle:
    x: float = 0.0
    y: float = 0.0
    heading: float = math.pi / 2
    width: float = 0.08

    def forward(self, d: float) -> 'Turtle':
        return replace(self, x=self.x + d * math.cos(self.heading), y=self.y + d * math.sin(self.heading))

    def turn(self, a: float) -> 'Turtle':
        return replace(self, heading=self.heading + a)

    def thin(self, k: float) -> 'Turtle':
        return replace(self, width=self.width * k)


@dataclass
class LSystem:
    axiom: str
    rules: dict[str, str]
    angle: float
    step: float = 0.2
    generations: int = 3

    def expand(self) -> str:
        text = self.axiom
        for _ in range(self.generations):
            text = ''.join(self.rules.get(c, c) for c in text)
        return text

    def segments(self):
        turtle, stack = Turtle(), []
        for symbol in self.expand():
            match symbol:
                case 'F' | 'G':
                    ahead = turtle.forward(self.step)
                    yield 'wood', turtle, ahead
                    turtle = ahead
                case '+':
                    turtle = turtle.turn(self.angle)
                case '-':
                    turtle = turtle.turn(-self.angle)
                case '[':
                    stack.append(turtle)
                    turtle = turtle.thin(0.7)
                case ']':
                    yield 'leaf', turtle, turtle
                    turtle = stack.pop()


SPECIES = {
    'fern': LSystem('X', {'X': 'F[+X]F[-X]+X', 'F': 'FF'}, math.radians(22), 0.12),
    'shrub': LSystem('F', {'F': 'F[+F]F[-F]'}, math.radians(28), 0.22, 3),
}


@register()
def plant(kind: str = 'fern', leaf: float = 0.06) -> Shape:
    parts = []
    for what, a, b in SPECIES[kind].segments():
        if what == 'wood':
            parts.append(primitive_call('cylinder', color=(0.35, 0.45, 0.2), shape_kwargs={'radius': a.width / 3, 'p0': (a.x, a.y, 0), 'p1': (b.x, b.y, 0)}))
        else:
            parts.append(transform_shape(primitive_call('sphere', color=(0.25, 0.65, 0.25), shape_kwargs={'radius': leaf}), translation_matrix((a.x, a.y, 0))))
    return concat_shapes(*parts)


@register()
def pot(radius: float = 0.5, height: float = 0.7) -> Shape:
    rings = 5
    return concat_shapes(*[
        primitive_call('cylinder', color=(0.7, 0.35, 0.2), shape_kwargs={'radius': radius * (0.7 + 0.3 * (i + 1) / rings), 'p0': (0, height * i / rings, 0), 'p1': (0, height * (i + 1) / rings, 0)})
        for i in range(rings)])


@register()
def potted(kind: str = 'fern', planes: int = 3) -> Shape:
    base = library_call('pot')
    foliage = [transform_shape(library_call('plant', kind=kind), rotation_matrix(k * math.pi / planes, (0, 1, 0), (0, 0, 0))) for k in range(planes)]
    return concat_shapes(base, *[transform_shape(f, translation_matrix((0, 0.7, 0))) for f in foliage])


@register()
def windowsill() -> Shape:
    sill = transform_shape(primitive_call('cube', color=(0.9, 0.9, 0.88), shape_kwargs={'scale': (6, 0.15, 1.6)}), translation_matrix((0, -0.075, 0)))
    left = transform_shape(library_call('potted', kind='fern'), translation_matrix((-1.6, 0, 0)))
    right = transform_shape(library_call('potted', kind='shrub', planes=2), translation_matrix((1.6, 0, 0)))
    return concat_shapes(sill, left, right)
