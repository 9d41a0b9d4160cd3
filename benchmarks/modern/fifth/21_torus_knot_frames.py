"""a polished torus-knot sculpture on a marble plinth in a gallery"""
from __future__ import annotations

from helper import *
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
import numpy as np


@dataclass(frozen=True, slots=True)
class Quaternion:
    w: float
    x: float
    y: float
    z: float

    @classmethod
    def about(cls, axis: np.ndarray, angle: float) -> Quaternion:
        x, y, z = np.sin(angle / 2) * axis / np.linalg.norm(axis)
        return cls(np.cos(angle / 2), x, y, z)

    @classmethod
    def between(cls, a: np.ndarray, b: np.ndarray) -> Quaternion:
        """The shortest rotation that takes unit vector a to unit vector b."""
        axis, dot = np.cross(a, b), float(np.dot(a, b))
        if np.linalg.norm(axis) < 1e-9:
            return cls(1, 0, 0, 0) if dot > 0 else cls(0, 1, 0, 0)
        return cls.about(axis, np.arctan2(np.linalg.norm(axis), dot))

    def __mul__(self, o: Quaternion) -> Quaternion:
        return Quaternion(
            self.w * o.w - self.x * o.x - self.y * o.y - self.z * o.z,
            self.w * o.x + self.x * o.w + self.y * o.z - self.z * o.y,
            self.w * o.y - self.x * o.z + self.y * o.w + self.z * o.x,
            self.w * o.z + self.x * o.y - self.y * o.x + self.z * o.w,
        )

    @property
    def matrix(self) -> np.ndarray:
        w, x, y, z = self.w, self.x, self.y, self.z
        m = np.eye(4)
        m[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        return m


class TorusKnot:
    def __init__(self, p: int, q: int, major: float = 1.0, minor: float = 0.42, samples: int = 160):
        self.p, self.q, self.major, self.minor, self.samples = p, q, major, minor, samples

    @cached_property
    def points(self) -> np.ndarray:
        t = np.linspace(0, 2 * np.pi, self.samples, endpoint=False)
        r = self.major + self.minor * np.cos(self.q * t)
        return np.stack([r * np.cos(self.p * t), self.minor * np.sin(self.q * t), r * np.sin(self.p * t)], axis=-1)

    @cached_property
    def tangents(self) -> np.ndarray:
        d = np.roll(self.points, -1, axis=0) - np.roll(self.points, 1, axis=0)
        return d / np.linalg.norm(d, axis=1, keepdims=True)

    def frames(self):
        """Parallel transport of a frame along the knot."""
        q = Quaternion.between(np.array([0.0, 0.0, 1.0]), self.tangents[0])
        yield q
        for a, b in pairwise(self.tangents):
            q = Quaternion.between(a, b) * q
            yield q

    def __len__(self) -> int:
        return self.samples


@register()
def ribbon(p: int = 2, q: int = 3, width: float = 0.34, thickness: float = 0.09, twists: int = 3) -> Shape:
    knot = TorusKnot(p, q)
    step = np.linalg.norm(knot.points[1] - knot.points[0]) * 1.15
    parts = []
    for i, (pos, frame) in enumerate(zip(knot.points, knot.frames(), strict=True)):
        u = i / len(knot)
        color = np.array([0.85, 0.6, 0.25]) * (0.75 + 0.25 * np.cos(4 * np.pi * u))
        slab = primitive_call('cube', shape_kwargs={'scale': (width, thickness, step)}, color=tuple(color))
        roll = rotation_matrix(2 * np.pi * twists * u, (0, 0, 1), (0, 0, 0))
        parts.append(transform_shape(slab, translation_matrix(pos) @ frame.matrix @ roll))
    return concat_shapes(*parts)


@register()
def plinth(height: float = 1.2, width: float = 1.1) -> Shape:
    tiers = [(1.3, 0.1), (1.15, 0.08), (1.0, height - 0.36), (1.15, 0.08), (1.25, 0.1)]
    shapes, y = [], 0.0
    for scale, h in tiers:
        block = primitive_call('cube', shape_kwargs={'scale': (width * scale, h, width * scale)}, color=(0.9, 0.9, 0.92))
        shapes.append(transform_shape(block, translation_matrix((0, y + h / 2, 0))))
        y += h
    return concat_shapes(*shapes)


@register()
def gallery(p: int = 2, q: int = 3) -> Shape:
    base = library_call('plinth')
    art = transform_shape(library_call('ribbon', p=p, q=q), rotation_matrix(np.pi / 3, (1, 0, 0), (0, 0, 0)))
    lift = compute_shape_max(base)[1] - compute_shape_min(art)[1]
    spot = loop(5, lambda i: transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.12}, color=(1, 0.97, 0.85)), translation_matrix((1.2 * (i - 2), 4.5, 0.8))))
    floor = transform_shape(primitive_call('cube', shape_kwargs={'scale': (8, 0.1, 8)}, color=(0.45, 0.4, 0.38)), translation_matrix((0, -0.05, 0)))
    return concat_shapes(floor, base, transform_shape(art, translation_matrix((0, lift, 0))), spot)
