"""a yellow excavator digging a pile of gravel at a construction site"""
from __future__ import annotations

from helper import *
from dataclasses import dataclass, field
from typing import Iterator
import math
import numpy as np
import random

YELLOW, STEEL, RUBBER = (0.96, 0.72, 0.08), (0.35, 0.36, 0.38), (0.1, 0.1, 0.11)


class Pose:
    """A rigid motion; `@` chains poses and also moves shapes and points."""

    def __init__(self, matrix=None):
        self.m = np.eye(4) if matrix is None else np.asarray(matrix, dtype=float)

    @classmethod
    def move(cls, x=0.0, y=0.0, z=0.0) -> Pose:
        return cls(translation_matrix((x, y, z)))

    @classmethod
    def turn(cls, degrees: float, axis: str = 'z') -> Pose:
        direction = {'x': (1, 0, 0), 'y': (0, 1, 0), 'z': (0, 0, 1)}[axis]
        return cls(rotation_matrix(math.radians(degrees), direction, (0, 0, 0)))

    def __matmul__(self, other):
        if isinstance(other, Pose):
            return Pose(self.m @ other.m)
        if isinstance(other, np.ndarray) and other.shape == (3,):
            return (self.m @ np.append(other, 1.0))[:3]
        return transform_shape(other, self.m)


@dataclass
class Link:
    name: str
    length: float
    angle: float = 0.0
    children: list[Link] = field(default_factory=list)

    def walk(self, base: Pose | None = None) -> Iterator[tuple[Link, Pose]]:
        here = (base or Pose()) @ Pose.turn(self.angle)
        yield self, here
        for child in self.children:
            yield from child.walk(here @ Pose.move(self.length))

    def __rshift__(self, child: Link) -> Link:
        """a >> b hangs b on the end of a and gives b, so that chains read from left to right."""
        self.children.append(child)
        return child


def two_link_ik(x: float, y: float, a: float, b: float) -> tuple[float, float]:
    """Angles in degrees that bring the end of two links to (x, y), elbow up; out of reach it stretches."""
    d = min(math.hypot(x, y), a + b - 1e-6)
    elbow = math.acos(max(-1.0, min(1.0, (d * d - a * a - b * b) / (2 * a * b))))
    shoulder = math.atan2(y, x) + math.atan2(b * math.sin(elbow), a + b * math.cos(elbow))
    return math.degrees(shoulder), -math.degrees(elbow)


def box(w, h, d, color=YELLOW):
    return primitive_call('cube', shape_kwargs={'scale': (w, h, d)}, color=color)


def rod(a, b, r, color=STEEL):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': tuple(map(float, a)), 'p1': tuple(map(float, b))}, color=color)


@register()
def track(length: float = 2.6, radius: float = 0.32, width: float = 0.4, pads: int = 34) -> Shape:
    straight = length - 2 * radius
    perimeter = 2 * straight + 2 * math.pi * radius
    out = []
    for i in range(pads):
        s = perimeter * i / pads
        if s < straight:
            pose = Pose.move(-straight / 2 + s, radius)
        elif (s := s - straight) < math.pi * radius:
            pose = Pose.move(straight / 2) @ Pose.turn(-math.degrees(s / radius)) @ Pose.move(0, radius)
        elif (s := s - math.pi * radius) < straight:
            pose = Pose.move(straight / 2 - s, -radius) @ Pose.turn(180)
        else:
            pose = Pose.move(-straight / 2) @ Pose.turn(180 - math.degrees((s - straight) / radius)) @ Pose.move(0, radius)
        out.append(pose @ box(perimeter / pads * 0.9, 0.07, width, RUBBER))
    rollers = [rod((x, 0, -width / 2), (x, 0, width / 2), radius * 0.8) for x in np.linspace(-straight / 2, straight / 2, 5)]
    return concat_shapes(*out, *rollers)


@register()
def bucket(size: float = 0.6, teeth: int = 5, load: int = 6) -> Shape:
    shell = [Pose.turn(-30 * i) @ Pose.move(size * 0.5) @ box(0.05, size * 0.32, size, STEEL) for i in range(-2, 4)]
    spikes = loop(teeth, lambda i: Pose.turn(75) @ Pose.move(size * 0.5, 0.05, (i / (teeth - 1) - 0.5) * size * 0.9) @ box(0.05, 0.16, 0.06, (0.6, 0.6, 0.62)))
    rnd = random.Random(load)
    stones = [Pose.move(rnd.uniform(-0.1, 0.3) * size, rnd.uniform(-0.2, 0.2) * size, rnd.uniform(-0.4, 0.4) * size) @ primitive_call('sphere', shape_kwargs={'radius': 0.09}, color=(0.5, 0.45, 0.4)) for _ in range(load)]
    return concat_shapes(*shell, spikes, *stones)


