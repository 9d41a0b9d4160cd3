"""an industrial robot arm that moves a box from one conveyor to another, as an animation"""
from helper import *
import numpy as np
from numpy.typing import NDArray

ORANGE, GRAY, DARK = (0.95, 0.5, 0.1), (0.6, 0.62, 0.65), (0.18, 0.18, 0.2)
LINKS = np.array([1.4, 1.2, 0.5])
# base yaw, shoulder, elbow, wrist in degrees; is the box held?
KEYFRAMES = np.array([
    [-60, 35, 75, 70],
    [-60, 20, 55, 60],
    [20, 10, 50, 60],
    [70, 25, 70, 65],
    [70, 38, 80, 62],
], dtype=float)
HELD = (False, True, True, True, False)


def poses(keys: NDArray, between: int) -> NDArray:
    """Interpolate smoothly between rows."""
    rows = []
    for a, b in zip(keys[:-1], keys[1:]):
        for t in np.linspace(0, 1, between, endpoint=False):
            s = t * t * (3 - 2 * t)
            rows.append((1 - s) * a + s * b)
    rows.append(keys[-1])
    return np.vstack(rows)


def joints(shoulder: float, elbow: float, wrist: float) -> NDArray:
    """The positions of the joints in the xy plane; angles are from the vertical, added up."""
    bend = np.radians(np.cumsum([shoulder, elbow, wrist]))
    steps = np.stack([np.sin(bend) * LINKS, np.cos(bend) * LINKS, np.zeros(3)], axis=1)
    start = np.array([[0.0, 0.8, 0.0]])
    return np.concatenate([start, start + np.cumsum(steps, axis=0)])


def as_point(v) -> tuple[float, float, float]:
    return tuple(float(c) for c in v)


@register("a link with a ball joint at its beginning")
def link(a: tuple[float, float, float] = (0, 0, 0), b: tuple[float, float, float] = (0, 1, 0), radius: float = 0.16) -> Shape:
    joint = transform_shape(primitive_call('sphere', shape_kwargs={'radius': radius * 1.4}, color=DARK), translation_matrix(a))
    return concat_shapes(primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': a, 'p1': b}, color=ORANGE), joint)


@register("two fingers that point down; closed or open")
def gripper(closed: bool = False) -> Shape:
    gap = 0.2 if closed else 0.32
    palm = primitive_call('cube', shape_kwargs={'scale': (0.3, 0.1, 0.75)}, color=GRAY)
    fingers = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.1, 0.4, 0.06)}, color=GRAY), translation_matrix((0, -0.2, s * gap))) for s in (-1, 1)]
    return concat_shapes(palm, *fingers)


@register("the carton")
def carton(size: float = 0.36) -> Shape:
    body = primitive_call('cube', shape_kwargs={'scale': (size, size, size)}, color=(0.75, 0.58, 0.38))
    tape = primitive_call('cube', shape_kwargs={'scale': (size * 1.01, size * 1.01, 0.06)}, color=(0.9, 0.82, 0.6))
    return concat_shapes(body, tape)


@register("the whole robot in one pose")
def robot(yaw: float = 0.0, shoulder: float = 20.0, elbow: float = 60.0, wrist: float = 60.0, held: bool = False) -> Shape:
    points = joints(shoulder, elbow, wrist)
    parts = [library_call('link', a=as_point(p), b=as_point(q), radius=0.17 - 0.03 * k) for k, (p, q) in enumerate(zip(points, points[1:]))]
    tip = points[-1]
    parts.append(transform_shape(library_call('gripper', closed=held), translation_matrix(as_point(tip))))
    if held:
        parts.append(transform_shape(library_call('carton'), translation_matrix(as_point(tip - [0, 0.3, 0]))))
    turned = transform_shape(concat_shapes(*parts), rotation_matrix(float(np.deg2rad(yaw)), (0, 1, 0), (0, 0, 0)))
    base = [primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, lo, 0), 'p1': (0, hi, 0)}, color=c)
            for r, lo, hi, c in ((0.55, 0.0, 0.12, DARK), (0.38, 0.12, 0.45, ORANGE), (0.28, 0.45, 0.75, GRAY))]
    return concat_shapes(*base, turned)


@register("a conveyor along z with rollers")
def conveyor(length: float = 3.0, rollers: int = 12, height: float = 0.5) -> Shape:
    zs = np.linspace(-length / 2, length / 2, rollers)
    shapes = [primitive_call('cylinder', shape_kwargs={'radius': 0.09, 'p0': (-0.4, height, float(z)), 'p1': (0.4, height, float(z))}, color=GRAY) for z in zs]
    rails = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.08, 0.2, length + 0.3)}, color=DARK), translation_matrix((s * 0.45, height, 0))) for s in (-1, 1)]
    return concat_shapes(*shapes, *rails)


@register_animation()
def moving_box(between: int = 3) -> list[Shape]:
    frames = []
    for number, (yaw, *angles) in enumerate(poses(KEYFRAMES, between).tolist()):
        held = HELD[number // between]
        shoulder, elbow, wrist = angles
        belts = [transform_shape(library_call('conveyor'), translation_matrix((1.6, 0, z))) for z in (-2.2, 2.2)]
        frames.append(concat_shapes(library_call('robot', yaw=yaw, shoulder=shoulder, elbow=elbow, wrist=wrist, held=held), *belts))
    return frames
