"""Draft pictures: an analytic ray caster with soft shadows and ambient occlusion, in numpy alone.

Four samples per pixel; a sample sees the nearest opaque solid, the ground, or the backdrop, with up to six see-through
layers before it. Light, ground and film are those of final pictures (``studio``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.cast import NOTHING, Caster, Keys, Rays, caster_for, depths_of, ids_of, view_rays
from scenelang.backends.shade import ShadowMap, key_light, occlusion, shadow_map, sky_light, smoothed
from scenelang.backends.solids import Form, Solids
from scenelang.backends.stage import Stage
from scenelang.backends.studio import AMBIENT, BACKDROP, BRIGHTEST, GROUND_EDGE, KEY, tone

Float32Array = npt.NDArray[np.float32]
FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

Shadow = tuple[ShadowMap, float]  # and the share of the light that what casts it takes

GROUND = -1
SKY = -2
_SAMPLES = 2  # per pixel and direction
_BAND = 1 << 17  # samples shaded at once
_LAYERS = 6


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A draft picture of H x W pixels.

    ``linear`` (H, W, 3) is after the film's tone curve, linear sRGB in [0, 1]; ``depth`` (H, W) of opaque surfaces
    along the view, infinity on the backdrop; ``ids`` (H, W) the nearest solids' numbers, GROUND or SKY; ``albedo`` and
    ``normal`` (H, W, 3) are averaged over each pixel, for denoisers; ``sky`` (H, W) is its share of backdrop.
    """

    linear: Float32Array
    depth: Float32Array
    ids: IntArray
    albedo: Float32Array
    normal: Float32Array
    sky: Float32Array


@dataclass(frozen=True, slots=True, eq=False)
class _Surface:
    """What N samples see: numbers, depths, points and unit normals against the view."""

    ids: IntArray
    depth: FloatArray
    points: FloatArray
    normals: FloatArray


