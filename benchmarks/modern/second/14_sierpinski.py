"""
a Sierpinski pyramid glowing on a pedestal
"""
from helper import *
import math
from collections.abc import Iterable
from typing import TypeVar
import numpy as np

T_ = TypeVar('T_')

VERTS = np.array([
    [1, 0, -1 / math.sqrt(2)],
    [-1, 0, -1 / math.sqrt(2)],
    [0, 1, 1 / math.sqrt(2)],
    [0, -1, 1 / math.sqrt(2)],
])


def upright_tetrahedron() -> np.ndarray:
    base = [(math.cos(a), 0, math.sin(a)) for a in (math.tau * k / 3 for k in range(3))]
    return np.array([*base, (0, math.sqrt(2), 0)])


def corners(tet: np.ndarray, depth: int):
    if depth == 0:
        yield tet
        return
    for v in tet:
        yield from corners((tet + v) / 2, depth - 1)


def flatten(nested: Iterable[Iterable[T_]]) -> list[T_]:
    return [x for inner in nested for x in inner]


def gradient(y: float, stops=((0.0, (0.9, 0.2, 0.4)), (0.5, (0.95, 0.6, 0.2)), (1.0, (0.98, 0.95, 0.5)))):
    for (a, ca), (b, cb) in zip(stops, stops[1:]):
        if a <= y <= b:
            t = (y - a) / (b - a)
            return tuple(p + (q - p) * t for p, q in zip(ca, cb, strict=True))
    return stops[-1][1]


@register()
def tetra_frame(points: np.ndarray | None = None, radius: float = 0.02, color: tuple = (1.0, 0.8, 0.3)) -> Shape:
    pts = upright_tetrahedron() if points is None else np.asarray(points)
    edges = [(i, j) for i in range(4) for j in range(i + 1, 4)]
    return concat_shapes(*[primitive_call('cylinder', {'radius': radius, 'p0': pts[i], 'p1': pts[j]}, color=color) for i, j in edges])


@register()
def sierpinski(depth: int = 3, size: float = 2.0) -> Shape:
    tet = upright_tetrahedron() * size
    top = tet[:, 1].max()
    radius = size * 0.02 * 0.7 ** depth
    pieces = []
    for small in corners(tet, depth):
        mid = small.mean(axis=0)
        pieces.append(library_call('tetra_frame', points=small, radius=radius, color=gradient(mid[1] / top)))
    assert len(pieces) == 4 ** depth
    return flatten(pieces)


@register()
def pedestal(sides: int = 3, steps: int = 4, width: float = 4.4) -> Shape:
    def step(i: int) -> Shape:
        shade = 0.25 + 0.1 * i
        w = width * (1 - 0.08 * i)
        return primitive_call('cylinder', {'radius': w / 2, 'p0': (0, 0.15 * i, 0), 'p1': (0, 0.15 * (i + 1), 0)}, color=(shade,) * 3)
    return loop(steps, step)


@register()
def glow_ring(n: int = 9, radius: float = 2.6) -> Shape:
    angles = np.linspace(0, math.tau, n, endpoint=False)
    pts = np.stack([radius * np.cos(angles), np.full(n, 0.2), radius * np.sin(angles)], axis=1)
    lamp = primitive_call('sphere', {'radius': 0.12}, color=(1, 0.95, 0.7))
    return flatten(transform_shape(lamp, translation_matrix(p)) for p in pts)


@register()
def glowing_pyramid() -> Shape:
    base = library_call('pedestal')
    y = compute_shape_max(base)[1]
    fractal = transform_shape(library_call('sierpinski', depth=3, size=2.0), translation_matrix((0, float(y), 0)))
    return concat_shapes(base, library_call('glow_ring'), fractal)
