"""a playground with a swing set, a slide and a seesaw, from a small scene graph"""
from __future__ import annotations
from helper import *
from dataclasses import dataclass, field
from functools import singledispatch
import numpy as np


@dataclass
class Node:
    pose: np.ndarray = field(default_factory=identity_matrix, kw_only=True)
    children: list[Node] = field(default_factory=list, kw_only=True)

    def add(self, *nodes: Node) -> Node:
        self.children.extend(nodes)
        return self


@dataclass
class Box(Node):
    size: tuple
    color: tuple


@dataclass
class Rod(Node):
    a: tuple
    b: tuple
    radius: float = 0.05
    color: tuple = (0.3, 0.5, 0.8)


@singledispatch
def emit(node) -> Shape:
    raise TypeError(f"cannot emit {type(node).__name__}")


@emit.register(Box)
def _(node):
    return primitive_call('cube', shape_kwargs={'scale': node.size}, color=node.color)


@emit.register(Rod)
def _(node):
    return primitive_call('cylinder', shape_kwargs={'radius': node.radius, 'p0': node.a, 'p1': node.b}, color=node.color)


@emit.register(Node)
def _(node):
    return []


def render(node: Node) -> Shape:
    own = emit(node)
    kids = [render(c) for c in node.children]
    return transform_shape(concat_shapes(own, *kids), node.pose)


def move(x=0.0, y=0.0, z=0.0):
    return translation_matrix((x, y, z))


@register()
def swing_set(width: float = 3.0, height: float = 2.2, angles: tuple = (20, -15)) -> Shape:
    root = Node()
    for s in (-1, 1):
        root.add(Rod((s * width / 2, height, 0), (s * width / 2, 0, 0.8)), Rod((s * width / 2, height, 0), (s * width / 2, 0, -0.8)))
    root.add(Rod((-width / 2, height, 0), (width / 2, height, 0), 0.06))
    for i, deg in enumerate(angles):
        x = -width / 4 + i * width / 2
        swing = Node(pose=move(x, height) @ rotation_matrix(np.radians(deg), (1, 0, 0), (0, 0, 0)))
        swing.add(Rod((-0.2, 0, 0), (-0.2, -1.6, 0), 0.015, (0.5, 0.5, 0.5)), Rod((0.2, 0, 0), (0.2, -1.6, 0), 0.015, (0.5, 0.5, 0.5)),
                  Box((0.5, 0.05, 0.25), (0.85, 0.3, 0.1), pose=move(y=-1.6)))
        root.add(swing)
    return render(root)


@register()
def slide(height: float = 1.8, run: float = 2.5) -> Shape:
    length, tilt = np.hypot(height, run), np.arctan2(height, run)
    chute = Box((length, 0.05, 0.6), (0.95, 0.8, 0.1), pose=move(run / 2, height / 2) @ rotation_matrix(-tilt, (0, 0, 1), (0, 0, 0)))
    chute.add(*(Box((length, 0.2, 0.05), (0.9, 0.2, 0.2), pose=move(0, 0.1, s * 0.3)) for s in (-1, 1)))
    ladder = Node().add(*(Rod((-0.1, h, -0.3), (-0.1, h, 0.3), 0.025) for h in np.arange(0.3, height, 0.3)))
    rails = [Rod((-0.1, 0, z), (-0.1, height + 0.5, z), 0.04) for z in (-0.3, 0.3)]
    return render(Node().add(chute, ladder, *rails))


@register()
def seesaw(tilt_deg: float = 14) -> Shape:
    plank = Box((3, 0.08, 0.35), (0.2, 0.6, 0.35), pose=move(y=0.6) @ rotation_matrix(np.radians(tilt_deg), (0, 0, 1), (0, 0, 0)))
    for s in (-1, 1):
        plank.add(Rod((s * 1.2, 0, 0), (s * 1.2, 0.35, 0), 0.03), Rod((s * 1.2, 0.35, -0.15), (s * 1.2, 0.35, 0.15), 0.03))
    return render(Node().add(plank, Rod((0, 0, -0.3), (0, 0.6, 0), 0.06), Rod((0, 0, 0.3), (0, 0.6, 0), 0.06)))


@register()
def playground() -> Shape:
    ground = render(Box((10, 0.1, 8), (0.55, 0.75, 0.4), pose=move(y=-0.05)))
    placed = {'swing_set': (-2.5, 0, -2), 'slide': (1, 0, -1.5), 'seesaw': (0, 0, 2)}
    return concat_shapes(ground, *[transform_shape(library_call(n), translation_matrix(p)) for n, p in placed.items()])
