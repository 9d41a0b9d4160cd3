"""Affine poses as 12-tuples (see ``values.Matrix``), which for single poses cost a tenth of 4x4 numpy arrays.

Conventions: column vectors, right-handed frames, radians. ``compose(a, b)`` applies ``b`` first (docs/language.md,
"Geometry").
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain
from struct import pack_into
from typing import TYPE_CHECKING, Any

from scenelang.interpreter.loading import np
from scenelang.interpreter.values.values import Matrix

if TYPE_CHECKING:
    import numpy.typing as npt


Point = tuple[float, float, float]

AXES = ("x", "y", "z")  # of the world, in the order of coordinates


def translation(x: float, y: float, z: float) -> Matrix:
    """Return the translation by (x, y, z)."""
    return Matrix((1.0, 0.0, 0.0, float(x), 0.0, 1.0, 0.0, float(y), 0.0, 0.0, 1.0, float(z)))


def about(linear: Sequence[float], point: Sequence[float]) -> Matrix:
    """Return the pose with the 3x3 ``linear`` part (row-major) that maps ``point`` to itself."""
    a, b, c, d, e, f, g, h, i = linear
    x, y, z = point
    if x == y == z == 0.0:
        return Matrix((a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0))
    return Matrix((
        a, b, c, x - (a * x + b * y + c * z),
        d, e, f, y - (d * x + e * y + f * z),
        g, h, i, z - (g * x + h * y + i * z),
    ))  # fmt: skip


def rotation(angle: float, axis: Sequence[float], point: Sequence[float]) -> Matrix:
    """Return the right-handed rotation by ``angle`` radians about the ``axis`` through ``point``.

    Raises ValueError for a zero axis.
    """
    x, y, z = axis
    norm = math.sqrt(x * x + y * y + z * z)
    if norm == 0.0 or not math.isfinite(norm):
        raise ValueError("the rotation axis must be a finite non-zero vector")
    x, y, z = x / norm, y / norm, z / norm
    c, s = math.cos(angle), math.sin(angle)
    t = 1.0 - c  # Rodrigues' rotation formula
    return about(
        (t * x * x + c, t * x * y - s * z, t * x * z + s * y,
         t * x * y + s * z, t * y * y + c, t * y * z - s * x,
         t * x * z - s * y, t * y * z + s * x, t * z * z + c),
        point,
    )  # fmt: skip


EXACT = 1 << 53  # smaller integers are exact as floats


def exact_translation(x: Any, y: Any, z: Any) -> Matrix | None:
    """Return the translation by (x, y, z), or None unless these are finite floats or integers that floats can hold.

    Most poses of programs are translations, so this is written out for speed.
    """
    if type(x) is int and -EXACT < x < EXACT:
        x = float(x)
    if type(y) is int and -EXACT < y < EXACT:
        y = float(y)
    if type(z) is int and -EXACT < z < EXACT:
        z = float(z)
    if type(x) is float and type(y) is float and type(z) is float and math.isfinite(x + y + z):
        return Matrix((1.0, 0.0, 0.0, x, 0.0, 1.0, 0.0, y, 0.0, 0.0, 1.0, z))
    return None


def scaling(x: float, y: float, z: float, origin: Sequence[float]) -> Matrix:
    """Return the scaling by (x, y, z) that maps ``origin`` to itself."""
    return about((float(x), 0.0, 0.0, 0.0, float(y), 0.0, 0.0, 0.0, float(z)), origin)


def reflection(point: Sequence[float], normal: Sequence[float]) -> Matrix:
    """Return the reflection in the plane through ``point`` with ``normal``; raise ValueError for a zero normal."""
    x, y, z = normal
    norm = math.sqrt(x * x + y * y + z * z)
    if norm == 0.0 or not math.isfinite(norm):
        raise ValueError("the normal of a reflection must be a finite non-zero vector")
    x, y, z = x / norm, y / norm, z / norm
    return about(  # the Householder matrix I - 2 n n^T
        (1 - 2 * x * x, -2 * x * y, -2 * x * z,
         -2 * y * x, 1 - 2 * y * y, -2 * y * z,
         -2 * z * x, -2 * z * y, 1 - 2 * z * z),
        point,
    )  # fmt: skip


def facing(eye: Sequence[float], target: Sequence[float], up: Sequence[float]) -> Matrix:
    """Return the pose at ``eye`` whose +z axis points to ``target``, and whose +y axis is closest to ``up``.

    Raises ValueError if ``eye`` and ``target`` are equal, or if ``up`` is zero or points along the line between them.
    """
    z = _unit([b - a for a, b in zip(eye, target, strict=True)], "the eye and the target must be different points")
    x = _unit(_cross(_unit(up, "`up` must not be zero"), z), "`up` must not point to the target or away from it")
    y = _cross(z, x)
    rows = zip(x, y, z, map(float, eye), strict=True)
    return Matrix([entry for row in rows for entry in row])


def _cross(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """Return the cross product of two vectors."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


