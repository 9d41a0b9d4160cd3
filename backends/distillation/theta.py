"""What an optimiser changes: the Gaussians of a figure, and the poses of the actors about those they began with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from scenelang.backends.splats.gaussians import Gaussians, Splats, joined, posed, rotations

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

    def of(self, actor: int, frame: int, start: Tensor) -> tuple[Tensor, Tensor]:
        """The matrix (3, 3) and the place (3,) of an actor whose pose was ``start`` (3, 4); differentiable."""
        import torch

        size = start[:, :3].square().sum().sqrt() / 3.0**0.5
        turn = torch.cat([torch.ones_like(self.turns[actor, frame, :1]), self.turns[actor, frame]])
        matrix = rotations(turn[None])[0] @ start[:, :3] * self.log_scales[actor, frame].exp()
        return matrix, start[:, 3] + size * self.shifts[actor, frame]


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


def on_stage(thetas: list[Gaussians], actors: Sequence[OnStage], starts: Tensor, poses: Poses, frame: int) -> Splats:
    """All actors of a frame, of which there is at least one, as splats in the world; ``thetas`` are the Gaussians of
    each figure, ``starts`` (N, F, 3, 4) the poses that the program gave."""
    parts = []
    for number, actor in enumerate(actors):
        if actor.shown[frame]:
            matrix, place = poses.of(number, frame, starts[number, frame])
            parts.append(posed(thetas[actor.figure], matrix, place))
    return joined(parts)
