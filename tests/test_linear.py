"""Reading, checking and formatting take as many steps for twice the text as twice."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from support import calls

from scenelang.grammar.datum import Source
from scenelang.grammar.formatter import format_text
from scenelang.grammar.reader import read
from scenelang.interpreter.checker import lint
from scenelang.interpreter.checker.idioms import SPELLINGS
from scenelang.interpreter.compile.analyze import analyze
from scenelang.interpreter.expand.forms import INDENTS
from scenelang.session.session import Session

TEXTS: dict[str, Callable[[int], str]] = {
    "numbers": lambda n: "\n".join(f"{i:09d}" for i in range(n)),
    "words": lambda n: "\n".join(f'(bind "w{i}" (lambda () (call "cube" :scale {i})))' for i in range(n)),
    "definitions": lambda n: "\n".join(f"(define v{i} (+ {i} 1))" for i in range(n)),
    "one list": lambda n: "(define x (list " + " ".join(map(str, range(n))) + "))",
    "nested": lambda n: "(list " * 50 + " 1" * n + ")" * 50,
    "comments": lambda n: "\n".join(f"; {i}\n#| b |# #; c {i}" for i in range(n)),
    "unclosed": lambda n: "(a b)\n" * n + "(",
    "wrong": lambda n: "3px\n" * n,
}


def check(text: str) -> None:
    Session().check_forms(Source("<test>", text))


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("step", ["read", "check", "format"])
@pytest.mark.sampled(4)
def test_twice_the_text_takes_twice_the_calls(step: str, text: str) -> None:
    if step != "read" and text in ("unclosed", "wrong"):
        pytest.skip("a text that cannot be read")
    actions: dict[str, Callable[[str], object]] = {
        "read": lambda text: read(Source("<test>", text)),
        "check": check,
        "format": lambda text: format_text(text, INDENTS),
    }
    make, action = TEXTS[text], actions[step]
    action(make(300))  # what is made once
    few, many = (calls(lambda n=n: action(make(n))) for n in (300, 600))
    assert many < 2.3 * few


@pytest.mark.parametrize(
    "make",
    [
        lambda n: "(define (f) " + " ".join(f"(define a{i} 0)" for i in range(n)) + " a1)",
        lambda n: "(defun f (x) (setq y 1))(if (x) else y)\n" * n,
        lambda n: "for i in range(10): print(i)\n" * n,
    ],
    ids=["unused locals", "forms of another language", "statements of another language"],
)  # fmt: skip
@pytest.mark.sampled(3)
def test_twice_the_mistakes_take_twice_the_calls(make: Callable[[int], str]) -> None:
    check(make(20))
    few, many = (calls(lambda n=n: check(make(n))) for n in (100, 200))
    assert many < 2.4 * few


def test_long_numbers_are_searched_in_one_pass() -> None:
    """The expressions for numbers with units took quadratic time, which would be hours here."""
    for row in SPELLINGS:
        assert list(re.finditer(row.pattern, f"+{'9' * 1_000_000}", re.S)) == []


def test_names_are_counted_in_one_pass() -> None:
    """The text was searched for every definition."""
    found = lint._mentions("(define a 'a) `(,b ,@b) 'c''c b@d \"e\"", 3)
    assert (found["a"], found["b"], found["c"], found["d"]) == (2, 2, 1, 1)


def test_loops_in_loops_are_found_in_one_pass() -> None:
    """The body of an outer loop was searched once more for each loop around it."""

    def found(depth: int) -> int:
        text = "(let l ((i 0)) (if (< i 1) (l (+ i 1)) " * depth + "x" + "))" * depth
        program = Session().check(Source("<test>", f"(define (f x) {text})")).program
        assert program is not None
        (form,) = program.forms
        return calls(lambda: analyze((form,)))

    few, many = (found(depth) for depth in (40, 80))
    assert many < 2.3 * few
