"""an anglepoise desk lamp with springs, on a desk with a coffee mug"""
from helper import *
import numpy as np


def make_cylinder_between(color):
    def between(a, b, r):
        a, b = np.asarray(a, float), np.asarray(b, float)
        return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': a.tolist(), 'p1': b.tolist()}, color=color)
    return between


steel = make_cylinder_between((0.7, 0.7, 0.72))
red = make_cylinder_between((0.8, 0.1, 0.1))


def lathe(profile, color):
    """Stack of discs from (y, r) pairs."""
    parts = []
    for (y0, r0), (y1, r1) in zip(profile, profile[1:]):
        parts.append(primitive_call('cylinder', shape_kwargs={'radius': (r0 + r1) / 2, 'p0': (0, y0, 0), 'p1': (0, y1, 0)}, color=color))
    return concat_shapes(*parts)


@register()
def spring(a, b, coils: int = 6, radius: float = 0.05, wire: float = 0.01) -> Shape:
    a, b = np.array(a, float), np.array(b, float)
    axis = (b - a) / np.linalg.norm(b - a)
    u = np.cross(axis, [0, 0, 1.0])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    t = np.linspace(0, 1, coils * 8 + 1)
    ang = 2 * np.pi * coils * t
    pts = a + t[:, None] * (b - a) + radius * (np.cos(ang)[:, None] * u + np.sin(ang)[:, None] * v)
    return concat_shapes(*(steel(p, q, wire) for p, q in zip(pts, pts[1:])))


@register()
def lamp(shoulder_deg: float = 65, elbow_deg: float = -70, arm: float = 1.0) -> Shape:
    base = lathe([(0, 0.4), (0.06, 0.4), (0.1, 0.1), (0.15, 0.08)], (0.8, 0.1, 0.1))
    p0 = np.array([0, 0.15, 0])
    a0 = np.radians(180 - shoulder_deg)
    p1 = p0 + arm * np.array([np.cos(a0), np.sin(a0), 0])
    a1 = a0 + np.radians(elbow_deg)
    p2 = p1 + arm * np.array([np.cos(a1), np.sin(a1), 0])
    joints = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.06}, color=(0.2, 0.2, 0.2)), translation_matrix(p)) for p in (p0, p1, p2)]
    springs = [library_call('spring', a=p0 + [0.08, 0, 0], b=p0 + 0.4 * (p1 - p0) + [0.08, 0, 0])]
    shade = lathe([(0, 0.08), (-0.1, 0.14), (-0.2, 0.2), (-0.3, 0.27)], (0.8, 0.1, 0.1))
    bulb = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=(1, 0.95, 0.7)), translation_matrix((0, -0.3, 0)))
    head = transform_shape(concat_shapes(shade, bulb), rotation_matrix(np.radians(25), (0, 0, 1), (0, 0, 0)))
    return concat_shapes(base, red(p0, p1, 0.03), red(p1, p2, 0.03), *joints, *springs, transform_shape(head, translation_matrix(p2)))


@register()
def mug(color=(0.2, 0.5, 0.6)) -> Shape:
    body = lathe([(0, 0.15), (0.32, 0.16)], color)
    coffee = lathe([(0.32, 0.14), (0.325, 0.14)], (0.25, 0.13, 0.06))
    a = np.linspace(-np.pi / 2, np.pi / 2, 9)
    ring = np.stack([0.14 + 0.1 * np.cos(a), 0.16 + 0.1 * np.sin(a), np.zeros_like(a)], axis=-1)
    make = make_cylinder_between(color)
    return concat_shapes(body, coffee, *[make(p, q, 0.025) for p, q in zip(ring[:-1], ring[1:])])


@register()
def desk_scene() -> Shape:
    top = transform_shape(primitive_call('cube', shape_kwargs={'scale': (3.5, 0.1, 1.8)}, color=(0.6, 0.43, 0.27)), translation_matrix((0, -0.05, 0)))
    return concat_shapes(top, library_call('lamp'), transform_shape(library_call('mug'), translation_matrix((1.0, 0, 0.4))))
