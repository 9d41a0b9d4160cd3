"""
a robot arm on a pedestal whose joints follow inverse kinematics
"""
from helper import *
import numpy as np
import math


class Joint:
    def __init__(self, name, length, axis='z', limits=(-math.pi, math.pi)):
        self.name = name
        self.length = length
        self.axis = {'x': (1, 0, 0), 'y': (0, 1, 0), 'z': (0, 0, 1)}[axis]
        self._limits = limits
        self._angle = 0.0

    @property
    def angle(self):
        return self._angle

    @angle.setter
    def angle(self, value):
        low, high = self._limits
        if not low <= high:
            raise ValueError(f'bad limits for {self.name}')
        self._angle = min(max(value, low), high)

    @property
    def local(self):
        return rotation_matrix(self._angle, self.axis, (0, 0, 0)) @ translation_matrix((self.length, 0, 0))


def solve(lengths, target, iterations=60):
    points = np.cumsum(np.concatenate([[0.0], lengths]))
    chain = np.stack([points, np.zeros_like(points)], axis=1)
    target = np.asarray(target, dtype=float)
    for _ in range(iterations):
        chain[-1] = target
        for i in range(len(lengths) - 1, -1, -1):
            d = chain[i] - chain[i + 1]
            chain[i] = chain[i + 1] + d / np.linalg.norm(d) * lengths[i]
        chain[0] = 0
        for i in range(len(lengths)):
            d = chain[i + 1] - chain[i]
            chain[i + 1] = chain[i] + d / np.linalg.norm(d) * lengths[i]
        if np.linalg.norm(chain[-1] - target) < 1e-6:
            break
    steps = np.diff(chain, axis=0)
    absolute = np.arctan2(steps[:, 1], steps[:, 0])
    return np.diff(np.concatenate([[0.0], absolute]))


@register()
def segment(length: float, thickness: float = 0.25) -> Shape:
    bar = transform_shape(primitive_call('cube', color=(0.9, 0.5, 0.1), shape_kwargs={'scale': (length, thickness, thickness)}), translation_matrix((length / 2, 0, 0)))
    knob = primitive_call('sphere', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': thickness * 0.8})
    return concat_shapes(bar, knob)


@register()
def arm(reach=(2.0, 1.5)) -> Shape:
    joints = [Joint('shoulder', 1.6), Joint('elbow', 1.2, limits=(-2.5, 2.5)), Joint('wrist', 0.6)]
    for joint, angle in zip(joints, solve(np.array([j.length for j in joints]), reach)):
        joint.angle = float(angle)
    pose = identity_matrix()
    shapes = []
    for joint in joints:
        turn = pose @ rotation_matrix(joint.angle, joint.axis, (0, 0, 0))
        shapes.append(transform_shape(library_call('segment', length=joint.length), turn))
        pose = pose @ joint.local
    shapes.append(transform_shape(primitive_call('cube', color=(0.1, 0.6, 0.2), shape_kwargs={'scale': 0.3}), pose))
    return concat_shapes(*shapes)


@register()
def workstation() -> Shape:
    pedestal = primitive_call('cylinder', color=(0.5, 0.5, 0.55), shape_kwargs={'radius': 0.6, 'p0': (0, -1, 0), 'p1': (0, 0, 0)})
    return concat_shapes(pedestal, library_call('arm'), transform_shape(library_call('arm', reach=(1.0, 2.4)), rotation_matrix(math.pi, (0, 1, 0), (0, 0, 0))))
