"""Limits and the meter: every loop that a program can drive passes through ``Meter.tick`` or ``Meter.charge``."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain, repeat
from operator import length_hint
from typing import Any, ClassVar

from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.grammar.settings import amount, setting, whole_amount

_CHUNK = 2048
_CHUNKS_PER_MEMORY_CHECK = 16
_LITTLE_MEMORY = 1_000_000_000  # bytes: a limit below is looked at four times as often
_WORTH_A_LOOK = 4_000_000  # bytes: less is found by the checks that follow
_SIZES = {"a string": 2, "an array": 40}  # bytes of an item; a list's pair and its item take more
_SIZE_OF_ITEM = 96
STEPS_OF_ERROR = 16  # what an error costs that a program catches: its message and its chain of calls are made


def _limit(default: float, help: str, flag: str) -> Any:
    read = whole_amount if type(default) is int else amount
    return setting(default, f"{help} (default {default:,})", flag, metavar="N", read=read)


@dataclass(frozen=True, slots=True)
class Limits:
    """What a run may use. ``depth``: nested calls; ``size``: items of a list, characters of a string (integers have at
    most 4,000 digits, which Python can still print); ``memory``: bytes beyond what the process had at the start;
    ``seconds``: wall time."""

    steps: int = _limit(10_000_000, "steps of evaluation", "--max-steps")
    depth: int = _limit(100_000, "nested calls", "--max-depth")
    entities: int = _limit(2_000_000, "distinct entities", "--max-entities")
    primitives: int = _limit(5_000_000, "primitives when the scene is expanded", "--max-primitives")
    size: int = _limit(10_000_000, "items of a list or array, characters of a string", "--max-size")
    memory: int = _limit(4_000_000_000, "bytes of memory (suffixes k, M, G)", "--max-memory")
    seconds: float = _limit(60.0, "wall time", "--max-seconds")
    log: int = 100_000

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not value >= 0:
                raise SceneError("value", f"`{name}`: expected a limit of at least 0, got {value!r}")


def resident_bytes() -> int:
    """Resident memory of this process in bytes (its peak where the system tells no more, 0 where it tells nothing)."""
    try:
        with open("/proc/self/statm", "rb") as statm:
            return int(statm.read().split()[1]) * 4096
    except OSError:
        return _peak_bytes()


def _peak_bytes() -> int:
    try:
        import resource
    except ImportError:  # Windows
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def time_error(seconds: float) -> LimitError:
    """E507: a run that is longer than allowed."""
    return LimitError(
        "time", f"the program ran longer than {seconds:g} seconds", hint="raise the limit with --max-seconds"
    )


def memory_error(limit: int) -> LimitError:
    """E506: a run that uses more memory than allowed."""
    return LimitError(
        "memory", f"the program used more than {limit / 1e9:g} GB of memory", hint="raise the limit with --max-memory"
    )


def show_size(size: int) -> str:
    """A size in a message; Python refuses to print integers of thousands of digits."""
    return f"{size:,}" if size.bit_length() < 200 else f"about 2^{size.bit_length()}"


class Meter:
    """Counts steps and watches time and memory. ``tick()`` counts one step at almost no cost."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self._block = repeat(None, _CHUNK)
        self._patience = _CHUNKS_PER_MEMORY_CHECK // (4 if limits.memory < _LITTLE_MEMORY else 1)
        self.renew()
        self.tick: Callable[[], Any] = chain.from_iterable(self._refill()).__next__

    def renew(self, started: float | None = None) -> None:
        """Begin to count anew, with all that the limits allow; ``tick`` goes on to work, also after an error.

        ``started`` (``time.monotonic()``) is when the seconds began, for a caller that has spent some of them."""
        self.steps = length_hint(self._block) - _CHUNK  # what was counted of the running chunk
        self.cancelled = False
        self._owed = 0
        self._chunks = 0
        self._deadline = (time.monotonic() if started is None else started) + self.limits.seconds
        self._memory = resident_bytes() + self.limits.memory

    def _refill(self) -> Iterator[Iterator[None]]:
        toll = _Toll(self)
        while True:
            self._block = repeat(None, _CHUNK)
            yield self._block
            yield toll

    @property
    def total(self) -> int:
        """The steps counted so far, those of the unfinished chunk included."""
        return self.steps + self._owed + _CHUNK - length_hint(self._block)

    def cancel(self) -> None:
        """Ask the run to stop; called from another thread."""
        self.cancelled = True

    def charge(self, work: int) -> None:
        """Count ``work`` steps at once, for a builtin that does as much.

        A builtin charges before the work, and so much that a step is no more than about 20 microseconds and a kilobyte:
        ``n >> 8`` for n items that C goes through, ``n >> 4`` for those of a loop in Python."""
        self._owed += work
        if self._owed >= _CHUNK:
            owed, self._owed = self._owed, 0
            self.spend(owed)

    def spend(self, steps: int) -> None:
        limits = self.limits
        self.steps += steps
        if self.cancelled:
            raise LimitError("interrupted", "the evaluation was interrupted")
        if self.steps > limits.steps:
            raise LimitError(
                "steps",
                f"the program ran more than {limits.steps:,} steps",
                hint="is there a loop or recursion without end? raise the limit with --max-steps",
            )
        if time.monotonic() > self._deadline:
            raise time_error(limits.seconds)
        self._chunks += 1
        if self._chunks % self._patience == 0 or steps > 100_000:
            self.check_memory()

    def check_memory(self) -> None:
        self._check_bytes(0)

    def reserve(self, size: int) -> None:
        """Refuse to allocate ``size`` bytes that would go past the limit, before they are there."""
        if size >= _WORTH_A_LOOK:
            self._check_bytes(size)

    def _check_bytes(self, more: int) -> None:
        if resident_bytes() + more > self._memory:
            raise memory_error(self.limits.memory)

    def check_growth(self, size: int, what: str) -> None:
        """Refuse ``what`` that has grown to ``size`` items; for a loop that charges what it does."""
        if size > self.limits.size:
            raise LimitError(
                "size",
                f"{what} of {show_size(size)} items is larger than the limit of {self.limits.size:,}",
                hint="raise the limit with --max-size",
            )

    def check_size(self, size: int, what: str) -> None:
        """Refuse to make ``what`` (a list, a string, an array) of ``size`` items; else charge for them."""
        self.check_growth(size, what)
        self.reserve(size * _SIZES.get(what, _SIZE_OF_ITEM))
        self.charge(size >> 3)


