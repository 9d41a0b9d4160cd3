"""One figure while it is learned: its Gaussians, their optimiser, and how strongly each is pulled."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenelang.backends.distillation.density import changed
from scenelang.backends.distillation.settings import Settings
from scenelang.backends.distillation.theta import Theta, beginning

if TYPE_CHECKING:
    from torch import Generator, Tensor


class FigureLearning:
    """``theta`` are leaves of torch's graph; ``turns`` counts the steps made."""

    def __init__(self, box: Tensor, settings: Settings, generator: Generator) -> None:
        self.box, self._settings = box, settings
        self.turns = 0
        self._take(beginning(box, settings.start, generator))

    def _take(self, theta: Theta) -> None:
        """Optimise ``theta`` from now on, of which the optimiser knows nothing yet."""
        import torch

        columns = {name: column.detach().clone().requires_grad_(True) for name, column in theta.columns().items()}
        self.theta = Theta(**columns)
        rates = self._settings.rates
        groups = [{"params": [column], "lr": getattr(rates, name)} for name, column in columns.items()]
        self._adam = torch.optim.Adam(groups, eps=1e-15)
        self._pull = torch.zeros(len(theta), device=theta.means.device)
        self._pulls = 0

    @property
    def done(self) -> float:
        """The share of the steps that is done."""
        return self.turns / max(self._settings.steps, 1)

    def step(self) -> None:
        """Follow the gradients that are there: of the figure's own terms, and of the scene's since its last turn."""
        gradient = self.theta.means.grad
        if gradient is not None:
            self._pull += gradient.norm(dim=1)
            self._pulls += 1
        self._adam.step()
        self._adam.zero_grad(set_to_none=True)

    def turned(self, generator: Generator) -> None:
        """Count a step of the figure's own; now and then change how many Gaussians there are."""
        self.turns += 1
        settings = self._settings
        left = settings.growths - self.turns // settings.every + 1
        if self.turns % settings.every == 0 and left > 0:
            growth = max(settings.most / len(self.theta), 1.0) ** (1.0 / left)
            self._densify(min(math.ceil(growth * len(self.theta)), settings.most), generator)

    def _densify(self, most: int, generator: Generator) -> None:
        """More Gaussians, up to ``most``, and fewer; the optimiser goes on with those that stay."""
        found = changed(self.theta, self.box, self._pull / max(self._pulls, 1), most, generator)
        before = {name: self._adam.state.get(column, {}) for name, column in self.theta.columns().items()}
        self._take(found.theta)
        for name, column in self.theta.columns().items():
            if before[name]:
                self._adam.state[column] = {
                    key: self._moved(value, found.source, found.is_new) for key, value in before[name].items()
                }

    @staticmethod
    def _moved(value: Any, source: Tensor, is_new: Tensor) -> Any:
        """An optimiser's numbers for the rows that stay, 0 for new ones; its count of steps as it is."""
        if value.ndim == 0:
            return value
        rows = value[source].clone()
        rows[is_new] = 0.0
        return rows

    def state(self) -> dict[str, Tensor]:
        """All that is needed to go on, as tensors."""
        import torch

        found = {"turns": torch.tensor(self.turns), "pull": self._pull, "pulls": torch.tensor(self._pulls)}
        for name, column in self.theta.columns().items():
            found[f"theta/{name}"] = column.detach()
            if column.grad is not None:
                found[f"gradient/{name}"] = column.grad
            for key, value in self._adam.state.get(column, {}).items():
                found[f"adam/{name}/{key}"] = value
        return found

    def restore(self, state: dict[str, Tensor]) -> None:
        """Go on where ``state`` ended."""
        device = self.box.device
        self._take(Theta(**{name: state[f"theta/{name}"].to(device) for name in self.theta.columns()}))
        for name, column in self.theta.columns().items():
            if f"gradient/{name}" in state:
                column.grad = state[f"gradient/{name}"].to(device).clone()
            kept = {key.rpartition("/")[2]: state[key] for key in state if key.startswith(f"adam/{name}/")}
            if kept:
                self._adam.state[column] = {
                    key: value.clone() if value.ndim == 0 else value.to(device).clone() for key, value in kept.items()
                }
        self.turns, self._pulls = int(state["turns"]), int(state["pulls"])
        self._pull = state["pull"].to(device).clone()
