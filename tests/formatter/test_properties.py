"""Formatting changes white space only and is idempotent, whatever the text."""

from __future__ import annotations

from hypothesis import example, given, settings
from hypothesis import strategies as st
from searching import many

from formatter.texts import INDENTS, text_of
from scenelang.grammar.concrete import essence
from scenelang.grammar.datum import Source, print_datum
from scenelang.grammar.formatter import UnreadableError, format_range, format_text
from scenelang.grammar.reader import read

SEEDS = st.integers(0, 2**40)


def readable(text: str) -> bool:
    return not read(Source("<test>", text)).diagnostics


@settings(max_examples=many(600), deadline=None)
@given(SEEDS, st.sampled_from([30, 60, 88]))
@example(118601, 30)  # a string of several lines, then a keyword
def test_only_white_space_changes_and_once_is_enough(seed: int, width: int) -> None:
    text = text_of(seed)
    try:
        done = format_text(text, INDENTS, width=width)
    except UnreadableError:
        assert not readable(text)
        return
    assert essence(done) == essence(text)
    assert [print_datum(form) for form in read(Source("", done)).forms] == [
        print_datum(form) for form in read(Source("", text)).forms
    ]
    assert format_text(done, INDENTS, width=width) == done


@settings(max_examples=many(400), deadline=None)
@given(SEEDS, st.integers(1, 30), st.integers(0, 8))
def test_a_range_changes_white_space_only(seed: int, first: int, more: int) -> None:
    text = text_of(seed)
    if not readable(text):
        return
    done = format_range(text, first, first + more, INDENTS)
    assert essence(done) == essence(text)
