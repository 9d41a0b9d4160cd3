"""How long a builtin runs between two checks of the meter, in seconds of this thread's processor."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.runtime.limits import _CHUNK_STEPS, STEPS_OF_ERROR, Limits
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.values import Keyword, Procedure
from scenelang.stdlib.library import build_library


class WatchedRuntime(Runtime):
    """Notes the longest time between two checks."""

    def __init__(self, limits: Limits) -> None:
        super().__init__(build_library(), limits)
        meter = self.meter
        self.longest = 0.0
        self._last = time.thread_time()
        check: Callable[[int], None] = meter.spend

        def spend(steps: int) -> None:
            self.pause()
            check(steps)

        meter.spend = spend  # type: ignore[method-assign]

    def begin(self) -> None:
        self.reset()
        self.longest = 0.0
        self._last = time.thread_time()

    def pause(self) -> None:
        now = time.thread_time()
        self.longest = max(self.longest, now - self._last)
        self._last = now


@dataclass(frozen=True, slots=True)
class Measured:
    """``longest``: seconds between two checks within the call. ``looped``: seconds between two checks of a loop that
    makes nothing but this call, which is a step beside what it charges; 0 where a limit ends the program."""

    longest: float
    looped: float

    @property
    def worst(self) -> float:
        return max(self.longest, self.looped)


def measure(rt: WatchedRuntime, function: Procedure, positional: list[Any], keywords: dict[str, Any]) -> Measured:
    """Call ``function`` once; an error of the program or of a limit ends the call like a value."""
    given = list(positional)
    for name, value in keywords.items():
        given += [Keyword(name.replace("_", "-")), value]
    rt.begin()
    before = rt.meter.total
    started = time.thread_time()
    ended = False
    try:
        rt.apply(function, given)
    except LimitError:
        ended = True
    except SceneError:
        rt.charge(STEPS_OF_ERROR)  # as `guard` does
    rt.pause()
    seconds = time.thread_time() - started
    steps = max(1, rt.meter.total - before)
    return Measured(rt.longest, 0.0 if ended else seconds * _CHUNK_STEPS / steps)
