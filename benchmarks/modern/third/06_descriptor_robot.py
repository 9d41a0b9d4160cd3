"""
a tin robot made of validated parts
"""
from helper import *
import math
from dataclasses import dataclass


class Positive:
    """A number that has to be positive."""

    def __init__(self, default: float):
        self.default = default

    def __set_name__(self, owner, name):
        self.name = '_' + name

    def __get__(self, instance, owner=None):
        if instance is None:
            return self.default
        return getattr(instance, self.name, self.default)

    def __set__(self, instance, value):
        if value <= 0:
            raise ValueError(f'{self.name} must be positive, got {value}')
        setattr(instance, self.name, value)


class Body:
    width = Positive(1.2)
    height = Positive(1.6)
    depth = Positive(0.8)

    def __init__(self, **sizes: float):
        for name, value in sizes.items():
            setattr(self, name, value)

    @property
    def shoulder(self) -> tuple[float, float, float]:
        return (self.width / 2 + 0.15, self.height * 0.85, 0.0)

    @property
    def hip(self) -> tuple[float, float, float]:
        return (self.width / 4, 0.0, 0.0)


@dataclass
class Joint:
    angle: float
    length: float

    def matrix(self):
        return rotation_matrix(self.angle, (1, 0, 0), (0, 0, 0))


STEEL = (0.65, 0.68, 0.72)
RED = (0.8, 0.2, 0.15)


@register()
def segment(length: float = 0.8, radius: float = 0.12) -> Shape:
    rod = primitive_call('cylinder', color=STEEL, shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, -length, 0)})
    knob = primitive_call('sphere', color=RED, shape_kwargs={'radius': radius * 1.4})
    return concat_shapes(knob, rod)


@register()
def arm(upper: float = 0.7, lower: float = 0.6, lift: float = 0.4, bend: float = -0.8) -> Shape:
    joints = [Joint(lift, upper), Joint(bend, lower)]
    chain = primitive_call('sphere', color=RED, shape_kwargs={'radius': 0.16})
    for joint in reversed(joints):
        chain = transform_shape(chain, translation_matrix((0, -joint.length, 0)))
        chain = concat_shapes(library_call('segment', length=joint.length), chain)
        chain = transform_shape(chain, joint.matrix())
    return chain


@register()
def head(size: float = 0.8) -> Shape:
    skull = primitive_call('cube', color=STEEL, shape_kwargs={'scale': (size, size * 0.8, size * 0.8)})
    eyes = [transform_shape(primitive_call('sphere', color=(1, 0.9, 0.3), shape_kwargs={'radius': size * 0.12}), translation_matrix((s * size * 0.22, size * 0.1, size * 0.4))) for s in (-1, 1)]
    aerial = primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.03, 'p0': (0, size * 0.4, 0), 'p1': (0, size * 0.9, 0)})
    return concat_shapes(skull, *eyes, aerial)


@register()
def robot() -> Shape:
    body = Body(width=1.4, height=1.7)
    torso = transform_shape(primitive_call('cube', color=RED, shape_kwargs={'scale': (body.width, body.height, body.depth)}), translation_matrix((0, body.height / 2, 0)))
    arms = []
    for side, lift in ((-1, 0.3), (1, -0.9)):
        x, y, z = body.shoulder
        arms.append(transform_shape(library_call('arm', lift=lift), translation_matrix((side * x, y, z))))
    legs = [transform_shape(library_call('segment', length=1.1, radius=0.2), translation_matrix((s * body.hip[0], 0, 0))) for s in (-1, 1)]
    top = transform_shape(library_call('head'), translation_matrix((0, body.height + 0.4, 0)))
    return concat_shapes(torso, *arms, *legs, top)
