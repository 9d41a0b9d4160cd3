"""A version that is checked after an edit gives what a check from scratch gives, whatever the edit."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from searching import many

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import to_json
from scenelang.grammar.reader import split, split_again
from scenelang.session.editing import Editing
from scenelang.session.session import Session

EXAMPLES = Path(__file__).parents[2] / "examples"
PROGRAM = """\
; Everything that forms can depend on.
(define-record spot x (y 2))
(define-syntax twice
  (syntax-rules () ((_ body) (union body body))))
(define-macro (square n) `(* ,n ,n))
(define-macro (chance) (random))
(param size 2 "how large" :min 1 :max 9)
(define (half x) (/ x 2))
(define wide (square 3))
(define (area s::spot) (* (spot-x s) (spot-y s)))
(bind "leg" (lambda (:height (:tint [1 0 0])) (call "cylinder" :radius (half height))))
(bind "table" (lambda ((:height 1)) (twice (call "leg" :height height))))
(define row (list (call "leg" :height 1) (call "lge")))
(bind "hall" (lambda () (if #t (union (call "table") (chance)) (call "leg"))))
(scene "hall" size)
"""
INSERTS = ("(", ")", "[", "]", '"', " ", "\n", ";", "#|", "|#", "#;", "'", "x", "half", "3", "(define half 3)\n",
           "(define-syntax half (syntax-rules () ((_ x) x)))\n", '(bind "leg" 3)\n', "(square 2)", ":radius", "spot",
           "(import \"other.scene\")\n", '(scene "leg")\n', "(define-record spot a b)\n", "\n\n(")  # fmt: skip

session = Session()


@pytest.fixture(scope="module", autouse=True)
def _untried() -> Iterator[None]:
    """Macros that do no harm are expanded without a trial in a copy of this process first."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scenelang.sandbox.worker.trial", lambda work: None)
        yield


def told(source: Source, diagnostics: Any) -> list[Any]:
    return [to_json(d) for d in diagnostics]


def edited(text: str, chance: random.Random) -> str:
    """``text`` with one random change, as people and careless tools make them."""
    at = chance.randrange(len(text) + 1)
    kind = chance.randrange(6)
    if kind < 3:
        return text[:at] + chance.choice(INSERTS) + text[at:]
    if kind == 3:
        return text[:at] + text[at + chance.choice((1, 1, 2, 7, 40)) :]
    lines = text.splitlines(keepends=True)
    if not lines:
        return text
    a, b = chance.randrange(len(lines)), chance.randrange(len(lines))
    if kind == 4:
        lines[a], lines[b] = lines[b], lines[a]
    else:
        lines.insert(b, lines[a])
    return "".join(lines)


@settings(max_examples=many(60), deadline=None)
@example(seed=198)  # a literal that cannot be read, in a form with an unused parameter
@given(seed=st.integers(0, 1 << 30))
def test_edits_give_what_a_check_from_scratch_gives(seed: int) -> None:
    chance = random.Random(seed)
    editing, text = Editing(session), PROGRAM
    history = [text]
    for _ in range(6):
        source = Source("edited.scene", text)
        assert told(source, editing.check(source).diagnostics) == told(source, session.check(source).diagnostics), text
        text = chance.choice(history) if chance.random() < 0.2 else edited(text, chance)
        history.append(text)


@pytest.mark.parametrize("name", ["chessboard", "macros", "combinators"])
def test_edits_of_examples(name: str) -> None:
    chance = random.Random(name)
    path = EXAMPLES / f"{name}.scene"
    text = path.read_text("utf-8")
    editing = Editing(session)
    for _ in range(10):
        source = Source(str(path), text)
        assert told(source, editing.check(source).diagnostics) == told(source, session.check(source).diagnostics)
        text = edited(text, chance)


def test_only_changed_forms_are_analysed_again() -> None:
    lines = [
        f'(define (f{i} x) (+ x {i}))\n(bind "w{i}" (lambda () (call "cube" :scale (f{i} 1))))\n' for i in range(50)
    ]
    editing = Editing(session)
    first = editing.check(Source("a.scene", "".join(lines))).version
    lines[7] = lines[7].replace("(+ x 7)", "(* x 7)")
    second = editing.check(Source("a.scene", "".join(lines))).version
    assert first is not None
    assert second is not None
    known = {id(piece) for _, piece in first.pieces}
    fresh = [piece.text for _, piece in second.pieces if id(piece) not in known]
    assert fresh == ["(define (f7 x) (* x 7))"]
    forms = {id(form) for form in first.program.forms}
    assert len([form for form in second.program.forms if id(form) not in forms]) == 1


def test_a_macro_that_changes_is_expanded_anew_where_it_is_used() -> None:
    editing = Editing(session)
    text = "(define-syntax m (syntax-rules () ((_ x) x)))\n(define y 1)\n(define z (m y))\n"
    assert editing.check(Source("a.scene", text)).diagnostics == ()
    changed = text.replace("((_ x) x)", "((_ x) nowhere)")
    (problem,) = editing.check(Source("a.scene", changed)).diagnostics
    assert problem.message == "`nowhere` is not defined"
    assert editing.check(Source("a.scene", text)).diagnostics == ()


def test_other_open_files_count_as_they_are(tmp_path: Path) -> None:
    other = tmp_path / "other.scene"
    other.write_text("(define a 1)")
    main = Source(str(tmp_path / "main.scene"), '(import "other.scene")\n(print b)\n')
    texts = {}
    editing = Editing(session, texts)
    assert [d.name for d in editing.check(main).diagnostics] == ["unbound"]
    texts[other.resolve()] = "(define a 1) (define b 2)"
    assert editing.check(main).diagnostics == ()
    del texts[other.resolve()]
    assert [d.name for d in editing.check(main).diagnostics] == ["unbound"]


def test_several_mistakes_of_broken_text_are_found() -> None:
    text = '(define x 1))\n(bind "a" (lambda () (call "cube")\n\n(define z 3x)\n(nowhere)\n'
    found = [
        (d.code, d.span and d.span.source.position(d.span.start)[0])
        for d in session.check(Source("a", text)).diagnostics
    ]
    assert found == [("E102", 1), ("E101", 2), ("E103", 4)]


@settings(max_examples=many(150), deadline=None)
@given(seed=st.integers(0, 1 << 30))
def test_pieces_after_an_edit_are_those_of_the_text(seed: int) -> None:
    chance = random.Random(seed)
    before, chunks = PROGRAM, split(PROGRAM)
    for _ in range(12):
        text = edited(before, chance)
        chunks = split_again(text, before, chunks)
        assert chunks == split(text), (before, text)
        before = text
