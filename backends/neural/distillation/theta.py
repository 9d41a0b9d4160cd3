"""What an optimiser changes: the Gaussians of a figure, and the poses of the actors about those they began with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from scenelang.backends.neural.splats.gaussians import Gaussians, Splats, joined, posed, rotations

if TYPE_CHECKING:
    from torch import Generator, Tensor


_BEGIN = 0.8  # of the box: the ellipsoid that the first Gaussians fill
_OPACITY = -2.2  # logit of 0.1
_SPACING = 0.6  # the first standard deviations, in mean distances between neighbours


@dataclass(frozen=True, slots=True, eq=False)
class Theta:
    """The paper's phi = (mu, alpha, s, q, c) for K Gaussians in the figure's frame: ``means`` (K, 3), ``opacities``
    (K,) and ``colors`` (K, 3) as logits, ``log_scales`` (K, 3), ``quaternions`` (K, 4) w first. Colours are sRGB, as
    diffusion models see them."""

    means: Tensor
    opacities: Tensor
    log_scales: Tensor
    quaternions: Tensor
    colors: Tensor

    def __len__(self) -> int:
        return len(self.means)

    def columns(self) -> dict[str, Tensor]:
        """The tensors by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def gaussians(self) -> Gaussians:
        """As the renderer takes them, colours in [0, 1], sRGB."""
        return Gaussians(self.means, self.log_scales, self.quaternions, self.opacities, self.colors.sigmoid())


