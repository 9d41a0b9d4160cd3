"""The language: programs beside the same in plain Python, in Hy and in Guile, and programs that strangers wrote.

``strangers/NAME.scene`` is timed in its last form, ``strangers/NAME.py`` has the same as ``run()``. Whoever wrote them
knew the language and not the interpreter, and nobody tunes to them; ``strangers/relatives.toml`` says which program of
ours does alike work (``NAME = "tak"``), whose goal it then has, times 1.5.
"""

from __future__ import annotations

import runpy
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import native
import programs
from measuring import HERE, Absent, Goal, Pair, Probe, Row, Timed, peer, timed

STRANGERS = HERE / "strangers"
_RELATED = 1.5  # times the goal of our own program
_GUILE = (
    "(define-syntax time (syntax-rules () ((_ e) (let ((t (get-internal-run-time))) e "
    "(display (/ (- (get-internal-run-time) t) internal-time-units-per-second 1.0))))))\n"
)

# name: program, the same in Python, the most that their ratio may be
OURS: dict[str, tuple[str, Callable[[], Any], float | None]] = {
    "fib": (programs.FIB, partial(native.fib, 22), None),
    "loop": (programs.LOOP, native.loop, None),
    "tak": (programs.TAK, partial(native.tak, 14, 8, 2), 3.0),
    "queens": (programs.QUEENS, partial(native.queens, 7), 5.0),
    "strings": (programs.STRINGS, native.strings, 6.0),
    "vectors": (programs.VECTORS, native.vectors, 3.5),
    "chessboard": (programs.CHESSBOARD, native.chessboard, None),
    "100,000 placed objects": (programs.PLACED, native.placed, 2.0),
    "tree of depth 14, a draw a call": (programs.TREE, partial(native.tree, 14), 3.5),
    "30,000 nested poses": (programs.NESTED, native.nested, 2.0),
}
COUNTED = ("fib", "loop", "tak", "queens", "strings", "vectors", "tree of depth 14, a draw a call")
SCENES = ("100,000 placed objects", "tree of depth 14, a draw a call", "30,000 nested poses")
LISPS = ("fib", "loop", "tak")


def last_form(text: str, collecting: bool = False) -> Timed:
    """Return the probe of the last form of a program, the others having run."""
    from scenelang.grammar.datum import Source
    from scenelang.interpreter.evaluation.evaluate import ProgramRun
    from scenelang.interpreter.runtime.runtime import Runtime
    from scenelang.session.session import Session

    session = Session()
    program = session.check(Source("<bench>", text)).program
    assert program is not None, "the program has errors"

    def begun() -> ProgramRun:
        run = ProgramRun(session.library, Runtime(session.library))
        for form in program.forms[:-1]:
            run.run_form(form)
        return run

    return Timed(lambda run: run.run_form(program.forms[-1]), begun, collecting, deep=True)


def beside(text: str, other: Callable[[], Any], collecting: bool = False) -> list[Pair]:
    return [Pair(last_form(text, collecting), timed(other, collecting=collecting))]


def guile(text: str) -> Probe:
    """Return the probe of a program whose last form is in ``(time ...)``, where Guile is installed."""
    if shutil.which("guile") is None:
        raise Absent("guile is not installed")
    words = ["guile", "-c", _GUILE + text]
    return lambda: float(subprocess.run(words, check=True, capture_output=True, text=True).stdout)


def guile_text(name: str) -> str:
    """Return a program of ours for Guile, in which these programs mean the same."""
    text = OURS[name][0].strip()
    start = text.rindex("\n(") + 1 if "\n(" in text else text.rindex(") (") + 2 if ") (" in text else 0
    return f"{text[:start]}(time {text[start:]})"


def strangers(folder: Path = STRANGERS) -> Iterator[Row]:
    """Iterate over the rows of programs that strangers wrote; the folder may be empty or absent."""
    table = folder / "relatives.toml"
    relatives = tomllib.loads(table.read_text("utf-8")) if table.exists() else {}
    for path in sorted(folder.glob("*.scene")):
        most = OURS[relatives[path.stem]][2] if path.stem in relatives else None
        goals = () if most is None else (Goal(_RELATED * most),)
        yield Row(f"stranger: {path.stem}", partial(stranger, path), "Python", goals, rounds=3)


def stranger(path: Path) -> list[Pair]:
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))  # whose programs share a module
    return beside(path.read_text("utf-8"), runpy.run_path(str(path.with_suffix(".py")))["run"])


def _ours() -> Iterator[Row]:
    for name, (text, other, most) in OURS.items():
        goals = () if most is None else (Goal(most),)
        yield Row(name, partial(beside, text, other), "Python", goals, counts=name in COUNTED)
        if name in SCENES:
            yield Row(f"{name}, gc on", partial(beside, text, other, True), "Python, gc on", rounds=3)
    for name in LISPS:
        text = OURS[name][0]
        yield Row(f"{name} beside Hy", partial(_beside_lisp, text, peer, ("hy", name)), "Hy", rounds=3)
        yield Row(f"{name} beside Guile", partial(_beside_lisp, text, guile, (guile_text(name),)), "Guile", rounds=3)


def _beside_lisp(text: str, lisp: Callable[..., Probe], words: tuple[str, ...]) -> list[Pair]:
    return [Pair(last_form(text), lisp(*words))]


ROWS = (*_ours(), *strangers())
