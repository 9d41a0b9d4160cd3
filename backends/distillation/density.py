"""More Gaussians where the loss pulls, fewer where nothing is seen (3D Gaussian Splatting, section 5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenelang.backends.distillation.theta import Theta
from scenelang.backends.splats.gaussians import rotations

if TYPE_CHECKING:
    from torch import Generator, Tensor

_LARGE = 0.12  # of the figure's size: what is wider is split, what is smaller doubled
_SPLIT = 1.6  # by which the halves of a split one are smaller
_FAINT = 0.03  # opacity below which a Gaussian goes
_FAR = 1.3  # half sizes of the box beyond which it goes
_LEAST = 16


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """New Gaussians: ``theta``, and which old one each comes from, ``source`` (K,); ``is_new`` (K,) where it is not
    that one unchanged, so that an optimiser knows nothing of it yet."""

    theta: Theta
    source: Tensor
    is_new: Tensor


def changed(theta: Theta, box: Tensor, pull: Tensor, most: int, generator: Generator) -> Change:
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
    return Change(Theta(**columns), origin, is_new)


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
