import random
import numpy as np
from helper import *

"""
desert shrubs from a stochastic L-system with a turtle of matrices
"""

RULES = {
    "F": [(0.5, "F[&F]/F"), (0.3, "F[^F]"), (0.2, "FF")],
    "A": [(1.0, "[&FA]///[&FA]///[&FA]")],
}

class MatrixTurtle:
    def __init__(self, step: float = 0.3, angle: float = 28.0) -> None:
        self.pose = np.eye(4)
        self.stack: list[np.ndarray] = []
        self.step, self.angle = step, np.radians(angle)
        self.segments: list[tuple] = []
        self._table = {
            "F": self.forward,
            "&": lambda: self.turn((1, 0, 0), self.angle),
            "^": lambda: self.turn((1, 0, 0), -self.angle),
            "/": lambda: self.turn((0, 1, 0), 2 * self.angle),
            "[": lambda: self.stack.append(self.pose.copy()),
            "]": self.pop,
        }

    @property
    def position(self) -> np.ndarray:
        return self.pose[:3, 3].copy()

    def forward(self) -> None:
        start = self.position
        self.pose = self.pose @ translation_matrix((0, self.step, 0))
        self.segments.append((start, self.position, len(self.stack)))

    def turn(self, axis, angle) -> None:
        self.pose = self.pose @ rotation_matrix(angle, axis, (0, 0, 0))

    def pop(self) -> None:
        self.pose = self.stack.pop()

    def run(self, program: str) -> "MatrixTurtle":
        for ch in program:
            if (action := self._table.get(ch)) is not None:
                action()
        return self

def choose(options: list) -> str:
    r, total = random.random(), 0.0
    for weight, text in options:
        total += weight
        if r < total:
            return text
    return options[-1][1]

def grow(axiom: str, generations: int) -> str:
    return axiom if generations == 0 else grow("".join(choose(RULES[c]) if c in RULES else c for c in axiom), generations - 1)

@register()
def shrub(generations: int) -> Shape:
    turtle = MatrixTurtle().run(grow("FA", generations))
    parts = []
    for start, end, depth in turtle.segments:
        parts.append(primitive_call('cylinder', color=(0.4 - 0.05 * min(depth, 4), 0.35 + 0.05 * depth, 0.2), shape_kwargs={'radius': 0.06 / (1 + depth / 2), 'p0': start, 'p1': end}))
    return concat_shapes(*parts)

@register()
def desert() -> Shape:
    shapes = [primitive_call('cube', color=(0.85, 0.7, 0.45), shape_kwargs={'scale': (8, 0.1, 8)})]
    for k in range(5):
        x, z = np.random.uniform(-3, 3, 2)
        shapes.append(transform_shape(library_call('shrub', generations=2 + k % 2), translation_matrix((x, 0, z))))
    return concat_shapes(*shapes)
