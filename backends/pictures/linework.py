"""Outlines: lines at silhouettes, at creases and between objects, from what a finer grid of rays sees.

A line is where neighboring rays see different objects, or one object's surface whose normals differ by more than a
crease, or whose depth jumps: the step between the points is far from the tangent plane. The rays on both sides are
widened by a disc, and averaged over each pixel.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.rays import Caster, Keys, Rays, camera_rays, caster_for, depths_of, ids_of
from scenelang.backends.pictures.stage import Stage

Float32Array = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

_FINENESS = ((400_000, 4), (1_100_000, 3), (4_200_000, 2))  # rays per pixel and axis, up to so many pixels
_CREASE_COSINE = float(np.cos(np.radians(30.0)))
_JUMP = 4.0  # distance from the tangent plane, in steps between rays: a sphere's limb stays below 1
_BATCH_ROWS = 1 << 18  # rays whose normals are computed at once, which bounds the memory


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """What is drawn of outlines: the share (H, W) of each pixel that lines cover, and that objects cover."""

    ink: Float32Array
    objects: Float32Array


def lines_of(stage: Stage, width: float, every_triangle: bool = False) -> Lines:
    """Return the lines of a stage, ``width`` pixels wide, around objects or around every triangle of a mesh."""
    fine = next((count for most, count in _FINENESS if stage.width * stage.height <= most), 1)
    camera = stage.camera.resized(stage.width * fine, stage.height * fine)
    rays = camera_rays(camera, 1)
    caster = caster_for(stage.solids, rays)
    keys = caster.cast(stage.solids.opacity > 0.0)
    ids = ids_of(keys).astype(np.int64)
    ids[ids < 0] = -1
    group = ids if every_triangle else np.append(stage.solids.instance, -1)[ids]
    depth = np.where(ids >= 0, depths_of(keys), np.inf).astype(np.float32)
    surface = _points_and_normals(caster, rays, keys, ids)
    is_thin = width * fine < 2.0
    edges = _edges(replace(stage, camera=camera), group, depth, surface, both_sides=not is_thin)
    wide = edges if is_thin else widened(edges, width * fine / 2.0 - 1.0)
    return Lines(averaged(wide, fine), averaged(ids >= 0, fine))


def _points_and_normals(caster: Caster, rays: Rays, keys: Keys, ids: IntArray) -> tuple[Float32Array, Float32Array]:
    """Return the points and the normals (H, W, 3) of what rays see; zero where they see nothing."""
    points, normals = (np.zeros((*ids.shape, 3), np.float32) for _ in range(2))
    rows, columns = np.nonzero(ids >= 0)
    depths = depths_of(keys)
    for low in range(0, len(rows), _BATCH_ROWS):
        row, column = rows[low : low + _BATCH_ROWS], columns[low : low + _BATCH_ROWS]
        origin, direction = rays.at(column.astype(np.float64) + 0.5, row.astype(np.float64) + 0.5)
        at = origin + direction * depths[row, column].astype(np.float64)[:, None]
        points[row, column] = at
        normals[row, column] = caster.surface(ids[row, column], at, direction)
    return points, normals


def _edges(
    stage: Stage, group: IntArray, depth: Float32Array, surface: tuple[Float32Array, Float32Array], *, both_sides: bool
) -> Mask:
    """Return the rays (H, W) at both sides of a line, or at the nearer one."""
    points, normals = surface
    edges = np.zeros(group.shape, bool)
    step = 1.0 / stage.camera.focal[1]  # between neighboring rays at depth 1
    for before, after in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        both = (group[before] >= 0) & (group[after] >= 0)
        turn = np.einsum("rci,rci->rc", normals[before], normals[after])
        move = points[after] - points[before]
        off = [np.abs(np.einsum("rci,rci->rc", normals[side], move)) for side in (before, after)]
        near = np.minimum(depth[before], depth[after])
        reach = step * (np.ones_like(near) if stage.camera.is_parallel else near)
        with np.errstate(invalid="ignore"):
            bent = both & ((turn < _CREASE_COSINE) | (np.maximum(*off) > _JUMP * reach))
        line = (group[before] != group[after]) | bent
        nearer = depth[before] <= depth[after]
        edges[before] |= line & (nearer | both_sides)
        edges[after] |= line & (~nearer | both_sides)
    return edges


def widened(mask: Mask, radius: float) -> Mask:
    """Return a mask (H, W) widened by a disc of ``radius``: for each row of it, by a run of its length."""
    height, width = mask.shape
    wide = np.zeros_like(mask)
    reach = int(radius)
    sums = np.zeros((height, width + 1), np.int32)
    np.cumsum(mask, axis=1, out=sums[:, 1:])
    for down in range(-reach, reach + 1):
        half = int((radius * radius - down * down) ** 0.5)
        first, last = np.maximum(np.arange(width) - half, 0), np.minimum(np.arange(width) + half + 1, width)
        run = sums[:, last] > sums[:, first]
        low, high = max(0, down), height + min(0, down)
        wide[low:high] |= run[low - down : high - down]
    return wide


def averaged(mask: Mask, fine: int) -> Float32Array:
    """Return the mean of ``fine`` x ``fine`` rays of each pixel."""
    height, width = mask.shape[0] // fine, mask.shape[1] // fine
    means: Float32Array = mask.reshape(height, fine, width, fine).mean(axis=(1, 3), dtype=np.float32)
    return means
