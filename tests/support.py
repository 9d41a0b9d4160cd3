"""What several tests need: running programs with chosen runtimes, and scenes as comparable data."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import pytest

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Source
from scenelang.grammar.diagnostics import SceneError, render_text
from scenelang.interpreter.lint.lint import find_root
from scenelang.interpreter.runtime.evaluate import ProgramRun
from scenelang.interpreter.runtime.limits import Limits
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import flatten
from scenelang.session import Options, Session, run_with_room


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


def wait_for_work(pid: int, seconds: float) -> int:
    """Wait for a child of a process that has had so many seconds of the processor; returns its number. Where no folder
    tells, it only waits."""
    if not Path("/proc/self/task").is_dir():
        time.sleep(1.5 + seconds)
        return 0
    end = time.monotonic() + 30.0
    while time.monotonic() < end:
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            if _worked(int(child)) >= seconds:
                return int(child)
        time.sleep(0.02)
    raise AssertionError("no child works")


def _worked(pid: int) -> float:
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def session(**options: Any) -> Session:
    return Session(Options(**options))


@contextmanager
def unchecked() -> Iterator[None]:
    """Programs whose kinds are not checked, so that mistakes are found when they run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scenelang.session.findings", lambda program, root, is_written=True: [])
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


def outcome(text: str, memoise: bool) -> Any:
    """What a program does, as comparable data: flattened geometry and log, or the error."""
    sessions = session()
    with unchecked():
        checked = sessions.check(Source("<test>", text))
    program = checked.program
    assert checked.ok, [render_text(d) for d in checked.diagnostics]
    assert program is not None
    runtime = Runtime(sessions.library, Limits(steps=2_000_000), memoise=memoise)

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
        assert "stop with `,watch`" in running.stdout.readline()
        time.sleep(0.5)  # until the thread watches
        yield running, running.stdin, running.stdout
