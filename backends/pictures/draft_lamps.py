"""Lights of a program in draft images: diffuse reflection and highlights, with shadows.

Suns have the parallel shadow maps of the key light. Every other lamp looks through the six faces of a cube around it,
each a pinhole camera, and a face is cast when a visible point is behind it. Lamps with an extent have soft shadows by
percentage-closer soft shadows (Fernando, 2005), as the key light.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.camera import camera_at
from scenelang.backends.pictures.draft_light import (
    GROUND,
    SKY,
    LampLight,
    Surface,
    batches,
    disk_points,
    gradient_noise,
    ground_reflectance,
    key_light,
    mirrored_ground,
    mirroring,
    rows_of,
    samples_at,
    shadow_map,
)
from scenelang.backends.pictures.rays import Rays, camera_rays, caster_for, depths_of
from scenelang.backends.pictures.stage import Stage
from scenelang.backends.surfaces.lights import Light, irradiance_of, level_axes
from scenelang.backends.surfaces.solids import Solids
from scenelang.interpreter.scene.primitives.mesh import inverses_of

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]

_FACE = 1.04  # half width of a face of the cube at distance 1: neighbors overlap, so that taps find what is beside
_LIFT_TEXELS = 0.7  # offset of points along their normals, against self-shadowing
_SEARCH_TAPS, _SHADOW_TAPS = 32, 48  # with fewer, penumbras show the rotation of the taps
_MIN_TEXELS, _MAX_SHARE = 1.0, 0.12  # radius of the taps, in texels, and relative to the map's size
_NEARER = 1e-3  # a blocker is so much nearer to the lamp than the tangent plane of a point, relative to the distance
_BATCH = 1 << 15  # points in penumbras at once, which bounds the memory


@dataclass(frozen=True, slots=True, eq=False)
class Lamps:
    """Lights of a stage with their shadow maps; a map is cast when a point first needs it, and kept in ``maps``.

    Attributes
    ----------
    solids
        Those that throw shadows.
    maps
        Maps by the number of the light and, for all but suns, of the face.
    """

    stage: Stage
    solids: Solids
    maps: dict[tuple[int, int], Any]

    @property
    def size(self) -> int:
        """Texels per side of a map."""
        return min(1024, max(256, self.stage.width, self.stage.height))

    def light(self, visible: Surface, row: IntArray, column: IntArray) -> LampLight:
        """Return the light of the lamps on visible surfaces.

        ``row`` and ``column`` (N,) are the samples' positions in the picture.
        """
        ground = np.zeros((len(visible.ids), 3), np.float32)
        mirrors = mirroring(self.stage, visible)
        if self.stage.ground is not None and len(mirrors):
            ground[mirrors] = self._mirrored(visible.take(mirrors), row[mirrors], column[mirrors])
        lit = np.zeros((len(self.stage.lights), len(visible.ids)), np.float32)
        at = np.flatnonzero(visible.ids != SKY)
        points = np.asarray(rows_of(visible.points, at), np.float64)
        normals = np.asarray(visible.normals[at], np.float64)
        lit[:, at] = self._irradiance(visible.ids[at], points, normals, row[at], column[at])
        return LampLight(self.stage.lights, lit, ground)

    def _mirrored(self, part: Surface, row: IntArray, column: IntArray) -> Float32Array:
        """Return the radiance (N, 3) that lamps give the ground where surfaces mirror it."""
        points = mirrored_ground(self.stage, part)
        up = np.broadcast_to(np.array([0.0, 1.0, 0.0]), points.shape)
        lit = self._irradiance(np.full(len(points), GROUND), points, up, row, column)
        white = LampLight(self.stage.lights, lit, np.zeros((0, 3))).white
        return white * ground_reflectance(self.stage).astype(np.float32)

    def _irradiance(
        self, ids: IntArray, points: FloatArray, normals: FloatArray, row: IntArray, column: IntArray
    ) -> Float32Array:
        """Return the irradiance (L, N) of points (N, 3) of the solids ``ids`` (N,) by each light of white color."""
        out = np.zeros((len(self.stage.lights), len(points)), np.float32)
        for number, light in enumerate(self.stage.lights):
            irradiance = irradiance_of(light, points, normals)
            irradiance[self._is_shut_out(light, ids, points)] = 0.0
            lit = np.flatnonzero(irradiance > 0.0)
            if len(lit):
                share = self._reached(number, points[lit], normals[lit], row[lit], column[lit])
                out[number, lit] = irradiance[lit] * share
        return out

    def _is_shut_out(self, light: Light, ids: IntArray, points: FloatArray) -> npt.NDArray[np.bool_]:
        """Return which points (N, 3) are outside a solid that encloses a lamp.

        Its shadow map does not tell a surface below the solid from the solid's lowest face, which are in one plane.
        """
        out, solids = np.zeros(len(points), bool), self.stage.solids
        if light.kind == "sun":
            return out
        for number in _enclosing(solids, np.array(light.position)):
            rows = np.flatnonzero(ids != number)
            out[rows] |= ~_is_inside(solids, np.full(len(rows), number), points[rows])
        return out

    def _reached(
        self, number: int, points: FloatArray, normals: FloatArray, row: IntArray, column: IntArray
    ) -> FloatArray:
        """Return the share (N,) of a light that reaches points (N, 3)."""
        light = self.stage.lights[number]
        if not len(self.solids):
            return np.ones(len(points))
        if light.kind == "sun":
            shadow = self._kept(number, 0, lambda: shadow_map(self.solids, -np.array(light.direction), self.size * 2))
            samples = samples_at(points.astype(np.float32), normals.astype(np.float32), column, row)
            return np.asarray(key_light(shadow, light.radius, samples), np.float64)
        share = np.ones(len(points))
        local = (points - np.array(light.position)) @ (axes := _cube_axes(light)).T
        turned = normals @ axes.T
        dominant = np.argmax(np.abs(local), axis=1)
        faces = dominant * 2 + (np.take_along_axis(local, dominant[:, None], 1)[:, 0] < 0.0)
        angle = 2.0 * math.pi * gradient_noise(column, row).astype(np.float64)
        for face in np.unique(faces):
            at = np.flatnonzero(faces == face)
            turn = _FACES[face]
            depth = self._kept(number, int(face), partial(self._cast, light, turn @ axes))
            share[at] = _lit_share(depth, light, local[at] @ turn.T, turned[at] @ turn.T, angle[at])
        return share

    def _cast(self, light: Light, axes: FloatArray) -> Float32Array:
        """Return the depths (S, S) that a lamp sees along ``axes`` (3, 3): right, up, forward."""
        focal = self.size / (2.0 * _FACE)
        camera = camera_at(np.array(light.position), (axes[0], axes[1], axes[2]), focal, self.size, self.size)
        return depths_of(caster_for(self.solids, camera_rays(camera)).cast())

    def _kept(self, number: int, face: int, cast: Callable[[], Any]) -> Any:
        """Return a map, cast at the first call."""
        if (number, face) not in self.maps:
            self.maps[number, face] = cast()
        return self.maps[number, face]

    def seen(self, rays: Rays, depth: Float32Array, samples: int) -> tuple[Float32Array, Float32Array]:
        """Return the lamps that the image shows: their radiance (H, W, 3), and the share (H, W, 1) of a pixel.

        ``depth`` are those of opaque surfaces at the samples of the image, ``samples`` per pixel and axis.
        """
        height, width = depth.shape
        nearest, radiance = depth.astype(np.float64).reshape(-1), np.zeros((depth.size, 3))
        is_seen = np.zeros(depth.size, bool)
        origin, direction = (np.asarray(v, np.float64) for v in rays.each())
        for light in self.stage.lights:
            if _shines(light):
                hit = _hit(light, origin, direction)
                front = hit < nearest
                nearest[front], radiance[front], is_seen[front] = hit[front], light.radiance, True
        shape = (height // samples, samples, width // samples, samples)
        share = is_seen.reshape(shape).mean(axis=(1, 3))[:, :, None]
        mean = radiance.reshape(*shape, 3).mean(axis=(1, 3)) / np.maximum(share, 1e-9)
        return mean.astype(np.float32), share.astype(np.float32)


def show_lamps(stage: Stage) -> npt.NDArray[np.bool_]:
    """Return which pixels (H, W) a sphere or a rectangle that shines may cover."""
    shining = [light for light in stage.lights if _shines(light)]
    if not shining:
        return np.zeros((stage.height, stage.width), bool)
    samples = 2
    origin, direction = (np.asarray(v, np.float64) for v in camera_rays(stage.camera, samples).each())
    shown = np.any([np.isfinite(_hit(light, origin, direction)) for light in shining], axis=0)
    blocks = shown.reshape(stage.height, samples, stage.width, samples)
    return np.asarray(blocks.any(axis=(1, 3)), bool)


def _enclosing(solids: Solids, place: FloatArray) -> IntArray:
    """Return the numbers (K,) of the opaque closed solids around a place (3,)."""
    rows = np.flatnonzero(solids.that_are("is_closed") & (solids.opacity >= 1.0))
    return rows[_is_inside(solids, rows, np.broadcast_to(place, (len(rows), 3)))]


def _is_inside(solids: Solids, rows: IntArray, points: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which points (N, 3) are in the solids ``rows`` (N,), each in its own one."""
    out = np.zeros(len(rows), bool)
    matrices = solids.matrices[rows]
    with np.errstate(all="ignore"):  # of flat solids, which have no inside
        local = np.einsum("nij,nj->ni", inverses_of(matrices[:, :, :3]), points - matrices[:, :, 3])
    for number in np.unique(solids.forms[rows]).tolist():
        form, same = solids.kinds[number], np.flatnonzero(solids.forms[rows] == number)
        u, v, w = local[same].T
        out[same] = form.contains(u, v, w, solids.ratios_of(form, rows[same]))
    return out


