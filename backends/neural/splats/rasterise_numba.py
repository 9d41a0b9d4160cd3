"""Compositing on the CPU by numba's compiled kernels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.neural.splats.gaussians import Projected, View


Floats = npt.NDArray[Any]


def forward(picture: Ellipses) -> tuple[Tensor, Tensor, tuple[Tensor, ...]]:
    """The features (H, W, C), the share that is hidden (H, W), and what ``backward`` needs of it."""
    import torch

    from scenelang.backends.neural.splats import kernels

    columns = _arrays(picture)
    box = kernels.boxes(columns[0], picture.radii.numpy(), picture.width, picture.height)
    image = np.zeros((picture.height, picture.width, columns[3].shape[1]), columns[3].dtype)
    light = np.ones((picture.height, picture.width), columns[3].dtype)
    done = kernels.forward(*columns, box, image, light)
    behind = torch.from_numpy(light)
    return torch.from_numpy(image), 1.0 - behind, (behind, torch.from_numpy(done), torch.from_numpy(box))


def backward(
    picture: Ellipses, kept: tuple[Tensor, ...], by_image: Tensor, by_hidden: Tensor
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """The derivatives by centres, conics, opacities and features, from those by what ``forward`` gave."""
    import torch

    from scenelang.backends.neural.splats import kernels

    columns = _arrays(picture)
    light, done, box = (one.numpy() for one in kept)
    found = kernels.backward(*columns, box, light, done, by_image.numpy(), by_hidden.numpy())
    centers, conics, opacities, features = (torch.from_numpy(one) for one in found)
    return centers, conics, opacities, features


def _arrays(picture: Ellipses) -> tuple[Floats, Floats, Floats, Floats]:
    return picture.centers.numpy(), picture.conics.numpy(), picture.opacities.numpy(), picture.features.numpy()


# Blending projected splats over each other, with derivatives: what every way of working it out has in common.
#
# A pixel at ``d`` from the centre of a splat gets ``alpha = min(0.999, opacity exp(-d' conic d / 2))`` of it, nothing
# below 1/255. Nearest first, each adds ``alpha`` times the light that those before it let through; a pixel is done
# before the splat that would leave it less than 1e-4.


@dataclass(frozen=True, slots=True, eq=False)
class Ellipses:
    """M splats nearest first, as ``projection.Projected`` has them: ``centers`` (M, 2), ``conics`` (M, 3),
    ``opacities`` (M,), ``radii`` (M, 2); with ``features`` (M, C), to be blended into ``width`` x ``height`` pixels."""

    centers: Tensor
    conics: Tensor
    opacities: Tensor
    features: Tensor
    radii: Tensor
    width: int
    height: int


class Engine(Protocol):
    """A way of blending: a module with these functions."""

    def forward(self, picture: Ellipses) -> tuple[Tensor, Tensor, tuple[Tensor, ...]]:
        """The features (H, W, C), the share that is hidden (H, W), and what ``backward`` needs of it."""

    def backward(
        self, picture: Ellipses, kept: tuple[Tensor, ...], by_image: Tensor, by_hidden: Tensor
    ) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """The derivatives by centres, conics, opacities and features, from those by what ``forward`` gave."""


def composite(engine: Engine, seen: Projected, features: Tensor, view: View) -> tuple[Tensor, Tensor]:
    """The ``features`` (M, C) of what is ``seen`` as a picture (H, W, C), and the share that is hidden (H, W)."""
    columns = (seen.centers, seen.conics, seen.opacities, features, seen.radii)
    image, hidden = _function().apply(engine, (view.width, view.height), *columns)
    return image, hidden


def _ellipses(columns: tuple[Tensor, ...], size: tuple[int, int]) -> Ellipses:
    centers, conics, opacities, features, radii = columns
    return Ellipses(centers, conics, opacities, features, radii, *size)


@cache
def _function() -> Any:
    """The operation for torch's derivatives; made here because torch is imported late."""
    import torch

    class Composite(torch.autograd.Function):
        @staticmethod
        def forward(ctx: Any, engine: Engine, size: tuple[int, int], *columns: Tensor) -> tuple[Tensor, Tensor]:
            columns = tuple(column.detach().contiguous() for column in columns)
            image, hidden, kept = engine.forward(_ellipses(columns, size))
            ctx.engine, ctx.size = engine, size
            ctx.save_for_backward(*columns, *kept)
            return image, hidden

        @staticmethod
        @torch.autograd.function.once_differentiable
        def backward(ctx: Any, by_image: Tensor, by_hidden: Tensor) -> tuple[Tensor | None, ...]:
            columns, kept = ctx.saved_tensors[:5], ctx.saved_tensors[5:]
            picture = _ellipses(columns, ctx.size)
            found = ctx.engine.backward(picture, kept, by_image.contiguous(), by_hidden.contiguous())
            return (None, None, *found, None)

    return Composite
