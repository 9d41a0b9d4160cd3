"""Draft backend: an analytic ray caster with soft shadows and ambient occlusion, in numpy alone.

There are four samples per pixel. A sample sees the nearest opaque solid, the ground, or the backdrop, behind at most
six transparent layers. Lighting, ground and tone curve are those of final images (``appearance``, ``mitsuba``).

Pixels inside a surface are shaded once, in their middle, with the mean of the key light at their samples where a shadow
ends. Images differ by .1 of 255 levels on average from those with every sample shaded, which take twice as long.
Datasets shade by pixel: the key light once, too, ambient light at every fourth pixel, and shadow maps of the image's
size. Such drafts differ from those by sample by one of 255 levels on average.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import sub_progress
from scenelang.backends.pictures.backdrops import (
    backdrops,
    beside,
    clearest,
    lightness,
    lines_in,
    metering,
    probing,
    stops_for,
)
from scenelang.backends.pictures.draft_lamps import Lamps
from scenelang.backends.pictures.draft_light import (
    GROUND,
    SKY,
    Reach,
    Shadow,
    ShadowMap,
    Surface,
    albedo_of,
    batches,
    darkest_at_contact,
    disk_points,
    ground_depths,
    ground_radiance,
    ground_reflectance,
    hidden_share,
    key_reach,
    occlusion,
    radiance_of,
    relieved,
    rows_of,
    samples_at,
    shadow_map,
    sky_direction_count,
    sky_light,
    sky_maps,
    smoothed,
    tap_group,
    through_glass,
)
from scenelang.backends.pictures.rays import NOTHING, Caster, Keys, Rays, camera_rays, caster_for, depths_of, ids_of
from scenelang.backends.pictures.stage import Shot, Stage, Staging, has_free_tone
from scenelang.backends.surfaces.environments import environment_of, tone_map
from scenelang.backends.surfaces.image_files import to_srgb
from scenelang.backends.surfaces.solids import Solids

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
Places = tuple[IntArray, IntArray]  # rows and columns of samples
T = TypeVar("T")

_SAMPLES = 2  # per pixel and axis
_BATCH_SAMPLES = 1 << 17  # shaded at once, which bounds the memory
_MAX_LAYERS = 6  # transparent surfaces that a sample sees
_MIN_SMOOTH_COSINE = 0.95  # between normals of neighboring pixels on one smooth surface; below it is a crease
_LENS_POINTS = 32  # pinholes by which a lens is drawn; with 16, blurred edges showed steps
_LAYER_AMBIENT = 0.9  # ambient light on transparent layers, for which no occlusion is computed
_HAZE = 0.015  # of the shadow on the ground that is left out: the precision of ambient light far from the scene
# Texels per side of the shadow map, and directions of the sky, of the draft by which the backdrop is chosen.
_PROBE_SHADOW, _PROBE_DIRECTIONS = 256, 6
_GLOW = 0.25  # of the radiance of what glows that the ground beside it gets in final images, as at half its height
_HORIZON_SAMPLES = 64  # per pixel row: the horizon is a long straight edge, on which steps are conspicuous


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A draft image of H x W pixels.

    Attributes
    ----------
    linear : (H, W, 3)
        Linear sRGB in [0, 1], after tone mapping.
    radiance : (H, W, 3)
        Linear sRGB before tone mapping.
    depth : (H, W)
        Distance to opaque surfaces along the view direction; infinite on the backdrop.
    ids : (H, W)
        Indices of the nearest solids, ``GROUND`` or ``SKY``.
    albedo, normal : (H, W, 3)
        Means over each pixel, for denoisers.
    sky : (H, W)
        Fraction of the pixel covered by the backdrop.
    alpha, shadow : (H, W)
        Share of the background that objects hide, and that the shadow on the ground of a clear stage hides in addition.
        Colors of a clear stage are multiplied by the former.
    """

    linear: Float32Array
    radiance: Float32Array
    depth: Float32Array
    ids: IntArray
    albedo: Float32Array
    normal: Float32Array
    sky: Float32Array
    alpha: Float32Array
    shadow: Float32Array


