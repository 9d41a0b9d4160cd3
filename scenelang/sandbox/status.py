"""Memory page shared by a monitor and the process it supervises: phase, limits and running position."""

from __future__ import annotations

import mmap
import os
import struct
import sys
import threading
import time
from types import FrameType
from typing import Any, get_args

from scenelang.grammar import ast
from scenelang.grammar.datum import ArrayDatum, Atom, ListDatum, Source, Span, dataclass
from scenelang.grammar.diagnostics import Diagnostic, Note
from scenelang.interpreter.runtime.procedures import Closure
from scenelang.interpreter.runtime.types import STD

_STATUS_BYTES = 1 << 16  # of the memory that holds the status
_PHASE = struct.Struct("=QdddQQQQ")  # number (0: none), start, CPU start, seconds, max. bytes, limit, pid, successor
_PLACE = struct.Struct("=II")  # sequence (odd during a write), length
# Offsets in the page, in bytes: the pid of the supervised process, the call chain, the reason of a kill.
_WATCHED_AT = 64
_PLACE_AT = 72
_REASON_AT = 1 << 15
# Limits of what is recorded and read: the page is written by a process that may be broken.
_MAX_LINE_LENGTH = 2_000
_MAX_CHAIN_LENGTH = 12
_MAX_LINES = 1_000_000

Chain = tuple[tuple[str, Span | None], ...]


@dataclass(frozen=True, slots=True)
class Phase:
    """A limited phase of work.

    Attributes
    ----------
    start, cpu_start
        ``time.monotonic``, and CPU seconds of the process, at its start.
    seconds
        Limit of CPU time.
    ceiling
        Maximum resident bytes.
    memory
        The limit as given by the user, in bytes.
    pid
        Process.
    """

    number: int
    start: float
    cpu_start: float
    seconds: float
    ceiling: int
    memory: int
    pid: int


class Status:
    """The page shared by monitor and supervised process; the monitor writes the reason of a kill and ``watched``."""

    def __init__(self) -> None:
        self._page = mmap.mmap(-1, _STATUS_BYTES)  # shared with forked processes
        import json  # before a process that records its place is confined or short of memory

        self._json = json

    # --- the phase ---------------------------------------------------------------------------------------------

    def begin(self, phase: Phase) -> None:
        """Record the beginning of a phase."""
        times = (phase.start, phase.cpu_start, phase.seconds)
        values = (*times, phase.ceiling, phase.memory, phase.pid, self.successor)
        self._write_record(_PLACE_AT, None)
        _PHASE.pack_into(self._page, 0, 0, *values)
        struct.pack_into("=Q", self._page, 0, phase.number)  # written last, since the monitor may read concurrently

    def end(self) -> None:
        """Record the end of the phase."""
        struct.pack_into("=Q", self._page, 0, 0)

    @property
    def phase(self) -> Phase | None:
        """The running phase, or None."""
        number, *values, _ = _PHASE.unpack_from(self._page, 0)
        return Phase(number, *values) if number else None

    @property
    def successor(self) -> int:
        """Pid of the process that continues if this one is killed; 0 for none."""
        pid: int = _PHASE.unpack_from(self._page, 0)[-1]
        return pid

    @successor.setter
    def successor(self, pid: int) -> None:
        struct.pack_into("=Q", self._page, _PHASE.size - 8, pid)

    @property
    def watched(self) -> int:
        """Pid of the supervised process after a change; written by the monitor."""
        pid: int = struct.unpack_from("=Q", self._page, _WATCHED_AT)[0]
        return pid

    @watched.setter
    def watched(self, pid: int) -> None:
        struct.pack_into("=Q", self._page, _WATCHED_AT, pid)

    # --- position --------------------------------------------------------------------------------------------------

    def put_place(self, chain: Chain) -> None:
        """Record the running call chain, innermost first."""
        data = [(name, _place_data(span)) for name, span in chain[:_MAX_CHAIN_LENGTH]]
        self._write_record(_PLACE_AT, data)

    def place(self) -> Chain:
        """Return the last recorded call chain; empty if there is none."""
        data = self._read_record(_PLACE_AT)
        return tuple((name, _span(place)) for name, place in data or ())

    # --- reason of a kill ------------------------------------------------------------------------------------------

    def put_reason(self, problem: Diagnostic) -> None:
        """Record for the next process why this one was killed."""
        chain = [(name, _place_data(span)) for name, span in problem.chain]
        notes = [note.message for note in problem.notes]
        fields = [problem.name, problem.message, _place_data(problem.span), problem.hint, notes, chain]
        self._write_record(_REASON_AT, fields)

    def forget_reason(self) -> None:
        """Remove the reason of an earlier kill."""
        self._write_record(_REASON_AT, None)

    def reason(self) -> Diagnostic | None:
        """Return why the predecessor was killed; None if it was not."""
        data = self._read_record(_REASON_AT)
        if data is None:
            return None
        name, message, place, hint, notes, chain = data
        chain = tuple((word, _span(where)) for word, where in chain)
        return Diagnostic(name, message, _span(place), hint, tuple(Note(text) for text in notes), chain)

    # --- records -----------------------------------------------------------------------------------------------

    def _write_record(self, at: int, data: Any) -> None:
        """Write a record under a sequence lock (odd during the write), so that readers detect torn reads."""
        sequence, _ = _PLACE.unpack_from(self._page, at)
        text = b"" if data is None else self._json.dumps(data).encode()
        if len(text) > _REASON_AT - _PLACE_AT - _PLACE.size:
            text = b""
        _PLACE.pack_into(self._page, at, (sequence | 1) & 0xFFFFFFFF, 0)
        start = at + _PLACE.size
        self._page[start : start + len(text)] = text
        _PLACE.pack_into(self._page, at, ((sequence | 1) + 1) & 0xFFFFFFFF, len(text))

    def _read_record(self, at: int) -> Any:
        for _ in range(20):
            sequence, length = _PLACE.unpack_from(self._page, at)
            start = at + _PLACE.size
            text = self._page[start : start + length]
            if not sequence & 1 and _PLACE.unpack_from(self._page, at) == (sequence, length):
                return self._json.loads(text) if text else None
            time.sleep(0.001)
        return None


