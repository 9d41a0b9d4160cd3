"""Work in a child process under a monitor: time, memory, Ctrl-C and a crash of the child come to one code path.

The child says when a phase with limits begins and ends (``Link``); the monitor samples its clock and resident memory,
and ends it where it goes past a limit that the evaluator's own meter should have held. Resident memory is what counts:
address space does not, since a stack for deep recursion reserves half a gigabyte and touches little of it.
"""

from __future__ import annotations

import ctypes
import gc
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any, NoReturn

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.runtime.limits import Limits, memory_error, resident_bytes, time_error
from scenelang.sandbox.confinement import confine
from scenelang.sandbox.status import Chain, Phase, Sampler, Status, resident_bytes_of

GRACE = 0.5  # seconds beyond the limit that the evaluator's own check is given
_INTERRUPT_GRACE = 1.0
_MEMORY_SLACK = 1.03
_GLANCE, _CLOSE_GLANCE, _IDLE_GLANCE = 0.005, 0.001, 0.02  # seconds between two looks
_ADOPTION = 10.0
_NOTE_EVERY = 0.002
_CLOSE = 0.6  # of the memory that is allowed
_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36
INTERRUPTED = 130
_INTERRUPT = frozenset((signal.SIGINT,))


def is_supported() -> bool:
    """Whether this system has what hard limits are made of; some containers refuse the calls."""
    if not sys.platform.startswith("linux") or resident_bytes_of(os.getpid()) == 0:
        return False
    try:
        os.close(os.pidfd_open(os.getpid()))
    except (AttributeError, OSError):
        return False
    return True


@dataclass(frozen=True, slots=True)
class Ending:
    """How a child ended: by itself, with a code, or by a signal or the monitor, for which ``problem`` is the reason."""

    code: int
    problem: Diagnostic | None = None


class Ended(SceneError):
    """A process was ended before its work was done; the diagnostic says why and where."""

    def __init__(self, problem: Diagnostic) -> None:
        super().__init__(problem.name, problem.message, problem.hint, problem.span, problem.notes, list(problem.chain))
        self.problem = problem

    def __reduce__(self) -> Any:
        return Ended, (self.problem,)


# --- the child's side --------------------------------------------------------------------------------------------


class Link:
    """What a watched process says to its monitor. ``confined`` is False where evaluation keeps all rights."""

    def __init__(self, status: Status, confined: bool = True) -> None:
        self._status = status
        self._confined = confined
        self._phases = 0
        self._depth = 0
        self._start = 0.0
        self._noted = 0.0

    @contextmanager
    def phase(self, limits: Limits) -> Iterator[float]:
        """Work that the limits hold for, and when it began; a phase within another is part of that one."""
        if self._depth:
            self._depth += 1
            try:
                yield self._start
            finally:
                self._depth -= 1
            return
        self._start = time.monotonic()
        self._phases += 1
        self._depth = 1
        self._noted = 0.0
        resident = resident_bytes()
        ceiling = resident + int(limits.memory * _MEMORY_SLACK)
        _die_with_parent(signal.SIGKILL)
        self._status.begin(Phase(self._phases, self._start, limits.seconds, ceiling, limits.memory, os.getpid()))
        try:
            yield self._start
        finally:
            self._depth = 0
            self._status.end()
            _die_with_parent(signal.SIGTERM)

    @contextmanager
    def evaluating(self, folders: tuple[str, ...]) -> Iterator[None]:
        """In the thread that evaluates: only reading is allowed from here on, and its place is noted."""
        if self._confined:
            confine(folders)
        sampler = Sampler(self._status, threading.get_ident())
        try:
            yield
        finally:
            sampler.stop()

    def note(self, span: Span | None, name: str | None = None) -> None:
        """What begins now, where the sampler may not come to look; many in a row are noted now and then."""
        now = time.monotonic()
        if span is not None and (name is not None or now - self._noted > _NOTE_EVERY):
            self._noted = now
            self._status.put_place((("", span), *(((name, None),) if name is not None else ())))

    def checkpoint(self) -> WorkCheckpoint:
        """A copy of this process that goes on from here should what follows have to be ended."""
        return WorkCheckpoint(self._status)


_LINK: list[Link] = []  # of this process: whether it is watched is a fact about it, as its id is


def link() -> Link | None:
    """The link to this process's monitor, None for one that nobody watches."""
    return _LINK[-1] if _LINK else None


@contextmanager
def limited(limits: Limits) -> Iterator[float]:
    """A phase under the monitor, if there is one; gives the time at which it began."""
    watched = link()
    if watched is None:
        yield time.monotonic()
        return
    with watched.phase(limits) as start:
        yield start


def become_child(status: Status, confined: bool = True) -> None:
    """What a process does first that was forked to be watched."""
    _die_with_parent(signal.SIGTERM)
    _LINK[:] = [Link(status, confined)]


