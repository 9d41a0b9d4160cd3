"""Pseudo-words learned step by step; only their vectors move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.diffusion.model import Diffusion
from scenelang.backends.inversion.objective import denoising_loss
from scenelang.backends.inversion.settings import Settings
from scenelang.backends.inversion.subjects import Subject
from scenelang.backends.weights import INSTALL

if TYPE_CHECKING:
    from torch import Tensor

_MOMENTS = ("exp_avg", "exp_avg_sq")  # AdamW's own names
_MEASURING = 1 << 40  # away from the numbers of steps, so that what is measured is not what is learned from


class Inverting:
    """Vectors (1, width) by the names of pseudo-words, which begin at ``starts`` and meet the pictures of all
    ``subjects`` together, each under its own sentence.

    The noise of a step depends on the seed and the step's number alone, so that a run that was broken off and restored
    goes on as if it had not been.
    """

    def __init__(
        self, model: Diffusion, subjects: Sequence[Subject], starts: Mapping[str, Tensor], settings: Settings
    ) -> None:
        self._torch = torch = need("torch", INSTALL)
        self._model, self._subjects, self._settings = model, tuple(subjects), settings
        self._device = model.network.device
        with torch.no_grad():
            pictures = [subject.picture[None].to(self._device) for subject in subjects]
            self._latents = [model.pixels.encode(picture) for picture in pictures]
        self._vectors = {name: start.detach().clone().to(self._device) for name, start in starts.items()}
        for vector in self._vectors.values():
            vector.requires_grad_(True)
        self._optimiser = torch.optim.AdamW(list(self._vectors.values()), lr=settings.rate)
        self.done = 0

    @property
    def steps(self) -> int:
        return self._settings.steps

    def step(self) -> float:
        """One step of all subjects; returns the mean of their losses before it."""
        generator = self._generator(self.done)
        self._optimiser.zero_grad()
        total = 0.0
        for number in range(len(self._subjects)):  # one after the other, since each holds a network's activations
            loss = self._loss(number, *self._drawn(number, self._settings.batch, generator)) / len(self._subjects)
            loss.backward()  # type: ignore[no-untyped-call]
            total += float(loss.detach())
        self._optimiser.step()
        self.done += 1
        return total

    def measured(self) -> float:
        """The mean loss with the same steps and noise at every call, those evenly over the schedule."""
        generator, draws = self._generator(_MEASURING), self._settings.draws
        steps = (self._torch.arange(draws) + 0.5) / draws * self._model.schedule.steps
        total = 0.0
        with self._torch.no_grad():
            for number, latents in enumerate(self._latents):
                for step in steps.long():
                    noise = self._torch.randn(latents.shape, generator=generator).to(self._device)
                    total += float(self._loss(number, step[None].to(self._device), noise))
        return total / (draws * len(self._subjects))

    def vectors(self) -> dict[str, npt.NDArray[np.float32]]:
        """The vectors as they are now, by name."""
        return {name: vector.detach().float().cpu().numpy().copy() for name, vector in self._vectors.items()}

    def _generator(self, number: int) -> Any:
        mixed = np.random.SeedSequence([self._settings.seed % (1 << 64), number]).generate_state(1, np.uint64)[0]
        return self._torch.Generator().manual_seed(int(mixed) >> 1)

    def _drawn(self, number: int, count: int, generator: Any) -> tuple[Tensor, Tensor]:
        """Random steps and noise, the same on every device."""
        torch, shape = self._torch, self._latents[number].shape[1:]
        steps = torch.randint(0, self._model.schedule.steps, (count,), generator=generator)
        noise = torch.randn((count, *shape), generator=generator)
        return steps.to(self._device), noise.to(self._device)

    def _loss(self, number: int, steps: Tensor, noise: Tensor) -> Tensor:
        states = self._model.words.encode([self._subjects[number].prompt], self._vectors)
        count = len(steps)
        latents = self._latents[number].expand(count, -1, -1, -1)
        return denoising_loss(self._model, latents, states.expand(count, -1, -1), steps, noise)

    # --- breaks ------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Tensor]:
        """All that a later run needs to go on, beside the number of steps ``done``."""
        found = {}
        for name, vector in self._vectors.items():
            found[f"vector/{name}"] = vector.detach().cpu().clone()
            for moment in _MOMENTS if self.done else ():
                found[f"{moment}/{name}"] = self._optimiser.state[vector][moment].detach().cpu().clone()
        return found

    def restore(self, state: Mapping[str, Tensor], done: int) -> None:
        """Go on from ``state`` after ``done`` steps; raises KeyError or ValueError for that of other pseudo-words."""
        with self._torch.no_grad():
            for name, vector in self._vectors.items():
                if state[f"vector/{name}"].shape != vector.shape:
                    raise ValueError(f"the vector of {name} has another shape")
                vector.copy_(state[f"vector/{name}"])
                if done:
                    moments = {moment: state[f"{moment}/{name}"].to(self._device) for moment in _MOMENTS}
                    if any(moment.shape != vector.shape for moment in moments.values()):
                        raise ValueError(f"the moments of {name} have another shape")
                    self._optimiser.state[vector] = {"step": self._torch.tensor(float(done)), **moments}
        self.done = done
