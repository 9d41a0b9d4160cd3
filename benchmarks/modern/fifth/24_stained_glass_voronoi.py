"""a gothic stained-glass window with voronoi panes and lead lines"""
from helper import *
from typing import Final
import colorsys
import numpy as np

WIDTH: Final = 28
HEIGHT: Final = 44
CELL: Final = 0.08


def pointed_arch(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Mask of a gothic window: a rectangle and two circles that meet at the top."""
    half, spring = 1.0, 2.0
    lower = (np.abs(x) <= half) & (y >= 0) & (y < spring)
    upper = (y >= spring) & (np.hypot(x - half, y - spring) <= 2 * half) & (np.hypot(x + half, y - spring) <= 2 * half)
    return lower | upper


def relax(sites: np.ndarray, pixels: np.ndarray, rounds: int = 3) -> np.ndarray:
    """Lloyd's algorithm on pixels."""
    for _ in range(rounds):
        owner = np.argmin(((pixels[:, None] - sites[None]) ** 2).sum(-1), axis=1)
        sites = np.array([pixels[owner == k].mean(axis=0) if np.any(owner == k) else s for k, s in enumerate(sites)])
    return sites


def assign(panes: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    xs = (np.arange(WIDTH) - (WIDTH - 1) / 2) * CELL
    ys = np.arange(HEIGHT) * CELL
    gx, gy = np.meshgrid(xs, ys)
    inside = pointed_arch(gx, gy)
    pixels = np.column_stack([gx[inside], gy[inside]])
    sites = relax(pixels[rng.choice(len(pixels), panes, replace=False)], pixels)
    owner = np.full(gx.shape, -1)
    owner[inside] = np.argmin(np.linalg.norm(pixels[:, None, :] - sites, axis=-1), axis=1)
    return owner, gx, gy


def pane_color(k: int, center: tuple[float, float]) -> tuple[float, float, float]:
    x, y = center
    hue = (np.arctan2(y - 2.0, x) / (2 * np.pi)) % 1.0
    return colorsys.hsv_to_rgb(hue, 0.75 if k % 3 else 0.45, 0.95 - 0.2 * (k % 2))


@register()
def glass(panes: int = 24, seed: int = 1163, depth: float = 0.05) -> Shape:
    owner, gx, gy = assign(panes, seed)
    # a pixel is lead where its right or upper neighbour belongs to another pane
    lead = np.zeros_like(owner, dtype=bool)
    lead[:, :-1] |= owner[:, :-1] != owner[:, 1:]
    lead[:-1, :] |= owner[:-1, :] != owner[1:, :]
    lead &= owner >= 0
    out = []
    for k in np.unique(owner[owner >= 0]):
        mask = (owner == k) & ~lead
        if not (n := int(mask.sum())):
            continue
        color = pane_color(int(k), (float(gx[mask].mean()), float(gy[mask].mean())))
        # merge the pixels of a row into one strip
        for row in np.flatnonzero(mask.any(axis=1)):
            cols = np.flatnonzero(mask[row])
            for run in np.split(cols, np.flatnonzero(np.diff(cols) > 1) + 1):
                w = len(run) * CELL
                strip = primitive_call('cube', shape_kwargs={'scale': (w, CELL, depth)}, color=color)
                out.append(transform_shape(strip, translation_matrix((gx[row, run[0]] + w / 2 - CELL / 2, gy[row, 0], 0.0))))
    for r, c in zip(*np.nonzero(lead)):
        bead = primitive_call('cube', shape_kwargs={'scale': (CELL, CELL, depth * 2)}, color=(0.12, 0.12, 0.14))
        out.append(transform_shape(bead, translation_matrix((gx[r, c], gy[r, c], 0))))
    return concat_shapes(*out)


@register()
def stone_frame(thickness: float = 0.14, arc_steps: int = 12) -> Shape:
    left = [(-1.15, y) for y in np.linspace(-0.1, 2.0, 5)]
    theta = np.linspace(np.pi, np.pi - np.arccos(1 / 2.15), arc_steps)[1:]
    arc = [(1.0 + 2.15 * np.cos(t), 2.0 + 2.15 * np.sin(t)) for t in theta]
    half = left + arc
    path = half + [(-x, y) for x, y in reversed(half)]
    stones = [primitive_call('cylinder', shape_kwargs={'radius': thickness, 'p0': (x0, y0, 0), 'p1': (x1, y1, 0)}, color=(0.6, 0.57, 0.52))
              for (x0, y0), (x1, y1) in zip(path[:-1], path[1:])]
    sill = transform_shape(primitive_call('cube', shape_kwargs={'scale': (2.9, 0.2, 0.6)}, color=(0.65, 0.62, 0.56)), translation_matrix((0, -0.2, 0.1)))
    return concat_shapes(*stones, sill)


@register()
def light_pool(rows: int = 6, columns: int = 5) -> Shape:
    """Coloured light on the floor in front of the window."""
    def patch(i: int) -> Shape:
        r, c = divmod(i, columns)
        rgb = colorsys.hsv_to_rgb((i * 0.381966) % 1, 0.35, 0.95)
        tile = primitive_call('cube', shape_kwargs={'scale': (0.4, 0.01, 0.5)}, color=rgb)
        return transform_shape(tile, translation_matrix(((c - (columns - 1) / 2) * 0.42 * (1 + 0.08 * r), -0.85, 0.6 + 0.52 * r)))
    return loop(rows * columns, patch)


@register()
def chapel_window() -> Shape:
    wall = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (1.2, 5.2, 0.4)}, color=(0.72, 0.69, 0.63)), translation_matrix((s * 1.9, 1.7, 0))) for s in (-1, 1)]
    floor = transform_shape(primitive_call('cube', shape_kwargs={'scale': (5, 0.1, 4.5)}, color=(0.5, 0.47, 0.44)), translation_matrix((0, -0.92, 2)))
    return concat_shapes(*wall, floor, library_call('stone_frame'), library_call('glass'), library_call('light_pool'))
