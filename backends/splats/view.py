"""From the project's one camera to what the rasteriser takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenelang.backends.camera import Camera

if TYPE_CHECKING:
    from torch import Tensor


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A camera as tensors: ``world_to_camera`` (4, 4) and ``intrinsics`` (3, 3), as ``camera.Camera`` defines them,
    which is also gsplat's convention (x right, y down, z forward, pixel centres at halves)."""

    world_to_camera: Tensor
    intrinsics: Tensor
    width: int
    height: int
    is_parallel: bool = False


def view_of(camera: Camera, like: Tensor) -> View:
    """``camera`` as a view, its tensors of the type and on the device of ``like``. Its lens is taken for a pinhole."""
    import torch

    pose, intrinsics = (torch.as_tensor(m).to(like) for m in (camera.world_to_camera, camera.intrinsics))
    return View(pose, intrinsics, camera.width, camera.height, camera.is_parallel)