def _die_with_parent(number: int) -> None:
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(number), 0, 0, 0)


class WorkCheckpoint:
    """A forked copy that waits. ``drop`` when the work went well; when the monitor ended the process, the copy goes on
    in its place, with ``problem`` set."""

    def __init__(self, status: Status) -> None:
        self.problem: Diagnostic | None = None
        read, write = os.pipe()
        sys.stdout.flush()
        sys.stderr.flush()
        status.forget_reason()
        replaced = os.getpid()
        self._pid = os.fork()
        if self._pid:
            os.close(read)
            self._write = write
            self._status = status
            status.successor = self._pid
            return
        os.close(write)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        finished = os.read(read, 1)
        os.close(read)
        if finished:
            os._exit(0)
        deadline = time.monotonic() + _ADOPTION
        while os.getppid() == replaced or status.watched != os.getpid():  # until the monitor knows of this process
            time.sleep(0.001)
            if time.monotonic() > deadline:  # the monitor is gone as well
                os._exit(1)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        _die_with_parent(signal.SIGTERM)
        status.successor = 0
        self.problem = status.reason() or crash(0)

    def drop(self) -> None:
        """The work is done: the copy ends."""
        if self._pid:
            self._status.successor = 0
            os.write(self._write, b".")
            os.close(self._write)
            os.waitpid(self._pid, 0)


# --- the parent's side -------------------------------------------------------------------------------------------


def supervise(work: Callable[[], int], report: Callable[[Diagnostic], None]) -> int:
    """Run ``work`` in a child and return its exit code; in the child, this returns what ``work`` does, and the caller
    ends the process with it. ``report`` shows why the child was ended."""
    status = Status()
    sys.stdout.flush()
    sys.stderr.flush()
    gc.freeze()
    ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    signal.pthread_sigmask(signal.SIG_BLOCK, _INTERRUPT)
    pid = os.fork()
    if pid == 0:
        become_child(status)
        signal.signal(signal.SIGTERM, _leave)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _INTERRUPT)
        return work()
    with _passed_on(Monitor(pid, status, listens=True)) as monitor:
        ending = monitor.wait()
    if ending.problem is not None:
        report(ending.problem)
    return ending.code


def _leave(number: int, frame: FrameType | None) -> NoReturn:
    """SIGTERM as an exception, so that temporary files go."""
    raise SystemExit(128 + number)


