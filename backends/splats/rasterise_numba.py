"""Compositing on the CPU by numba's compiled kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.splats.compositing import Ellipses


Floats = npt.NDArray[Any]


def forward(picture: Ellipses) -> tuple[Tensor, Tensor, tuple[Tensor, ...]]:
    """The features (H, W, C), the share that is hidden (H, W), and what ``backward`` needs of it."""
    import torch

    from scenelang.backends.splats import kernels

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

    from scenelang.backends.splats import kernels

    columns = _arrays(picture)
    light, done, box = (one.numpy() for one in kept)
    found = kernels.backward(*columns, box, light, done, by_image.numpy(), by_hidden.numpy())
    centers, conics, opacities, features = (torch.from_numpy(one) for one in found)
    return centers, conics, opacities, features


def _arrays(picture: Ellipses) -> tuple[Floats, Floats, Floats, Floats]:
    return picture.centers.numpy(), picture.conics.numpy(), picture.opacities.numpy(), picture.features.numpy()
