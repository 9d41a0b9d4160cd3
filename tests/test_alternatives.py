"""Fixes of errors that are tested by evaluating the program with them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from scenelang import Session, Source
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.repairs.alternatives import with_tested
from scenelang.session.checking import Examination
from scenelang.session.session import Evaluated

SESSION = Session()


def examined(text: str) -> list[Diagnostic]:
    return list(Examination(SESSION, run=True, complete=True).of(Source("a.scene", text)).diagnostics)


def fixed(text: str) -> str:
    """A text with the first fix of every finding."""
    edits = {(e.span.start, e.span.end, e.text) for d in examined(text) for f in d.fixes[:1] for e in f.edits}
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def scene(body: str, *before: str) -> str:
    return "\n".join((*before, f'(bind "a" (lambda () {body}))\n'))


def box(size: str) -> str:
    return f'(call "cube" :scale {size})'


@pytest.mark.parametrize(
    ("meant", "written"),
    [
        ("(extrude (car (list [[0 0] [1 0] [0 1]])) .2)", "(extrude .2 (car (list [[0 0] [1 0] [0 1]])))"),
        (box("(ref (list 1 2) (car (list 1)))"), box("(ref (car (list 1)) (list 1 2))")),
        (box("(list-ref (map + (list 1 2)) 1)"), box("(list-ref 1 (map + (list 1 2)))")),
    ],
)
def test_arguments_in_another_order(meant: str, written: str) -> None:
    assert fixed(scene(written)) == scene(meant)


def test_the_other_side_of_what_is_on_one() -> None:
    text = scene('(for/union ((x (list far (- far)))) (transform (call "cube") (translate [x 0 0])))', "(define far 3)")
    assert fixed(text.replace("(- far)", "(-)")) == text


PLACE = """(define-syntax place
  (syntax-rules (at turned)
    ((_ thing at p) (transform thing (translate p)))
    ((_ thing turned angle) (transform thing (rotate (deg angle) [0 1 0])))))"""


@pytest.mark.parametrize(
    ("meant", "written"),
    [
        ("(transform thing (translate p))", "(transform (translate p) thing)"),
        ("(deg angle)", "(deg)"),
        ("(rotate (deg angle) [0 1 0])", "(rotate [0 1 0] (deg angle))"),
        ("(rotate (deg angle) [0 1 0])", "(rotate (deg angle) 0 1 0)"),
        ("(rotate (deg angle) [0 1 0])", "(rotate (deg angle) [0 1 0 1])"),
    ],
)
def test_arguments_in_the_definition_of_a_macro(meant: str, written: str) -> None:
    body = "(union " + " ".join(f"(place {box('1')} {how})" for how in ("at [2 0 0]", "turned 30", "turned 60")) + ")"
    assert fixed(scene(body, PLACE.replace(meant, written))) == scene(body, PLACE)


def test_parentheses_around_what_is_passed_to_a_parameter() -> None:
    walls = '(bind "walls" (lambda (:width :height) (call "cube" :scale [width (- height 3) 1])))'
    body = '(call "walls" :width 11 :height 7)'
    wrong = walls.replace("[width (- height 3) 1]", "(width (- height 3) 1)")
    assert fixed(scene(body, wrong)) == scene(body, walls)


@pytest.mark.parametrize(
    ("meant", "written"),
    [
        (box("(color (car names))"), "'tomato'"),
        (f"(transform {box('1')} (translate [(car sizes) 0 (cadr sizes)]))", "((car sizes) 0 (cadr sizes))"),
        ('(call "wall" :height 2)', ":height=2"),
        ('(call "wall" :height (car sizes))', ":height=(car sizes)"),
        (box("(second (list [0 1 2] [1 2 3]))"), "[1 2 3 4]"),
        (f"(transform {box('1')} (translate (car (list [1 2 0]))))", "[1 2]"),
    ],
)
def test_notations_that_only_a_run_finds(meant: str, written: str) -> None:
    before = (
        '(define names (list "tomato" "orange"))',
        "(define sizes (list 1 2 3))",
        '(bind "wall" (lambda (:height) (call "cube" :scale [1 height 1])))',
    )
    text = scene(meant, *before)
    of = {"'tomato'": '"tomato"', ":height=2": ":height 2", ":height=(car sizes)": ":height (car sizes)",
          "((car sizes) 0 (cadr sizes))": "[(car sizes) 0 (cadr sizes)]", "[1 2 3 4]": "[1 2 3]", "[1 2]": "[1 2 0]"}  # fmt: skip
    assert text.count(of[written]) == 1
    assert fixed(text.replace(of[written], written)) == text


def test_a_part_beside_which_the_missing_one_stands() -> None:
    parts = '(define trunk (call "cube")) (define crown (call "sphere"))'
    text = scene("(union trunk (on-top-of crown trunk))", parts)
    assert fixed(text.replace("crown trunk)", "crown)")) == text


def test_a_pose_that_is_missing_is_none() -> None:
    text = scene(f"(union {box('1')} (transform {box('2')}))")
    assert fixed(text) == scene(f"(union {box('1')} {box('2')})")


def test_nothing_is_tested_while_brackets_are_wrong() -> None:
    text = scene(box("(side 2)"), "(define depth 3) (define (side width depth) [width 1 depth])")
    assert fixed(text) != text
    found = with_tested(Source("a.scene", text + "("), SESSION.evaluate(Source("a.scene", text + "(")).diagnostics,
                        lambda source: Evaluated(None, None, ()))  # fmt: skip
    assert not any(d.fixes for d in found if d.name == "arity")


def test_an_index_that_is_one_too_high() -> None:
    sizes = "(define sizes (list 1 2 3))"
    last = box("(ref sizes (- (length sizes) 1))")
    assert fixed(scene(last.replace("(length sizes)", "(+ (length sizes) 1)"), sizes)) == scene(last, sizes)
    loop = f"(for/union ((i 3)) {box('(ref sizes i)')})"
    assert fixed(scene(loop.replace("i 3", "i 4"), sizes)) == scene(loop, sizes)
    assert fixed(scene(loop.replace("i 3", "i 9"), sizes)) != scene(loop, sizes)  # nobody counts six too many
    keyed = "(define sizes (table 0 1 1 2))"
    loop = f"(for/union ((i 2)) {box('(ref sizes i)')})"
    assert fixed(scene(loop.replace("sizes i", "sizes (+ i 0 1)"), keyed)) != scene(loop, keyed)
    assert fixed(
        scene(loop.replace("((i 2)) (call", "((i (list 1))) (call").replace("i))", "(+ i 1)))"), keyed)
    ) == scene(loop.replace("((i 2)) (call", "((i (list 1))) (call"), keyed)


@pytest.mark.parametrize(
    ("meant", "missing", "before"),
    [
        (box("(side 2 depth)"), " depth", "(define depth 3) (define (side width depth) [width 1 depth])"),
        (f"(transform {box('1')} (rotate 1 [0 1 0]))", " [0 1 0]", ""),
        (f"(transform {box('1')} (rotate 1 [1 0 0]))", " [1 0 0]", "(define lying (rotate .5 [1 0 0]))"),
        ('(stand (call "b"))', ' (call "b")', '(define (stand part) part) (bind "b" (lambda () (call "cube")))'),
        ("(union (pair 1 .2) (pair 3 .2) (pair 5 .2))", " .2", f"(define (pair a b) {box('[a b 1]')})"),
        (box("[(+ (sin turn) (cos turn)) 1 (+ 3 turn)]"), " turn", "(define turn 1)"),
        (box("(vector 1 2 deep)"), " deep", "(define deep 3)"),
    ],
)
def test_a_missing_argument_that_the_program_tells(meant: str, missing: str, before: str) -> None:
    text = scene(meant, before)
    at = text.index(missing, text.index('(bind "a"'))
    written = text[:at] + text[at + len(missing) :]
    assert fixed(written) == text


@pytest.mark.parametrize(
    "written",
    [
        f"(transform {box('1')} (translate))",
        box("(color)"),
        f"(let ((x 1)) {box('[x (sin) 2]')})",  # that the variable is called as the parameter of `sin` says nothing
        f"(union (transform {box('1')} (translate [0 1 0])) (transform {box('2')} (translate)))",
        "(f 1 2)",
    ],
)
def test_nothing_is_invented(written: str) -> None:
    text = scene(written, '(define (f a b c) (call "cube" :scale [a b c]))' if "(f " in written else "")
    assert [d for d in examined(text) if d.is_error]
    assert fixed(text) == text


def test_a_candidate_with_another_error_is_no_fix() -> None:
    source = Source("a.scene", scene(f"(for/union ((i 4)) {box('(ref sizes i)')})", "(define sizes (list 1 2 3))"))
    found = [replace(d, fixes=()) for d in SESSION.evaluate(source).diagnostics]
    other = Diagnostic("type", "another error", found[0].span)
    tried: list[str] = []

    def evaluate(changed: Source) -> Evaluated:
        tried.append(changed.text)
        return Evaluated(None, None, (other,))

    assert with_tested(source, found, evaluate) == found
    assert source.text.replace("i 4", "i 3") in tried
    assert [len(d.fixes) for d in with_tested(source, [*found, other], evaluate)] == [
        1,
        0,
    ]  # the other was there before


def test_only_the_output_for_programs_tries() -> None:
    text = scene(f"(for/union ((i 4)) {box('(ref sizes i)')})", "(define sizes (list 1 2 3))")
    assert [len(d.fixes) for d in examined(text)] == [1]
    plain = Examination(SESSION, run=True).of(Source("a.scene", text)).diagnostics
    assert [d.fixes for d in plain if d.is_error] == [()]
