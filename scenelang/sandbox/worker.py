"""Worker processes for servers: each request runs in a separate process, so that killing it affects only that request.

A worker forks a zygote before its server starts threads; the zygote forks a child for every request, with all modules
loaded and no locks of the server's threads held. Only data pickled by our own code on both sides is exchanged; entity
trees stay in the child.
"""

from __future__ import annotations

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
from scenelang.sandbox.status import Status
from scenelang.sandbox.supervision import Ended, Monitor, become_child, crash, is_supported

_HEADER = struct.Struct("=Q")
_MAX_SIZE = 1 << 32  # maximum bytes of an answer


class Worker:
    """Calls ``function`` in a new process per request. ``ask(*arguments)`` returns its value, or raises its exception.
    Arguments, values and exceptions are pickled. ``folders`` are readable for these processes; None removes only the
    rights that evaluation itself gives up.

    Create it before starting other threads. ``ask`` may be called from several threads; requests run sequentially.
    """

    def __init__(self, function: Callable[..., Any], folders: tuple[str, ...] | None = None) -> None:
        self._function = function
        self._folders = folders
        self._lock = threading.Lock()
        self._pid = 0
        self._socket: socket.socket | None = None
        self._number = 0  # number of the last request
        self._running = 0  # number of the running request, 0 for none
        self._cancelled = mmap.mmap(-1, _HEADER.size)  # number of the request to cancel, shared with the zygote
        if is_supported():
            self._start()

    def ask(self, *arguments: Any) -> Any:
        """Run a request; raises Ended if its process exceeded a limit or crashed."""
        if self._socket is None:
            return self._function(*arguments)
        with self._lock:
            self._number += 1
            self._running = self._number
            try:
                answer = self._exchange(pickle.dumps(arguments))
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
        assert self._socket is not None
        try:
            _send(self._socket, _HEADER.pack(self._number) + request)
            return _receive(self._socket)
        except (OSError, EOFError):  # the zygote was killed; the next request starts another
            self.close()
            self._start()
            return pickle.dumps(("ended", crash(0)))

    def _start(self) -> None:
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
        _quietly(lambda: _serve(theirs, self._function, self._folders, parent, self._cancelled))


def _quietly(work: Callable[[], None]) -> NoReturn:
    """Run a forked process to its end, without returning to the code of the parent."""
    code = 1
    try:
        work()
        code = 0
    finally:
        os._exit(code)


# --- zygote --------------------------------------------------------------------------------------------------------


def _serve(
    channel: socket.socket,
    function: Callable[..., Any],
    folders: tuple[str, ...] | None,
    parent: int,
    cancelled: mmap.mmap,
) -> None:
    """Fork a child for every request until the server ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    gc.collect()
    gc.freeze()  # keeps memory pages shared with the children
    while os.getppid() == parent:
        try:
            request = _receive(channel)
        except EOFError:
            return
        number = request[: _HEADER.size]
        is_unwanted = lambda: cancelled[:] == number or os.getppid() != parent  # noqa: B023  # called in this round only
        _send(channel, _answer(function, request[_HEADER.size :], folders, is_unwanted))


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
    become_child(status, confined=folders is None)
    if folders is not None:
        confine(folders)
    try:
        arguments = pickle.loads(request)  # written by the server itself  # noqa: S301  # nosec B301
        answer: tuple[str, Any] = ("value", function(*arguments))
    except Exception as error:
        answer = ("error", error)
    data = _pickled(answer)
    with open(memory, "wb", closefd=False) as file:
        file.write(data)


def _pickled(answer: tuple[str, Any]) -> bytes:
    try:
        return pickle.dumps(answer)
    except Exception as error:  # exceptions of libraries may not be picklable
        message = f"internal error: {type(answer[1]).__name__}: {answer[1]} ({error})"
        return pickle.dumps(("error", RuntimeError(message[:2000])))


# --- framing: length-prefixed messages -------------------------------------------------------------------------------


def _send(channel: socket.socket, data: bytes) -> None:
    channel.sendall(_HEADER.pack(len(data)))
    channel.sendall(data)


def _receive(channel: socket.socket) -> bytes:
    (length,) = _HEADER.unpack(_exactly(channel, _HEADER.size))
    if length > _MAX_SIZE:
        raise EOFError
    return _exactly(channel, length)


def _exactly(channel: socket.socket, length: int) -> bytes:
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
    """Run ``work`` in a forked process first; returns why the fork was killed, or None if it ended by itself. Its
    result and exceptions are discarded, since the work is repeated here. A crashed fork is tried again: threads that
    were not copied by the fork may have left a native library in an inconsistent state."""
    if not is_supported():
        return None
    problem = _trial(work)
    return _trial(work) if problem is not None and problem.name == "crash" else problem


def _trial(work: Callable[[], object]) -> Diagnostic | None:
    status = Status()
    sys.stdout.flush()
    sys.stderr.flush()
    pid = os.fork()
    if pid == 0:
        _quietly(lambda: _tried(work, status))
    return Monitor(pid, status).wait().problem


def _tried(work: Callable[[], object], status: Status) -> None:
    become_child(status)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    null = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1, 2):
        os.dup2(null, number)
    try:
        work()
    except Exception:  # raised again when the work is repeated
        return
