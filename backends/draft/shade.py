"""Light in draft pictures: a soft key light by a shadow map, and the surrounding light by what hides it.

The surrounding light is the product of two parts: what large things take, by coarse shadow maps from a dozen places of
the sky, and what near things take, by comparing neighbouring pixels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.backends.rays.cast import caster_for, depths_of, parallel_rays
from scenelang.backends.solids import Solids

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
Turn = tuple[Float32Array, Float32Array]  # cosine and sine of each point's own rotation of the taps

_SEARCH_TAPS = 14
_SHADOW_TAPS = 16
_NEAR_TAPS = 16
_NEAR_REACH = 0.16  # where the scene's half diagonal is 1
_CHUNK = 1 << 16
_LIGHT_DISTANCE = 3.0
_HALF = 1.02  # half the width of a shadow map; the scene lies in the unit ball
_SKY_SIZE = 128
_SKY_PLACES, _FEW_SKY_PLACES, _MANY_SOLIDS = 18, 6, 40_000


@dataclass(frozen=True, slots=True, eq=False)
class ShadowMap:
    """Depths from a light: ``depth`` (size, size), infinity where nothing is; ``axes`` rows right, up, forward (away
    from the light); the map covers the square of half width ``_HALF`` about ``center``."""

    depth: Float32Array
    axes: FloatArray
    center: FloatArray

    @property
    def size(self) -> int:
        return int(self.depth.shape[0])

    def before(self, other: ShadowMap) -> ShadowMap:
        """The map of what both maps of one light hold."""
        return replace(self, depth=np.minimum(self.depth, other.depth))

    @property
    def texel(self) -> float:
        """The width of a texel."""
        return 2.0 * _HALF / self.size


@dataclass(frozen=True, slots=True, eq=False)
class _Receivers:
    """Points that a map may shade: texels (``u``, ``v``), ``depth``, and the change of depth per texel along each
    point's own plane; all (N,). ``radius`` is that of the taps in texels, ``turn`` their rotation."""

    u: Float32Array
    v: Float32Array
    depth: Float32Array
    slope_u: Float32Array
    slope_v: Float32Array
    turn: Turn
    radius: Float32Array

    def take(self, rows: IntArray, radius: Float32Array) -> _Receivers:
        cosine, sine = self.turn
        return _Receivers(
            self.u[rows],
            self.v[rows],
            self.depth[rows],
            self.slope_u[rows],
            self.slope_v[rows],
            (cosine[rows], sine[rows]),
            radius,
        )

    def above(self, shadow: ShadowMap, dx: float, dy: float) -> Float32Array:
        """How far (N,) what the map holds at the tap (dx, dy) of the unit disk lies above the points' planes."""
        cosine, sine = self.turn
        du, dv = self.radius * (dx * cosine - dy * sine), self.radius * (dx * sine + dy * cosine)
        plane = self.depth + du * self.slope_u + dv * self.slope_v
        above: Float32Array = plane - _tap(shadow, self.u + du, self.v + dv)
        return above


def shadow_map(solids: Solids, direction: FloatArray, size: int) -> ShadowMap:
    """The shadow map of ``solids``, all inside the unit ball, for light from ``direction`` (3,), a unit vector."""
    forward = -direction
    right = np.cross(forward, np.eye(3)[int(np.argmin(np.abs(forward)))])
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(right, forward), forward])
    center = direction * _LIGHT_DISTANCE
    caster = caster_for(solids, parallel_rays(center, axes, _HALF, size))
    return ShadowMap(depths_of(caster.cast()), axes, center)


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Surface points to be lit: ``points`` and ``normals`` as coordinates (3, N), and the ``turn`` of their taps."""

    points: Float32Array
    normals: Float32Array
    turn: Turn

    def part(self, which: slice) -> Samples:
        cosine, sine = self.turn
        return Samples(self.points[:, which], self.normals[:, which], (cosine[which], sine[which]))


def samples_at(points: FloatArray, normals: FloatArray, column: IntArray, row: IntArray) -> Samples:
    """Samples at ``points`` (N, 3); ``column`` and ``row`` (N,) are their places: neighbours get different taps."""
    angle = (2.0 * math.pi) * _noise(column, row)
    columns = [np.ascontiguousarray(values.T, np.float32) for values in (points, normals)]
    return Samples(columns[0], columns[1], (np.cos(angle), np.sin(angle)))


def key_light(shadow: ShadowMap, radius: float, samples: Samples) -> Float32Array:
    """The share (N,) of the key light, seen under twice ``radius`` degrees, that reaches ``samples``; penumbras widen
    with the blocker's distance."""
    spread = math.tan(math.radians(radius))  # growth of the penumbra's radius with the blocker's distance
    out = np.ones(samples.points.shape[1], np.float32)
    for start in range(0, len(out), _CHUNK):
        part = slice(start, start + _CHUNK)
        out[part] = _key_light(shadow, spread, samples.part(part))
    return out


