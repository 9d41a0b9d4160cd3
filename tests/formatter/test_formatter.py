"""What formatting keeps and what it may never do: line ends, marks, parts of a text, broken and hostile texts."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from support import calls

from formatter.texts import INDENTS
from scenelang.grammar import formatter
from scenelang.grammar.formatter import (
    FormatEdit,
    FormatFault,
    UnreadableError,
    edit_between,
    format_range,
    format_text,
    settled,
)


def formatted(text: str, width: int = 88) -> str:
    done = format_text(text, INDENTS, width=width)
    assert format_text(done, INDENTS, width=width) == done
    return done


# --- line ends, marks ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("", ""),
        (" \n\t\n", ""),
        ("x", "x\n"),
        ("(a  b)\r\n(c  d)\r\n", "(a b)\r\n(c d)\r\n"),
        ("(a  b)\r\n(c)\n(d)\n", "(a b)\n(c)\n(d)\n"),
        ("(a  b)\n(c)\r\n(d)\r\n", "(a b)\r\n(c)\r\n(d)\r\n"),
        ("(a  b)\n", "(a b)\n"),
        ("; c \t\r\nx\r\n", "; c\r\nx\r\n"),
        ("\ufeff(a  b)", "\ufeff(a b)\n"),
        ("\ufeff", "\ufeff"),
        ("(a\tb\f\n c)", "(a b c)\n"),
        ('(a "x\ty\n z")\r\nb\r\nc\r\n', '(a "x\ty\n z")\r\nb\r\nc\r\n'),
        ('"\n" "\n" "\n" a\r\n', '"\n"\r\n"\n"\r\n"\n"\r\na\r\n'),
        ('(f "a\0b" ; \0\n c)', '(f "a\0b"  ; \0\n  c)\n'),
        ("; only\n\n\n\n; comments", "; only\n\n; comments\n"),
    ],
)
def test_line_ends_and_marks(text: str, wanted: str) -> None:
    assert formatted(text) == wanted


@pytest.mark.parametrize(
    "text",
    [
        "(a  (b  c) . ; why\t \n d)\n",
        "(a . b #| why |#  )\n",
        "'  ; why \n (a    b)\n",
        ",@ #| why |#  (a    b)\n",
        "#;  ; why \n (a    b)\n\nc\n",
    ],
)
def test_comments_in_odd_places_leave_the_text_as_it_stands(text: str) -> None:
    assert formatted(text) == text


def test_strings_of_several_lines_count_by_their_last_line() -> None:
    text = '(f "one\n' + "x" * 40 + '" a-long-operand another-long-operand a-third-operand)'
    assert formatted(text, 60) == (
        '(f "one\n' + "x" * 40 + '" a-long-operand\n   another-long-operand a-third-operand)\n'
    )


@pytest.mark.parametrize(
    "text",
    ["'x", "(quote x)", "`(a ,b ,@c)", "(quasiquote (a (unquote b)))", ", @x", "(a . (b c))", "(a b . c)", "#;a b"],
)
def test_notation_stays(text: str) -> None:
    assert formatted(text) == text + "\n"


def test_each_line_of_a_body_is_kept_apart_by_at_most_one_empty_line() -> None:
    text = "(define (f)\n\n\n  (a)\n\n\n\n  (b)\n  (c))"
    assert formatted(text) == "(define (f)\n\n  (a)\n\n  (b)\n  (c))\n"


# --- off, skip -----------------------------------------------------------------------------------------------------


def test_off_holds_until_on_or_the_end_of_the_list() -> None:
    assert formatted("(f\n; fmt: off\n a   b\n   c)\n(d   e)") == "(f\n  ; fmt: off\n a   b\n   c)\n\n(d e)\n"
    assert formatted("; fmt: off\n( a )\n; fmt: on\n( b )") == "; fmt: off\n( a )\n; fmt: on\n(b)\n"
    assert formatted("( a ) ; fmt: off\n( b )") == "(a)  ; fmt: off\n(b)\n"  # not on a line of its own


def test_a_region_that_ends_with_a_comment_keeps_its_list_closed() -> None:
    assert formatted("(f\n ; fmt: off\n  a  ; c\n )") == "(f\n  ; fmt: off\n  a  ; c\n)\n"


def test_line_ends_of_a_region_stay() -> None:
    text = "; fmt: off\n( a\n b )\n; fmt: on\n(c)\r\n(d)\r\n(e)\r\n(g)\r\n"
    assert formatted(text) == "; fmt: off\r\n( a\n b )\r\n; fmt: on\r\n(c)\r\n(d)\r\n(e)\r\n(g)\r\n"


# --- faults, broken texts ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["(a", "a)", '"a', "#| a", "(a . )", "3px", "xs[0]", "'", '"\\q" 1/2'])
def test_what_does_not_read_is_an_error(text: str) -> None:
    with pytest.raises(UnreadableError) as caught:
        format_text(text, INDENTS)
    assert caught.value.diagnostics
    assert caught.value.diagnostic == caught.value.diagnostics[0]


@pytest.mark.parametrize("wrong", ["(a  c)\n", "(a b) ; more\n", "(a b\n", "((a b))\n"])
def test_a_fault_of_the_formatter_is_found(wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(formatter, "layout_lines", lambda *_, **__: wrong.splitlines())
    with pytest.raises((FormatFault, UnreadableError)):
        format_text("( a b )", INDENTS)


# --- parts of a text -----------------------------------------------------------------------------------------------

PARTS = """\
(a   1)
; of b
(b
    2)   ; end of b


