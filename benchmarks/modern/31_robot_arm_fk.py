"""an industrial robot arm reaching for a box, by forward kinematics"""
from helper import *
from itertools import accumulate
from typing import NamedTuple
import numpy as np


class Joint(NamedTuple):
    axis: str
    angle_deg: float
    length: float
    radius: float


CHAIN = [Joint('y', 30, 0.8, 0.25), Joint('z', -25, 1.4, 0.16), Joint('z', -60, 1.2, 0.12), Joint('z', -50, 0.5, 0.09)]
AXES = {'x': (1, 0, 0), 'y': (0, 1, 0), 'z': (0, 0, 1)}
ORANGE, GRAY = (0.95, 0.45, 0.1), (0.3, 0.3, 0.33)


def local(j: Joint) -> np.ndarray:
    return rotation_matrix(np.deg2rad(j.angle_deg), AXES[j.axis], (0, 0, 0)) @ translation_matrix((0, j.length, 0))


def frames(chain: list[Joint]) -> list[np.ndarray]:
    return list(accumulate((local(j) for j in chain), np.matmul, initial=identity_matrix()))


@register()
def link(length: float, radius: float) -> Shape:
    bone = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, length, 0)}, color=ORANGE)
    knuckle = primitive_call('cylinder', shape_kwargs={'radius': radius * 1.4, 'p0': (0, 0, -radius * 1.3), 'p1': (0, 0, radius * 1.3)}, color=GRAY)
    return concat_shapes(bone, knuckle)


@register()
def gripper(opening: float = 0.2) -> Shape:
    palm = primitive_call('cube', shape_kwargs={'scale': (0.4, 0.08, 0.2)}, color=GRAY)
    finger = primitive_call('cube', shape_kwargs={'scale': (0.05, 0.3, 0.12)}, color=(0.6, 0.6, 0.62))
    return concat_shapes(palm, *(transform_shape(finger, translation_matrix((s * (opening / 2 + 0.05), 0.18, 0))) for s in (-1, 1)))


@register()
def arm() -> Shape:
    out: Shape = []
    poses = frames(CHAIN)
    for joint, pose in zip(CHAIN, poses):
        turn = rotation_matrix(np.deg2rad(joint.angle_deg), AXES[joint.axis], (0, 0, 0))
        out = concat_shapes(out, transform_shape(library_call('link', length=joint.length, radius=joint.radius), pose @ turn))
    return concat_shapes(out, transform_shape(library_call('gripper'), poses[-1]))


@register()
def robot_cell() -> Shape:
    pedestal = primitive_call('cylinder', shape_kwargs={'radius': 0.5, 'p0': (0, -0.3, 0), 'p1': (0, 0, 0)}, color=GRAY)
    tip = frames(CHAIN)[-1] @ np.array([0, 0.4, 0, 1])
    crate = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.2, 0.2, 0.2)}, color=(0.65, 0.5, 0.3)), translation_matrix(tip[:3]))
    return concat_shapes(pedestal, library_call('arm'), crate)