def _key_light(shadow: ShadowMap, spread: float, samples: Samples) -> Float32Array:
    lit = np.ones(samples.points.shape[1], np.float32)
    at, receivers = _receivers(shadow, samples, 0.6)
    if not len(at):
        return lit
    per_distance = np.float32(spread / shadow.texel)
    widest = np.float32(0.11 * shadow.size)
    reach = np.clip((receivers.depth - np.float32(_LIGHT_DISTANCE - 1.0)) * per_distance, np.float32(2.0), widest)
    receivers = replace(receivers, radius=reach)
    distance = _blocker_distance(shadow, receivers)
    some = np.flatnonzero(distance > 0.0)
    radius = np.clip(distance[some] * per_distance, np.float32(0.9), widest)
    lit[at[some]] = _lit_share(shadow, receivers.take(some, radius))
    return lit


def _receivers(shadow: ShadowMap, samples: Samples, lift: float) -> tuple[IntArray, _Receivers]:
    """The samples that face the light near the map, and where they are in it, ``lift`` texels off their surfaces."""
    size, texel = shadow.size, np.float32(shadow.texel)
    axes = shadow.axes.astype(np.float32)
    tilt = _turned(axes, samples.normals)
    facing = np.clip(-tilt[2], np.float32(0.0), np.float32(1.0))
    local = _turned(axes, samples.points) - (axes @ shadow.center.astype(np.float32))[:, None]
    local += tilt * (texel * np.float32(lift) * (np.float32(1.0) + np.float32(2.0) * np.sqrt(1.0 - facing * facing)))
    half = np.float32(0.5 * size)
    u = (local[0] * np.float32(1.0 / _HALF) + np.float32(1.0)) * half - np.float32(0.5)
    v = (np.float32(1.0) - local[1] * np.float32(1.0 / _HALF)) * half - np.float32(0.5)
    reach = 0.15 * size
    at = np.flatnonzero((u > -reach) & (u < size + reach) & (v > -reach) & (v < size + reach) & (facing > 0.0))
    steep = np.minimum(tilt[2, at], np.float32(-0.2))
    cosine, sine = samples.turn
    receivers = _Receivers(
        u[at],
        v[at],
        local[2, at],
        -tilt[0, at] / steep * texel,
        tilt[1, at] / steep * texel,
        (cosine[at], sine[at]),
        np.zeros(len(at), np.float32),
    )
    return at, receivers


def _turned(axes: Float32Array, values: Float32Array) -> Float32Array:
    """``axes`` (K, 3) @ ``values`` (3, N), by hand: the threads of a matrix product cost more than they gain here."""
    rows = [a[0] * values[0] + a[1] * values[1] + a[2] * values[2] for a in axes]
    return np.asarray(np.stack(rows), np.float32)


def _disk(count: int, power: float = 0.5) -> list[tuple[float, float]]:
    """Points of the unit disk on Vogel's spiral: evenly spread, or denser in the middle for a ``power`` above 1/2."""
    golden = math.pi * (3.0 - math.sqrt(5.0))
    radii = [((i + 0.5) / count) ** power for i in range(count)]
    return [(r * math.cos(i * golden), r * math.sin(i * golden)) for i, r in enumerate(radii)]


def _noise(column: IntArray, row: IntArray) -> Float32Array:
    """Interleaved gradient noise in [0, 1): neighbours differ, which a small average smooths away."""
    inner = 0.06711056 * column + 0.00583715 * row
    return np.asarray(np.modf(52.9829189 * np.modf(inner)[0])[0], np.float32)


def _tap(shadow: ShadowMap, u: Float32Array, v: Float32Array) -> Float32Array:
    """The map's depths at texels (N,), infinity outside."""
    size = shadow.size
    column, row = np.rint(u).astype(np.int32), np.rint(v).astype(np.int32)
    inside = (column >= 0) & (column < size) & (row >= 0) & (row < size)
    index = np.where(inside, row * size + column, 0)
    return np.where(inside, shadow.depth.reshape(-1)[index], np.float32(np.inf))


def _blocker_distance(shadow: ShadowMap, receivers: _Receivers) -> Float32Array:
    """The mean distance (N,) from the receivers to what may block the light, 0 where nothing does."""
    total = np.zeros(len(receivers.u), np.float32)
    count = np.zeros(len(receivers.u), np.float32)
    for dx, dy in _disk(_SEARCH_TAPS, 1.6):  # a thin blocker near the receiver must not be missed
        above = receivers.above(shadow, dx, dy)
        blocks = above > 1e-4
        total += np.where(blocks, above, np.float32(0.0))
        count += blocks
    return np.asarray(total / np.maximum(count, np.float32(1.0)), np.float32)


def _lit_share(shadow: ShadowMap, receivers: _Receivers) -> Float32Array:
    lit = np.zeros(len(receivers.u), np.float32)
    for dx, dy in _disk(_SHADOW_TAPS):
        lit += receivers.above(shadow, dx, dy) <= 1e-4
    return np.asarray(lit / np.float32(_SHADOW_TAPS), np.float32)


