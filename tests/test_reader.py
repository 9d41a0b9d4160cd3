"""The reader: every text gives datums or diagnostics; what the printer writes reads back equal."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from searching import many
from support import shape

from scenelang.grammar.datum import (
    ArrayDatum,
    Atom,
    Datum,
    Handle,
    Keyword,
    ListDatum,
    Source,
    Span,
    Symbol,
    atom_text,
    print_datum,
    walk,
)
from scenelang.grammar.reader import Completeness, ReadResult, read, read_comments, read_pieces

NOWHERE = Span(Source("<test>", ""), 0, 0)


def reading(text: str) -> ReadResult:
    return read(Source("<test>", text))


symbols = st.from_regex(r"[a-zA-Z!$%&*/:<=>?^_~+@-][a-zA-Z0-9!$%&*/<=>?^_~+@.-]{0,8}", fullmatch=True).filter(
    lambda s: (
        s != "none"
        and ":" not in s
        and not (s.startswith("<") and s.endswith(">"))
        and not s.lstrip("+-").startswith((".", *"0123456789"))
    )
)
values = st.one_of(
    symbols.map(Symbol),
    st.from_regex(r"[a-z][a-z0-9-]{0,6}", fullmatch=True).map(Keyword),
    st.from_regex(r"[a-z][a-z0-9_-]{0,6}\*?", fullmatch=True).map(Handle),
    st.integers(-(10**30), 10**30),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=12).filter(lambda s: not any(0xD800 <= ord(c) < 0xE000 for c in s)),
    st.booleans(),
    st.none(),
)


def compound(inner: st.SearchStrategy[Datum]) -> st.SearchStrategy[Datum]:
    lists = st.lists(inner, max_size=5).map(lambda items: ListDatum(tuple(items), None, NOWHERE))
    dotted = st.tuples(st.lists(inner, min_size=1, max_size=3), inner.filter(lambda d: not isinstance(d, ListDatum)))
    pairs = dotted.map(lambda parts: ListDatum(tuple(parts[0]), parts[1], NOWHERE))
    arrays = st.lists(inner, max_size=4).map(lambda items: ArrayDatum(tuple(items), NOWHERE))
    quotes = st.tuples(st.sampled_from(["quote", "quasiquote", "unquote", "unquote-splicing"]), inner).map(
        lambda pair: ListDatum((Atom(Symbol(pair[0]), NOWHERE), pair[1]), None, NOWHERE)
    )
    return st.one_of(lists, pairs, arrays, quotes)


datums = st.recursive(values.map(lambda value: Atom(value, NOWHERE)), compound, max_leaves=20)


@settings(max_examples=many(400), deadline=None)
@given(datums)
def test_what_is_printed_reads_back_equal(datum: Datum) -> None:
    text = print_datum(datum)
    result = reading(text)
    assert not result.diagnostics, (text, result.diagnostics)
    assert [shape(form) for form in result.forms] == [shape(datum)]


@settings(max_examples=many(400), deadline=None)
@given(st.text(alphabet=st.sampled_from("()[]'`,@;#|\"\\. \n:<>z1*-+ae\x00é"), max_size=40))
def test_any_text_gives_datums_or_diagnostics(text: str) -> None:
    result = reading(text)
    assert (result.completeness is Completeness.COMPLETE) == (not result.diagnostics)
    for datum in walk(*result.forms):
        assert 0 <= datum.span.start <= datum.span.end <= len(text)


@given(
    st.lists(st.sampled_from(["(a b)", "12", '"x"', "[1 2]", "; c\n", "#| d |#", "#;(gone)", "<z1>", ":k"]), max_size=6)
)
def test_spans_are_exact(pieces: list[str]) -> None:
    text = "  ".join(pieces)
    if pieces and pieces[-1] == "#;(gone)":
        text += " "
    kept = [piece for piece in pieces if piece not in ("; c\n", "#| d |#", "#;(gone)")]
    assert [form.span.text for form in reading(text).forms] == kept


def test_comments_are_kept() -> None:
    text = '; one\n(a "; no" #| two #| deep |# |# b) #;(gone) ; three'
    assert [span.text for span in read_comments(Source("<test>", text))] == [
        "; one", "#| two #| deep |# |#", "#;", "; three",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "state"),
    [
        ("(a b)", Completeness.COMPLETE),
        ("", Completeness.COMPLETE),
        ("(a", Completeness.INCOMPLETE),
        ("(a [1", Completeness.INCOMPLETE),
        ('"abc', Completeness.INCOMPLETE),
        ("#| x", Completeness.INCOMPLETE),
        ("'", Completeness.INCOMPLETE),
        ("#;", Completeness.INCOMPLETE),
        (")", Completeness.WRONG),
        ("(a]", Completeness.WRONG),
        ("3px", Completeness.WRONG),
        ("(')", Completeness.WRONG),
        ("(a . )", Completeness.WRONG),
    ],
)
def test_incomplete_is_told_from_wrong(text: str, state: Completeness) -> None:
    assert reading(text).completeness is state


@pytest.mark.parametrize(
    ("text", "value"),
    [
        (".5", 0.5), ("-1e-3", -0.001), ("-7", -7), ("+3", 3), ("1.", 1.0), ("#t", True), ("#f", False), ("none", None),
        ("@", Symbol("@")), ("->", Symbol("->")), ("<=", Symbol("<=")), ("<", Symbol("<")), ("-", Symbol("-")),
        ("<z1*>", Handle("z1*")), ("<style>", Handle("style")), (":name", Keyword("name")), ("...", Symbol("...")),
        ("embedding-list::List[Embedding]", Symbol("embedding-list::List[Embedding]")),
        ("x::Tuple[List[Float], Word]", Symbol("x::Tuple[List[Float], Word]")), (r'"a\n\x41;\u0042"', "a\nAB"),
    ],
)  # fmt: skip
def test_atoms(text: str, value: Any) -> None:
    (form,) = reading(text).forms
    assert isinstance(form, Atom)
    assert (type(form.value), form.value) == (type(value), value)
    assert reading(atom_text(form.value)).forms[0].value == value  # type: ignore[union-attr]


def test_several_malformed_atoms_are_reported_together() -> None:
    result = reading('(a 3px "\\q" 1/2 xs #foo)')
    assert [d.name for d in result.diagnostics] == ["bad-atom", "bad-string", "bad-atom", "bad-atom"]


@pytest.mark.parametrize("opener", ["(", "[", "'", "`(", "((", "#;("])
@pytest.mark.parametrize("count", [100_000, 1_000_000])
def test_deep_nesting_is_a_diagnostic(opener: str, count: int) -> None:
    assert reading(opener * count).diagnostics


@pytest.mark.parametrize("text", ["a#;#|", ")a#;#|", "'#;|##;", "|##;#|", "(a) b#;#|"])
def test_pieces_of_a_text_that_reads_nowhere(text: str) -> None:
    """The place of what is wrong is in none of the pieces: this ran for ever."""
    assert read_pieces(Source("<a>", text)).diagnostics
