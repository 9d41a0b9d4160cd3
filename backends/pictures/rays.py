"""The analytic ray caster: which solid every sample of a picture sees, and how far away (numpy only).

Solids are tested only inside their bounding rectangles on the picture: large ones one at a time over their rectangle,
small ones in batches over all their samples at once. Each sample holds one 64-bit key, the distance's float32 bits
above the solid's number, so that the nearest hit is a minimum, and equal distances have one winner.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.solids import SolidForm, Solids, inverses_of
from scenelang.backends.pictures.camera import Camera

# Rays against the canonical solids (see ``solids``): all are convex, so a ray meets each in one interval.
#
# ``o`` and ``d`` are tuples of three arrays (or floats) that broadcast: origin and direction in the solid's own frame,
# where ``d`` is never zero. Arithmetic runs into infinities on purpose: callers hold ``numpy.errstate(all="ignore")``.


Triple = tuple[Any, Any, Any]
AnyFloatArray = npt.NDArray[np.floating]
Interval = tuple[AnyFloatArray, AnyFloatArray]

_TINY = 1e-200
_SEAM = 1e-9  # by which triangles overlap, so that no ray passes between neighbours


def interval(form: int, o: Triple, d: Triple) -> Interval:
    """The ray parameters where the ray enters and leaves; the first is above the second where it misses."""
    if form == SolidForm.BALL:
        return _ball(o, d)
    if form == SolidForm.BLOCK:
        return _block(o, d)
    if form == SolidForm.CYLINDER:
        return _cylinder(o, d)
    if form == SolidForm.CONE:
        return _cone(o, d)
    return _triangle(o, d)


def first_hit(form: int, o: Triple, d: Triple, near: float) -> AnyFloatArray:
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


def normals(form: int, p: AnyFloatArray) -> AnyFloatArray:
    """Outward normals (N, 3), of any length, at surface points ``p`` (N, 3), in the solid's own frame."""
    n = np.zeros_like(p)
    if form == SolidForm.BALL:
        return p
    if form == SolidForm.BLOCK:
        axis = np.argmax(np.abs(p), axis=1)
        rows = np.arange(len(p))
        n[rows, axis] = np.sign(p[rows, axis])
    elif form == SolidForm.CYLINDER:
        cap = np.abs(p[:, 1]) > np.hypot(p[:, 0], p[:, 2])
        n[:, 0], n[:, 2] = np.where(cap, 0.0, p[:, 0]), np.where(cap, 0.0, p[:, 2])
        n[:, 1] = np.where(cap, p[:, 1], 0.0)
    elif form == SolidForm.CONE:
        _cone_normals(p, n)
    else:
        n[:, 2] = 1.0
    return n


def _cone_normals(p: AnyFloatArray, n: AnyFloatArray) -> None:
    radius = np.hypot(p[:, 0], p[:, 2])
    base = np.abs(p[:, 1] + 1.0) < np.abs(0.5 - 0.5 * p[:, 1] - radius)
    scale = np.where(base, 0.0, 1.0 / np.maximum(radius, 1e-12))
    n[:, 0], n[:, 2] = p[:, 0] * scale, p[:, 2] * scale
    n[:, 1] = np.where(base, -1.0, 0.5)


FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Keys = npt.NDArray[np.uint64]

NEAR = 1e-5  # nothing nearer to the eye is seen; the scene's half diagonal is 1
NOTHING = np.uint64(0xFFFFFFFFFFFFFFFF)
_SMALL = 900  # samples in a rectangle below which solids are cast in batches
_BATCH = 1 << 16
_BLOCK = 1 << 15
_SHIFT = np.uint64(32)

_CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
_EDGES = np.array([(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit])
_HULLS = {
    SolidForm.BALL: _CUBE,
    SolidForm.BLOCK: _CUBE,
    SolidForm.CYLINDER: _CUBE,
    SolidForm.CONE: np.array([[-1.0, -1, -1], [1, -1, -1], [-1, -1, 1], [1, -1, 1], [0, 1, 0]]),
    SolidForm.TRIANGLE: np.array([[-1.0, -1, 0], [1, -1, 0], [-1, 1, 0]]),
}


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """One ray per sample of a picture of ``width`` x ``height`` samples; row 0 is at the top.

    Sample (column, row) has its centre at x = column + 1/2, y = row + 1/2; its ray starts at ``origin[0] + x origin[1]
    + y origin[2]`` and runs along ``direction[0] + x direction[1] + y direction[2]``; both (3, 3). Along ``axes[2]``
    (rows right, up, forward) every direction has length 1, so that ray parameters are depths from ``eye``. ``focal``
    and ``principal`` are the camera's, in samples.
    """

    width: int
    height: int
    eye: FloatArray
    axes: FloatArray
    focal: tuple[float, float]
    principal: tuple[float, float]
    origin: FloatArray
    direction: FloatArray
    parallel: bool

    def at(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Origins and directions (N, 3) at picture positions (N,)."""
        o, d = self.origin, self.direction
        if self.parallel:
            return o[0] + x[:, None] * o[1] + y[:, None] * o[2], np.broadcast_to(d[0], (len(x), 3))
        return np.broadcast_to(o[0], (len(x), 3)), d[0] + x[:, None] * d[1] + y[:, None] * d[2]


def camera_rays(camera: Camera, samples: int = 1) -> Rays:
    """The rays of ``camera``, ``samples`` per pixel in each direction."""
    (fx, fy), (cx, cy) = camera.focal, camera.principal
    focal, principal = (fx * samples, fy * samples), (cx * samples, cy * samples)
    size = camera.width * samples, camera.height * samples
    return _rays(camera.eye, camera.axes, focal, principal, size, camera.is_parallel)


def parallel_rays(center: FloatArray, axes: FloatArray, half: float, size: int) -> Rays:
    """Parallel rays along ``axes[2]`` through the square of half width ``half`` about ``center``; size x size."""
    focal, middle = size / (2.0 * half), size / 2.0
    return _rays(center, axes, (focal, focal), (middle, middle), (size, size), True)


def _rays(
    eye: FloatArray,
    axes: FloatArray,
    focal: tuple[float, float],
    principal: tuple[float, float],
    size: tuple[int, int],
    parallel: bool,
) -> Rays:
    right, up, forward = axes
    across, down = right / focal[0], -up / focal[1]
    plane = np.stack([-principal[0] * across - principal[1] * down, across, down])  # at depth 1 of a perspective view
    still = np.zeros((3, 3))
    still[0] = forward if parallel else eye
    moving = plane.copy()
    moving[0] += eye if parallel else forward
    origin, direction = (moving, still) if parallel else (still, moving)
    return Rays(*size, eye, axes, focal, principal, origin, direction, parallel)


@dataclass(frozen=True, slots=True, eq=False)
class Caster:
    """Solids prepared for rays: ``inverse`` (N, 3, 3) and ``center`` (N, 3) take world points into the solids' frames;
    the solids' rectangles on the picture are columns [x0, x1) and rows [y0, y1), empty where out of view."""

    rays: Rays
    forms: npt.NDArray[np.int8]
    inverse: FloatArray
    center: FloatArray
    rectangles: IntArray  # (N, 4): x0, y0, x1, y1
    nearest: FloatArray  # (N,) a lower bound of each solid's depth

    def cast(
        self,
        which: npt.NDArray[np.bool_] | None = None,
        beyond: Keys | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Keys:
        """Keys (height, width) of the first hits among the solids ``which``, or NOTHING.

        With ``beyond``, of the first hits whose key is above the one there, which peels layer after layer.
        """
        keys = np.full((self.rays.height, self.rays.width), NOTHING, np.uint64)
        x0, y0, x1, y1 = self.rectangles.T
        area = (x1 - x0) * (y1 - y0)
        chosen = area > 0 if which is None else (area > 0) & which
        large = np.flatnonzero(chosen & (area > _SMALL))
        large = large[np.argsort(self.nearest[large], kind="stable")]  # so that what is hidden can be passed over
        done, total = 0.0, max(1.0, float(area[chosen].sum()))
        with np.errstate(all="ignore"):
            for i in large:
                self._cast_large(int(i), keys, beyond)
                done += float(area[i])
                if progress is not None:
                    progress(done / total)
            for form in SolidForm:
                small = np.flatnonzero(chosen & (area <= _SMALL) & (self.forms == form))
                for batch in _batches(small, area):
                    self._cast_batch(form, batch, keys, beyond)
                    done += float(area[batch].sum())
                    if progress is not None:
                        progress(done / total)
        return keys

    def _local_rays(self, which: IntArray) -> tuple[FloatArray, FloatArray]:
        """Coefficients (K, 3, 3) of origin and direction in the solids' frames; [:, 0] is at the rectangle's corner
        sample, [:, 1] and [:, 2] change per column and row."""
        rays, inverse = self.rays, self.inverse[which]
        x = self.rectangles[which, 0, None] + 0.5
        y = self.rectangles[which, 1, None] + 0.5
        origin = np.empty((len(which), 3, 3))
        direction = np.empty((len(which), 3, 3))
        origin[:, 0] = rays.origin[0] - self.center[which]
        direction[:, 0] = rays.direction[0]
        if rays.parallel:
            origin[:, 0] += x * rays.origin[1] + y * rays.origin[2]
        else:
            direction[:, 0] += x * rays.direction[1] + y * rays.direction[2]
        origin[:, 1:], direction[:, 1:] = rays.origin[1:], rays.direction[1:]
        transposed = np.swapaxes(inverse, 1, 2)
        return origin @ transposed, direction @ transposed

    def _cast_large(self, i: int, keys: Keys, beyond: Keys | None) -> None:
        x0, y0, x1, y1 = (int(edge) for edge in self.rectangles[i])
        origin, direction = (c[0] for c in self._local_rays(np.array([i])))
        columns = np.arange(x1 - x0, dtype=np.float64)[None, :]
        hidden = _keys_of(np.array([max(0.0, float(self.nearest[i])) * (1.0 - 1e-6)]), np.uint64(0))[0]
        step = max(1, _BLOCK // (x1 - x0))
        for top in range(y0, y1, step):
            bottom = min(y1, top + step)
            rows = np.arange(top - y0, bottom - y0, dtype=np.float64)[:, None]
            o, d = origin[0], direction[0]
            if self.rays.parallel:
                o = [origin[0, k] + columns * origin[1, k] + rows * origin[2, k] for k in range(3)]
            else:
                d = [direction[0, k] + columns * direction[1, k] + rows * direction[2, k] for k in range(3)]
            part = keys[top:bottom, x0:x1]
            if part.max() < hidden:
                continue
            t = first_hit(int(self.forms[i]), (o[0], o[1], o[2]), (d[0], d[1], d[2]), NEAR)
            found = _keys_of(t, np.uint64(i))
            if beyond is not None:
                found = np.where(found > beyond[top:bottom, x0:x1], found, NOTHING)
            np.minimum(part, found, out=part)

    def _cast_batch(self, form: int, batch: IntArray, keys: Keys, beyond: Keys | None) -> None:
        x0, y0, x1, y1 = self.rectangles[batch].T
        width = x1 - x0
        area = width * (y1 - y0)
        owner = np.repeat(np.arange(len(batch)), area)
        within = np.arange(len(owner)) - np.repeat(np.cumsum(area) - area, area)
        row, column = np.divmod(within, width[owner])
        pixel = (row + y0[owner]) * self.rays.width + column + x0[owner]
        origin, direction = self._local_rays(batch)
        o: list[FloatArray] = []
        d: list[FloatArray] = []
        for k in range(3):
            for out, c, moves in ((o, origin, self.rays.parallel), (d, direction, not self.rays.parallel)):
                value = c[:, 0, k][owner]
                if moves:
                    value = value + column * c[:, 1, k][owner] + row * c[:, 2, k][owner]
                out.append(value)
        t = first_hit(form, (o[0], o[1], o[2]), (d[0], d[1], d[2]), NEAR)
        hit = np.flatnonzero(t < np.inf)
        found = _keys_of(t[hit], batch[owner[hit]].astype(np.uint64))
        pixel = pixel[hit]
        if beyond is not None:
            kept = found > beyond.reshape(-1)[pixel]
            found, pixel = found[kept], pixel[kept]
        np.minimum.at(keys.reshape(-1), pixel, found)

    def surface(self, ids: IntArray, points: FloatArray, toward: FloatArray) -> FloatArray:
        """Unit normals (N, 3) of the solids ``ids`` at the world ``points`` (N, 3), turned against ``toward``."""
        out = np.zeros_like(points)
        inverse = self.inverse[ids]
        local = np.einsum("nij,nj->ni", inverse, points - self.center[ids])
        forms = self.forms[ids]
        for form in np.unique(forms):
            rows = np.flatnonzero(forms == form)
            out[rows] = np.einsum("nji,nj->ni", inverse[rows], normals(int(form), local[rows]))
        length = np.sqrt(np.einsum("ni,ni->n", out, out))
        away = np.einsum("ni,ni->n", out, toward) > 0.0
        sign = np.where(away, -1.0, 1.0)
        return out * (sign / np.where(length > 0.0, length, 1.0))[:, None]


def depths_of(keys: Keys) -> npt.NDArray[np.float32]:
    """The depths in ``keys``, infinity where there is nothing."""
    depth = (keys >> _SHIFT).astype(np.uint32).view(np.float32)
    return np.where(keys == NOTHING, np.float32(np.inf), depth)


def ids_of(keys: Keys) -> IntArray:
    """The solids' numbers in ``keys``, -1 where there is nothing."""
    return np.where(keys == NOTHING, -1, (keys & np.uint64(0xFFFFFFFF)).astype(np.int64))


def caster_for(solids: Solids, rays: Rays) -> Caster:
    """Prepare ``solids``, whose poses are invertible, for ``rays``."""
    with np.errstate(all="ignore"):
        inverse = inverses_of(solids.matrices[:, :, :3])
        rectangles = _rectangles(solids, rays)
        forward = rays.axes[2]
        depth = (solids.matrices[:, :, 3] - rays.eye) @ forward
        nearest = depth - np.abs(forward @ solids.matrices[:, :, :3]).sum(axis=1)
    return Caster(rays, solids.forms, inverse, solids.matrices[:, :, 3], rectangles, nearest)


def _keys_of(t: npt.NDArray[np.floating], number: npt.NDArray[np.uint64] | np.uint64) -> Keys:
    near = t.astype(np.float32)
    key = (near.view(np.uint32).astype(np.uint64) << _SHIFT) | number
    return np.where(near < np.inf, key, NOTHING)


def _batches(which: IntArray, area: IntArray) -> list[IntArray]:
    """``which`` cut so that each piece covers about ``_BATCH`` samples."""
    if not len(which):
        return []
    ends = np.cumsum(area[which])
    cuts = np.searchsorted(ends, np.arange(_BATCH, int(ends[-1]), _BATCH))
    return [piece for piece in np.split(which, np.unique(cuts)) if len(piece)]


# --- rectangles ------------------------------------------------------------------------------------------------


def _rectangles(solids: Solids, rays: Rays) -> IntArray:
    """The samples (N, 4) that each solid may cover, cut to the picture."""
    low = np.full((len(solids), 2), np.inf)
    high = np.full((len(solids), 2), -np.inf)
    linear = rays.axes @ solids.matrices[:, :, :3]
    center = (solids.matrices[:, :, 3] - rays.eye) @ rays.axes.T
    for form in SolidForm:
        rows = np.flatnonzero(solids.forms == form)
        for start in range(0, len(rows), _BATCH):
            part = rows[start : start + _BATCH]
            if rays.parallel:
                low[part], high[part] = _parallel_bounds(form, linear[part], center[part])
            else:
                low[part], high[part] = _perspective_bounds(form, linear[part], center[part])
    size = np.array([rays.width, rays.height], np.float64)
    first, last = low * rays.focal + rays.principal, high * rays.focal + rays.principal
    up = np.array(rays.principal)[1] * 2.0
    first[:, 1], last[:, 1] = up - last[:, 1], up - first[:, 1].copy()
    empty = ~(low <= high).all(axis=1)
    first[empty], last[empty] = 0.0, 0.0
    # a sample counts when its centre, at column + 1/2, may be covered
    low_edge = np.ceil(np.clip(np.nan_to_num(first - 0.5001, nan=0.0), 0.0, size)).astype(np.int64)
    high_edge = np.floor(np.clip(np.nan_to_num(last - 0.4999, nan=0.0), -1.0, size - 1.0)).astype(np.int64) + 1
    out = np.concatenate([low_edge, np.maximum(high_edge, low_edge)], axis=1)
    out[empty] = 0
    return out


def _parallel_bounds(form: SolidForm, linear: FloatArray, center: FloatArray) -> tuple[FloatArray, FloatArray]:
    if form == SolidForm.BALL:
        reach = np.sqrt(np.einsum("nij,nij->ni", linear, linear))[:, :2]
        return center[:, :2] - reach, center[:, :2] + reach
    points = np.einsum("nij,kj->nki", linear[:, :2], _HULLS[form]) + center[:, None, :2]
    return points.min(axis=1), points.max(axis=1)


def _perspective_bounds(form: SolidForm, linear: FloatArray, center: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bounds (K, 2) at depth 1 of what lies before the near plane; empty (low > high) where nothing does."""
    points = np.einsum("nij,kj->nki", linear, _HULLS[form]) + center[:, None, :]
    depth = points[:, :, 2]
    before = depth.min(axis=1) > NEAR
    flat = points[:, :, :2] / depth[:, :, None]
    low, high = flat.min(axis=1), flat.max(axis=1)
    crossing = np.flatnonzero(~before)
    if len(crossing):
        low[crossing], high[crossing] = _clipped_bounds(linear[crossing], center[crossing])
    if form == SolidForm.BALL:
        rows = np.flatnonzero(before)
        low[rows], high[rows] = _ball_bounds(linear[rows], center[rows])
    return low, high


def _clipped_bounds(linear: FloatArray, center: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bounds of the posed cube [-1, 1]^3 cut at the near plane."""
    points = np.einsum("nij,kj->nki", linear, _CUBE) + center[:, None, :]
    a, b = points[:, _EDGES[:, 0]], points[:, _EDGES[:, 1]]
    share = (NEAR - a[:, :, 2]) / (b[:, :, 2] - a[:, :, 2])
    cut = a + np.clip(np.nan_to_num(share), 0.0, 1.0)[:, :, None] * (b - a)
    crosses = (a[:, :, 2] > NEAR) != (b[:, :, 2] > NEAR)
    every = np.concatenate([points, cut], axis=1)
    valid = np.concatenate([points[:, :, 2] > NEAR, crosses], axis=1)[:, :, None]
    flat = every[:, :, :2] / np.where(valid, np.maximum(every[:, :, 2:], 0.5 * NEAR), 1.0)
    return np.where(valid, flat, np.inf).min(axis=1), np.where(valid, flat, -np.inf).max(axis=1)


def _ball_bounds(linear: FloatArray, center: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The exact bounds of ellipsoids before the eye, by the dual conic ``A A' - t t'`` of their outlines."""
    conic = linear @ np.swapaxes(linear, 1, 2) - center[:, :, None] * center[:, None, :]
    scale = conic[:, 2, 2]
    diagonal = np.stack([conic[:, 0, 0], conic[:, 1, 1]], axis=1)
    mixed = conic[:, :2, 2]
    root = np.sqrt(np.maximum(mixed * mixed - diagonal * scale[:, None], 0.0))
    first, second = (mixed - root) / scale[:, None], (mixed + root) / scale[:, None]
    return np.minimum(first, second), np.maximum(first, second)
