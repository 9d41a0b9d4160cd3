"""Rasterisation of splats, differentiable in means, covariances, opacities and colors.

Uses gsplat on CUDA and numba on the CPU if installed, and plain torch otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

from scenelang.backends.base import require
from scenelang.backends.neural.splats import rasterise_numba, rasterise_torch
from scenelang.backends.neural.splats.gaussians import EPS2D, FAR, NEAR, project
from scenelang.backends.neural.splats.rasterise_numba import Engine, composite
from scenelang.backends.neural.weights import INSTALL
from scenelang.grammar.diagnostics import LimitError

if TYPE_CHECKING:
    import torch
    from torch import Tensor

    from scenelang.backends.neural.splats.gaussians import Splats, View


_MAX_WEIGHTS = 1 << 28
_MIN_ALPHA = 1e-10  # of pixels with a depth


@dataclass(frozen=True, slots=True, eq=False)
class EntityLabels:
    """Entity of each of N Gaussians: ``index`` (N,), an integer from 0 to ``count`` - 1."""

    index: Tensor
    count: int


@dataclass(frozen=True, slots=True, eq=False)
class RasterisedImage:
    """Image of splats on a transparent background.

    Attributes
    ----------
    color
        (H, W, 3), linear, premultiplied by alpha.
    alpha
        (H, W).
    depth
        (H, W), mean depth of the visible splats, 0 where there are none.
    weights
        (H, W, E), contribution of each entity, or None without labels.
    """

    color: Tensor
    alpha: Tensor
    depth: Tensor
    weights: Tensor | None = None


def rasterise(
    splats: Splats, view: View, antialiased: bool = False, labels: EntityLabels | None = None
) -> RasterisedImage:
    """Render splats, and with ``labels`` the contribution of each entity.

    ``antialiased`` reduces the opacity of splats that are thinner than a pixel. Raises LimitError if there are too many
    pixels and entities.
    """
    features = _features(splats, view, labels)
    device = splats.means.device
    if device.type == "cuda" and find_spec("gsplat") is not None:
        image, depth, alpha = composite_on_cuda(splats, features, view, antialiased)
        return _rasterised_image(image, depth, alpha)
    return rasterise_by(engine_for(device), splats, view, antialiased, labels)


def rasterise_by(
    engine: Engine, splats: Splats, view: View, antialiased: bool = False, labels: EntityLabels | None = None
) -> RasterisedImage:
    """Render splats as ``rasterise`` does, with the given engine."""
    import torch

    features = _features(splats, view, labels)
    projected = project(splats, view, antialiased)
    with_depth = torch.cat([features[projected.index], projected.depths[:, None]], 1)
    image, alpha = composite(engine, projected, with_depth, view)
    return _rasterised_image(image[:, :, :-1], image[:, :, -1], alpha)


def engine_for(device: torch.device) -> Engine:
    """Return the numba engine on the CPU if numba is installed, else the torch engine."""
    return rasterise_numba if device.type == "cpu" and find_spec("numba") is not None else rasterise_torch


def _features(splats: Splats, view: View, labels: EntityLabels | None) -> Tensor:
    """Return the features to composite: colors (N, 3), and one-hot labels (N, E)."""
    import torch

    if labels is None:
        return splats.colors
    total = labels.count * max(view.width * view.height, len(splats))
    if total > _MAX_WEIGHTS:
        message = f"the weights of {labels.count:,} entities would be {total:,} numbers, more than {_MAX_WEIGHTS:,}"
        raise LimitError("size", message, hint="use a smaller image or fewer entities")
    one_hot = torch.nn.functional.one_hot(labels.index, labels.count).to(splats.colors)
    return torch.cat([splats.colors, one_hot], 1)


def _rasterised_image(image: Tensor, depth: Tensor, alpha: Tensor) -> RasterisedImage:
    weights = image[:, :, 3:] if image.shape[2] > 3 else None
    return RasterisedImage(image[:, :, :3], alpha, depth / alpha.clamp_min(_MIN_ALPHA), weights)


def composite_on_cuda(splats: Splats, features: Tensor, view: View, antialiased: bool) -> tuple[Tensor, Tensor, Tensor]:
    """Composite the ``features`` (N, C) of splats with gsplat, in float32.

    Returns an image (H, W, C), accumulated depth (H, W) and alpha (H, W). Raises SceneError("backend") without gsplat.
    """
    gsplat = require("gsplat", INSTALL)
    image, alpha, _ = gsplat.rasterization(
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
    return image[0, :, :, :-1], image[0, :, :, -1], alpha[0, :, :, 0]
