"""a kinetic Lissajous knot sculpture on a marble plinth"""
from helper import *
import numpy as np
from math import gcd


class Curve:
    """A parametric closed curve: subclasses implement __call__ on arrays of t in [0, 1)."""

    def __call__(self, t: np.ndarray) -> np.ndarray:
        raise NotImplementedError

    def sample(self, n: int) -> np.ndarray:
        return self(np.arange(n) / n)

    def __matmul__(self, m: np.ndarray) -> 'Transformed':
        return Transformed(self, m)


class Lissajous(Curve):
    def __init__(self, nx: int, ny: int, nz: int, phases=(0.7, 0.2, 0.0)):
        if any(gcd(a, b) != 1 for a, b in ((nx, ny), (ny, nz), (nx, nz))):
            raise ValueError("frequencies must be pairwise coprime")
        self.freq = np.array([nx, ny, nz])
        self.phases = np.array(phases)

    def __call__(self, t):
        return np.cos(2 * np.pi * np.outer(t, self.freq) + self.phases)


class Transformed(Curve):
    def __init__(self, base: Curve, m: np.ndarray):
        self.base, self.m = base, np.asarray(m)

    def __call__(self, t):
        return self.base(t) @ self.m.T


@register()
def tube(points: np.ndarray, radius: float = 0.06, warm=(0.9, 0.6, 0.2), cool=(0.6, 0.25, 0.1)) -> Shape:
    warm, cool = np.array(warm), np.array(cool)
    n = len(points)
    out = []
    for i in range(n):
        p, q = points[i], points[(i + 1) % n]
        w = 0.5 + 0.5 * np.cos(2 * np.pi * i / n)
        out.append(primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': p, 'p1': q}, color=tuple(w * warm + (1 - w) * cool)))
    return concat_shapes(*out)


@register()
def knot(n: int = 160) -> Shape:
    curve = Lissajous(3, 2, 7) @ np.diag([1.2, 1.2, 0.8])
    return library_call('tube', points=curve.sample(n))


@register()
def plinth(width: float = 1.6, height: float = 1.5) -> Shape:
    layers = [(width * 1.2, 0.15), (width, height), (width * 1.1, 0.1)]
    y, out = 0.0, []
    for w, h in layers:
        out += transform_shape(primitive_call('cube', shape_kwargs={'scale': (w, h, w)}, color=(0.9, 0.9, 0.88)), translation_matrix((0, y + h / 2, 0)))
        y += h
    return out


@register()
def sculpture() -> Shape:
    base, k = library_call('plinth'), library_call('knot')
    lift = compute_shape_max(base)[1] - compute_shape_min(k)[1]
    return concat_shapes(base, transform_shape(k, translation_matrix((0, lift, 0))))
