"""Run work in a child process under a monitor, which enforces limits of time and memory and handles Ctrl-C and crashes.

The child reports the start and the end of each limited phase (``Link``). The monitor samples its CPU time and resident
memory, and kills it if it exceeds a limit that the evaluator's own meter failed to enforce, such as inside a builtin.
Wall-clock time ends only a child that makes no progress (``wall_guard``), so that a busy machine changes no verdict.
Resident memory is measured, not address space: the stack for deep recursion reserves half a gigabyte and touches
little.
"""

from __future__ import annotations

import gc
import os
import re
import select
import signal
import stat
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from types import FrameType
from typing import Any, NoReturn

from scenelang.grammar.datum import Span, dataclass
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.runtime.types import STD
from scenelang.interpreter.values.limits import (
    Limits,
    blocked_error,
    memory_error,
    resident_bytes,
    time_error,
    wall_guard,
)
from scenelang.sandbox.environment import hidden_variables
from scenelang.sandbox.status import Chain, Phase, Sampler, Status, cpu_seconds_of, resident_bytes_of

GRACE = 0.5  # CPU seconds beyond the limit, to let the evaluator's own check report first
_INTERRUPT_GRACE = 1.0  # seconds after Ctrl-C until a process is killed
_MEMORY_SLACK = 1.03  # times the limit, to let the evaluator's own check report first
_POLL_INTERVAL, _FAST_POLL_INTERVAL, _IDLE_POLL_INTERVAL = 0.005, 0.001, 0.02  # sampling intervals, in seconds
_ADOPTION_SECONDS = 10.0  # within which the monitor must supervise the successor of a killed process
_NOTE_INTERVAL = 0.002  # seconds
_HIGH_MEMORY = 0.6  # fraction of the memory limit from which sampling is faster
_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36
INTERRUPTED, CLOSED = 130, 141  # exit codes, as of a process that SIGINT or SIGPIPE ends
_INTERRUPT = frozenset((signal.SIGINT,))


def is_supported() -> bool:
    """Return whether the system supports hard limits; some containers forbid the required system calls."""
    if not sys.platform.startswith("linux") or resident_bytes_of(os.getpid()) == 0:
        return False
    try:
        os.close(os.pidfd_open(os.getpid()))
    except (AttributeError, OSError):
        return False
    return True


@dataclass(frozen=True, slots=True)
class Ending:
    """How a child ended.

    Attributes
    ----------
    code
        Exit code.
    problem
        Diagnostic, if it was killed by a signal or the monitor.
    is_answered
        Whether it has not ended, but written an answer.
    """

    code: int
    problem: Diagnostic | None = None
    is_answered: bool = False


class Ended(SceneError):
    """Raised if a process was killed before its work was done; the diagnostic contains reason and position."""

    def __init__(self, problem: Diagnostic) -> None:
        super().__init__(problem.name, problem.message, problem.hint, problem.span, problem.notes, list(problem.chain))
        self.problem = problem

    def __reduce__(self) -> Any:
        return Ended, (self.problem,)


# --- child process -----------------------------------------------------------------------------------------------


