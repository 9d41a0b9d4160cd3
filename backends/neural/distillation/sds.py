"""Score distillation sampling: the gradient by which a diffusion model says how a picture should change (the paper,
appendix; DreamFusion, equation 3; MVDream, section 3.3).

A picture's latents ``z`` are noised to the step eta, ``sqrt(a) z + sqrt(1 - a) eps``, and the model says which noise
it sees, with and without the sentence. (The paper prints alpha on both terms.)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenelang.grammar.settings import setting

if TYPE_CHECKING:
    from torch import Generator, Tensor

    from scenelang.backends.neural.diffusion import DiffusionModel


WEIGHTINGS = ("reconstruction", "sds", "uniform")


@dataclass(frozen=True, slots=True)
class Guiding:
    """``guidance``: how much more the sentence counts than none. ``weighting``: "sds" is w(eta) = 1 - a, "uniform" 1,
    "reconstruction" MVDream's distance to the picture that the model sees, whose contrast is brought back by the share
    ``rescale``."""

    guidance: float = setting(50.0, "classifier-free guidance scale (default 50)", metavar="X", read=float)
    weighting: str = setting("reconstruction", "of the steps of noise", choices=WEIGHTINGS)
    rescale: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Heard:
    """What the model is told of B pictures: ``states`` of the sentence and of no sentence, (B, T, D) each; cameras
    (B, 16) and depth pictures (B, 3, H, W), or None."""

    states: Tensor
    unsaid: Tensor
    cameras: Tensor | None = None
    depth: Tensor | None = None


@dataclass(frozen=True, slots=True)
class Window:
    """From which part of the noise steps are drawn, as shares of them all."""

    low: float = 0.02
    high: float = 0.98


def window_at(done: float) -> Window:
    """The window when the share ``done`` of the work is: MVDream's annealing, which ends within [0.02, 0.5] after
    four fifths."""
    part = min(done / 0.8, 1.0)
    return Window(0.98 - 0.96 * part, 0.98 - 0.48 * part)


def sds_loss(
    model: DiffusionModel, pictures: Tensor, heard: Heard, guiding: Guiding, window: Window, generator: Generator
) -> Tensor:
    """A number whose gradient by ``pictures`` (B, 3, H, W), sRGB in [0, 1], is that of SDS; one step of noise for all
    pictures that are denoised together."""
    import torch

    latents = model.codec.encode(pictures)
    groups = len(latents) // (model.views if heard.cameras is not None else 1)
    most = len(model.schedule.alphas_cumprod)
    low, high = int(window.low * most), max(int(window.high * most), int(window.low * most) + 1)
    steps = torch.randint(low, min(high, most - 1) + 1, (groups,), generator=generator).clamp_max(most - 1)
    steps = steps.repeat_interleave(len(latents) // groups).to(latents.device)
    noise = torch.randn(latents.shape, generator=generator).to(latents)
    with torch.no_grad():
        noisy = model.schedule.add_noise(latents, noise, steps)
        said, unsaid = _both(model, noisy, steps, heard)
    return distance(model, latents, noise, noisy, steps, said, unsaid, guiding)


def _both(model: DiffusionModel, noisy: Tensor, steps: Tensor, heard: Heard) -> tuple[Tensor, Tensor]:
    """The noise that the model sees with the sentence and without."""
    import torch

    def twice(rows: Tensor | None) -> Tensor | None:
        return None if rows is None else torch.cat([rows, rows])

    doubled, all_steps = torch.cat([noisy, noisy]), torch.cat([steps, steps])
    states = torch.cat([heard.states, heard.unsaid])
    output = model.predict(doubled, all_steps, states, twice(heard.cameras), twice(heard.depth)).to(noisy)
    said, unsaid = model.schedule.predicted_noise(output, doubled, all_steps).chunk(2)
    return said, unsaid


def distance(
    model: DiffusionModel,
    latents: Tensor,
    noise: Tensor,
    noisy: Tensor,
    steps: Tensor,
    said: Tensor,
    unsaid: Tensor,
    guiding: Guiding,
) -> Tensor:
    """Half the squared distance of the latents to where guidance wants them, which is held still, for each picture."""
    import torch

    guided = unsaid + guiding.guidance * (said - unsaid)
    alphas = model.schedule.alphas_cumprod.to(latents)[steps][:, None, None, None]
    with torch.no_grad():
        if guiding.weighting == "reconstruction":
            target = _reconstructed(noisy, alphas, said, guided, guiding.rescale, model.views)
        else:
            weight = 1.0 - alphas if guiding.weighting == "sds" else 1.0
            target = latents - weight * (guided - noise)
    return 0.5 * (latents - target).square().sum() / len(latents)


def _reconstructed(noisy: Tensor, alphas: Tensor, said: Tensor, guided: Tensor, rescale: float, views: int) -> Tensor:
    """The picture that the guided noise leaves, its spread brought near that without guidance."""
    clean, calm = ((noisy - (1.0 - alphas).sqrt() * each) / alphas.sqrt() for each in (guided, said))
    together = views if len(clean) % views == 0 else 1
    groups = (each.reshape(-1, together, *each.shape[1:]) for each in (calm, clean))
    own, wide = (each.std(dim=(1, 2, 3, 4), keepdim=True) for each in groups)
    factor = (own / wide.clamp_min(1e-8)).expand(-1, together, 1, 1, 1).reshape(-1, 1, 1, 1)
    return rescale * clean * factor + (1.0 - rescale) * clean
