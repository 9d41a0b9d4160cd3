"""Drawing splats with gsplat's CUDA kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenelang.backends.base import need
from scenelang.backends.neural.splats.gaussians import EPS2D, FAR, NEAR
from scenelang.backends.neural.weights import INSTALL

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.neural.splats.gaussians import Splats, View


def composite(splats: Splats, features: Tensor, view: View, antialiased: bool) -> tuple[Tensor, Tensor, Tensor]:
    """The ``features`` (N, C) of ``splats`` as a picture (H, W, C), the sum of their depths (H, W) and the share that
    is hidden (H, W), in 32 bits. Raises SceneError("backend") without gsplat."""
    gsplat = need("gsplat", INSTALL)
    image, hidden, _ = gsplat.rasterization(
        means=splats.means.float(),
        quats=None,
        scales=None,
        covars=splats.covariances.float(),
        opacities=splats.opacities.float(),
        colors=features.float(),
        viewmats=view.world_to_camera.float()[None],
        Ks=view.intrinsics.float()[None],
        width=view.width,
        height=view.height,
        near_plane=NEAR,
        far_plane=FAR,
        eps2d=EPS2D,
        render_mode="RGB+D",
        rasterize_mode="antialiased" if antialiased else "classic",
        camera_model="ortho" if view.is_parallel else "pinhole",
        packed=False,
    )
    return image[0, :, :, :-1], image[0, :, :, -1], hidden[0, :, :, 0]
