"""What is optimized, and the terms of the loss.

The parameters are the Gaussians of a group, with density control, and offsets of the instances' poses. The terms are
L_reg and L_layout of the paper, and score distillation sampling (SDS), which gives gradients for images from a
diffusion model. Sources: the paper, appendix "SDS-Based Renderer"; DreamFusion (Poole et al. 2022), equation 3; MVDream
(Shi et al. 2023), section 3.3. An image's latents ``z`` are noised at the timestep eta,
``sqrt(a) z + sqrt(1 - a) eps``, and the model predicts the noise with and without the prompt. (The paper prints alpha
in both terms.)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from scenelang.backends.neural.splats.gaussians import Gaussians, Splats, apply_pose, concatenate_splats, rotations
from scenelang.grammar.datum import dataclass, fields
from scenelang.grammar.settings import setting, within

if TYPE_CHECKING:
    from torch import Generator, Tensor

    from scenelang.backends.neural.diffusion import DiffusionModel

_INITIAL_EXTENT = 0.8  # size of the initial ellipsoid, in half sizes of the box
_INITIAL_OPACITY = -2.2  # logit of 0.1, as in 3D Gaussian Splatting
_INITIAL_SCALE = 0.6  # standard deviation, in mean distances between neighbors


@dataclass(frozen=True, slots=True, eq=False)
class Theta:
    """Parameters of K Gaussians in the frame of their group: the paper's phi = (mu, alpha, s, q, c).

    Attributes
    ----------
    means
        (K, 3).
    opacities
        (K,), logits.
    log_scales
        (K, 3).
    quaternions
        (K, 4), w first; need not be normalised.
    colors
        (K, 3), logits of sRGB, the color space of diffusion models.
    """

    means: Tensor
    opacities: Tensor
    log_scales: Tensor
    quaternions: Tensor
    colors: Tensor

    def __len__(self) -> int:
        return len(self.means)

    def columns(self) -> dict[str, Tensor]:
        """Return the tensors by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def gaussians(self) -> Gaussians:
        """Return the Gaussians for the renderer, with colors in [0, 1], sRGB."""
        return Gaussians(self.means, self.log_scales, self.quaternions, self.opacities, self.colors.sigmoid())


def initial_theta(box: Tensor, count: int, generator: Generator) -> Theta:
    """Return ``count`` grey Gaussians, uniformly distributed in an ellipsoid in the box with half sizes ``box`` (3,).

    The result depends on the box only, not on the prompt.
    """
    import torch

    directions = torch.randn(count, 3, generator=generator)
    radii = torch.rand(count, 1, generator=generator) ** (1.0 / 3.0)
    means = torch.nn.functional.normalize(directions, dim=1) * radii * box.cpu() * _INITIAL_EXTENT
    # 4.2 is the volume 4 pi / 3 of the unit ball
    scale = _INITIAL_SCALE * (4.2 * float(box.prod()) * _INITIAL_EXTENT**3 / count) ** (1.0 / 3.0)
    quaternions = torch.zeros(count, 4)
    quaternions[:, 0] = 1.0
    columns = (
        means,
        torch.full((count,), _INITIAL_OPACITY),
        torch.full((count, 3), float(np.log(scale))),
        quaternions,
        0.1 * torch.randn(count, 3, generator=generator),
    )
    return Theta(*(column.to(box) for column in columns))


@dataclass(frozen=True, slots=True, eq=False)
class PoseOffsets:
    """Learned offsets of the poses of N instances in F frames from their initial poses; all zero initially.

    Attributes
    ----------
    rotations
        (N, F, 3), rotations about the instance's center: the vector part of a quaternion with scalar part 1.
    translations
        (N, F, 3), in units of the instance's size.
    log_scales
        (N, F, 3), along the axes of its group.
    """

    rotations: Tensor
    translations: Tensor
    log_scales: Tensor

    def columns(self) -> dict[str, Tensor]:
        """Return the tensors by their names in checkpoints."""
        return {"turns": self.rotations, "shifts": self.translations, "log_scales": self.log_scales}

    def apply(self, instances: Tensor, frame: int, initial: Tensor) -> tuple[Tensor, Tensor]:
        """Return the matrices (M, 3, 3) and translations (M, 3) of ``instances`` (M,) in a frame; differentiable.

        ``initial`` (N, F, 3, 4) are the poses from the program.
        """
        import torch

        poses, vectors = initial[instances, frame], self.rotations[instances, frame]
        sizes = poses[:, :, :3].square().sum((1, 2)).sqrt() / 3.0**0.5
        matrices = rotations(torch.cat([torch.ones_like(vectors[:, :1]), vectors], 1))
        matrices = matrices @ poses[:, :, :3] * self.log_scales[instances, frame].exp()[:, None, :]
        return matrices, poses[:, :, 3] + sizes[:, None] * self.translations[instances, frame]


