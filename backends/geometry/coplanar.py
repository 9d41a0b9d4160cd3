"""Coplanar faces of solids in different colors, of which either may be drawn (z-fighting)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scenelang.backends.geometry.hidden import holds_points
from scenelang.backends.surfaces.convex import Bodies, plane_axes, signed_area
from scenelang.backends.surfaces.distance import IntArray
from scenelang.backends.surfaces.solids import FloatArray, PosedForms
from scenelang.interpreter.scene.primitives.mesh import cofactors_of

_MIN_FACE_SHARE = 0.1  # of the smaller face: less flickers too little to be seen
_MIN_COLOR_DIFFERENCE = 0.08  # of linear channels: z-fighting of stones with slightly different tints is not visible
_DOWNWARD_NORMAL = -0.99  # vertical component of the normal of faces that look down and are rarely visible


Vector = tuple[float, float, float]
_Face = tuple[FloatArray, FloatArray]


def faces_of(solids: PosedForms, i: int) -> Iterator[_Face]:
    """Yield outward unit normals (3,) and corners (K, 3) of a posed solid's flat faces."""
    matrix = solids.matrices[i]
    cofactors = cofactors_of(matrix[None, :, :3])[0]
    inside_out = np.sign(np.linalg.det(matrix[:, :3]))
    form, ratios = solids.form(i)
    for axis, side, corners in form.flat_faces(ratios):
        normal = cofactors[:, axis] * side * inside_out
        length = np.linalg.norm(normal)
        if length > 0.0:
            yield normal / length, corners @ matrix[:, :3].T + matrix[:, 3]


@dataclass(frozen=True, slots=True, eq=False)
class SharedFace:
    """Overlap of two coplanar faces that face the same way.

    Attributes
    ----------
    area
        Area of the overlap, in squared scene units.
    share
        Its fraction of the smaller face.
    center, normal : (3,)
        Its center, and the common unit normal.
    """

    area: float
    share: float
    center: FloatArray
    normal: FloatArray


def shared_face(
    faces: Sequence[_Face], others: Sequence[_Face], tolerance: float, least_width: float
) -> SharedFace | None:
    """Return the largest overlap of coplanar ``faces`` and ``others``, in planes closer than ``tolerance``.

    Faces that look straight down and overlaps narrower than ``least_width`` are ignored, since they are rarely visible.
    """
    best: SharedFace | None = None
    for normal, corners in faces:
        if normal[1] < _DOWNWARD_NORMAL:
            continue
        for other_normal, other in others:
            if normal @ other_normal < 1.0 - 1e-6 or abs((other[0] - corners[0]) @ normal) > tolerance:
                continue
            axes = plane_axes(normal)
            first, second = _counter_clockwise(corners @ axes), _counter_clockwise(other @ axes)
            piece = _clipped(first, second)
            area, smaller = abs(signed_area(piece)), min(abs(signed_area(first)), abs(signed_area(second)))
            if smaller > 0.0 and _width(piece) >= least_width and area > (best.area if best is not None else 0.0):
                center = axes @ piece.mean(axis=0) + normal * (corners[0] @ normal)
                best = SharedFace(area, area / smaller, center, normal)
    return best


def _width(polygon: FloatArray) -> float:
    """Return the width of a rectangle of the polygon's area and perimeter, if it is narrow."""
    perimeter = np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1).sum() if len(polygon) else 0.0
    return 2.0 * abs(signed_area(polygon)) / float(perimeter) if perimeter > 0.0 else 0.0


def _counter_clockwise(polygon: FloatArray) -> FloatArray:
    """Return a polygon (K, 2) in counter-clockwise order."""
    return polygon if signed_area(polygon) >= 0.0 else polygon[::-1]


def _clipped(subject: FloatArray, clip: FloatArray) -> FloatArray:
    """Return the part of a convex polygon inside another; both counter-clockwise.

    Source: Sutherland and Hodgman, "Reentrant polygon clipping", CACM 17 (1974).
    """
    for start, end in zip(clip, np.roll(clip, -1, axis=0)):
        edge = end - start
        side = edge[0] * (subject[:, 1] - start[1]) - edge[1] * (subject[:, 0] - start[0])
        inside_points: list[FloatArray] = []
        for k in range(len(subject)):
            distance, next_distance = side[k], side[(k + 1) % len(subject)]
            if distance >= 0.0:
                inside_points.append(subject[k])
            if (distance >= 0.0) != (next_distance >= 0.0):
                inside_points.append(
                    subject[k] + (subject[(k + 1) % len(subject)] - subject[k]) * distance / (distance - next_distance)
                )
        if not inside_points:
            return np.zeros((0, 2))
        subject = np.array(inside_points)
    return subject


def coplanar_pairs(bodies: Bodies, pairs: IntArray) -> Iterator[tuple[int, int, float, Vector | None]]:
    """Yield touching solids with visible coplanar faces of different colors.

    Each with the area that they share, and the translation of the second by which the thinner one protrudes.
    """
    colors = np.abs(bodies.colors[pairs[:, 0]] - bodies.colors[pairs[:, 1]]).max(axis=1)
    flat = (bodies.exact & ~bodies.solids.that_are("is_rounded"))[pairs].all(axis=1)
    opaque = bodies.opaque[pairs].all(axis=1)
    chosen = pairs[flat & opaque & (colors > _MIN_COLOR_DIFFERENCE)]
    faces = {i: list(faces_of(bodies.solids, i)) for i in np.unique(chosen).tolist()}
    for i, j in chosen.tolist():
        shared = shared_face(faces[i], faces[j], 1e-5 * bodies.size, bodies.touch)
        if shared is None or shared.share < _MIN_FACE_SHARE:
            continue
        if not _is_covered(bodies, shared, i, j):
            yield i, j, shared.area, _out_of(bodies, shared.normal, i, j)


def _out_of(bodies: Bodies, normal: FloatArray, i: int, j: int) -> Vector | None:
    """Return a translation of a body ``j`` after which the thinner of two bodies protrudes along a normal.

    None if they are equally thick, and so coplanar on both sides.
    """
    thick = [float(np.abs(normal) @ (bodies.boxes[1] - bodies.boxes[0])[k]) for k in (i, j)]
    if abs(thick[0] - thick[1]) <= 1e-5 * bodies.size:
        return None
    move = normal * min(2.0 * bodies.touch, 0.5 * min(thick)) * (1.0 if thick[1] < thick[0] else -1.0)
    return float(move[0]), float(move[1]), float(move[2])


def _is_covered(bodies: Bodies, shared: SharedFace, i: int, j: int) -> bool:
    """Return whether a third solid hides the center of a shared face."""
    low, high = bodies.boxes
    point = shared.center + shared.normal * (1e-4 * bodies.size)
    near = np.flatnonzero(((low <= point) & (high >= point)).all(axis=1))
    return any(k not in (i, j) and bodies.opaque[k] and holds_points(bodies, k, point[None]) for k in near.tolist())
