import numpy as np
from helper import *

"""
a planetarium dome
"""

np.random.seed(99)
CLASSES = ["O", "A", "G", "K", "M"]
COLORS = {"O": (0.6, 0.7, 1.0), "A": (0.9, 0.95, 1.0), "G": (1.0, 0.95, 0.7), "K": (1.0, 0.75, 0.5), "M": (1.0, 0.5, 0.4)}


def on_dome(n: int, radius: float) -> np.ndarray:
    """n points on the upper half of a sphere."""
    v = np.random.normal(size=(n, 3))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    v[:, 1] = np.abs(v[:, 1])
    return v * radius


@register()
def star(kind: str, magnitude: float) -> Shape:
    return primitive_call('sphere', color=COLORS[kind], shape_kwargs={'radius': 0.03 + 0.02 * magnitude})


@register()
def stars(n: int, radius: float) -> Shape:
    points = on_dome(n, radius)
    kinds = np.random.choice(CLASSES, size=n, p=[0.05, 0.15, 0.2, 0.25, 0.35])
    magnitudes = np.clip(np.random.exponential(1.0, n), 0, 4)
    return concat_shapes(*[transform_shape(library_call('star', kind=str(k), magnitude=m), translation_matrix(p)) for p, k, m in zip(points, kinds, magnitudes)])


@register()
def constellation(center, links: int) -> Shape:
    center = np.asarray(center)
    offsets = np.random.uniform(-0.5, 0.5, size=(links + 1, 3))
    offsets = offsets - offsets.mean(axis=0)
    points = center + offsets
    lines = [primitive_call('cylinder', color=(0.4, 0.5, 0.8), shape_kwargs={'radius': 0.015, 'p0': points[i], 'p1': points[i + 1]}) for i in range(links)]
    knots = [transform_shape(library_call('star', kind='A', magnitude=1.5), translation_matrix(p)) for p in points]
    return concat_shapes(*lines, *knots)


@register()
def planetarium() -> Shape:
    centers = on_dome(3, 3.0)
    seats = []
    for row in range(2):
        n = np.random.randint(5, 9)
        angles = np.sort(np.random.rand(n)) * np.pi
        for a in angles:
            seat = primitive_call('cube', color=(0.5, 0.1, 0.15), shape_kwargs={'scale': (0.25, 0.3, 0.25)})
            seats.append(transform_shape(seat, translation_matrix(((1 + row) * np.cos(a), 0.15, (1 + row) * np.sin(a)))))
    floor = primitive_call('cylinder', color=(0.15, 0.15, 0.2), shape_kwargs={'radius': 4.2, 'p0': (0, -0.1, 0), 'p1': (0, 0, 0)})
    return concat_shapes(floor, *seats, library_call('stars', n=80, radius=4.0), *[library_call('constellation', center=c, links=int(k)) for c, k in zip(centers, np.random.randint(3, 6, size=3))])
