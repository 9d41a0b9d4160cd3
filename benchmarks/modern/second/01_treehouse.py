"""
a treehouse in an old oak tree with a rope ladder
"""
from helper import *
import math
import random
from dataclasses import dataclass, field
from typing import Iterator

import numpy as np

BARK = (0.36, 0.25, 0.16)
LEAF = (0.22, 0.48, 0.18)
PLANK = (0.66, 0.48, 0.30)


@dataclass(frozen=True)
class Branch:
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float
    depth: int

    @property
    def direction(self) -> np.ndarray:
        d = np.subtract(self.end, self.start)
        return d / np.linalg.norm(d)

    @property
    def length(self) -> float:
        return float(np.linalg.norm(np.subtract(self.end, self.start)))


@dataclass
class OakGrower:
    seed: int = 7
    spread: float = 0.6
    shrink: float = 0.74
    max_depth: int = 4
    rng: random.Random = field(init=False, repr=False)

    def __post_init__(self):
        self.rng = random.Random(self.seed)

    def grow(self, trunk: Branch) -> Iterator[Branch]:
        yield trunk
        if trunk.depth >= self.max_depth:
            return
        n = 3 if trunk.depth < 2 else 2
        twist = self.rng.uniform(0, 2 * math.pi)
        for k in range(n):
            az = twist + 2 * math.pi * k / n
            side = np.array([math.cos(az), 0.0, math.sin(az)])
            d = trunk.direction * math.cos(self.spread) + side * math.sin(self.spread)
            d /= np.linalg.norm(d)
            length = trunk.length * self.shrink * self.rng.uniform(0.85, 1.1)
            end = tuple(np.asarray(trunk.end) + d * length)
            yield from self.grow(Branch(trunk.end, end, trunk.radius * 0.62, trunk.depth + 1))


@register()
def oak(seed: int = 7, trunk_height: float = 3.0) -> Shape:
    grower = OakGrower(seed=seed)
    root = Branch((0, 0, 0), (0, trunk_height, 0), 0.45, 0)
    shapes = []
    for b in grower.grow(root):
        shapes.append(primitive_call('cylinder', {'radius': b.radius, 'p0': b.start, 'p1': b.end}, color=BARK))
        if b.depth == grower.max_depth:
            blob = primitive_call('sphere', {'radius': 0.45 + 0.2 * grower.rng.random()}, color=LEAF)
            shapes.append(transform_shape(blob, translation_matrix(b.end)))
    return concat_shapes(*shapes)


@register()
def rope_ladder(height: float = 2.9, width: float = 0.5, rungs: int = 8) -> Shape:
    ropes = concat_shapes(*[
        primitive_call('cylinder', {'radius': 0.02, 'p0': (x, 0, 0), 'p1': (x, height, 0)}, color=(0.8, 0.7, 0.5))
        for x in (-width / 2, width / 2)
    ])
    steps = loop(rungs, lambda i: primitive_call(
        'cylinder',
        {'radius': 0.03,
         'p0': (-width / 2, (i + 0.5) * height / rungs, 0),
         'p1': (width / 2, (i + 0.5) * height / rungs, 0)},
        color=PLANK))
    return concat_shapes(ropes, steps)


@register()
def cabin(size: float = 1.8, height: float = 1.3) -> Shape:
    floor = primitive_call('cube', {'scale': (size * 1.4, 0.1, size * 1.4)}, color=PLANK)
    walls = []
    for i in range(4):
        wall = transform_shape(primitive_call('cube', {'scale': (size, height, 0.08)}, color=(0.72, 0.54, 0.35)),
                               translation_matrix((0, height / 2, size / 2)))
        if i != 0:
            walls.append(transform_shape(wall, rotation_matrix(i * math.pi / 2, (0, 1, 0), (0, 0, 0))))
    roof = []
    for sgn in (-1, 1):
        slab = primitive_call('cube', {'scale': (size * 0.8, 0.07, size * 1.2)}, color=(0.55, 0.2, 0.15))
        slab = transform_shape(slab, rotation_matrix(-sgn * 0.6, (0, 0, 1), (0, 0, 0)))
        roof.append(transform_shape(slab, translation_matrix((sgn * size * 0.3, height + 0.35, 0))))
    return concat_shapes(floor, *walls, *roof)


@register()
def treehouse_scene() -> Shape:
    tree = library_call('oak', seed=11, trunk_height=3.0)
    house = transform_shape(library_call('cabin'), translation_matrix((0.2, 3.0, 0.3)))
    ladder = library_call('rope_ladder')
    lo, hi = compute_shape_min(house), compute_shape_max(house)
    ladder = transform_shape(ladder, translation_matrix(((lo[0] + hi[0]) / 2, 0, hi[2] - 0.05)))
    ground = transform_shape(primitive_call('cylinder', {'radius': 5, 'p0': (0, -0.2, 0), 'p1': (0, 0, 0)},
                                            color=(0.4, 0.6, 0.3)), identity_matrix())
    return concat_shapes(ground, tree, house, ladder)
