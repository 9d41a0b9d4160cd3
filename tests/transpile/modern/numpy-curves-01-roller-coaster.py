from dataclasses import dataclass
import numpy as np
from helper import *

"""
a roller coaster with a track from sampled splines
"""


@dataclass
class Track:
    knots: np.ndarray

    def sample(self, per_segment: int = 6) -> np.ndarray:
        """A closed Catmull-Rom spline."""
        p0, p1, p2, p3 = (np.roll(self.knots, shift, axis=0) for shift in (1, 0, -1, -2))
        t = np.linspace(0, 1, per_segment, endpoint=False)[:, None, None]
        points = 0.5 * (2 * p1 + (p2 - p0) * t + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t ** 2 + (-p0 + 3 * p1 - 3 * p2 + p3) * t ** 3)
        return points.transpose(1, 0, 2).reshape(-1, 3)


def frames(points: np.ndarray):
    tangent = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    side = np.cross(tangent, np.array([0.0, 1.0, 0.0]))
    side /= np.linalg.norm(side, axis=-1)[..., np.newaxis]
    return tangent, side


@register()
def rail(points: np.ndarray, color: tuple) -> Shape:
    following = np.roll(points, -1, axis=0)
    return concat_shapes(*[primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.04, 'p0': a, 'p1': b}) for a, b in zip(points, following)])


@register()
def car(color: tuple) -> Shape:
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.5, 0.3, 0.35)}), translation_matrix((0, 0.2, 0)))


@register()
def coaster() -> Shape:
    angles = np.arange(8) * 2 * np.pi / 8
    knots = np.c_[4 * np.cos(angles), 1.5 + np.array([0, 1.5, 2.5, 0.5, -0.5, 1, 0, -0.8]), 2.5 * np.sin(angles)]
    points = Track(knots).sample()
    tangent, side = frames(points)
    shapes = [library_call('rail', points=points + s * 0.15 * side, color=(0.8, 0.2, 0.2)) for s in (-1, 1)]
    for p in points[::3]:
        shapes.append(primitive_call('cylinder', color=(0.6, 0.6, 0.65), shape_kwargs={'radius': 0.05, 'p0': (p[0], -0.5, p[2]), 'p1': p}))
    arc = np.cumsum(np.linalg.norm(np.diff(points, axis=0, append=points[:1]), axis=1))
    targets = arc[-1] * np.array([0.1, 0.14, 0.18, 0.6])
    for k, i in enumerate(np.searchsorted(arc, targets)):
        pose = np.eye(4)
        pose[:3, 0] = tangent[i]
        pose[:3, 1] = np.cross(side[i], tangent[i])
        pose[:3, 2] = side[i]
        pose[:3, 3] = points[i]
        shapes.append(transform_shape(library_call('car', color=(0.2 * k, 0.5, 0.8)), pose))
    top = points[np.argmax(points[:, 1])]
    flag = primitive_call('cylinder', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': 0.05, 'p0': top, 'p1': top + np.array([0, 1.0, 0])})
    return concat_shapes(*shapes, flag)