def _shines(light: Light) -> bool:
    """Return whether a light is seen itself."""
    return light.kind == "area" or (light.kind == "point" and light.radius > 0.0)


# The faces of a cube: rows right, up and forward of each, in the axes of the lamp.
_FACES = np.array([
    [[0, 0, -1], [0, 1, 0], [1, 0, 0]], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
    [[1, 0, 0], [0, 0, -1], [0, 1, 0]], [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
], np.float64)  # fmt: skip


def _cube_axes(light: Light) -> FloatArray:
    """Return the axes (3, 3) of a lamp: right, up, and the direction in which it shines."""
    right, up, forward = level_axes(np.array(light.direction))
    return np.stack([right, up, forward])


def _lit_share(
    depth: Float32Array, light: Light, local: FloatArray, normals: FloatArray, angle: FloatArray
) -> FloatArray:
    """Return the share (N,) of a lamp that is visible from points through one face.

    Parameters
    ----------
    depth : (S, S)
        Distances along the face's axis, infinite without a blocker.
    local, normals : (N, 3)
        Points relative to the lamp and their normals, in the axes of the face.
    angle : (N,)
        Rotation of the taps.
    """
    size = len(depth)
    focal = size / (2.0 * _FACE)
    texel = np.maximum(local[:, 2], 1e-9) / focal
    lifted = local + normals * (_LIFT_TEXELS * texel)[:, None]
    z = np.maximum(lifted[:, 2], 1e-9)
    u, v = lifted[:, 0] / z, lifted[:, 1] / z
    plane = np.einsum("ni,ni->n", normals, lifted)
    extent = light.radius if light.kind == "point" else 0.5 * math.sqrt(light.size[0] * light.size[1])
    most = _MAX_SHARE * size

    def heights(
        radius: FloatArray, taps: Sequence[tuple[float, float]], at: Any = slice(None), turned: FloatArray = angle
    ) -> FloatArray:
        """Return how much nearer than the points' planes the blockers at the taps are (T, N), negative for none."""
        cosine, sine = np.cos(turned[at]) * radius / focal, np.sin(turned[at]) * radius / focal
        (nx, ny, nz), far, distances = normals[at].T, z[at], []
        for dx, dy in taps:
            x, y = u[at] + dx * cosine - dy * sine, v[at] + dx * sine + dy * cosine
            slope = nx * x + ny * y + nz
            reach = np.where(slope < -1e-6, plane[at] / np.where(slope < -1e-6, slope, -1.0), 2.0 * far)
            column = np.clip(np.floor(x * focal + size / 2.0), 0, size - 1).astype(np.int64)
            row = np.clip(np.floor(size / 2.0 - y * focal), 0, size - 1).astype(np.int64)
            nearest = depth[row, column].astype(np.float64)
            distances.append(np.clip(reach, 0.25 * far, 2.0 * far) * (1.0 - _NEARER) - nearest)
        return np.stack(distances)

    radius = np.full(len(z), _MIN_TEXELS)
    if extent == 0.0:
        return np.asarray((heights(radius, disk_points(_SEARCH_TAPS)) <= 0.0).mean(axis=0), np.float64)
    # The search is not rotated: another radius at each pixel would be noise that the taps cannot average.
    still = angle * 0.0
    above = heights(np.clip(extent * focal / z, _MIN_TEXELS, most), disk_points(_SEARCH_TAPS), turned=still)
    count = (above > 0.0).sum(axis=0)
    blocker = z - np.where(above > 0.0, above, 0.0).sum(axis=0) / np.maximum(count, 1)
    penumbra = extent * np.maximum(z - blocker, 0.0) / np.maximum(blocker, 1e-9)  # by similar triangles
    radius = np.clip(np.where(count > 0, penumbra, 0.0) * focal / z, _MIN_TEXELS, most)
    share = np.ones(len(z))
    some = np.flatnonzero(count)
    for part in batches(some, _BATCH):
        share[part] = (heights(radius[part], disk_points(_SHADOW_TAPS), part) <= 0.0).mean(axis=0)
    return share


def _hit(light: Light, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the distance (N,) along rays to a sphere or to the front of an area, infinite for rays that miss it."""
    offset = np.array(light.position) - origin
    with np.errstate(invalid="ignore", divide="ignore"):
        if light.kind == "point":
            a = np.einsum("ni,ni->n", direction, direction)
            b = np.einsum("ni,ni->n", direction, offset)
            root = np.sqrt(b * b - a * (np.einsum("ni,ni->n", offset, offset) - light.radius**2))
            hit = (b - root) / a
            return np.where(np.isfinite(hit) & (hit > 0.0), hit, np.inf)
        right, up, forward = _cube_axes(light)
        against = direction @ forward
        hit = (offset @ forward) / against
        place = direction * hit[:, None] - offset
        width, height = light.size
        is_inside = (np.abs(place @ right) <= width / 2.0) & (np.abs(place @ up) <= height / 2.0)
        return np.where(is_inside & (hit > 0.0) & (against < 0.0), hit, np.inf)
