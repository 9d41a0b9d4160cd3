"""Compositing on the CPU by kernels compiled with numba; the interface of all engines, and the autograd function."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.neural.splats.gaussians import ProjectedSplats, View


Floats = npt.NDArray[Any]


def forward(ellipses: Ellipses) -> tuple[Tensor, Tensor, tuple[Tensor, ...]]:
    """Return the features (H, W, C), alpha (H, W), and the tensors required by ``backward``."""
    import torch

    from scenelang.backends.neural.splats import kernels

    columns = _arrays(ellipses)
    box = kernels.boxes(columns[0], ellipses.radii.numpy(), ellipses.width, ellipses.height)
    image = np.zeros((ellipses.height, ellipses.width, columns[3].shape[1]), columns[3].dtype)
    light = np.ones((ellipses.height, ellipses.width), columns[3].dtype)
    finished_at = kernels.forward(*columns, box, image, light)
    transmittance = torch.from_numpy(light)
    saved = transmittance, torch.from_numpy(finished_at), torch.from_numpy(box)
    return torch.from_numpy(image), 1.0 - transmittance, saved


def backward(
    ellipses: Ellipses, saved: tuple[Tensor, ...], grad_image: Tensor, grad_alpha: Tensor
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Return the gradients by centers, conics, opacities and features."""
    import torch

    from scenelang.backends.neural.splats import kernels

    columns = _arrays(ellipses)
    transmittance, finished_at, box = (each.numpy() for each in saved)
    gradients = kernels.backward(*columns, box, transmittance, finished_at, grad_image.numpy(), grad_alpha.numpy())
    centers, conics, opacities, features = (torch.from_numpy(each) for each in gradients)
    return centers, conics, opacities, features


def _arrays(ellipses: Ellipses) -> tuple[Floats, Floats, Floats, Floats]:
    return ellipses.centers.numpy(), ellipses.conics.numpy(), ellipses.opacities.numpy(), ellipses.features.numpy()


# Alpha compositing of projected splats, common to all engines (3D Gaussian Splatting, section 4, as in gsplat).
#
# The alpha of a splat at offset ``d`` from its center is ``min(0.999, opacity exp(-d' conic d / 2))``, or 0 below
# 1/255. From near to far, each splat adds its features times alpha times the transmittance of those before it; a pixel
# is finished before a splat that would reduce the transmittance below 1e-4.


@dataclass(frozen=True, slots=True, eq=False)
class Ellipses:
    """M projected splats, sorted from near to far, with the features to composite.

    Attributes
    ----------
    centers, radii
        (M, 2), as in ``ProjectedSplats``.
    conics
        (M, 3), as in ``ProjectedSplats``.
    opacities
        (M,).
    features
        (M, C).
    width, height
        Size of the image in pixels.
    """

    centers: Tensor
    conics: Tensor
    opacities: Tensor
    features: Tensor
    radii: Tensor
    width: int
    height: int


class Engine(Protocol):
    """Implementation of compositing: a module with these functions."""

    def forward(self, ellipses: Ellipses) -> tuple[Tensor, Tensor, tuple[Tensor, ...]]:
        """Return the features (H, W, C), alpha (H, W), and the tensors required by ``backward``."""

    def backward(
        self, ellipses: Ellipses, saved: tuple[Tensor, ...], grad_image: Tensor, grad_alpha: Tensor
    ) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return the gradients by centers, conics, opacities and features."""


def composite(engine: Engine, projected: ProjectedSplats, features: Tensor, view: View) -> tuple[Tensor, Tensor]:
    """Composite the ``features`` (M, C) of projected splats: returns an image (H, W, C) and alpha (H, W)."""
    columns = (projected.centers, projected.conics, projected.opacities, features, projected.radii)
    image, alpha = _autograd_function().apply(engine, (view.width, view.height), *columns)
    return image, alpha


def _ellipses(columns: tuple[Tensor, ...], size: tuple[int, int]) -> Ellipses:
    centers, conics, opacities, features, radii = columns
    return Ellipses(centers, conics, opacities, features, radii, *size)


@cache
def _autograd_function() -> Any:
    """Define the autograd function; in a function, since torch is imported lazily."""
    import torch

    class Composite(torch.autograd.Function):
        @staticmethod
        def forward(ctx: Any, engine: Engine, size: tuple[int, int], *columns: Tensor) -> tuple[Tensor, Tensor]:
            columns = tuple(column.detach().contiguous() for column in columns)
            image, alpha, saved = engine.forward(_ellipses(columns, size))
            ctx.engine, ctx.size = engine, size
            ctx.save_for_backward(*columns, *saved)
            return image, alpha

        @staticmethod
        @torch.autograd.function.once_differentiable
        def backward(ctx: Any, grad_image: Tensor, grad_alpha: Tensor) -> tuple[Tensor | None, ...]:
            columns, saved = ctx.saved_tensors[:5], ctx.saved_tensors[5:]
            ellipses = _ellipses(columns, ctx.size)
            gradients = ctx.engine.backward(ellipses, saved, grad_image.contiguous(), grad_alpha.contiguous())
            return (None, None, *gradients, None)

    return Composite
