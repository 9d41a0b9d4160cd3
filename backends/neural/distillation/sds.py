"""Score distillation sampling (SDS): gradients for images from a diffusion model.

Sources: the paper, appendix "SDS-Based Renderer"; DreamFusion (Poole et al. 2022), equation 3; MVDream (Shi et al.
2023), section 3.3. An image's latents ``z`` are noised at the timestep eta, ``sqrt(a) z + sqrt(1 - a) eps``, and the
model predicts the noise with and without the prompt. (The paper prints alpha in both terms.)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenelang.grammar.datum import dataclass
from scenelang.grammar.settings import setting

if TYPE_CHECKING:
    from torch import Generator, Tensor

    from scenelang.backends.neural.diffusion import DiffusionModel


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

    scale: float = setting(50.0, "classifier-free guidance scale (default 50)", "--guidance", metavar="X", read=float)
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

    Strong guidance increases the standard deviation, which saturates colours (MVDream, section 3.3).
    """
    original, unguided = ((noisy - (1.0 - alphas).sqrt() * each) / alphas.sqrt() for each in (guided, conditional))
    group_size = views if len(original) % views == 0 else 1
    groups = (each.reshape(-1, group_size, *each.shape[1:]) for each in (unguided, original))
    unguided_std, guided_std = (each.std(dim=(1, 2, 3, 4), keepdim=True) for each in groups)
    factor = (unguided_std / guided_std.clamp_min(1e-8)).expand(-1, group_size, 1, 1, 1).reshape(-1, 1, 1, 1)
    return rescale * original * factor + (1.0 - rescale) * original
