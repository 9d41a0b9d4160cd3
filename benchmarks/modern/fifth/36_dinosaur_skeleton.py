"""a long-necked dinosaur skeleton mounted in a museum hall with rope barriers"""
from helper import *
from bisect import bisect_right
from collections.abc import Sequence
from typing import Generic, TypeVar, overload
import math
import numpy as np

BONE = np.array([0.9, 0.85, 0.72])
T_ = TypeVar('T_')


class Track(Generic[T_]):
    """Values at keys with smooth interpolation between them."""

    def __init__(self, keys: Sequence[float], values: Sequence[T_]):
        assert len(keys) == len(values) and list(keys) == sorted(keys)
        self.keys, self.values = list(keys), [np.asarray(v, dtype=float) for v in values]

    def __call__(self, t: float):
        if t <= self.keys[0]:
            return self.values[0]
        if t >= self.keys[-1]:
            return self.values[-1]
        i = bisect_right(self.keys, t) - 1
        u = (t - self.keys[i]) / (self.keys[i + 1] - self.keys[i])
        p1, p2 = self.values[i], self.values[i + 1]
        p0 = self.values[i - 1] if i > 0 else 2 * p1 - p2
        p3 = self.values[i + 2] if i + 2 < len(self.values) else 2 * p2 - p1
        basis = np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]]) / 2
        weights = np.array([1, u, u ** 2, u ** 3]) @ basis
        return sum(w * p for w, p in zip(weights, (p0, p1, p2, p3)))

    def tangent(self, t: float, h: float = 1e-3):
        d = self(t + h) - self(t - h)
        return d / np.linalg.norm(d)


# from the tip of the tail (t = 0) to the skull (t = 1)
SPINE = Track([0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9, 1.0],
              [(-6.0, 0.6, 0.6), (-4.4, 1.0, 0.2), (-2.8, 1.9, 0), (-1.2, 2.4, 0), (0.6, 2.3, 0), (2.0, 3.0, 0.1), (3.2, 4.3, 0.3), (4.0, 4.7, 0.6)])
GIRTH = Track([0.0, 0.2, 0.42, 0.6, 0.8, 1.0], [0.03, 0.09, 0.16, 0.16, 0.1, 0.07])


def bone(a, b, r, shade: float = 1.0) -> Shape:
    color = tuple((BONE * shade).tolist())
    return concat_shapes(
        primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': tuple(a), 'p1': tuple(b)}, color=color),
        *[transform_shape(primitive_call('sphere', shape_kwargs={'radius': r * 1.5}, color=color), translation_matrix(p)) for p in (a, b)])


@register()
def vertebra(girth: float = 0.12, spine_height: float = 0.25) -> Shape:
    color = tuple(BONE.tolist())
    body = primitive_call('cylinder', shape_kwargs={'radius': girth, 'p0': (-girth * 0.6, 0, 0), 'p1': (girth * 0.6, 0, 0)}, color=color)
    process = transform_shape(primitive_call('cube', shape_kwargs={'scale': (girth * 0.8, spine_height, girth * 0.4)}, color=color), translation_matrix((-girth * 0.2, girth + spine_height / 2, 0)) @ rotation_matrix(0.3, (0, 0, 1), (0, 0, 0)))
    sides = transform_shape(primitive_call('cube', shape_kwargs={'scale': (girth * 0.5, girth * 0.3, girth * 3.4)}, color=color), translation_matrix((0, girth * 0.3, 0)))
    return concat_shapes(body, process, sides)


@register()
def backbone(count: int = 46) -> Shape:
    out = []
    for t in np.linspace(0.01, 0.98, count):
        p, d = SPINE(t), SPINE.tangent(t)
        g = float(GIRTH(t))
        yaw, pitch = math.atan2(-d[2], d[0]), math.asin(np.clip(d[1], -1, 1))
        pose = translation_matrix(p) @ rotation_matrix(yaw, (0, 1, 0), (0, 0, 0)) @ rotation_matrix(pitch, (0, 0, 1), (0, 0, 0))
        out.append(transform_shape(library_call('vertebra', girth=g, spine_height=0.1 + 0.35 * math.exp(-((t - 0.48) / 0.15) ** 2)), pose))
    return concat_shapes(*out)


@register()
def ribs(pairs: int = 10, start: float = 0.43, end: float = 0.64, drop: float = 1.1) -> Shape:
    out = []
    for k, t in enumerate(np.linspace(start, end, pairs)):
        x, y, z = SPINE(t)
        bulge = math.sin(math.pi * (k + 1) / (pairs + 1)) ** 0.5
        for side in (-1, 1):
            arc = [(x - 0.1 * a, y - drop * bulge * (1 - math.cos(a)) / 2, z + side * 0.62 * bulge * math.sin(a)) for a in np.linspace(0, 2.6, 8)]
            out += [primitive_call('cylinder', shape_kwargs={'radius': 0.045 - 0.004 * i, 'p0': p, 'p1': q}, color=tuple(BONE * 0.95)) for i, (p, q) in enumerate(zip(arc[:-1], arc[1:]))]
    return concat_shapes(*out)