class Link:
    """A supervised process's connection to its monitor. ``confined`` is False if evaluation keeps all access rights."""

    def __init__(self, status: Status, confined: bool = True) -> None:
        self._status = status
        self._confined = confined
        self._phases = 0
        self._depth = 0
        self._cpu_start = 0.0
        self._noted = 0.0

    @contextmanager
    def phase(self, limits: Limits) -> Iterator[None]:
        """Start a limited phase; nested phases are part of the outer one."""
        if self._depth:
            self._depth += 1
            try:
                yield
            finally:
                self._depth -= 1
            return
        self._cpu_start = _own_cpu_seconds()
        self._phases += 1
        self._depth = 1
        self._noted = 0.0
        resident = resident_bytes()
        ceiling = resident + int(limits.memory * _MEMORY_SLACK)
        _die_with_parent(signal.SIGKILL)
        times = (time.monotonic(), self._cpu_start, limits.seconds)
        self._status.begin(Phase(self._phases, *times, ceiling, limits.memory, os.getpid()))
        try:
            yield
        finally:
            self._depth = 0
            self._status.end()
            _die_with_parent(signal.SIGTERM)

    @property
    def may_fork(self) -> bool:
        """Whether only evaluating threads are confined; otherwise the process is, and is killed with its request."""
        return self._confined

    @property
    def spent(self) -> float:
        """CPU seconds of the running phase so far; 0 outside of phases."""
        return _own_cpu_seconds() - self._cpu_start if self._depth else 0.0

    @contextmanager
    def evaluating(self, folders: tuple[str, ...]) -> Iterator[None]:
        """Confine the evaluating thread to reading ``folders``, and sample its position."""
        with hidden_variables():
            if self._confined:
                from scenelang.sandbox.confinement import confine

                confine(folders)
            sampler = Sampler(self._status, threading.get_ident())
            try:
                yield
            finally:
                sampler.stop()

    def note(self, span: Span | None, name: str | None = None) -> None:
        """Record the position that starts now, for phases without a sampler; rapid sequences are thinned out."""
        now = time.monotonic()
        if span is not None and (name is not None or now - self._noted > _NOTE_INTERVAL):
            self._noted = now
            self._status.put_place((("", span), *(((name, None),) if name is not None else ())))

    def at(self, span: Span) -> None:
        """Record the position of a step that may take long."""
        self._status.put_place((("", span),))

    def checkpoint(self) -> WorkCheckpoint:
        """Fork a checkpoint of this process, which continues if the process is killed."""
        return WorkCheckpoint(self._status)


_LINK: list[Link] = []  # process-wide, like the process id


def link() -> Link | None:
    """Return the link to this process's monitor, or None if it is not supervised."""
    return _LINK[-1] if _LINK else None


def noting() -> Callable[[Span], None] | None:
    """Return the function that reports a position in the text to the monitor, or None without a monitor."""
    watched = link()
    return None if watched is None else watched.at


@contextmanager
def limited(limits: Limits) -> Iterator[None]:
    """Run a phase under the monitor, if there is one."""
    watched = link()
    with watched.phase(limits) if watched is not None else nullcontext():
        yield


def spent_seconds() -> float:
    """Return the CPU seconds that the running phase has used.

    It is 0 in a process without a monitor, whose other threads may use the CPU too.
    """
    watched = link()
    return watched.spent if watched is not None else 0.0


def _own_cpu_seconds() -> float:
    return sum(os.times()[:4])  # with ended children, as in `cpu_seconds_of`


def become_child(status: Status, confined: bool = True) -> None:
    """Initialize a supervised process after the fork."""
    _die_with_parent(signal.SIGTERM)
    _LINK[:] = [Link(status, confined)]


def _die_with_parent(number: int) -> None:
    """Have the kernel send a signal to this process when its parent ends."""
    import ctypes

    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(number), 0, 0, 0)


class WorkCheckpoint:
    """A suspended fork of the process.

    ``drop`` it when the work succeeded. If the monitor killed the process, the fork continues in its place, with
    ``problem`` set.
    """

    def __init__(self, status: Status) -> None:
        """Fork; in the fork, wait until the work has succeeded, or this process was killed."""
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
        deadline = time.monotonic() + _ADOPTION_SECONDS
        while os.getppid() == replaced or status.watched != os.getpid():  # until supervised
            time.sleep(0.001)
            if time.monotonic() > deadline:  # the monitor has ended, too
                os._exit(1)
        signal.signal(signal.SIGINT, after_imports(signal.default_int_handler))
        _die_with_parent(signal.SIGTERM)
        status.successor = 0
        self.problem = status.reason() or crash(0)

    def drop(self) -> None:
        """End the fork after the work succeeded."""
        if self._pid:
            self._status.successor = 0
            os.write(self._write, b".")
            os.close(self._write)
            os.waitpid(self._pid, 0)


# --- parent process ----------------------------------------------------------------------------------------------


