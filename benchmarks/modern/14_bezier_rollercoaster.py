"""a roller coaster with a closed track on wooden supports and a train of three cars"""
from helper import *
import numpy as np
from typing import Iterator

CONTROL = np.array([
    [-6, 1.5, -3], [-2, 5.0, -4], [3, 1.2, -3.5], [6, 3.0, 0],
    [4, 1.0, 3.5], [0, 2.5, 2.0], [-4, 1.0, 4.0], [-7, 1.2, 1.0],
], dtype=float)


def catmull_to_bezier(pts: np.ndarray) -> Iterator[np.ndarray]:
    n = len(pts)
    for i in range(n):
        p0, p1, p2, p3 = pts[np.arange(i - 1, i + 3) % n]
        yield np.stack([p1, p1 + (p2 - p0) / 6, p2 - (p3 - p1) / 6, p2])


def bezier(ctrl: np.ndarray, t: np.ndarray) -> np.ndarray:
    t = t[:, None]
    basis = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t ** 2 * (1 - t), t ** 3])
    return basis @ ctrl


def track_points(per_segment: int = 8) -> np.ndarray:
    t = np.linspace(0, 1, per_segment, endpoint=False)
    return np.concatenate([bezier(c, t) for c in catmull_to_bezier(CONTROL)])


PTS = track_points()
TANGENT = np.roll(PTS, -1, axis=0) - np.roll(PTS, 1, axis=0)
TANGENT /= np.linalg.norm(TANGENT, axis=1, keepdims=True)
SIDE = np.cross(TANGENT, [0, 1, 0])
SIDE /= np.linalg.norm(SIDE, axis=-1, keepdims=True)


@register()
def rails(gauge: float = 0.4) -> Shape:
    out = []
    for s in (-1, 1):
        line = PTS + s * gauge / 2 * SIDE
        for a, b in zip(line, np.roll(line, -1, axis=0)):
            out.append(primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': a, 'p1': b}, color=(0.8, 0.15, 0.15)))
    ties = [primitive_call('cylinder', shape_kwargs={'radius': 0.035, 'p0': p - s * gauge * 0.6, 'p1': p + s * gauge * 0.6}, color=(0.3, 0.3, 0.3))
            for p, s in zip(PTS, SIDE)]
    return concat_shapes(*out, *ties)


@register()
def supports(every: int = 4) -> Shape:
    return concat_shapes(*[
        primitive_call('cylinder', shape_kwargs={'radius': 0.07, 'p0': (x, 0, z), 'p1': (x, y, z)}, color=(0.55, 0.4, 0.25))
        for x, y, z in PTS[::every]
    ])


@register()
def car(index: int, color=(0.2, 0.4, 0.9)) -> Shape:
    i = index % len(PTS)
    up = np.cross(SIDE[i], TANGENT[i])
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2], pose[:3, 3] = SIDE[i], up, -TANGENT[i], PTS[i] + 0.2 * up
    body = primitive_call('cube', shape_kwargs={'scale': (0.5, 0.3, 0.8)}, color=color)
    head = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.12}, color=(0.95, 0.8, 0.65)), translation_matrix((0, 0.3, 0)))
    return transform_shape(concat_shapes(body, head), pose)


@register()
def roller_coaster() -> Shape:
    ground = transform_shape(primitive_call('cube', shape_kwargs={'scale': (18, 0.1, 12)}, color=(0.4, 0.65, 0.35)), translation_matrix((0, -0.05, 0)))
    cars = [library_call('car', index=10 + 2 * k, color=c) for k, c in enumerate([(0.2, 0.4, 0.9), (0.9, 0.7, 0.1), (0.2, 0.7, 0.3)])]
    return concat_shapes(ground, library_call('rails'), library_call('supports'), *cars)
