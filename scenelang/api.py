"""The Python API: small functions over a session."""

from __future__ import annotations

from pathlib import Path

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.reader import ReadResult, read
from scenelang.interpreter.scene.entity import Scene
from scenelang.session import Checked, Evaluated, Options, Session


def parse(text: str, name: str = "<text>") -> ReadResult:
    """Read ``text`` into datums with spans. Never raises: what is wrong is in ``.diagnostics``."""
    return read(Source(name, text))


def check(text: str, name: str = "<text>", options: Options | None = None) -> Checked:
    """Find the mistakes of a program without running it. Never raises for a mistake in the program."""
    return Session(options).check(Source(name, text))


def evaluate(text: str, name: str = "<text>", options: Options | None = None) -> Evaluated:
    """Run a program. ``.scene`` is None when something went wrong; ``.diagnostics`` says what."""
    return Session(options).evaluate(Source(name, text))


def load(path: str | Path, options: Options | None = None) -> Scene:
    """The scene of a program file. Raises SceneError with the first mistake found."""
    session = Session(options)
    result = session.evaluate(session.source(str(path)))
    if result.scene is not None:
        return result.scene
    problem = next(d for d in result.diagnostics if d.is_error)
    raise SceneError(problem.name, problem.message, problem.hint, problem.span, problem.notes, list(problem.chain))