def draw(stage: Stage, progress: Callable[[float], None] | None = None, shaded: bool = True) -> Draft:
    """Draw ``stage``; without ``shaded`` only geometry (depth, ids, albedo, normal), ``linear`` is black."""
    report = progress or (lambda _: None)
    rays = view_rays(stage.view, stage.width * _SAMPLES, stage.height * _SAMPLES)
    caster = caster_for(stage.solids, rays)
    opaque = stage.solids.opacity >= 1.0
    keys = caster.cast(opaque, progress=lambda share: report(0.4 * share))
    layers = _layers(caster, ~opaque, keys) if not opaque.all() else []
    shadows = _shadows(stage) if shaded else []
    report(0.55)
    first = _surface(stage, caster, rays, keys[::_SAMPLES, ::_SAMPLES], 0, _SAMPLES)
    size = (stage.height, stage.width)
    depth = first.depth.reshape(size).astype(np.float32)
    ambient = _ambient(stage, first, depth) if shaded else np.ones(size, np.float32)
    report(0.7)
    outputs = [np.zeros((*size, channels), np.float32) for channels in (3, 3, 3, 1)]
    rows = max(1, _BAND // (stage.width * _SAMPLES * _SAMPLES))
    for top in range(0, stage.height, rows):
        bottom = min(stage.height, top + rows)
        band = slice(top * _SAMPLES, bottom * _SAMPLES)
        parts = _band(
            stage, caster, rays, keys[band], [layer[band] for layer in layers], band.start, shadows, ambient, depth
        )
        for output, part in zip(outputs, parts, strict=True):
            output[top:bottom] = _averaged(part, bottom - top, stage.width)
        report(0.7 + 0.3 * bottom / stage.height)
    color, albedo, normal, sky = outputs
    ids = first.ids.reshape(size)
    for layer in layers[:1]:
        ids = np.where(layer[::_SAMPLES, ::_SAMPLES] != NOTHING, ids_of(layer[::_SAMPLES, ::_SAMPLES]), ids)
    return Draft(color, depth, ids, albedo, normal, sky[:, :, 0] * _above_horizon(stage, rays))


def _above_horizon(stage: Stage, rays: Rays) -> Float32Array:
    """The share (H, 1) of each row of pixels that looks above the ground's horizon, which is level."""
    if stage.ground is None:
        return np.ones((stage.height, 1), np.float32)
    y = (np.arange(stage.height * 64, dtype=np.float64) + 0.5) * (_SAMPLES / 64)
    _, direction = rays.at(np.full(len(y), rays.width / 2.0), y)
    share: Float32Array = (direction[:, 1] >= 0.0).reshape(-1, 64).mean(axis=1, dtype=np.float32)[:, None]
    return share


def _shadows(stage: Stage) -> list[Shadow]:
    """The shadows of opaque and of see-through solids."""
    size = 1024 if max(stage.width, stage.height) <= 640 else 2048
    direction, opaque = stage.studio.key_direction, stage.solids.opacity >= 1.0
    shadows = [(shadow_map(stage.solids.take(opaque), direction, size), 1.0)]
    if not opaque.all():
        clear = stage.solids.take(~opaque)
        shadows.append((shadow_map(clear, direction, size // 2), float(_hidden_share(clear).mean())))
    return shadows


def _layers(caster: Caster, which: npt.NDArray[np.bool_], opaque: Keys) -> list[Keys]:
    """The keys of see-through solids before ``opaque``, nearest layer first."""
    layers: list[Keys] = []
    beyond = None
    for _ in range(_LAYERS):
        keys = caster.cast(which, beyond)
        beyond = keys.copy()
        keys = np.where(keys < opaque, keys, NOTHING)
        if (keys == NOTHING).all():
            break
        layers.append(keys)
    return layers


def _surface(stage: Stage, caster: Caster, rays: Rays, keys: Keys, top: int, step: int) -> _Surface:
    """What the samples of ``keys`` (R, C) see; these lie ``step`` samples apart, from row ``top`` on."""
    rows, columns = np.divmod(np.arange(keys.size), keys.shape[1])
    _, direction = rays.at(columns * step + 0.5, rows * step + top + 0.5)
    ids = ids_of(keys).reshape(-1)
    depth = depths_of(keys).reshape(-1).astype(np.float64)
    ids[ids < 0] = SKY
    if stage.ground is not None:
        drop = direction[:, 1]
        falls = drop < -1e-9
        fall = np.where(falls, (stage.ground - stage.view.eye[1]) / np.where(falls, drop, -1.0), 1e30)
        across = np.hypot(stage.view.eye[0] + direction[:, 0] * fall, stage.view.eye[2] + direction[:, 2] * fall)
        ground = (fall < depth) & (across < GROUND_EDGE)
        ids[ground], depth[ground] = GROUND, fall[ground]
    points = stage.view.eye + direction * np.where(np.isfinite(depth), depth, 0.0)[:, None]
    normals = np.zeros((len(ids), 3))
    normals[ids < 0, 1] = 1.0
    solid = np.flatnonzero(ids >= 0)
    normals[solid] = caster.surface(ids[solid], points[solid], direction[solid])
    return _Surface(ids, depth, points, normals)


def _ambient(stage: Stage, first: _Surface, depth: Float32Array) -> Float32Array:
    shape = (stage.height, stage.width)
    focal = stage.height / (2.0 * stage.view.tangent)
    points = first.points.astype(np.float32).reshape(*shape, 3)
    normals = first.normals.astype(np.float32).reshape(*shape, 3)
    near = occlusion(points, normals, depth, (first.ids >= 0).reshape(shape), focal)
    row, column = np.divmod(np.arange(first.ids.size), stage.width)
    at = np.flatnonzero(first.ids != SKY)
    opaque = stage.solids.take(stage.solids.opacity >= 1.0)
    far = np.ones(first.ids.size, np.float32)
    far[at] = sky_light(opaque, first.points[at], first.normals[at], column[at], row[at])
    return smoothed(near * far.reshape(shape), depth)


def _band(
    stage: Stage,
    caster: Caster,
    rays: Rays,
    keys: Keys,
    layers: list[Keys],
    top: int,
    shadows: list[Shadow],
    ambient: Float32Array,
    depth: Float32Array,
) -> tuple[Float32Array, ...]:
    """Colour, albedo, normal (N, 3) and emptiness (N, 1) of the samples of a band of rows, from row ``top`` on."""
    seen = _surface(stage, caster, rays, keys, top, 1)
    albedo = _albedo(stage, seen.ids)
    normals, empty = seen.normals.astype(np.float32), (seen.ids < 0).astype(np.float32)[:, None]
    color = np.zeros_like(albedo)
    row, column = np.divmod(np.arange(keys.size), keys.shape[1])
    row = row + top
    if shadows:
        light = _fetched(ambient, depth, seen.depth, row, column)
        color = tone(_lit(stage, seen, albedo, shadows, light, row, column)).astype(np.float32)
    for layer in reversed(layers):
        at = np.flatnonzero(layer.reshape(-1) != NOTHING)
        if len(at):
            over = _surface(stage, caster, rays, layer, top, 1)
            part = _Surface(over.ids[at], over.depth[at], over.points[at], over.normals[at])
            own = _albedo(stage, part.ids)
            share = _hidden_share(stage.solids)[part.ids].astype(np.float32)[:, None]
            if shadows:
                light = np.full(len(at), 0.9, np.float32)
                shade = tone(_lit(stage, part, own, shadows, light, row[at], column[at])).astype(np.float32)
                color[at] += (shade - color[at]) * share
            albedo[at] += (own - albedo[at]) * share
            normals[at] += (part.normals.astype(np.float32) - normals[at]) * share
    return color, albedo, normals, empty


def _hidden_share(solids: Solids) -> FloatArray:
    """How much of what is behind each solid (N,) it hides: light passes the surface of a closed one twice."""
    return np.where(solids.forms == Form.TRIANGLE, solids.opacity, 1.0 - (1.0 - solids.opacity) ** 2)


def _albedo(stage: Stage, ids: IntArray) -> Float32Array:
    out = np.empty((len(ids), 3), np.float32)
    out[ids < 0] = stage.studio.ground  # the backdrop too, so that denoisers see no horizon
    solid = np.flatnonzero(ids >= 0)
    out[solid] = stage.solids.colors[ids[solid]] * BRIGHTEST
    return out


def _fetched(
    ambient: Float32Array, depth: Float32Array, own: FloatArray, row: IntArray, column: IntArray
) -> Float32Array:
    """``ambient`` at samples (N,), from the four pixels around each, the nearer in depth the more."""
    height, width = ambient.shape
    r, c = row // _SAMPLES, column // _SAMPLES
    total = np.zeros(len(row), np.float32)
    weight = np.zeros(len(row), np.float32)
    near = np.where(np.isfinite(own), own, 1e9).astype(np.float32)
    for dr in (0, 1):
        for dc in (0, 1):
            # pixels hold the values of their first samples, so the second lies between two pixels
            index = np.minimum(r + dr * (row % _SAMPLES), height - 1) * width + np.minimum(
                c + dc * (column % _SAMPLES), width - 1
            )
            other = depth.reshape(-1)[index]
            other = np.where(np.isfinite(other), other, np.float32(1e9))
            share = np.float32(1e-4) + np.exp(-np.minimum(np.abs(other - near) / (0.01 * near), 60.0))
            total += share * ambient.reshape(-1)[index]
            weight += share
    return total / weight


def _lit(
    stage: Stage,
    seen: _Surface,
    albedo: Float32Array,
    shadows: list[Shadow],
    ambient: Float32Array,
    row: IntArray,
    column: IntArray,
) -> Float32Array:
    """The radiance (N, 3) that samples see."""
    backdrop, key, sky = (np.array(light, np.float32) for light in (BACKDROP, KEY, AMBIENT))
    facing = np.maximum(seen.normals @ stage.studio.key_direction, 0.0).astype(np.float32)
    at = np.flatnonzero((seen.ids != SKY) & (facing > 0.0))
    for shadow, hidden in shadows:
        reaches = key_light(shadow, seen.points[at], seen.normals[at], column[at], row[at])
        facing[at] *= 1.0 - np.float32(hidden) * (1.0 - reaches)
    solid = seen.ids >= 0
    around = np.broadcast_to(sky, albedo.shape)
    if stage.ground is not None:  # from below comes the ground's light, but near it lies the solid's own shadow
        height = np.clip(seen.points[:, 1] - stage.ground, 0.0, 10.0).astype(np.float32)
        below = np.where(solid, 0.5 - 0.5 * seen.normals[:, 1], 0.0).astype(np.float32)
        turned_away = (0.5 - 0.5 * seen.normals @ stage.studio.key_direction).astype(np.float32)
        shaded = np.float32(0.7) * turned_away * np.exp(-height / np.float32(0.35))
        around = sky + below[:, None] * (backdrop * (1.0 - shaded)[:, None] - sky)
    # what hides the surrounding light is itself lit, the less the deeper it lies, and taken to have the same colour
    share = ambient[:, None]
    lit = (np.float32(0.5) * sky + np.float32(0.28) * key) * (np.float32(0.3) + np.float32(0.7) * share)
    bounced = np.where(solid[:, None], albedo, np.float32(0.4)) * lit
    color = albedo * (around * share + bounced * (1.0 - share) + key * facing[:, None])
    color[solid] += stage.solids.emission[seen.ids[solid]].astype(np.float32)
    color[seen.ids == SKY] = backdrop
    return np.asarray(color, np.float32)


def _averaged(samples: Float32Array, height: int, width: int) -> Float32Array:
    grid = samples.reshape(height, _SAMPLES, width, _SAMPLES, -1)
    average: Float32Array = grid.mean(axis=(1, 3))
    return average