def zero_offsets(instances: int, frames: int, like: Tensor) -> PoseOffsets:
    """Return the initial offsets, with the dtype and device of ``like``."""
    return PoseOffsets(*(like.new_zeros(instances, frames, 3) for _ in range(3)))


class VisibleInstance(Protocol):
    """Attributes of an instance that are required for rendering."""

    @property
    def group(self) -> int:
        """Index of its group."""

    @property
    def visible(self) -> Any:
        """Visibility in each frame."""


def compose(
    groups: Sequence[Gaussians], instances: Sequence[VisibleInstance], initial: Tensor, offsets: PoseOffsets, frame: int
) -> Splats:
    """Return all instances of a frame, of which there must be at least one, as splats in the world.

    ``groups`` are the Gaussians of each group, ``initial`` (N, F, 3, 4) the poses from the program.
    """
    parts = []
    for number, members in visible_by_group(instances, frame, initial).items():
        gaussians = groups[number]
        matrices, translations = (
            each.repeat_interleave(len(gaussians), 0) for each in offsets.apply(members, frame, initial)
        )
        parts.append(apply_pose(gaussians.take(repeat_indices(len(gaussians), members)), matrices, translations))
    return concatenate_splats(parts)


def visible_by_group(instances: Sequence[VisibleInstance], frame: int, like: Tensor) -> dict[int, Tensor]:
    """Return the indices (M,) of a frame's visible instances by group, on the device of ``like``."""
    import torch

    numbers_by_group: dict[int, list[int]] = {}
    for number, instance in enumerate(instances):
        if instance.visible[frame]:
            numbers_by_group.setdefault(instance.group, []).append(number)
    return {group: torch.tensor(numbers, device=like.device) for group, numbers in numbers_by_group.items()}


def repeat_indices(count: int, members: Tensor) -> Tensor:
    """Return the indices of ``count`` Gaussians, repeated for each of ``members``."""
    import torch

    return torch.arange(count, device=members.device).repeat(len(members))


# Adaptive density control (Kerbl et al., "3D Gaussian Splatting", 2023, section 5.2): clone or split Gaussians with
# large positional gradients, and prune transparent ones.


_SPLIT_SIZE = 0.12  # in units of the group's size; larger Gaussians are split, smaller ones cloned
_SPLIT_FACTOR = 1.6  # ratio of the scales before and after a split, as in 3D Gaussian Splatting
_MIN_OPACITY = 0.03  # of Gaussians that are not pruned
_MAX_DISTANCE = 1.3  # of Gaussians that are not pruned, in half sizes of the box
_MIN_COUNT = 16  # Gaussians that are never pruned


@dataclass(frozen=True, slots=True, eq=False)
class DensityChange:
    """Result of density control.

    Attributes
    ----------
    theta
        New Gaussians.
    source
        (K,), index of the old Gaussian from which each comes.
    is_new
        (K,), False for unchanged Gaussians, whose optimizer state remains valid.
    """

    theta: Theta
    source: Tensor
    is_new: Tensor


def densify_and_prune(
    theta: Theta, box: Tensor, gradient: Tensor, max_count: int, generator: Generator
) -> DensityChange:
    """Prune and densify Gaussians, to ``max_count`` but at most twice those left by pruning.

    ``gradient`` (K,) is the mean norm of the gradient by each mean.
    """
    import torch

    with torch.no_grad():
        source = _unpruned(theta, box).nonzero()[:, 0]
        count = min(max(max_count - len(source), 0), len(source))
        chosen = source[gradient[source].topk(count).indices] if count else source[:0]
        is_large = theta.log_scales[chosen].exp().amax(1) > _SPLIT_SIZE
        origin = torch.cat([source, chosen])
        columns = {name: column[origin].clone() for name, column in theta.columns().items()}
        split = torch.zeros(len(theta), dtype=torch.bool, device=origin.device)
        split[chosen[is_large]] = True
        halves = split[origin]
        columns["log_scales"][halves] -= torch.log(torch.tensor(_SPLIT_FACTOR))
        columns["means"][halves] += _sample_offsets(theta, origin[halves], generator)
        is_new = halves.clone()
        is_new[len(source) :] = True
    return DensityChange(Theta(**columns), origin, is_new)


