"""An inversion from its beginning or a break to its end: steps, a file now and then, a stop when it is asked for."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenelang.backends.inversion.keeping import Kept, keep, restore
from scenelang.backends.inversion.learning import Inverting

_PAUSE = 10.0  # seconds between two files


@dataclass(frozen=True, slots=True)
class Told:
    """Where a run stands: steps ``done`` of ``steps``, and the loss of the last."""

    done: int
    steps: int
    loss: float


@dataclass(frozen=True, slots=True)
class Outcome:
    """The loss measured before the first step and now, and whether all steps are made."""

    before: float
    after: float
    finished: bool


def run(
    learning: Inverting,
    folder: Path,
    asked: Mapping[str, Any],
    kept: Kept | None = None,
    tell: Callable[[Told], None] = lambda _: None,
    stopped: Callable[[], bool] = lambda: False,
) -> Outcome:
    """Make the steps that are left, from ``kept`` on where that is given, and keep the run in ``folder``.

    The file is written every ten seconds, at the end and where ``stopped`` says so: a kill loses no more. Raises
    SceneError as ``keeping.restore`` does, and "file".
    """
    if kept is not None:
        restore(learning, kept, asked, folder)
    first = learning.measured() if kept is None else kept.first
    losses = [] if kept is None else list(kept.losses)
    last = time.monotonic()
    while learning.done < learning.steps and not stopped():
        losses.append(learning.step())
        tell(Told(learning.done, learning.steps, losses[-1]))
        if time.monotonic() - last > _PAUSE:
            keep(folder, learning, asked, losses, first)
            last = time.monotonic()
    keep(folder, learning, asked, losses, first)
    finished = learning.done >= learning.steps
    return Outcome(first, learning.measured() if finished else losses[-1] if losses else first, finished)