def supervise(work: Callable[[], int], report: Callable[[Diagnostic], None]) -> int:
    """Run ``work`` in a child and return its exit code.

    In the child this returns the result of ``work``, with which the caller must exit. ``report`` displays why the child
    was killed.
    """
    status = Status()
    sys.stdout.flush()
    sys.stderr.flush()
    gc.freeze()
    import ctypes

    ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    signal.pthread_sigmask(signal.SIG_BLOCK, _INTERRUPT)
    pid = os.fork()
    if pid == 0:
        become_child(status)
        signal.signal(signal.SIGTERM, after_imports(_leave))
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _INTERRUPT)
        return work()
    with _passed_on(Monitor(pid, status, listens=True)) as monitor:
        ending = monitor.wait()
    if ending.problem is not None:
        report(ending.problem)
    return ending.code


def _leave(number: int, frame: FrameType | None) -> NoReturn:
    """Convert SIGTERM to an exception, so that temporary files are removed."""
    raise SystemExit(128 + number)


def after_imports(handle: Callable[[int, FrameType | None], object]) -> Callable[[int, FrameType | None], object]:
    """Return a signal handler that is called once no module is being imported.

    An exception in the middle of an import leaves half a module, which raises other errors later, or is swallowed by a
    library's own code: NumPy and MuJoCo report a bad installation then.
    """

    def wait(number: int, frame: FrameType | None) -> object:
        """Call the handler, or send the signal again later."""
        if not _is_importing(frame):
            return handle(number, frame)
        again = threading.Timer(0.02, os.kill, (os.getpid(), number))
        again.daemon = True
        again.start()
        return None

    return wait


