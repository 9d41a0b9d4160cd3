"""Lighting of draft images: a soft key light by shadow mapping, and ambient light with occlusion.

Ambient occlusion is the product of two terms: a large-scale term, from coarse shadow maps for a dozen directions of the
sky, and a small-scale term in screen space, from neighboring pixels.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.rays import camera_rays, caster_for, depths_of, parallel_rays
from scenelang.backends.pictures.stage import Stage
from scenelang.backends.surfaces import microfacets
from scenelang.backends.surfaces.appearance import GLASS
from scenelang.backends.surfaces.environments import FADED, GROUND_EDGE, Studio, faded, ground_colors
from scenelang.backends.surfaces.lights import Light
from scenelang.backends.surfaces.solids import Solids
from scenelang.backends.surfaces.tiles import coordinates, period_of, relief_of, tile_of
from scenelang.interpreter.scene.primitives.mesh import inverses_of
from scenelang.interpreter.scene.primitives.textures import Texture

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
Vectors = npt.NDArray[np.floating]
T = TypeVar("T", bound=np.generic)
Rotation = tuple[Float32Array, Float32Array]  # cosine and sine of the per-point rotation of the taps

# Numbers of samples per point. A rotation per pixel turns their pattern into noise, which ``smoothed`` removes.
_SEARCH_TAPS = 14
_SHADOW_TAPS = 16
_NEAR_TAPS = 16
_BATCH_POINTS = 1 << 16  # lit at once, which bounds the memory
# Lengths in units of the scene's half diagonal; the scene is inside the unit ball.
_NEAR_REACH = 0.16  # of occlusion in screen space
_LIGHT_DISTANCE = 3.0  # of the plane from which shadow maps are seen
_MAP_HALF_WIDTH = 1.02
_BIAS = 1e-4  # a blocker must be so far above a point's tangent plane
# The penumbra's radius, in texels, or relative to the map's size.
_MIN_SEARCH_TEXELS, _MIN_PENUMBRA_TEXELS, _MAX_PENUMBRA_SHARE = 2.0, 0.9, 0.11
# Offset of points along their normals, against self-shadowing, and how many times that it is at a grazing angle.
_KEY_LIFT_TEXELS, _SKY_LIFT_TEXELS, _MOST_LIFT = 0.6, 0.8, 3.0
_CELLS = 64  # of a map, per axis, in which blockers are counted
_SKY_SIZE, _SKY_REACH_TEXELS = 128, 4.0  # texels of a sky map, and the radius of its taps
_SKY_SOLIDS = 1 << 15  # cast at once, which bounds the memory
_SKY_DIRECTIONS, _FEW_SKY_DIRECTIONS, _MANY_SOLIDS = 18, 6, 40_000
_GROUPS = 2  # neighboring pixels evaluate different halves of the taps; with four groups, surfaces showed a pattern
_FAR_POINT = 1e3  # coordinate of what occludes nothing
_FAR_DEPTH = 1e9  # stands for the infinite depth of the backdrop where depths are subtracted


@dataclass(frozen=True, eq=False)
class ShadowMap:
    """Shadow map: depths seen from a light.

    Attributes
    ----------
    depth : (S, S)
        Infinite without a blocker.
    axes : (3, 3)
        Rows right, up and forward (away from the light).
    center : (3,)
        Center of the square of half width ``_MAP_HALF_WIDTH`` that the map covers.
    reach
        The distance of the farthest taps in texels.
    """

    depth: Float32Array
    axes: FloatArray
    center: FloatArray
    reach: float

    @cached_property
    def framed(self) -> Float32Array:
        """The depths within a frame of infinity, ((S + 2)^2,): taps outside the map need no test."""
        return np.pad(self.depth, 1, constant_values=np.float32(np.inf)).reshape(-1)

    @cached_property
    def blockers(self) -> npt.NDArray[np.int32]:
        """The number of cells with a blocker, of ``_CELLS`` per axis, above and to the left of each cell's corner."""
        starts = np.arange(0, self.size, self.cell)
        rows = np.logical_or.reduceat(np.isfinite(self.depth), starts, 0)
        return _corner_sums(np.logical_or.reduceat(rows, starts, 1))

    @property
    def cell(self) -> int:
        """Width of a cell in texels."""
        return -(-self.size // _CELLS)

    @cached_property
    def near(self) -> npt.NDArray[np.bool_]:
        """The cells with a blocker within ``reach``, in a frame of cells that reach the map, and one that do not."""
        cells, far = len(self.blockers) - 1, self._cells_in_reach
        edges = np.arange(-1 - far, cells + 1 + far)
        low, high = np.clip(edges - far, 0, cells), np.clip(edges + far + 1, 0, cells)
        columns = self.blockers[:, high] - self.blockers[:, low]
        return np.asarray(columns[high] > columns[low], bool)

    @property
    def _cells_in_reach(self) -> int:
        return math.ceil(self.reach / self.cell)

    def is_near(self, u: Float32Array, v: Float32Array) -> npt.NDArray[np.bool_]:
        """Return which of the texels (N,) may have a blocker within ``reach``, by the cells around them."""
        share, first = np.float32(1.0 / self.cell), np.float32(1 + self._cells_in_reach)
        last = np.float32(len(self.near) - 1)
        column = np.clip(u * share + first, np.float32(0.0), last).astype(np.int32)
        row = np.clip(v * share + first, np.float32(0.0), last).astype(np.int32)
        return np.asarray(self.near.reshape(-1).take(row * np.int32(len(self.near)) + column), bool)

    @property
    def size(self) -> int:
        """Number of texels per side."""
        return int(self.depth.shape[0])

    def before(self, other: ShadowMap) -> ShadowMap:
        """Merge two maps of the same light."""
        return replace(self, depth=np.minimum(self.depth, other.depth))

    @property
    def texel(self) -> float:
        """Width of a texel in scene units."""
        return 2.0 * _MAP_HALF_WIDTH / self.size


@dataclass(frozen=True, slots=True, eq=False)
class _Receivers:
    """Points that may be in shadow, in the coordinates of a map; all (N,).

    Attributes
    ----------
    u, v
        Texel.
    depth
        Distance from the light's plane.
    slope_u, slope_v
        Change of depth per texel along the tangent plane of the point.
    turn
        Rotation of the taps.
    radius
        Radius of the taps, in texels.
    """

    u: Float32Array
    v: Float32Array
    depth: Float32Array
    slope_u: Float32Array
    slope_v: Float32Array
    turn: Rotation
    radius: Float32Array

    def take(self, rows: IntArray, radius: Float32Array) -> _Receivers:
        """Return some of the points, with other radii of the taps."""
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

    def heights(self, shadow: ShadowMap, taps: list[tuple[float, float]]) -> Iterator[Float32Array]:
        """Yield the heights (N,) of blockers above the points' planes at each of the ``taps`` of the unit disk."""
        cosine, sine = (self.radius * part for part in self.turn)
        for dx, dy in taps:
            du, dv = dx * cosine - dy * sine, dx * sine + dy * cosine
            plane = self.depth + du * self.slope_u + dv * self.slope_v
            du += self.u
            dv += self.v
            plane -= shadow.framed.take(_framed_index(du, dv, shadow.size, shadow.size))
            yield np.asarray(plane, np.float32)


def shadow_map(solids: Solids, direction: FloatArray, size: int) -> ShadowMap:
    """Return the shadow map of solids for parallel light.

    Parameters
    ----------
    solids
        All inside the unit ball.
    direction : (3,)
        Unit vector towards the light.
    size
        Texels per side.
    """
    axes, center = _light_view(direction)
    caster = caster_for(solids, parallel_rays(center, axes, _MAP_HALF_WIDTH, size))
    reach = _MAX_PENUMBRA_SHARE * size + _MOST_LIFT * _KEY_LIFT_TEXELS
    return ShadowMap(depths_of(caster.cast()), axes, center, reach)


def _light_view(direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the axes (3, 3) and the center (3,) of the shadow map of light from ``direction`` (3,)."""
    forward = -direction
    right = np.cross(forward, np.eye(3)[int(np.argmin(np.abs(forward)))])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward]), direction * _LIGHT_DISTANCE


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Surface points to be lit: ``points`` and ``normals`` as coordinates (3, N), and the ``turn`` of their taps."""

    points: Float32Array
    normals: Float32Array
    turn: Rotation

    def part(self, which: IntArray) -> Samples:
        """Return some of the samples."""
        cosine, sine = self.turn
        return Samples(self.points.take(which, 1), self.normals.take(which, 1), (cosine.take(which), sine.take(which)))


def samples_at(
    points: npt.NDArray[np.floating], normals: npt.NDArray[np.floating], column: IntArray, row: IntArray
) -> Samples:
    """Return samples at ``points`` (N, 3) with ``normals`` (N, 3).

    ``column`` and ``row`` (N,) are their pixels; neighboring ones get different rotations of the taps.
    """
    angle = (2.0 * math.pi) * gradient_noise(column, row)
    columns = [np.ascontiguousarray(values.T, np.float32) for values in (points, normals)]
    return Samples(columns[0], columns[1], (np.cos(angle), np.sin(angle)))


def key_light(shadow: ShadowMap, radius: float, samples: Samples) -> Float32Array:
    """Return the visible fraction (N,) of the key light, whose angular radius is ``radius`` degrees, at ``samples``.

    Percentage-closer soft shadows (Fernando, 2005): penumbras widen with the distance of the blocker.
    """
    spread = math.tan(math.radians(radius))  # growth of the penumbra's radius per distance of the blocker
    out = np.ones(samples.points.shape[1], np.float32)
    for part in batches(np.arange(len(out)), _BATCH_POINTS):
        out[part] = _key_light(shadow, spread, samples.part(part))
    return out


def _key_light(shadow: ShadowMap, spread: float, samples: Samples) -> Float32Array:
    """Return the visible fraction (N,) of the key light at a batch of samples.

    ``spread`` is the growth of the penumbra's radius per distance of the blocker.
    """
    lit = np.ones(samples.points.shape[1], np.float32)
    per_distance = np.float32(spread / shadow.texel)
    widest = np.float32(_MAX_PENUMBRA_SHARE * shadow.size)
    at, receivers = _receivers(shadow, samples, _KEY_LIFT_TEXELS)
    if not len(at):
        return lit
    farthest = receivers.depth - np.float32(_LIGHT_DISTANCE - 1.0)  # distance of a blocker at the edge of the scene
    reach = np.clip(farthest * per_distance, np.float32(_MIN_SEARCH_TEXELS), widest)
    receivers = replace(receivers, radius=reach)
    distance = _blocker_distance(shadow, receivers)
    some = np.flatnonzero(distance > 0.0)
    radius = np.clip(distance[some] * per_distance, np.float32(_MIN_PENUMBRA_TEXELS), widest)
    lit[at[some]] = _lit_share(shadow, receivers.take(some, radius))
    return lit


def _receivers(shadow: ShadowMap, samples: Samples, lift: float) -> tuple[IntArray, _Receivers]:
    """Return the indices of samples that face the light within reach of a blocker, and their coordinates.

    The samples are offset by ``lift`` texels along their normals, against self-shadowing.
    """
    texel, axes = np.float32(shadow.texel), shadow.axes.astype(np.float32)
    center = axes @ shadow.center.astype(np.float32)
    half, middle = np.float32(1.0 / shadow.texel), np.float32(0.5 * shadow.size - 0.5)
    u = _along(axes[0] * half, samples.points) + (middle - center[0] * half)
    v = _along(axes[1] * -half, samples.points) + (middle + center[1] * half)
    facing = _along(-axes[2], samples.normals)
    at = np.flatnonzero(shadow.is_near(u, v) & (facing > 0.0))
    # one coordinate at a time, which takes half the time of `take` along an axis
    points, normals = ([row.take(at) for row in values] for values in (samples.points, samples.normals))
    facing = np.minimum(facing.take(at), np.float32(1.0))
    tilt_u, tilt_v = _along(axes[0], normals), _along(axes[1], normals)
    offset = np.float32(lift) * (
        np.float32(1.0) + np.float32(_MOST_LIFT - 1.0) * np.sqrt(np.float32(1.0) - facing * facing)
    )
    steep = np.asarray(texel / np.maximum(facing, np.float32(0.2)), np.float32)
    cosine, sine = samples.turn
    return at, _Receivers(
        u.take(at) + tilt_u * offset,
        v.take(at) - tilt_v * offset,
        _along(axes[2], points) - (center[2] + facing * offset * texel),
        tilt_u * steep,
        -tilt_v * steep,
        (cosine.take(at), sine.take(at)),
        np.zeros(len(at), np.float32),
    )


def _along(axis: Float32Array, values: Sequence[Float32Array] | Float32Array) -> Float32Array:
    """Return ``axis`` (3,) @ ``values`` (3, N), without BLAS: starting its threads costs more than it saves here."""
    out = axis[0] * values[0]
    out += axis[1] * values[1]
    out += axis[2] * values[2]
    return np.asarray(out, np.float32)


def disk_points(count: int, power: float = 0.5) -> list[tuple[float, float]]:
    """Return points of the unit disk on Vogel's spiral: uniform, or denser in the middle for a ``power`` above 1/2."""
    golden = math.pi * (3.0 - math.sqrt(5.0))
    radii = [((i + 0.5) / count) ** power for i in range(count)]
    return [(r * math.cos(i * golden), r * math.sin(i * golden)) for i, r in enumerate(radii)]


def gradient_noise(column: IntArray, row: IntArray) -> Float32Array:
    """Return interleaved gradient noise in [0, 1) (Jimenez, 2014): neighbors differ, and a small average removes it."""
    inner = 0.06711056 * column + 0.00583715 * row
    return np.asarray(np.modf(52.9829189 * np.modf(inner)[0])[0], np.float32)


def _framed_index(x: Float32Array, y: Float32Array, width: int, height: int) -> npt.NDArray[np.int32]:
    """Return the indices (N,) of positions in an image of that size within a frame of one pixel."""
    column = np.clip(np.rint(x) + np.float32(1.0), np.float32(0.0), np.float32(width + 1)).astype(np.int32)
    row = np.clip(np.rint(y) + np.float32(1.0), np.float32(0.0), np.float32(height + 1)).astype(np.int32)
    return row * np.int32(width + 2) + column


def _blocker_distance(shadow: ShadowMap, receivers: _Receivers) -> Float32Array:
    """Return the mean distance (N,) from the receivers to potential blockers, 0 if there are none."""
    total = np.zeros(len(receivers.u), np.float32)
    count = np.zeros(len(receivers.u), np.float32)
    taps = disk_points(_SEARCH_TAPS, 1.6)  # denser in the middle, to find thin blockers near the receiver
    for above in receivers.heights(shadow, taps):
        blocks = above > _BIAS
        total += np.where(blocks, above, np.float32(0.0))
        count += blocks
    return np.asarray(total / np.maximum(count, np.float32(1.0)), np.float32)


def _lit_share(shadow: ShadowMap, receivers: _Receivers) -> Float32Array:
    """Return the fraction (N,) of taps without a blocker."""
    lit = np.zeros(len(receivers.u), np.float32)
    for above in receivers.heights(shadow, disk_points(_SHADOW_TAPS)):
        lit += above <= _BIAS
    return np.asarray(lit / np.float32(_SHADOW_TAPS), np.float32)


# --- ambient light ------------------------------------------------------------------------------------------


def sky_maps(solids: Solids, count: int) -> list[ShadowMap]:
    """Return the shadow maps of ``solids`` for light from ``count`` directions of the sky.

    They are cast below each other in one image, as many as hold the memory: with few solids, most of the time would be
    that of preparing a cast.
    """
    with np.errstate(all="ignore"):
        inverse = inverses_of(solids.matrices[:, :, :3])
    maps: list[ShadowMap] = []
    at_once = max(1, _SKY_SOLIDS // max(1, len(solids)))
    for start in range(0, count, at_once):
        views = [_light_view(_sky_direction(k, count)) for k in range(start, min(count, start + at_once))]
        depth = _depths_below_each_other(solids, views, inverse).reshape(-1, _SKY_SIZE, _SKY_SIZE)
        reach = _SKY_REACH_TEXELS + _MOST_LIFT * _SKY_LIFT_TEXELS
        maps += [ShadowMap(part, axes, center, reach) for part, (axes, center) in zip(depth, views, strict=True)]
    return maps


def _sky_direction(k: int, count: int) -> FloatArray:
    """Return direction number ``k`` of ``count`` (3,) on a spiral over the sky."""
    height = 1.0 - (k + 0.5) / count * 0.97
    turn, flat = k * math.pi * (3.0 - math.sqrt(5.0)), math.sqrt(1.0 - height * height)
    return np.array([flat * math.cos(turn), height, flat * math.sin(turn)])


def _depths_below_each_other(
    solids: Solids, views: list[tuple[FloatArray, FloatArray]], inverse: FloatArray
) -> Float32Array:
    """Return the depths (K S, S) of sky maps from K ``views``, axes and centers, one below the other.

    The solids are turned and moved in front of one camera instead of the camera around them.
    """
    width = 2.0 * _MAP_HALF_WIDTH
    moved, inverses = [], []
    for k, (axes, center) in enumerate(views):
        pose = axes @ solids.matrices
        pose[:, :, 3] -= axes @ center + np.array([0.0, k * width, 0.0])
        moved.append(pose)
        inverses.append(inverse @ axes.T)
    every = replace(solids.take(np.tile(np.arange(len(solids)), len(views))), matrices=np.concatenate(moved))
    rays = parallel_rays(np.zeros(3), np.eye(3), _MAP_HALF_WIDTH, _SKY_SIZE, len(views))
    return depths_of(caster_for(every, rays, np.concatenate(inverses)).cast())


def sky_direction_count(solids: Solids) -> int:
    """Return the number of sky directions to sample, fewer for scenes with many solids."""
    return _SKY_DIRECTIONS if len(solids) < _MANY_SOLIDS else _FEW_SKY_DIRECTIONS


def sky_light(maps: list[ShadowMap], samples: Samples, group: IntArray | None = None) -> Float32Array:
    """Return the fraction (N,) of ambient light at ``samples`` that is not blocked by large objects.

    ``group`` (N,) is the ``tap_group`` of each sample. A sample sees the directions of its group, which stand for all:
    the result may be outside [0, 1] before it is ``smoothed``. Without groups, all samples see all directions.
    """
    total = np.full(samples.points.shape[1], 0.1, np.float32)
    for shadow in maps:
        total += _facing(shadow, samples.normals)
    if group is None:
        return np.asarray(1.0 - _blocked_light(maps, samples) / total, np.float32)
    blocked = np.zeros(len(total), np.float32)
    for number in range(_GROUPS):
        for part in batches(np.flatnonzero(group == number), _BATCH_POINTS):
            blocked[part] = _blocked_light(maps[number::_GROUPS], samples.part(part))
    return np.asarray(1.0 - np.float32(_GROUPS) * blocked / total, np.float32)


def _blocked_light(maps: list[ShadowMap], samples: Samples) -> Float32Array:
    """Return the light (N,) from the directions of ``maps`` that does not reach ``samples``."""
    blocked = np.zeros(samples.points.shape[1], np.float32)
    for shadow in maps:
        at, receivers = _receivers(shadow, samples, _SKY_LIFT_TEXELS)
        receivers = replace(receivers, radius=np.full(len(at), _SKY_REACH_TEXELS, np.float32))
        hits = np.zeros(len(at), np.float32)
        for above in receivers.heights(shadow, [(0.3, 0.0), (-0.9, 0.3)]):
            hits += above > shadow.texel
        blocked[at] += np.float32(0.5) * _facing(shadow, samples.normals).take(at) * hits
    return blocked


def _facing(shadow: ShadowMap, normals: Float32Array) -> Float32Array:
    """Return the cosine (N,) between ``normals`` (3, N) and the direction of the light, 0 if they face away."""
    cosine = _along(-shadow.axes[2].astype(np.float32), normals)
    return np.asarray(np.maximum(cosine, np.float32(0.0)), np.float32)


def tap_group(row: IntArray, column: IntArray) -> IntArray:
    """Return the group (N,) of taps that pixels of an image evaluate: neighbors another.

    Interleaved sampling (Keller and Heidrich, 2001): ``smoothed`` gives all groups equal weight.
    """
    return (row + column) % _GROUPS


def batches(indices: IntArray, size: int) -> Iterator[IntArray]:
    """Yield ``indices`` (N,) in batches of ``size``, which bounds the memory."""
    for start in range(0, len(indices), size):
        yield indices[start : start + size]


def occlusion(
    points: Float32Array, normals: Float32Array, depth: Float32Array, solid: npt.NDArray[np.bool_], focal: float
) -> Float32Array:
    """Return the screen-space ambient visibility (H, W) in (0, 1] of each pixel, smoothed.

    Parameters
    ----------
    points, normals : (H, W, 3)
        In the frame where the scene's half diagonal is 1.
    depth : (H, W)
        Infinite on the backdrop.
    solid : (H, W)
        Pixels that occlude others; the bright ground does not.
    focal : float
        Focal length in pixels.
    """
    height, width = depth.shape
    reach = np.minimum(np.float32(_NEAR_REACH * focal) / depth, np.float32(0.35 * width)).reshape(-1)
    visible = np.flatnonzero(np.isfinite(depth))
    visible = visible[_has_solid_around(solid, visible, reach[visible])]
    group = tap_group(*np.divmod(visible, width))
    # Within a frame, and where nothing occludes, points are far away: taps need no test.
    away = np.where(solid[:, :, None], points, np.float32(_FAR_POINT))
    occluders = [np.pad(away[:, :, k], 1, constant_values=np.float32(_FAR_POINT)).reshape(-1) for k in range(3)]
    flat_points, flat_normals = points.reshape(-1, 3), normals.reshape(-1, 3)
    out = np.ones(height * width, np.float32)
    for number in range(_GROUPS):
        taps = disk_points(_NEAR_TAPS, 1.2)[number::_GROUPS]  # denser in the middle, at contacts
        for part in batches(visible[group == number], _BATCH_POINTS):
            p, n = flat_points[part].T.copy(), flat_normals[part].T.copy()
            blocked = _blocked_share(occluders, (height, width), part, reach[part], (p, n), taps)
            out[part] -= np.float32(1.5) * blocked
    return np.maximum(smoothed(out.reshape(height, width), depth), np.float32(0.15))


def _has_solid_around(solid: npt.NDArray[np.bool_], pixels: IntArray, reach: Float32Array) -> npt.NDArray[np.bool_]:
    """Return which of ``pixels`` (N,) have a solid one in the square of half width ``reach`` (N,) around them."""
    height, width = solid.shape
    count = _corner_sums(solid)
    row, column = np.divmod(pixels, width)
    far = np.ceil(reach).astype(np.int64)
    top, bottom = np.maximum(row - far, 0), np.minimum(row + far + 1, height)
    left, right = np.maximum(column - far, 0), np.minimum(column + far + 1, width)
    inside = count[bottom, right] - count[top, right] - count[bottom, left] + count[top, left]
    return np.asarray(inside > 0, bool)


def _corner_sums(values: npt.NDArray[np.bool_]) -> npt.NDArray[np.int32]:
    """Return the number (H + 1, W + 1) of true ``values`` (H, W) above and to the left of each corner of a cell."""
    count = np.zeros((values.shape[0] + 1, values.shape[1] + 1), np.int32)
    np.cumsum(np.cumsum(values, 0, np.int32), 1, out=count[1:, 1:])
    return count


def _blocked_share(
    occluders: list[Float32Array],
    size: tuple[int, int],
    pixels: IntArray,
    reach: Float32Array,
    surface: tuple[Float32Array, Float32Array],
    taps: list[tuple[float, float]],
) -> Float32Array:
    """Return the mean (N,) over ``taps`` of how much the occluders that they hit block.

    ``occluders`` are the coordinates of the pixels of an image of ``size`` (height, width) in a frame of one pixel,
    ``reach`` (N,) the radius of the taps in pixels, and ``surface`` the points and the normals (3, N) of ``pixels``.
    """
    height, width = size
    row, column = np.divmod(pixels, width)
    angle = np.float32(2.0 * math.pi) * gradient_noise(column, row)
    cosine, sine = reach * np.cos(angle), reach * np.sin(angle)
    x, y = column.astype(np.float32), row.astype(np.float32)
    (px, py, pz), (nx, ny, nz) = surface
    total = np.zeros(len(pixels), np.float32)
    for dx, dy in taps:
        index = _framed_index(x + dx * cosine - dy * sine, y + dx * sine + dy * cosine, width, height)
        ax, ay, az = (values.take(index) - own for values, own in zip(occluders, (px, py, pz), strict=True))
        square = ax * ax + ay * ay + az * az + np.float32(1e-9)
        rise = (ax * nx + ay * ny + az * nz) / np.sqrt(square)
        fade = np.maximum(np.float32(0.0), np.float32(1.0) - square * np.float32(1.0 / _NEAR_REACH**2))
        total += np.maximum(rise - np.float32(0.08), np.float32(0.0)) * fade
    return np.asarray(total / np.float32(len(taps)), np.float32)


def smoothed(values: Float32Array, depth: Float32Array) -> Float32Array:
    """Return the 5 x 5 mean of ``values`` (H, W) over pixels of similar ``depth``, by a separable bilateral filter.

    The outermost pixels have half the weight of the others, so that even and odd ones count equally (``tap_group``).
    """
    near = np.where(np.isfinite(depth), depth, np.float32(_FAR_DEPTH))
    for axis in (0, 1):
        total = values.copy()
        weight = np.ones_like(values)
        for shift in (-2, -1, 1, 2):
            share = np.float32(1.0 / abs(shift))
            same = share * (np.abs(np.roll(near, shift, axis=axis) - near) < np.float32(0.03) * near)
            total += same * np.roll(values, shift, axis=axis)
            weight += same
        values = total / weight
    return values


_CONTACT = 2  # pixels around solids in which neither term of the occlusion sees what is just above the ground


def darkest_at_contact(
    share: Float32Array, ground: npt.NDArray[np.bool_], solid: npt.NDArray[np.bool_]
) -> Float32Array:
    """Return the ``share`` (H, W) of ambient light without the bright lines where solids touch the ground.

    Pixels of the ``ground`` (H, W) beside ``solid`` ones (H, W) get the smallest share of the ground around them.
    """
    low, beside = np.where(ground, share, np.float32(1.0)), solid.copy()
    for axis in (0, 1):
        for values, merge in ((low, np.minimum), (beside, np.logical_or)):
            before = values.copy()
            for shift in range(1, _CONTACT + 1):
                head, tail = _shifted(axis, shift)
                merge(values[head], before[tail], out=values[head])
                merge(values[tail], before[head], out=values[tail])
    return np.where(ground & beside, low, share)


def _shifted(axis: int, shift: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Return the slices of all but the last, and of all but the first ``shift`` values along an axis of an image."""
    whole = slice(None)
    head, tail = slice(None, -shift), slice(shift, None)
    return ((head, whole), (tail, whole)) if axis == 0 else ((whole, head), (whole, tail))


# Shading: radiance of surfaces towards the eye, by diffuse reflection, highlights and reflections.


Shadow = tuple[ShadowMap, float]  # and the fraction of the light that its solids block

GROUND = -1
SKY = -2
MIN_ROUGHNESS = 0.06  # below this the highlight would be as large as the light itself
# Light on occluders, which are assumed to be lit in turn: shares of the ambient and the key light, and how much of it
# remains where a point is fully occluded.
_BOUNCED_AMBIENT, _BOUNCED_KEY, _MIN_BOUNCED = 0.5, 0.28, 0.3
_GROUND_ALBEDO = 0.4  # of occluders of the ground, whose color is unknown
# Shadow of a solid on the ground below it: its strength, and the height at which it fades, in half diagonals.
_GROUND_SHADOW, _GROUND_SHADOW_HEIGHT = 0.7, 0.35


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Surfaces seen by N samples.

    Attributes
    ----------
    ids : (N,)
        Indices of solids, ``GROUND`` or ``SKY``.
    depth : (N,)
        Distance along the view direction of the camera.
    points : (N, 3)
        In the frame of the stage.
    normals, view : (N, 3)
        Unit normals that face the viewer, and unit directions of the rays.
    """

    ids: IntArray
    depth: FloatArray
    points: npt.NDArray[np.floating]
    normals: npt.NDArray[np.floating]
    view: npt.NDArray[np.floating]

    def take(self, rows: IntArray) -> Surface:
        """Return some of the samples."""
        vectors = [rows_of(values, rows) for values in (self.points, self.normals, self.view)]
        return Surface(self.ids[rows], self.depth[rows], *vectors)


def rows_of(vectors: npt.NDArray[T], rows: IntArray) -> npt.NDArray[T]:
    """Return some rows of ``vectors`` (N, 3), stored by coordinate."""
    return vectors.T.take(rows, 1).T


@dataclass(frozen=True, slots=True, eq=False)
class LampLight:
    """Light of the program's lights at N samples.

    Attributes
    ----------
    irradiance : (L, N)
        By each of the ``lights``, without its color.
    ground : (N, 3)
        Radiance that they give the ground where the samples mirror it.
    """

    lights: tuple[Light, ...]
    irradiance: Float32Array
    ground: Vectors

    @property
    def white(self) -> Float32Array:
        """Radiance (N, 3) of a white matte surface."""
        colors = np.array([light.color for light in self.lights], np.float32) / np.float32(math.pi)
        return np.asarray(self.irradiance.T @ colors, np.float32)

    def take(self, rows: IntArray) -> LampLight:
        """Return some of the samples."""
        return LampLight(self.lights, self.irradiance[:, rows], self.ground[rows])


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """Light that reaches N samples: shares ``key`` (N,) of the key light and ``ambient`` (N,) of the ambient light, and
    the ``lamps`` of the program, if it has any."""

    key: Float32Array
    ambient: Float32Array
    lamps: LampLight | None = None

    def take(self, rows: IntArray) -> Reach:
        """Return some of the samples."""
        return Reach(self.key[rows], self.ambient[rows], None if self.lamps is None else self.lamps.take(rows))


def hidden_share(solids: Solids) -> FloatArray:
    """Return the effective opacity (N,) of each solid; light passes through the surface of a closed one twice."""
    return np.where(
        solids.that_are("is_closed") | solids.that_are("is_one_sided"),
        1.0 - (1.0 - solids.opacity) ** 2,
        solids.opacity,
    )


def albedo_of(stage: Stage, visible: Surface) -> Float32Array:
    """Return the reflectance (N, 3) of visible surfaces.

    The backdrop has that of the ground, so that denoisers, which are guided by it, do not sharpen the horizon.
    """
    out = np.zeros((3, len(visible.ids)), np.float32).T
    ground = stage.studio.ground
    if ground is not None:
        out[:] = ground.mean(axis=0)
        at = np.flatnonzero(visible.ids == GROUND)
        out[at] = ground_colors(ground, visible.points[at, 0], visible.points[at, 2])
    solid = np.flatnonzero(visible.ids >= 0)
    out[solid] = stage.solids.colors[visible.ids[solid]]
    if stage.solids.looks.textured.any():
        _add_textures(stage, visible, out)
    return out


def _add_textures(stage: Stage, visible: Surface, albedo: Float32Array) -> None:
    """Replace the mean colors in ``albedo`` (N, 3) of surfaces with textures by those at the points that are seen."""
    solids = stage.solids
    solid = np.flatnonzero(visible.ids >= 0)
    look = solids.look[visible.ids[solid]]
    for number in np.unique(look[solids.looks.textured[look]]).tolist():
        texture = solids.looks.rows[number].texture
        if texture is not None:
            rows = solid[look == number]
            points, normals, size = _in_primitive(stage, visible, rows)
            tile, period = tile_of(texture), math.sqrt(math.prod(period_of(texture)))
            facing = _facing_viewer(visible, rows)
            near, strips = np.flatnonzero(facing >= _GRAZING), np.flatnonzero(facing < _GRAZING)
            albedo[rows[near]] = tile.at(coordinates(texture, points[near], normals[near]), size[near] / period)
            if len(strips):
                shown = points[strips], normals[strips], size[strips] * np.maximum(facing[strips], 1.0 / _STRIP_TAPS)
                albedo[rows[strips]] = _along_strips(stage, visible, rows[strips], texture, *shown)


def _along_strips(
    stage: Stage,
    visible: Surface,
    rows: IntArray,
    texture: Texture,
    points: FloatArray,
    normals: FloatArray,
    size: FloatArray,
) -> Float32Array:
    """Return the colors (K, 3) of a texture where the samples ``rows`` see it at grazing angles.

    A pixel covers a long strip of the surface there. One square as long as the strip would blur letters across it too.

    Parameters
    ----------
    points, normals : (K, 3)
        In the frames of the primitives.
    size : (K,)
        Sides of the squares in a row that cover the strip.
    """
    tile, period = tile_of(texture), math.sqrt(math.prod(period_of(texture)))
    facing, flat = _facing_viewer(visible, rows), np.asarray(visible.normals[rows], np.float64)
    view = np.asarray(visible.view[rows], np.float64)
    along = view - np.einsum("ni,ni->n", view, flat)[:, None] * flat
    along /= np.linalg.norm(along, axis=1)[:, None].clip(1e-9)
    away = np.ones(len(rows)) if stage.camera.is_parallel else visible.depth[rows]
    along *= (away / stage.camera.focal[1] / facing)[:, None]
    ids, index = np.unique(visible.ids[rows], return_inverse=True)
    strip = np.einsum("nij,nj->ni", stage.solids.into_primitives(ids)[0][index], along)
    total = np.zeros((len(rows), 3), np.float32)
    for tap in range(_STRIP_TAPS):
        at = points + ((tap + 0.5) / _STRIP_TAPS - 0.5) * strip
        total += tile.at(coordinates(texture, at, normals), size / period)
    return total / np.float32(_STRIP_TAPS)


def _facing_viewer(visible: Surface, rows: IntArray) -> FloatArray:
    """Return the cosines (K,) between the samples ``rows`` and the viewer, at least ``_MIN_FACING``."""
    cosine = np.abs(np.einsum("ni,ni->n", visible.normals[rows], visible.view[rows]))
    return np.maximum(np.asarray(cosine, np.float64), _MIN_FACING)


_MIN_FACING = 0.06  # cosine of the grazing angle from which textures are not blurred further
_GRAZING, _STRIP_TAPS = 0.25, 4  # cosine below which strips are made of several squares, and how many


def relieved(stage: Stage, visible: Surface) -> Surface:
    """Return the samples with the normals of the reliefs of their textures, which light alone shows (Blinn, 1978)."""
    solids = stage.solids
    if not solids.looks.textured.any():  # which is asked for every batch, of scenes with many looks
        return visible
    if not any(look.texture is not None and look.texture.bump for look in solids.looks.rows):
        return visible
    solid = np.flatnonzero(visible.ids >= 0)
    look = solids.look[visible.ids[solid]]
    normals = np.array(visible.normals, np.float32)
    for number in np.unique(look).tolist():
        texture = solids.looks.rows[number].texture
        if texture is not None and texture.bump:
            rows = solid[look == number]
            normals[rows] = _tilted(stage, visible, rows, texture)
    return replace(visible, normals=normals)


def _tilted(stage: Stage, visible: Surface, rows: IntArray, texture: Texture) -> FloatArray:
    """Return the normals (K, 3) of a relief where the samples ``rows`` see it."""
    points, normals, size = _in_primitive(stage, visible, rows)
    normals /= np.linalg.norm(normals, axis=1)[:, None].clip(1e-300)
    tile, period = relief_of(texture), math.sqrt(math.prod(period_of(texture)))
    step = np.maximum(0.5 * size, period / max(tile.image.shape))[:, None]  # half a pixel of the picture or the image

    def height(at: FloatArray) -> FloatArray:
        """Return the heights (K,) at points near the seen ones, in the frame of the primitive."""
        return np.asarray(tile.at(coordinates(texture, at, normals), size / period).mean(axis=1), np.float64)

    first = np.cross(normals, np.eye(3)[np.argmin(np.abs(normals), axis=1)])
    first /= np.linalg.norm(first, axis=1)[:, None]
    raised = normals.copy()
    for tangent in (first, np.cross(normals, first)):
        change = height(points + step * tangent) - height(points - step * tangent)
        raised -= (texture.depth * change)[:, None] / (2.0 * step) * tangent
    ids, index = np.unique(visible.ids[rows], return_inverse=True)
    out = np.einsum("nji,nj->ni", stage.solids.into_primitives(ids)[0][index], raised)
    out /= np.linalg.norm(out, axis=1)[:, None].clip(1e-300)
    view = visible.view[rows]
    facing, flat = (-np.einsum("ni,ni->n", values, view) for values in (out, visible.normals[rows]))
    out -= np.maximum(_LEAST_FACING * flat - facing, 0.0)[:, None] * view
    return np.asarray(out / np.linalg.norm(out, axis=1)[:, None].clip(1e-300), np.float64)


# Of the cosine between a surface and the viewer, the share that its relief keeps: what is seen does not face away, and
# nearly grazing facets would reflect like mirrors, which their neighbors hide in final images.
_LEAST_FACING = 0.6


def _in_primitive(stage: Stage, visible: Surface, rows: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points and normals (K, 3) that the samples ``rows`` see, in the frames of their primitives.

    Also returns the sides (K,) of the squares there that pixels cover.
    """
    ids, index = np.unique(visible.ids[rows], return_inverse=True)
    linear, offset = stage.solids.into_primitives(ids)
    points = np.einsum("nij,nj->ni", linear[index], visible.points[rows]) + offset[index]
    dual = np.swapaxes(inverses_of(linear), 1, 2)[index]
    normals = np.einsum("nij,nj->ni", dual, visible.normals[rows])
    away = np.ones(len(rows)) if stage.camera.is_parallel else visible.depth[rows]
    away = away / _facing_viewer(visible, rows)  # pixels cover long strips at grazing angles
    growth = np.abs(np.linalg.det(linear)) ** (1.0 / 3.0)
    return points, normals, away / stage.camera.focal[1] * growth[index]


def radiance_of(stage: Stage, visible: Surface, albedo: Float32Array, reach: Reach) -> Float32Array:
    """Return the radiance (N, 3) that the samples see."""
    environment = stage.studio.environment
    solid = np.flatnonzero(visible.ids >= 0)
    if environment.unlit:
        color = albedo.copy()
    else:
        color = _lit(stage, visible, albedo, reach)
    color[solid] += stage.solids.emission[visible.ids[solid]].astype(np.float32)
    if stage.fades:
        ground = np.flatnonzero(visible.ids == GROUND)
        color[ground] *= faded(_from_scene(visible.points[ground]))[:, None]
    sky = visible.ids == SKY
    color[sky] = backdrop(stage.studio, visible.view[sky])
    return color


def backdrop(studio: Studio, directions: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
    """Return the radiance (3,) or (N, 3) behind the scene in unit ``directions`` (N, 3)."""
    flat = studio.environment.backdrop
    if flat is None:
        return studio.dome.radiance(directions)
    return np.array(flat) * (FADED if studio.fades else 1.0)


def _lit(stage: Stage, visible: Surface, albedo: Float32Array, reach: Reach) -> Float32Array:
    """Return the radiance (N, 3) that visible surfaces reflect: of ambient light, occluders, key light and lamps."""
    environment = stage.studio.environment
    key, sky = np.array(environment.key, np.float32), np.array(environment.ambient, np.float32)
    facing = (
        np.maximum(visible.normals @ stage.studio.key_direction.astype(np.float32), 0.0).astype(np.float32) * reach.key
    )
    solid = visible.ids >= 0
    around = _surroundings(stage, visible, solid)
    # Occluders are assumed to have the same color and to be lit in turn, less where the point is more occluded.
    share = reach.ambient[:, None]
    lit = (np.float32(_BOUNCED_AMBIENT) * sky + np.float32(_BOUNCED_KEY) * key) * (
        np.float32(_MIN_BOUNCED) + np.float32(1.0 - _MIN_BOUNCED) * share
    )
    bounced = np.where(solid[:, None], albedo, np.float32(_GROUND_ALBEDO)) * lit
    light = around * share + bounced * (1.0 - share) + key * facing[:, None]
    if reach.lamps is not None:
        light += reach.lamps.white
    color = np.asarray(albedo * light, np.float32)
    _add_gloss(stage, visible, color, albedo, reach)
    return color


def key_reach(stage: Stage, visible: Surface, shadows: list[Shadow], row: IntArray, column: IntArray) -> Float32Array:
    """Return the share (N,) of the key light that reaches visible surfaces; 0 where they face away from it.

    ``row`` and ``column`` (N,) are the samples' positions in the picture.
    """
    facing = visible.normals @ stage.studio.key_direction.astype(np.float32)
    reached = (facing > 0.0).astype(np.float32)
    at = np.flatnonzero((visible.ids != SKY) & (facing > 0.0))
    samples = samples_at(rows_of(visible.points, at), rows_of(visible.normals, at), column[at], row[at])
    for shadow, hidden in shadows:
        part = key_light(shadow, stage.studio.environment.radius, samples)
        reached[at] *= 1.0 - np.float32(hidden) * (1.0 - part)
    return reached


def _surroundings(stage: Stage, visible: Surface, solid: npt.NDArray[np.bool_]) -> Float32Array:
    """Return the ambient light (N, 3) around each sample.

    Light from below is reflected by the ground, which is darkened near the solid by the solid's shadow.
    """
    up = np.array([[0.0, 1.0, 0.0]], np.float32)
    sky = np.empty((len(solid), 3), np.float32)
    sky[:] = stage.studio.dome.irradiance(up, above=True)  # of the ground
    rows = np.flatnonzero(solid)
    sky[rows] = stage.studio.dome.irradiance(rows_of(visible.normals, rows), above=stage.ground is not None)
    if stage.ground is None:
        return sky
    height = np.clip(visible.points[:, 1] - stage.ground, 0.0, 10.0).astype(np.float32)
    below = np.where(solid, 0.5 - 0.5 * visible.normals[:, 1], 0.0).astype(np.float32)
    turned_away = (0.5 - 0.5 * visible.normals @ stage.studio.key_direction.astype(np.float32)).astype(np.float32)
    shaded = np.float32(_GROUND_SHADOW) * turned_away * np.exp(-height / np.float32(_GROUND_SHADOW_HEIGHT))
    ground = ground_radiance(stage).astype(np.float32)
    return np.asarray(sky + below[:, None] * (ground * (1.0 - shaded)[:, None]), np.float32)


def ground_depths(height: float, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the distance (N,) along rays to the ground at ``height``, infinity for rays that miss it."""
    drop = direction[:, 1]
    falls = drop < -1e-9
    fall = np.where(falls, (height - origin[:, 1]) / np.where(falls, drop, -1.0), 1e30)
    across = np.hypot(origin[:, 0] + direction[:, 0] * fall, origin[:, 2] + direction[:, 2] * fall)
    return np.where((fall > 0.0) & (across < GROUND_EDGE), fall, np.inf)


def ground_light(stage: Stage) -> FloatArray:
    """Return the share (H * W,) of light on the ground that each pixel sees; that of the farthest beside the ground."""
    origin, direction = camera_rays(stage.camera).each()
    depth = np.inf if stage.ground is None else ground_depths(stage.ground, origin, direction)
    depth = np.minimum(depth, GROUND_EDGE)
    return np.asarray(faded(_from_scene(origin + direction * depth[:, None])), np.float64)


def _from_scene(points: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
    """Return the horizontal distances (N,) of points (N, 3) from the middle of the scene, in half diagonals."""
    return np.asarray(np.hypot(points[:, 0], points[:, 2]), points.dtype)


def ground_radiance(stage: Stage) -> FloatArray:
    """Return the mean radiance (3,) of the unshadowed ground; black without a ground."""
    light = stage.studio.environment.on_level(stage.studio.key_direction)
    return np.asarray(ground_reflectance(stage) * light, np.float64)


def ground_reflectance(stage: Stage) -> FloatArray:
    """Return the mean reflectance (3,) of the ground; black without a ground."""
    ground = stage.studio.ground
    return np.zeros(3) if ground is None else np.asarray(ground.mean(axis=0), np.float64)


# --- gloss -----------------------------------------------------------------------------------------------------

_COAT_ROUGHNESS = 0.06  # of varnish
# The bright rim of fabric, as Mitsuba's ``principled`` has it: its reflectance k (1 - c)^p of light from all sides, by
# the cosine c between normal and view.
_SHEEN_RIM, _SHEEN_POWER = 0.75, 2.16


def _add_gloss(
    stage: Stage,
    visible: Surface,
    color: Float32Array,
    albedo: Float32Array,
    reach: Reach,
) -> None:
    """Replace part of the diffuse reflection in ``color`` of glossy surfaces with specular reflection.

    Microfacets (GGX, Schlick's Fresnel term) reflect the key light and the surroundings: the dome above the horizon and
    the ground below, both blurred by the roughness. What they lose by single scattering is added (``microfacets``).
    """
    looks, rows = stage.solids.looks, mirroring(stage, visible)
    if not len(rows):
        return
    gloss = _Gloss(stage, visible.take(rows), reach.take(rows))
    look = stage.solids.look[gloss.part.ids]
    tint, metallic = albedo[rows].astype(np.float64), looks.metallic[look][:, None]
    rough, ior = np.maximum(looks.gloss[look], MIN_ROUGHNESS), np.where(looks.diffuse[look], 1.0, looks.ior[look])
    base = microfacets.normal_reflectance(ior)[:, None]
    normal_reflectance = base * (1.0 - metallic) + tint * metallic
    later = metallic * microfacets.later_bounces(tint, rough[:, None])  # those of dielectrics are in their body
    scattered = color[rows] * (1.0 - metallic) * (1.0 - microfacets.dielectric_albedo(rough, ior)[:, None])
    out = scattered + gloss.reflected(normal_reflectance, rough, 1.0 + later)
    coat, sheen = looks.coat[look][:, None], looks.sheen[look][:, None]
    if sheen.any():
        rim = _SHEEN_RIM * (1.0 - gloss.toward[:, None]) ** _SHEEN_POWER
        # The key light is beside the viewer, where a sheen reflects nothing.
        out += sheen * (rim * gloss.around + microfacets.SHEEN_ALBEDO * (gloss.rim_of_lamps() - out))
    if coat.any():
        varnish, smooth = (
            np.full(coat.shape, microfacets.normal_reflectance(GLASS)),
            np.full(len(coat), _COAT_ROUGHNESS),
        )
        kept = 1.0 - coat * microfacets.dielectric_albedo(_COAT_ROUGHNESS, GLASS)
        out = out * kept + coat * gloss.reflected(varnish, smooth, 1.0)
    color[rows] = out


def through_glass(
    stage: Stage, visible: Surface, reach: Reach, behind: Float32Array
) -> tuple[IntArray, Float32Array, Float32Array]:
    """Return which of the samples see glass (K,), their radiance (K, 3), and the share (K, 1) that it reflects.

    Glass colors what is ``behind`` (N, 3), and its reflections are as bright as if it were opaque.
    """
    looks = stage.solids.looks
    rows = np.zeros(0, np.int64)
    if not stage.studio.environment.unlit and looks.refractive.any():
        rows = np.flatnonzero(looks.refractive[stage.solids.look[visible.ids]])
    if not len(rows):
        return rows, np.zeros((0, 3), np.float32), np.zeros((0, 1), np.float32)
    gloss = _Gloss(stage, visible.take(rows), reach.take(rows))
    look = stage.solids.look[gloss.part.ids]
    rough = np.maximum(looks.gloss[look], MIN_ROUGHNESS)
    normal = microfacets.normal_reflectance(looks.ior[look])[:, None]
    share = _schlick(normal, gloss.toward, rough) * microfacets.albedo(rough)[:, None]
    seen = behind[rows] * looks.color[look] * (1.0 - share) + gloss.reflected(normal, rough, 1.0)
    return rows, seen.astype(np.float32), share.astype(np.float32)


class _Gloss:
    """Specular reflection at samples: ``toward`` (N,) is the cosine between their normals and the viewer."""

    def __init__(self, stage: Stage, part: Surface, reach: Reach) -> None:
        self.stage, self.part, self._lamps = stage, part, reach.lamps
        self._key, self._ambient = reach.key[:, None], reach.ambient[:, None]
        self.toward = np.clip(-np.einsum("ni,ni->n", part.normals, part.view), 1e-3, 1.0)

    @property
    def around(self) -> FloatArray:
        """Radiance (N, 3) of a white matte surface by the surroundings alone."""
        light = _surroundings(self.stage, self.part, self.part.ids >= 0) * self._ambient
        return np.asarray(light, np.float64)

    def reflected(self, normal_reflectance: Vectors, rough: FloatArray, bounces: Vectors | float) -> FloatArray:
        """Return the radiance (N, 3) that facets reflect.

        ``normal_reflectance`` (N, 1 or 3) is theirs at normal incidence, ``bounces`` (N, 3) how many times brighter
        their light is than that of one bounce.
        """
        fresnel = _schlick(normal_reflectance, self.toward, rough) * microfacets.albedo(rough)[:, None]
        ground = 0.0 if self._lamps is None else self._lamps.ground
        room = fresnel * _room(self.stage, self.part, self.toward, rough, ground) * self._ambient
        highlight = _highlight(self.stage, self.part, normal_reflectance, self.toward, rough) * self._key
        highlight = highlight + self._highlights_of_lamps(normal_reflectance, rough)
        return np.asarray((room + highlight) * bounces, np.float64)

    def rim_of_lamps(self) -> FloatArray:
        """Return the radiance (N, 3) of the rim that a sheen of 1 has by the lamps, as in final images.

        It is the sheen of Disney's BRDF (Burley, 2012), of the strength that ``mitsuba_materials`` gives it.
        """

        def rim(part: Surface, rows: IntArray, toward: Vectors) -> Vectors:
            """Return the BRDF (M, 1) of a sheen of 1."""
            between = np.einsum("ni,ni->n", toward, -part.view)
            half = np.sqrt(np.clip(0.5 + 0.5 * between, 0.0, 1.0))  # cosine of half the angle between light and viewer
            return np.asarray(microfacets.SHEEN_STRENGTH * (1.0 - half[:, None]) ** 5, np.float64)

        return self._of_lamps(rim)

    def _highlights_of_lamps(self, normal_reflectance: Vectors, rough: FloatArray) -> FloatArray:
        """Return the radiance (N, 3) of the highlights of the lamps."""
        reflectance = np.broadcast_to(normal_reflectance, (len(self.part.ids), 3))
        return self._of_lamps(
            lambda part, rows, toward: facets(part, toward, reflectance[rows], self.toward[rows], rough[rows])
        )

    def _of_lamps(self, brdf: Callable[[Surface, IntArray, Vectors], Vectors]) -> FloatArray:
        """Return the radiance (N, 3) that a BRDF reflects of the lamps.

        ``brdf`` takes M lit samples, their indices, and the unit directions (M, 3) to a lamp.
        """
        out = np.zeros((len(self.part.ids), 3))
        lamps = self._lamps
        for light, irradiance in () if lamps is None else zip(lamps.lights, lamps.irradiance, strict=True):
            rows = np.flatnonzero(irradiance)
            part = self.part.take(rows)
            reflected = brdf(part, rows, light.toward(np.asarray(part.points, np.float64)))
            out[rows] += reflected * irradiance[rows, None] * np.array(light.color)
        return out


def _schlick(reflectance: Vectors, cosine: FloatArray, rough: FloatArray) -> FloatArray:
    """Return the Fresnel reflectance (N, 3) by Schlick's approximation (1994), weaker at grazing angles if rough."""
    limit = np.where(reflectance > 0.0, np.maximum((1.0 - rough)[:, None], reflectance), 0.0)
    return np.asarray(reflectance + (limit - reflectance) * ((1.0 - cosine) ** 5)[:, None], np.float64)


def mirroring(stage: Stage, visible: Surface) -> IntArray:
    """Return the indices (N,) of visible surfaces that mirror what is around them, or have highlights."""
    looks, solid = stage.solids.looks, np.flatnonzero(visible.ids >= 0)
    if bool(looks.matte.all()):
        return solid[:0]
    return solid[~looks.matte[stage.solids.look[visible.ids[solid]]]]


_LEAST_FALL = 0.02  # of a ray that meets the ground, the cosine to the vertical


def mirrored_ground(stage: Stage, part: Surface) -> FloatArray:
    """Return the points (N, 3) of the ground in the middle of what glossy surfaces of a stage with a ground mirror.

    Rough surfaces mirror a wide cone of directions, of which the lower part meets the ground.
    """
    toward = np.einsum("ni,ni->n", part.normals, part.view)
    direction = np.asarray(part.view - 2.0 * toward[:, None] * part.normals, np.float64)
    rough = stage.solids.looks.gloss[stage.solids.look[part.ids]]
    fall = np.maximum(-direction[:, 1], np.maximum(0.5 * rough, _LEAST_FALL))
    points = np.asarray(part.points, np.float64)
    far = np.maximum(points[:, 1] - (stage.ground or 0.0), 0.0) / fall
    points = points + direction * far[:, None]
    points[:, 1] = stage.ground or 0.0
    return points


def _room(
    stage: Stage, part: Surface, toward: FloatArray, rough: FloatArray, lit_ground: Vectors | float
) -> FloatArray:
    """Return the radiance (N, 3) of the surroundings in the direction of reflection.

    ``lit_ground`` (N, 3) is the radiance of the ground there by the lights of the program.
    """
    direction = part.view + 2.0 * toward[:, None] * part.normals
    sky = stage.studio.dome.radiance(direction, rough)
    if stage.ground is None:
        return sky
    share = np.clip(0.5 + 0.5 * direction[:, 1] / np.maximum(rough, 0.02), 0.0, 1.0)[:, None]
    return np.asarray(sky * share + (ground_radiance(stage) + lit_ground) * (1.0 - share), np.float64)


def _highlight(stage: Stage, part: Surface, reflectance: Vectors, toward: FloatArray, rough: FloatArray) -> FloatArray:
    """Return the radiance (N, 3) of the key light's highlight; ``toward`` (N,) is the cosine to the viewer."""
    light = np.broadcast_to(stage.studio.key_direction, part.normals.shape)
    facing = np.clip(np.einsum("ni,ni->n", part.normals, light), 0.0, 1.0)
    # A white matte surface has the radiance `key`, so the irradiance is pi times that.
    strength = np.pi * np.array(stage.studio.environment.key)
    return np.asarray(facets(part, light, reflectance, toward, rough) * facing[:, None] * strength, np.float64)


def facets(part: Surface, light: Vectors, reflectance: Vectors, toward: FloatArray, rough: FloatArray) -> FloatArray:
    """Return the BRDF (N, 3) of microfacets (GGX distribution, Smith masking, Schlick's Fresnel term).

    Parameters
    ----------
    light : (N, 3)
        Unit directions to the light.
    reflectance : (N, 1 or 3)
        At normal incidence.
    toward : (N,)
        Cosine between the normals and the viewer.
    rough : (N,)
    """
    half = light - part.view
    half /= np.maximum(np.linalg.norm(half, axis=1), 1e-9)[:, None]
    alpha2 = rough**4
    facing = np.clip(np.einsum("ni,ni->n", part.normals, light), 0.0, 1.0)
    straight = np.clip(np.einsum("ni,ni->n", part.normals, half), 0.0, 1.0)
    spread = alpha2 / (np.pi * (straight**2 * (alpha2 - 1.0) + 1.0) ** 2)
    masked = 0.5 / np.maximum(
        facing * np.sqrt(toward**2 * (1.0 - alpha2) + alpha2) + toward * np.sqrt(facing**2 * (1.0 - alpha2) + alpha2),
        1e-4,
    )
    fresnel = _schlick(reflectance, np.clip(np.einsum("ni,ni->n", half, light), 0.0, 1.0), rough)
    return np.asarray(fresnel * (spread * masked)[:, None], np.float64)
