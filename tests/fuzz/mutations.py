"""Mutations of real programs: forms wrapped, exchanged, dropped and repeated, other white space and comments, and stray
brackets. The programs are those of the examples, the library, the documentation and the tests."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from random import Random

from scenelang.grammar.datum import ArrayDatum, Datum, ListDatum, Source, subdatums
from scenelang.grammar.reader import read

ROOT = Path(__file__).parents[2]
FOLDERS = ("examples", "stdlib", "tests/corpus", "tests/fixed", "tests/formatter/cases", "tests/mistakes", "tests/transpile/scenes")  # fmt: skip
LONGEST = 6_000  # characters: larger programs take seconds each
WRAPS = (
    "(begin {})", "(let () {})", "(cond (#t {}))", "(cond ({} => (lambda (v) v)) (else 0))", "(let ((v {})) v)",
    "((lambda xs (car xs)) {})", "((lambda (a (b 1) :k (:c 2) . more) a) {} :k 1)", "(apply (lambda xs (first xs)) (list {}))",
    "(begin (define-record spot at (size 1) (name \"n\")) (spot-at (spot {})))", "(when #t {})", "(if #t {} 0)",
    "(do ((i 0 (+ i 1)) (v {})) ((> i 2) v))", "(let loop ((n 2)) (if (= n 0) {} (loop (- n 1))))", "(first (list {}))",
    "(case 1 ((1 2) {}) (else 3))", "(match (list 1 {}) ((a b) b))", "(let-values (((a b) (values {} 1))) a)",
    "(let/ec out (out {}))", "(guard (e (#t 0)) {})", "(quote {})", "(quasiquote (1 (unquote {})))", "(for/list ((i 2)) {})",
)  # fmt: skip
GAPS = ("\n", " ", "\n\n", "  ", "\n\t", " ; note\n", " #| block |# ", " #;(a b) ", "\r\n")
STRAY = ("(", ")", '"', "[", "]", "#", "'", ",", "`", ";", ".", "\\", "=>", ":", "|")


@cache
def real_programs() -> tuple[str, ...]:
    """The texts of programs that people wrote, up to ``LONGEST``."""
    files = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.scene"))]
    texts = [path.read_text("utf-8", "replace") for path in files]
    for page in (*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md"):
        texts += [match[1] for match in re.finditer(r"```scene\n(.*?)```", page.read_text("utf-8"), re.S)]
    return tuple(text for text in texts if len(text) <= LONGEST)


class Mutations:
    """Draws mutated programs one after another."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)

    def program(self) -> str:
        text = self.random.choice(real_programs())
        for _ in range(self.random.choice((0, 1, 1, 2, 3))):
            text = self._mutated(text)
        return text

    def _mutated(self, text: str) -> str:
        pick = self.random
        nodes = [node for form in read(Source("<program>", text)).forms for node in _nodes(form)]
        if not nodes or pick.random() < 0.35:
            return self._respelled(text)
        span = pick.choice(nodes).span
        written, before, after = span.text, text[: span.start], text[span.end :]
        kind = pick.random()
        if kind < 0.5:
            return before + pick.choice(WRAPS).replace("{}", written) + after
        if kind < 0.7:
            return before + pick.choice(nodes).span.text + after
        if kind < 0.85:
            return before + after
        return f"{before}{written} {written}{after}"

    def _respelled(self, text: str) -> str:
        """Other white space and comments, all on one line, or a stray character."""
        pick = self.random
        kind = pick.random()
        if kind < 0.7:
            out = list(text)
            gaps = [match.start() for match in re.finditer(r"[ \n]+", text)]
            for place in pick.sample(gaps, min(len(gaps), pick.choice((1, 3, 10)))):
                out[place] = pick.choice(GAPS)
            return "".join(out)
        if kind < 0.85:
            return re.sub(r"\s*\n\s*", " ", re.sub(r";[^\n]*", "", text))
        place = pick.randrange(len(text) + 1)
        return text[:place] + pick.choice(STRAY) + text[place:]


def _nodes(form: Datum) -> list[Datum]:
    nodes, stack = [], [form]
    while stack:
        datum = stack.pop()
        nodes.append(datum)
        if isinstance(datum, (ListDatum, ArrayDatum)):
            stack.extend(subdatums(datum))
    return nodes
