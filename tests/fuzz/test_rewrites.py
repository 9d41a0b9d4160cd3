"""Rewriting keeps the meaning: `fmt`, `expand`, `check --fix`, `lift`, edits of instances and `transpile` change neither
the scene nor the log nor what goes wrong, what they write can be read, and what is written is rewritten to itself.

A sample of other programs every day, 5,000 with `make test-nightly`, and by hand, for one rewrite or one kind of program:

    PYTHONPATH=tests python -m fuzz.test_rewrites mutated 10000 [first seed]
"""

from __future__ import annotations

import re
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from typing import Any

import numpy as np
import pytest
from searching import many

from fuzz.mutations import Mutations
from fuzz.python_programs import PythonPrograms
from fuzz.scene_programs import Programs
from scenelang import api
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.formatter import format_text
from scenelang.interpreter.expand.forms import INDENTS
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.flatten import flatten
from scenelang.interpreter.values.limits import Limits
from scenelang.session import session
from scenelang.session.session import Options, Session

SESSION = Session(Options(limits=Limits(steps=300_000, primitives=20_000, entities=20_000)))
PER_SEED = 100
CLOSE = 1e-9  # relative: what a rewrite may change by rounding

# Findings whose fix changes the scene, because it is not what the text says: degrees of degrees, a product of matrices
# by elements, a keyword taken by position, and an offset of the web's kind.
CORRECTED = frozenset({"W402", "W405", "W407", "W608"})
_FUNCTION = re.compile(r"<procedure [^<>]*>")  # a function that is written where it is used has no name to print


@dataclass(frozen=True)
class Outcome:
    """The primitives of a program, their matrices, what was printed, and the names of its errors."""

    primitives: object
    matrices: tuple[bytes, ...]
    log: object
    errors: frozenset[str]

    def equals(self, other: Outcome, is_exact: bool) -> bool:
        if (self.primitives, self.errors) != (other.primitives, other.errors):
            return False
        if is_exact:
            return (self.matrices, self.log) == (other.matrices, other.log)
        if _FUNCTION.sub("", str(self.log)) != _FUNCTION.sub("", str(other.log)):
            return False
        mine, theirs = (np.frombuffer(b"".join(each.matrices)) for each in (self, other))
        scale = float(np.abs(mine).max(initial=1.0))
        return mine.shape == theirs.shape and bool(np.allclose(mine, theirs, rtol=0, atol=CLOSE * scale))


def outcome(name: str, text: str) -> Outcome:
    result = SESSION.evaluate(Source(name, text))
    errors = frozenset(d.name for d in result.diagnostics if d.is_error)
    if result.scene is None:
        return Outcome(None, (), result.log, errors)
    try:
        frames = flatten(result.scene).frames
    except SceneError as error:
        return Outcome(error.name, (), result.log, errors)
    primitives = [[frame.primitives[i] for i in frame.index] for frame in frames]
    texts = tuple((each.word, repr(primitive_attributes(each))) for frame in primitives for each in frame)
    matrices = tuple(np.asarray(matrix, float).tobytes() for frame in frames for matrix in frame.matrices)
    return Outcome(texts, matrices, result.log, errors)


def _expanded(text: str) -> str | None:
    checked = SESSION.check(Source("<program>", text))
    return SESSION.expansion(checked.program) if checked.ok and checked.program is not None else None


def _edited(text: str) -> str | None:
    """Move the first part of the scene there and back."""
    result = SESSION.evaluate(Source("<program>", text))
    if result.scene is None or not result.ok or not result.scene.frames[0].children:
        return None
    root = result.scene.frames[0]
    path = f"{root.word}/{root.children[0].car.word}"
    there = api.edit_instance(text, path, move=(1, 2, 3)).text
    return api.edit_instance(there, path, move=(-1, -2, -3)).text


def _transpiled(text: str) -> str | None:
    translation = SESSION.transpile(Source("<program>.py", text))
    return translation.text if translation.ok else None


REWRITES: dict[str, Callable[[str], str | None]] = {
    "fix": lambda text: SESSION.autofix(Source("<program>", text))[0].text,
    "fmt": lambda text: format_text(text, INDENTS),
    "expand": _expanded,
    "lift": lambda text: SESSION.lift(Source("<program>", text))[0],
    "edit": _edited,
    "transpile": _transpiled,
}  # fmt: skip
IDEMPOTENT = frozenset({"fix", "fmt", "expand", "lift"})
OF_SCENES = ("fix", "fmt", "expand", "lift", "edit")
KINDS = {"mutated": OF_SCENES, "scene": OF_SCENES, "python": ("transpile",)}


