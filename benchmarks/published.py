"""Programs that language models wrote, in this process: checked, translated, and evaluated beside the reference.

The reference is ``tests/transpile/reference_model``, which runs the Python in CPython as the authors' package does.
``python published.py RESPONSE`` runs it once.
"""

from __future__ import annotations

import runpy
import sys
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any

from measuring import ROOT, Goal, Pair, Row, timed

RESPONSES = sorted((ROOT / "tests" / "transpile" / "responses").glob("*.txt"))
_LONG = 0.005  # seconds of the reference, from which its own time is compared


@cache
def reference() -> dict[str, Any]:
    return runpy.run_path(str(ROOT / "tests" / "transpile" / "reference_model.py"))


def by_reference(text: str) -> Callable[[], Any]:
    """Return the evaluation of a response by the reference, without its rounding for golden files."""
    model = reference()
    model["flatten"].__globals__["_plain"] = dict
    code = model["extract"](text)
    return lambda: model["flatten"](code)


def evaluations(is_long: bool) -> Iterator[Pair]:
    """The programs for which the reference takes as long, or less: their evaluation, and the reference's."""
    from scenelang.grammar.datum import Source
    from scenelang.interpreter.transpile.translate import translate
    from scenelang.session.session import Session

    session = Session()
    for path in RESPONSES:
        text = path.read_text("utf-8")
        translated = translate(Source(path.name, text)).text
        other = timed(by_reference(text))
        if translated and (other() >= _LONG) == is_long:
            yield Pair(timed(partial(session.evaluate, Source(path.stem, translated))), other)


def checks() -> Iterator[Pair]:
    from scenelang.grammar.datum import Source
    from scenelang.interpreter.transpile.translate import translate
    from scenelang.session.session import Session

    session = Session()
    for path in RESPONSES:
        translated = translate(Source(path.name, path.read_text("utf-8"))).text
        if translated:
            yield Pair(timed(partial(session.check, Source(path.stem, translated))))


def translations() -> Iterator[Pair]:
    from scenelang.grammar.datum import Source
    from scenelang.interpreter.transpile.translate import translate

    for path in RESPONSES:
        yield Pair(timed(partial(translate, Source(path.name, path.read_text("utf-8")))))


_LONG_ROW = "published programs, reference >= 5 ms"
ROWS = (
    Row(f"{_LONG_ROW}, median", partial(evaluations, True), "reference", (Goal(5.0),), rounds=1),
    Row(f"{_LONG_ROW}, worst", partial(evaluations, True), "reference", rounds=3, summary=max),
    Row(
        "published programs, reference < 5 ms, slowest", partial(evaluations, False), "reference",
        (Goal(0.006, "ours"),), rounds=3, summary=max,
    ),
    Row("check of published programs, median", checks, rounds=1),
    Row("check of published programs, slowest", checks, rounds=3, summary=max),
    Row("translation of responses, median", translations, goals=(Goal(0.05, "ours"),), rounds=1),
    Row("translation of responses, slowest", translations, rounds=3, summary=max),
)  # fmt: skip


if __name__ == "__main__":
    by_reference(Path(sys.argv[1]).read_text("utf-8"))()
