"""Rays against the canonical solids (see ``solids``): all are convex, so a ray meets each in one interval.

``o`` and ``d`` are tuples of three arrays (or floats) that broadcast: origin and direction in the solid's own frame,
where ``d`` is never zero. Arithmetic runs into infinities on purpose: callers hold ``numpy.errstate(all="ignore")``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.solids import Form

Triple = tuple[Any, Any, Any]
FloatArray = npt.NDArray[np.floating]
Interval = tuple[FloatArray, FloatArray]

_TINY = 1e-200
_SEAM = 1e-9  # by which triangles overlap, so that no ray passes between neighbours


def interval(form: int, o: Triple, d: Triple) -> Interval:
    """The ray parameters where the ray enters and leaves; the first is above the second where it misses."""
    if form == Form.BALL:
        return _ball(o, d)
    if form == Form.BLOCK:
        return _block(o, d)
    if form == Form.CYLINDER:
        return _cylinder(o, d)
    if form == Form.CONE:
        return _cone(o, d)
    return _triangle(o, d)


def first_hit(form: int, o: Triple, d: Triple, near: float) -> FloatArray:
    """The first ray parameter above ``near`` on the surface, infinity where there is none."""
    enter, leave = interval(form, o, d)
    hit = np.where(enter > near, enter, leave)
    return np.where((enter <= leave) & (hit > near), hit, np.inf)


def _quadratic(a: Any, b: Any, c: Any) -> tuple[Any, Any, Any]:
    """The roots of a t^2 + 2 b t + c, smaller first, without cancellation, and the discriminant / 4."""
    discriminant = b * b - a * c
    q = -(b + np.copysign(np.sqrt(np.maximum(discriminant, 0.0)), b))
    q = np.where(q == 0.0, _TINY, q)
    first, second = q / a, c / q
    return np.minimum(first, second), np.maximum(first, second), discriminant


def _ball(o: Triple, d: Triple) -> Interval:
    a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    b = o[0] * d[0] + o[1] * d[1] + o[2] * d[2]
    c = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - 1.0
    root = np.sqrt(b * b - a * c)  # nan where the ray misses, and comparisons with nan are false
    return (-b - root) / a, (root - b) / a


def _slab(o: Any, d: Any) -> tuple[Any, Any]:
    inverse = 1.0 / np.where(np.abs(d) < _TINY, _TINY, d)
    first, second = (-1.0 - o) * inverse, (1.0 - o) * inverse
    return np.minimum(first, second), np.maximum(first, second)


def _block(o: Triple, d: Triple) -> Interval:
    x0, x1 = _slab(o[0], d[0])
    y0, y1 = _slab(o[1], d[1])
    z0, z1 = _slab(o[2], d[2])
    return np.maximum(np.maximum(x0, y0), z0), np.minimum(np.minimum(x1, y1), z1)


def _cylinder(o: Triple, d: Triple) -> Interval:
    a = np.maximum(d[0] * d[0] + d[2] * d[2], _TINY)
    b = o[0] * d[0] + o[2] * d[2]
    c = o[0] * o[0] + o[2] * o[2] - 1.0
    root = np.sqrt(b * b - a * c)
    y0, y1 = _slab(o[1], d[1])
    return np.maximum((-b - root) / a, y0), np.minimum((root - b) / a, y1)


def _cone(o: Triple, d: Triple) -> Interval:
    radius, growth = 0.5 - 0.5 * o[1], -0.5 * d[1]  # of the cone at the height of o, and its change along the ray
    a = d[0] * d[0] + d[2] * d[2] - growth * growth
    a = np.where(np.abs(a) < _TINY, _TINY, a)
    b = o[0] * d[0] + o[2] * d[2] - radius * growth
    c = o[0] * o[0] + o[2] * o[2] - radius * radius
    low, high, discriminant = _quadratic(a, b, c)
    # a < 0: the ray is inside both nappes outside the roots; the lower nappe lies where the radius grows
    steep = a < 0.0
    enter = np.where(steep, np.where(growth > 0.0, high, -np.inf), np.where(discriminant < 0.0, np.inf, low))
    leave = np.where(steep, np.where(growth > 0.0, np.inf, low), high)
    y0, y1 = _slab(o[1], d[1])
    return np.maximum(enter, y0), np.minimum(leave, y1)


def _triangle(o: Triple, d: Triple) -> Interval:
    t = -o[2] / np.where(np.abs(d[2]) < _TINY, _TINY, d[2])
    x, y = o[0] + t * d[0], o[1] + t * d[1]
    inside = (x >= -1.0 - _SEAM) & (y >= -1.0 - _SEAM) & (x + y <= _SEAM)
    return np.where(inside, t, np.inf), np.where(inside, t, -np.inf)


def normals(form: int, p: FloatArray) -> FloatArray:
    """Outward normals (N, 3), of any length, at surface points ``p`` (N, 3), in the solid's own frame."""
    n = np.zeros_like(p)
    if form == Form.BALL:
        return p
    if form == Form.BLOCK:
        axis = np.argmax(np.abs(p), axis=1)
        rows = np.arange(len(p))
        n[rows, axis] = np.sign(p[rows, axis])
    elif form == Form.CYLINDER:
        cap = np.abs(p[:, 1]) > np.hypot(p[:, 0], p[:, 2])
        n[:, 0], n[:, 2] = np.where(cap, 0.0, p[:, 0]), np.where(cap, 0.0, p[:, 2])
        n[:, 1] = np.where(cap, p[:, 1], 0.0)
    elif form == Form.CONE:
        _cone_normals(p, n)
    else:
        n[:, 2] = 1.0
    return n


def _cone_normals(p: FloatArray, n: FloatArray) -> None:
    radius = np.hypot(p[:, 0], p[:, 2])
    base = np.abs(p[:, 1] + 1.0) < np.abs(0.5 - 0.5 * p[:, 1] - radius)
    scale = np.where(base, 0.0, 1.0 / np.maximum(radius, 1e-12))
    n[:, 0], n[:, 2] = p[:, 0] * scale, p[:, 2] * scale
    n[:, 1] = np.where(base, -1.0, 0.5)
