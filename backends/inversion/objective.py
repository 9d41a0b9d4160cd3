"""How well a diffusion model takes a sentence for a picture: the loss that it was trained with."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenelang.backends.base import need
from scenelang.backends.diffusion.model import Diffusion
from scenelang.backends.weights import INSTALL

if TYPE_CHECKING:
    from torch import Tensor


def denoising_loss(model: Diffusion, latents: Tensor, states: Tensor, steps: Tensor, noise: Tensor) -> Tensor:
    """The mean square between what the network says of noisy ``latents`` (B, C, h, w) after ``steps`` (B,), told
    ``states`` (B, T, D), and what it was trained to say, which is ``noise`` itself for most models.

    Every row is denoised alone and without a camera: MVDream's mode for single pictures.
    """
    functional = need("torch.nn.functional", INSTALL)
    noisy = model.schedule.noised(latents, noise, steps)
    output = model.predict(noisy, steps, states)
    return functional.mse_loss(output, model.schedule.target(latents, noise, steps))  # type: ignore[no-any-return]