# --- surrounding light -----------------------------------------------------------------------------------------


def sky_maps(solids: Solids, count: int) -> list[ShadowMap]:
    """The shadow maps of ``solids`` for light from ``count`` places of the sky."""
    maps = []
    for k in range(count):
        height = 1.0 - (k + 0.5) / count * 0.97
        turn, flat = k * math.pi * (3.0 - math.sqrt(5.0)), math.sqrt(1.0 - height * height)
        direction = np.array([flat * math.cos(turn), height, flat * math.sin(turn)])
        maps.append(shadow_map(solids, direction, _SKY_SIZE))
    return maps


def sky_places(solids: Solids) -> int:
    """From how many places of the sky so many solids are looked at."""
    return _SKY_PLACES if len(solids) < _MANY_SOLIDS else _FEW_SKY_PLACES


def sky_light(maps: list[ShadowMap], samples: Samples) -> Float32Array:
    """The share (N,) of the sky's light on ``samples`` that large things let through, seen from places of the sky."""
    count = samples.points.shape[1]
    total = np.full(count, 0.1, np.float32)
    open_ = np.full(count, 0.1, np.float32)
    for start in range(0, count, _CHUNK):
        part = slice(start, start + _CHUNK)
        chunk = samples.part(part)
        for shadow in maps:
            weight = np.maximum(-_turned(shadow.axes[2:].astype(np.float32), chunk.normals)[0], np.float32(0.0))
            lit = np.ones(len(weight), np.float32)
            at, receivers = _receivers(shadow, chunk, 0.8)
            receivers = replace(receivers, radius=np.full(len(at), 4.0, np.float32))
            for dx, dy in ((0.3, 0.0), (-0.9, 0.3)):
                lit[at] -= np.float32(0.5) * (receivers.above(shadow, dx, dy) > shadow.texel)
            total[part] += weight
            open_[part] += weight * lit
    return np.asarray(open_ / total, np.float32)


def occlusion(
    points: Float32Array, normals: Float32Array, depth: Float32Array, solid: npt.NDArray[np.bool_], focal: float
) -> Float32Array:
    """How much of the surrounding light near things let through to each pixel, in (0, 1]: (H, W).

    ``points`` and ``normals`` (H, W, 3) in the frame where the scene's half diagonal is 1, ``depth`` (H, W) infinite
    on the backdrop, ``solid`` (H, W) marks what hides light (the bright ground does not), ``focal`` is the size in
    pixels of a unit at depth 1.
    """
    height, width = depth.shape
    seen = np.flatnonzero(np.isfinite(depth).reshape(-1))
    out = np.ones(height * width, np.float32)
    flat_points, flat_normals = points.reshape(-1, 3), normals.reshape(-1, 3)
    flat_depth, flat_solid = depth.reshape(-1), solid.reshape(-1)
    for start in range(0, len(seen), _CHUNK):
        part = seen[start : start + _CHUNK]
        row, column = np.divmod(part, width)
        p, n = flat_points[part], flat_normals[part]
        reach = np.minimum(_NEAR_REACH * focal / flat_depth[part], 0.35 * width).astype(np.float32)
        angle = 2.0 * math.pi * _noise(column, row)
        cosine, sine = reach * np.cos(angle), reach * np.sin(angle)
        blocked = np.zeros(len(part), np.float32)
        for dx, dy in _disk(_NEAR_TAPS, 1.2):  # denser in the middle, where things touch
            c = np.rint(column + dx * cosine - dy * sine).astype(np.int64)
            r = np.rint(row + dx * sine + dy * cosine).astype(np.int64)
            inside = (c >= 0) & (c < width) & (r >= 0) & (r < height)
            index = np.where(inside, r * width + c, part)
            away = flat_points[index] - p
            square = np.einsum("ni,ni->n", away, away) + np.float32(1e-9)
            rise = np.einsum("ni,ni->n", away, n) / np.sqrt(square)
            fade = np.maximum(np.float32(0.0), np.float32(1.0) - square / np.float32(_NEAR_REACH**2))
            blocks = np.maximum(rise - np.float32(0.08), np.float32(0.0)) * fade
            blocked += np.where(flat_solid[index], blocks, np.float32(0.0))
        out[part] = np.maximum(np.float32(1.0) - blocked * np.float32(1.5 / _NEAR_TAPS), np.float32(0.15))
    return out.reshape(height, width)


def smoothed(values: Float32Array, depth: Float32Array) -> Float32Array:
    """A 5 x 5 average of ``values`` (H, W) over pixels of about the same ``depth``."""
    near = np.where(np.isfinite(depth), depth, np.float32(1e9))
    for axis in (0, 1):
        total = values.copy()
        weight = np.ones_like(values)
        for shift in (-2, -1, 1, 2):
            same = (np.abs(np.roll(near, shift, axis=axis) - near) < np.float32(0.03) * near).astype(np.float32)
            total += same * np.roll(values, shift, axis=axis)
            weight += same
        values = total / weight
    return values
