"""Support points of posed canonical solids (``backends.solids``): how far each one reaches in a direction."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from scenelang.backends.solids import FloatArray, Form

Forms = npt.NDArray[np.int8]


def support(forms: Forms, matrices: FloatArray, directions: FloatArray) -> FloatArray:
    """The farthest points (N, 3) of the solids under ``matrices`` (N, 3, 4) along ``directions`` (N, 3)."""
    local = np.einsum("nij,ni->nj", matrices[:, :, :3], directions)
    point = np.sign(local)  # of a block, where 0 stands for the middle of an edge or face
    ball = forms == Form.BALL
    if ball.any():
        point[ball] = _unit(local[ball])
    for form in (Form.CYLINDER, Form.CONE):
        chosen = forms == form
        if chosen.any():
            point[chosen] = _round(local[chosen], cone=form is Form.CONE)
    found: FloatArray = np.einsum("nij,nj->ni", matrices[:, :, :3], point) + matrices[:, :, 3]
    return found


def _round(local: FloatArray, cone: bool) -> FloatArray:
    """Support points of the canonical cylinder or cone."""
    point = np.empty_like(local)
    across = np.hypot(local[:, 0], local[:, 2])
    safe = np.where(across > 0.0, across, 1.0)
    point[:, 0], point[:, 2] = local[:, 0] / safe, local[:, 2] / safe
    if not cone:
        point[:, 1] = np.sign(local[:, 1])
        return point
    point[:, 1] = -1.0
    apex = local[:, 1] > across - local[:, 1]
    point[apex] = (0.0, 1.0, 0.0)
    return point


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


def boxes(forms: Forms, matrices: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The exact axis-aligned boxes of posed solids: least and greatest corners, (N, 3) each."""
    low, high = np.empty((len(forms), 3)), np.empty((len(forms), 3))
    for axis in range(3):
        direction = np.zeros((len(forms), 3))
        direction[:, axis] = 1.0
        high[:, axis] = support(forms, matrices, direction)[:, axis]
        low[:, axis] = support(forms, matrices, -direction)[:, axis]
    return low, high
