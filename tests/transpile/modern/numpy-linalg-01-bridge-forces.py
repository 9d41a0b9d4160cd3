import numpy as np
from helper import *

"""
a beam bridge: loads are solved with a linear system and drawn as arrows
"""


def reactions(loads: np.ndarray, xs: np.ndarray, span: float) -> np.ndarray:
    """Support forces left and right from equilibrium."""
    a = np.array([[1.0, 1.0], [0.0, span]])
    b = np.array([loads.sum(), (loads * xs).sum()])
    return np.linalg.solve(a, b)


def stiffness(n: int) -> np.ndarray:
    return 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)


@register()
def arrow(force: float, up: bool) -> Shape:
    length = 0.2 + 0.3 * abs(force)
    color = (0.2, 0.7, 0.3) if up else (0.8, 0.2, 0.2)
    shaft = primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.04, 'p0': (0, 0.15, 0), 'p1': (0, length, 0)})
    tip = transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.15, 0.15, 0.15)}), translation_matrix((0, 0.1, 0)) @ rotation_matrix(np.pi / 4, (0, 0, 1), (0, 0, 0)))
    whole = concat_shapes(shaft, tip)
    return whole if not up else transform_shape(whole, reflection_matrix((0, 0, 0), (0, 1, 0)))


@register()
def bridge(span: float = 8.0) -> Shape:
    xs = np.linspace(0, span, 9)[1:-1]
    loads = np.array([1.0, 0.5, 2.0, 1.5, 0.5, 1.0, 3.0])
    left, right = reactions(loads, xs, span)
    k = stiffness(len(xs))
    sag = np.linalg.inv(k) @ loads
    assert np.allclose(np.linalg.solve(k, loads), sag)
    sag = -sag / np.abs(sag).max()
    knots = np.column_stack([np.r_[0, xs, span], np.r_[0, sag, 0], np.zeros(len(xs) + 2)])
    deck = [primitive_call('cylinder', color=(0.5, 0.5, 0.55), shape_kwargs={'radius': 0.1, 'p0': a, 'p1': b}) for a, b in zip(knots[:-1], knots[1:])]
    shapes = [transform_shape(library_call('arrow', force=f, up=False), translation_matrix(p + [0, 0.1, 0])) for f, p in zip(loads, knots[1:-1])]
    for x, r in ((0, left), (span, right)):
        shapes.append(transform_shape(library_call('arrow', force=r, up=True), translation_matrix((x, -0.1, 0))))
    values, vectors = np.linalg.eigh(k)
    for m in range(3):
        mode = vectors[:, m] * np.sign(vectors[0, m])
        dots = [transform_shape(primitive_call('sphere', color=(0.2, 0.4, 0.2 + 0.3 * m), shape_kwargs={'radius': 0.05 + 0.03 * values[m]}), translation_matrix((x, 2 + m + 0.5 * v, -1))) for x, v in zip(xs, mode)]
        shapes += dots
    det = np.linalg.det(k)
    rank = np.linalg.matrix_rank(k)
    tower = primitive_call('cube', color=(0.3, 0.3, 0.3), shape_kwargs={'scale': (0.3, det / 2, 0.1 * rank)})
    return concat_shapes(*deck, *shapes, transform_shape(tower, translation_matrix((-1, 0, 0))))
