"""Cameras of the two terms, and what they see: four at equal steps around a figure, as MVDream was trained; one before
the scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from scenelang.backends.camera import Camera, camera_at
from scenelang.backends.distillation.settings import BACKGROUND
from scenelang.backends.splats.gaussians import posed
from scenelang.backends.splats.rasterise import rasterise
from scenelang.backends.splats.view import view_of
from scenelang.backends.viewpoint import Viewpoint, axes_of, place

if TYPE_CHECKING:
    from torch import Generator, Tensor

    from scenelang.backends.splats.gaussians import Gaussians, Splats

FIELDS = (30.0, 50.0)  # degrees
ELEVATIONS = (0.0, 30.0)
_NEAR, _FAR = 1.0, 1.2  # distances at which a ball of radius 1 nearly fills the picture
_SCENE_FIELD = 40.0


def around(count: int, size: int, generator: Generator) -> list[Camera]:
    """``count`` cameras at equal steps around the middle of a figure, for pictures of ``size`` pixels square."""
    import torch

    start, up, far, wide = torch.rand(4, generator=generator).tolist()
    elevation = ELEVATIONS[0] + up * (ELEVATIONS[1] - ELEVATIONS[0])
    field = FIELDS[0] + wide * (FIELDS[1] - FIELDS[0])
    return ring(count, size, 360.0 * start, elevation, field, _NEAR + far * (_FAR - _NEAR))


def ring(
    count: int, size: int, azimuth: float = 30.0, elevation: float = 15.0, field: float = 40.0, far: float = 1.1
) -> list[Camera]:
    """Cameras from ``azimuth`` on, angles in degrees; at the distance ``far`` / tan(field / 2)."""
    tangent = math.tan(math.radians(field) / 2.0)
    cameras = []
    for number in range(count):
        axes = axes_of(azimuth + 360.0 * number / count, elevation)
        cameras.append(camera_at(-far / tangent * axes[2], axes, size / (2.0 * tangent), size, size))
    return cameras


def before(low: npt.NDArray[np.float64], high: npt.NDArray[np.float64], size: int, generator: Generator) -> Camera:
    """A camera that sees the whole box from ``low`` to ``high`` (3,) from anywhere around."""
    import torch

    turn, up = torch.rand(2, generator=generator).tolist()
    elevation = ELEVATIONS[0] + up * (ELEVATIONS[1] - ELEVATIONS[0])
    return place(Viewpoint(360.0 * turn, elevation, fov=_SCENE_FIELD), low, high, size, size)


def depth_pictures(depth: Tensor, alpha: Tensor) -> Tensor:
    """A depth picture (1, 3, H, W) as ControlNet reads it: the nearest is white, nothing is black; from ``depth`` and
    ``alpha`` (H, W)."""
    import torch

    seen = alpha > 0.5
    inverse = torch.where(seen, 1.0 / depth.clamp_min(1e-6), 0.0)
    if bool(seen.any()):
        low, high = inverse[seen].min(), inverse[seen].max()
        inverse = torch.where(seen, 0.1 + 0.9 * (inverse - low) / (high - low).clamp_min(1e-9), 0.0)
    return inverse[None, None].expand(1, 3, -1, -1)


def alone(gaussians: Gaussians) -> Splats:
    """A figure's Gaussians where they are in its own frame."""
    import torch

    like = gaussians.means
    return posed(gaussians, torch.eye(3).to(like), torch.zeros(3).to(like))


def background(generator: Generator) -> float:
    """The grey, sRGB, behind the pictures of one step: over a fixed one, a thing of just that grey would have no
    gradient by its opacities."""
    import torch

    return float(torch.rand((), generator=generator))


def pictured(splats: Splats, camera: Camera, behind: float = BACKGROUND) -> Tensor:
    """Splats as the models see them, (H, W, 3) sRGB over the grey ``behind``; differentiable."""
    drawn = rasterise(splats, view_of(camera, splats.means))
    return drawn.color + (1.0 - drawn.alpha[..., None]) * behind


def stacked(pictures: Sequence[Tensor]) -> Tensor:
    """Pictures (H, W, 3) as (B, 3, H, W)."""
    import torch

    return torch.stack([picture.permute(2, 0, 1) for picture in pictures])