def _unpruned(theta: Theta, box: Tensor) -> Tensor:
    """Return the mask (K,) of Gaussians that are visible and near their box, or among the most opaque few."""
    opacity = theta.opacities.sigmoid()
    mask = (opacity > _MIN_OPACITY) & (theta.means.abs() < _MAX_DISTANCE * box).all(1)
    mask[opacity.topk(min(_MIN_COUNT, len(theta))).indices] = True
    return mask


def _sample_offsets(theta: Theta, indices: Tensor, generator: Generator) -> Tensor:
    """Sample a point (K, 3) from each Gaussian, relative to its mean."""
    import torch

    local = torch.randn(len(indices), 3, generator=generator).to(theta.means) * theta.log_scales[indices].exp()
    return (rotations(theta.quaternions[indices]) @ local[:, :, None])[:, :, 0]


# Regularization: L_reg and L_layout (the paper, appendix, after GALA3D).
#
# The code of GALA3D is not public. L_layout is the Manhattan distance of the means to their box; the form of L_reg is
# specific to this implementation: the excess of an ellipsoid's axis ratio over ``MAX_AXIS_RATIO``.


MAX_AXIS_RATIO = 8.0


def axis_ratio_loss(axes: Tensor, matrices: Tensor) -> Tensor:
    """Return L_reg: the mean excess of the ratio of longest and shortest axis over MAX_AXIS_RATIO.

    ``axes`` (K, 3, 3) are those of the Gaussians, ``matrices`` (N, 3, 3) the poses of instances, which get no gradient.
    """
    import torch

    spread = matrices.detach()[:, None] @ axes
    with torch.no_grad():
        _, eigenvectors = torch.linalg.eigh((spread @ spread.mT).double())
        longest, shortest = (eigenvectors[..., i].to(axes) for i in (2, 0))
    # to first order, an eigenvalue changes as the covariance along its fixed eigenvector, so eigh needs no gradient
    long, short = ((spread.mT @ each[..., None]).square().sum((-2, -1)) for each in (longest, shortest))
    ratio = (long / short.clamp_min(1e-12)).clamp_min(1.0).sqrt()
    return torch.relu(ratio - MAX_AXIS_RATIO).mean()


def layout_loss(theta: Theta, box: Tensor) -> Tensor:
    """Return L_layout: the mean Manhattan distance of the means to the box with half sizes ``box`` (3,)."""
    return (theta.means.abs() - box).clamp_min(0.0).sum(1).mean()


# --- score distillation sampling --------------------------------------------------------------------------------------


WEIGHTINGS = ("reconstruction", "sds", "uniform")


@dataclass(frozen=True, slots=True)
class Guidance:
    """Classifier-free guidance and timestep weighting of an SDS term.

    Parameters
    ----------
    scale : float
        Classifier-free guidance scale.
    weighting : str
        Timestep weighting: "sds" is w(eta) = 1 - a, "uniform" is 1, "reconstruction" is MVDream's distance to the
        predicted original image.
    rescale : float
        Fraction of the contrast rescaling of "reconstruction" (Lin et al. 2024, section 3.4), 0 to 1.
    """

    scale: float = setting(
        50.0, "classifier-free guidance scale (default 50)", "--guidance", metavar="X", read=within(0.0, 10_000.0)
    )
    weighting: str = setting("reconstruction", "timestep weighting", choices=WEIGHTINGS)
    rescale: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Conditioning:
    """Conditioning of a diffusion model for B images.

    Attributes
    ----------
    prompt, empty
        (B, T, D), hidden states of the prompt and of the empty prompt.
    cameras
        (B, 16), or None.
    depth
        (B, 3, H, W), depth maps, or None.
    """

    prompt: Tensor
    empty: Tensor
    cameras: Tensor | None = None
    depth: Tensor | None = None


@dataclass(frozen=True, slots=True)
class TimestepRange:
    """Range from which timesteps are sampled, in fractions of the noise schedule."""

    low: float = 0.02
    high: float = 0.98


