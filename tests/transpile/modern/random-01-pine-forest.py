import random
from dataclasses import dataclass
from helper import *

"""
a pine forest on a slope
"""

random.seed(42)


@dataclass
class Pine:
    x: float
    z: float
    height: float
    tiers: int

    @classmethod
    def random(cls, area: float) -> "Pine":
        return cls(
            x=random.uniform(-area, area),
            z=random.uniform(-area, area),
            height=max(0.8, random.gauss(1.6, 0.3)),
            tiers=random.randint(2, 4),
        )

    def too_close(self, others: list, distance: float = 0.7) -> bool:
        return any((self.x - o.x) ** 2 + (self.z - o.z) ** 2 < distance ** 2 for o in others)


@register()
def pine(height: float, tiers: int) -> Shape:
    trunk = primitive_call('cylinder', color=(0.4, 0.27, 0.15), shape_kwargs={'radius': 0.07, 'p0': (0, 0, 0), 'p1': (0, height * 0.4, 0)})
    green = random.choice([(0.1, 0.35, 0.15), (0.12, 0.42, 0.2), (0.08, 0.3, 0.18)])
    layers = loop(tiers, lambda i: primitive_call('cylinder', color=green, shape_kwargs={
        'radius': 0.4 * (1 - i / (tiers + 1)),
        'p0': (0, height * (0.3 + 0.7 * i / tiers), 0),
        'p1': (0, height * (0.3 + 0.7 * (i + 0.6) / tiers), 0),
    }))
    return concat_shapes(trunk, layers)


@register()
def forest(n: int = 25, area: float = 4.0) -> Shape:
    trees: list[Pine] = []
    attempts = 0
    while len(trees) < n and attempts < 200:
        attempts += 1
        candidate = Pine.random(area)
        if not candidate.too_close(trees):
            trees.append(candidate)
    shapes = [transform_shape(library_call('pine', height=t.height, tiers=t.tiers), translation_matrix((t.x, 0.1 * t.x, t.z))) for t in trees]
    ground = transform_shape(primitive_call('cube', color=(0.35, 0.4, 0.25), shape_kwargs={'scale': (2.4 * area, 0.1, 2.4 * area)}), rotation_matrix(0.1, (0, 0, 1), (0, 0, 0)))
    return concat_shapes(ground, *shapes)
