"""
a terrarium with ferns growing from an L-system
"""
from helper import *
import math
from collections import deque
from contextlib import contextmanager
from functools import lru_cache

import numpy as np

RULES = {'X': 'F[&+X][&-X]F[^/X]FX', 'F': 'FF'}


@lru_cache
def expand(axiom: str, depth: int) -> str:
    return axiom if depth == 0 else expand(''.join(RULES.get(c, c) for c in axiom), depth - 1)


def _rot(axis: np.ndarray, a: float) -> np.ndarray:
    x, y, z = axis
    c, s = math.cos(a), math.sin(a)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + s * K + (1 - c) * (K @ K)


class Turtle3D:
    def __init__(self, step: float, angle: float):
        self.pos = np.zeros(3)
        self.frame = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, 1]])  # heading, left, up (rows)
        self.step, self.angle = step, angle
        self.width = 0.05
        self._stack: deque = deque()
        self.shapes: list = []

    @contextmanager
    def saved(self):
        state = self.pos.copy(), self.frame.copy(), self.width
        try:
            yield self
        finally:
            self.pos, self.frame, self.width = state

    def push(self):
        self._stack.append((self.pos.copy(), self.frame.copy(), self.width))
        self.width *= 0.7

    def pop(self):
        self.pos, self.frame, self.width = self._stack.pop()

    def turn(self, axis_row: int, sign: float):
        R = _rot(self.frame[axis_row], sign * self.angle)
        self.frame = self.frame @ R.T

    def forward(self, color):
        new = self.pos + self.frame[0] * self.step
        self.shapes += primitive_call('cylinder', {'radius': self.width, 'p0': self.pos, 'p1': new}, color=color)
        self.pos = new

    def leaf(self, color, size=0.05):
        with self.saved():
            self.pos = self.pos + self.frame[0] * size
            s = primitive_call('sphere', {'radius': size}, color=color)
            self.shapes += transform_shape(s, translation_matrix(self.pos))

    def run(self, program: str, stem, leaf):
        for c in program:
            match c:
                case 'F': self.forward(stem)
                case '[': self.push()
                case ']': self.pop()
                case 'X': self.leaf(leaf)
                case '+': self.turn(2, 1)
                case '-': self.turn(2, -1)
                case '&': self.turn(1, 1)
                case '^': self.turn(1, -1)
                case '/': self.turn(0, 1)
        return self.shapes


@register()
def fern(depth: int = 3, step: float = 0.06, angle_deg: float = 24) -> Shape:
    t = Turtle3D(step, math.radians(angle_deg))
    return t.run(expand('X', depth), stem=(0.25, 0.45, 0.15), leaf=(0.35, 0.7, 0.25))


@register()
def pebbles(count: int = 18, spread: float = 1.2, seed: int = 1) -> Shape:
    rng = np.random.default_rng(seed)
    theta = rng.uniform(0, 2 * np.pi, count)
    rad = spread * np.sqrt(rng.random(count))
    grey = rng.uniform(0.4, 0.75, count)
    pts = np.c_[rad * np.cos(theta), np.zeros(count), rad * np.sin(theta)]
    return loop(count, lambda i: transform_shape(
        primitive_call('sphere', {'radius': 0.05 + 0.07 * rng.random()}, color=(grey[i],) * 3),
        translation_matrix(pts[i])))


@register()
def glass_tank(radius: float = 1.5, height: float = 2.0, bars: int = 6) -> Shape:
    soil = primitive_call('cylinder', {'radius': radius, 'p0': (0, -0.4, 0), 'p1': (0, 0, 0)}, color=(0.28, 0.18, 0.1))
    lid = primitive_call('cylinder', {'radius': radius, 'p0': (0, height, 0), 'p1': (0, height + 0.08, 0)}, color=(0.7, 0.85, 0.85))
    post = primitive_call('cylinder', {'radius': 0.03, 'p0': (radius, -0.4, 0), 'p1': (radius, height, 0)}, color=(0.2, 0.2, 0.2))
    posts = loop(bars, lambda i: transform_shape(post, rotation_matrix(2 * math.pi * i / bars, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(soil, lid, posts)


@register()
def terrarium() -> Shape:
    spots = [(0, 0, 1.0), (0.7, 0.3, 0.6), (-0.6, 0.5, 0.7), (0.1, -0.8, 0.5)]
    plants = []
    for k, (x, z, s) in enumerate(spots):
        f = library_call('fern', depth=3 if s > 0.65 else 2)
        f = transform_shape(f, scale_matrix(s, (0, 0, 0)))
        f = transform_shape(f, rotation_matrix(k * 1.3, (0, 1, 0), (0, 0, 0)))
        plants.append(transform_shape(f, translation_matrix((x, 0, z))))
    return concat_shapes(library_call('glass_tank'), library_call('pebbles'), *plants)