@register()
def arm(reach: float = 3.0, lift: float = -0.4, curl: float = -60.0) -> Shape:
    boom_len, stick_len = 2.2, 1.6
    shoulder, elbow = two_link_ik(reach, lift, boom_len, stick_len)
    boom = Link('boom', boom_len, shoulder)
    boom >> Link('stick', stick_len, elbow) >> Link('bucket', 0.3, curl)
    parts, joints = [], {}
    for link, pose in boom.walk():
        joints[link.name] = pose
        if link.name == 'bucket':
            parts.append(pose @ Pose.move(0.25) @ library_call('bucket'))
            continue
        thick = 0.32 if link.name == 'boom' else 0.24
        parts.append(pose @ Pose.move(link.length / 2) @ box(link.length, thick, 0.26))
        parts.append(pose @ rod((0, 0, -0.2), (0, 0, 0.2), 0.12))
    # hydraulic pistons between points on neighbouring links
    for a, u, b, v in (('boom', (1.2, 0.25, 0), 'stick', (0.1, 0.25, 0)), ('stick', (0.3, 0.22, 0), 'bucket', (0.1, 0.1, 0))):
        p, q = joints[a] @ np.array(u), joints[b] @ np.array(v)
        parts += [rod(p, p + 0.6 * (q - p), 0.07, YELLOW), rod(p, q, 0.04, (0.8, 0.8, 0.83))]
    return concat_shapes(*parts)


@register()
def excavator(swing: float = 20.0, reach: float = 3.0) -> Shape:
    tracks = [Pose.move(0, 0.36, s * 0.75) @ library_call('track') for s in (-1, 1)]
    cab = concat_shapes(
        Pose.move(0, 0.2) @ box(1.9, 0.5, 1.5), Pose.move(-0.85, 0.5) @ box(0.5, 0.55, 1.4, STEEL), Pose.move(0.35, 0.85, 0.45) @ box(0.9, 0.9, 0.6),
        Pose.move(0.4, 0.95, 0.45) @ box(0.85, 0.5, 0.62, (0.6, 0.8, 0.88)), rod((-0.7, 0.8, -0.4), (-0.7, 1.3, -0.4), 0.06))
    arm_shape = Pose.move(0.9, 0.4, -0.1) @ library_call('arm', reach=reach)
    upper = Pose.move(0, 0.85) @ Pose.turn(swing, 'y') @ concat_shapes(cab, arm_shape, rod((0, -0.2, 0), (0, 0, 0), 0.55))
    return concat_shapes(*tracks, upper)


@register()
def gravel(stones: int = 90, radius: float = 1.1, seed: int = 13) -> Shape:
    rng = np.random.default_rng(seed)
    r = radius * np.sqrt(rng.random(stones))
    a = rng.random(stones) * 2 * np.pi
    heights = np.maximum(0, (radius - r) * 0.7) * rng.random(stones)
    sizes = rng.uniform(0.06, 0.16, stones)
    return concat_shapes(*(Pose.move(x, y + s / 2, z) @ Pose.turn(t, 'y') @ box(s, s, s, (g, g * 0.95, g * 0.88)) for x, y, z, s, t, g in zip(r * np.cos(a), heights, r * np.sin(a), sizes, rng.uniform(0, 90, stones), rng.uniform(0.4, 0.6, stones))))


@register()
def construction_site() -> Shape:
    ground = Pose.move(1.2, -0.05) @ box(10, 0.1, 7, (0.62, 0.52, 0.38))
    cones = loop(5, lambda i: Pose.move(-2.5 + 1.6 * i, 0, 2.6) @ concat_shapes(*(rod((0, 0.12 * k, 0), (0, 0.12 * (k + 1), 0), 0.16 - 0.035 * k, (1, 1, 1) if k == 2 else (0.95, 0.4, 0.1)) for k in range(4))))
    heap = Pose.move(3.7, 0, -1.2) @ library_call('gravel')
    return concat_shapes(ground, library_call('excavator'), heap, cones)
