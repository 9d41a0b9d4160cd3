import numpy as np
from helper import *

"""
autumn: a bare tree with fallen leaves around it
"""

AUTUMN = np.array([(0.85, 0.3, 0.1), (0.9, 0.6, 0.1), (0.6, 0.2, 0.1), (0.75, 0.5, 0.2)])


class LeafSampler:
    """Draws leaf poses; the wind moves them in +x."""

    def __init__(self, n: int, wind: float = 0.5):
        self.n = n
        self.wind = wind

    def __iter__(self):
        radii = np.abs(np.random.normal(1.2, 0.6, self.n))
        angles = np.random.uniform(0, 2 * np.pi, self.n)
        for r, a in zip(radii, angles):
            drift = np.random.rand() * self.wind
            yield np.array([r * np.cos(a) + drift, 0.02, r * np.sin(a)])


@register()
def leaf() -> Shape:
    color = AUTUMN[np.random.choice(len(AUTUMN))] * np.random.uniform(0.8, 1.0)
    size = np.random.uniform(0.08, 0.16)
    blade = primitive_call('cube', color=tuple(color), shape_kwargs={'scale': (size, 0.01, size * 0.6)})
    tilt = rotation_matrix(np.random.uniform(-0.4, 0.4), direction=(1, 0, 0), point=(0, 0, 0))
    turn = rotation_matrix(np.random.uniform(0, np.pi), direction=(0, 1, 0), point=(0, 0, 0))
    return transform_shape(blade, turn @ tilt)


@register()
def twig(start, direction, depth: int) -> Shape:
    start, direction = np.array(start, dtype=float), np.array(direction, dtype=float)
    end = start + direction
    parts = [primitive_call('cylinder', color=(0.35, 0.25, 0.2), shape_kwargs={'radius': 0.04 * (depth + 1) / 2, 'p0': start, 'p1': end})]
    if depth > 0:
        for _ in range(2):
            swing = direction * 0.75 + np.random.randn(3) * 0.25 * np.linalg.norm(direction)
            parts.append(library_call('twig', start=end, direction=swing, depth=depth - 1))
    return concat_shapes(*parts)


@register()
def autumn_tree() -> Shape:
    tree = library_call('twig', start=(0, 0, 0), direction=(0, 1, 0), depth=5)
    leaves = [transform_shape(library_call('leaf'), translation_matrix(p)) for p in LeafSampler(60)]
    pile = np.random.normal([3, 2], 0.3, size=(15, 2))
    heap = [transform_shape(library_call('leaf'), translation_matrix((x, 0.05 + 0.02 * k, z))) for k, (x, z) in enumerate(pile)]
    mushrooms = np.random.permutation(6)[:3]
    fungi = [transform_shape(primitive_call('sphere', color=(0.8, 0.1, 0.1), shape_kwargs={'radius': 0.1}), translation_matrix((m - 3, 0.1, 1.5))) for m in mushrooms]
    return concat_shapes(tree, *leaves, *heap, *fungi)