class DraftCache:
    """Values shared by the shots of a video, recomputed only when their dependencies change."""

    def __init__(self) -> None:
        self._values: dict[str, tuple[Hashable, Any]] = {}

    def get(self, name: str, depends_on: Hashable, make: Callable[[], T]) -> T:
        """Return the cached value ``name`` for ``depends_on``, calling ``make`` if it is absent or stale."""
        entry = self._values.get(name)
        if entry is None or entry[0] != depends_on:
            entry = self._values[name] = (depends_on, make())
        value: T = entry[1]
        return value


def draw(
    stage: Stage,
    progress: Callable[[float], None] | None = None,
    shaded: bool = True,
    cache: DraftCache | None = None,
    by_pixel: bool = False,
) -> Draft:
    """Draw a stage.

    Parameters
    ----------
    progress
        Called with a fraction from 0 to 1.
    shaded
        Whether to compute colors; without, only depth, ids, albedo and normal are computed, and colors are black.
    cache
        Stores the image and the light of static solids between the shots of a video.
    by_pixel
        Compute the key light once for pixels inside a surface, and ambient light at every fourth pixel.
    """
    report = progress or (lambda _: None)
    cache = cache or DraftCache()
    rays = camera_rays(stage.camera, _SAMPLES)
    caster = caster_for(stage.solids, rays)
    opaque = stage.solids.opacity >= 1.0
    keys = _opaque_keys(stage, caster, opaque, cache, lambda share: report(0.4 * share))
    layers = _layers(caster, ~opaque, keys) if not opaque.all() else []
    shaded = shaded and not stage.studio.environment.unlit
    shadows = _shadows(stage, cache, is_coarse=by_pixel) if shaded else []
    report(0.55)
    size = (stage.height, stage.width)
    pixels = _pixel_surface(stage, caster, rays, keys)
    depth = pixels.depth.reshape(size).astype(np.float32)
    step = 2 if by_pixel else 1
    ambient = _ambient(stage, pixels, depth, cache, step) if shaded else np.ones_like(depth[::step, ::step])
    lamps = None
    if shaded and stage.lights:
        is_still = stage.fixed == len(stage.solids)
        maps: dict[tuple[int, int], Any] = cache.get("lamps", (stage.lights, size), dict) if is_still else {}
        lamps = Lamps(stage, stage.solids.take(opaque), maps)
    light = _Light(shadows, ambient, depth[::step, ::step], _SAMPLES * step, lamps)
    report(0.7)
    scene = _Shading(stage, caster, rays, keys, layers, light, by_pixel)
    color, radiance, albedo, normal, sky, cover = _shade(scene, pixels, lambda share: report(0.7 + 0.3 * share))
    if lamps is not None:
        shining, share = lamps.seen(rays, depths_of(keys), _SAMPLES)
        color += (tone_map(shining, stage.studio.environment).astype(np.float32) - color) * share
        radiance += (shining - radiance) * share
    ids = pixels.ids.reshape(size)
    for layer in layers[:1]:
        ids = np.where(layer[::_SAMPLES, ::_SAMPLES] != NOTHING, ids_of(layer[::_SAMPLES, ::_SAMPLES]), ids)
    sky = sky[:, :, 0] * _above_horizon(stage, rays)
    return Draft(color, radiance, depth, ids, albedo, normal, sky, cover[:, :, 0], cover[:, :, 1])


def draw_lens(
    stage: Stage,
    progress: Callable[[float], None] | None = None,
    shaded: bool = True,
    cache: DraftCache | None = None,
    by_pixel: bool = False,
) -> Draft:
    """Draw a stage as ``draw`` does; through a lens, as the mean of what pinholes all over it see."""
    camera, cache = stage.camera, cache or DraftCache()
    if camera.aperture == 0.0 or camera.is_parallel:
        return draw(stage, progress, shaded, cache, by_pixel)
    drafts = []
    number, count = stage.instant  # instants share the points: all of them see the lens once
    points = disk_points(_LENS_POINTS)[number::count]
    for k, (right, up) in enumerate(points):
        pinhole = camera.from_lens(camera.aperture * right, camera.aperture * up)
        part = sub_progress(progress, k / len(points), (k + 1) / len(points))
        drafts.append(draw(replace(stage, camera=pinhole), part, shaded, cache, by_pixel))
    mean: dict[str, Any] = {
        name: np.mean([getattr(one, name) for one in drafts], axis=0, dtype=np.float32)
        for name in ("linear", "radiance", "albedo", "normal", "sky", "alpha", "shadow")
    }
    if shaded and not stage.is_clear:
        mean["linear"] = tone_map(mean["radiance"], stage.studio.environment).astype(np.float32)
    return replace(drafts[0], **mean)


