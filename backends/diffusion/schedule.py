"""How much noise there is at each step, and what a network's output says of picture and noise."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenelang.backends.base import need
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from torch import Tensor

PREDICTIONS = ("epsilon", "v_prediction", "sample")
_MOST_STEPS = 10_000


@dataclass(frozen=True, slots=True, eq=False)
class Schedule:
    """``alphas`` (T,) are the shares of the picture's variance that are left after each step, the cumulative products
    of DDPM; ``prediction``, one of PREDICTIONS, is what the network's output means: the noise, the velocity
    ``sqrt(a) noise - sqrt(1 - a) clean``, or the clean picture."""

    alphas: Tensor
    prediction: str = "epsilon"

    @property
    def steps(self) -> int:
        """T; steps count from 0, the least noise, to T - 1."""
        return len(self.alphas)

    def noised(self, clean: Tensor, noise: Tensor, steps: Tensor) -> Tensor:
        """``clean`` (B, ...) with ``noise`` of that shape as after ``steps`` (B,)."""
        signal, spread = self._shares(clean, steps)
        return signal * clean + spread * noise

    def target(self, clean: Tensor, noise: Tensor, steps: Tensor) -> Tensor:
        """What the network was trained to say of ``clean`` (B, ...) with ``noise`` as after ``steps`` (B,)."""
        if self.prediction == "epsilon":
            return noise
        if self.prediction == "sample":
            return clean
        signal, spread = self._shares(clean, steps)
        return signal * noise - spread * clean

    def noise_of(self, output: Tensor, noisy: Tensor, steps: Tensor) -> Tensor:
        """The noise that ``output`` (B, ...) of the network sees in ``noisy`` after ``steps`` (B,)."""
        if self.prediction == "epsilon":
            return output
        signal, spread = self._shares(noisy, steps)
        if self.prediction == "v_prediction":
            return signal * output + spread * noisy
        return (noisy - signal * output) / spread

    def clean_of(self, output: Tensor, noisy: Tensor, steps: Tensor) -> Tensor:
        """What ``output`` (B, ...) of the network takes for the picture in ``noisy`` after ``steps`` (B,).

        From predicted noise it is not finite at a step that leaves nothing of the picture.
        """
        if self.prediction == "sample":
            return output
        signal, spread = self._shares(noisy, steps)
        if self.prediction == "v_prediction":
            return signal * noisy - spread * output
        return (noisy - spread * output) / signal

    def _shares(self, like: Tensor, steps: Tensor) -> tuple[Tensor, Tensor]:
        alphas = self.alphas.to(like.device)[steps.to(like.device)]
        alphas = alphas.reshape(-1, *[1] * (like.ndim - 1))
        return alphas.sqrt().to(like.dtype), (1.0 - alphas).sqrt().to(like.dtype)


def schedule_of(config: Mapping[str, Any]) -> Schedule:
    """The schedule of a ``scheduler_config.json`` of diffusers, as its DDPMScheduler computes it.

    Raises SceneError("weights") for schedules that are not known here.
    """
    torch = need("torch", INSTALL)
    prediction = config.get("prediction_type", "epsilon")
    if prediction not in PREDICTIONS:
        raise SceneError("weights", f"a scheduler that predicts {prediction!r} is not known ({', '.join(PREDICTIONS)})")
    alphas = torch.cumprod(1.0 - _betas(torch, config), dim=0)
    if config.get("rescale_betas_zero_snr"):
        alphas = _to_nothing(alphas)
    if not bool(torch.isfinite(alphas).all() and (alphas >= 0.0).all() and (alphas <= 1.0).all()):
        raise SceneError("weights", "the scheduler's betas are not between 0 and 1")
    return Schedule(alphas, prediction)


def _betas(torch: Any, config: Mapping[str, Any]) -> Any:
    kind = config.get("beta_schedule", "linear")
    given = config.get("trained_betas")
    steps = len(given) if given is not None else config.get("num_train_timesteps", 1000)
    if type(steps) is not int or not 2 <= steps <= _MOST_STEPS:
        raise SceneError("weights", f"a scheduler has 2 to {_MOST_STEPS:,} steps, not {steps!r}")
    if given is not None:
        return torch.tensor(given, dtype=torch.float32)
    start, end = float(config.get("beta_start", 0.0001)), float(config.get("beta_end", 0.02))
    if not 0.0 < start < 1.0 or not 0.0 < end < 1.0:
        raise SceneError("weights", f"the scheduler's betas are not between 0 and 1: {start:g}, {end:g}")
    if kind == "linear":
        return torch.linspace(start, end, steps, dtype=torch.float32)
    if kind == "scaled_linear":
        return torch.linspace(start**0.5, end**0.5, steps, dtype=torch.float32) ** 2
    if kind == "squaredcos_cap_v2":
        left = [math.cos((i / steps + 0.008) / 1.008 * math.pi / 2.0) ** 2 for i in range(steps + 1)]
        return torch.tensor([min(1.0 - left[i + 1] / left[i], 0.999) for i in range(steps)], dtype=torch.float32)
    raise SceneError("weights", f"the beta schedule {kind!r} is not known (linear, scaled_linear, squaredcos_cap_v2)")


def _to_nothing(alphas: Any) -> Any:
    """Shifted and stretched so that the last step leaves nothing of the picture, and the first stays as it is."""
    roots = alphas.sqrt()
    first, last = roots[0].clone(), roots[-1].clone()
    return ((roots - last) * (first / (first - last))) ** 2