class Monitor:
    """Watches a child until it ends."""

    def __init__(self, pid: int, status: Status, listens: bool = False) -> None:
        self._pid = pid
        self._status = status
        self._listens = listens  # Ctrl-C is blocked in this process, and looked for
        self._interrupted: tuple[int, float] | None = None  # in which phase, and when
        self._is_unwanted: Callable[[], bool] = lambda: False

    def _interrupt(self) -> None:
        """Somebody wants the running phase to stop. The child got the signal too, and has a moment to end it itself;
        outside of phases it handles Ctrl-C as it likes."""
        phase = self._phase()
        if phase is not None and (self._interrupted is None or self._interrupted[0] != phase.number):
            self._interrupted = phase.number, time.monotonic()

    def unless(self, is_unwanted: Callable[[], bool]) -> Monitor:
        """The same monitor, which also ends the child when nobody wants its result any more."""
        self._is_unwanted = is_unwanted
        return self

    def wait(self) -> Ending:
        """How the child ended."""
        while True:
            ending = self._watch()
            if ending is not None:
                return ending

    def _listen(self) -> None:
        """Note Ctrl-C, and pass it on where the terminal has not sent it to the child as well."""
        info = signal.sigtimedwait(_INTERRUPT, 0)
        if info is not None:
            self._interrupt()
            if info.si_code <= 0:  # SI_USER and the like: somebody's kill
                _kill(self._pid, signal.SIGINT)

    def terminate(self, number: int) -> None:
        _kill(self._pid, number)

    def _watch(self) -> Ending | None:
        """Watch one process; None when its successor is to be watched."""
        handle = os.pidfd_open(self._pid)
        problem: Diagnostic | None = None
        try:
            poll = select.poll()
            poll.register(handle, select.POLLIN)
            while not poll.poll(1000 * self._pause()):
                phase = self._phase()
                problem = self._excess(phase)
                if problem is not None and not self._is_still_in(phase):
                    problem = None
                if problem is not None:
                    self._status.put_reason(problem)
                    _kill(self._pid, signal.SIGKILL)
                    break
        finally:
            os.close(handle)
        _, code = os.waitpid(self._pid, 0)
        exit_code = os.waitstatus_to_exitcode(code)
        if exit_code >= 0 and problem is None:
            return Ending(exit_code)
        return self._ended(problem, -exit_code)

    def _ended(self, problem: Diagnostic | None, number: int) -> Ending | None:
        """The child was ended by a signal: ours, or one that it could not help."""
        successor = self._status.successor
        if problem is None:
            if number in (signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE):
                if successor:
                    _kill(successor, signal.SIGKILL)
                return Ending(128 + number)
            problem = self._interruption() if number == signal.SIGINT else crash(number, self._status.place())
            self._status.put_reason(problem)
        if successor:
            self._pid, self._interrupted = successor, None
            self._status.watched = successor
            return None
        return Ending(INTERRUPTED if problem.name == "interrupted" else 1, problem)

    def _phase(self) -> Phase | None:
        """The phase that the watched process is in; not that of one that was ended before it."""
        phase = self._status.phase
        return phase if phase is not None and phase.pid == self._pid else None

    def _is_still_in(self, phase: Phase | None) -> bool:
        """Whether the child is in this phase, and stays in it: it is stopped for that, since it may end the phase, and
        with that the need to be ended, between a look and a signal."""
        if phase is None:
            return True
        _kill(self._pid, signal.SIGSTOP)
        os.waitid(os.P_PID, self._pid, os.WSTOPPED | os.WEXITED | os.WNOWAIT)
        now = self._phase()
        if now is not None and now.number == phase.number:
            return True
        _kill(self._pid, signal.SIGCONT)
        return False

    def _pause(self) -> float:
        phase = self._phase()
        if phase is None:
            return _IDLE_GLANCE
        return _CLOSE_GLANCE if resident_bytes_of(self._pid) > _CLOSE * phase.ceiling else _GLANCE

    def _excess(self, phase: Phase | None) -> Diagnostic | None:
        """The limit that the child is past in a phase, if any."""
        now = time.monotonic()
        if self._listens:
            self._listen()
        if self._is_unwanted():
            return self._interruption()
        if phase is None:
            return None
        if self._interrupted is not None and self._interrupted[0] == phase.number:
            if now > self._interrupted[1] + _INTERRUPT_GRACE:
                return self._interruption()
        if resident_bytes_of(self._pid) > phase.ceiling:
            return excess_of_memory(phase.memory, self._status.place())
        if now > phase.start + phase.seconds + GRACE:
            return excess_of_time(phase.seconds, self._status.place())
        return None

    def _interruption(self) -> Diagnostic:
        return _placed(Diagnostic("interrupted", "the evaluation was interrupted"), self._status.place())


def excess_of_time(seconds: float, chain: Chain) -> Diagnostic:
    """E507, as the evaluator's own meter reports it."""
    return _placed(time_error(seconds).diagnostic, chain)


def excess_of_memory(limit: int, chain: Chain) -> Diagnostic:
    """E506, as the evaluator's own meter reports it."""
    return _placed(memory_error(limit).diagnostic, chain)


def crash(number: int, chain: Chain = ()) -> Diagnostic:
    """The process that did the work ended without a word."""
    try:
        how = f"ended by {signal.Signals(number).name}" if number else "ended early"
    except ValueError:
        how = f"ended by signal {number}"
    hint = "a native library failed; please report it, with the program"
    if number == signal.SIGKILL:
        hint = "another program ended it, or the system ran out of memory; lower --max-memory"
    return _placed(Diagnostic("crash", f"the process that worked on the program was {how}", None, hint), chain)


def _placed(problem: Diagnostic, chain: Chain) -> Diagnostic:
    """A problem at the place that was running."""
    if not chain:
        return problem
    return Diagnostic(problem.name, problem.message, chain[0][1], problem.hint, problem.notes, chain[1:])


def _kill(pid: int, number: int) -> None:
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass


@contextmanager
def _passed_on(monitor: Monitor) -> Iterator[Monitor]:
    """Requests to end that reach this process are meant for the child. Ctrl-C is blocked; the monitor looks for it."""

    def end(number: int, _: FrameType | None) -> None:
        monitor.terminate(number)

    numbers = (signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.signal(number, end) for number in numbers}
    try:
        yield monitor
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # one that comes now is too late
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _INTERRUPT)


# Ctrl-C in work that is made of steps.


@contextmanager
def interruptions() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C was pressed: from the first time that this is asked on, the step that is being made ends first.
    Pressed again it interrupts at once."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    pressed = threading.Event()
    before = signal.getsignal(signal.SIGINT)

    def note(*_: object) -> None:
        if pressed.is_set():
            raise KeyboardInterrupt
        pressed.set()

    def stopped() -> bool:
        if signal.getsignal(signal.SIGINT) is not note:  # what comes before the first step needs no care
            signal.signal(signal.SIGINT, note)
        return pressed.is_set()

    try:
        yield stopped
    finally:
        signal.signal(signal.SIGINT, before)