def toned(staging: Staging, shot: Shot) -> Staging:
    """Return a staging whose backdrop shows the outline of the scene in ``shot``, unless a ground is asked for."""
    environment = environment_of(staging.environment)
    is_free = has_free_tone(environment, staging.ground, staging.lighting)
    if not is_free or staging.backdrop is not None or environment.backdrop is None:
        return staging
    shot = replace(shot, camera=probing(shot.camera))
    stage = staging.stage(shot)
    outline, reach, is_line = _outline(stage)
    if not len(outline.ids):
        return replace(staging, backdrop=environment.backdrop)
    glow = _GLOW * _emitted(stage, outline)
    choices = [replace(staging, backdrop=backdrop) for backdrop in backdrops(environment.backdrop)]

    def sides(choice: Staging) -> tuple[FloatArray, FloatArray]:
        """Return the lightness inside and outside of the outline before a backdrop."""
        tried = replace(stage, studio=choice.studio(stage.camera))
        radiance = radiance_of(tried, outline, albedo_of(tried, outline), reach)
        inside, unlit = np.split(radiance.astype(np.float64), 2)
        outside = unlit + glow * ground_reflectance(tried)
        inside = np.where(is_line[:, None], (inside + outside) / 2.0, inside)  # a line covers half of its pixels
        light = [lightness(tone_map(values, tried.studio.environment)) for values in (inside, outside)]
        return light[0], light[1]

    return choices[clearest(map(sides, choices))]


def _emitted(stage: Stage, outline: Surface) -> FloatArray:
    """Return the radiance (N, 3) that the objects at an ``outline`` emit, where the ground is outside of it; else 0."""
    inside, outside = np.split(outline.ids, 2)
    emitted = np.zeros((len(inside), 3))
    lit = outside == GROUND
    emitted[lit] = stage.solids.emission[inside[lit]]
    return emitted


def _outline(stage: Stage) -> tuple[Surface, Reach, npt.NDArray[np.bool_]]:
    """Return what is inside and then, as often, outside of the outline of the objects, the light on it, and which
    pixels inside are of lines one pixel wide."""
    size = (stage.height, stage.width)
    rays = camera_rays(stage.camera, 1)
    caster = caster_for(stage.solids, rays)
    seen = _pixel_surface(stage, caster, rays, caster.cast(stage.solids.opacity > 0.0), 1)
    solid = (seen.ids >= 0).reshape(size)
    inside, outside = beside(solid)
    pairs = np.concatenate([inside, outside])
    outline = seen.take(pairs)
    shadow = shadow_map(stage.solids, stage.studio.key_direction, _PROBE_SHADOW)
    row, column = np.divmod(pairs, stage.width)
    key = key_reach(stage, outline, [(shadow, 1.0)], row, column)
    depth = np.where(np.isfinite(seen.depth), seen.depth, np.inf).astype(np.float32).reshape(size)
    points, normals = (values.astype(np.float32).reshape(*size, 3) for values in (seen.points, seen.normals))
    near = occlusion(points, normals, depth, solid, stage.camera.focal[1]).reshape(-1)[pairs]
    samples = samples_at(outline.points, outline.normals, column, row)
    far = sky_light(sky_maps(stage.solids, _PROBE_DIRECTIONS), samples)
    reach = Reach(key, near * np.clip(far, np.float32(0.02), np.float32(1.0)))
    return outline, reach, lines_in(solid).reshape(-1)[inside]


def adjusted(staging: Staging, shot: Shot) -> Staging:
    """Return a staging with the backdrop that ``toned`` chooses, and the exposure by what ``shot`` shows if asked for.

    A staging that was adjusted stays the same.
    """
    lighting = staging.lighting
    if lighting is not None and lighting.is_metered:
        drawn = draw(staging.stage(replace(shot, camera=metering(shot.camera))), by_pixel=True)
        stops = lighting.exposure + stops_for(drawn.radiance, drawn.ids >= 0)
        staging = replace(staging, lighting=replace(lighting, exposure=stops, is_metered=False))
    return toned(staging, shot)


def _grid(height: int, width: int, step: int) -> tuple[IntArray, IntArray]:
    """Return the rows and columns (N,) of samples ``step`` apart, row by row."""
    row, column = np.divmod(np.arange(height * width), width)
    return row * step, column * step


