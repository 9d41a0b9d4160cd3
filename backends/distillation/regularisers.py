"""What keeps Gaussians well shaped and in place: L_reg and L_layout (the paper, appendix; after GALA3D).

GALA3D's code is not public. L_layout is the Manhattan distance of the centres to their box; L_reg is of our own form:
how far the longest axis of an ellipsoid exceeds ``LONGEST`` times the shortest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.distillation.theta import Theta

LONGEST = 8.0


def too_long(axes: Tensor, matrices: Tensor) -> Tensor:
    """L_reg of Gaussians with the axes (K, 3, 3) under each of the poses (N, 3, 3), through which no gradient goes:
    the mean excess of the ratio of the longest axis to the shortest over LONGEST."""
    import torch

    spread = matrices.detach()[:, None] @ axes
    with torch.no_grad():
        _, turns = torch.linalg.eigh((spread @ spread.mT).double())
        longest, shortest = (turns[..., i].to(axes) for i in (2, 0))
    # the axes of an ellipsoid change to first order as its covariance does along them
    long, short = ((spread.mT @ each[..., None]).square().sum((-2, -1)) for each in (longest, shortest))
    ratio = (long / short.clamp_min(1e-12)).clamp_min(1.0).sqrt()
    return torch.relu(ratio - LONGEST).mean()


def outside(theta: Theta, box: Tensor) -> Tensor:
    """L_layout: the mean Manhattan distance of the centres from the box with half sizes ``box`` (3,) that the program
    gave, in the figure's frame; 0 for those within."""
    return (theta.means.abs() - box).clamp_min(0.0).sum(1).mean()