(c   3) (d   4)
(e   5)
"""


@pytest.mark.parametrize(
    ("first", "last", "changes"),
    [
        (1, 1, {"(a   1)": "(a 1)"}),
        (2, 2, {"(b\n    2)   ;": "(b 2)  ;"}),
        (4, 4, {"(b\n    2)   ;": "(b 2)  ;"}),
        (5, 6, {}),
        (7, 7, {"(c   3) (d   4)": "(c 3)\n(d 4)"}),
        (1, 2, {"(a   1)": "(a 1)", "(b\n    2)   ;": "(b 2)  ;"}),
        (8, 99, {"(e   5)": "(e 5)"}),
        (50, 60, {}),
    ],
)
def test_range(first: int, last: int, changes: dict[str, str]) -> None:
    wanted = PARTS
    for before, after in changes.items():
        assert before in wanted
        wanted = wanted.replace(before, after)
    assert format_range(PARTS, first, last, INDENTS) == wanted
    crlf = format_range("\ufeff" + PARTS.replace("\n", "\r\n"), first, last, INDENTS)
    assert crlf == "\ufeff" + wanted.replace("\n", "\r\n")


def test_range_knows_macros_of_the_whole_text() -> None:
    text = "(define-syntax rep (syntax-rules () ((_ n body ...) (begin body ...))))\n(rep 2\n      (f)\n(g))\n"
    assert format_range(text, 2, 2, INDENTS).endswith("(rep 2\n  (f)\n  (g))\n")


def test_edit_between() -> None:
    assert edit_between("a\nb\n", "a\nb\n") is None
    assert edit_between("a\nb\nc\n", "a\nB\nC\nc\n") == FormatEdit(2, 2, "B\nC\n")
    assert edit_between("a\nc\n", "a\nb\nc\n") == FormatEdit(2, 1, "b\n")
    assert edit_between("a\n\n\nc\n", "a\n\nc\n") == FormatEdit(3, 3, "")
    assert edit_between("", "a\n") == FormatEdit(1, 0, "a\n")


# --- hostile texts -------------------------------------------------------------------------------------------------


HOSTILE: dict[str, Callable[[int], str]] = {
    "lists": lambda n: "(" * n + "x" + ")" * n,
    "quotes": lambda n: "'" * n + "x",
    "calls in calls": lambda n: "(f " * (n // 2) + "; c\n x" + ")" * (n // 2),
    "vectors": lambda n: "[ ;x\n" * (n // 2) + "1" + "]" * (n // 2),
    "datum comments": lambda n: "#;" * (n // 2) + " x" * (n // 2) + " y",
    "tails": lambda n: "(a . " * (n // 2) + "b" + ")" * (n // 2),
    "calls behind comments": lambda n: "(f #;(" * (n // 4) + "x" + ")y)" * (n // 4),
    "block comments": lambda n: "#|" * (2 * n) + "|#" * (2 * n) + " x",
    "off in calls": lambda n: "(f\n; fmt: off\nx\n; fmt: on\n" * (n // 6) + ")" * (n // 6),
    "off": lambda n: "; fmt: off\n; fmt: on\n" * (n // 2),
    "many lists": lambda n: "(" + "(a b) " * (n // 2) + ")",
    "many calls": lambda n: "(f" + " (g 1) ; c\n" * (n // 2) + ")",
    "lines in a string": lambda n: '(f "' + "\n" * (4 * n) + '")',
    "a name": lambda n: "(" + "a" * (20 * n) + ")",
}


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.sampled(3)
def test_hostile_texts(name: str) -> None:
    make = HOSTILE[name]
    formatted(make(4_999))  # as deep as the reader allows
    few, many = (calls(lambda n=n: formatted(make(n))) for n in (900, 1_800))
    assert many < 2.3 * few


def test_four_times_the_forms_take_four_times_the_calls() -> None:
    form = '(bind "a"\n  (lambda (:x)\n    (union (call "b" :x 1)   (call "c"))))  ; note\n\n'
    settled(form, INDENTS)  # what is made once
    few, many = (calls(lambda n=n: settled(form * n, INDENTS)) for n in (100, 400))
    assert many < 4.4 * few


@pytest.mark.parametrize("width", [40, 60, 88])
def test_a_keyword_stays_with_its_value(width: int) -> None:
    text = (
        "(define a (align (row (map tub (iota 3)) :gap .25) some-long-paving-name :x :min :y :after :z :max"
        ' :and-another-keyword (list 1 2 3 4 5 6 7 8) :color (color "lightgoldenrodyellow")))\n'
    )
    lines = format_text(text, INDENTS, width=width).splitlines()
    assert len(lines) > 1
    for pair in (":x :min", ":y :after", ":z :max", ":gap .25", ":color (color", ":and-another-keyword (list"):
        assert any(pair in line for line in lines), pair
