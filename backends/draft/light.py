"""What surfaces radiate towards the eye in draft pictures: even scattering, highlights, reflections of the room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.draft.shade import ShadowMap, key_light, samples_at
from scenelang.backends.solids import Form, Solids
from scenelang.backends.stage import Stage
from scenelang.backends.studio import BRIGHTEST, GROUND_EDGE, ground_colors

Float32Array = npt.NDArray[np.float32]
FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Shadow = tuple[ShadowMap, float]  # and the share of the light that what casts it takes

GROUND = -1
SKY = -2
_LEAST_ROUGHNESS = 0.06  # below it the highlight of the key light is as large as the light


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """What N samples see: numbers, depths, points, unit normals against the view, unit directions of the view."""

    ids: IntArray
    depth: FloatArray
    points: FloatArray
    normals: FloatArray
    view: FloatArray

    def take(self, rows: IntArray) -> Surface:
        return Surface(self.ids[rows], self.depth[rows], self.points[rows], self.normals[rows], self.view[rows])


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """What light reaches N samples: what ``shadows`` leave of the key light, the share ``ambient`` (N,) of the
    surrounding light. ``row`` and ``column`` (N,) are the samples' places."""

    shadows: list[Shadow]
    ambient: Float32Array
    row: IntArray
    column: IntArray


def hidden_share(solids: Solids) -> FloatArray:
    """How much of what is behind each solid (N,) it hides: light passes the surface of a closed one twice."""
    return np.where(solids.forms == Form.TRIANGLE, solids.opacity, 1.0 - (1.0 - solids.opacity) ** 2)


def albedo_of(stage: Stage, seen: Surface) -> Float32Array:
    """The reflectance (N, 3) of what is seen; of the ground where nothing is, so that denoisers see no horizon."""
    out = np.zeros((len(seen.ids), 3), np.float32)
    ground = stage.studio.ground
    if ground is not None:
        out[:] = ground.mean(axis=0)
        at = np.flatnonzero(seen.ids == GROUND)
        out[at] = ground_colors(ground, seen.points[at, 0], seen.points[at, 2])
    solid = np.flatnonzero(seen.ids >= 0)
    brightest = 1.0 if stage.studio.environment.unlit else BRIGHTEST
    out[solid] = stage.solids.colors[seen.ids[solid]] * brightest
    return out


def radiance_of(stage: Stage, seen: Surface, albedo: Float32Array, reach: Reach) -> Float32Array:
    """The radiance (N, 3) that samples see."""
    environment = stage.studio.environment
    solid = np.flatnonzero(seen.ids >= 0)
    if environment.unlit:
        color = albedo.copy()
    else:
        color = _lit(stage, seen, albedo, reach)
    color[solid] += stage.solids.emission[seen.ids[solid]].astype(np.float32)
    color[seen.ids == SKY] = environment.backdrop
    return color


def _lit(stage: Stage, seen: Surface, albedo: Float32Array, reach: Reach) -> Float32Array:
    environment = stage.studio.environment
    key, sky = np.array(environment.key, np.float32), np.array(environment.ambient, np.float32)
    facing = np.maximum(seen.normals @ stage.studio.key_direction, 0.0).astype(np.float32)
    reached = (facing > 0.0).astype(np.float32)
    at = np.flatnonzero((seen.ids != SKY) & (facing > 0.0))
    samples = samples_at(seen.points[at], seen.normals[at], reach.column[at], reach.row[at])
    for shadow, hidden in reach.shadows:
        part = key_light(shadow, environment.radius, samples)
        reached[at] *= 1.0 - np.float32(hidden) * (1.0 - part)
    facing *= reached
    solid = seen.ids >= 0
    around = _surroundings(stage, seen, solid)
    # what hides the surrounding light is itself lit, the less the deeper it lies, and taken to have the same colour
    share = reach.ambient[:, None]
    lit = (np.float32(0.5) * sky + np.float32(0.28) * key) * (np.float32(0.3) + np.float32(0.7) * share)
    bounced = np.where(solid[:, None], albedo, np.float32(0.4)) * lit
    color = np.asarray(albedo * (around * share + bounced * (1.0 - share) + key * facing[:, None]), np.float32)
    _add_gloss(stage, seen, color, albedo, reached, reach.ambient)
    return color


def _surroundings(stage: Stage, seen: Surface, solid: npt.NDArray[np.bool_]) -> Float32Array:
    """The light (N, 3) that surrounds each sample: from below comes the ground's, but near it lies the solid's own
    shadow."""
    environment = stage.studio.environment
    sky = np.array(environment.ambient, np.float32)
    if stage.ground is None:
        return np.broadcast_to(sky, (len(seen.ids), 3))
    height = np.clip(seen.points[:, 1] - stage.ground, 0.0, 10.0).astype(np.float32)
    below = np.where(solid, 0.5 - 0.5 * seen.normals[:, 1], 0.0).astype(np.float32)
    turned_away = (0.5 - 0.5 * seen.normals @ stage.studio.key_direction).astype(np.float32)
    shaded = np.float32(0.7) * turned_away * np.exp(-height / np.float32(0.35))
    ground = ground_radiance(stage).astype(np.float32)
    return np.asarray(sky + below[:, None] * (ground * (1.0 - shaded)[:, None] - sky), np.float32)


