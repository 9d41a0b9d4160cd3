from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.values.values import NIL, Symbol

from .conftest import Caller, new_runtime

CALL = Caller(new_runtime())
TEXT = st.text("ab ,", max_size=8)


@given(TEXT, TEXT.filter(bool), TEXT)
def test_texts_are_pythons(text: str, part: str, other: str) -> None:
    assert CALL.python("string-split", text) == text.split()
    assert CALL.python("string-split", text, part) == text.split(part)
    assert CALL("string-replace", text, part, other) == text.replace(part, other)
    assert CALL("string-replace", text, part, other, 1) == text.replace(part, other, 1)
    assert CALL("string-replace", text, "", other) == text.replace("", other)
    assert CALL("string-trim", text) == text.strip()
    assert CALL("string-trim", text, part) == text.strip(part)
    assert CALL("string-join", CALL("string-split", text, part), part) == text
    assert CALL("string-contains?", text, part) == (part in text)
    assert CALL("string-prefix?", text, part) == text.startswith(part)
    assert CALL("string-suffix?", text, part) == text.endswith(part)
    assert CALL("string-index", text, part) == (text.find(part) if part in text else False)
    assert CALL("string-pad", text, 5, "*") == text.rjust(5, "*")
    assert CALL("string-pad-right", text, 5) == text.ljust(5)
    assert CALL("string<?", text, other) == (text < other)
    assert CALL("list->string", CALL("string->list", text)) == text


def test_strings(call: Caller) -> None:
    assert call("string-append") == ""
    assert call("string", 1.5, "a", Symbol("b"), [1, "c"]) == '1.5ab(1 "c")'
    assert call("string-join", ["a", "b"]) == "a b"
    assert call("string-upcase", "straße") == "STRASSE"
    assert call("string-ref", "abc", -1) == "c"
    assert call("substring", "abcd", 1, 3) == "bc"
    assert call("substring", "abcd", 4) == ""
    assert call("ord", "é") == 233
    assert call("chr", 233) == "é"
    assert type(call("symbol->string", Symbol("a"))) is str
    assert type(call("string->symbol", "a")) is Symbol
    for name, *arguments in (("substring", "ab", 1, 5), ("substring", "ab", 2, 1), ("string-ref", "", 0)):
        call.refuses("index", name, *arguments)
    for name, *arguments in (
        ("string-split", "a", ""),
        ("ord", "ab"),
        ("chr", 0xD800),
        ("chr", -1),
        ("string-pad", "a", 3, ""),
    ):
        call.refuses("value", name, *arguments)
    assert "(string value)" in call.refuses("type", "string-join", [1, 2])


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("string-pad", ("a", 10**9)), ("repeat", ("ab", 10**9)), ("string-replace", ("a" * 4000, "a", "b" * 4000)),
        ("format", ("{:>1000000000}", 1)), ("format", ("{:.1000000000f}", 1)), ("format", ("{:{}}", 1, 10**9)),
        ("format", ("{:>" + "9" * 5000 + "}", 1)), ("string-join", ([""] * 2000, "x" * 10_000)),
    ],
)  # fmt: skip
def test_sizes_are_bounded(call: Caller, name: str, arguments: Any) -> None:
    with pytest.raises(LimitError):
        call(name, *arguments)


FILL = st.sampled_from(["", "<", ">", "^", "*^", "=", "é>"])
SIGN = st.sampled_from(["", "+", " ", "-"])
WIDTH = st.sampled_from(["", "3", "08", "12"])
PRECISION = st.sampled_from(["", ".0", ".2", ".10"])
KIND = st.sampled_from(["", "d", "f", "e", "g", "%", "x", "b", "c", "s"])


@given(st.one_of(st.integers(-(10**6), 10**6), st.floats(allow_nan=False), TEXT), FILL, SIGN, WIDTH, PRECISION, KIND)
def test_formats_are_pythons(value: Any, fill: str, sign: str, width: str, precision: str, kind: str) -> None:
    template = "<{:" + fill + sign + width + precision + kind + "}>"
    try:
        wanted = template.format(value)
    except (ValueError, OverflowError):
        CALL.refuses("format", "format", template, value)
    else:
        assert CALL("format", template, value) == wanted


def test_templates(call: Caller) -> None:
    assert call("format", "{} {}", 1, "a") == "1 a"
    assert call("format", "{1}{0}{1}", 1, 2) == "212"
    assert call("format", "{{{}}}", 1) == "{1}"
    assert call("format", "{:>{}}|{:.{}f}", "a", 3, 1.0, 1) == "  a|1.0"
    assert call("format", "{!r} {!s}", "a", "b") == '"a" b'
    assert call("format", "{} {} {}", True, None, NIL) == "#t none ()"
    assert call("format", "{:>6}|{:,}", [1, 2], 1234567) == " (1 2)|1,234,567"


@pytest.mark.parametrize(
    "template",
    [
        "{",
        "}",
        "{0.real}",
        "{0[0]}",
        "{.real}",
        "{x}",
        "{5}",
        "{} {} {}",
        "{!x}",
        "{!r:d}",
        "{:n}",
        "{:{:{}}}",
        "{0:{1.x}}",
        "{:q}",
    ],
)
def test_templates_that_are_refused(call: Caller, template: str) -> None:
    call.refuses("format", "format", template, 1, 2)
