"""
a robot mannequin doing a handstand-like pose, built as a hierarchy of joints
"""
from __future__ import annotations
from helper import *
import math
from dataclasses import dataclass, field
from typing import Iterator
import numpy as np


@dataclass
class Joint:
    name: str
    offset: tuple[float, float, float]
    thickness: float = 0.08
    angles: dict[str, float] = field(default_factory=dict)
    children: list[Joint] = field(default_factory=list)

    AXES = {'x': (1, 0, 0), 'y': (0, 1, 0), 'z': (0, 0, 1)}

    def add(self, *kids: Joint) -> Joint:
        self.children.extend(kids)
        return self

    def __truediv__(self, name: str) -> Joint:
        for node in self.walk():
            if node.name == name:
                return node
        raise LookupError(name)

    def walk(self) -> Iterator[Joint]:
        yield self
        for c in self.children:
            yield from c.walk()

    @property
    def local(self) -> np.ndarray:
        m = translation_matrix(self.offset)
        for axis, deg in self.angles.items():
            m = m @ rotation_matrix(math.radians(deg), self.AXES[axis], (0, 0, 0))
        return m

    def world(self, parent: np.ndarray | None = None) -> Iterator[tuple[Joint, np.ndarray, np.ndarray]]:
        parent = np.eye(4) if parent is None else parent
        here = parent @ self.local
        yield self, parent[:3, 3], here[:3, 3]
        for c in self.children:
            yield from c.world(here)


def limb(side: int, kind: str) -> Joint:
    s = 'LR'[side > 0]
    if kind == 'arm':
        return Joint(f'{s}shoulder', (0.3 * side, 0.05, 0)).add(
            Joint(f'{s}elbow', (0.1 * side, -0.5, 0), 0.07).add(Joint(f'{s}wrist', (0, -0.45, 0), 0.05)))
    return Joint(f'{s}hip', (0.17 * side, -0.05, 0), 0.1).add(
        Joint(f'{s}knee', (0, -0.65, 0), 0.09).add(
            Joint(f'{s}ankle', (0, -0.6, 0), 0.06).add(Joint(f'{s}toe', (0, -0.05, 0.22), 0.05))))


def mannequin() -> Joint:
    torso = Joint('chest', (0, 0.6, 0), 0.16).add(
        Joint('neck', (0, 0.2, 0), 0.06).add(Joint('head', (0, 0.25, 0), 0.05)), *(limb(s, 'arm') for s in (-1, 1)))
    return Joint('pelvis', (0, 0, 0), 0.15).add(torso, *(limb(s, 'leg') for s in (-1, 1)))


POSES = {
    'handstand': 'Lshoulder z -170; Rshoulder z 170; Lhip x 12; Rhip x -25; Rknee x 50; neck x -20',
    'wave': 'Rshoulder z 150; Relbow z -40; Lshoulder z -15; Lhip z -5; Rhip z 5',
}


def apply_pose(root: Joint, text: str) -> Joint:
    for command in filter(None, map(str.strip, text.split(';'))):
        name, axis, deg = command.split()
        (root / name).angles[axis] = float(deg)
    return root


@register()
def joint_ball(radius: float = 0.09, color: tuple = (0.95, 0.6, 0.15)) -> Shape:
    return primitive_call('sphere', {'radius': radius}, color=color)


@register()
def figure(pose: str = 'wave', shell: tuple = (0.85, 0.87, 0.9)) -> Shape:
    root = apply_pose(mannequin(), POSES[pose])
    parts: list[Shape] = []
    for joint, start, end in root.world():
        parts.append(transform_shape(library_call('joint_ball', radius=joint.thickness * 1.15), translation_matrix(end)))
        if np.linalg.norm(end - start) > 1e-6:
            parts.append(primitive_call('cylinder', {'radius': joint.thickness, 'p0': start, 'p1': end}, color=shell))
        if joint.name == 'head':
            parts.append(transform_shape(library_call('joint_ball', radius=0.2, color=shell), translation_matrix(end)))
    return concat_shapes(*parts)


@register()
def mat(width: float = 3.0, stripes: int = 5) -> Shape:
    return loop(stripes, lambda i: transform_shape(
        primitive_call('cube', {'scale': (width / stripes, 0.08, 1.6)}, color=(0.2, 0.35 + 0.1 * (i % 2), 0.6)),
        translation_matrix(((i + 0.5) * width / stripes - width / 2, -0.04, 0))))


@register()
def gymnasts() -> Shape:
    flip = rotation_matrix(math.pi, (0, 0, 1), (0, 0, 0))
    upside = transform_shape(library_call('figure', pose='handstand', shell=(0.75, 0.8, 0.95)), flip)
    upright = library_call('figure', pose='wave')
    stand = lambda s, x: transform_shape(s, translation_matrix((x, -compute_shape_min(s)[1], 0)))
    mats = [transform_shape(library_call('mat'), translation_matrix((x, 0, 0))) for x in (-1.8, 1.8)]
    return concat_shapes(*mats, stand(upside, -1.8), stand(upright, 1.8))