def _is_importing(frame: FrameType | None) -> bool:
    """Return whether a frame is in an import."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


class Monitor:
    """Monitors a child until it ends."""

    def __init__(self, pid: int, status: Status, listens: bool = False) -> None:
        self._pid = pid
        self._status = status
        self._listens = listens  # SIGINT is blocked in this process and polled
        self._interrupted: tuple[int, float] | None = None  # phase and time of the interruption
        self._is_unwanted: Callable[[], bool] = lambda: False
        self._answer = -1

    def _interrupt(self) -> None:
        """Request the end of the running phase.

        The child received the signal, too, and gets a moment to end the phase itself; outside of phases it handles
        Ctrl-C on its own.
        """
        phase = self._phase()
        if phase is not None and (self._interrupted is None or self._interrupted[0] != phase.number):
            self._interrupted = phase.number, time.monotonic()

    def unless(self, is_unwanted: Callable[[], bool]) -> Monitor:
        """Return a monitor that also kills the child when its result is no longer needed."""
        self._is_unwanted = is_unwanted
        return self

    def until(self, answer: int) -> Monitor:
        """Return a monitor that also ends when there is something to read from a file descriptor."""
        self._answer = answer
        return self

    def wait(self) -> Ending:
        """Monitor the child until it ends, and return how it ended."""
        while True:
            ending = self._watch()
            if ending is not None:
                return ending

    def _listen(self) -> None:
        """Record a pending Ctrl-C, and forward it if the terminal has not sent it to the child."""
        info = signal.sigtimedwait(_INTERRUPT, 0)
        if info is not None:
            self._interrupt()
            if info.si_code <= 0:  # SI_USER and similar: sent by kill
                _kill(self._pid, signal.SIGINT)

    def terminate(self, number: int) -> None:
        """Send a signal to the process."""
        _kill(self._pid, number)

    def _watch(self) -> Ending | None:
        """Monitor one process; returns None when its successor is to be monitored."""
        handle = os.pidfd_open(self._pid)
        problem: Diagnostic | None = None
        try:
            poll = select.poll()
            poll.register(handle, select.POLLIN)
            if self._answer >= 0:
                poll.register(self._answer, select.POLLIN)
            while not (ready := poll.poll(1000 * self._pause())):
                phase = self._phase()
                problem = self._excess(phase)
                if problem is not None and not self._is_still_in(phase):
                    problem = None
                if problem is not None:
                    self._status.put_reason(problem)
                    _kill(self._pid, signal.SIGKILL)
                    break
            if any(number == self._answer and event & select.POLLIN for number, event in ready):
                return Ending(0, is_answered=True)
        finally:
            os.close(handle)
        _, code = os.waitpid(self._pid, 0)
        exit_code = os.waitstatus_to_exitcode(code)
        if exit_code >= 0 and problem is None:
            return Ending(exit_code)
        return self._ended(problem, -exit_code)

    def _ended(self, problem: Diagnostic | None, number: int) -> Ending | None:
        """Return the reason for a child killed by a signal, ours or another one."""
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
        """Return the current phase of the supervised process, ignoring that of a killed predecessor."""
        phase = self._status.phase
        return phase if phase is not None and phase.pid == self._pid else None

    def _is_still_in(self, phase: Phase | None) -> bool:
        """Stop the child and return whether it is still in this phase.

        Without the stop, the phase might end between the check and the kill.
        """
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
            return _IDLE_POLL_INTERVAL
        return _FAST_POLL_INTERVAL if resident_bytes_of(self._pid) > _HIGH_MEMORY * phase.ceiling else _POLL_INTERVAL

    def _excess(self, phase: Phase | None) -> Diagnostic | None:
        """Return the diagnostic of the limit that the child exceeds in a phase, or None."""
        if self._listens:
            self._listen()
        if self._is_unwanted():
            return self._interruption()
        if phase is None:
            return None
        if self._interrupted is not None and self._interrupted[0] == phase.number:
            if time.monotonic() > self._interrupted[1] + _INTERRUPT_GRACE:
                return self._interruption()
        if resident_bytes_of(self._pid) > phase.ceiling:
            return excess_of_memory(phase.memory, self._status.place())
        used = cpu_seconds_of(self._pid) - phase.cpu_start
        if used > phase.seconds + GRACE:
            return excess_of_time(phase.seconds, self._status.place())
        if time.monotonic() > phase.start + wall_guard(phase.seconds):
            return _placed(blocked_error(phase.seconds, used).diagnostic, self._status.place())
        return None

    def _interruption(self) -> Diagnostic:
        return _placed(Diagnostic("interrupted", "the evaluation was interrupted"), self._status.place())


def excess_of_time(seconds: float, chain: Chain) -> Diagnostic:
    """Return E507, as the evaluator's own meter reports it."""
    return _placed(time_error(seconds).diagnostic, chain)


def excess_of_memory(limit: int, chain: Chain) -> Diagnostic:
    """Return E506, as the evaluator's own meter reports it."""
    return _placed(memory_error(limit).diagnostic, chain)


def crash(number: int, chain: Chain = ()) -> Diagnostic:
    """Return the diagnostic of a process that crashed.

    ``number`` is the signal that killed it, 0 if it exited; ``chain`` the calls that it was evaluating, if they are
    known.
    """
    try:
        how = f"killed by {signal.Signals(number).name}" if number else "ended unexpectedly"
    except ValueError:
        how = f"killed by signal {number}"
    hint = "a native library crashed; please report it with the program"
    if number == signal.SIGKILL:
        hint = "another process killed it, or the system ran out of memory; set a lower --max-memory"
    return _placed(Diagnostic("crash", f"the process that evaluated the program was {how}", None, hint), chain)


def _placed(problem: Diagnostic, chain: Chain) -> Diagnostic:
    """Return ``problem`` at the innermost call of ``chain``, with the outer ones as its call stack."""
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
    """Forward termination signals to the child. SIGINT is blocked; the monitor polls for it."""

    def end(number: int, _: FrameType | None) -> None:
        """Forward a signal."""
        monitor.terminate(number)

    numbers = (signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.signal(number, end) for number in numbers}
    try:
        yield monitor
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # ignore late interruptions
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _INTERRUPT)


# Programs whose check runs no code of theirs, and does not need a monitor.


