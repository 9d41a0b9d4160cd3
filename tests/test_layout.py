"""The layout: programs look as a person writes them, keep their comments, and read back equal."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from textwrap import dedent

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from searching import many
from support import calls, shape

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
    print_datum,
    walk,
)
from scenelang.grammar.layout import Row, Trivia, layout, line_comment
from scenelang.grammar.reader import read, read_comments
from scenelang.interpreter.expand.forms import FORMS

INDENTS = {name: form.indent for name, form in FORMS.items()}
NOWHERE = Span(Source("<test>", ""), 0, 0)
CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.scene"))


def forms_of(text: str) -> tuple[Datum, ...]:
    result = read(Source("<test>", text))
    assert not result.diagnostics, (text, result.diagnostics)
    return result.forms


def spelling_of(forms: Iterable[Datum]) -> dict[int, str]:
    return {id(datum): datum.span.text for datum in walk(*forms) if isinstance(datum, Atom)}


def laid_out(text: str, width: int = 88) -> str:
    forms = forms_of(text)
    return layout(forms, indents=INDENTS, spelling=spelling_of(forms), width=width)


# --- style ---------------------------------------------------------------------------------------------------------

STYLE = {
    "flat": (88, "(define x (+ 1 .5 1e-3))"),
    "functions of a file": (
        88,
        """
        (define (smoothstep t)
          (* t t (- 3 (* 2 t))))

        (bind "floor"
          (lambda (:radius)
            (call "cylinder" :radius radius)))
        """,
    ),
    "top-level lines stand together": (
        88,
        """
        (define x 1)
        (define y 2)

        (define (f)
          3)

        (scene "a")
        """,
    ),
    "bodies of several forms": (
        88,
        """
        (define (f xs)
          (define (g x) (* x x))
          (when xs
            (print xs)
            (begin0
              (g 1)
              (print 2)))
          (map (lambda (i) (* i i)) xs))
        """,
    ),
    "definitions": (
        40,
        """
        (define total-height
          (+ (* num-shelves shelf-height) top))

        (define-values (first second third)
          (compute-three-things first second))

        (set! theta
          (+ theta (/ spacing growth) offset))
        """,
    ),
    "let": (
        40,
        """
        (let* ((spiral (call "domino_spiral"))
               (center (+ (center-of spiral)
                          (offset-of spiral))))
          (list spiral center))

        (let* ((an-extremely-long-variable
                 (f an-extremely-long-value)))
          (list spiral center))

        (let loop ((i 0))
          (loop (+ i 1)))
        """,
    ),
    "cond and case": (
        40,
        """
        (cond
          ((contains? missing i) (union))
          ((assoc x table) => second)
          ((contains? fallen something-long i)
           (call "stone"))
          (else
           (define stone (call "stone"))
           stone))

        (case x
          ((1 2 3) "small")
          (else "large"))
        """,
    ),
    "if": (
        40,
        """
        (f
          (if (and (> x 0) (< x width))
            (g x)
            (h x some-other-parameter height)))

        (define (k x)
          (if (> x 0)
            (f x)
            (g x)))
        """,
    ),
    "aligned operands": (
        40,
        """
        (or (contains? (list 0 (- num-x 1)) i)
            (contains? (list 0 (- num-z 1)) j))

        (+ (* 0.5 some-long-name another-name)
           offset another-offset)
        """,
    ),
    "applications": (
        40,
        """
        (union
          background
          (call "robot_arm" :yaw yaw :reach r)
          cube)

        (push! layers
          (transform tiles (translate [x i 0])))

        (map (lambda (x) (+ x (* 2 x) x))
             (filter positive? xs))

        (union-loop (+ num-shelves 1)
          (lambda (i)
            (transform (call "shelf_board")
                       (translate [0 i 0]))))
        """,
    ),
    "loops": (
        40,
        """
        (for/union ((x xs) (y ys))
          (call "thing" :x x :y y :key value))

        (for*/union ((x (range 1 20))
                     (y (range 1 20))
                     :when (even? (+ x y)))
          (call "thing" :x x :y y))

        (for/fold ((acc 0) (other (list)))
                  ((x xs) (y (range 10)))
          (list (+ acc x) y))
        """,
    ),
    "call": (
        60,
        """
        (call "cylinder" :color [0.25 0.25 0.28] :radius radius
          :p0 [x y (- z r)] :p1 [x y (+ z r)] :height height)

        (call "place_on_circle"
          :shape (call "trilithon" :height h :gap .35)
          :radius radius
          :angle a)

        (call "set-cuboid" :block-type "minecraft:brick_stairs"
          :scale [1 1 length])
        """,
    ),
    "transform": (
        50,
        """
        (transform (call "cube" :scale [0.5 0.06 0.16])
                   (translate [0 -0.17 0]))

        (transform
          (call "cube" :color color :scale [0.5 0.06])
          (translate [0 -0.17 0]))

        (transform
          (union
            (call "link" :p0 shoulder-p :p1 elbow-p)
            (call "link" :p0 elbow-p :p1 wrist-p))
          (rotate yaw [0 1 0]))

        (transform row
          (translate [(+ (/ width 2) 0.01) shelf 0.3]))
        """,
    ),
    "data": (
        40,
        """
        '((.6 .12 .12) (.12 .25 .5) (.1 .4 .25)
          (.2 .2 .22) (.7 .35 .15) (.5 .3 .2))

        `((0.0 1.1 1.5 ,wide #f 0)
          (,start-yaw ,reach ,high ,wide #f 8))

        (list 2 3 5 7 11 13 17 19 23 29 31 37 41
              43 47)

        [0.125 0.25 0.375 0.5 0.625 0.75 0.875
         1.0]

        '(alpha beta gamma delta epsilon zeta
          . eta)
        """,
    ),
    "table": (
        40,
        """
        (table
          0 '()
          1 '((0 0))
          2 '((-1 1) (1 -1))
          "another" [1 2 3])
        """,
    ),
    "macros": (
        60,
        """
        (define-syntax swap!
          (syntax-rules ()
            ((_ a b)
             (let ((tmp a))
               (set! a b)
               (set! b tmp)))))

        (define-macro (my-unless test . body)
          `(if ,test none (begin ,@body)))
        """,
    ),
    "parameters": (
        40,
        """
        (define (f a b (c 12) :key
                   (:other [1 2 3]) :further)
          a)

        (lambda (:a :b (:width 0.5) (:height 1)
                 :thickness)
          (union))
        """,
    ),
}


@pytest.mark.parametrize("name", STYLE)
@pytest.mark.sampled(2)
def test_style(name: str) -> None:
    width, text = STYLE[name]
    wanted = dedent(text).strip() + "\n"
    assert laid_out(" ".join(wanted.split()), width) == wanted


# --- comments ------------------------------------------------------------------------------------------------------


def rows(texts: Iterable[str | None]) -> tuple[Row, ...]:
    return tuple(None if text is None else line_comment(text) for text in texts)


def around(
    before: Iterable[str | None] = (), after: str | None = None, blank: bool = False, end: Iterable[str | None] = ()
) -> Trivia:
    """Trivia with comments given without ``; ``."""
    return Trivia(rows(before), line_comment(after) if after else None, blank, rows(end))


def found(forms: Iterable[Datum], text: str) -> Datum:
    """The datum with this text."""
    return next(datum for datum in walk(*forms) if datum.span.text == text)


def commented(text: str, trivia: dict[str, Trivia], width: int = 88) -> str:
    forms = forms_of(text)
    return layout(
        forms, indents=INDENTS, trivia={id(found(forms, key)): value for key, value in trivia.items()}, width=width
    )


def test_comments_above_and_empty_lines() -> None:
    text = '(define (f x) (define y 1) (+ x y)) (scene "a")'
    trivia = {
        "(define (f x) (define y 1) (+ x y))": around(before=("title", None, "one", "", "two")),
        "(+ x y)": around(before=("the sum",), blank=True),
        '(scene "a")': around(),
    }
    wanted = """\
