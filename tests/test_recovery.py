"""Where a missing or superfluous bracket was meant, and what is found behind it and behind other mistakes."""

from __future__ import annotations

import pytest

from scenelang import Session, Source
from scenelang.grammar import diagnostics
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.recovery import Recovered, bracket_edits, wrong_chunks
from scenelang.session.checking import Examination


def fixed(text: str, diagnostics: list[Diagnostic]) -> str:
    """A text with the first fix of every finding."""
    edits = {(e.span.start, e.span.end, e.text) for d in diagnostics for f in d.fixes[:1] for e in f.edits}
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def checked(text: str) -> list[Diagnostic]:
    return list(Examination(Session()).of(Source("a.scene", text)).diagnostics)


STOOL = """(bind "stool"
  (lambda ()
    (define top (call "cube" :scale [1 .1 1]))
    (define leg (call "cylinder" :radius (/ .2 2) :p1 [0 .5 0]))
    (union
      (transform top (translate [0 .5 0]))
      (for/union ((x (list -.4 .4)))
        (transform leg (translate [x 0 0]))))))

(scene "stool")
"""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[1 .1 1]))", "[1 .1 1])"),  # the next line shows it
        ("(list -.4 .4)))", "(list -.4 .4))"),
        ("(/ .2 2)", "(/ .2 2"),  # the arguments show it
        ("[0 .5 0]))\n      (for", "[0 .5 0])))\n      (for"),
        ("[0 .5 0]))\n    (union", "[0 .5 0]\n    (union"),  # two at once
        ("[x 0 0]", "[x 0 0"),
        ("[x 0 0]", "[x 0 0)"),
        ("[x 0 0]))))))", "[x 0 0])))))"),
        ("[x 0 0]))))))", "[x 0 0])))))))"),
        ('(scene "stool")', '(scene "stool"'),
        ("(lambda ()\n", "(lambda (\n"),
    ],
)
def test_the_bracket_is_found_where_it_was_meant(old: str, new: str) -> None:
    assert STOOL.count(old) == 1
    text = STOOL.replace(old, new)
    found = checked(text)
    assert {d.code[:3] for d in found if d.is_error} == {"E10"}
    assert fixed(text, found) == STOOL


def test_the_bracket_is_where_what_is_left_can_be_fixed() -> None:
    loop = '(union (call "ball") (for/union ((s sizes)) (call "cube" :scale s)))'
    before = "(define sizes '(1 2))\n"
    text = scene_of(loop.replace("sizes))", "sizes)").replace('(call "cube', '(cll "cube'), before)
    assert fixed(text, checked(text)) == scene_of(loop, before)


def test_the_bracket_is_where_a_point_has_three_numbers() -> None:
    part = '(place "box" [(* dx (+ radius 1)) (- level 1) (* dx (+ radius 1))])'
    text = scene_of(part.replace("radius 1)) (- level", "radius 1) (- level"))
    assert fixed(text, checked(text)) == scene_of(part)


def scene_of(body: str, before: str = "") -> str:
    return f"""{before}(define (place word position)
  (transform (call "cube" :label word) (translate position)))
(bind "a"
  (lambda (:radius :level)
    (for/union ((dx '(1 -1)))
      {body})))
(call "a" :radius 2 :level 1)
"""


@pytest.mark.parametrize("old", ['"stool"\n', '"cylinder"', '(scene "stool"'])
def test_a_string_is_closed_at_the_end_of_a_word(old: str) -> None:
    text = STOOL.replace(old, "".join(old.rsplit('"', 1)))
    assert fixed(text, checked(text)) == STOOL


@pytest.mark.parametrize("written", ["(translate [0 .5 0]) 1)", "(translate [0 .5 0] 0))"])
def test_what_is_too_much_is_left_out(written: str) -> None:
    extra = STOOL.replace("(translate [0 .5 0]))", written)
    assert fixed(extra, checked(extra)) == STOOL


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("(ref (list 1 2) 2)", "(ref (list 1 2) 1)"),
        ("(ref (list 1 2) (+ (% 3 2) 1))", "(ref (list 1 2) (% 3 2))"),
        ("(sum (list 1 2) 3 4)", "(sum (list 1 2))"),
        ("(rotate [0 1 0] 1)", "(rotate 1 [0 1 0])"),
    ],
)
def test_a_call_is_put_right(wrong: str, right: str) -> None:
    text = f'(define value {wrong})\n(bind "a" (lambda () (call "cube" :value value)))\n'
    found = Examination(Session(), run=True, complete=True).of(Source("a.scene", text)).diagnostics
    assert fixed(text, [d for d in found if d.is_error]) == text.replace(wrong, right)


def test_a_keyword_without_its_colon() -> None:
    text = '(bind "a" (lambda () (row (list (call "cube") (call "cube")) gap .5)))\n'
    assert fixed(text, checked(text)) == text.replace("gap", ":gap")


def test_the_hint_says_where() -> None:
    found = checked(STOOL.replace("[1 .1 1]))", "[1 .1 1])"))
    assert [d.hint for d in found] == ["add `)` at the end of line 3"]
    assert [d.fixes[0].safe for d in found] == [False]


