"""What several tests need: running programs with chosen runtimes, and scenes as comparable data."""

from __future__ import annotations

import itertools
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import tracemalloc
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import pytest

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Source
from scenelang.grammar.diagnostics import SceneError, render_text
from scenelang.interpreter.checker.lint import find_root
from scenelang.interpreter.evaluation.evaluate import ProgramRun
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import flatten
from scenelang.interpreter.values.limits import Limits
from scenelang.session.session import Options, Session, run_with_room

PATIENCE = 300.0  # seconds to wait for what comes at once on an idle machine


def calls(action: Callable[[], object]) -> int:
    """How many functions an action calls, those in C too, here and in the threads that it starts."""
    count = itertools.count()

    def note(frame: Any, event: str, argument: Any) -> None:
        if event in ("call", "c_call"):
            next(count)

    threading.setprofile(note)
    sys.setprofile(note)
    try:
        action()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)  # type: ignore[arg-type]
    return next(count)


def peak_bytes(action: Callable[[], object]) -> int:
    """The most memory that Python and numpy hold for an action at once."""
    tracemalloc.start()
    try:
        action()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@contextmanager
def interruptible(words: list[str], cwd: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A process that Ctrl-C reaches, also where the tests run in the background; ended with the block."""
    heed = lambda: signal.signal(signal.SIGINT, signal.default_int_handler)
    pipe, environment = subprocess.PIPE, {**os.environ, "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(words, cwd=cwd, stdout=pipe, stderr=pipe, env=environment, preexec_fn=heed) as running:
        try:
            yield running
        finally:
            running.kill()


def wait_for_work(pid: int, seconds: float, but: Collection[int] = ()) -> int:
    """Wait until a process below another one, with none below itself, has had so many seconds of the processor, ``but``
    not one of these; returns its number. Where no folder tells, it only waits."""
    if not _TELLS:
        time.sleep(1.5 + seconds)
        return 0
    for _ in _patiently():
        for child in below(pid):
            if child not in but and worked(child) >= seconds and not below(child):
                return child
        assert is_running(pid), "the process has ended"
    raise AssertionError("no process works")


def wait_for_more_work(pid: int, seconds: float) -> None:
    """Wait until a process and those below it have had so many more seconds of the processor. Where no folder tells, it
    only waits."""
    if not _TELLS:
        time.sleep(1.5 + seconds)
        return
    before = worked_in_all(pid)
    for _ in _patiently():
        if worked_in_all(pid) >= before + seconds:
            return
        assert is_running(pid), "the process has ended"
    raise AssertionError("it does not work")


def wait_until(condition: Callable[[], object]) -> None:
    """Wait for what holds at once on an idle machine."""
    assert any(condition() for _ in _patiently()), "it takes too long"


_TELLS = Path("/proc/self/task").is_dir()


def _patiently() -> Iterator[None]:
    """Comes again and again, with a pause between, until patience ends."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        yield
        time.sleep(0.02)


def below(pid: int) -> list[int]:
    """The processes that a process has started, and those that they have."""
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            found += map(int, task.read_text().split())
        except OSError:
            pass
    return found + [deeper for child in found for deeper in below(child)]


def worked(pid: int) -> float:
    """The seconds of the processor that a process has had."""
    fields = _status(pid)
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK") if fields else 0.0


def worked_in_all(pid: int) -> float:
    """The seconds of the processor that a process and those below it have had."""
    return sum(map(worked, [pid, *below(pid)]))


def is_running(pid: int) -> bool:
    """Whether there is such a process, and it has not ended."""
    fields = _status(pid)
    return bool(fields) and fields[0] != "Z"


def _status(pid: int) -> list[str]:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []


def session(**options: Any) -> Session:
    return Session(Options(**options))


@contextmanager
def unchecked() -> Iterator[None]:
    """Programs whose kinds are not checked, so that mistakes are found when they run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scenelang.session.session.findings", lambda program, root, is_written=True: [])
        yield


def evaluate(text: str, **options: Any) -> Scene:
    """The scene of a program that must be right."""
    result = session(**options).evaluate(Source("<test>", text))
    assert result.scene is not None, "\n".join(render_text(d) for d in result.diagnostics)
    return result.scene


def failure(text: str, **options: Any) -> tuple[str, str]:
    """Name and message of the error that a program must end in."""
    result = session(**options).evaluate(Source("<test>", text))
    errors = [d for d in result.diagnostics if d.is_error]
    assert errors, "the program is right"
    return errors[0].name, errors[0].message


def value(expression: str, definitions: str = "", **options: Any) -> Any:
    """The value of an expression."""
    sessions = session(**options)
    checked = sessions.check(Source("<test>", f"{definitions}\n{expression}"))
    program = checked.program
    assert checked.ok, [d.message for d in checked.diagnostics]
    assert program is not None
    run = ProgramRun(sessions.library, Runtime(sessions.library, Limits(seconds=30.0), sessions.options.seed))

    def go() -> Any:
        result = None
        for form in program.forms:
            result = run.run_form(form)
        return result

    return run_with_room(go, 100_000)


def outcome(text: str, memoize: bool) -> Any:
    """What a program does, as comparable data: flattened geometry and log, or the error."""
    sessions = session()
    with unchecked():
        checked = sessions.check(Source("<test>", text))
    program = checked.program
    assert checked.ok, [render_text(d) for d in checked.diagnostics]
    assert program is not None
    runtime = Runtime(sessions.library, Limits(steps=2_000_000), memoize=memoize)

    def go() -> Scene:
        run = ProgramRun(sessions.library, runtime)
        run.run_forms(program)
        return run.run_root(program, find_root(program)[0], 0)

    try:
        scene = run_with_room(go, 10_000)
    except SceneError as error:
        return error.name, error.message
    return geometry(scene)


def geometry(scene: Scene) -> list[Any]:
    """Per frame, the primitives in order: word, attributes as printed, path, matrix."""
    frames = []
    for frame in flatten(scene).frames:
        rows = []
        for i in range(len(frame)):
            entity = frame.primitives[frame.index[i]]
            attributes = sorted(primitive_attributes(entity).items())
            rows.append((entity.word, repr(attributes), frame.paths[frame.path_index[i]], frame.matrices[i].tolist()))
        frames.append(rows)
    return frames


def shape(datum: Datum) -> Any:
    """A datum without its places."""
    if isinstance(datum, Atom):
        return type(datum.value).__name__, datum.value
    items = [shape(item) for item in datum.items]
    if isinstance(datum, ArrayDatum):
        return "array", items
    return "list", items, shape(datum.tail) if datum.tail is not None else None


def rewrite(path: Path, text: str) -> None:
    """Replace a file in one step, as editors do: who watches it never reads half of it."""
    whole = path.with_suffix(".part")
    whole.write_text(text, "utf-8")
    whole.replace(path)


def read_until(stream: IO[str], text: str) -> list[str]:
    """The lines that come until one holds ``text``, that one included."""
    found = [stream.readline()]
    while text not in found[-1]:
        assert found[-1], f"{text!r} does not come, but {''.join(found)!r}"
        found.append(stream.readline())
    return found


@contextmanager
def watching(
    command: list[str], folder: Path, inputs: str = ""
) -> Iterator[tuple[subprocess.Popen[str], IO[str], IO[str]]]:
    """A plain REPL that watches its file, with its streams."""
    with subprocess.Popen(
        command, cwd=folder, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as running:
        assert running.stdin is not None
        assert running.stdout is not None
        running.stdin.write(f"{inputs},watch\n")
        running.stdin.flush()
        assert "stop with `,watch`" in running.stdout.readline()  # what changes from now on is noticed
        yield running, running.stdin, running.stdout


def chromium_path() -> str | None:
    """Return where Chromium is installed, None if it is not."""
    return shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
