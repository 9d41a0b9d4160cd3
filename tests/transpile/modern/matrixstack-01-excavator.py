from __future__ import annotations
import numpy as np
from helper import *

"""
an excavator from a scene graph with nested poses
"""


class Node:
    def __init__(self, name: str, shape: Shape | None = None, pose: np.ndarray | None = None):
        self.name = name
        self.shape = shape
        self.pose = np.eye(4) if pose is None else pose
        self.children: list[Node] = []
        self.parent: Node | None = None

    def attach(self, *children: Node) -> Node:
        for child in children:
            child.parent = self
            self.children.append(child)
        return self

    @property
    def world(self) -> np.ndarray:
        return self.pose if self.parent is None else self.parent.world @ self.pose

    def walk(self, depth: int = 0):
        yield depth, self
        for child in self.children:
            yield from child.walk(depth + 1)

    def find(self, name: str) -> Node:
        return next(node for _, node in self.walk() if node.name == name)

    def rotate(self, degrees: float, axis=(0, 0, 1)) -> None:
        self.pose = self.pose @ rotation_matrix(np.radians(degrees), axis, (0, 0, 0))

    def render(self) -> Shape:
        return concat_shapes(*(transform_shape(node.shape, node.world) for _, node in self.walk() if node.shape is not None))


YELLOW, BLACK = (0.95, 0.75, 0.1), (0.15, 0.15, 0.15)


def beam(length: float, width: float) -> Shape:
    """A beam along +x from the origin."""
    return transform_shape(primitive_call('cube', color=YELLOW, shape_kwargs={'scale': (length, width, width)}), translation_matrix((length / 2, 0, 0)))


@register()
def tracks() -> Shape:
    pads = []
    for side in (-1, 1):
        pads.append(transform_shape(primitive_call('cube', color=BLACK, shape_kwargs={'scale': (3, 0.5, 0.5)}), translation_matrix((0, 0.25, 0.9 * side))))
        pads += [primitive_call('cylinder', color=(0.4, 0.4, 0.4), shape_kwargs={'radius': 0.22, 'p0': (x, 0.25, 0.9 * side - 0.3), 'p1': (x, 0.25, 0.9 * side + 0.3)}) for x in np.linspace(-1.3, 1.3, 4)]
    return concat_shapes(*pads)


@register()
def excavator(swing: float, boom: float, stick: float, bucket: float) -> Shape:
    root = Node("tracks", library_call('tracks'))
    house = Node("house", primitive_call('cube', color=YELLOW, shape_kwargs={'scale': (2.2, 1.0, 1.6)}), translation_matrix((0, 1.1, 0)))
    cab = Node("cab", primitive_call('cube', color=(0.6, 0.8, 0.9), shape_kwargs={'scale': (0.8, 1.0, 0.7)}), translation_matrix((0.6, 0.8, 0.5)))
    arm = Node("boom", beam(2.5, 0.3), translation_matrix((1.0, 0.2, -0.3)))
    fore = Node("stick", beam(1.8, 0.22), translation_matrix((2.5, 0, 0)))
    shovel = Node("bucket", transform_shape(primitive_call('cube', color=BLACK, shape_kwargs={'scale': (0.6, 0.5, 0.8)}), translation_matrix((0.3, -0.2, 0))), translation_matrix((1.8, 0, 0)))
    root.attach(house.attach(cab, arm.attach(fore.attach(shovel))))
    for name, angle, axis in (("house", swing, (0, 1, 0)), ("boom", boom, (0, 0, 1)), ("stick", stick, (0, 0, 1)), ("bucket", bucket, (0, 0, 1))):
        root.find(name).rotate(angle, axis)
    tip = root.find("bucket").world @ np.array([0.6, -0.4, 0, 1])
    dirt = transform_shape(primitive_call('sphere', color=(0.4, 0.3, 0.2), shape_kwargs={'radius': 0.3}), translation_matrix(tip[:3]))
    depth = max(d for d, _ in root.walk())
    return concat_shapes(root.render(), *[dirt] * (depth - 3))


@register()
def building_site() -> Shape:
    poses = [(0, 45, -90, -60), (60, 30, -70, -100), (200, 60, -120, -30)]
    return concat_shapes(*[transform_shape(library_call('excavator', **dict(zip(("swing", "boom", "stick", "bucket"), p))), translation_matrix((8 * k, 0, 0))) for k, p in enumerate(poses)])
