from enum import Enum, auto

from helper import *

"""
a row of traffic signals, each in another phase
"""


class Phase(Enum):
    STOP = auto()
    READY = auto()
    GO = auto()
    CAUTION = auto()

    @property
    def lit(self) -> tuple[bool, bool, bool]:
        return {
            Phase.STOP: (True, False, False),
            Phase.READY: (True, True, False),
            Phase.GO: (False, False, True),
            Phase.CAUTION: (False, True, False),
        }[self]

    def next(self) -> "Phase":
        members = list(Phase)
        return members[(members.index(self) + 1) % len(members)]


LAMP_COLORS = ((0.95, 0.1, 0.1), (1.0, 0.75, 0.0), (0.1, 0.85, 0.2))


@register("one signal lamp")
def lamp(color: tuple, on: bool) -> Shape:
    factor = 1.0 if on else 0.2
    bulb = primitive_call('sphere', shape_kwargs={'radius': 0.14}, color=tuple(c * factor for c in color))
    hood = primitive_call('cylinder', shape_kwargs={'radius': 0.16, 'p0': (0, 0, -0.05), 'p1': (0, 0, 0.02)}, color=(0.1, 0.1, 0.1))
    return concat_shapes(hood, transform_shape(bulb, translation_matrix((0, 0, 0.05))))


@register("traffic signal")
def signal(phase: Phase) -> Shape:
    pole = primitive_call('cylinder', shape_kwargs={'radius': 0.06, 'p0': (0, 0, 0), 'p1': (0, 2.2, 0)}, color=(0.35, 0.35, 0.38))
    box = primitive_call('cube', shape_kwargs={'scale': (0.45, 1.3, 0.3)}, color=(0.12, 0.13, 0.12))
    box = transform_shape(box, translation_matrix((0, 2.85, 0)))
    lamps = [
        transform_shape(library_call('lamp', color=color, on=on), translation_matrix((0, 3.25 - 0.4 * row, 0.17)))
        for row, (color, on) in enumerate(zip(LAMP_COLORS, phase.lit))
    ]
    return concat_shapes(pole, box, *lamps)


@register("street with signals")
def street() -> Shape:
    road = primitive_call('cube', shape_kwargs={'scale': (10, 0.1, 2)}, color=(0.25, 0.25, 0.27))
    phase, shapes = Phase.STOP, [road]
    for i in range(len(Phase) + 1):
        shapes.append(transform_shape(library_call('signal', phase=phase), translation_matrix((2 * (i - 2), 0, 0))))
        print(phase, phase.name, phase.value)
        phase = phase.next()
    return concat_shapes(*shapes)