def ground_depths(height: float, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """How far along rays (N, 3) the ground at ``height`` lies (N,); infinity for those that do not meet it."""
    drop = direction[:, 1]
    falls = drop < -1e-9
    fall = np.where(falls, (height - origin[:, 1]) / np.where(falls, drop, -1.0), 1e30)
    across = np.hypot(origin[:, 0] + direction[:, 0] * fall, origin[:, 2] + direction[:, 2] * fall)
    return np.where((fall > 0.0) & (across < GROUND_EDGE), fall, np.inf)


def ground_radiance(stage: Stage) -> FloatArray:
    """The radiance (3,) of the ground where nothing shades it, the mean of its squares; black without a ground."""
    if stage.studio.ground is None:
        return np.zeros(3)
    environment = stage.studio.environment
    light = np.array(environment.ambient) + np.array(environment.key) * stage.studio.key_direction[1]
    return np.asarray(stage.studio.ground.mean(axis=0) * light, np.float64)


# --- gloss -----------------------------------------------------------------------------------------------------


def _add_gloss(
    stage: Stage, seen: Surface, color: Float32Array, albedo: Float32Array, reached: Float32Array, ambient: Float32Array
) -> None:
    """Replace, in ``color``, a part of the even scattering of surfaces that are not matte by what they reflect.

    A microfacet model (GGX, Schlick's Fresnel term) of the key light, and of a room that is the surrounding light above
    the horizon and the ground below, both blurred by the roughness.
    """
    looks = stage.solids.looks
    if bool(looks.matte.all()):
        return
    solid = np.flatnonzero(seen.ids >= 0)
    rows = solid[~looks.matte[stage.solids.look[seen.ids[solid]]]]
    if not len(rows):
        return
    part = seen.take(rows)
    look = stage.solids.look[part.ids]
    tint, metallic = albedo[rows].astype(np.float64), looks.metallic[look][:, None]
    base = ((looks.ior[look] - 1.0) / (looks.ior[look] + 1.0)) ** 2
    normal_reflectance = base[:, None] * (1.0 - metallic) + tint * metallic
    rough = np.maximum(looks.gloss[look], _LEAST_ROUGHNESS)
    toward = np.clip(-np.einsum("ni,ni->n", part.normals, part.view), 1e-3, 1.0)
    fresnel = _schlick(normal_reflectance, toward, rough)
    room = _room(stage, part, toward, rough) * ambient[rows][:, None]
    highlight = _highlight(stage, part, normal_reflectance, toward, rough) * reached[rows][:, None]
    scattered = color[rows] * (1.0 - metallic) * (1.0 - base[:, None])
    color[rows] = scattered + fresnel * room + highlight


def _schlick(reflectance: FloatArray, cosine: FloatArray, rough: FloatArray) -> FloatArray:
    """The share (N, 3) that is reflected; rough surfaces reflect less at grazing angles."""
    limit = np.maximum((1.0 - rough)[:, None], reflectance)
    return np.asarray(reflectance + (limit - reflectance) * ((1.0 - cosine) ** 5)[:, None], np.float64)


def _room(stage: Stage, part: Surface, toward: FloatArray, rough: FloatArray) -> FloatArray:
    """The radiance (N, 3) of the room in the direction of reflection."""
    environment = stage.studio.environment
    sky = np.array(environment.ambient)
    if stage.ground is None:
        return np.broadcast_to(sky, (len(rough), 3))
    up = part.view[:, 1] + 2.0 * toward * part.normals[:, 1]
    share = np.clip(0.5 + 0.5 * up / np.maximum(rough, 0.02), 0.0, 1.0)[:, None]
    return np.asarray(sky * share + ground_radiance(stage) * (1.0 - share), np.float64)


def _highlight(
    stage: Stage, part: Surface, reflectance: FloatArray, toward: FloatArray, rough: FloatArray
) -> FloatArray:
    """The radiance (N, 3) of the key light's highlight."""
    light = stage.studio.key_direction
    half = light - part.view
    half /= np.maximum(np.linalg.norm(half, axis=1), 1e-9)[:, None]
    alpha2 = rough**4
    facing = np.clip(part.normals @ light, 0.0, 1.0)
    straight = np.clip(np.einsum("ni,ni->n", part.normals, half), 0.0, 1.0)
    spread = alpha2 / (np.pi * (straight**2 * (alpha2 - 1.0) + 1.0) ** 2)
    masked = 0.5 / np.maximum(
        facing * np.sqrt(toward**2 * (1.0 - alpha2) + alpha2) + toward * np.sqrt(facing**2 * (1.0 - alpha2) + alpha2),
        1e-4,
    )
    fresnel = _schlick(reflectance, np.clip(half @ light, 0.0, 1.0), rough)
    # a white matte surface has the radiance `key`, so the irradiance is pi times that
    strength = np.pi * np.array(stage.studio.environment.key)
    return np.asarray(fresnel * (spread * masked * facing)[:, None] * strength, np.float64)
