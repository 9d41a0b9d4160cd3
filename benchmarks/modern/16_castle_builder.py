"""a medieval castle with four towers, crenellated walls and a gatehouse"""
from helper import *
from contextlib import contextmanager
import math

STONE = (0.6, 0.58, 0.55)
ROOF = (0.5, 0.15, 0.12)


class Builder:
    """Fluent builder with a transform stack."""

    def __init__(self):
        self._shapes = []
        self._stack = [identity_matrix()]

    @contextmanager
    def at(self, x=0.0, y=0.0, z=0.0, *, turn=0.0):
        pose = translation_matrix((x, y, z)) @ rotation_matrix(turn, (0, 1, 0), (0, 0, 0))
        self._stack.append(self._stack[-1] @ pose)
        try:
            yield self
        finally:
            self._stack.pop()

    def add(self, shape):
        self._shapes.append(transform_shape(shape, self._stack[-1]))
        return self

    def box(self, sx, sy, sz, color=STONE):
        return self.add(primitive_call('cube', shape_kwargs={'scale': (sx, sy, sz)}, color=color))

    def drum(self, r, y0, y1, color=STONE):
        return self.add(primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, y0, 0), 'p1': (0, y1, 0)}, color=color))

    def build(self):
        return concat_shapes(*self._shapes)


@register()
def tower(height: float = 5.0, radius: float = 1.0) -> Shape:
    b = Builder()
    b.drum(radius, 0, height).drum(radius * 1.15, height, height + 0.3)
    steps = 8
    for i in range(steps):
        r = radius * 1.2 * (1 - i / steps)
        b.drum(r, height + 0.3 + i * 0.25, height + 0.55 + i * 0.25, color=ROOF)
    with b.at(y=height * 0.6, z=radius):
        b.box(0.2, 0.6, 0.1, color=(0.05, 0.05, 0.08))
    return b.build()


@register()
def wall(length: float = 8.0, height: float = 3.0, thickness: float = 0.6) -> Shape:
    b = Builder()
    with b.at(y=height / 2):
        b.box(length, height, thickness)
    n = int(length / 0.8)
    for i in range(n):
        with b.at(x=-length / 2 + (i + 0.5) * length / n, y=height + 0.2, z=thickness / 2 - 0.1):
            b.box(0.4, 0.4, 0.2)
    return b.build()


@register()
def gatehouse(width: float = 2.4, height: float = 4.0) -> Shape:
    b = Builder()
    with b.at(y=height / 2):
        b.box(width, height, 1.4)
        with b.at(y=-height / 2 + 1.0, z=0.7):
            b.box(1.2, 2.0, 0.1, color=(0.3, 0.2, 0.1))
            for k in range(5):
                with b.at(x=-0.5 + 0.25 * k, z=0.08):
                    b.box(0.05, 2.0, 0.05, color=(0.2, 0.2, 0.22))
    return b.build()


@register()
def castle(side: float = 10.0) -> Shape:
    b = Builder()
    half = side / 2
    with b.at(y=-0.1):
        b.box(side * 1.6, 0.2, side * 1.6, color=(0.35, 0.5, 0.25))
    for k in range(4):
        with b.at(turn=k * math.pi / 2):
            with b.at(z=half):
                b.add(library_call('wall', length=side))
            with b.at(x=half, z=half):
                b.add(library_call('tower'))
    with b.at(z=half):
        b.add(library_call('gatehouse'))
    with b.at(y=2.5):
        b.box(3, 5, 3)
    return b.build()
