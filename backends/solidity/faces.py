"""The flat faces of posed solids, and how much of two of them lies in one plane."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from scenelang.backends.solidity.support import Forms
from scenelang.backends.solids import FloatArray, Form, cofactors_of

_TURN = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
_DOWN = -0.99
_SQUARE = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))


def _canonical(form: int) -> Iterator[tuple[int, float, FloatArray]]:
    """The faces of a canonical solid: the axis that it looks along, the side, its corners (K, 3)."""
    if form == Form.BLOCK:
        for axis in range(3):
            for side in (-1.0, 1.0):
                corners = np.insert(np.array(_SQUARE), axis, side, axis=1)
                yield axis, side, corners
    elif form in (Form.CYLINDER, Form.CONE):
        for side in (-1.0,) if form == Form.CONE else (-1.0, 1.0):
            yield 1, side, np.stack([np.cos(_TURN), np.full(len(_TURN), side), np.sin(_TURN)], axis=1)


def _faces(form: int, matrix: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Outward unit normals (3,) and corners (K, 3) of a posed solid's flat faces."""
    cofactors = cofactors_of(matrix[None, :, :3])[0]
    inside_out = np.sign(np.linalg.det(matrix[:, :3]))
    for axis, side, corners in _canonical(form):
        normal = cofactors[:, axis] * side * inside_out
        length = np.linalg.norm(normal)
        if length > 0.0:
            yield normal / length, corners @ matrix[:, :3].T + matrix[:, 3]


@dataclass(frozen=True, slots=True, eq=False)
class SharedFace:
    """Where a face of one solid and one of another lie in one plane: ``area``, its ``share`` of the smaller face, the
    middle (3,) and the unit normal (3,) that both look along."""

    area: float
    share: float
    center: FloatArray
    normal: FloatArray


def shared_face(forms: Forms, matrices: FloatArray, i: int, j: int, tolerance: float) -> SharedFace | None:
    """The largest piece that a face of ``i`` and one of ``j`` share, looking the same way in planes nearer than
    ``tolerance``. Faces that look straight down are left out: who looks from below?"""
    best: SharedFace | None = None
    others = list(_faces(int(forms[j]), matrices[j]))
    for normal, corners in _faces(int(forms[i]), matrices[i]):
        if normal[1] < _DOWN:
            continue
        for other_normal, other in others:
            if normal @ other_normal < 1.0 - 1e-6 or abs((other[0] - corners[0]) @ normal) > tolerance:
                continue
            axes = _axes(normal)
            first, second = _counter_clockwise(corners @ axes), _counter_clockwise(other @ axes)
            piece = _clipped(first, second)
            area, smaller = _area(piece), min(_area(first), _area(second))
            if smaller > 0.0 and area > (best.area if best is not None else 0.0):
                center = axes @ piece.mean(axis=0) + normal * (corners[0] @ normal)
                best = SharedFace(area, area / smaller, center, normal)
    return best


def _axes(normal: FloatArray) -> FloatArray:
    """Two unit vectors across ``normal`` as columns (3, 2)."""
    least = np.eye(3)[np.argmin(np.abs(normal))]
    u = np.cross(normal, least)
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u)], axis=1)


def _signed(polygon: FloatArray) -> float:
    x, y = polygon[:, 0], polygon[:, 1]
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2.0) if len(polygon) > 2 else 0.0


def _area(polygon: FloatArray) -> float:
    return abs(_signed(polygon))


def _counter_clockwise(polygon: FloatArray) -> FloatArray:
    return polygon if _signed(polygon) >= 0.0 else polygon[::-1]


def _clipped(subject: FloatArray, clip: FloatArray) -> FloatArray:
    """The part of a convex polygon inside another (Sutherland and Hodgman); both counter-clockwise."""
    for start, end in zip(clip, np.roll(clip, -1, axis=0)):
        edge = end - start
        side = edge[0] * (subject[:, 1] - start[1]) - edge[1] * (subject[:, 0] - start[0])
        kept: list[FloatArray] = []
        for k in range(len(subject)):
            here, there = side[k], side[(k + 1) % len(subject)]
            if here >= 0.0:
                kept.append(subject[k])
            if (here >= 0.0) != (there >= 0.0):
                kept.append(subject[k] + (subject[(k + 1) % len(subject)] - subject[k]) * here / (here - there))
        if not kept:
            return np.zeros((0, 2))
        subject = np.array(kept)
    return subject
