"""
a mobile built with a context manager for nested transforms
"""
from helper import *
import math
from contextlib import contextmanager
from typing import Optional


class Scene:
    def __init__(self):
        self.matrices = [identity_matrix()]
        self.shapes = []

    @property
    def current(self):
        return self.matrices[-1]

    @contextmanager
    def push(self, *steps):
        m = self.current
        for s in steps:
            m = m @ s
        self.matrices.append(m)
        try:
            yield self
        finally:
            self.matrices.pop()

    def add(self, shape):
        self.shapes.append(transform_shape(shape, self.current))
        return self

    def finish(self):
        return concat_shapes(*self.shapes)


def rod(length):
    return primitive_call('cylinder', color=(0.3, 0.3, 0.3), shape_kwargs={'radius': 0.03, 'p0': (-length / 2, 0, 0), 'p1': (length / 2, 0, 0)})


def thread(length):
    return primitive_call('cylinder', color=(0.8, 0.8, 0.8), shape_kwargs={'radius': 0.01, 'p0': (0, 0, 0), 'p1': (0, -length, 0)})


def hang(scene: Scene, depth: int, width: float, hue: float = 0.0):
    scene.add(thread(0.6))
    with scene.push(translation_matrix((0, -0.6, 0))):
        if depth == 0:
            scene.add(primitive_call('sphere', color=(0.9, hue, 1 - hue), shape_kwargs={'radius': 0.15 + width * 0.1}))
            return
        with scene.push(rotation_matrix(math.pi / 5 * depth, (0, 1, 0), (0, 0, 0))):
            scene.add(rod(width))
            for side in (-1, 1):
                with scene.push(translation_matrix((side * width / 2, 0, 0))):
                    hang(scene, depth - 1, width * 0.55, hue + (0.2 if side > 0 else 0.05))


@register()
def mobile(depth: int = 3, width: float = 3.0) -> Shape:
    scene = Scene()
    hang(scene, depth, width)
    return scene.finish()
