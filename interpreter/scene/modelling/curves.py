"""Paths: arrays (N, 3) of points, with their curves, lengths and frames.

A path is closed if it ends where it begins. Frames do not turn about the path, so that objects and cross-sections keep
their roll. Paths are plain arrays, not objects: array arithmetic moves and scales them, and programs can compute them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

_MAX_SMOOTH_TURN = math.radians(20.0)  # joints that turn less belong to a curve; others are corners
_SAME = 1e-9  # of the size of a path: points at this distance are equal


def without_repeats(points: FloatArray) -> FloatArray:
    """Drop the points that are equal to the one before."""
    if len(points) < 2:
        return points
    size = float(np.ptp(points, axis=0).max())
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.asarray(points[np.concatenate([[True], steps > _SAME * size])], np.float64)


def is_closed(points: FloatArray) -> bool:
    """Return whether a path ends where it begins."""
    size = float(np.ptp(points, axis=0).max(initial=0.0))
    return len(points) > 2 and float(np.linalg.norm(points[0] - points[-1])) <= _SAME * size


# --- curves ----------------------------------------------------------------------------------------------------------


def bezier(control: FloatArray, shares: FloatArray) -> FloatArray:
    """Return points (T, D) of a Bezier curve of any degree, by de Casteljau's algorithm.

    Parameters
    ----------
    control : (K, D)
        Control points.
    shares : (T,)
        Curve parameters from 0 to 1.
    """
    level = np.repeat(control[None], len(shares), axis=0)
    t = shares[:, None, None]
    while level.shape[1] > 1:
        level = level[:, :-1] * (1.0 - t) + level[:, 1:] * t
    return np.asarray(level[:, 0], np.float64)


def chained_bezier(control: FloatArray, segments: int) -> FloatArray:
    """Return the points of cubic Bezier curves that share their ends, with ``segments`` steps in each.

    ``control`` are 3 n + 1 control points of n curves.
    """
    shares = np.arange(1, segments + 1) / segments
    pieces = [bezier(control[start : start + 4], shares) for start in range(0, len(control) - 1, 3)]
    return np.concatenate([control[:1], *pieces])


def catmull_rom(points: FloatArray, closed: bool, segments: int) -> FloatArray:
    """Return a centripetal Catmull-Rom spline through points, with ``segments`` steps between two of them.

    Evaluated as in Barry and Goldman, "A recursive evaluation algorithm for a class of Catmull-Rom splines" (1988).
    Centripetal knots give no loops within a span (Yuksel et al., "Parameterization and applications of Catmull-Rom
    curves", 2011). The first point is repeated at the end of a closed spline.
    """
    if closed:
        padded = np.concatenate([points[-1:], points, points[:2]])
    else:
        ends = 2.0 * points[[0, -1]] - points[[1, -2]]
        padded = np.concatenate([ends[:1], points, ends[1:]])
    knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(padded, axis=0), axis=1) ** 0.5)])
    share = (np.arange(segments) / segments)[None, :, None]
    p = [padded[i : len(padded) - 3 + i, None, :] for i in range(4)]
    k = [knots[i : len(knots) - 3 + i, None, None] for i in range(4)]
    t = k[1] + (k[2] - k[1]) * share
    a = [_between(p[i], p[i + 1], k[i], k[i + 1], t) for i in range(3)]
    b = [_between(a[i], a[i + 1], k[i], k[i + 2], t) for i in range(2)]
    curve = _between(b[0], b[1], k[1], k[2], t).reshape(-1, points.shape[1])
    return np.concatenate([curve, padded[-2:-1]])


def _between(a: FloatArray, b: FloatArray, start: FloatArray, end: FloatArray, t: FloatArray) -> FloatArray:
    """Interpolate linearly between the knots ``start`` and ``end``."""
    return np.asarray(((end - t) * a + (t - start) * b) / (end - start), np.float64)


def helix(radius: float, height: float, turns: float, segments: int) -> FloatArray:
    """Return the points (N, 3) of a helix around the y axis, which begins at [0 0 radius] and rises to ``height``.

    ``turns`` may be negative, for a left turn; ``segments`` is the number of steps in each turn.
    """
    share = np.linspace(0.0, 1.0, max(1, math.ceil(abs(turns) * segments)) + 1)
    angle = math.tau * turns * share
    return np.stack([radius * np.sin(angle), height * share, radius * np.cos(angle)], axis=1)


# --- lengths and frames ----------------------------------------------------------------------------------------------


def lengths_to(points: FloatArray) -> FloatArray:
    """Return the length (N,) of a path up to each of its points."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def points_at(points: FloatArray, shares: FloatArray) -> FloatArray:
    """Return the points (T, D) of a path at shares (T,) of its length."""
    along = lengths_to(points)
    at = shares * along[-1]
    return np.stack([np.interp(at, along, coordinate) for coordinate in points.T], axis=1)


def upright_frames(directions: FloatArray) -> FloatArray:
    """Return rotations (T, 3, 3) whose z axes are the directions (T, 3) and whose y axes are as far up as possible.

    The axes are the columns. For a direction along the y axis of the scene, the x axis is that of the scene.
    """
    x = np.cross([0.0, 1.0, 0.0], directions)
    length = np.linalg.norm(x, axis=1, keepdims=True)
    x = np.where(length > 1e-9, x / np.maximum(length, 1e-9), [1.0, 0.0, 0.0])
    y = np.cross(directions, x)
    return np.stack([x, y / np.linalg.norm(y, axis=1, keepdims=True), directions], axis=2)


def turns_between(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the rotations (N, 3, 3) by the smallest angle that turn unit vectors (N, 3) into others.

    Two reflections: in the plane across ``a``, then in the one across ``a + b``. Opposite vectors have no such rotation
    and get one by half a turn.
    """
    middle = a + b
    length = np.linalg.norm(middle, axis=1, keepdims=True)
    side = np.cross(a, np.where(np.abs(a[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]]))
    middle = np.where(length > 1e-9, middle / np.maximum(length, 1e-9), side / np.linalg.norm(side, axis=1)[:, None])
    return np.asarray(_reflections(middle) @ _reflections(a), np.float64)


def _reflections(normals: FloatArray) -> FloatArray:
    """Return the Householder reflections (N, 3, 3) across planes with unit normals (N, 3)."""
    return np.asarray(np.eye(3) - 2.0 * normals[:, :, None] * normals[:, None, :], np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class PathFrames:
    """A path without repeated points, and the frames of its segments.

    Attributes
    ----------
    points : (N, 3)
    along : (N,)
        Length up to each point.
    axes : (N - 1, 3, 3)
        Axes x, y and z of each segment as columns; z is its direction.
    closed : bool
        Whether the last point is the first.
    roll : float
        Angle about z from the last frame, carried once around a closed path, to the first; 0 for an open one.
    """

    points: FloatArray
    along: FloatArray
    axes: FloatArray
    closed: bool
    roll: float

    @property
    def directions(self) -> FloatArray:
        """Unit vectors (N - 1, 3) along the segments."""
        return np.asarray(self.axes[:, :, 2], np.float64)

    def posed_at(self, shares: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points (T, 3) and frames (T, 3, 3) at shares (T,) of the length.

        On a curve the direction turns evenly between the points of the path; a corner belongs to the segment after it.
        The roll of a closed path is spread over its length.
        """
        at = shares * self.along[-1]
        which = np.clip(np.searchsorted(self.along, at, "right") - 1, 0, len(self.axes) - 1)
        length = np.diff(self.along)[which]
        part = np.clip((at - self.along[which]) / length, 0.0, 1.0)[:, None]
        points = self.points[which] * (1.0 - part) + self.points[which + 1] * part
        before, after = self._tangents()
        tangent = before[which] * (1.0 - part) + after[which] * part
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        frames = turns_between(self.directions[which], tangent) @ self.axes[which]
        return points, frames @ rolls(self.roll * shares)

    def _tangents(self) -> tuple[FloatArray, FloatArray]:
        """Return the directions (N - 1, 3) at the start and the end of each segment."""
        d = self.directions
        before, after = np.concatenate([d[-1:], d[:-1]]), np.concatenate([d[1:], d[:1]])
        starts, ends = _tangent(before, d, d), _tangent(d, after, d)
        if not self.closed:
            starts[0], ends[-1] = d[0], d[-1]
        return starts, ends


def _tangent(before: FloatArray, after: FloatArray, segment: FloatArray) -> FloatArray:
    """Return the direction halfway between two segments at a smooth joint, else that of ``segment``, one of the two."""
    middle = before + after
    is_smooth = np.sum(before * after, axis=1, keepdims=True) > math.cos(_MAX_SMOOTH_TURN)
    return np.where(is_smooth, middle / np.maximum(np.linalg.norm(middle, axis=1, keepdims=True), 1e-9), segment)


def rolls(angles: FloatArray) -> FloatArray:
    """Return the rotations (T, 3, 3) about z by angles (T,)."""
    c, s, zero = np.cos(angles), np.sin(angles), np.zeros_like(angles)
    rows = [np.stack(row, axis=-1) for row in ((c, -s, zero), (s, c, zero), (zero, zero, zero + 1.0))]
    return np.stack(rows, axis=-2)


def frames_of(points: FloatArray) -> PathFrames:
    """Return the rotation-minimizing frames of a path (N, 3) with at least two different points.

    The double reflection of Wang, Juettler, Zheng and Liu, "Computation of rotation minimizing frames" (2008), with the
    directions of the segments as tangents; for polygons this is the parallel transport of Bergou et al., "Discrete
    elastic rods" (2008), so that a mitered joint meets both of its segments, and ``along`` and ``sweep`` agree.
    """
    path = without_repeats(points)
    along = lengths_to(path)
    directions = np.diff(path, axis=0) / np.diff(along)[:, None]
    turns = turns_between(directions[:-1], directions[1:])
    axes = np.empty((len(directions), 3, 3))
    axes[0] = upright_frames(directions[:1])[0]
    for number, turn in enumerate(turns):
        axes[number + 1] = turn @ axes[number]
    axes[:, :, 2] = directions  # orthonormalize: rounding errors add up over many turns
    axes[:, :, 0] = np.cross(axes[:, :, 1], directions)
    axes[:, :, 0] /= np.linalg.norm(axes[:, :, 0], axis=1, keepdims=True)
    axes[:, :, 1] = np.cross(directions, axes[:, :, 0])
    closed = is_closed(path)
    return PathFrames(path, along, axes, closed, _roll(axes) if closed else 0.0)


def _roll(axes: FloatArray) -> float:
    """Return the angle about z from the last frame, turned at the joint to the first one, to the first frame."""
    carried = turns_between(axes[-1:, :, 2], axes[:1, :, 2])[0] @ axes[-1]
    return math.atan2(float(axes[0, :, 0] @ carried[:, 1]), float(axes[0, :, 0] @ carried[:, 0]))
