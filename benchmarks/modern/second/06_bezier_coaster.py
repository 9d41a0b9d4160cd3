"""
a wooden roller coaster with a train of cars on a looping track
"""
from helper import *
import numpy as np
from itertools import islice, cycle, pairwise
from math import comb


class Bezier:
    """Composite-friendly Bezier curve of any degree."""

    def __init__(self, *control):
        self.ctrl = np.asarray(control, dtype=float)
        if self.ctrl.ndim != 2 or self.ctrl.shape[1] != 3:
            raise ValueError('control points must be 3d')

    @property
    def degree(self) -> int:
        return len(self.ctrl) - 1

    def __call__(self, t):
        t = np.atleast_1d(t)[:, None]
        n = self.degree
        basis = np.concatenate([comb(n, k) * t**k * (1 - t)**(n - k) for k in range(n + 1)], axis=1)
        return basis @ self.ctrl


def closed_spline(anchors: np.ndarray, per: int = 10) -> np.ndarray:
    m = len(anchors)
    tangents = (np.roll(anchors, -1, axis=0) - np.roll(anchors, 1, axis=0)) / 6
    pieces = []
    for i in range(m):
        j = (i + 1) % m
        curve = Bezier(anchors[i], anchors[i] + tangents[i], anchors[j] - tangents[j], anchors[j])
        pieces.append(curve(np.linspace(0, 1, per, endpoint=False)))
    return np.vstack(pieces)


ANCHORS = np.array([
    [-4, 1.0, 0], [-3, 3.2, 2], [0, 4.0, 3], [3, 1.0, 2.4],
    [4, 2.6, 0], [3, 0.8, -2], [0, 2.2, -3], [-3, 0.7, -2],
], dtype=float)

PATH = closed_spline(ANCHORS)


@register()
def rail(offset: float = 0.2, radius: float = 0.04, color: tuple = (0.8, 0.15, 0.12)) -> Shape:
    fwd = np.roll(PATH, -1, axis=0) - PATH
    side = np.cross(fwd, [0, 1, 0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    pts = PATH + side * offset
    ring = [*pts, pts[0]]
    return concat_shapes(*[primitive_call('cylinder', {'radius': radius, 'p0': a, 'p1': b}, color=color)
                           for a, b in pairwise(ring)])


@register()
def sleeper(i: int = 0, width: float = 0.6) -> Shape:
    p, q = PATH[i % len(PATH)], PATH[(i + 1) % len(PATH)]
    side = np.cross(q - p, (0, 1, 0))
    side = side / np.linalg.norm(side) * width / 2
    return primitive_call('cylinder', {'radius': 0.03, 'p0': p - side, 'p1': p + side}, color=(0.45, 0.32, 0.2))


@register()
def trestle(i: int = 0, splay: float = 0.25) -> Shape:
    x, y, z = PATH[i % len(PATH)]
    legs = [primitive_call('cylinder', {'radius': 0.05, 'p0': (x + s * splay, 0, z), 'p1': (x, y, z)}, color=(0.75, 0.68, 0.55))
            for s in (-1, 1)]
    if y > 1.5:
        legs.append(primitive_call('cube', {'scale': (splay * 1.2, 0.05, 0.05)}, color=(0.7, 0.62, 0.5)))
        legs[-1] = transform_shape(legs[-1], translation_matrix((x, y / 2, z)))
    return concat_shapes(*legs)


@register()
def coaster_car(index: int = 0, color: tuple = (0.1, 0.3, 0.8)) -> Shape:
    p, q = PATH[index % len(PATH)], PATH[(index + 1) % len(PATH)]
    d = q - p
    yaw = np.arctan2(-d[2], d[0])
    pitch = np.arctan2(d[1], np.hypot(d[0], d[2]))
    hull = transform_shape(primitive_call('cube', {'scale': (0.55, 0.25, 0.4)}, color=color), translation_matrix((0, 0.2, 0)))
    head = transform_shape(primitive_call('sphere', {'radius': 0.1}, color=(0.9, 0.75, 0.6)), translation_matrix((0, 0.45, 0)))
    car = concat_shapes(hull, head)
    car = transform_shape(car, rotation_matrix(pitch, (0, 0, 1), (0, 0, 0)))
    car = transform_shape(car, rotation_matrix(yaw, (0, 1, 0), (0, 0, 0)))
    return transform_shape(car, translation_matrix(p))


@register()
def roller_coaster(cars: int = 4) -> Shape:
    rails = [library_call('rail', offset=o) for o in (-0.2, 0.2)]
    ties = loop(len(PATH) // 2, lambda i: library_call('sleeper', i=2 * i))
    supports = loop(len(PATH) // 5, lambda i: library_call('trestle', i=5 * i))
    palette = islice(cycle([(0.1, 0.3, 0.8), (0.95, 0.8, 0.1)]), cars)
    train = [library_call('coaster_car', index=12 + 1 * k, color=c) for k, c in enumerate(palette)]
    field = primitive_call('cube', {'scale': (11, 0.1, 9)}, color=(0.45, 0.65, 0.4))
    return concat_shapes(field, *rails, ties, supports, *train)