def annealed_range(done: float) -> TimestepRange:
    """Return the timestep range after the fraction ``done`` of the training.

    This is MVDream's annealing, which reaches [0.02, 0.5] after 80 % of the training.
    """
    part = min(done / 0.8, 1.0)
    return TimestepRange(0.98 - 0.96 * part, 0.98 - 0.48 * part)


def sds_loss(
    model: DiffusionModel,
    pictures: Tensor,
    conditioning: Conditioning,
    guidance: Guidance,
    timestep_range: TimestepRange,
    generator: Generator,
) -> Tensor:
    """Return a scalar whose gradient with respect to ``pictures`` is that of SDS.

    ``pictures`` (B, 3, H, W) are sRGB in [0, 1]. All images that are denoised jointly have the same timestep.
    """
    import torch

    latents = model.codec.encode(pictures)
    groups = len(latents) // (model.views if conditioning.cameras is not None else 1)
    count = len(model.schedule.alphas_cumprod)
    low = int(timestep_range.low * count)
    high = max(int(timestep_range.high * count), low + 1)
    timesteps = torch.randint(low, min(high, count - 1) + 1, (groups,), generator=generator).clamp_max(count - 1)
    timesteps = timesteps.repeat_interleave(len(latents) // groups).to(latents.device)
    noise = torch.randn(latents.shape, generator=generator).to(latents)
    with torch.no_grad():
        noisy = model.schedule.add_noise(latents, noise, timesteps)
        conditional, unconditional = _predict_noise(model, noisy, timesteps, conditioning)
    return guided_loss(model, latents, noise, noisy, timesteps, conditional, unconditional, guidance)


def _predict_noise(
    model: DiffusionModel, noisy: Tensor, timesteps: Tensor, conditioning: Conditioning
) -> tuple[Tensor, Tensor]:
    """Predict the noise with the prompt and with the empty prompt, in one batch."""
    import torch

    def twice(rows: Tensor | None) -> Tensor | None:
        return None if rows is None else torch.cat([rows, rows])

    doubled, all_timesteps = torch.cat([noisy, noisy]), torch.cat([timesteps, timesteps])
    states = torch.cat([conditioning.prompt, conditioning.empty])
    cameras, depth = twice(conditioning.cameras), twice(conditioning.depth)
    output = model.predict(doubled, all_timesteps, states, cameras, depth).to(noisy)
    conditional, unconditional = model.schedule.predicted_noise(output, doubled, all_timesteps).chunk(2)
    return conditional, unconditional


def guided_loss(
    model: DiffusionModel,
    latents: Tensor,
    noise: Tensor,
    noisy: Tensor,
    timesteps: Tensor,
    conditional: Tensor,
    unconditional: Tensor,
    guidance: Guidance,
) -> Tensor:
    """Return half the squared distance of the latents to their guided target, averaged over the images.

    The target has no gradient, so the gradient by the latents is their difference from it.
    """
    import torch

    guided = unconditional + guidance.scale * (conditional - unconditional)
    alphas = model.schedule.alphas_cumprod.to(latents)[timesteps][:, None, None, None]
    with torch.no_grad():
        if guidance.weighting == "reconstruction":
            target = _reconstruction(noisy, alphas, conditional, guided, guidance.rescale, model.views)
        else:
            weight = 1.0 - alphas if guidance.weighting == "sds" else 1.0
            target = latents - weight * (guided - noise)
    return 0.5 * (latents - target).square().sum() / len(latents)


def _reconstruction(
    noisy: Tensor, alphas: Tensor, conditional: Tensor, guided: Tensor, rescale: float, views: int
) -> Tensor:
    """Return the original latents predicted by the guided noise, rescaled towards the contrast without guidance.

    Strong guidance increases the standard deviation, which saturates colors (MVDream, section 3.3).
    """
    original, unguided = ((noisy - (1.0 - alphas).sqrt() * each) / alphas.sqrt() for each in (guided, conditional))
    group_size = views if len(original) % views == 0 else 1
    groups = (each.reshape(-1, group_size, *each.shape[1:]) for each in (unguided, original))
    unguided_std, guided_std = (each.std(dim=(1, 2, 3, 4), keepdim=True) for each in groups)
    factor = (unguided_std / guided_std.clamp_min(1e-8)).expand(-1, group_size, 1, 1, 1).reshape(-1, 1, 1, 1)
    return rescale * original * factor + (1.0 - rescale) * original
