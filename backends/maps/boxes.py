"""Boxes around instances: in the picture, of what is seen and of the whole, and in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.camera import Camera
from scenelang.backends.maps.truth import Truth
from scenelang.backends.solids import Form, Solids
from scenelang.interpreter.ancestry import Ancestry

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
_CORNER = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0]])
_NEAR = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """For each instance (M,): ``visible`` (M, 4) pixel columns and rows x0, y0, x1, y1 (ends excluded) of what is seen
    of it, ``area`` (M,) how many pixels; ``full`` (M, 4) the exact rectangle of its whole projection in pixels, also
    beyond the picture, nan where a part of it lies behind the camera."""

    visible: IntArray
    area: IntArray
    full: FloatArray


def boxes_in(truth: Truth) -> Boxes:
    """The boxes of every instance of a shot."""
    ancestry = truth.ancestry
    count = len(ancestry)
    rows, columns = np.nonzero(truth.seen)
    own = truth.instance[rows, columns]
    visible = np.tile(np.array([truth.camera.width, truth.camera.height, 0, 0]), (count, 1))
    area = np.bincount(own, minlength=count)
    for start, values in ((0, columns), (1, rows)):
        np.minimum.at(visible[:, start], own, values)
        np.maximum.at(visible[:, start + 2], own, values + 1)
    full = np.tile(np.array([np.inf, np.inf, -np.inf, -np.inf]), (count, 1))
    solids = truth.solids
    rectangles = rectangles_of(solids, truth.camera)
    number = ancestry.primitives[solids.instance]
    np.minimum.at(full, number, np.where([True, True, False, False], rectangles, np.inf))
    np.maximum.at(full, number, np.where([False, False, True, True], rectangles, -np.inf))
    _gather(ancestry, visible, area, full)
    full[~np.isfinite(full).all(axis=1)] = np.nan
    return Boxes(visible, area, full)


def _gather(ancestry: Ancestry, visible: IntArray, area: IntArray, full: FloatArray) -> None:
    """Pass what instances cover to their parents, from the deepest level up."""
    for depth in range(ancestry.deepest, 0, -1):
        rows = np.flatnonzero(ancestry.depth == depth)
        parent = ancestry.parent[rows]
        np.add.at(area, parent, area[rows])
        for boxes in (visible, full):
            np.minimum.at(boxes[:, :2], parent, boxes[rows, :2])
            np.maximum.at(boxes[:, 2:], parent, boxes[rows, 2:])


def rectangles_of(solids: Solids, camera: Camera) -> FloatArray:
    """The exact rectangles (N, 4) x0, y0, x1, y1 that solids project to, in pixels; nan where one lies partly behind
    the camera. Ellipsoids and disks by their dual quadrics, the rest by corners."""
    turn, move = camera.world_to_camera[:3, :3], camera.world_to_camera[:3, 3]
    linear = turn @ solids.matrices[:, :, :3]
    center = solids.matrices[:, :, 3] @ turn.T + move
    out = np.full((len(solids), 4), np.nan)
    for form in Form:
        rows = np.flatnonzero(solids.forms == form)
        if len(rows):
            out[rows] = _rectangles(form, linear[rows], center[rows], camera)
    return out


def _rectangles(form: Form, linear: FloatArray, center: FloatArray, camera: Camera) -> FloatArray:
    if form == Form.BALL:
        return _of_quadrics(np.concatenate([linear, center[:, :, None]], axis=2), camera)
    if form in (Form.BLOCK, Form.TRIANGLE):
        hull = _CUBE if form == Form.BLOCK else _CORNER
        return _of_points(np.einsum("nij,kj->nki", linear, hull) + center[:, None], camera)
    across = linear[:, :, [0, 2]]
    bottom = _of_quadrics(np.concatenate([across, (center - linear[:, :, 1])[:, :, None]], axis=2), camera)
    top = center + linear[:, :, 1]
    if form == Form.CYLINDER:
        return _union(bottom, _of_quadrics(np.concatenate([across, top[:, :, None]], axis=2), camera))
    return _union(bottom, _of_points(top[:, None], camera))


def _union(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.concatenate([np.minimum(a[:, :2], b[:, :2]), np.maximum(a[:, 2:], b[:, 2:])], axis=1)


def _of_points(points: FloatArray, camera: Camera) -> FloatArray:
    """The rectangles of point sets (N, K, 3) in the camera's frame."""
    depth = points[:, :, 2]
    safe = np.ones_like(depth) if camera.is_parallel else np.where(depth > _NEAR, depth, np.nan)
    flat = points[:, :, :2] / safe[:, :, None] * np.array(camera.focal) + np.array(camera.principal)
    return np.concatenate([flat.min(axis=1), flat.max(axis=1)], axis=1)


def _of_quadrics(frames: FloatArray, camera: Camera) -> FloatArray:
    """The rectangles of ellipsoids or ellipses: ``frames`` (N, 3, K) are K - 1 half axes and the centre.

    Their dual quadric is ``F diag(1, .., 1, -1) F'``; a line l of the picture touches the projection where l' C l = 0.
    """
    signs = np.ones(frames.shape[2])
    signs[-1] = -1.0
    projected = frames.copy()
    if camera.is_parallel:  # the third coordinate of a picture point is 1 whatever its depth
        projected[:, 2], projected[:, 2, -1] = 0.0, 1.0
    dual = np.einsum("nik,k,njk->nij", projected, signs, projected)
    nearest = frames[:, 2, -1] - np.sqrt((frames[:, 2, :-1] ** 2).sum(axis=1))
    before = np.ones(len(frames), bool) if camera.is_parallel else nearest > _NEAR
    out = np.full((len(frames), 4), np.nan)
    with np.errstate(all="ignore"):
        for axis in range(2):
            middle = dual[:, axis, 2]
            root = np.sqrt(np.maximum(middle**2 - dual[:, axis, axis] * dual[:, 2, 2], 0.0))
            ends = np.stack([(middle - root) / dual[:, 2, 2], (middle + root) / dual[:, 2, 2]])
            pixels = ends * camera.focal[axis] + camera.principal[axis]
            out[:, axis], out[:, axis + 2] = pixels.min(axis=0), pixels.max(axis=0)
    out[~before] = np.nan
    return out