@dataclass(frozen=True, slots=True, eq=False)
class _Light:
    """Light of an image: shadow maps, ambient light at samples ``step`` apart with the depths at these samples, and the
    lights of the program."""

    shadows: list[Shadow]
    ambient: Float32Array
    depth: Float32Array
    step: int
    lamps: Lamps | None


@dataclass(frozen=True, slots=True, eq=False)
class _Shading:
    """Input of the shading of samples: the stage, its rays, and the keys of opaque solids and transparent layers."""

    stage: Stage
    caster: Caster
    rays: Rays
    keys: Keys
    layers: list[Keys]
    light: _Light
    by_pixel: bool

    def at_samples(self, row: IntArray, column: IntArray) -> tuple[Float32Array, ...]:
        """Return color, radiance, albedo, normal (N, 3), sky coverage (N, 1), alpha and shadow (N, 2) of samples."""
        visible = _surface(self.stage, self.caster, self.rays, self.keys, row, column)
        shadows = self.light.shadows
        ambient = _interpolated(self.light, visible.depth, row, column)
        over = []
        for layer in self.layers:
            at = np.flatnonzero(layer[row, column] != NOTHING)
            part = _surface(self.stage, self.caster, self.rays, layer, row[at], column[at])
            key = key_reach(self.stage, part, shadows, row[at], column[at])
            reach = Reach(key, np.full(len(at), _LAYER_AMBIENT, np.float32))
            over.append((at, part, reach, (row[at], column[at])))
        reach = Reach(key_reach(self.stage, visible, shadows, row, column), ambient)
        return _shaded(self, visible, reach, over, (row, column))


def _outputs(stage: Stage) -> list[Float32Array]:
    """Return empty images for color, radiance, albedo, normal, sky coverage, and alpha with shadow."""
    return [np.zeros((stage.height, stage.width, channels), np.float32) for channels in (3, 3, 3, 3, 1, 2)]


