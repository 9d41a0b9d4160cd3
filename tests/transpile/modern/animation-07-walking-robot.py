from enum import Enum, auto
from itertools import cycle, islice
from helper import *

"""
a robot that walks, turns and waves
"""


class Mode(Enum):
    WALK = auto()
    TURN = auto()
    WAVE = auto()


class Robot:
    TRANSITIONS = {Mode.WALK: (8, Mode.TURN), Mode.TURN: (4, Mode.WAVE), Mode.WAVE: (6, Mode.WALK)}

    def __init__(self):
        self.mode, self.ticks = Mode.WALK, 0
        self.x = self.z = self.heading = 0.0
        self.phase = 0.0
        self.arm = 0.0

    def update(self):
        getattr(self, "_" + self.mode.name.lower())()
        self.ticks += 1
        limit, following = self.TRANSITIONS[self.mode]
        if self.ticks >= limit:
            self.mode, self.ticks = following, 0
        return self

    def _walk(self):
        self.x += 0.25 * math.cos(self.heading)
        self.z -= 0.25 * math.sin(self.heading)
        self.phase += 0.8

    def _turn(self):
        self.heading += math.pi / 8

    def _wave(self):
        self.arm = 1.2 * abs(math.sin(self.ticks))

    @property
    def pose(self):
        return translation_matrix((self.x, 0, self.z)) @ rotation_matrix(self.heading, (0, 1, 0), (0, 0, 0))


METAL = (0.6, 0.65, 0.7)


def limb(length, angle, at):
    part = transform_shape(primitive_call('cube', color=METAL, shape_kwargs={'scale': (0.2, length, 0.2)}), translation_matrix((0, -length / 2, 0)))
    return transform_shape(part, translation_matrix(at) @ rotation_matrix(angle, (0, 0, 1), (0, 0, 0)))


@register()
def robot(phase: float, arm: float, eyes: tuple) -> Shape:
    swing = 0.5 * math.sin(phase)
    body = transform_shape(primitive_call('cube', color=(0.3, 0.4, 0.7), shape_kwargs={'scale': (0.6, 1, 0.9)}), translation_matrix((0, 1.5, 0)))
    head = transform_shape(primitive_call('cube', color=METAL, shape_kwargs={'scale': (0.5, 0.5, 0.6)}), translation_matrix((0, 2.3, 0)))
    pupils = [transform_shape(primitive_call('sphere', color=eyes, shape_kwargs={'radius': 0.08}), translation_matrix((0.26, 2.35, z))) for z in (-0.15, 0.15)]
    limbs = [limb(1, swing, (0, 1, -0.3)), limb(1, -swing, (0, 1, 0.3)), limb(0.9, -swing, (0, 2, -0.6)), limb(0.9, swing + 2 * arm, (0, 2, 0.6))]
    return concat_shapes(body, head, *pupils, *limbs)


@register_animation()
def robot_show() -> Generator[Shape, None, None]:
    colors = cycle([(0.1, 0.9, 0.3)] * 3 + [(0.05, 0.2, 0.1)])
    floor = primitive_call('cube', color=(0.4, 0.4, 0.42), shape_kwargs={'scale': (12, 0.1, 12)})
    machine = Robot()
    trail = []
    for eyes in islice(colors, 30):
        machine.update()
        if machine.mode is Mode.WALK and machine.ticks % 3 == 0:
            trail.append((machine.x, 0.06, machine.z))
        marks = [transform_shape(primitive_call('sphere', color=(0.9, 0.6, 0.1), shape_kwargs={'radius': 0.06}), translation_matrix(p)) for p in trail[-5:]]
        yield concat_shapes(floor, transform_shape(library_call('robot', phase=machine.phase, arm=machine.arm, eyes=eyes), machine.pose), *marks)
