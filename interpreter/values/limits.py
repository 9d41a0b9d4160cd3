"""Resource limits of a run, enforced by a meter: every loop of a program calls ``Meter.tick`` or ``Meter.charge``."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from itertools import chain, repeat
from operator import length_hint
from typing import Any, ClassVar

from scenelang.grammar.datum import dataclass, fields
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.grammar.settings import amount, setting, whole_amount

_CHUNK_STEPS = 2048  # steps between two checks of the limits
_CHUNKS_PER_MEMORY_CHECK = 16  # reading /proc is slower than the other checks
_SMALL_MEMORY_LIMIT = 1_000_000_000  # bytes: for a smaller limit, memory is checked four times as often
_MIN_CHECKED_BYTES = 4_000_000  # smaller allocations are covered by the periodic checks
_BYTES_PER_ITEM = {"a string": 2, "an array": 40}
_BYTES_PER_LIST_ITEM = 96  # a pair and its item
_MIN_RESERVED_ITEMS = _MIN_CHECKED_BYTES // _BYTES_PER_LIST_ITEM
# Cost of catching an error: building its message takes a tenth of a millisecond, and a loop that only catches errors
# must reach the meter often enough.
STEPS_OF_ERROR = 16


def _limit(default: float, help: str, flag: str) -> Any:
    """Declare a limit as an option; its type is that of the default."""
    read = whole_amount if type(default) is int else amount
    return setting(default, f"{help} (default {default:,})", flag, metavar="N", read=read)


MAX_DEPTH = 10_000_000  # of calls, each of which takes about 500 bytes of stack


@dataclass(frozen=True, slots=True)
class Limits:
    """Resource limits of a run.

    Attributes
    ----------
    steps
        Evaluation steps.
    depth
        Nesting depth of calls. Python's recursion limit enforces it (``recursion_room``), so it is approximate: an
        exact count of calls would make the evaluator 10 % slower.
    entities
        Distinct entities.
    primitives
        Primitives of the expanded scene.
    size
        Items of a list or array, characters of a string. Integers have at most 4,000 digits, which Python can print.
    memory
        Bytes of memory in addition to those used at the start.
    seconds
        CPU time of the evaluating thread. It is a guard and not a verdict: steps, which do not depend on the machine,
        are meant to end a program first.
    log
        Characters of output.
    """

    steps: int = _limit(10_000_000, "maximum number of evaluation steps", "--max-steps")
    depth: int = _limit(100_000, "maximum nesting depth of calls", "--max-depth")
    entities: int = _limit(2_000_000, "maximum number of distinct entities", "--max-entities")
    primitives: int = _limit(5_000_000, "maximum number of primitives of the expanded scene", "--max-primitives")
    size: int = _limit(
        10_000_000, "maximum number of items of a list or array, or characters of a string", "--max-size"
    )
    memory: int = _limit(4_000_000_000, "maximum memory in bytes (suffixes k, M, G)", "--max-memory")
    seconds: float = _limit(60.0, "maximum CPU time in seconds", "--max-seconds")
    log: int = 100_000

    def __post_init__(self) -> None:
        """Refuse limits that are negative, not numbers, or deeper than a stack can be."""
        for entry in fields(self):
            name, value = entry.name, getattr(self, entry.name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not value >= 0:
                raise SceneError("value", f"`{name}`: expected a limit of at least 0, got {value!r}")
        if self.depth > MAX_DEPTH:
            raise SceneError("value", f"`depth`: expected a limit of at most {MAX_DEPTH:,}, got {self.depth:,}")


_MEMORY_PAGE_BYTES = 4096  # in which `/proc/self/statm` counts


def resident_bytes() -> int:
    """Return the resident memory of this process in bytes.

    Falls back to the peak resident memory, or 0, on systems that do not report it.
    """
    try:
        with open("/proc/self/statm", "rb") as statm:
            return int(statm.read().split()[1]) * _MEMORY_PAGE_BYTES
    except OSError:
        return _peak_bytes()


def _peak_bytes() -> int:
    """Return the peak resident memory; ``getrusage`` counts bytes on macOS and kibibytes elsewhere."""
    try:
        import resource
    except ImportError:  # Windows
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def time_error(seconds: float) -> LimitError:
    """Return the error for exceeding the limit of CPU time."""
    return LimitError(
        "time", f"limit of {seconds:g} seconds of CPU time exceeded", hint="raise the limit with --max-seconds"
    )


def wall_guard(seconds: float) -> float:
    """Return the wall-clock time, in seconds, after which an evaluation is ended that sleeps or is blocked.

    It is ten times the limit of CPU time, since the guard must not end an evaluation that is only slowed down: four
    busy processes on two cores slow it down by a factor of three. The minute allows for small limits on machines that
    swap or start cold.
    """
    return 10.0 * seconds + 60.0


def blocked_error(seconds: float, used: float) -> LimitError:
    """Return the error for exceeding the wall-clock guard of a limit of ``seconds``, with ``used`` CPU seconds."""
    return LimitError(
        "blocked",
        f"no result after {wall_guard(seconds):g} seconds, in which {used:.1f} seconds of CPU time were used: the "
        "evaluation sleeps or is blocked, or the machine is overloaded",
        hint="the guard is 10 times --max-seconds, plus 60 seconds",
    )


def memory_error(limit: int) -> LimitError:
    """Return the error for exceeding the memory limit."""
    return LimitError(
        "memory", f"memory limit of {limit / 1e9:g} GB exceeded", hint="raise the limit with --max-memory"
    )


def show_size(size: int) -> str:
    """Format a size for a message.

    Python refuses to print integers with thousands of digits, so very large sizes are shortened.
    """
    return f"{size:,}" if size.bit_length() < 200 else f"about 2^{size.bit_length()}"


class Meter:
    """Meter of a run: counts steps, and checks time and memory periodically.

    ``tick()`` counts one step at almost no cost: it advances a C iterator that calls ``spend`` once per chunk.
    """

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self._block = repeat(None, _CHUNK_STEPS)
        self._memory_interval = _CHUNKS_PER_MEMORY_CHECK // (4 if limits.memory < _SMALL_MEMORY_LIMIT else 1)
        self.reset()
        self.ticks = chain.from_iterable(self._refill())  # generated code counts a step by ``next(ticks)``
        self.tick: Callable[[], Any] = self.ticks.__next__

    def reset(self, spent: float = 0.0) -> None:
        """Reset all counters to the full limits; ``tick`` remains valid, also after an error.

        ``spent`` is the CPU time, in seconds, that the check of the program has used already.
        """
        self.steps = length_hint(self._block) - _CHUNK_STEPS  # minus the steps already used in the current chunk
        self.cancelled = False
        self._uncounted = 0
        self._chunks = 0
        self._spent = spent
        self._deadline: float | None = None
        self._memory = resident_bytes() + self.limits.memory

    def _refill(self) -> Iterator[Iterator[None]]:
        """Yield chunks of steps without end, each followed by the toll that accounts for it."""
        toll = _Toll(self)
        while True:
            self._block = repeat(None, _CHUNK_STEPS)
            yield self._block
            yield toll

    @property
    def total(self) -> int:
        """Number of steps so far, including those of the current chunk."""
        return self.steps + self._uncounted + _CHUNK_STEPS - length_hint(self._block)

    def cancel(self) -> None:
        """Request that the run stop; called from another thread."""
        self.cancelled = True

    def charge(self, work: int) -> None:
        """Count ``work`` steps at once, for a builtin that does a corresponding amount of work.

        A builtin charges before the work. One step should cover at most about 20 microseconds and 1 kB: ``n >> 8`` for
        n items processed in C, ``n >> 4`` for n iterations of a Python loop.
        """
        self._uncounted += work
        if self._uncounted >= _CHUNK_STEPS:
            counted, self._uncounted = self._uncounted, 0
            self.spend(counted)

    def spend(self, steps: int) -> None:
        """Count ``steps`` and check all limits; raise ``LimitError`` if one is exceeded."""
        limits = self.limits
        self.steps += steps
        if self.cancelled:
            raise LimitError("interrupted", "evaluation interrupted")
        if self.steps > limits.steps:
            raise LimitError(
                "steps",
                f"limit of {limits.steps:,} steps exceeded",
                hint="check for an infinite loop or recursion, or raise the limit with --max-steps",
            )
        now = time.thread_time()
        if self._deadline is None:  # set here and not in ``reset``, which another thread, with its own clock, may call
            self._deadline = now + limits.seconds - self._spent
        if now > self._deadline:
            raise time_error(limits.seconds)
        self._chunks += 1
        if self._chunks % self._memory_interval == 0 or steps > 100_000:
            self.check_memory()

    def check_memory(self) -> None:
        """Check that the process does not exceed the memory limit."""
        self._check_bytes(0)

    def reserve(self, size: int) -> None:
        """Check that allocating ``size`` bytes would not exceed the memory limit."""
        if size >= _MIN_CHECKED_BYTES:
            self._check_bytes(size)

    def _check_bytes(self, size: int) -> None:
        """Raise ``LimitError`` if ``size`` more bytes would exceed the memory limit."""
        if resident_bytes() + size > self._memory:
            raise memory_error(self.limits.memory)

    def check_growth(self, size: int, noun: str) -> None:
        """Check that a value of ``size`` items does not exceed the size limit; ``noun`` names it in the error."""
        if size > self.limits.size:
            raise LimitError(
                "size",
                f"{noun} of {show_size(size)} items exceeds the limit of {self.limits.size:,}",
                hint="raise the limit with --max-size",
            )

    def check_size(self, size: int, noun: str) -> None:
        """Check that a value may have ``size`` items, and charge for creating it.

        ``noun`` is "a list", "a string", "an array" or another name for it; it decides how much memory an item takes.
        """
        if size > self.limits.size:
            self.check_growth(size, noun)
        if size >= _MIN_RESERVED_ITEMS:
            self.reserve(size * _BYTES_PER_ITEM.get(noun, _BYTES_PER_LIST_ITEM))
        if size >= 8:
            self.charge(size >> 3)


class _Toll:
    """Empty iterator placed after each chunk of steps, which charges for the chunk.

    It must be an iterator: ``chain`` survives an error raised by one of its iterators, but not one raised by the
    generator that supplies them. So compiled code can keep its ``tick`` across evaluations, also after an error.
    """

    def __init__(self, meter: Meter) -> None:
        self._meter = meter

    def __iter__(self) -> Iterator[None]:
        return self

    def __next__(self) -> None:
        self._meter.spend(_CHUNK_STEPS)
        raise StopIteration


def fork_safe_lock() -> threading.Lock:
    """Return a lock for module-level state that is never held while the process forks."""
    lock = threading.Lock()
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(before=lock.acquire, after_in_parent=lock.release, after_in_child=lock.release)
    return lock


_FRAMES_PER_CALL = 5  # Python frames that a call of the language takes at most
_SPARE_FRAMES = 2_000  # for the code of the evaluator and of builtins at the bottom and top of the stack
# A browser's stack of 1 MB holds 400 to 600 calls that go through C, such as those of ``map``; for one of these there
# are two or more of Python's frames. All forms of recursion were tried (``tests/playground/test_page``).
_MAX_FRAMES = 900 if sys.platform == "emscripten" else 1 << 40


class recursion_room:
    """Context manager that raises Python's recursion limit while a program runs, in a thread with a large stack.

    The recursion limit is global to the process. If several threads raise it, the largest value applies, and the last
    one to exit restores the original limit.
    """

    _lock = fork_safe_lock()
    _active: ClassVar[list[int]] = []
    _original = 0

    def __init__(self, depth: int) -> None:
        self._frames = min(_FRAMES_PER_CALL * depth + _SPARE_FRAMES, _MAX_FRAMES)

    def __enter__(self) -> None:
        kind = type(self)
        with kind._lock:
            if not kind._active:
                kind._original = sys.getrecursionlimit()
            kind._active.append(self._frames)
            sys.setrecursionlimit(max(min(kind._original, _MAX_FRAMES), *kind._active))

    def __exit__(self, *_: object) -> None:
        kind = type(self)
        with kind._lock:
            kind._active.remove(self._frames)
            sys.setrecursionlimit(max([kind._original, *kind._active]))