def _shade(scene: _Shading, pixels: Surface, report: Callable[[float], None]) -> list[Float32Array]:
    """Return the outputs of an image; pixels that are inside a surface of ``pixels`` are shaded once."""
    stage, outputs = scene.stage, _outputs(scene.stage)
    flat = [output.reshape(-1, output.shape[2]) for output in outputs]
    inside = _is_inside(scene, pixels)
    reach = _pixel_reach(scene, pixels, inside)
    report(0.3)
    for part in batches(np.flatnonzero(inside), _BATCH_SAMPLES):
        light = reach.take(part)
        row, column = np.divmod(part, stage.width)
        places = row * _SAMPLES, column * _SAMPLES
        for output, values in zip(flat, _shaded(scene, pixels.take(part), light, [], places), strict=True):
            output[part] = values
    report(0.6)
    for part in batches(np.flatnonzero(~inside), _BATCH_SAMPLES // _SAMPLES**2):
        row, column, owner, weight = _distinct(scene, part)
        for output, values in zip(flat, scene.at_samples(row, column), strict=True):
            for channel in range(values.shape[1]):
                output[part, channel] = np.bincount(owner, values[:, channel] * weight, len(part))
    report(1.0)
    return outputs


def _pixel_reach(scene: _Shading, pixels: Surface, inside: npt.NDArray[np.bool_]) -> Reach:
    """Return the light that reaches the pixels (H * W,) that are ``inside`` a surface.

    Where the key light changes between neighboring pixels, its share is the mean over the samples: these are the
    penumbras, in which one sample shows the pattern of its taps, and the edges of shadows, which are sharper than a
    pixel.
    """
    stage, light, size = scene.stage, scene.light, (scene.stage.height, scene.stage.width)
    row, column = _grid(*size, _SAMPLES)
    if light.step == _SAMPLES:
        ambient = light.ambient.reshape(-1)
    else:
        ambient = _interpolated(light, pixels.depth, row, column)
    key = key_reach(stage, pixels, light.shadows, row, column)
    if scene.by_pixel or not light.shadows:
        return Reach(key, ambient)
    uneven = _is_uneven(key.reshape(size)).reshape(-1) & inside
    for part in batches(np.flatnonzero(uneven), _BATCH_SAMPLES // _SAMPLES**2):
        rows, columns = _samples_of(part, stage.width)
        seen = _surface(stage, scene.caster, scene.rays, scene.keys, rows.reshape(-1), columns.reshape(-1))
        share = key_reach(stage, seen, light.shadows, rows.reshape(-1), columns.reshape(-1))
        key[part] = share.reshape(-1, _SAMPLES**2).mean(axis=1)
    return Reach(key, ambient)


def _is_uneven(values: Float32Array) -> npt.NDArray[np.bool_]:
    """Return where ``values`` (H, W) differ from one of the eight around them."""
    low = high = np.pad(values, 1, mode="edge")
    for axis in (0, 1):
        parts = [np.take(low, np.arange(k, low.shape[axis] - 2 + k), axis) for k in range(3)]
        tops = [np.take(high, np.arange(k, high.shape[axis] - 2 + k), axis) for k in range(3)]
        low, high = np.minimum.reduce(parts), np.maximum.reduce(tops)
    return np.asarray(low < high, bool)


def _samples_of(pixels: IntArray, width: int) -> tuple[IntArray, IntArray]:
    """Return the rows and columns (N, samples) of the samples of ``pixels`` (N,) of an image of ``width``."""
    down, right = np.divmod(np.arange(_SAMPLES * _SAMPLES), _SAMPLES)
    row, column = np.divmod(pixels, width)
    return (row * _SAMPLES)[:, None] + down, (column * _SAMPLES)[:, None] + right


def _distinct(scene: _Shading, pixels: IntArray) -> tuple[IntArray, IntArray, IntArray, Float32Array]:
    """Return the samples (N,) to shade of pixels that show several surfaces: row, column, pixel and weight.

    In a pixel of several solids, the first sample of each stands for all of that solid. In other pixels, at a crease or
    the horizon, all samples are shaded.
    """
    per_pixel = _SAMPLES * _SAMPLES
    row, column = _samples_of(pixels, scene.stage.width)
    number = scene.keys[row, column].astype(np.uint32)
    same = number[:, :, None] == number[:, None, :]
    is_first = np.argmax(same, axis=2) == np.arange(per_pixel)
    weight = same.sum(axis=2, dtype=np.float32) / np.float32(per_pixel)
    every = same.all(axis=(1, 2))  # a crease or the horizon
    for layer in scene.layers:
        every |= (layer[row, column] != NOTHING).any(axis=1)
    is_first[every], weight[every] = True, np.float32(1.0 / per_pixel)
    owner, place = np.nonzero(is_first)
    return row[owner, place], column[owner, place], owner, weight[owner, place]


def _is_inside(scene: _Shading, pixels: Surface) -> npt.NDArray[np.bool_]:
    """Return the pixels (H * W,) whose samples all see one smooth opaque surface, directly."""
    stage = scene.stage
    shape = (stage.height, stage.width)
    is_inside = _is_uniform(scene.keys.astype(np.uint32))
    for layer in scene.layers:
        is_inside &= (layer.reshape(shape[0], _SAMPLES, shape[1], _SAMPLES) == NOTHING).all(axis=(1, 3))
    ids = pixels.ids.reshape(shape)
    normal = pixels.normals.astype(np.float32).reshape(*shape, 3)
    for before, after in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):  # the ground's edge, and creases
        one, other, turned = ids[before], ids[after], normal[after]
        bend = np.einsum("rci,rci->rc", normal[before], turned)
        is_smooth = np.where(one == other, bend > _MIN_SMOOTH_COSINE, (one >= 0) | (other >= 0))
        is_inside[before] &= is_smooth
        is_inside[after] &= is_smooth
    ground = stage.studio.ground
    if ground is not None and not (ground[0] == ground[1]).all():
        is_inside &= ids != GROUND
    return np.asarray(is_inside.reshape(-1), bool)


def _is_uniform(values: npt.NDArray[Any], samples: int = _SAMPLES) -> npt.NDArray[np.bool_]:
    """Return the pixels (H, W) whose ``samples`` x ``samples`` values are equal."""
    first = values[::samples, ::samples]
    uniform = np.ones(first.shape, bool)
    for down, right in np.ndindex(samples, samples):
        uniform &= values[down::samples, right::samples] == first
    return uniform


def _opaque_keys(
    stage: Stage, caster: Caster, opaque: npt.NDArray[np.bool_], cache: DraftCache, progress: Callable[[float], None]
) -> Keys:
    """Return the ray-cast keys of the opaque solids; those of static solids are cast once per camera."""
    fixed = np.arange(len(stage.solids)) < stage.fixed
    if not fixed.any():
        return caster.cast(opaque, progress=progress)
    still = cache.get("keys", stage.camera.identity, lambda: caster.cast(opaque & fixed, progress=progress))
    return np.minimum(still, caster.cast(opaque & ~fixed))


def _has_level_horizon(stage: Stage) -> bool:
    """Return whether the horizon is a row of the image: a ground seen by a perspective camera that is not rolled."""
    return stage.ground is not None and not stage.camera.is_parallel and abs(float(stage.camera.right[1])) < 1e-9


def _above_horizon(stage: Stage, rays: Rays) -> Float32Array:
    """Return the fraction (H, 1) of each pixel row above a level horizon, at a higher resolution than the samples."""
    if not _has_level_horizon(stage):
        return np.ones((stage.height, 1), np.float32)
    y = (np.arange(stage.height * _HORIZON_SAMPLES, dtype=np.float64) + 0.5) * (_SAMPLES / _HORIZON_SAMPLES)
    _, direction = rays.at(np.full(len(y), rays.width / 2.0), y)
    share: Float32Array = (direction[:, 1] >= 0.0).reshape(-1, _HORIZON_SAMPLES).mean(axis=1, dtype=np.float32)[:, None]
    return share


def _shadows(stage: Stage, cache: DraftCache, *, is_coarse: bool) -> list[Shadow]:
    """Return the shadow maps of opaque and of transparent solids."""
    side = max(stage.width, stage.height)
    size = min(1024, max(192, side * 3 // 2)) if is_coarse else max(256, min(1024, 2 * side)) if side <= 640 else 2048
    direction, opaque = stage.studio.key_direction, stage.solids.opacity >= 1.0

    def cast(solids: Solids) -> ShadowMap:
        """Return the shadow map of the key light."""
        return shadow_map(solids, direction, size)

    (opaque_shadow,) = _cached_maps(stage, cache, "key", direction.tobytes(), lambda solids: [cast(solids)])
    shadows = [(opaque_shadow, 1.0)]
    if not opaque.all():
        clear = stage.solids.take(~opaque)
        shadows.append((shadow_map(clear, direction, size // 2), float(hidden_share(clear).mean())))
    return shadows


def _cached_maps(
    stage: Stage, cache: DraftCache, name: str, depends_on: Hashable, cast: Callable[[Solids], list[ShadowMap]]
) -> list[ShadowMap]:
    """Return the maps that ``cast`` computes for the opaque solids, caching the part of the static ones."""
    opaque = stage.solids.opacity >= 1.0
    fixed = np.arange(len(stage.solids)) < stage.fixed
    if fixed.all() and len(fixed):
        return cache.get(name, depends_on, lambda: cast(stage.solids.take(opaque)))
    moving = cast(stage.solids.take(opaque & ~fixed))
    if not fixed.any():
        return moving
    still = cache.get(name, depends_on, lambda: cast(stage.solids.take(opaque & fixed)))
    return [one.before(other) for one, other in zip(still, moving, strict=True)]


def _layers(caster: Caster, which: npt.NDArray[np.bool_], opaque: Keys) -> list[Keys]:
    """Return the keys of transparent solids in front of ``opaque`` by depth peeling (Everitt, 2001), nearest first."""
    layers: list[Keys] = []
    beyond = None
    for _ in range(_MAX_LAYERS):
        keys = caster.cast(which, beyond)
        beyond = keys.copy()
        keys = np.where(keys < opaque, keys, NOTHING)
        if (keys == NOTHING).all():
            break
        layers.append(keys)
    return layers


def _surface(stage: Stage, caster: Caster, rays: Rays, keys: Keys, row: IntArray, column: IntArray) -> Surface:
    """Return the surface points that the samples (``row``, ``column``) (N,) of a picture with ``keys`` see."""
    seen = keys[row, column]
    x, y = column.astype(np.float64) + 0.5, row.astype(np.float64) + 0.5
    return _surface_at(stage, caster, rays.at(x, y), ids_of(seen), depths_of(seen).astype(np.float64))


def _pixel_surface(stage: Stage, caster: Caster, rays: Rays, keys: Keys, samples: int = _SAMPLES) -> Surface:
    """Return the surface that each pixel (H * W,) sees: in its middle, or at its first sample if its samples differ.

    There are ``samples`` of them per pixel and axis.
    """
    row, column = _grid(stage.height, stage.width, samples)
    depths = depths_of(keys)
    middle = sum(depths[i::samples, k::samples] for i, k in np.ndindex(samples, samples)) / np.float32(samples**2)
    whole = _is_uniform(keys.astype(np.uint32), samples)
    depth = np.where(whole, middle, depths[::samples, ::samples]).reshape(-1).astype(np.float64)
    shift = np.where(whole, 0.5 * samples, 0.5).reshape(-1)
    x, y = column.astype(np.float64) + shift, row.astype(np.float64) + shift
    ids = ids_of(keys[::samples, ::samples]).reshape(-1)
    return _surface_at(stage, caster, rays.at(x, y), ids, depth)


def _surface_at(
    stage: Stage, caster: Caster, rays: tuple[FloatArray, FloatArray], ids: IntArray, depth: FloatArray
) -> Surface:
    """Return the surface that ``rays``, origins and directions (N, 3), see of the solids ``ids`` at ``depth``."""
    origin, direction = rays
    ids[ids < 0] = SKY
    if stage.ground is not None:
        fall = ground_depths(stage.ground, origin, direction)
        ground = fall < depth
        ids[ground], depth[ground] = GROUND, fall[ground]
    solid = np.flatnonzero(ids >= 0)
    points = origin + direction * np.where(ids == SKY, 0.0, depth)[:, None]
    normals = np.zeros((3, len(ids)), np.float32).T
    normals[:, 1] = ids < 0
    normals[solid] = caster.surface(ids[solid], rows_of(points, solid), rows_of(direction, solid))
    direction = direction.astype(np.float32)
    view = direction / np.sqrt(np.einsum("ni,ni->n", direction, direction))[:, None]
    return Surface(ids, depth, points.astype(np.float32), normals, view)


def _ambient(stage: Stage, first: Surface, depth: Float32Array, cache: DraftCache, step: int) -> Float32Array:
    """Return the share of ambient light (H, W) at the pixels that are ``step`` apart, which see ``first``."""
    if step > 1:
        height, width = depth.shape
        row, column = _grid(-(-height // step), -(-width // step), step)
        first, depth = first.take(row * width + column), depth[::step, ::step]
    shape = depth.shape
    focal = stage.camera.focal[1] / step
    points = first.points.astype(np.float32).reshape(*shape, 3)
    normals = first.normals.astype(np.float32).reshape(*shape, 3)
    reach = np.ones_like(depth) if stage.camera.is_parallel else depth
    near = occlusion(
        points, normals, np.where(np.isfinite(depth), reach, depth), (first.ids >= 0).reshape(shape), focal
    )
    at = np.flatnonzero(first.ids != SKY)
    row, column = np.divmod(at, shape[1])
    places = sky_direction_count(stage.solids)
    maps = _cached_maps(stage, cache, "sky", places, lambda solids: sky_maps(solids, places))
    samples = samples_at(rows_of(first.points, at), rows_of(first.normals, at), column, row)
    far = np.ones(first.ids.size, np.float32)
    far[at] = sky_light(maps, samples, tap_group(row, column))
    # Once, a fraction of the noise by which taps are turned stays: stripes where surfaces are half open to the sky.
    open_sky = smoothed(smoothed(far.reshape(shape), depth), depth)
    share = near * np.clip(open_sky, np.float32(0.02), np.float32(1.0))
    return darkest_at_contact(share, (first.ids == GROUND).reshape(shape), (first.ids >= 0).reshape(shape))


def _shaded(
    scene: _Shading,
    visible: Surface,
    reach: Reach,
    layers: list[tuple[IntArray, Surface, Reach, Places]],
    places: Places,
) -> tuple[Float32Array, ...]:
    """Return color, radiance, albedo, normal (N, 3), sky coverage (N, 1), alpha and shadow (N, 2) of samples.

    The samples are behind transparent layers.

    ``layers`` are surfaces, the nearest first, each with the indices of the samples that see it, its light, and the
    rows and columns of these samples; ``places`` are those of all samples.
    """
    stage, lamps = scene.stage, scene.light.lamps
    environment = stage.studio.environment
    albedo = albedo_of(stage, visible)
    normals = visible.normals.astype(np.float32, copy=False)
    empty = (visible.ids < 0 if _has_level_horizon(stage) else visible.ids == SKY).astype(np.float32)[:, None]
    lit = relieved(stage, visible)
    if lamps is not None:
        reach = replace(reach, lamps=lamps.light(lit, *places))
    radiance = radiance_of(stage, lit, albedo, reach)
    cover = np.zeros((len(visible.ids), 2), np.float32)
    cover[:, 0] = visible.ids >= 0
    if stage.is_clear:
        cover[:, 1] = _shadow_share(stage, visible, radiance)
        radiance[visible.ids < 0] = 0.0
    color = tone_map(radiance, environment).astype(np.float32)
    hidden = hidden_share(stage.solids).astype(np.float32) if layers else np.zeros(0, np.float32)
    for at, part, light, seen in reversed(layers):
        layer_albedo, share = albedo_of(stage, part), hidden[part.ids][:, None]
        lit = relieved(stage, part)
        if lamps is not None:
            light = replace(light, lamps=lamps.light(lit, *seen))
        shade = radiance_of(stage, lit, layer_albedo, light)
        for under, over in (
            (color, tone_map(shade, environment).astype(np.float32)),
            (radiance, shade),
            (albedo, layer_albedo),
            (normals, part.normals.astype(np.float32)),
            (cover, np.array([[1.0, 0.0]], np.float32)),
        ):
            under[at] += (over - under[at]) * share
        rows, glass, reflected = through_glass(stage, part, light, radiance[at])
        pixels, rest = at[rows], 1.0 - share[rows]
        radiance[pixels] += rest * (glass - radiance[pixels])
        color[pixels] = tone_map(radiance[pixels], environment)
        cover[pixels, :1] += (1.0 - cover[pixels, :1]) * reflected
    return color, radiance, albedo, normals, empty, cover


def _shadow_share(stage: Stage, visible: Surface, radiance: Float32Array) -> Float32Array:
    """Return how black (N,) the shadow on the ground is: what a viewer must put over the lit ground to see it shaded.

    Viewers blend encoded colors, so that the share is that of encoded colors. Far from the scene the ambient light is
    known to about a percent, which would be a haze: that much is left out.
    """
    share = np.zeros(len(visible.ids), np.float32)
    at = np.flatnonzero(visible.ids == GROUND)
    if len(at) and not stage.studio.environment.unlit:
        environment = stage.studio.environment
        lit = to_srgb(tone_map(ground_radiance(stage), environment)).mean()
        shaded = to_srgb(tone_map(radiance[at], environment)).mean(axis=1)
        share[at] = np.clip((1.0 - shaded / lit - _HAZE) / (1.0 - _HAZE), 0.0, 1.0)
    return share


def _interpolated(light: _Light, depth: npt.NDArray[np.float64], row: IntArray, column: IntArray) -> Float32Array:
    """Interpolate ambient light at samples (N,) from the four around them, weighted by similarity in depth.

    This is a joint bilateral upsampling (Kopf et al., 2007): light does not leak across edges.
    """
    height, width = light.ambient.shape
    r, c = row // light.step, column // light.step
    down, right = row % light.step, column % light.step
    total = np.zeros(len(row), np.float32)
    weight = np.zeros(len(row), np.float32)
    near = np.where(np.isfinite(depth), depth, 1e9).astype(np.float32)
    depths, ambient = np.where(np.isfinite(light.depth), light.depth, np.float32(1e9)).reshape(-1), light.ambient
    for dr in (0, 1):
        for dc in (0, 1):
            if light.step == _SAMPLES:
                # Pixels store the values of their first samples, so the second sample is between two pixels.
                lower, further, area = r + dr * down, c + dc * right, np.ones(1, np.float32)
            else:
                lower, further = r + dr, c + dc
                across = (light.step - right if dc == 0 else right).astype(np.float32)
                area = np.asarray((light.step - down if dr == 0 else down).astype(np.float32) * across, np.float32)
            index = np.minimum(lower, height - 1) * width + np.minimum(further, width - 1)
            other = depths[index]
            share = np.float32(1e-4) + np.exp(-np.minimum(np.abs(other - near) / (0.01 * near), 60.0))
            share = share * area
            total += share * ambient.reshape(-1)[index]
            weight += share
    return np.asarray(total / weight, np.float32)
