"""Patterns without a choice, which Python's own matcher ends soon."""

from __future__ import annotations

import subprocess
import sys
from random import Random

import pytest
from support import session

from scenelang import Source
from scenelang.interpreter.transpile.evaluation.deterministic import is_deterministic


@pytest.mark.parametrize(
    "pattern",
    [
        r"([pnbrqkPNBRQK1-8]+/){7}[pnbrqkPNBRQK1-8]+", r"([a-z]+,)*[0-9]+", r"(?:-\d+)*$", r"(ab|cd)+", r"[^a]*a",
        r"#(?:[0-9a-f]{2}){3}", r"(a[^a]*)+", r"([^,]*,)*", r"(x?y)*z", r"(\d+\.)*x", r"(\w+(,\w+)*)", r"(a|ab)*c", r"(\w|\d)+",
    ],
)  # fmt: skip
def test_without_a_choice(pattern: str) -> None:
    assert is_deterministic(pattern)


@pytest.mark.parametrize(
    "pattern",
    [
        r"(a+)*", r"(a*)*b", r"[ab](b*)*", r"(\d+\.)*\d", r"(a|a)*", r"(a(b?)?)*", r"(\w+)+x", r"(.*,)*", r"(\w+\s*)*", r"(é+)*", r"([^a]+)*b",
        r"(a+?)*", r"(?=a+)*", r"(a)\1*", r"(?i:a+)*A", r"(?P<x>a+)(?P=x)*", r"(\S+\W?)*", r"(?i)(aA)+", r"(x{1,9}y?){3}z|x+",
    ],
)  # fmt: skip
def test_with_a_choice_or_undecided(pattern: str) -> None:
    assert not is_deterministic(pattern)


STARTS = "a", "b", "[ab]", "[^a]", "(a", "(b", "(?:[bc]", "c"
PIECES = "a", "b", "c", "(a", "(b", ")", ")*", ")+", ")?", "){2,3}", "*", "+", "?", "|", "d"
SEARCH = """
import re
for pattern in {patterns!r}:
    for text in ("a" * 400, "ab" * 200 + "!", "abc" * 130 + "x", "b" * 400 + "e", "aab" * 99 + "dd"):
        re.compile(pattern).fullmatch(text)
"""


def test_patterns_without_a_choice_end_soon() -> None:
    pick = Random(5)
    drawn = ["".join([pick.choice(STARTS), *pick.choices(PIECES, k=pick.randint(2, 9))]) for _ in range(8_000)]
    patterns = sorted({pattern for pattern in drawn if is_deterministic(pattern)})
    assert len(patterns) > 200
    # one process for all: a pattern that goes back without end would not return to this one
    subprocess.run([sys.executable, "-c", SEARCH.format(patterns=patterns)], check=True, timeout=30)


PROGRAM = """
from helper import *
import re
BOARD = re.{call}

@register()
def w() -> Shape:
    return primitive_call('cube', shape_kwargs={{'scale': (1, 1 + len(BOARD), 1)}}, color=(1, 0, 0))
"""
NESTED = r"r'([pnbr1-8]+/){2}[pnbr1-8]+', 'pn1/rb2/8'"


@pytest.mark.parametrize(
    ("call", "is_translated"),
    [
        (f"search({NESTED})[0]", True),
        (f"compile({NESTED.partition(', ')[0]}).search('pn1/r/8')[0]", True),
        (f"search({NESTED}, re.IGNORECASE)[0]", False),
        (f"search({NESTED}, flags=re.I)[0]", False),
        ("search(r'(\\w+\\s?)+x', 'ab cd')[0]", False),
        (f"search({NESTED}, 2)[0]", False),
        (f"search({NESTED}, flags=2)[0]", False),
        ("search(r'(?:a?){24}a{24}b', 'a' * 24)[0]", False),
    ],
)
def test_patterns_of_programs(call: str, is_translated: bool) -> None:
    result = session().check(Source("w.py", PROGRAM.format(call=call)))
    assert result.ok is is_translated
    assert is_translated or "may take too long to match" in str(result.diagnostics)
