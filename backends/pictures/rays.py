"""Analytic ray caster: which solid each sample of a picture sees, and at what depth (numpy only).

Solids are tested only inside their bounding rectangles on the picture: large ones individually over their rectangle,
small ones in batches over all their samples at once. Each sample stores a 64-bit key, the depth's float32 bits above
the solid's index, so that the nearest hit is the minimum and ties are broken deterministically.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.solids import PosedForms
from scenelang.backends.pictures.camera import Camera
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Ratios, Triple, box_corners, first_hits
from scenelang.interpreter.scene.primitives.mesh import inverses_of

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Keys = npt.NDArray[np.uint64]

NEAR = 1e-5  # near clipping plane; the scene's half diagonal is 1
NOTHING = np.uint64(0xFFFFFFFFFFFFFFFF)
_SMALL = 900  # rectangle size in samples below which solids are cast in batches
_BATCH = 1 << 16
_BLOCK = 1 << 15
_SHIFT = np.uint64(32)

_CUBE = box_corners((1.0, 1.0, 1.0))
_EDGES = np.array([(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit])


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """One ray per sample of a picture of ``width`` x ``height`` samples; row 0 is at the top.

    Sample (column, row) has its centre at x = column + 1/2, y = row + 1/2; its ray starts at ``origin[0] + x origin[1]
    + y origin[2]`` in the direction ``direction[0] + x direction[1] + y direction[2]``; both (3, 3). The component of
    every direction along ``axes[2]`` (rows right, up, forward) is 1, so that ray parameters are depths from ``eye``.
    ``focal`` and ``principal`` are the camera's, in samples.
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
        """Return the origins and directions (N, 3) of rays at picture positions (N,)."""
        o, d = self.origin, self.direction
        if self.parallel:
            return o[0] + x[:, None] * o[1] + y[:, None] * o[2], np.broadcast_to(d[0], (len(x), 3))
        return np.broadcast_to(o[0], (len(x), 3)), d[0] + x[:, None] * d[1] + y[:, None] * d[2]


def camera_rays(camera: Camera, samples: int = 1) -> Rays:
    """Return the rays of ``camera``, with ``samples`` per pixel and axis."""
    (fx, fy), (cx, cy) = camera.focal, camera.principal
    focal, principal = (fx * samples, fy * samples), (cx * samples, cy * samples)
    size = camera.width * samples, camera.height * samples
    return _rays(camera.eye, camera.axes, focal, principal, size, camera.is_parallel)