@register()
def leg(hip: tuple = (0.0, 2.2, 0.35), stride: float = 0.3, toes: int = 3) -> Shape:
    x, y, z = hip
    knee = (x + 0.3 + stride * 0.5, y * 0.52, z + 0.08)
    ankle = (x - 0.1 + stride, y * 0.16, z + 0.05)
    parts = [bone(hip, knee, 0.1), bone(knee, ankle, 0.075), bone(ankle, (ankle[0] + 0.12, 0.06, z), 0.06)]
    for k in range(toes):
        a = (k - (toes - 1) / 2) * 0.5
        parts.append(bone((ankle[0] + 0.12, 0.06, z), (ankle[0] + 0.12 + 0.32 * math.cos(a), 0.03, z + 0.32 * math.sin(a)), 0.03))
    return concat_shapes(*parts)


@register()
def skull(length: float = 0.7, jaw: float = 18.0, teeth: int = 7) -> Shape:
    color = tuple(BONE.tolist())
    def wedge(sign: int) -> Shape:
        plates = loop(5, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (length / 5, 0.12 - 0.012 * i if sign > 0 else 0.06, 0.3 - 0.035 * i)}, color=color), translation_matrix((length * (i + 0.5) / 5, sign * 0.05, 0))))
        pegs = [primitive_call('cylinder', shape_kwargs={'radius': 0.014, 'p0': (length * (0.35 + 0.6 * i / teeth), 0, s * (0.11 - 0.008 * i)), 'p1': (length * (0.35 + 0.6 * i / teeth), -sign * 0.07, s * (0.11 - 0.008 * i))}, color=(0.98, 0.96, 0.9)) for i in range(teeth) for s in (-1, 1)]
        return transform_shape(concat_shapes(plates, *pegs), rotation_matrix(math.radians(0.5 * sign * jaw), (0, 0, 1), (0, 0, 0)))
    sockets = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.06}, color=(0.15, 0.12, 0.1)), translation_matrix((0.22, 0.13, s * 0.12))) for s in (-1, 1)]
    return concat_shapes(wedge(1), wedge(-1), *sockets)


@register()
def barrier(posts: int = 6, a: float = 6.8, b: float = 2.6) -> Shape:
    ring = [(a * math.cos(2 * math.pi * i / posts), b * math.sin(2 * math.pi * i / posts)) for i in range(posts)]
    out = []
    for (x0, z0), (x1, z1) in zip(ring, ring[1:] + ring[:1]):
        out += [primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (x0, 0, z0), 'p1': (x0, h, z0)}, color=(0.85, 0.68, 0.3)) for r, h in ((0.18, 0.04), (0.04, 0.95))]
        rope = [(x0 + (x1 - x0) * t, 0.9 - 1.2 * t * (1 - t), z0 + (z1 - z0) * t) for t in np.linspace(0, 1, 9)]
        out += [primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': p, 'p1': q}, color=(0.6, 0.08, 0.12)) for p, q in zip(rope, rope[1:])]
    return concat_shapes(*out)


@register()
def museum_hall() -> Shape:
    d = SPINE.tangent(0.99)
    head = transform_shape(library_call('skull'), translation_matrix(SPINE(1.0)) @ rotation_matrix(math.atan2(-d[2], d[0]), (0, 1, 0), (0, 0, 0)))
    hips = [(-1.1, 2.3, 0.4), (-1.1, 2.3, -0.4), (0.9, 2.1, 0.35), (0.9, 2.1, -0.35)]
    legs = [library_call('leg', hip=h, stride=s) for h, s in zip(hips, (0.35, -0.25, -0.2, 0.3))]
    supports = [primitive_call('cylinder', shape_kwargs={'radius': 0.035, 'p0': (float(SPINE(t)[0]), 0, float(SPINE(t)[2])), 'p1': tuple(SPINE(t))}, color=(0.15, 0.15, 0.16)) for t in (0.2, 0.5, 0.78)]
    dais = transform_shape(primitive_call('cube', shape_kwargs={'scale': (12.5, 0.2, 4)}, color=(0.3, 0.22, 0.16)), translation_matrix((-0.8, -0.1, 0)))
    return concat_shapes(dais, library_call('backbone'), library_call('ribs'), *legs, head, *supports, library_call('barrier'))
