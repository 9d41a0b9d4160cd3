"""
a rotating-wheel space station with docked shuttles above a planet
"""
from helper import *
import math
from abc import ABC, abstractmethod
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import reduce

import numpy as np

WHITE, GREY, BLUE = (0.92, 0.93, 0.95), (0.5, 0.52, 0.56), (0.1, 0.2, 0.5)


class Scene:
    """A matrix stack in the manner of old OpenGL."""

    def __init__(self):
        self._stack = [np.eye(4)]
        self.items: list = []

    @property
    def top(self) -> np.ndarray:
        return self._stack[-1]

    @contextmanager
    def pushed(self, *poses):
        self._stack.append(reduce(np.matmul, poses, self.top))
        try:
            yield self
        finally:
            self._stack.pop()

    def draw(self, shape) -> 'Scene':
        self.items.extend(transform_shape(shape, self.top))
        return self

    __lshift__ = draw


@dataclass
class Module(ABC):
    size: float = 1.0
    color: tuple[float, float, float] = WHITE

    @abstractmethod
    def emit(self, scene: Scene) -> None: ...


@dataclass
class Hub(Module):
    ports: int = 4

    def emit(self, scene):
        scene << primitive_call('cylinder', {'radius': 0.5 * self.size, 'p0': (0, -self.size, 0), 'p1': (0, self.size, 0)}, color=self.color)
        for end in (-1, 1):
            with scene.pushed(translation_matrix((0, end * self.size * 1.1, 0))):
                scene << primitive_call('sphere', {'radius': 0.4 * self.size}, color=GREY)


@dataclass
class Rim(Module):
    segments: int = 24
    spokes: int = 4
    radius: float = field(default=3.0, kw_only=True)

    def emit(self, scene):
        step = 2 * math.pi / self.segments
        seg_len = 2 * self.radius * math.tan(step / 2) * 1.05
        for i in range(self.segments):
            with scene.pushed(rotation_matrix(i * step, (0, 1, 0), (0, 0, 0)), translation_matrix((self.radius, 0, 0))):
                scene << primitive_call('cube', {'scale': (0.5, 0.5, seg_len)}, color=self.color)
                if i % 2:
                    with scene.pushed(translation_matrix((0.26, 0, 0))):
                        scene << primitive_call('cube', {'scale': (0.02, 0.15, seg_len * 0.5)}, color=(1.0, 0.9, 0.5))
        for k in range(self.spokes):
            with scene.pushed(rotation_matrix(k * 2 * math.pi / self.spokes, (0, 1, 0), (0, 0, 0))):
                scene << primitive_call('cylinder', {'radius': 0.12, 'p0': (0.4, 0, 0), 'p1': (self.radius, 0, 0)}, color=GREY)


@register()
def solar_panel(cells: int = 6, width: float = 0.8) -> Shape:
    s = Scene()
    for i in range(cells):
        with s.pushed(translation_matrix((0.5 + i * 0.42, 0, 0))):
            s << primitive_call('cube', {'scale': (0.4, 0.03, width)}, color=BLUE)
    s << primitive_call('cylinder', {'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0.4 * cells + 0.5, 0, 0)}, color=GREY)
    return s.items


@register()
def shuttle(length: float = 1.2) -> Shape:
    s = Scene()
    s << primitive_call('cylinder', {'radius': 0.14, 'p0': (0, 0, 0), 'p1': (0, length, 0)}, color=WHITE)
    with s.pushed(translation_matrix((0, length, 0))):
        s << primitive_call('sphere', {'radius': 0.14}, color=(0.15, 0.15, 0.17))
    for side in (-1, 1):
        with s.pushed(rotation_matrix(side * 0.5, (0, 0, 1), (0, 0, 0)), translation_matrix((side * 0.2, 0.3, 0))):
            s << primitive_call('cube', {'scale': (0.35, 0.4, 0.03)}, color=GREY)
    return s.items


@register()
def space_station(rims: int = 2, spin: float = 0.3) -> Shape:
    scene = Scene()
    with scene.pushed(rotation_matrix(0.35, (0, 0, 1), (0, 0, 0)), rotation_matrix(spin, (0, 1, 0), (0, 0, 0))):
        parts: list[tuple[float, Module]] = [(0.0, Hub(1.6))] + [((i - (rims - 1) / 2) * 1.4, Rim(radius=3.0 - 0.6 * i)) for i in range(rims)]
        for y, module in parts:
            with scene.pushed(translation_matrix((0, y, 0))):
                module.emit(scene)
        for k, a in enumerate((0, math.pi)):
            with scene.pushed(translation_matrix((0, 2.1, 0)), rotation_matrix(a, (0, 1, 0), (0, 0, 0))):
                scene << library_call('solar_panel')
        with scene.pushed(translation_matrix((0, -2.2, 0)), rotation_matrix(math.pi, (1, 0, 0), (0, 0, 0))):
            scene << library_call('shuttle')
    assert len(scene._stack) == 1
    with scene.pushed(translation_matrix((-6, -12, -6))):
        scene << primitive_call('sphere', {'radius': 9.0}, color=(0.25, 0.45, 0.7))
    return scene.items
