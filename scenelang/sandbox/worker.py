"""Work for servers, each request in a process of its own: a program that has to be ended costs its request only.

A worker forks once, before its server starts threads, and that copy forks a child for every request: all modules are
loaded already, and no lock of the server's threads is held. What goes between them is plain data, pickled by code of
ours on both sides; entity trees stay in the child.
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
_LARGEST = 1 << 32  # bytes of an answer


class Worker:
    """``ask(*arguments)`` calls ``function`` in a new process and returns its value, or raises what it raised.
    Arguments, values and errors are pickled. ``folders`` is what those processes may read; None leaves them all rights
    but those that evaluation itself gives up.

    Create it before other threads start. Several threads may ask; requests run one after another.
    """

    def __init__(self, function: Callable[..., Any], folders: tuple[str, ...] | None = None) -> None:
        self._function = function
        self._folders = folders
        self._lock = threading.Lock()
        self._pid = 0
        self._socket: socket.socket | None = None
        self._number = 0  # of the last request
        self._running = 0  # the number of the request that runs, 0 for none
        self._cancelled = mmap.mmap(
            -1, _HEADER.size
        )  # the number of the request to end, shared with the waiting process
        if is_supported():
            self._start()

    def ask(self, *arguments: Any) -> Any:
        """Raises Ended where the process went past a limit or crashed."""
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
        """End the request that is running, if any, as Ctrl-C would."""
        self._cancelled[:] = _HEADER.pack(self._running)

    def close(self) -> None:
        """End the waiting process and what it runs."""
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
        except (OSError, EOFError):  # the waiting process itself was ended from outside: the next request has another
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
    """Run the life of a forked process; nothing of the process that it was forked from may run in it."""
    code = 1
    try:
        work()
        code = 0
    finally:
        os._exit(code)


# --- the waiting process -----------------------------------------------------------------------------------------


def _serve(
    channel: socket.socket,
    function: Callable[..., Any],
    folders: tuple[str, ...] | None,
    parent: int,
    cancelled: mmap.mmap,
) -> None:
    """Fork a child for every request until the server is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    gc.collect()
    gc.freeze()  # what the collector never visits stays shared with the children
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
    """What a child of its own makes of a request, or why it was ended."""
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
    except Exception as error:  # an error of a library may hold anything
        said = f"internal error: {type(answer[1]).__name__}: {answer[1]} ({error})"
        return pickle.dumps(("error", RuntimeError(said[:2000])))


# --- a request or an answer, with its length before it ---------------------------------------------------------------


def _send(channel: socket.socket, data: bytes) -> None:
    channel.sendall(_HEADER.pack(len(data)))
    channel.sendall(data)


def _receive(channel: socket.socket) -> bytes:
    (length,) = _HEADER.unpack(_exactly(channel, _HEADER.size))
    if length > _LARGEST:
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


# --- a trial -------------------------------------------------------------------------------------------------------


def trial(work: Callable[[], object]) -> Diagnostic | None:
    """Do ``work`` in a copy of this process first: why that copy had to be ended, None where it came to an end. What it
    computed is lost, and what it raised is raised again when the work is done here. A copy that crashes is tried again:
    threads that were not copied may have left a native library in the middle of something."""
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
    except Exception:  # raised again where the work is done
        return