; title

; one
;
; two
(define (f x)
  (define y 1)

  ; the sum
  (+ x y))

(scene "a")
"""
    assert commented(text, trivia) == wanted


def test_comment_at_the_end_moves_behind_the_parentheses() -> None:
    assert commented("(f (g (list a b)))", {"b": around(after="28 tiles")}) == "(f (g (list a b)))  ; 28 tiles\n"
    trivia = {"b": around(after="one"), "(g (list a b))": around(after="two")}
    assert commented("(f (g (list a b)))", trivia) == "(f (g (list a b)))  ; one; two\n"
    assert commented("(list a b)", {"a": around(after="one")}) == "(list a  ; one\n      b)\n"


def test_comments_at_the_ends_of_neighboring_lines_are_aligned() -> None:
    text = "(let () (define inner 1) (define longer 2) (define z 3))"
    trivia = {"(define inner 1)": around(after="a"), "(define longer 2)": around(after="b")}
    assert commented(text, trivia) == "(let ()\n  (define inner 1)   ; a\n  (define longer 2)  ; b\n  (define z 3))\n"


def test_comments_before_the_closing_parenthesis() -> None:
    assert commented("(f a)", {"(f a)": around(end=("no more",))}) == "(f a\n  ; no more\n)\n"
    assert commented("()", {"()": around(end=("empty",))}) == "(\n ; empty\n)\n"


def test_comments_among_bindings() -> None:
    text = "(let* ((a 1) (b 2)) b)"
    assert commented(text, {"(b 2)": around(before=("why",))}) == "(let* ((a 1)\n       ; why\n       (b 2))\n  b)\n"


def test_comments_within_quotes() -> None:
    assert commented("'(a b)", {"b": around(before=("c",))}) == "'(a\n  ; c\n  b)\n"
    assert commented("(quote a)", {"a": around(before=("c",))}) == "(quote\n  ; c\n  a)\n"


def test_comments_after_the_last_form() -> None:
    assert layout(forms_of("x"), indents={}, end=(None, "; end")) == "x\n\n; end\n"
    assert layout((), indents={}) == ""


# --- properties ----------------------------------------------------------------------------------------------------

symbols = st.sampled_from([*INDENTS, "call", "table", "transform", "union", "+", "f", "x", "=>", "else", "_"])
values = st.one_of(
    symbols.map(Symbol),
    st.sampled_from(["key", "p0", "p1"]).map(Keyword),
    st.just("z1").map(Handle),
    st.integers(-(10**20), 10**20),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(alphabet='ab ;()"\\\né', max_size=12),
    st.sampled_from([True, False, None]),
)


def compound(inner: st.SearchStrategy[Datum]) -> st.SearchStrategy[Datum]:
    lists = st.lists(inner, max_size=6).map(lambda items: ListDatum(tuple(items), None, NOWHERE))
    forms = st.tuples(symbols, st.lists(inner, max_size=5)).map(
        lambda parts: ListDatum((Atom(Symbol(parts[0]), NOWHERE), *parts[1]), None, NOWHERE)
    )
    dotted = st.tuples(st.lists(inner, min_size=1, max_size=3), inner.filter(lambda d: not isinstance(d, ListDatum)))
    pairs = dotted.map(lambda parts: ListDatum(tuple(parts[0]), parts[1], NOWHERE))
    arrays = st.lists(inner, max_size=4).map(lambda items: ArrayDatum(tuple(items), NOWHERE))
    quotes = st.tuples(st.sampled_from(["quote", "quasiquote", "unquote", "unquote-splicing"]), inner).map(
        lambda pair: ListDatum((Atom(Symbol(pair[0]), NOWHERE), pair[1]), None, NOWHERE)
    )
    return st.one_of(lists, forms, forms, pairs, arrays, quotes)


datums = st.recursive(values.map(lambda value: Atom(value, NOWHERE)), compound, max_leaves=30)
programs = st.lists(datums, max_size=3)


@settings(max_examples=many(200), deadline=None)
@given(programs, st.integers(20, 100))
def test_what_is_laid_out_reads_back_equal_and_stays(forms: list[Datum], width: int) -> None:
    text = layout(forms, indents=INDENTS, width=width)
    again = forms_of(text)
    assert [shape(form) for form in again] == [shape(form) for form in forms]
    assert layout(again, indents=INDENTS, width=width) == text
    assert all(line == line.rstrip() for line in text.splitlines())


def comments_in_order(forms: Iterable[Datum], trivia: dict[int, Trivia]) -> list[str]:
    out: list[Row] = []
    for form in forms:
        around = trivia.get(id(form), Trivia())
        out += around.before
        if not isinstance(form, Atom):
            tail = form.tail if isinstance(form, ListDatum) else None
            out += comments_in_order([*form.items, *([tail] if tail is not None else [])], trivia)
            out += around.end
        out.append(around.after)
    return [text.lstrip("; ") for text in out if isinstance(text, str) and text.strip("; ")]


@settings(max_examples=many(200), deadline=None)
@given(programs, st.integers(20, 100), st.data())
def test_comments_are_kept_in_order(forms: list[Datum], width: int, data: st.DataObject) -> None:
    parts = list(walk(*forms))
    trivia = {}
    for number in data.draw(st.lists(st.integers(0, len(parts) - 1), max_size=6)) if parts else []:
        trivia[id(parts[number])] = around(
            before=tuple(data.draw(st.lists(st.sampled_from([f"b{number}.", "", None]), max_size=2))),
            after=data.draw(st.sampled_from([None, f"a{number}."])),
            blank=data.draw(st.booleans()),
            end=() if isinstance(parts[number], Atom) else tuple(data.draw(st.sampled_from([(), (f"e{number}.",)]))),
        )
    text = layout(forms, indents=INDENTS, trivia=trivia, width=width)
    assert [shape(form) for form in forms_of(text)] == [shape(form) for form in forms]
    said = " ".join(span.text.lstrip(";").replace(";", " ") for span in read_comments(Source("<test>", text)))
    assert said.split() == comments_in_order(forms, trivia)


# --- programs ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("program", CORPUS, ids=lambda path: path.stem)
def test_programs_written_by_hand(program: Path) -> None:
    forms = forms_of(program.read_text())
    spelling = spelling_of(forms)
    text = layout(forms, indents=INDENTS, spelling=spelling)
    again = forms_of(text)
    assert [shape(form) for form in again] == [shape(form) for form in forms]
    assert layout(again, indents=INDENTS, spelling=spelling_of(again)) == text
    assert max(len(line) for line in text.splitlines() if " " in line.strip()) <= 100
    assert len(text.splitlines()) < 1.2 * len(program.read_text().splitlines())


def deep_and_wide(count: int) -> tuple[list[Datum], dict[int, Trivia]]:
    """A list of that depth with a comment at the bottom, and one of five times that length."""
    deep: Datum = Atom(Symbol("deepest"), NOWHERE)
    trivia = {id(deep): around(before=("at the bottom",))}
    for _ in range(count):
        deep = ListDatum((Atom(Symbol("f"), NOWHERE), deep), None, NOWHERE)
    wide = ListDatum(tuple(Atom(i, NOWHERE) for i in range(5 * count)), None, NOWHERE)
    return [deep, wide], trivia


def test_deep_and_wide_datums() -> None:
    """Nesting is no danger to the stack; no comment is lost."""
    forms, trivia = deep_and_wide(4_000)
    text = layout(forms, indents=INDENTS, trivia=trivia)
    assert "; at the bottom" in text
    assert len(list(walk(*forms_of(text)))) == len(list(walk(*forms)))


def test_twice_the_datums_take_twice_the_calls() -> None:
    def work(count: int) -> int:
        forms, trivia = deep_and_wide(count)
        return calls(lambda: layout(forms, indents=INDENTS, trivia=trivia))

    work(1)  # what is made once
    few, many = work(400), work(800)
    assert many < 2.3 * few


@pytest.mark.parametrize(
    "opening",
    ["(f ", "(f x ", '(call "a" :key ', "(let ((a ", "(define (f x) ", "(+ ", "(list x (", "[", "'(", "(cond ("],
)
def test_nesting_is_no_danger_to_the_stack(opening: str) -> None:
    closing = ")" * (opening.count("(") - opening.count(")")) + "]" * opening.count("[")
    text = opening * 300 + "x" + closing * 300
    assert print_datum(forms_of(laid_out(text))[0]) == print_datum(forms_of(text)[0])