class Comparison:
    """What rewrites change about a program. ``rewritten`` counts the texts that each one wrote."""

    def __init__(self) -> None:
        self.rewritten: Counter[str] = Counter()

    def differences(self, rewrites: tuple[str, ...], text: str) -> list[str]:
        before: dict[str, Outcome] = {}  # by the file's name, once it is needed
        return [told for rewrite in rewrites if (told := self._difference(rewrite, text, before)) is not None]

    def _difference(self, rewrite: str, text: str, known: dict[str, Outcome]) -> str | None:
        written = self._written(rewrite, text)
        if written is None or written == text:
            return None
        self.rewritten[rewrite] += 1
        name = "<program>.py" if rewrite == "transpile" else "<program>.scene"
        before = known.setdefault(name, outcome(name, text))
        if not self._is_kept(rewrite, text, before, outcome("<program>.scene", written)):
            return f"--- {rewrite}\n{text}\n--- becomes\n{written}\n--- {before}\n--- {outcome('<program>.scene', written)}"
        again = self._written(rewrite, written) if rewrite in IDEMPOTENT and not before.errors else written
        return None if again == written else f"--- {rewrite} twice\n{text}\n--- becomes\n{written}\n--- then\n{again}"

    @staticmethod
    def _written(rewrite: str, text: str) -> str | None:
        try:
            return REWRITES[rewrite](text)
        except SceneError:  # a text that cannot be read, or no form that makes a part alone
            return None

    @staticmethod
    def _is_kept(rewrite: str, text: str, before: Outcome, after: Outcome) -> bool:
        if before.equals(after, is_exact=rewrite not in ("lift", "edit")):
            return True
        if not before.errors:
            codes = {d.code for d in SESSION.check(Source("<program>", text)).diagnostics}
            return rewrite == "fix" and bool(codes & CORRECTED)
        if rewrite == "fmt":  # what is not a program, such as prose, has no meaning to keep
            return "foreign-syntax" in before.errors | after.errors and bool(after.errors)
        return True  # errors are repaired by `fix`, and an expansion may show what was only known when it ran


def programs(kind: str, seed: int) -> Callable[[], str]:
    makers: dict[str, Any] = {"mutated": Mutations, "python": PythonPrograms, "transpile": PythonPrograms}
    return makers.get(kind, Programs)(seed).program


@pytest.mark.search
@pytest.mark.parametrize("kind", KINDS)
def test_rewriting_keeps_the_meaning(kind: str) -> None:
    """Other programs every day, and the day is the seed, so that a failure can be repeated."""
    seed = date.today().toordinal()
    draw, comparison = programs(kind, seed), Comparison()
    for _ in range(many(500)):
        told = comparison.differences(KINDS[kind], draw())
        assert not told, f"seed {seed}\n{told[0]}"
    assert comparison.rewritten, "no rewrite wrote another text"


def main(kind: str, count: int, first: int) -> int:
    """Run ``count`` programs through the rewrites of a kind, or one rewrite; print every difference, and the figures."""
    rewrites = KINDS.get(kind, (kind,))
    session.run_with_room = lambda action, *_, **__: action()  # small programs need no thread of their own
    comparison, wrong, started = Comparison(), 0, time.perf_counter()
    for number in range(count):
        if number % PER_SEED == 0:
            draw = programs(kind, first + number // PER_SEED)
        text = draw()
        try:
            told = comparison.differences(rewrites, text)
        except Exception as error:
            told = [f"{text}\n--- raises {type(error).__name__}: {error}"]
        for problem in told:
            wrong += 1
            print(problem, flush=True)
        if number % PER_SEED == PER_SEED - 1 or number == count - 1:
            shown = re.sub(r"Counter\(|\)$", "", str(comparison.rewritten))
            print(f"# {number + 1} programs, {shown} rewritten, {wrong} differences, "
                  f"{time.perf_counter() - started:.0f} s", flush=True)  # fmt: skip
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]) if len(sys.argv) > 3 else 0))
