"""Pictures of splats, differentiable in their means, covariances, opacities and colours.

gsplat draws on CUDA where it is installed, numba on the CPU where that is; plain torch draws everywhere.
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


_MOST_WEIGHTS = 1 << 28
_LEAST_HIDDEN = 1e-10  # below it a pixel has no depth


@dataclass(frozen=True, slots=True, eq=False)
class Members:
    """Which of ``count`` entities each of N Gaussians belongs to: ``number`` (N,) from 0, whole."""

    number: Tensor
    count: int


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A picture of splats over nothing: ``color`` (H, W, 3), linear and multiplied with ``alpha`` (H, W), the share of
    each pixel that is hidden; ``depth`` (H, W) along the view, the mean of what is seen, 0 where that is nothing;
    ``weights`` (H, W, E), how much of each pixel shows each entity, where these were given."""

    color: Tensor
    alpha: Tensor
    depth: Tensor
    weights: Tensor | None = None


def rasterise(splats: Splats, view: View, antialiased: bool = False, members: Members | None = None) -> Drawn:
    """Draw ``splats`` as ``view`` sees them; with ``members`` also who is seen where.

    ``antialiased`` thins out what is narrower than a pixel instead of widening it. Raises LimitError for more pixels
    times entities than fit.
    """
    features = _features(splats, view, members)
    device = splats.means.device
    if device.type == "cuda" and find_spec("gsplat") is not None:
        image, depth, alpha = composite_on_cuda(splats, features, view, antialiased)
        return _drawn(image, depth, alpha)
    return rasterise_by(engine_for(device), splats, view, antialiased, members)


def rasterise_by(
    engine: Engine, splats: Splats, view: View, antialiased: bool = False, members: Members | None = None
) -> Drawn:
    """As ``rasterise``, worked out by ``engine``."""
    import torch

    features = _features(splats, view, members)
    seen = project(splats, view, antialiased)
    deep = torch.cat([features[seen.index], seen.depths[:, None]], 1)
    image, alpha = composite(engine, seen, deep, view)
    return _drawn(image[:, :, :-1], image[:, :, -1], alpha)


def engine_for(device: torch.device) -> Engine:
    """numba on the CPU where it is installed, else plain torch."""
    return rasterise_numba if device.type == "cpu" and find_spec("numba") is not None else rasterise_torch


def _features(splats: Splats, view: View, members: Members | None) -> Tensor:
    """What is blended: the colours (N, 3), and after them who each is (N, E)."""
    import torch

    if members is None:
        return splats.colors
    total = members.count * max(view.width * view.height, len(splats))
    if total > _MOST_WEIGHTS:
        message = f"the weights of {members.count:,} entities would be {total:,} numbers, over {_MOST_WEIGHTS:,}"
        raise LimitError("size", message, hint="draw a smaller picture, or fewer entities at once")
    whose = torch.nn.functional.one_hot(members.number, members.count).to(splats.colors)
    return torch.cat([splats.colors, whose], 1)


def _drawn(image: Tensor, depth: Tensor, alpha: Tensor) -> Drawn:
    weights = image[:, :, 3:] if image.shape[2] > 3 else None
    return Drawn(image[:, :, :3], alpha, depth / alpha.clamp_min(_LEAST_HIDDEN), weights)


def composite_on_cuda(splats: Splats, features: Tensor, view: View, antialiased: bool) -> tuple[Tensor, Tensor, Tensor]:
    """With gsplat: the ``features`` (N, C) of ``splats`` as a picture (H, W, C), the sum of their depths (H, W) and the
    share that is hidden (H, W), in 32 bits. Raises SceneError("backend") without gsplat."""
    gsplat = require("gsplat", INSTALL)
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