def beginning(box: Tensor, count: int, generator: Generator) -> Theta:
    """``count`` grey Gaussians spread evenly in the ellipsoid that fills most of the box with half sizes ``box`` (3,).
    All figures of a box begin alike, whatever their sentence."""
    import torch

    at = torch.randn(count, 3, generator=generator)
    reach = torch.rand(count, 1, generator=generator) ** (1.0 / 3.0)
    means = torch.nn.functional.normalize(at, dim=1) * reach * box.cpu() * _BEGIN
    spacing = _SPACING * (4.2 * float(box.prod()) * _BEGIN**3 / count) ** (1.0 / 3.0)
    turns = torch.zeros(count, 4)
    turns[:, 0] = 1.0
    columns = (
        means,
        torch.full((count,), _OPACITY),
        torch.full((count, 3), float(np.log(spacing))),
        turns,
        0.1 * torch.randn(count, 3, generator=generator),
    )
    return Theta(*(column.to(box) for column in columns))


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """How far the pose of each of N actors in F frames is from its beginning: ``turns`` (N, F, 3), half the tangent of
    a rotation about the actor's middle; ``shifts`` (N, F, 3), in its sizes; ``log_scales`` (N, F, 3), along the axes of
    its figure. All are 0 at first."""

    turns: Tensor
    shifts: Tensor
    log_scales: Tensor

    def columns(self) -> dict[str, Tensor]:
        """The tensors by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def of(self, actors: Tensor, frame: int, starts: Tensor) -> tuple[Tensor, Tensor]:
        """The matrices (M, 3, 3) and places (M, 3) in a frame of the actors numbered ``actors`` (M,), whose poses the
        program gave as ``starts`` (N, F, 3, 4); differentiable."""
        import torch

        begun, half = starts[actors, frame], self.turns[actors, frame]
        sizes = begun[:, :, :3].square().sum((1, 2)).sqrt() / 3.0**0.5
        turns = rotations(torch.cat([torch.ones_like(half[:, :1]), half], 1))
        matrices = turns @ begun[:, :, :3] * self.log_scales[actors, frame].exp()[:, None, :]
        return matrices, begun[:, :, 3] + sizes[:, None] * self.shifts[actors, frame]


def resting(actors: int, frames: int, like: Tensor) -> Poses:
    """The poses at the beginning, of the type and on the device of ``like``."""
    return Poses(*(like.new_zeros(actors, frames, 3) for _ in range(3)))


class OnStage(Protocol):
    """An actor, as far as it matters for a picture."""

    @property
    def figure(self) -> int: ...

    @property
    def shown(self) -> Any:
        """Whether it is there, by frame."""


def on_stage(
    thetas: Sequence[Gaussians], actors: Sequence[OnStage], starts: Tensor, poses: Poses, frame: int
) -> Splats:
    """All actors of a frame, of which there is at least one, as splats in the world; ``thetas`` are the Gaussians of
    each figure, ``starts`` (N, F, 3, 4) the poses that the program gave."""
    parts = []
    for number, which in shown_by_figure(actors, frame, starts).items():
        one = thetas[number]
        matrices, places = (each.repeat_interleave(len(one), 0) for each in poses.of(which, frame, starts))
        parts.append(posed(one.take(copies(len(one), which)), matrices, places))
    return joined(parts)


def shown_by_figure(actors: Sequence[OnStage], frame: int, like: Tensor) -> dict[int, Tensor]:
    """The numbers (M,) of the actors that a frame shows, for each figure that it has, on the device of ``like``."""
    import torch

    found: dict[int, list[int]] = {}
    for number, actor in enumerate(actors):
        if actor.shown[frame]:
            found.setdefault(actor.figure, []).append(number)
    return {figure: torch.tensor(numbers, device=like.device) for figure, numbers in found.items()}


def copies(count: int, which: Tensor) -> Tensor:
    """Indices of ``count`` Gaussians as often as there are actors ``which``."""
    import torch

    return torch.arange(count, device=which.device).repeat(len(which))


# More Gaussians where the loss pulls, fewer where nothing is seen (3D Gaussian Splatting, section 5).


_LARGE = 0.12  # of the figure's size: what is wider is split, what is smaller doubled
_SPLIT = 1.6  # by which the halves of a split one are smaller
_FAINT = 0.03  # opacity below which a Gaussian goes
_FAR = 1.3  # half sizes of the box beyond which it goes
_LEAST = 16


@dataclass(frozen=True, slots=True, eq=False)
class DensityChange:
    """New Gaussians: ``theta``, and which old one each comes from, ``source`` (K,); ``is_new`` (K,) where it is not
    that one unchanged, so that an optimiser knows nothing of it yet."""

    theta: Theta
    source: Tensor
    is_new: Tensor


def changed(theta: Theta, box: Tensor, pull: Tensor, most: int, generator: Generator) -> DensityChange:
    """The Gaussians after pruning and densification: ``most``, but no more than twice those that stay. ``pull`` (K,) is
    the mean length of the gradient by each centre."""
    import torch

    with torch.no_grad():
        kept = _kept(theta, box)
        source = kept.nonzero()[:, 0]
        count = min(max(most - len(source), 0), len(source))
        chosen = source[pull[source].topk(count).indices] if count else source[:0]
        is_large = theta.log_scales[chosen].exp().amax(1) > _LARGE
        origin = torch.cat([source, chosen])
        columns = {name: column[origin].clone() for name, column in theta.columns().items()}
        split = torch.zeros(len(theta), dtype=torch.bool, device=origin.device)
        split[chosen[is_large]] = True
        halves = split[origin]
        columns["log_scales"][halves] -= torch.log(torch.tensor(_SPLIT))
        columns["means"][halves] += _drawn(theta, origin[halves], generator)
        is_new = halves.clone()
        is_new[len(source) :] = True
    return DensityChange(Theta(**columns), origin, is_new)


def _kept(theta: Theta, box: Tensor) -> Tensor:
    """Which Gaussians stay: those that are seen and near their box, and always the most opaque few."""
    opacity = theta.opacities.sigmoid()
    kept = (opacity > _FAINT) & (theta.means.abs() < _FAR * box).all(1)
    kept[opacity.topk(min(_LEAST, len(theta))).indices] = True
    return kept


def _drawn(theta: Theta, which: Tensor, generator: Generator) -> Tensor:
    """A point of each Gaussian, about its centre (K, 3)."""
    import torch

    at = torch.randn(len(which), 3, generator=generator).to(theta.means) * theta.log_scales[which].exp()
    return (rotations(theta.quaternions[which]) @ at[:, :, None])[:, :, 0]


# What keeps Gaussians well shaped and in place: L_reg and L_layout (the paper, appendix; after GALA3D).
#
# GALA3D's code is not public. L_layout is the Manhattan distance of the centres to their box; L_reg is of our own
# form: how far the longest axis of an ellipsoid exceeds ``LONGEST`` times the shortest.


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
