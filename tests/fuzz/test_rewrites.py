"""Rewriting keeps the meaning: `check --fix`, `fmt`, `expand` and `transpile` change neither geometry nor log, nor what
goes wrong. A few programs in the suite; long runs by hand:

    PYTHONPATH=tests python -m fuzz.test_rewrites scene 10000 [first seed]     (or python, or one rewrite)
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence

import pytest

from fuzz.python_programs import PythonPrograms
from fuzz.scene_programs import Programs
from scenelang import session
from scenelang.grammar.datum import Source
from scenelang.grammar.formatter import format_text
from scenelang.interpreter.expand.forms import INDENTS
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.flatten import flatten
from scenelang.session import Session

SESSION = Session()
IN_SUITE = 60
PER_SEED = 100

Outcome = tuple[object, ...]


def outcome(name: str, text: str) -> Outcome:
    """The geometry, what was printed, and the errors of a program, by name."""
    result = SESSION.evaluate(Source(name, text))
    errors = tuple(d.name for d in result.diagnostics if d.is_error)
    if result.scene is None:
        return (None, result.log, errors)
    try:
        frames = flatten(result.scene).frames
    except Exception as error:
        return (type(error).__name__, result.log, errors)
    rows = [
        (primitive.word, repr(primitive_attributes(primitive)), frame.matrices[i].tobytes())
        for frame in frames
        for i, primitive in enumerate(frame.primitives[index] for index in frame.index)
    ]
    return (tuple(rows), result.log, errors)


def _fixed(text: str) -> str:
    return SESSION.autofix(Source("<program>", text))[0].text


def _formatted(text: str) -> str:
    return format_text(text, INDENTS)


def _expanded(text: str) -> str | None:
    checked = SESSION.check(Source("<program>", text))
    return SESSION.expansion(checked.program) if checked.ok and checked.program is not None else None


def _transpiled(text: str) -> str | None:
    translation = SESSION.transpile(Source("<program>.py", text))
    return translation.text if translation.ok else None


REWRITES: dict[str, Callable[[str], str | None]] = {
    "fix": _fixed, "fmt": _formatted, "expand": _expanded, "transpile": _transpiled,
}  # fmt: skip
KINDS = {"scene": ("fix", "fmt", "expand"), "python": ("transpile",)}


def differences(rewrites: Sequence[str], text: str) -> tuple[list[str], list[str]]:
    """What rewrites change about a program, and which of them wrote another text."""
    found, rewritten = [], []
    before: Outcome | None = None
    for rewrite in rewrites:
        written = REWRITES[rewrite](text)
        if written is None or written == text:
            continue
        rewritten.append(rewrite)
        before = before or outcome("<program>.py" if rewrite == "transpile" else "<program>.scene", text)
        after = outcome("<rewritten>.scene", written)
        is_repaired = rewrite == "fix" and before[2]  # what fails is meant to change
        if before != after and not is_repaired:
            found.append(f"--- {rewrite}\n{text}\n--- becomes\n{written}\n--- {before}\n--- {after}")
    return found, rewritten


def programs(kind: str, seed: int) -> Callable[[], str]:
    return PythonPrograms(seed).program if kind in ("python", "transpile") else Programs(seed).program


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.sampled(2)
def test_rewriting_keeps_the_meaning(kind: str) -> None:
    draw = programs(kind, 0)
    for _ in range(IN_SUITE):
        found, _ = differences(KINDS[kind], draw())
        assert not found, found[0]


def main(kind: str, count: int, first: int) -> int:
    """Run ``count`` programs through the rewrites of a kind, or one rewrite; print every difference, and the figures at the end."""
    rewrites = KINDS.get(kind, (kind,))
    session.run_with_room = lambda action, *_, **__: action()  # small programs need no thread of their own
    wrong, rewritten, started = 0, Counter[str](), time.perf_counter()
    for number in range(count):
        if number % PER_SEED == 0:
            draw = programs(kind, first + number // PER_SEED)
        text = draw()
        try:
            found, names = differences(rewrites, text)
        except Exception as error:
            found, names = [f"{text}\n--- raises {type(error).__name__}: {error}"], []
        rewritten.update(names)
        for problem in found:
            wrong += 1
            print(problem, flush=True)
        if number % PER_SEED == PER_SEED - 1 or number == count - 1:
            seconds = time.perf_counter() - started
            print(
                f"# {number + 1} programs, {dict(rewritten)} rewritten, {wrong} differences, {seconds:.0f} s",
                flush=True,
            )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]) if len(sys.argv) > 3 else 0))
