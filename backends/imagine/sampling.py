"""Drawing one picture: a checkpoint denoises from noise, guided by words, a layout and a depth picture."""

from __future__ import annotations

import inspect
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, need
from scenelang.backends.imagine.models import Checkpoint
from scenelang.backends.imagine.steering import Steering, Unsteered
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

Picture = npt.NDArray[np.uint8]
MOST_STEPS = 1000


@dataclass(frozen=True, slots=True)
class Sampling:
    """``width`` and ``height`` in pixels; so many ``steps``; ``guidance`` 1 is none; the same ``seed`` gives the same
    picture on the same machine; ``control`` is how much a ControlNet counts."""

    width: int
    height: int
    steps: int = 50
    guidance: float = 7.5
    seed: int = 0
    control: float = 1.0

    @property
    def guided(self) -> bool:
        return self.guidance > 1.0

    def latent(self, factor: int) -> tuple[int, int]:
        """Height and width of the latent whose places are ``factor`` pixels wide."""
        return self.height // factor, self.width // factor


@dataclass(frozen=True, slots=True, eq=False)
class Control:
    """A ControlNet and its ``picture`` (H, W, 3), 8-bit: for depth, the nearest is white."""

    network: Any
    picture: Picture


def check_sampling(sampling: Sampling, factor: int) -> None:
    """Raises SceneError("value") for numbers that make no picture."""
    if sampling.width % factor or sampling.height % factor:
        shown = f"{sampling.width} x {sampling.height}"
        raise SceneError("value", f"this model draws pictures in steps of {factor} pixels, so not {shown}")
    if not 1 <= sampling.steps <= MOST_STEPS:
        raise SceneError("value", f"`--steps` must be 1 to {MOST_STEPS:,}, not {sampling.steps:,}")
    for name, value, most in (("guidance", sampling.guidance, 100.0), ("control-scale", sampling.control, 10.0)):
        if not 0.0 <= value <= most:
            raise SceneError("value", f"`--{name}` must be 0 to {most:g}, not {value:g}")


def draw(
    checkpoint: Checkpoint,
    words: Any,
    sampling: Sampling,
    steering: Steering | None = None,
    control: Control | None = None,
    progress: Progress | None = None,
) -> Picture:
    """One picture (H, W, 3), 8-bit sRGB. ``words`` (B, T, D) are the prompt's, with the negative prompt's before them
    where the sampling is guided.

    Raises SceneError("value") for sizes and numbers that make no sense, "unsupported" where memory does not suffice or
    the model's numbers overflow.
    """
    torch = need("torch", INSTALL)
    check_sampling(sampling, checkpoint.factor)
    try:
        with torch.no_grad(), steering or Unsteered() as steered:
            latent = _denoised(checkpoint, words, sampling, steered, control, progress)
            decoded = checkpoint.vae.decode(latent / checkpoint.vae.config.scaling_factor).sample
    except torch.OutOfMemoryError as error:
        message = f"{checkpoint.device} has too little memory for a picture of {sampling.width} x {sampling.height}"
        raise SceneError("unsupported", message, hint="a smaller --size, or --device cpu") from error
    if not bool(torch.isfinite(decoded).all()):
        raise SceneError("unsupported", "the model's numbers overflowed, so there is no picture", hint="--device cpu")
    shares = (decoded[0].float().permute(1, 2, 0) / 2.0 + 0.5).clamp(0.0, 1.0).cpu().numpy()
    return np.asarray((shares * 255.0).round().astype(np.uint8))


def _denoised(
    checkpoint: Checkpoint,
    words: Any,
    sampling: Sampling,
    steering: Steering,
    control: Control | None,
    progress: Progress | None,
) -> Any:
    """The latent (1, C, h, w) after all steps."""
    torch = need("torch", INSTALL)
    unet, scheduler = checkpoint.unet, checkpoint.scheduler
    source = torch.Generator().manual_seed(sampling.seed)  # on the CPU: the same noise for every device
    scheduler.set_timesteps(sampling.steps, device=checkpoint.device)
    shape = (1, unet.config.in_channels, *sampling.latent(checkpoint.factor))
    latent = torch.randn(shape, generator=source, dtype=words.dtype).to(checkpoint.device) * scheduler.init_noise_sigma
    takes_source = "generator" in inspect.signature(scheduler.step).parameters
    more = {"generator": source} if takes_source else {}
    depth = _condition(control, checkpoint, words) if control is not None else None
    times = scheduler.timesteps
    for number, time in enumerate(times):
        given = steering.step(number, len(times))
        read = scheduler.scale_model_input(torch.cat([latent] * len(words)), time)
        residuals = _residuals(control, depth, read, time, words, sampling.control)
        noise = unet(read, time, encoder_hidden_states=words, cross_attention_kwargs=given, **residuals).sample
        if sampling.guided:
            without, with_words = noise.chunk(2)
            noise = without + sampling.guidance * (with_words - without)
        latent = scheduler.step(noise, time, latent, **more).prev_sample
        if progress is not None:
            progress((number + 1) / len(times))
    return latent


def _condition(control: Control, checkpoint: Checkpoint, words: Any) -> Any:
    """A ControlNet's picture as it reads it (1, 3, H, W), 0 to 1."""
    torch = need("torch", INSTALL)
    return torch.from_numpy(control.picture.copy()).permute(2, 0, 1)[None].to(checkpoint.device, words.dtype) / 255.0


def _residuals(control: Control | None, depth: Any, read: Any, time: Any, words: Any, scale: float) -> dict[str, Any]:
    """What a ControlNet adds to the model's levels."""
    if control is None:
        return {}
    shown = depth.expand(len(read), -1, -1, -1)
    down, middle = control.network(
        read, time, encoder_hidden_states=words, controlnet_cond=shown, conditioning_scale=scale, return_dict=False
    )
    return {"down_block_additional_residuals": down, "mid_block_additional_residual": middle}
