"""a coral reef with branching coral, sea fans, an anemone and a school of fish"""
from helper import *
from abc import ABC, abstractmethod
from collections import deque
from typing import ClassVar
import numpy as np


class Coral(ABC):
    """A growing thing: every subclass registers itself by its key."""
    registry: ClassVar[dict[str, type['Coral']]] = {}
    key: ClassVar[str]
    tint: ClassVar[tuple[float, float, float]] = (0.9, 0.5, 0.5)

    def __init_subclass__(cls, /, key: str, **kwargs):
        super().__init_subclass__(**kwargs)
        cls.key = key
        Coral.registry[key] = cls

    def __init__(self, size: float, rng: np.random.Generator):
        self.size, self.rng = size, rng

    @abstractmethod
    def grow(self) -> Shape:
        ...

    def tone(self, t: float) -> tuple[float, float, float]:
        base, light = np.array(self.tint), np.array([1.0, 0.95, 0.9])
        return tuple((base + (light - base) * t * 0.6).tolist())

    @staticmethod
    def rod(a, b, r, color) -> Shape:
        return primitive_call('cylinder', shape_kwargs={'radius': float(r), 'p0': tuple(map(float, a)), 'p1': tuple(map(float, b))}, color=color)

    @staticmethod
    def knob(at, r, color) -> Shape:
        return transform_shape(primitive_call('sphere', shape_kwargs={'radius': float(r)}, color=color), translation_matrix(at))


class Staghorn(Coral, key='staghorn'):
    tint = (0.95, 0.45, 0.35)

    def grow(self, generations: int = 4) -> Shape:
        queue = deque([(np.zeros(3), np.array([0.0, 1.0, 0.0]), 0)])
        shapes = []
        while queue:
            base, direction, g = queue.popleft()
            length = self.size * 0.45 * 0.8 ** g
            tip = base + direction * length
            shapes.append(self.rod(base, tip, self.size * 0.07 * 0.75 ** g, self.tone(g / generations)))
            if g + 1 < generations:
                for _ in range(2 if g else 4):
                    d = direction + self.rng.normal(scale=0.45, size=3) + [0, 0.25, 0]
                    queue.append((tip, d / np.linalg.norm(d), g + 1))
            else:
                shapes.append(self.knob(tip, self.size * 0.04, (1, 0.95, 0.9)))
        return concat_shapes(*shapes)


class SeaFan(Coral, key='fan'):
    tint = (0.6, 0.25, 0.65)

    def grow(self) -> Shape:
        shapes = []
        for theta in np.linspace(-1.0, 1.0, 11):
            r = self.size * (1 - 0.25 * theta ** 2)
            shapes.append(self.rod((0, 0, 0), (r * np.sin(theta), r * np.cos(theta), 0), 0.015, self.tint))
        for ring in np.arange(0.3, 1.0, 0.2) * self.size:
            arc = [(ring * np.sin(t), ring * np.cos(t), 0) for t in np.linspace(-0.9, 0.9, 9)]
            shapes.extend(self.rod(a, b, 0.01, self.tone(0.4)) for a, b in zip(arc, arc[1:]))
        return concat_shapes(*shapes)


class Brain(Coral, key='brain'):
    tint = (0.75, 0.7, 0.35)

    def grow(self) -> Shape:
        n = 60
        k = np.arange(n) + 0.5
        phi, theta = np.arccos(1 - k / n), np.pi * (1 + 5 ** 0.5) * k  # upper half of a Fibonacci sphere
        pts = self.size * 0.5 * np.c_[np.sin(phi) * np.cos(theta), np.cos(phi), np.sin(phi) * np.sin(theta)]
        return concat_shapes(self.knob((0, 0, 0), self.size * 0.5, self.tint), *(self.knob(p, self.size * 0.05, self.tone(float(i % 2))) for i, p in enumerate(pts)))


class Anemone(Coral, key='anemone'):
    tint = (0.9, 0.4, 0.7)

    def grow(self) -> Shape:
        shapes = [self.rod((0, 0, 0), (0, 0.2 * self.size, 0), 0.3 * self.size, (0.5, 0.2, 0.3))]
        for i in range(24):
            a, r = i * 2.39996, 0.28 * self.size * np.sqrt(i / 24)
            p = np.array([r * np.cos(a), 0.2 * self.size, r * np.sin(a)])
            for s in range(4):
                q = p + np.array([0.06 * np.sin(a + s), 0.12 * self.size, 0.06 * np.cos(a * 2 + s)])
                shapes.append(self.rod(p, q, 0.03 - 0.005 * s, self.tone(s / 4)))
                p = q
        return concat_shapes(*shapes)


@register()
def coral(kind: str = 'staghorn', size: float = 1.0, seed: int = 0) -> Shape:
    return Coral.registry[kind](size, np.random.default_rng(seed)).grow()


@register()
def fish(length: float = 0.3, color: tuple = (0.98, 0.6, 0.1), stripes: int = 2) -> Shape:
    body = transform_shape(primitive_call('sphere', shape_kwargs={'radius': length / 2}, color=color), scale_matrix((1, 0.55, 0.28), (0, 0, 0)))
    tail = transform_shape(primitive_call('cube', shape_kwargs={'scale': (length * 0.25, length * 0.25, 0.01)}, color=color), translation_matrix((-length * 0.55, 0, 0)) @ rotation_matrix(np.pi / 4, (0, 0, 1), (0, 0, 0)))
    bands = loop(stripes, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (length * 0.07, length * 0.5, length * 0.26)}, color=(1, 1, 1)), translation_matrix((length * (0.2 - 0.3 * i), 0, 0))))
    eye = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': length * 0.05}, color=(0, 0, 0)), translation_matrix((length * 0.33, length * 0.06, s * length * 0.1))) for s in (-1, 1)]
    return concat_shapes(body, tail, bands, *eye)


@register()
def reef(corals: int = 12, fishes: int = 14, seed: int = 88) -> Shape:
    rng = np.random.default_rng(seed)
    kinds = list(Coral.registry)
    placed = []
    for i, kind in enumerate(rng.choice(kinds, size=corals, p=[0.4, 0.2, 0.25, 0.15])):
        r, a = 0.9 * np.sqrt(i + 0.5), i * 2.4
        c = library_call('coral', kind=str(kind), size=float(rng.uniform(0.6, 1.2)), seed=i)
        placed.append(transform_shape(c, translation_matrix((r * np.cos(a), 0, r * np.sin(a))) @ rotation_matrix(a, (0, 1, 0), (0, 0, 0))))
    school = []
    for k in range(fishes):
        t = 2 * np.pi * k / fishes
        f = library_call('fish', length=0.25 + 0.02 * (k % 4), color=(0.98, 0.6, 0.1) if k % 3 else (0.2, 0.5, 0.95))
        school.append(transform_shape(f, translation_matrix((2.2 * np.cos(t), 1.7 + 0.4 * np.sin(3 * t), 2.2 * np.sin(t))) @ rotation_matrix(-t - np.pi / 2, (0, 1, 0), (0, 0, 0))))
    sand = primitive_call('cylinder', shape_kwargs={'radius': 4.2, 'p0': (0, -0.2, 0), 'p1': (0, 0, 0)}, color=(0.9, 0.83, 0.65))
    return concat_shapes(sand, *placed, *school)
