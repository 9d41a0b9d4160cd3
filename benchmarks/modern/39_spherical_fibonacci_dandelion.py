"""a dandelion clock losing its seeds in the wind"""
from helper import *
import numpy as np


def fibonacci_sphere(n: int) -> np.ndarray:
    i = np.arange(n) + 0.5
    phi = np.arccos(1 - 2 * i / n)
    theta = np.pi * (1 + 5 ** 0.5) * i
    return np.stack([np.cos(theta) * np.sin(phi), np.cos(phi), np.sin(theta) * np.sin(phi)], axis=1)


def align_y_to(direction: np.ndarray) -> np.ndarray:
    """4x4 rotation sending +y to direction."""
    d = direction / np.linalg.norm(direction)
    axis = np.cross([0, 1, 0], d)
    if (s := np.linalg.norm(axis)) < 1e-8:
        return identity_matrix() if d[1] > 0 else rotation_matrix(np.pi, (1, 0, 0), (0, 0, 0))
    return rotation_matrix(np.arctan2(s, d[1]), axis / s, (0, 0, 0))


@register()
def seed(length: float = 0.6, filaments: int = 6) -> Shape:
    stalk = primitive_call('cylinder', shape_kwargs={'radius': 0.008, 'p0': (0, 0.1, 0), 'p1': (0, length, 0)}, color=(0.85, 0.85, 0.8))
    achene = primitive_call('cylinder', shape_kwargs={'radius': 0.018, 'p0': (0, 0.04, 0), 'p1': (0, 0.12, 0)}, color=(0.4, 0.28, 0.15))
    a = np.linspace(0, 2 * np.pi, filaments, endpoint=False)
    tips = np.c_[0.14 * np.cos(a), np.full(filaments, length + 0.1), 0.14 * np.sin(a)]
    fluff = [primitive_call('cylinder', shape_kwargs={'radius': 0.004, 'p0': (0, length, 0), 'p1': t}, color=(1, 1, 1)) for t in tips]
    return concat_shapes(stalk, achene, *fluff)


@register()
def seed_ball(n: int = 60, wind=(1.0, 0.3, 0.0)) -> Shape:
    wind = np.array(wind) / np.linalg.norm(wind)
    rng = np.random.default_rng(12)
    out = [primitive_call('sphere', shape_kwargs={'radius': 0.12}, color=(0.6, 0.65, 0.4))]
    for d in fibonacci_sphere(n):
        shape = transform_shape(library_call('seed'), align_y_to(d))
        if d @ wind > 0.75:  # blown away
            shape = transform_shape(shape, translation_matrix(wind * rng.uniform(0.6, 2.5) + rng.normal(0, 0.2, 3)))
        out.append(shape)
    return concat_shapes(*out)


@register()
def dandelion(height: float = 2.2) -> Shape:
    pts = np.array([[0.1 * np.sin(t * 2), height * t, 0] for t in np.linspace(0, 1, 9)])
    stem = concat_shapes(*(primitive_call('cylinder', shape_kwargs={'radius': 0.035, 'p0': p, 'p1': q}, color=(0.45, 0.6, 0.3)) for p, q in zip(pts, pts[1:])))
    return concat_shapes(stem, transform_shape(library_call('seed_ball'), translation_matrix(pts[-1])))
