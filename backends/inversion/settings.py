"""What an inversion may be asked for."""

from __future__ import annotations

from dataclasses import dataclass

from scenelang.grammar.diagnostics import SceneError

_MOST_STEPS = 100_000
_LARGEST_BATCH = 256


@dataclass(frozen=True, slots=True)
class Settings:
    """``steps`` with the rate ``rate`` of AdamW, both the paper's; ``batch`` noisy copies of each picture in a step.

    ``draws`` noisy copies, the same ones every time, measure the loss before and after.
    """

    steps: int = 100
    rate: float = 1e-2
    batch: int = 4
    seed: int = 0
    draws: int = 16

    def __post_init__(self) -> None:
        """Raises SceneError("value")."""
        if not 1 <= self.steps <= _MOST_STEPS:
            raise SceneError("value", f"an inversion has 1 to {_MOST_STEPS:,} steps")
        if not 0.0 < self.rate <= 1.0:
            raise SceneError("value", "the rate is above 0, and at most 1")
        if not 1 <= self.batch <= _LARGEST_BATCH:
            raise SceneError("value", f"a step takes 1 to {_LARGEST_BATCH} noisy copies of a picture")
