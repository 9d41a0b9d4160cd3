"""How much a builtin does between two checks of the meter: work, which is the same on every machine, or seconds of this
thread's processor, in which what is done in C counts too."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any, Protocol

from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.values.limits import _CHUNK_STEPS, STEPS_OF_ERROR, Limits
from scenelang.interpreter.values.values import Keyword, Procedure
from scenelang.stdlib.library import build_library


class Gauge(Protocol):
    """``read`` tells how much was done so far while it is ``running``."""

    def read(self) -> float: ...

    def running(self) -> AbstractContextManager[object]: ...


class Seconds:
    """Seconds of this thread's processor."""

    def read(self) -> float:
        return time.thread_time()

    def running(self) -> AbstractContextManager[object]:
        return nullcontext()


class Work:
    """Lines of Python that run in this thread, and calls of functions, those in C too."""

    def __init__(self) -> None:
        self._count = 0

    def read(self) -> float:
        return self._count

    def running(self) -> Work:
        return self

    def __enter__(self) -> None:
        sys.setprofile(self._call)
        sys.settrace(self._line)

    def __exit__(self, *_: object) -> None:
        sys.settrace(None)
        sys.setprofile(None)

    def _call(self, frame: Any, event: str, argument: Any) -> None:
        if event == "c_call":
            self._count += 1

    def _line(self, frame: Any, event: str, argument: Any) -> Any:
        self._count += 1
        return self._line


class WatchedRuntime(Runtime):
    """Notes the most that is done between two checks."""

    def __init__(self, limits: Limits, gauge: Gauge) -> None:
        super().__init__(build_library(), limits)
        meter = self.meter
        self.gauge = gauge
        self.most = 0.0
        self._last = 0.0
        check: Callable[[int], None] = meter.spend

        def spend(steps: int) -> None:
            self.pause()
            check(steps)

        meter.spend = spend  # type: ignore[method-assign]

    def begin(self) -> None:
        self.reset()
        self.most = 0.0
        self._last = self.gauge.read()

    def pause(self) -> None:
        now = self.gauge.read()
        self.most = max(self.most, now - self._last)
        self._last = now


@dataclass(frozen=True, slots=True)
class Measured:
    """``most``: what is done between two checks within the call. ``looped``: what is done between two checks of a loop
    that makes nothing but this call, which is a step beside what it charges; 0 where a limit ends the program."""

    most: float
    looped: float

    @property
    def worst(self) -> float:
        return max(self.most, self.looped)


def measure(rt: WatchedRuntime, function: Procedure, positional: list[Any], keywords: dict[str, Any]) -> Measured:
    """Call ``function`` once; an error of the program or of a limit ends the call like a value."""
    given = list(positional)
    for name, value in keywords.items():
        given += [Keyword(name.replace("_", "-")), value]
    with rt.gauge.running():
        rt.begin()
        before = rt.meter.total
        started = rt.gauge.read()
        ended = False
        try:
            rt.apply(function, given)
        except LimitError:
            ended = True
        except SceneError:
            rt.charge(STEPS_OF_ERROR)  # as `guard` does
        rt.pause()
        done = rt.gauge.read() - started
    steps = max(1, rt.meter.total - before)
    return Measured(rt.most, 0.0 if ended else done * _CHUNK_STEPS / steps)
