"""Gaussians to draw, cameras to draw them with, and a picture worked out directly: pixel by pixel, in numpy."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.neural.splats.gaussians import Gaussians, Splats
from scenelang.backends.pictures.camera import Camera, Viewpoint, place

FloatArray = npt.NDArray[np.float64]


def random_gaussians(count: int, seed: int = 0, dtype: Any = None, size: float = 0.15) -> Gaussians:
    """Gaussians in the cube [-1, 1]^3, of all shapes, some nearly opaque, some faint; float64 for None."""
    import torch

    chance = torch.Generator().manual_seed(seed)
    kind = {"generator": chance, "dtype": dtype or torch.float64}
    return Gaussians(
        torch.rand(count, 3, **kind) * 2.0 - 1.0,
        torch.randn(count, 3, **kind) * 0.5 + float(np.log(size)),
        torch.randn(count, 4, **kind),
        torch.randn(count, **kind) * 2.0,
        torch.rand(count, 3, **kind),
    )


def splats_of(gaussians: Gaussians) -> Splats:
    return Splats(gaussians.means, gaussians.covariances, gaussians.opacities, gaussians.colors)


def a_camera(width: int = 48, height: int = 40, **view: Any) -> Camera:
    """A camera that sees the cube [-1, 1]^3."""
    return place(Viewpoint(**view), -np.ones(3), np.ones(3), width, height)


def directly(splats: Splats, camera: Camera, antialiased: bool = False) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Color (H, W, 3), alpha and depth (H, W) by the definition."""
    ellipses = [e for i in range(len(splats)) if (e := _ellipse(splats, i, camera, antialiased)) is not None]
    ellipses.sort(key=lambda ellipse: ellipse[0])
    color = np.zeros((camera.height, camera.width, 3))
    alpha, depth = np.zeros((2, camera.height, camera.width))
    for row in range(camera.height):
        for column in range(camera.width):
            light = 1.0
            for z, center, inverse, opacity, paint in ellipses:
                d = np.array([column + 0.5, row + 0.5]) - center
                share = min(0.999, opacity * np.exp(-0.5 * d @ inverse @ d))
                if share < 1.0 / 255.0:
                    continue
                if light * (1.0 - share) <= 1e-4:
                    break
                color[row, column] += light * share * paint
                depth[row, column] += light * share * z
                light *= 1.0 - share
            alpha[row, column] = 1.0 - light
    return color, alpha, depth / np.maximum(alpha, 1e-10)


def _ellipse(splats: Splats, i: int, camera: Camera, antialiased: bool) -> Any:
    turn = camera.world_to_camera[:3, :3]
    x, y, z = local = turn @ splats.means[i].numpy() + camera.world_to_camera[:3, 3]
    if not 0.01 < z < 1e10:
        return None
    (fx, fy), (cx, cy) = camera.focal, camera.principal
    if camera.is_parallel:
        slope = np.array([[fx, 0.0, 0.0], [0.0, fy, 0.0]])
        center = np.array([fx * x + cx, fy * y + cy])
    else:
        center = np.array([fx * x / z + cx, fy * y / z + cy])
        wide, high = camera.width / fx, camera.height / fy
        u = np.clip(local[0] / z, -cx / fx - 0.15 * wide, (camera.width - cx) / fx + 0.15 * wide)
        v = np.clip(local[1] / z, -cy / fy - 0.15 * high, (camera.height - cy) / fy + 0.15 * high)
        slope = np.array([[fx / z, 0.0, -fx * u / z], [0.0, fy / z, -fy * v / z]])
    spread = slope @ turn @ splats.covariances[i].numpy() @ turn.T @ slope.T
    widened = spread + 0.3 * np.eye(2)
    opacity = float(splats.opacities[i])
    if antialiased:
        opacity *= float(np.sqrt(max(np.linalg.det(spread) / np.linalg.det(widened), 0.0)))
    return z, center, np.linalg.inv(widened), opacity, splats.colors[i].numpy()
