from enum import Enum
import numpy as np
from helper import *

"""
umbrellas in the rain
"""


class Fabric(Enum):
    PLAIN = 0
    STRIPED = 1
    DOTTED = 2

    @classmethod
    def pick(cls) -> "Fabric":
        return cls(int(np.random.randint(len(cls))))


@register()
def umbrella(color: tuple, ribs: int = 8) -> Shape:
    fabric = Fabric.pick()
    second = tuple(1 - c * 0.5 for c in color)
    panels = []
    for i in range(ribs):
        tint = second if fabric is Fabric.STRIPED and i % 2 else color
        panel = transform_shape(primitive_call('cube', color=tint, shape_kwargs={'scale': (0.7, 0.02, 0.45)}), rotation_matrix(-0.4, (0, 0, 1), (0, 0, 0)))
        panel = transform_shape(panel, translation_matrix((0.35, 2.0, 0)))
        panels.append(transform_shape(panel, rotation_matrix(2 * np.pi * i / ribs, (0, 1, 0), (0, 0, 0))))
    if fabric is Fabric.DOTTED:
        for x, z in np.random.uniform(-0.4, 0.4, (5, 2)):
            panels.append(transform_shape(primitive_call('sphere', color=second, shape_kwargs={'radius': 0.06}), translation_matrix((x, 2.1 - 0.4 * np.hypot(x, z), z))))
    stick = primitive_call('cylinder', color=(0.3, 0.2, 0.1), shape_kwargs={'radius': 0.03, 'p0': (0, 0.8, 0), 'p1': (0, 2.2, 0)})
    return concat_shapes(stick, *panels)


@register()
def rain(n: int, size: float) -> Shape:
    tops = np.random.uniform([-size, 2.5, -size], [size, 5, size], size=(n, 3))
    lengths = np.random.gamma(2.0, 0.1, n)
    slant = np.array([0.1, -1.0, 0.0])
    bottoms = tops + slant * lengths[:, None]
    return concat_shapes(*[primitive_call('cylinder', color=(0.6, 0.7, 0.85), shape_kwargs={'radius': 0.01, 'p0': a, 'p1': b}) for a, b in zip(tops, bottoms)])


@register()
def rainy_square() -> Shape:
    np.random.seed(4)
    colors = np.random.rand(6, 3)
    colors[::2] = colors[::2] * 0.5 + 0.5
    spots = np.stack(np.meshgrid(np.arange(3), np.arange(2)), axis=-1).reshape(-1, 2) * 2.0
    spots += np.random.uniform(-0.3, 0.3, spots.shape)
    np.random.shuffle(spots)
    people = [transform_shape(library_call('umbrella', color=tuple(c)), translation_matrix((x - 2, 0, z - 1))) for c, (x, z) in zip(colors, spots)]
    puddles = [primitive_call('cylinder', color=(0.4, 0.45, 0.55), shape_kwargs={'radius': r, 'p0': (x, 0, z), 'p1': (x, 0.02, z)}) for r, x, z in np.random.random_sample((5, 3)) * [0.5, 4, 2] + [0.1, -2, -1]]
    return concat_shapes(library_call('rain', n=90, size=3.0), *people, *puddles)
