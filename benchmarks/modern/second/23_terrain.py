"""
a voxel island with beaches, grass, snowy peaks and a few palm trees
"""
from helper import *
import numpy as np
from dataclasses import dataclass


@dataclass(frozen=True)
class Band:
    upto: float
    color: tuple[float, float, float]


BANDS = (
    Band(0.8, (0.90, 0.83, 0.60)),
    Band(2.2, (0.38, 0.62, 0.28)),
    Band(3.4, (0.48, 0.44, 0.40)),
    Band(float('inf'), (0.97, 0.98, 1.0)),
)


def perlin(shape: tuple[int, int], cells: int, rng: np.random.Generator) -> np.ndarray:
    ang = rng.uniform(0, 2 * np.pi, (cells + 1, cells + 1))
    grad = np.stack([np.cos(ang), np.sin(ang)], axis=-1)
    xs = np.linspace(0, cells, shape[0], endpoint=False)
    ys = np.linspace(0, cells, shape[1], endpoint=False)
    X, Y = np.meshgrid(xs, ys, indexing='ij')
    i, j = X.astype(int), Y.astype(int)
    fx, fy = X - i, Y - j
    fade = lambda t: t ** 3 * (t * (t * 6 - 15) + 10)

    def corner(di, dj):
        g = grad[i + di, j + dj]
        return g[..., 0] * (fx - di) + g[..., 1] * (fy - dj)

    u, v = fade(fx), fade(fy)
    top = corner(0, 0) * (1 - u) + corner(1, 0) * u
    bot = corner(0, 1) * (1 - u) + corner(1, 1) * u
    return top * (1 - v) + bot * v


def heightmap(n: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    noise = sum(perlin((n, n), c, rng) / k for k, c in enumerate((2, 4, 8), start=1))
    axis = np.linspace(-1, 1, n)
    falloff = 1 - np.hypot(*np.meshgrid(axis, axis)) ** 2
    return np.clip(3.2 * falloff + 2.4 * noise - 0.3, 0, None)


def shade(h: float) -> tuple[float, float, float]:
    return next(b.color for b in BANDS if h <= b.upto)


@register()
def voxel_column(height: float = 1.0, width: float = 0.5) -> Shape:
    col = primitive_call('cube', {'scale': (width, height, width)}, color=shade(height))
    return transform_shape(col, translation_matrix((0, height / 2, 0)))


@register()
def palm(height: float = 1.2, fronds: int = 6, lean: float = 0.25) -> Shape:
    t = np.linspace(0, 1, 5)
    spine = np.column_stack([lean * t ** 2, height * t, 0 * t])
    trunk = [primitive_call('cylinder', {'radius': 0.07 - 0.01 * k, 'p0': a, 'p1': b}, color=(0.5, 0.38, 0.22))
             for k, (a, b) in enumerate(zip(spine[:-1], spine[1:]))]
    leaf = primitive_call('cube', {'scale': (0.6, 0.03, 0.14)}, color=(0.15, 0.5, 0.2))
    leaf = transform_shape(transform_shape(leaf, translation_matrix((0.3, 0, 0))), rotation_matrix(-0.4, (0, 0, 1), (0, 0, 0)))
    crown = loop(fronds, lambda i: transform_shape(leaf, rotation_matrix(2 * np.pi * i / fronds, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(*trunk, transform_shape(crown, translation_matrix(spine[-1])))


@register()
def island(n: int = 22, seed: int = 12, pitch: float = 0.5) -> Shape:
    H = heightmap(n, seed)
    H = np.round(H / 0.25) * 0.25
    land = np.argwhere(H > 0)
    centre = (n - 1) / 2
    shapes = [transform_shape(library_call('voxel_column', height=H[i, j], width=pitch),
                              translation_matrix(((i - centre) * pitch, 0, (j - centre) * pitch))) for i, j in land]
    beach = land[(H[tuple(land.T)] <= 0.8)]
    rng = np.random.default_rng(seed + 1)
    for i, j in rng.permutation(beach)[:6]:
        tree = transform_shape(library_call('palm'), rotation_matrix(rng.uniform(0, 6.28), (0, 1, 0), (0, 0, 0)))
        shapes.append(transform_shape(tree, translation_matrix(((i - centre) * pitch, H[i, j], (j - centre) * pitch))))
    return concat_shapes(*shapes)


@register()
def island_scene() -> Shape:
    land = library_call('island')
    w, _, d = compute_shape_sizes(land)
    water = primitive_call('cube', {'scale': (w + 4, 0.3, d + 4)}, color=(0.15, 0.5, 0.7))
    return concat_shapes(transform_shape(water, translation_matrix((0, -0.05, 0))), land)
