"""What a user may choose of a distillation."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from scenelang.backends.distillation.sds import Guiding

BACKGROUND = 0.5  # grey, sRGB: behind previews; what the models see has another grey in each step


@dataclass(frozen=True, slots=True)
class Rates:
    """Learning rates: the Gaussians' in a figure's frame, whose box has half sizes of norm 1, and the poses'."""

    means: float = 5e-3
    opacities: float = 5e-2
    log_scales: float = 1e-2
    quaternions: float = 1e-2
    colors: float = 5e-2
    turns: float = 1e-3
    shifts: float = 2e-3
    pose_scales: float = 2e-3


@dataclass(frozen=True, slots=True)
class Weights:
    """What each term of the loss counts."""

    figure: float = 1.0
    scene: float = 1.0
    shape: float = 10.0
    layout: float = 100.0


@dataclass(frozen=True, slots=True)
class Settings:
    """``steps`` for each figure; ``most`` Gaussians of a figure at the end, at the beginning ``first`` or as many as it
    takes to grow to ``most``; ``every`` so many of its steps a figure gets more and loses some, until the share
    ``until`` of its steps is done."""

    seed: int = 0
    steps: int = 2000
    first: int = 1000
    most: int = 20_000
    every: int = 100
    until: float = 0.7
    guiding: Guiding = field(default_factory=Guiding)
    scene_guiding: Guiding = field(default_factory=lambda: Guiding(weighting="sds"))
    weights: Weights = field(default_factory=Weights)
    rates: Rates = field(default_factory=Rates)
    hull: int = 2000  # Gaussians of the surface that gives a figure's depth

    @property
    def growths(self) -> int:
        """How often the Gaussians of a figure become more, each time twice as many at most."""
        return int(self.until * self.steps + 1e-9) // self.every

    @property
    def start(self) -> int:
        """The Gaussians of a figure at the beginning."""
        return min(self.most, max(self.first, math.ceil(self.most / 2.0 ** min(self.growths, 60))))
