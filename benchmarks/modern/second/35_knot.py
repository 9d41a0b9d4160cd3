"""
a trefoil knot of rope and a torus knot (2,5) on two stands
"""
from helper import *
import numpy as np
from dataclasses import dataclass
from math import gcd, tau


@dataclass(frozen=True)
class TorusKnot:
    p: int
    q: int
    major: float = 1.0
    minor: float = 0.4

    def __post_init__(self):
        if gcd(self.p, self.q) != 1:
            raise ValueError(f'({self.p}, {self.q}) is a link, not a knot')

    def __call__(self, t: np.ndarray) -> np.ndarray:
        r = self.major + self.minor * np.cos(self.q * t)
        return np.stack([r * np.cos(self.p * t), r * np.sin(self.p * t), self.minor * np.sin(self.q * t)], axis=-1)

    def frames(self, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        t = np.linspace(0, tau, n, endpoint=False)
        pts = self(t)
        tangent = np.roll(pts, -1, axis=0) - np.roll(pts, 1, axis=0)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        core = np.stack([np.cos(self.p * t), np.sin(self.p * t), 0 * t], axis=-1) * self.major
        normal = pts - core
        normal -= np.einsum('ij,ij->i', normal, tangent)[:, None] * tangent
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        return pts, normal, np.cross(tangent, normal)


@register()
def strand(points: np.ndarray, radius: float = 0.05, color: tuple = (0.8, 0.7, 0.5)) -> Shape:
    nxt = np.roll(points, -1, axis=0)
    return loop(len(points), lambda i: primitive_call('cylinder', {'radius': radius, 'p0': points[i], 'p1': nxt[i]}, color=color))


@register()
def rope_knot(p: int = 2, q: int = 3, n: int = 90, strands: int = 3, twist: int = 12, thickness: float = 0.12) -> Shape:
    pts, normal, binormal = TorusKnot(p, q).frames(n)
    phase = np.linspace(0, tau * twist, n, endpoint=False)
    shapes = []
    for s in range(strands):
        a = (phase + tau * s / strands)[:, None]
        shapes.append(library_call('strand', points=pts + thickness * 0.55 * (np.cos(a) * normal + np.sin(a) * binormal),
                                   radius=thickness * 0.6, color=(0.78 - 0.1 * s, 0.64 - 0.08 * s, 0.42)))
    return concat_shapes(*shapes)


@register()
def stand(height: float = 1.0, width: float = 1.2) -> Shape:
    profile = np.interp(np.linspace(0, 1, 7), [0, 0.2, 0.8, 1], [1.0, 0.55, 0.55, 0.8]) * width / 2
    h = height / len(profile)
    return concat_shapes(*[primitive_call('cylinder', {'radius': r, 'p0': (0, k * h, 0), 'p1': (0, (k + 1) * h, 0)}, color=(0.85, 0.84, 0.82))
                           for k, r in enumerate(profile)])


@register()
def knot_gallery() -> Shape:
    out = []
    for i, (p, q) in enumerate([(2, 3), (2, 5)]):
        knot = library_call('rope_knot', p=p, q=q)
        base = library_call('stand')
        lift = compute_shape_max(base)[1] - compute_shape_min(knot)[1]
        exhibit = base + transform_shape(knot, translation_matrix([0, lift, 0]))
        out += transform_shape(exhibit, translation_matrix([3.6 * i - 1.8, 0, 0]))
    return out
