import numpy as np
from helper import *

"""
a truss dome: distances, normals and moments with einsum, cross and outer
"""


def icosahedron() -> np.ndarray:
    phi = (1 + np.sqrt(5)) / 2
    base = np.array([[0, s, t * phi] for s in (-1, 1) for t in (-1, 1)], dtype=float)
    return np.concatenate([np.roll(base, k, axis=1) for k in range(3)])


def edges(points: np.ndarray) -> np.ndarray:
    gram = np.einsum("ik,jk->ij", points, points)
    squared = np.diag(gram)[:, None] + np.diag(gram) - 2 * gram
    return np.argwhere(np.triu(np.isclose(squared, 4.0), k=1))


def inertia(points: np.ndarray) -> np.ndarray:
    r2 = np.einsum("ij,ij->i", points, points)
    return r2.sum() * np.eye(3) - np.einsum("ij,ik->jk", points, points)


@register()
def node(position: np.ndarray, radius: float) -> Shape:
    return transform_shape(primitive_call('sphere', color=(0.8, 0.8, 0.85), shape_kwargs={'radius': radius}), translation_matrix(position))


@register()
def strut(a: np.ndarray, b: np.ndarray) -> Shape:
    along = (b - a) / np.linalg.norm(b - a)
    tint = np.abs(along) @ np.array([[0.9, 0.2, 0.2], [0.2, 0.8, 0.3], [0.2, 0.3, 0.9]])
    return primitive_call('cylinder', color=tuple(np.minimum(tint, 1)), shape_kwargs={'radius': 0.05, 'p0': a, 'p1': b})


@register()
def dome() -> Shape:
    points = icosahedron()
    pairs = edges(points)
    moments = inertia(points)
    assert np.allclose(moments, moments.T) and len(pairs) == 30
    scale = np.trace(moments) / 3 / 100
    shapes = [library_call('node', position=p, radius=0.1 + 0.2 * scale) for p in points]
    shapes += [library_call('strut', a=points[i], b=points[j]) for i, j in pairs]
    # a spike along the normal of some faces
    near = {int(i): sorted(int(j) for a, b in pairs for j in (a, b) if i in (a, b) and j != i) for i in range(12)}
    for i, neighbors in list(near.items())[:6]:
        j = neighbors[0]
        k = next(n for n in neighbors[1:] if n in near[j])
        normal = np.cross(points[j] - points[i], points[k] - points[i])
        center = np.mean([points[i], points[j], points[k]], axis=0)
        normal *= np.sign(np.dot(normal, center)) / np.linalg.norm(normal)
        shapes.append(primitive_call('cylinder', color=(0.9, 0.7, 0.2), shape_kwargs={'radius': 0.03, 'p0': center, 'p1': center + 0.6 * normal}))
    table = np.outer([1, 2, 3], [0.1, 0.2])
    shapes += [transform_shape(primitive_call('cube', color=(0.4, 0.4, 0.4), shape_kwargs={'scale': (0.4, v, 0.4)}), translation_matrix((i - 1, -2.5 + v / 2, j))) for (i, j), v in np.ndenumerate(table)]
    return concat_shapes(*shapes)