def _place_data(span: Span | None) -> list[Any] | None:
    """Serialize a span without the rest of the text: name, line, column, end, and the line itself."""
    if span is None:
        return None
    line, column = span.source.position(span.start)
    end_line, end_column = span.source.position(span.end)
    return [span.source.name, line, column, end_line, end_column, span.source.line(line)[: column + _MAX_LINE_LENGTH]]


def _span(data: list[Any] | None) -> Span | None:
    """Deserialize a span, with a placeholder source that contains only its line."""
    if data is None:
        return None
    name, line, column, end_line, end_column, text = data
    line, end_line = min(line, _MAX_LINES), min(end_line, _MAX_LINES)
    rest = "\n" * (end_line - line) + " " * (end_column if end_line > line else max(0, end_column - len(text)))
    source = Source(name, "\n" * (line - 1) + text + rest)
    start = line - 1 + column - 1
    end = source.line_start(end_line) + end_column - 1 if end_line > line else line - 1 + end_column - 1
    return Span(source, start, max(end, start + 1))


def resident_bytes_of(pid: int) -> int:
    """Return the resident memory of another process, or 0 if it has ended."""
    try:
        with open(f"/proc/{pid}/statm", "rb") as statm:
            return int(statm.read().split()[1]) * _PAGE
    except (OSError, IndexError, ValueError):
        return 0


def cpu_seconds_of(pid: int) -> float:
    """Return the CPU time of a process and of its children that have ended, or 0 if it has ended itself.

    The kernel counts in ticks of 10 ms, as ``os.times`` does, so that both can be compared.
    """
    try:
        with open(f"/proc/{pid}/stat", "rb") as stat:
            fields = stat.read().rpartition(b")")[2].split()  # the name before may contain anything
    except OSError:
        return 0.0
    return sum(map(int, fields[11:15])) / _TICKS  # utime, stime, cutime, cstime of proc(5)


_PAGE = os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else 4096
_TICKS = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 100


# Position of an evaluating thread in the program, read from its Python frames.


_PLACED = (ListDatum, ArrayDatum, Atom, *get_args(ast.Expr), ast.Define)
_MAX_FRAMES = 300  # Python frames that are searched for a position
_INITIAL_DELAY = 0.02  # seconds; shorter evaluations are not sampled
_POLL_INTERVAL = 0.05  # seconds


def running(thread: int) -> Chain:
    """Return the call chain of a thread that evaluates, innermost first, as in a diagnostic.

    The first link is the expression being evaluated, which has no name.
    """
    frame = sys._current_frames().get(thread)
    chain: list[tuple[str, Span | None]] = []
    text: Source | None = None
    frames = 0
    while frame is not None and frames < _MAX_FRAMES:
        place = _place(frame)
        if frame.f_code.co_name == "evaluate_root":
            chain.append((f'"{frame.f_locals.get("word")}"', None))
        elif place is not None:
            if not chain:
                chain.append(("", place))
            name = _called(frame)
            if name is not None:
                chain.append((name, place))
        elif text is None:
            source = frame.f_locals.get("source")
            text = source if isinstance(source, Source) and not source.name.startswith(STD) else None
        frame, frames = frame.f_back, frames + 1
    if not chain and text is not None:  # during parsing or checking the position is the whole text
        return (("", Span(text, 0, 0)),)
    return tuple(chain)


def _place(frame: FrameType) -> Span | None:
    """Return the span of the program that an evaluator frame is evaluating."""
    names = frame.f_locals
    span = names["use"].span if frame.f_code.co_name == "transform" and "use" in names else names.get("span")
    if not isinstance(span, Span):
        known = ("form",) if frame.f_code.co_name == "run_form" else ("datum", "node")
        span = next((names[name].span for name in known if isinstance(names.get(name), _PLACED)), None)
    if not isinstance(span, Span) or not isinstance(span.source, Source) or span.source.name.startswith(STD):
        return None
    return span


def _called(frame: FrameType) -> str | None:
    """Return the word or function that a frame is calling."""
    names = frame.f_locals
    function, word = names.get("function"), names.get("name")
    if frame.f_code.co_name == "call" and isinstance(word, str):
        return f'"{word}"'
    if frame.f_code.co_name == "transform" and isinstance(word, str):  # a macro, at the position of its use
        return f"`{word}`"
    if isinstance(function, Closure) and not function.code.name.startswith('"'):
        return f"`{function.code.name}`"
    return None


class Sampler:
    """Thread that periodically records the position of another thread.

    A builtin that holds the GIL blocks it; the last recorded position is then the call of that builtin.
    """

    def __init__(self, status: Status, thread: int) -> None:
        self._status = status
        self._thread = thread
        self._ended = threading.Event()
        threading.Thread(target=self._look, daemon=True).start()

    def stop(self) -> None:
        """End the thread."""
        self._ended.set()

    def _look(self) -> None:
        """Record positions until stopped."""
        pause = _INITIAL_DELAY
        while not self._ended.wait(pause):
            try:
                chain = running(self._thread)
            except RuntimeError:  # the frames changed concurrently
                continue
            if chain and not self._ended.is_set():
                self._status.put_place(chain)
            pause = _POLL_INTERVAL