_MAX_BOUNDED_LENGTH = 40_000  # characters, with imports
# Texts and comments, and what may hide where they end: bars, datum comments and characters.
_TEXTS = lazy_pattern(r'"(?:[^"\\]|\\.)*"|#;|#\\|;[^\n]*|\|', re.S)
_HIDING = ("#;", "#\\", "|")
_IMPORT = lazy_pattern(r'\(\s*import\s+"([^"\\]*)"')


def is_bounded(paths: Sequence[str]) -> bool:
    """Return whether a check of programs takes bounded time and memory.

    It does if they are small and, like the files that they import, without procedural macros.
    """
    left, pending, visited = _MAX_BOUNDED_LENGTH, list(paths), set()
    while pending:
        path = pending.pop()
        text = _program_text(path, left) if path not in visited else ""
        if text is None or any(match[0] in _HIDING for match in _TEXTS.finditer(text)):
            return False
        code = _TEXTS.sub(lambda match: "" if match[0].startswith(";") else match[0], text)
        names = _IMPORT.findall(code)
        if "define-macro" in code or code.count("import") != len(names):
            return False
        left -= len(text)
        visited.add(path)
        pending += [os.path.join(os.path.dirname(path), name) for name in names if not name.startswith(STD)]
    return True


@contextmanager
def alarmed(seconds: float, report: Callable[[Diagnostic], None]) -> Iterator[None]:
    """End the process after some seconds of CPU time, at the wall-clock guard, or at Ctrl-C, without a monitor.

    A thread that works cannot be stopped, so the process ends.
    """

    def end(number: int, _: FrameType | None) -> None:
        """Report the limit or the interruption, and exit."""
        if number == signal.SIGPROF:
            report(excess_of_time(seconds, ()))
        elif number == signal.SIGALRM:
            report(blocked_error(seconds, time.process_time()).diagnostic)
        else:
            print("interrupted", file=sys.stderr)
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(INTERRUPTED if number == signal.SIGINT else 1)

    before = {number: signal.signal(number, end) for number in (signal.SIGPROF, signal.SIGALRM, signal.SIGINT)}
    timers = {signal.ITIMER_PROF: seconds + GRACE, signal.ITIMER_REAL: wall_guard(seconds)}
    for timer, value in timers.items():
        signal.setitimer(timer, value)
    try:
        yield
    finally:
        for timer in timers:
            signal.setitimer(timer, 0)
        for number, handler in before.items():
            signal.signal(number, handler)


def _program_text(path: str, most: int) -> str | None:
    """Return the text of a program of at most ``most`` bytes; None for anything else."""
    try:
        status = os.stat(path)
        if not path.endswith(".scene") or not stat.S_ISREG(status.st_mode) or status.st_size > most:
            return None
        with open(path, encoding="utf-8") as file:
            return file.read(most)
    except (OSError, ValueError):
        return None


# Ctrl-C.


def was_interrupted(error: BaseException) -> bool:
    """Return whether Ctrl-C caused an error: native libraries wrap the interruption in their own exceptions."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, KeyboardInterrupt) or "KeyboardInterrupt" in str(cause):
            return True
        cause = cause.__cause__ or cause.__context__
    return False


@contextmanager
def interruptions() -> Iterator[Callable[[], bool]]:
    """Yield a function that returns whether Ctrl-C was pressed, to stop after the current step.

    A second Ctrl-C interrupts immediately.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    pressed = threading.Event()
    before = signal.getsignal(signal.SIGINT)

    def note(*_: object) -> None:
        """Record the first Ctrl-C."""
        if pressed.is_set():
            raise KeyboardInterrupt
        pressed.set()

    def stopped() -> bool:
        """Return whether Ctrl-C was pressed."""
        if signal.getsignal(signal.SIGINT) is not note:  # before the first step Ctrl-C may interrupt directly
            signal.signal(signal.SIGINT, note)
        return pressed.is_set()

    try:
        yield stopped
    finally:
        signal.signal(signal.SIGINT, before)
