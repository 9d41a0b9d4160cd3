import numpy as np
from helper import *

"""
foam egg crate panels from broadcast waves
"""


def bumps(nx: int, nz: int, kind: str) -> np.ndarray:
    x = np.linspace(0, 2 * np.pi, nx)
    z = np.linspace(0, 2 * np.pi, nz)
    if kind == "product":
        return np.sin(x)[:, None] * np.sin(z)[None, :]
    if kind == "sum":
        return (np.cos(x)[:, np.newaxis] + np.cos(z)) / 2
    if kind == "ring":
        return np.cos(np.hypot(*(a - np.pi for a in np.ix_(x, z))))
    raise ValueError(f"unknown kind {kind!r}")


@register()
def panel(kind: str, n: int = 10, color: tuple = (0.3, 0.5, 0.8)) -> Shape:
    heights = bumps(n, n, kind)
    low, high = heights.min(), heights.max()
    heights = 0.1 + 0.8 * (heights - low) / (high - low)
    tint = np.asarray(color)
    # one color for each cell: (n, n, 1) times (3,)
    colors = np.clip(heights[..., None] * 0.6 + tint * 0.5, 0, 1)
    centers = np.stack(np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), axis=-1) - (n - 1) / 2
    shapes = []
    for i, j in np.ndindex(n, n):
        h = heights[i, j]
        cell = primitive_call('cube', color=tuple(colors[i, j]), shape_kwargs={'scale': (0.9, h, 0.9)})
        x, z = centers[i, j]
        shapes.append(transform_shape(cell, translation_matrix((x, h / 2, z))))
    return concat_shapes(*shapes)


@register()
def studio() -> Shape:
    kinds = ("product", "sum", "ring")
    offsets = np.arange(len(kinds))[:, None] * np.array([11.0, 0.0, 0.0])
    palette = np.array([[0.8, 0.3, 0.3], [0.3, 0.7, 0.4], [0.3, 0.4, 0.9]])
    shapes = [transform_shape(library_call('panel', kind=k, color=tuple(c)), translation_matrix(o)) for k, c, o in zip(kinds, palette, offsets)]
    corners = np.array([-1, 1])[:, None] * np.array([[0.5, 0.0, 0.5]]) * 12 + np.array([11.0, 0, 0])
    stands = [primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.2, 'p0': p, 'p1': p + [0, 4, 0]}) for p in corners]
    return concat_shapes(*shapes, *stands)