class _Toll:
    """Stands after each chunk of steps and pays for it. An error of an iterator leaves ``chain`` as it was, one of the
    generator that makes the iterators would end it."""

    def __init__(self, meter: Meter) -> None:
        self._meter = meter

    def __iter__(self) -> Iterator[None]:
        return self

    def __next__(self) -> None:
        self._meter.spend(_CHUNK)
        raise StopIteration


def fork_safe_lock() -> threading.Lock:
    """A lock of module-wide state that no fork may copy while it is held."""
    lock = threading.Lock()
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(before=lock.acquire, after_in_parent=lock.release, after_in_child=lock.release)
    return lock


class recursion_room:
    """Room for deep recursion while a program runs; restores what was there. Use with a thread of a large stack.

    Python's recursion limit is the process's, so the rooms that are open in several threads are counted: the limit is
    the largest one's, and the last one to close restores what the first one found."""

    _lock = fork_safe_lock()
    _open: ClassVar[list[int]] = []
    _before = 0

    def __init__(self, depth: int) -> None:
        self._frames = 5 * depth + 2_000

    def __enter__(self) -> None:
        kind = type(self)
        with kind._lock:
            if not kind._open:
                kind._before = sys.getrecursionlimit()
            kind._open.append(self._frames)
            sys.setrecursionlimit(max(kind._before, *kind._open))

    def __exit__(self, *_: object) -> None:
        kind = type(self)
        with kind._lock:
            kind._open.remove(self._frames)
            sys.setrecursionlimit(max([kind._before, *kind._open]))
