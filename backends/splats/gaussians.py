"""3D Gaussians as tensors, and the law by which a pose moves them.

A Gaussian is ``exp(-(x - mu)' Sigma^-1 (x - mu) / 2)`` times its opacity. Under ``x -> A x + p`` its centre becomes
``A mu + p`` and its covariance ``A Sigma A'``, for any invertible A: turns, unequal scales, mirrors and shear. Where A
is a turn times one scale, this is the paper's ``((R_t R)(S_t S))((R_t R)(S_t S))'``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from torch import Tensor


@dataclass(frozen=True, slots=True, eq=False)
class Gaussians:
    """N Gaussians by what an optimiser changes; no value needs to be kept in bounds but ``colors``.

    ``means`` (N, 3); ``log_scales`` (N, 3), the logarithms of the standard deviations along the own axes;
    ``quaternions`` (N, 4), w first, of any length but 0; ``opacity_logits`` (N,); ``colors`` (N, 3), linear sRGB in
    [0, 1], or more where something glows.
    """

    means: Tensor
    log_scales: Tensor
    quaternions: Tensor
    opacity_logits: Tensor
    colors: Tensor

    def __len__(self) -> int:
        return len(self.means)

    @property
    def axes(self) -> Tensor:
        """(N, 3, 3): the columns are the own axes, as long as the standard deviations."""
        return rotations(self.quaternions) * self.log_scales.exp()[:, None, :]

    @property
    def covariances(self) -> Tensor:
        """(N, 3, 3)"""
        axes = self.axes
        return axes @ axes.mT

    @property
    def opacities(self) -> Tensor:
        """(N,) in (0, 1)"""
        return self.opacity_logits.sigmoid()

    def take(self, which: Any) -> Gaussians:
        """The Gaussians that a mask or indices select."""
        return Gaussians(*(column[which] for column in _columns(self)))


@dataclass(frozen=True, slots=True, eq=False)
class Splats:
    """N Gaussians where they stand in the world, ready to be drawn: ``means`` (N, 3), ``covariances`` (N, 3, 3),
    ``opacities`` (N,) in [0, 1], ``colors`` (N, 3) in linear sRGB."""

    means: Tensor
    covariances: Tensor
    opacities: Tensor
    colors: Tensor

    def __len__(self) -> int:
        return len(self.means)

    def take(self, which: Any) -> Splats:
        """The splats that a mask or indices select."""
        return Splats(self.means[which], self.covariances[which], self.opacities[which], self.colors[which])

    def moved(self, matrix: Tensor, place: Tensor) -> Splats:
        """The splats after ``x -> matrix x + place``, (3, 3) and (3,), or (N, 3, 3) and (N, 3) of each its own."""
        means = (matrix @ self.means[:, :, None])[:, :, 0] + place
        return Splats(means, matrix @ self.covariances @ matrix.mT, self.opacities, self.colors)


def posed(gaussians: Gaussians, matrix: Tensor, place: Tensor) -> Splats:
    """The Gaussians under the pose ``x -> matrix x + place``, (3, 3) and (3,), or one for each, (N, 3, 3) and (N, 3).

    Differentiable in the Gaussians and in the pose; ``matrix`` may be any invertible one.
    """
    spread = matrix @ gaussians.axes  # keeps the covariance symmetric and positive, however the pose is rounded
    means = (matrix @ gaussians.means[:, :, None])[:, :, 0] + place
    return Splats(means, spread @ spread.mT, gaussians.opacities, gaussians.colors)


def joined(parts: Sequence[Splats]) -> Splats:
    """All splats of at least one part, one after the other."""
    import torch

    columns = zip(*((s.means, s.covariances, s.opacities, s.colors) for s in parts), strict=True)
    return Splats(*(torch.cat(column) for column in columns))


def joined_gaussians(parts: Sequence[Gaussians]) -> Gaussians:
    """All Gaussians of at least one part, one after the other."""
    import torch

    return Gaussians(*(torch.cat(column) for column in zip(*map(_columns, parts), strict=True)))


def _columns(gaussians: Gaussians) -> tuple[Tensor, ...]:
    one = gaussians
    return one.means, one.log_scales, one.quaternions, one.opacity_logits, one.colors


def gaussians_from(splats: Splats) -> Gaussians:
    """The Gaussians that, unposed, are ``splats``: a turn and three scales for each covariance, which a posed Gaussian
    always has. Not differentiable."""
    import torch

    with torch.no_grad():
        squares, axes = torch.linalg.eigh(splats.covariances.double())
        axes = axes * torch.where(torch.linalg.det(axes) < 0.0, -1.0, 1.0)[:, None, None]
        dtype = splats.means.dtype
        floor = torch.finfo(torch.float32).tiny
        scales = squares.clamp_min(floor).log() / 2.0
        return Gaussians(
            splats.means,
            scales.to(dtype),
            quaternions_from(axes).to(dtype),
            torch.logit(splats.opacities, 1e-6),
            splats.colors,
        )


def rotations(quaternions: Tensor) -> Tensor:
    """Rotation matrices (N, 3, 3) of quaternions (N, 4), w first, of any length but 0."""
    import torch

    w, x, y, z = torch.nn.functional.normalize(quaternions, dim=-1).unbind(-1)
    rows = (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip
    return torch.stack(rows, dim=-1).reshape(*quaternions.shape[:-1], 3, 3)


def quaternions_from(turns: Tensor) -> Tensor:
    """Unit quaternions (N, 4), w first, of rotation matrices (N, 3, 3)."""
    import torch

    (a, b, c), (d, e, f), (g, h, i) = (row.unbind(-1) for row in turns.unbind(-2))
    # four forms of each quaternion, times 4 w, 4 x, 4 y and 4 z: the one with the largest factor is exact
    forms = torch.stack(
        [
            torch.stack([1.0 + a + e + i, h - f, c - g, d - b], -1),
            torch.stack([h - f, 1.0 + a - e - i, b + d, c + g], -1),
            torch.stack([c - g, b + d, 1.0 - a + e - i, f + h], -1),
            torch.stack([d - b, c + g, f + h, 1.0 - a - e + i], -1),
        ],
        dim=-2,
    )
    best = forms.diagonal(dim1=-2, dim2=-1).argmax(-1)
    return torch.nn.functional.normalize(forms[torch.arange(len(forms), device=forms.device), best], dim=-1)
