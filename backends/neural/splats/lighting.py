"""Light on the Gaussians of a scene, as draft pictures have it, and what lies behind them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.draft_light import (
    GROUND,
    SKY,
    Reach,
    Shadow,
    Surface,
    albedo_of,
    ground_depths,
    radiance_of,
    shadow_map,
)
from scenelang.backends.pictures.rays import camera_rays
from scenelang.backends.pictures.stage import Stage
from scenelang.backends.pictures.studio import BRIGHTEST

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Float32Array = npt.NDArray[np.float32]

_SHADOW_PIXELS = 1024
_AROUND = 0.9  # the share of the surrounding light that reaches the Gaussians; all of it reaches the ground
_ROW = 1 << 12  # Gaussians in a row of the pattern by which shadows are sampled


def shadow_of(stage: Stage) -> list[Shadow]:
    """The shadow of the solids of ``stage``; none where there is no light."""
    if stage.studio.environment.unlit:
        return []
    return [(shadow_map(stage.solids, stage.studio.key_direction, _SHADOW_PIXELS), 1.0)]


def lit(
    stage: Stage, shadow: list[Shadow], points: FloatArray, normals: FloatArray, colors: FloatArray, ids: IntArray
) -> Float32Array:
    """The radiance (N, 3) towards the eye of ``points`` with ``normals`` and reflectances ``colors`` (N, 3), which
    belong to the solids ``ids`` (N,) of the stage."""
    camera = stage.camera
    view = np.broadcast_to(camera.forward, points.shape) if camera.is_parallel else points - camera.eye
    view = view / np.maximum(np.linalg.norm(view, axis=1, keepdims=True), 1e-300)
    away = np.einsum("ni,ni->n", normals, view) > 0.0
    seen = Surface(ids, np.zeros(len(ids)), points, np.where(away[:, None], -normals, normals), view)
    brightest = 1.0 if stage.studio.environment.unlit else BRIGHTEST
    return radiance_of(stage, seen, (colors * brightest).astype(np.float32), _reach(shadow, len(ids), _ROW, _AROUND))


def backdrop(stage: Stage, shadow: list[Shadow]) -> Float32Array:
    """The radiance (H, W, 3) of ground and sky without the solids, but with their shadow."""
    rays = camera_rays(stage.camera)
    count = stage.width * stage.height
    rows, columns = np.divmod(np.arange(count), stage.width)
    origin, direction = rays.at(columns + 0.5, rows + 0.5)
    depth = np.full(count, np.inf) if stage.ground is None else ground_depths(stage.ground, origin, direction)
    ids = np.where(np.isfinite(depth), GROUND, SKY)
    points = origin + direction * np.where(np.isfinite(depth), depth, 0.0)[:, None]
    view = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    seen = Surface(ids, depth, points, np.tile([0.0, 1.0, 0.0], (count, 1)), view)
    reach = _reach(shadow, count, stage.width, 1.0)
    return radiance_of(stage, seen, albedo_of(stage, seen), reach).reshape(stage.height, stage.width, 3)


def _reach(shadow: list[Shadow], count: int, width: int, around: float) -> Reach:
    row, column = np.divmod(np.arange(count), width)
    return Reach(shadow, np.full(count, around, np.float32), row, column)
