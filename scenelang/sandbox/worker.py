"""Worker processes for servers: each request runs in a separate process, so that killing it affects only that request.

A worker forks a zygote before its server starts threads; the zygote forks a child for every request, with all modules
loaded and no locks of the server's threads held. Only data pickled by our own code on both sides is exchanged; entity
trees stay in the child.
"""

from __future__ import annotations

import contextlib
import gc
import io
import mmap
import os
import pickle
import signal
import socket
import struct
import sys
import threading
from collections.abc import Callable
from typing import Any, NoReturn

from scenelang.grammar.diagnostics import Diagnostic
from scenelang.sandbox.confinement import confine
from scenelang.sandbox.environment import keep_named_variables
from scenelang.sandbox.status import Status
from scenelang.sandbox.supervision import Ended, Monitor, become_child, crash, is_supported, link

_HEADER = struct.Struct("=Q")
_MAX_ANSWER_BYTES = 1 << 32  # a header that states more is garbage: the process is treated as ended


class Worker:
    """Calls a function in a new process per request.

    Create it before starting other threads. ``ask`` may be called from several threads; requests run sequentially.
    Arguments, values and exceptions are pickled.

    Parameters
    ----------
    function
        Called with the arguments of each request.
    folders
        Folders that these processes may read; None removes only the rights that evaluation itself gives up.
    keeps
        The process of a request stays and answers all further requests with the same first argument, so that
        ``function`` can keep what it computed. If such a process exceeds its memory, a new one tries again.
    """

    def __init__(
        self, function: Callable[..., Any], folders: tuple[str, ...] | None = None, keeps: bool = False
    ) -> None:
        """Fork the zygote; without support for hard limits, requests run in this process."""
        self._function = function
        self._folders = folders
        self._keeps = keeps
        self._lock = threading.Lock()
        self._pid = 0
        self._socket: socket.socket | None = None
        self._number = 0  # number of the last request
        self._running = 0  # number of the running request, 0 for none
        self._cancelled = mmap.mmap(-1, _HEADER.size)  # number of the request to cancel, shared with the zygote
        if is_supported():
            self._start()

    def ask(self, *arguments: Any) -> Any:
        """Call the worker's function in a process of its own, and wait for the result.

        Parameters
        ----------
        arguments
            Arguments of the function. With ``keeps``, the text of the first one selects the process.

        Returns
        -------
        Any
            What the function returned.

        Raises
        ------
        Ended
            If the process exceeded a limit or crashed. An exception of the function is raised as it is.
        """
        if self._socket is None:  # no support for hard limits
            return self._function(*arguments)
        with self._lock:
            self._number += 1
            self._running = self._number
            try:
                key = str(arguments[0]).encode() if self._keeps and arguments else b""
                answer = self._exchange(_HEADER.pack(len(key)) + key + pickle.dumps(arguments))
            finally:
                self._running = 0
        kind, value = pickle.loads(answer)  # written by our own code  # noqa: S301  # nosec B301
        if kind == "value":
            return value
        if kind == "ended":
            raise Ended(value)
        raise value

    def interrupt(self) -> None:
        """Cancel the running request, if any, as Ctrl-C would."""
        self._cancelled[:] = _HEADER.pack(self._running)

    def close(self) -> None:
        """Stop the zygote and its running request."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
            os.waitpid(self._pid, 0)
            self._pid = 0

    def _exchange(self, request: bytes) -> bytes:
        """Send a request to the zygote and return the answer; if the zygote was killed, start another."""
        assert self._socket is not None
        try:
            _send(self._socket, _HEADER.pack(self._number) + request)
            return _receive(self._socket)
        except (OSError, EOFError):  # the zygote was killed; the next request starts another
            self.close()
            self._start()
            return pickle.dumps(("ended", crash(0)))

    def _start(self) -> None:
        """Fork the zygote; in it, serve and exit."""
        ours, theirs = socket.socketpair()
        sys.stdout.flush()
        sys.stderr.flush()
        parent = os.getpid()
        self._pid = os.fork()
        if self._pid:
            theirs.close()
            self._socket = ours
            return
        ours.close()
        keep_named_variables()
        zygote = _Zygote(self._function, self._folders, parent, self._cancelled)
        _quietly(lambda: zygote.serve(theirs))


def _quietly(work: Callable[[], None]) -> NoReturn:
    """Run a forked process to its end, without returning to the code of the parent."""
    code = 1
    try:
        work()
        code = 0
    finally:
        os._exit(code)


# --- zygote --------------------------------------------------------------------------------------------------------


_MAX_RESIDENT = 4  # processes, each with the caches of one program


class _ResidentProcess:
    """Process that answers one request after another."""

    def __init__(self, function: Callable[..., Any], folders: tuple[str, ...] | None) -> None:
        """Fork the process; in it, serve and exit."""
        self.status = Status()
        self.requests = 0
        ours, theirs = socket.socketpair()
        self.pid = os.fork()
        if self.pid == 0:
            ours.close()
            _quietly(lambda: self._serve(theirs, function, folders))
        theirs.close()
        self.channel = ours

    def _serve(self, channel: socket.socket, function: Callable[..., Any], folders: tuple[str, ...] | None) -> None:
        """Answer requests until the channel is closed."""
        _begin(self.status, folders)
        while True:
            try:
                request = _receive(channel)
            except EOFError:
                return
            _send(channel, _pickled(_result(function, request)))

    def ask(self, request: bytes, is_unwanted: Callable[[], bool]) -> bytes | Diagnostic:
        """Return the pickled answer, or why the process was killed."""
        self.requests += 1
        try:
            _send(self.channel, request)
            ending = Monitor(self.pid, self.status).unless(is_unwanted).until(self.channel.fileno()).wait()
            if ending.problem is None and ending.is_answered:
                return _receive(self.channel)
        except (OSError, EOFError):
            return crash(0)
        return ending.problem or crash(0)

    def close(self) -> None:
        """Kill the process."""
        self.channel.close()
        with contextlib.suppress(ProcessLookupError, ChildProcessError):  # the monitor has waited for a killed process
            os.kill(self.pid, signal.SIGKILL)
            os.waitpid(self.pid, 0)


class _Zygote:
    """Forks a child for every request, or for every key, until the server ends."""

    def __init__(
        self, function: Callable[..., Any], folders: tuple[str, ...] | None, parent: int, cancelled: mmap.mmap
    ) -> None:
        self._function, self._folders, self._parent, self._cancelled = function, folders, parent, cancelled
        self._resident: dict[bytes, _ResidentProcess] = {}

    def serve(self, channel: socket.socket) -> None:
        """Answer requests until the server ends."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        gc.collect()
        gc.freeze()  # keeps memory pages shared with the children
        while os.getppid() == self._parent:
            try:
                data = _receive(channel)
            except EOFError:
                return
            number, data = data[: _HEADER.size], data[_HEADER.size :]
            (length,) = _HEADER.unpack(data[: _HEADER.size])
            key, request = data[_HEADER.size : _HEADER.size + length], data[_HEADER.size + length :]
            is_unwanted = self._is_unwanted(number)
            if key:
                _send(channel, self._answer_by_resident(key, request, is_unwanted))
            else:
                _send(channel, _answer(self._function, request, self._folders, is_unwanted))

    def _is_unwanted(self, number: bytes) -> Callable[[], bool]:
        """Return a function that returns whether a request was cancelled, or the server has ended."""
        return lambda: self._cancelled[:] == number or os.getppid() != self._parent

    def _answer_by_resident(self, key: bytes, request: bytes, is_unwanted: Callable[[], bool]) -> bytes:
        """Answer a request by the process of its key; try a new one if an old one ran out of memory or crashed."""
        for attempt in range(2):
            process = self._resident.pop(key, None) or _ResidentProcess(self._function, self._folders)
            is_first = process.requests == 0
            answer = process.ask(request, is_unwanted)
            if isinstance(answer, bytes):
                self._resident[key] = process
                if len(self._resident) > _MAX_RESIDENT:
                    self._resident.pop(next(iter(self._resident))).close()
                return answer
            process.close()
            if is_first or attempt or answer.name not in ("memory", "crash"):
                return pickle.dumps(("ended", answer))
        raise AssertionError


