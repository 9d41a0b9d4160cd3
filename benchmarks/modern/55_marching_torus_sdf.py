"""a blobby smooth union of a torus and a sphere, sampled as voxels from a signed distance field"""
from __future__ import annotations
from helper import *
import numpy as np
from typing import Callable

Field = Callable[[np.ndarray], np.ndarray]


class SDF:
    def __init__(self, f: Field):
        self.f = f

    def __call__(self, p: np.ndarray) -> np.ndarray:
        return self.f(p)

    def __or__(self, other: SDF) -> SDF:
        return SDF(lambda p: np.minimum(self(p), other(p)))

    def __and__(self, other: SDF) -> SDF:
        return SDF(lambda p: np.maximum(self(p), other(p)))

    def __sub__(self, other: SDF) -> SDF:
        return SDF(lambda p: np.maximum(self(p), -other(p)))

    def blend(self, other: SDF, k: float = 0.3) -> SDF:
        def f(p):
            a, b = self(p), other(p)
            h = np.clip(0.5 + 0.5 * (b - a) / k, 0, 1)
            return b * (1 - h) + a * h - k * h * (1 - h)
        return SDF(f)

    def shift(self, offset) -> SDF:
        return SDF(lambda p: self(p - np.asarray(offset, dtype=float)))


def ball(r: float) -> SDF:
    return SDF(lambda p: np.linalg.norm(p, axis=-1) - r)


def torus(R: float, r: float) -> SDF:
    return SDF(lambda p: np.hypot(np.hypot(p[..., 0], p[..., 2]) - R, p[..., 1]) - r)


def slab(thickness: float) -> SDF:
    return SDF(lambda p: np.abs(p[..., 1]) - thickness)


@register()
def voxel(size: float, color) -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': (size, size, size)}, color=color)


@register()
def sdf_voxels(model: SDF, n: int = 20, extent: float = 1.6) -> Shape:
    axis = np.linspace(-extent, extent, n)
    grid = np.stack(np.meshgrid(axis, axis, axis, indexing='ij'), axis=-1)
    d = model(grid)
    h = axis[1] - axis[0]
    shell = (d < 0) & (d > -1.2 * h)
    pts = grid[shell]
    t = (pts - pts.min(axis=0)) / np.ptp(pts, axis=0)
    colors = np.array([0.95, 0.35, 0.3]) * (1 - t[:, 1:2]) + np.array([0.3, 0.45, 0.95]) * t[:, 1:2]
    return concat_shapes(*[transform_shape(library_call('voxel', size=h * 0.95, color=tuple(c)), translation_matrix(p)) for p, c in zip(pts, colors)])


@register()
def blob() -> Shape:
    shape = torus(1.0, 0.3).blend(ball(0.5).shift((0, 0.7, 0)), k=0.5) - ball(0.35).shift((1.0, 0.2, 0))
    trimmed = shape & slab(1.3)
    return library_call('sdf_voxels', model=trimmed | ball(0.2))
