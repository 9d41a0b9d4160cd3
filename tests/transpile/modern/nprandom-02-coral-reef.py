from dataclasses import dataclass, field
import numpy as np
from helper import *

"""
a coral reef grown with a seeded generator
"""


@dataclass
class Reef:
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(7))
    palette: np.ndarray = field(default_factory=lambda: np.array([[1.0, 0.45, 0.4], [0.95, 0.7, 0.3], [0.7, 0.35, 0.8], [0.3, 0.75, 0.7]]))

    def color(self) -> tuple:
        base = self.palette[self.rng.integers(len(self.palette))]
        return tuple(np.clip(base + self.rng.normal(0, 0.05, 3), 0, 1))

    def branch(self, start: np.ndarray, direction: np.ndarray, length: float, depth: int, color: tuple) -> list:
        end = start + direction * length
        parts = [primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.03 * (depth + 1), 'p0': start, 'p1': end})]
        if depth == 0:
            parts.append(transform_shape(primitive_call('sphere', color=(1, 1, 0.9), shape_kwargs={'radius': 0.06}), translation_matrix(end)))
            return parts
        for _ in range(self.rng.integers(2, 4)):
            wobble = direction + self.rng.uniform(-0.7, 0.7, size=3)
            wobble[1] = abs(wobble[1]) + 0.2
            parts += self.branch(end, wobble / np.linalg.norm(wobble), length * 0.75, depth - 1, color)
        return parts


@register("coral")
def coral(reef: Reef, depth: int) -> Shape:
    return concat_shapes(*reef.branch(np.zeros(3), np.array([0.0, 1.0, 0.0]), 0.5, depth, reef.color()))


@register("brain coral")
def brain(reef: Reef) -> Shape:
    r = reef.rng.uniform(0.2, 0.4)
    dots = reef.rng.standard_normal((8, 3))
    dots *= r / np.linalg.norm(dots, axis=1)[:, None]
    body = primitive_call('sphere', color=reef.color(), shape_kwargs={'radius': r})
    return concat_shapes(body, *[transform_shape(primitive_call('sphere', color=reef.color(), shape_kwargs={'radius': 0.06}), translation_matrix(d)) for d in dots])


@register("coral reef")
def coral_reef() -> Shape:
    reef = Reef()
    spots = reef.rng.permutation(np.array([(x, z) for x in range(-2, 3) for z in (-1, 1)]))
    shapes = [primitive_call('cube', color=(0.85, 0.8, 0.6), shape_kwargs={'scale': (7, 0.1, 4)})]
    for i, (x, z) in enumerate(spots):
        here = translation_matrix((1.2 * x, 0.05, z))
        if i < 5:
            shapes.append(transform_shape(library_call('coral', reef=reef, depth=2), here))
        elif i < 8:
            shapes.append(transform_shape(library_call('brain coral', reef=reef), here))
        else:
            weed = reef.rng.choice([0.6, 0.9, 1.3], size=3, replace=False)
            shapes.append(transform_shape(loop(3, lambda k: primitive_call('cylinder', color=(0.2, 0.5, 0.2), shape_kwargs={'radius': 0.03, 'p0': (0.1 * k, 0, 0), 'p1': (0.1 * k, weed[k], 0.1)})), here))
    return concat_shapes(*shapes)