def test_several_forms_and_what_is_behind_them() -> None:
    text = STOOL.replace("[1 .1 1]))", "[1 .1 1])").replace("translate [x", "tranlsate [x")
    text += '(bind "seat" (lambda () (call "cube" :scale [1 2 3)))\n'
    found = checked(text)
    assert [(d.code, d.span.text) for d in found if d.is_error and d.span is not None] == [
        ("E101", "("),
        ("E301", "tranlsate"),
        ("E102", ")"),
    ]
    assert not any(d.is_error for d in checked(fixed(text, found)))


@pytest.mark.parametrize(
    "text", [")", "(", "]", "((((", "(]", '("', "(a\n(b\n(c", "(a))\n(b))\n(c))\n(d))\n(e))\n(f))"]
)
def test_any_brackets(text: str) -> None:
    assert any(d.is_error for d in checked(text))


def test_places_lead_back_to_the_text_as_written() -> None:
    source = Source("a.scene", "(a (b c)\n")
    (chunk,) = wrong_chunks(source.text)
    for edit in bracket_edits(chunk):
        made = Recovered(source, source).edited(edit)
        assert wrong_chunks(made.source.text) == []
        assert made.source.text.count(")") == 2


# --- what other mistakes hide ----------------------------------------------------------------------------------------

SHELF = """(bind "plate" (lambda () (call "cube" :scale [2 .2 2])))
(bind "shelf"
  (lambda ()
    (union
      (transform (call "plate") (translate [0 .1 0]))
      (transform (call "cube") (translate [0 .9 0])))))
"""


def examined(text: str) -> list[Diagnostic]:
    asked = Examination(Session(), run=True, geometry=True, complete=True)
    return list(asked.of(Source("a.scene", text)).diagnostics)


def test_a_finding_about_the_scene_has_the_edit_that_resolves_it() -> None:
    (found,) = examined(SHELF)
    assert found.code == "W612"
    assert examined(fixed(SHELF, [found])) == []
    assert "[0 .7 0]" in fixed(SHELF, [found])


def test_a_finding_about_the_scene_shows_behind_an_error() -> None:
    text = SHELF.replace("translate [0 .1", "tranlsate [0 .1")
    found = examined(text)
    assert [d.code for d in found] == ["E301", "W612"]
    assert [d.span.text for d in found if d.span is not None] == ["tranlsate", '(call "cube")']
    assert examined(fixed(text, found)) == []


def test_a_thing_is_not_moved_because_of_another_mistake() -> None:
    """The plate is a box of another size while its word is misspelled."""
    text = SHELF.replace(".9", ".7").replace('(call "plate")', '(call "plaet")')
    found = examined(text)
    assert [d.code for d in found if d.fixes] == ["W605"]
    assert examined(fixed(text, found)) == []


def test_a_declaration_is_not_what_is_changed() -> None:
    text = '(bind "row" (lambda () (union-loop 4 (lambda (i) (transform (call "cube") (translate [i 0 0]))))))\n'
    text += '(assert-that (count "cube" 5))\n'
    (found,) = examined(text)
    assert found.code == "E612"
    assert fixed(text, [found]) == text.replace("union-loop 4", "union-loop 5")


def test_only_what_is_asked_for_is_looked_for() -> None:
    session = Session()
    assert Examination(session).of(Source("a.scene", SHELF)).diagnostics == ()
    (plain,) = Examination(session, geometry=True).of(Source("a.scene", SHELF)).diagnostics
    assert plain.fixes == ()


# --- findings that explain each other --------------------------------------------------------------------------------


def test_a_missing_function_gets_the_parameters_that_its_calls_pass() -> None:
    meant = """(bind "pond" (lambda (:radius :color) (call "sphere" :radius radius :color color)))
(bind "a" (lambda () (call "pond" :radius 2 :color [0 0 1])))
"""
    text = meant.replace("(lambda (:radius :color) ", "", 1).replace("color)))", "color))", 1)
    found = examined(text)
    assert [d.code for d in found] == ["E401"]
    assert fixed(text, found) == meant


def test_a_value_is_no_keyword_without_its_colon() -> None:
    written = '(bind "a" (lambda () (call "sphere" :radius radius :color [1 0 0])))\n'
    (found,) = (d for d in checked(written) if d.name == "unbound")
    assert found.hint is None or "colon" not in found.hint
    (found,) = (d for d in checked(written.replace(":radius radius", "metallic 1")) if d.name == "unbound")
    assert found.near == (":metallic",)


@pytest.mark.parametrize(
    ("written", "meant", "is_slip"),
    [
        ("cune", "cube", True), ("tube", "cube", False), ("sohere", "sphere", True), ("saphere", "sphere", False),
        ("pawwn", "pawn", True), ("pawn", "pawwn", False), ("lgihts", "lights", True), ("leg", "keg", False),
        ("wall-1", "wall-2", False), ("cube", "cube", False),
    ],
)  # fmt: skip
def test_a_slip_of_the_fingers(written: str, meant: str, is_slip: bool) -> None:
    assert diagnostics.is_typo(written, meant) is is_slip


def test_a_word_that_is_called_once_may_be_one_that_is_called_more_often() -> None:
    calls = '(bind "a" (lambda () (union (call "moai") (call "mpai") {})))\n'
    (found,) = checked(calls.format('(call "moai")'))
    assert (found.code, found.near) == ("W605", ("moai",))
    assert checked(calls.format("")) == []
    assert checked(calls.format('(call "moai")').replace("mpai", "moar")) == []
