"""A run from its beginning or a break to its end: steps, a file now and then, a stop when it is asked for."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from scenelang.backends.distillation.keeping import keep
from scenelang.backends.distillation.learning import Learning, Losses
from scenelang.backends.distillation.outcome import write_preview
from scenelang.backends.files import written_whole
from scenelang.grammar.diagnostics import SceneError

LOSSES = "losses.jsonl"
_PAUSE = 30.0  # seconds between two files
_SLOWEST = 0.1  # of the time that may go into files


@dataclass(frozen=True, slots=True)
class Told:
    """Where a run stands: steps ``done`` of ``steps``, the share of it all, and the losses of the last step."""

    done: int
    steps: int
    share: float
    losses: Losses


def run(
    learning: Learning,
    folder: Path,
    asked: Mapping[str, Any],
    *,
    seconds: float = 0.0,
    budget: float | None = None,
    tell: Callable[[Told], None] = lambda _: None,
    stopped: Callable[[], bool] = lambda: False,
) -> bool:
    """Make the steps that are left and keep the run in ``folder``; True where it came to its end.

    ``seconds`` were used before; ``budget`` are all that may be. With one the annealing follows the time, so that the
    result depends on the machine. The state is written every half minute, at the end and where ``stopped`` says so:
    a kill loses no more. Raises SceneError("file").
    """
    begun = time.monotonic() - seconds
    last, cost = time.monotonic(), 0.0
    told: list[dict[str, Any]] = []
    while learning.step_number < learning.steps and not stopped():
        used = time.monotonic() - begun
        if budget is not None and used >= budget:
            break
        try:
            losses = learning.step(None if budget is None else used / budget)
        except SceneError:
            _write(learning, folder, asked, used, told)
            raise
        share = max(learning.step_number / learning.steps, 0.0 if budget is None else used / budget)
        told.append({"step": learning.step_number, **asdict(losses)})
        tell(Told(learning.step_number, learning.steps, min(share, 1.0), losses))
        if time.monotonic() - last > max(_PAUSE, cost / _SLOWEST):
            start = time.monotonic()
            _write(learning, folder, asked, start - begun, told)
            last, cost = time.monotonic(), time.monotonic() - start
    _write(learning, folder, asked, time.monotonic() - begun, told)
    return learning.step_number >= learning.steps or (budget is not None and time.monotonic() - begun >= budget)


def _write(
    learning: Learning, folder: Path, asked: Mapping[str, Any], seconds: float, told: list[dict[str, Any]]
) -> None:
    keep(folder, learning.state(), learning.cast, asked, seconds, learning.frozen)
    _add_losses(folder / LOSSES, told)
    told.clear()
    write_preview(learning, folder)


def _add_losses(path: Path, told: list[dict[str, Any]]) -> None:
    """Add lines to the record of losses; steps that a killed run made after its last file are not told twice."""
    first = told[0]["step"] if told else 0
    before = path.read_text("utf-8").splitlines() if path.exists() else []
    kept = [line for line in before if not told or json.loads(line)["step"] < first]
    with written_whole(path) as temporary:
        temporary.write_text("".join(f"{line}\n" for line in [*kept, *map(json.dumps, told)]), "utf-8")