def parallel_rays(center: FloatArray, axes: FloatArray, half: float, size: int) -> Rays:
    """Return size x size parallel rays along ``axes[2]`` through the square of half width ``half`` around
    ``center``."""
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
    """Solids prepared for ray casting.

    ``inverse`` (N, 3, 3) and ``center`` (N, 3) transform world points into the solids' frames. ``rectangles`` bound the
    solids on the picture: columns [x0, x1) and rows [y0, y1), empty if out of view.
    """

    rays: Rays
    solids: PosedForms
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
        """Return the keys (height, width) of the first hits among the solids ``which``, NOTHING for misses.

        With ``beyond``, only hits with keys above those in ``beyond`` count, which implements depth peeling.
        """
        keys = np.full((self.rays.height, self.rays.width), NOTHING, np.uint64)
        x0, y0, x1, y1 = self.rectangles.T
        area = (x1 - x0) * (y1 - y0)
        chosen = area > 0 if which is None else (area > 0) & which
        large = np.flatnonzero(chosen & (area > _SMALL))
        # front to back, so that occluded blocks can be skipped
        large = large[np.argsort(self.nearest[large], kind="stable")]
        done, total = 0.0, max(1.0, float(area[chosen].sum()))
        with np.errstate(all="ignore"):
            for i in large:
                self._cast_large(int(i), keys, beyond)
                done += float(area[i])
                if progress is not None:
                    progress(done / total)
            for form, small in self.solids.groups(chosen & (area <= _SMALL)):
                for batch in _batches(small, area):
                    self._cast_batch(form, batch, keys, beyond)
                    done += float(area[batch].sum())
                    if progress is not None:
                        progress(done / total)
        return keys

    def _local_rays(self, which: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return coefficients (K, 3, 3) of ray origins and directions in the solids' frames.

        [:, 0] is the ray of the rectangle's first sample, [:, 1] and [:, 2] are the changes per column and row.
        """
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
        form, ratios = self.solids.form(i)
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
            for t in _hits(form, (o[0], o[1], o[2]), (d[0], d[1], d[2]), ratios):
                found = _keys_of(t, np.uint64(i))
                if beyond is not None:
                    found = np.where(found > beyond[top:bottom, x0:x1], found, NOTHING)
                np.minimum(part, found, out=part)

    def _cast_batch(self, form: CanonicalForm, batch: IntArray, keys: Keys, beyond: Keys | None) -> None:
        _, owner, pixel, o, d = self._batch_rays(batch)
        ratios = self._shape_ratios(form, batch, owner)
        for t in _hits(form, (o[0], o[1], o[2]), (d[0], d[1], d[2]), ratios):
            hit = np.flatnonzero(t < np.inf)
            found, at = _keys_of(t[hit], batch[owner[hit]].astype(np.uint64)), pixel[hit]
            if beyond is not None:
                kept = found > beyond.reshape(-1)[at]
                found, at = found[kept], at[kept]
            np.minimum.at(keys.reshape(-1), at, found)

    def _shape_ratios(self, form: CanonicalForm, batch: IntArray, owner: IntArray) -> Ratios:
        """Return the ratios that the shape depends on, for each ray of a batch."""
        count = form.ratios - form.shading_ratios
        return tuple(ratio[owner] for ratio in self.solids.ratios_of(form, batch)[:count]) if count else ()

    def _batch_rays(self, batch: IntArray) -> tuple[int, IntArray, IntArray, list[FloatArray], list[FloatArray]]:
        """Return the rays of all samples in the rectangles of a batch, in the frames of its solids.

        Their number, the position in ``batch`` and the sample (N,) of each, and the coordinates of origins and
        directions.
        """
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
        return len(owner), owner, pixel, o, d

    def covered(self, owner: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
        """Yield owners and the numbers of samples that each owner's solids cover, whatever is before them.

        ``owner`` (N,) is the owner of each solid, negative for none. Owners are distinct within and between yields.
        """
        x0, y0, x1, y1 = self.rectangles.T
        area = (x1 - x0) * (y1 - y0)
        rows = np.flatnonzero((area > 0) & (owner >= 0))
        rows = rows[np.argsort(owner[rows], kind="stable")]
        start = 0
        with np.errstate(all="ignore"):
            while start < len(rows):  # whole owners at a time, of as many samples as fit a batch
                end = int(np.searchsorted(np.cumsum(area[rows[start:]]), 16 * _BATCH, side="right")) + start
                last = owner[rows[min(max(end, start + 1), len(rows)) - 1]]
                end = int(np.searchsorted(owner[rows], last, side="right"))
                yield self._covered(rows[start:end], owner)
                start = end

    def _covered(self, rows: IntArray, owner: IntArray) -> tuple[IntArray, IntArray]:
        owners, which = np.unique(owner[rows], return_inverse=True)
        number = np.zeros(len(owner), np.int64)
        number[rows] = which
        size = self.rays.width * self.rays.height
        pairs = np.zeros(0, np.int64)
        chosen = np.zeros(len(owner), bool)
        chosen[rows] = True
        x0, y0, x1, y1 = self.rectangles.T
        for form, mine in self.solids.groups(chosen):
            for batch in _batches(mine, (x1 - x0) * (y1 - y0)):
                pixel, solid = self._hit_samples(form, batch)
                pairs = np.union1d(pairs, number[solid] * size + pixel)
        return owners, np.bincount(pairs // size, minlength=len(owners))

    def _hit_samples(self, form: CanonicalForm, batch: IntArray) -> tuple[IntArray, IntArray]:
        """Return the samples that the solids of a batch cover, and the solid that covers each."""
        at, owner, pixel, o, d = self._batch_rays(batch)
        ratios = self._shape_ratios(form, batch, owner)
        hit = np.zeros(at, bool)
        for t in _hits(form, (o[0], o[1], o[2]), (d[0], d[1], d[2]), ratios):
            hit |= t < np.inf
        return pixel[hit], batch[owner[hit]]

    def surface(self, ids: IntArray, points: FloatArray, toward: FloatArray) -> FloatArray:
        """Return unit normals (N, 3) of the solids ``ids`` at world ``points`` (N, 3), flipped to face against
        ``toward``."""
        out = np.zeros_like(points)
        inverse = self.inverse[ids]
        local = np.einsum("nij,nj->ni", inverse, points - self.center[ids])
        forms = self.solids.forms[ids]
        for number in np.unique(forms).tolist():
            form, rows = self.solids.kinds[number], np.flatnonzero(forms == number)
            ratios = self.solids.ratios_of(form, ids[rows])
            out[rows] = np.einsum("nji,nj->ni", inverse[rows], form.normals(local[rows], ratios))
        interpolated = np.array([kind.shading_ratios > 0 for kind in self.solids.kinds])[forms]
        faces = np.where(interpolated[:, None], inverse[:, 2], out) if interpolated.any() else out  # decide on the side
        length = np.sqrt(np.einsum("ni,ni->n", out, out))
        away = np.einsum("ni,ni->n", faces, toward) > 0.0
        sign = np.where(away, -1.0, 1.0)
        return out * (sign / np.where(length > 0.0, length, 1.0))[:, None]


def _hits(form: CanonicalForm, o: Triple, d: Triple, ratios: Ratios) -> list[npt.NDArray[np.floating]]:
    """Return the first hit of each component of a form that a ray may enter separately."""
    return first_hits(form.intervals(o, d, ratios), NEAR)


def depths_of(keys: Keys) -> npt.NDArray[np.float32]:
    """Return the depths stored in ``keys``, infinity for misses."""
    depth = (keys >> _SHIFT).astype(np.uint32).view(np.float32)
    return np.where(keys == NOTHING, np.float32(np.inf), depth)


def ids_of(keys: Keys) -> IntArray:
    """Return the solids' indices stored in ``keys``, -1 for misses."""
    return np.where(keys == NOTHING, -1, (keys & np.uint64(0xFFFFFFFF)).astype(np.int64))


def caster_for(solids: PosedForms, rays: Rays, inverse: FloatArray | None = None) -> Caster:
    """Prepare ``solids``, whose poses must be invertible, for ``rays``; ``inverse`` (N, 3, 3) are their inverses."""
    with np.errstate(all="ignore"):
        inverse = inverses_of(solids.matrices[:, :, :3]) if inverse is None else inverse
        rectangles = _rectangles(solids, rays, ~_turned_away(solids, rays, inverse))
        forward = rays.axes[2]
        depth = (solids.matrices[:, :, 3] - rays.eye) @ forward
        nearest = depth - np.abs(forward @ solids.matrices[:, :, :3]).sum(axis=1)
    return Caster(rays, solids, inverse, solids.matrices[:, :, 3], rectangles, nearest)


def _keys_of(t: npt.NDArray[np.floating], number: npt.NDArray[np.uint64] | np.uint64) -> Keys:
    near = t.astype(np.float32)
    key = (near.view(np.uint32).astype(np.uint64) << _SHIFT) | number
    return np.where(near < np.inf, key, NOTHING)


def _batches(which: IntArray, area: IntArray) -> list[IntArray]:
    """Split ``which`` into batches that cover about ``_BATCH`` samples each."""
    if not len(which):
        return []
    ends = np.cumsum(area[which])
    cuts = np.searchsorted(ends, np.arange(_BATCH, int(ends[-1]), _BATCH))
    return [piece for piece in np.split(which, np.unique(cuts)) if len(piece)]


# --- rectangles ------------------------------------------------------------------------------------------------


def _rectangles(solids: PosedForms, rays: Rays, which: npt.NDArray[np.bool_]) -> IntArray:
    """Return the samples (N, 4) that each of the solids ``which`` may cover, clipped to the picture; 0 for others."""
    low = np.full((len(solids), 2), np.inf)
    high = np.full((len(solids), 2), -np.inf)
    for form, rows in solids.groups(which):
        bounds = _parallel_bounds if rays.parallel else _perspective_bounds
        for start in range(0, len(rows), _BATCH):
            part = rows[start : start + _BATCH]
            linear = rays.axes @ solids.matrices[part, :, :3]
            center = (solids.matrices[part, :, 3] - rays.eye) @ rays.axes.T
            if rays.parallel and type(form).hull is CanonicalForm.hull and not _is_ball(form):  # the cube's corners
                reach = np.abs(linear[:, :2]).sum(axis=2)
                low[part], high[part] = center[:, :2] - reach, center[:, :2] + reach
                continue
            hull = form.hull(solids.ratios_of(form, part))
            low[part], high[part] = bounds(linear, center, hull, _is_ball(form))
    size = np.array([rays.width, rays.height], np.float64)
    first, last = low * rays.focal + rays.principal, high * rays.focal + rays.principal
    up = np.array(rays.principal)[1] * 2.0
    first[:, 1], last[:, 1] = up - last[:, 1], up - first[:, 1].copy()
    empty = ~(low <= high).all(axis=1)
    first[empty], last[empty] = 0.0, 0.0
    # a sample is covered if its centre, at column + 1/2, may be
    low_edge = np.ceil(np.clip(np.nan_to_num(first - 0.5001, nan=0.0), 0.0, size)).astype(np.int64)
    high_edge = np.floor(np.clip(np.nan_to_num(last - 0.4999, nan=0.0), -1.0, size - 1.0)).astype(np.int64) + 1
    out = np.concatenate([low_edge, np.maximum(high_edge, low_edge)], axis=1)
    out[empty] = 0
    return out


def _turned_away(solids: PosedForms, rays: Rays, inverse: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which solids (N,) are faces of closed surfaces that no ray meets from outside."""
    found = np.zeros(len(solids), bool)
    rows = np.flatnonzero(solids.that_are("is_one_sided"))
    outward = inverse[rows, 2]
    view = rays.axes[2] if rays.parallel else solids.matrices[rows, :, 3] - rays.eye
    found[rows] = np.einsum("ni,ni->n", outward, np.broadcast_to(view, outward.shape)) >= 0.0
    return found


def _is_ball(form: CanonicalForm) -> bool:
    """Whether the form is bounded by a single ellipsoid, whose outline is known exactly."""
    outline = form.outline()
    return outline is not None and len(outline) == 1 and outline[0].shape[1] == 4


def _hull_points(linear: FloatArray, hull: FloatArray) -> FloatArray:
    """Transform hulls (K, 3) or (N, K, 3) by ``linear`` (N, C, 3) to points (N, K, C)."""
    points: FloatArray = np.einsum("nij,kj->nki" if hull.ndim == 2 else "nij,nkj->nki", linear, hull)
    return points


def _parallel_bounds(
    linear: FloatArray, center: FloatArray, hull: FloatArray, is_ball: bool
) -> tuple[FloatArray, FloatArray]:
    if is_ball:
        reach = np.sqrt(np.einsum("nij,nij->ni", linear, linear))[:, :2]
        return center[:, :2] - reach, center[:, :2] + reach
    points = _hull_points(linear[:, :2], hull) + center[:, None, :2]
    return points.min(axis=1), points.max(axis=1)


def _perspective_bounds(
    linear: FloatArray, center: FloatArray, hull: FloatArray, is_ball: bool
) -> tuple[FloatArray, FloatArray]:
    """Return bounds (K, 2) at depth 1 of the parts in front of the near plane; empty (low > high) if there are none."""
    points = _hull_points(linear, hull) + center[:, None, :]
    depth = points[:, :, 2]
    before = depth.min(axis=1) > NEAR
    flat = points[:, :, :2] / depth[:, :, None]
    low, high = flat.min(axis=1), flat.max(axis=1)
    crossing = np.flatnonzero(~before)
    if len(crossing):
        low[crossing], high[crossing] = _clipped_bounds(linear[crossing], center[crossing])
    if is_ball:
        rows = np.flatnonzero(before)
        low[rows], high[rows] = _ball_bounds(linear[rows], center[rows])
    return low, high


def _clipped_bounds(linear: FloatArray, center: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the bounds of the posed cube [-1, 1]^3 clipped at the near plane."""
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
    """Return the exact bounds of ellipsoids in front of the eye, by the dual conic ``A A' - t t'`` of their
    outlines."""
    conic = linear @ np.swapaxes(linear, 1, 2) - center[:, :, None] * center[:, None, :]
    scale = conic[:, 2, 2]
    diagonal = np.stack([conic[:, 0, 0], conic[:, 1, 1]], axis=1)
    mixed = conic[:, :2, 2]
    root = np.sqrt(np.maximum(mixed * mixed - diagonal * scale[:, None], 0.0))
    first, second = (mixed - root) / scale[:, None], (mixed + root) / scale[:, None]
    return np.minimum(first, second), np.maximum(first, second)
