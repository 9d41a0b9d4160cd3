"""a balanced hanging mobile of origami cranes above a baby crib"""
from __future__ import annotations

from helper import *
from copy import deepcopy
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias
import math

Vec: TypeAlias = tuple[float, float, float]


@dataclass
class Crane:
    weight: int = 1
    color: Vec = (0.9, 0.4, 0.4)
    string: float = 0.5


@dataclass
class Rod:
    left: Node
    right: Node
    length: Fraction = Fraction(1)
    string: float = 0.4
    turn: float = field(default=0.0, compare=False)

    @property
    def weight(self) -> int:
        return self.left.weight + self.right.weight

    @property
    def pivot(self) -> Fraction:
        """The balance point from the left end, exactly."""
        return self.length * Fraction(self.right.weight, self.weight)

    def check(self) -> bool:
        torque = self.left.weight * self.pivot - self.right.weight * (self.length - self.pivot)
        return torque == 0


Node: TypeAlias = Crane | Rod


def depth(node: Node) -> int:
    return 0 if isinstance(node, Crane) else 1 + max(depth(node.left), depth(node.right))


def build_tree(colors: list[Vec], length: Fraction = Fraction(8, 5), level: int = 0) -> Node:
    """Split the colours in the ratio 1:2 until one is left."""
    if len(colors) == 1:
        return Crane(weight=1 + level % 2, color=colors[0], string=0.35 + 0.1 * level)
    cut = max(1, len(colors) // 3)
    return Rod(build_tree(colors[:cut], length * Fraction(3, 5), level + 1), build_tree(colors[cut:], length * Fraction(3, 4), level + 1), length, turn=0.9 * (level + 1))


@register()
def crane(color: Vec = (0.9, 0.4, 0.4), size: float = 0.18, wing_angle: float = 35.0) -> Shape:
    pale = tuple(min(1.0, c + 0.12) for c in color)
    body = transform_shape(primitive_call('cube', shape_kwargs={'scale': (size * 0.5, size * 0.5, size * 0.5)}, color=color), rotation_matrix(math.pi / 4, (0, 0, 1), (0, 0, 0)))
    wing = transform_shape(primitive_call('cube', shape_kwargs={'scale': (size * 0.6, size * 0.04, size)}, color=pale), translation_matrix((0, 0, size * 0.5)))
    wings = [transform_shape(transform_shape(wing, rotation_matrix(-math.radians(wing_angle), (1, 0, 0), (0, 0, 0))), rotation_matrix(k * math.pi, (0, 1, 0), (0, 0, 0))) for k in range(2)]
    neck = primitive_call('cylinder', shape_kwargs={'radius': size * 0.06, 'p0': (size * 0.25, 0, 0), 'p1': (size * 0.7, size * 0.6, 0)}, color=color)
    beak = primitive_call('cylinder', shape_kwargs={'radius': size * 0.04, 'p0': (size * 0.7, size * 0.6, 0), 'p1': (size * 0.9, size * 0.45, 0)}, color=pale)
    tail = primitive_call('cylinder', shape_kwargs={'radius': size * 0.06, 'p0': (-size * 0.25, 0, 0), 'p1': (-size * 0.8, size * 0.55, 0)}, color=color)
    return concat_shapes(body, *wings, neck, beak, tail)


def hang(node: Node) -> Shape:
    """The node below the origin."""
    string = primitive_call('cylinder', shape_kwargs={'radius': 0.004, 'p0': (0, 0, 0), 'p1': (0, -node.string, 0)}, color=(0.95, 0.95, 0.95))
    drop = translation_matrix((0, -node.string, 0))
    match node:
        case Crane(weight=w, color=c):
            below = library_call('crane', color=c, size=0.13 + 0.04 * w)
        case Rod(left=left, right=right, turn=turn) as rod:
            a, b = -float(rod.pivot), float(rod.length - rod.pivot)
            stick = primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': (a, 0, 0), 'p1': (b, 0, 0)}, color=(0.75, 0.58, 0.38))
            arms = [transform_shape(hang(child), translation_matrix((x, 0, 0))) for child, x in ((left, a), (right, b))]
            below = transform_shape(concat_shapes(stick, *arms), rotation_matrix(turn, (0, 1, 0), (0, 0, 0)))
    return concat_shapes(string, transform_shape(below, drop))


@register()
def mobile(cranes: int = 7, swap: bool = False) -> Shape:
    hues = [i / cranes for i in range(cranes)]
    colors = [tuple(0.6 + 0.35 * math.cos(2 * math.pi * (h + s)) for s in (0, 1 / 3, 2 / 3)) for h in hues]
    tree = build_tree(colors)
    if swap and isinstance(tree, Rod):
        mirrored = deepcopy(tree)
        mirrored.left, mirrored.right = mirrored.right, mirrored.left
        tree = mirrored
    assert isinstance(tree, Crane) or tree.check()
    return hang(tree)


@register()
def crib(width: float = 1.4, depth: float = 0.8, bars: int = 12) -> Shape:
    white = (0.97, 0.96, 0.93)
    mattress = transform_shape(primitive_call('cube', shape_kwargs={'scale': (width, 0.12, depth)}, color=(0.75, 0.85, 0.95)), translation_matrix((0, 0.4, 0)))
    def side(z: float) -> Shape:
        spindles = loop(bars, lambda i: primitive_call('cylinder', shape_kwargs={'radius': 0.015, 'p0': (-width / 2 + width * i / (bars - 1), 0.3, z), 'p1': (-width / 2 + width * i / (bars - 1), 0.95, z)}, color=white))
        rails = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (width + 0.06, 0.05, 0.05)}, color=white), translation_matrix((0, y, z))) for y in (0.3, 0.95)]
        return concat_shapes(spindles, *rails)
    ends = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.05, 1.1, depth)}, color=white), translation_matrix((s * (width / 2 + 0.03), 0.55, 0))) for s in (-1, 1)]
    return concat_shapes(mattress, side(-depth / 2), side(depth / 2), *ends)


@register()
def nursery() -> Shape:
    hanging = transform_shape(library_call('mobile'), translation_matrix((0, 3.4, 0)))
    rug = primitive_call('cylinder', shape_kwargs={'radius': 1.5, 'p0': (0, -0.03, 0), 'p1': (0, 0, 0)}, color=(0.95, 0.85, 0.7))
    return concat_shapes(rug, library_call('crib'), hanging)