def _answer(
    function: Callable[..., Any], request: bytes, folders: tuple[str, ...] | None, is_unwanted: Callable[[], bool]
) -> bytes:
    """Return the pickled result of a request computed by a child, or why the child was killed."""
    status = Status()
    memory = os.memfd_create("answer")
    try:
        pid = os.fork()
        if pid == 0:
            _quietly(lambda: _work(function, request, memory, status, folders))
        ending = Monitor(pid, status).unless(is_unwanted).wait()
        if ending.problem is not None:
            return pickle.dumps(("ended", ending.problem))
        with open(memory, "rb", closefd=False) as file:
            file.seek(0)
            return file.read() or pickle.dumps(("ended", crash(0)))
    finally:
        os.close(memory)


def _work(
    function: Callable[..., Any], request: bytes, memory: int, status: Status, folders: tuple[str, ...] | None
) -> None:
    """Compute a request in a child, and write the answer to its memory file."""
    _begin(status, folders)
    data = _pickled(_result(function, request))
    with open(memory, "wb", closefd=False) as file:
        file.write(data)


def _begin(status: Status, folders: tuple[str, ...] | None) -> None:
    """Initialize a child that answers requests."""
    os.environ["MUJOCO_GL"] = "disable"  # its import would start a process that looks for GLFW
    become_child(status, confined=folders is None)
    if folders is not None:
        confine(folders)