_MIN_LENGTH = 1e-12  # of a vector that has a direction; below it, rounding errors of its items decide


def _unit(vector: Sequence[float], problem: str) -> list[float]:
    """Return a vector scaled to length 1; raise ValueError with ``problem`` as message if it has no direction."""
    length = math.hypot(*vector)
    if not length > _MIN_LENGTH or not math.isfinite(length):
        raise ValueError(problem)
    return [entry / length for entry in vector]


def compose(m: Sequence[float], n: Sequence[float]) -> Matrix:
    """Return the product ``m n``, the pose that applies ``n`` first."""
    a0, a1, a2, a3, b0, b1, b2, b3, c0, c1, c2, c3 = m
    d0, d1, d2, d3, e0, e1, e2, e3, f0, f1, f2, f3 = n
    return Matrix((
        a0 * d0 + a1 * e0 + a2 * f0, a0 * d1 + a1 * e1 + a2 * f1,
        a0 * d2 + a1 * e2 + a2 * f2, a0 * d3 + a1 * e3 + a2 * f3 + a3,
        b0 * d0 + b1 * e0 + b2 * f0, b0 * d1 + b1 * e1 + b2 * f1,
        b0 * d2 + b1 * e2 + b2 * f2, b0 * d3 + b1 * e3 + b2 * f3 + b3,
        c0 * d0 + c1 * e0 + c2 * f0, c0 * d1 + c1 * e1 + c2 * f1,
        c0 * d2 + c1 * e2 + c2 * f2, c0 * d3 + c1 * e3 + c2 * f3 + c3,
    ))  # fmt: skip


def products(m: Sequence[float], poses: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return ``compose`` of a pose with each of N poses (N, 12), equal to the last bit."""
    out = np.empty_like(poses)
    with np.errstate(over="ignore", invalid="ignore"):  # the caller tests the products
        for row in range(0, 12, 4):
            entries = m[row] * poses[:, 0:4] + m[row + 1] * poses[:, 4:8] + m[row + 2] * poses[:, 8:12]
            entries[:, 3] += m[row + 3]
            out[:, row : row + 4] = entries
    return out


def apply(m: Sequence[float], p: Sequence[float]) -> Point:
    """Return the point ``m p``."""
    x, y, z = p
    return (
        m[0] * x + m[1] * y + m[2] * z + m[3],
        m[4] * x + m[5] * y + m[6] * z + m[7],
        m[8] * x + m[9] * y + m[10] * z + m[11],
    )


def to_array(m: Sequence[float]) -> npt.NDArray[np.float64]:
    """Convert a pose to a 4x4 array."""
    return np.array([*m, 0.0, 0.0, 0.0, 1.0]).reshape(4, 4)


_STACKED = 256  # poses that are arguments of one call: .25 us a pose; ``np.fromiter`` takes .37 us, 8,192 at once .35


def packed(poses: Sequence[Sequence[float]]) -> bytearray:
    """Return the numbers of K poses, 96 bytes each; ``array.extend`` takes four times as long."""
    out = bytearray(96 * len(poses))
    for low in range(0, len(poses), _STACKED):
        piece = poses[low : low + _STACKED]
        pack_into(f"{12 * len(piece)}d", out, 96 * low, *chain.from_iterable(piece))
    return out


def stacked(poses: Sequence[Sequence[float]]) -> npt.NDArray[np.float64]:
    """Return K poses as an array (K, 12), eight times as fast as ``np.array``, which inspects each ``Matrix``."""
    return np.frombuffer(packed(poses)).reshape(-1, 12)


def from_array(a: npt.NDArray[np.float64]) -> Matrix | None:
    """Convert a 4x4 array to a pose, or return None if its last row is not 0 0 0 1."""
    if a.shape != (4, 4) or a[3].tolist() != [0, 0, 0, 1]:
        return None
    return Matrix(a[:3].astype(float).ravel().tolist())


def is_finite(m: Sequence[float]) -> bool:
    """Return whether all entries are finite."""
    return math.isfinite(sum(m)) or all(map(math.isfinite, m))  # a finite sum rules out inf and nan in one check
