from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

from helper import *

"""
playground equipment behind an abstract interface
"""

STEEL = (0.7, 0.72, 0.75)


def bar(a, b, radius=0.06, color=STEEL) -> Shape:
    return primitive_call('cylinder', color=color, shape_kwargs={'radius': radius, 'p0': tuple(a), 'p1': tuple(b)})


class Equipment(ABC):
    @property
    @abstractmethod
    def footprint(self) -> float:
        """Width taken on the lawn."""

    @abstractmethod
    def build(self) -> Shape: ...

    def on_mat(self) -> Shape:
        mat = primitive_call('cube', color=(0.3, 0.3, 0.32), shape_kwargs={'scale': (self.footprint, 0.05, 2)})
        return concat_shapes(mat, self.build())


@dataclass
class Swing(Equipment):
    seats: int = 2

    @property
    def footprint(self) -> float:
        return self.seats * 1.0 + 0.6

    def build(self) -> Shape:
        w = self.footprint / 2
        frame = [bar((x, 0, z), (x, 2.2, 0)) for x in (-w, w) for z in (-0.7, 0.7)] + [bar((-w, 2.2, 0), (w, 2.2, 0))]
        for s in range(self.seats):
            x = -w + 0.8 + s
            dz = 0.4 * math.sin(1.3 * s)
            frame += [bar((x - 0.2, 2.2, 0), (x - 0.2, 0.6, dz), 0.02), bar((x + 0.2, 2.2, 0), (x + 0.2, 0.6, dz), 0.02)]
            frame.append(transform_shape(primitive_call('cube', color=(0.9, 0.5, 0.1), shape_kwargs={'scale': (0.5, 0.05, 0.25)}), translation_matrix((x, 0.6, dz))))
        return concat_shapes(*frame)


@dataclass
class Slide(Equipment):
    height: float = 1.8

    @property
    def footprint(self) -> float:
        return 1.4

    def build(self) -> Shape:
        rungs = [bar((-0.3, h, -0.8), (0.3, h, -0.8), 0.03) for h in np.arange(0.3, self.height, 0.3)]
        chute = transform_shape(primitive_call('cube', color=(0.1, 0.5, 0.9), shape_kwargs={'scale': (0.6, 0.06, self.height * 1.4)}),
                                translation_matrix((0, self.height / 2, 0.2)) @ rotation_matrix(math.pi / 4, (1, 0, 0), (0, 0, 0)))
        return concat_shapes(*rungs, chute)


@register("playground")
def playground() -> Shape:
    try:
        Equipment()
    except TypeError:
        print("an abstract class cannot be built")
    x, shapes = 0.0, []
    for item in [Swing(), Slide(), Swing(seats=4), Slide(height=2.5)]:
        shapes.append(transform_shape(item.on_mat(), translation_matrix((x + item.footprint / 2, 0, 0))))
        x += item.footprint + 0.5
    return concat_shapes(*shapes)