def _result(function: Callable[..., Any], request: bytes) -> tuple[str, Any]:
    """Call the function; an exception is a result, too."""
    try:
        arguments = pickle.loads(request)  # written by the server itself  # noqa: S301  # nosec B301
        return "value", function(*arguments)
    except Exception as error:
        return "error", error


def _pickled(answer: tuple[str, Any]) -> bytes:
    """Pickle an answer, or an error that says why it cannot be pickled."""
    try:
        return pickle.dumps(answer)
    except Exception as error:  # exceptions of libraries may not be picklable
        message = f"internal error: {type(answer[1]).__name__}: {answer[1]} ({error})"
        return pickle.dumps(("error", RuntimeError(message[:2000])))


# --- framing: length-prefixed messages -------------------------------------------------------------------------------


def _send(channel: socket.socket, data: bytes) -> None:
    """Send a message."""
    channel.sendall(_HEADER.pack(len(data)))
    channel.sendall(data)


def _receive(channel: socket.socket) -> bytes:
    """Receive a message; raises EOFError if the channel is closed."""
    (length,) = _HEADER.unpack(_exactly(channel, _HEADER.size))
    if length > _MAX_ANSWER_BYTES:
        raise EOFError
    return _exactly(channel, length)


def _exactly(channel: socket.socket, length: int) -> bytes:
    """Receive so many bytes."""
    buffer = io.BytesIO()
    left = length
    while left:
        piece = channel.recv(min(left, 1 << 20))
        if not piece:
            raise EOFError
        buffer.write(piece)
        left -= len(piece)
    return buffer.getvalue()


# --- trial run -----------------------------------------------------------------------------------------------------


def trial(work: Callable[[], object]) -> Diagnostic | None:
    """Run ``work`` in a forked process first; return why the fork was killed, or None if it ended normally.

    Result and exceptions are discarded, since the work is repeated here. A crashed fork is tried again: threads that
    the fork did not copy may have left a native library in an inconsistent state. A process that is confined as a whole
    cannot fork, and needs no trial: its monitor kills it, and nothing but its request is lost.
    """
    watched = link()
    if not is_supported() or not (watched is None or watched.may_fork):
        return None
    problem = _trial(work)
    return _trial(work) if problem is not None and problem.name == "crash" else problem


def _trial(work: Callable[[], object]) -> Diagnostic | None:
    """Run work in a fork, and return why it was killed."""
    status = Status()
    sys.stdout.flush()
    sys.stderr.flush()
    pid = os.fork()
    if pid == 0:
        _quietly(lambda: _tried(work, status))
    return Monitor(pid, status).wait().problem


def _tried(work: Callable[[], object], status: Status) -> None:
    """Run work in a fork that can be killed, without output."""
    become_child(status)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    null = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1, 2):
        os.dup2(null, number)
    try:
        work()
    except Exception:  # raised again when the work is repeated
        return
