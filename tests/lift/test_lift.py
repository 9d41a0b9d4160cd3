"""Lifting keeps the scene, shortens the program, and writes what a person would write."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import pytest
from sampling import one_in
from transpile.cases import CORPUS, IMITATIONS, Case

import scenelang
from lift.equality import scene_difference
from lift.searching import ShapePrograms, difference
from scenelang import Source
from scenelang.cli.main import main
from scenelang.grammar.reader import read
from scenelang.interpreter.lift.lift import lift_text
from scenelang.interpreter.lift.tree import expressions, node_of, size
from scenelang.session.session import Session

Command: TypeAlias = Callable[..., tuple[str, str]]
ROOT = Path(__file__).parent.parent.parent
SESSION = Session()
WRITTEN = sorted([*ROOT.glob("examples/*.scene"), *ROOT.glob("tests/corpus/*.scene")])
BETTER = re.compile(r"\((ring|grid|align|param)\s")


def lifted(text: str) -> str:
    return lift_text(Source("<test>", text), SESSION.library.names)


def nodes(text: str) -> int:
    return sum(size(node_of(form, {}, {})) for form in read(Source("<test>", text)).forms)


def check_lifted(text: str, name: str = "<test>") -> str:
    """Return the lifted program, after comparing it with the original."""
    found = lifted(text)
    before, after = SESSION.evaluate(Source(name, text)), SESSION.evaluate(Source(name, found))
    assert before.scene is not None
    assert after.scene is not None, [d.message for d in after.diagnostics]
    assert scene_difference(before.scene, after.scene) is None
    assert nodes(found) <= nodes(text)
    return found


@pytest.mark.parametrize("path", WRITTEN, ids=lambda path: path.stem)
@pytest.mark.sampled(3)
def test_written_programs_keep_their_scene(path: Path) -> None:
    found = check_lifted(path.read_text("utf-8"), str(path))
    assert lifted(found) == found


@pytest.mark.parametrize("case", [*CORPUS, *one_in(8, IMITATIONS)], ids=lambda case: case.name)
@pytest.mark.sampled(8)
def test_translated_programs_keep_their_scene(case: Case) -> None:
    literal = SESSION.transpile(Source(f"{case.name}.txt", case.text), literal=True).text
    found = check_lifted(literal)
    assert nodes(lifted(found)) == nodes(found)
    assert nodes(SESSION.transpile(Source(f"{case.name}.txt", case.text)).text) == nodes(found)


@pytest.mark.slow
def test_most_responses_use_a_combinator_or_a_param() -> None:
    texts = [SESSION.transpile(Source(f"{case.name}.txt", case.text)).text for case in CORPUS]
    assert sum(BETTER.search(text) is not None for text in texts) >= 2 * len(texts) / 3


@pytest.mark.parametrize("seed", range(50))
@pytest.mark.sampled(2)
def test_generated_programs_keep_their_scene(seed: int) -> None:
    assert difference(ShapePrograms(seed).program()) is None


# What each rule does to the body of a root.
RULES = {
    "a ring of parts that are turned": (
        """(union-loop 6 (lambda (i) (transform (transform (call "cube") (translate [0 1 3]))
                                      (rotate (/ (* i pi) 3) [0 1 0]))))""",
        """(ring 6 (transform (call "cube") (translate [0 1 0])) :radius 3)""",
    ),
    "a ring of parts that depend on the index": (
        """(for/union ((i (range 5))) (transform (call "cube" :scale (+ 1 i))
                                       (@ (rotate (* i (/ tau 5)) [0 1 0]) (translate [0 0 2]))))""",
        """(ring 5 (lambda (i) (call "cube" :scale (+ 1 i))) :radius 2)""",
    ),
    "a ring by sine and cosine": (
        """(union-loop 8 (lambda (i) (define a (/ (* 2 pi i) 8))
             (transform (call "sphere") (translate [(* 4 (sin a)) 0 (* 4 (cos a))]))))""",
        """(ring 8 (call "sphere") :radius 4 :turn #f)""",
    ),
    "a ring in the other direction": (
        """(union-loop 8 (lambda (i)
             (transform (call "sphere")
               (translate [(* 4 (cos (/ (* i pi) 4))) 0 (* 4 (sin (/ (* i pi) 4)))]))))""",
        """(ring 8 (call "sphere") :radius 4 :start (/ pi 2) :sweep (- tau) :turn #f)""",
    ),
    "a row of parts about the origin": (
        """(union-loop 4 (lambda (i) (transform (call "cube") (translate [(* (- i 1.5) 2) 0 0]))))""",
        """(grid (call "cube") :nx 4 :spacing 2)""",
    ),
    "an index that is divided": (
        """(union-loop 12 (lambda (k) (define-values (row col) (floor/ k 4))
             (transform (call "cube") (translate [col row (* row row)]))))""",
        """(for*/union ((row 3) (col 4)) (transform (call "cube") (translate [col row (* row row)])))""",
    ),
    "a grid over an index": (
        """(union-loop 6 (lambda (k) (define row (// k 3)) (define col (% k 3))
             (transform (call "cube" :scale (+ 1 row)) (translate [(* (- col 1) 2) 0 (- row .5)]))))""",
        """(grid (lambda (col _ row) (call "cube" :scale (+ 1 row))) :nx 3 :nz 2 :spacing [2 0 1])""",
    ),
    "the corners of a rectangle": (
        """(define leg (call "cylinder" :radius .1))
           (union (transform leg (translate [-1 0 -2])) (transform leg (translate [-1 0 2]))
                  (transform leg (translate [1 0 -2])) (transform leg (translate [1 0 2])))""",
        """(define leg (call "cylinder" :radius .1))
           (for*/union ((x '(-1 1)) (z '(-2 2))) (transform leg (translate [x 0 z])))""",
    ),
    "a table of what differs": (
        """(union (transform (call "cube" :color [1 0 0]) (translate [3 0 1]))
                  (transform (call "cube" :color [0 1 0]) (translate [4 0 1]))
                  (transform (call "cube" :color [0 0 1]) (translate [9 0 1]))
                  (transform (call "cube" :color [1 1 0]) (translate [2 0 1])))""",
        """(for/union (((color x) '(((1 0 0) 3) ((0 1 0) 4) ((0 0 1) 9) ((1 1 0) 2))))
             (transform (call "cube" :color color) (translate [x 0 1])))""",
    ),
    "poses of poses": (
        """(define part (transform (call "cube") (translate [1 0 0])))
           (transform (transform part (translate [0 2 0])) (rotate .5 [1 0 0]))""",
        """(transform (call "cube") (@ (rotate .5 [1 0 0]) (translate [1 2 0])))""",
    ),
    "a part that is used once": (
        """(define head (call "sphere")) (define body (call "cube")) (union body head)""",
        """(union (call "cube") (call "sphere"))""",
    ),
    "a function of a loop": (
        """(define (step i) (transform (call "cube") (translate [0 i i]))) (union-loop 3 step)""",
        """(union-loop 3 (lambda (i) (transform (call "cube") (translate [0 i i]))))""",
    ),
    "what nothing uses": (
        """(define unused (call "sphere")) (define (f x) x) (call "cube")""",
        """(call "cube")""",
    ),
    "a part that stands on another": (
        """(define base (call "cube")) (define top (call "sphere"))
           (define-values (_ high _) (compute-shape-max base)) (define-values (_ low _) (compute-shape-min top))
           (union base (transform top (translate [0 (- high low) 0])))""",
        """(define base (call "cube")) (union base (align (call "sphere") base :y :after))""",
    ),
    "a choice of two": (
        """(define n 3) (cond ((> n 2) (call "cube")) (else (call "sphere")))""",
        """(if (> n 2) (call "cube") (call "sphere"))""",
    ),
    "one coordinate of a box": (
        """(define base (call "cube")) (define-values (_ y _) (compute-shape-max base))
           (union base (transform base (translate [0 (+ y 1) 0])))""",
        """(define base (call "cube")) (union base (transform base (translate [0 (+ (y-of (compute-shape-max base)) 1) 0])))""",
    ),
}  # fmt: skip


def forms(text: str) -> list[str]:
    from scenelang.grammar.datum import print_datum

    return [print_datum(form) for form in read(Source("<test>", text)).forms]


@pytest.mark.parametrize("name", RULES)
def test_rules(name: str) -> None:
    before, after = RULES[name]
    found = check_lifted(f'(bind "root" (lambda () {before})) (scene "root")')
    found = re.sub(r"\(param \w+ \d+\)", "", found)
    assert forms(found) == forms(f'(bind "root" (lambda () {after})) (scene "root")')


# What must stay as it is.
UNCHANGED = {
    "draws keep their order": """(define a (call "cube" :scale (uniform 0 1))) (define b (call "cube" :scale (uniform 0 1)))
        (union b a)""",
    "a part that is read twice": '(define a (call "cube")) (union a (transform a (translate [1 0 0])))',
    "a variable that is assigned in between": """(define n 1) (define a (call "cube" :scale n)) (set! n 2)
        (union (call "sphere" :radius n) a)""",
    "a name that means something else where it is used": """(define w 2) (define a (call "cube" :scale w))
        (let ((w (uniform 0 1))) (union (call "sphere" :radius w) a))""",
    "parts of different kinds": '(union (call "cube") (call "sphere") (call "cone" :radius .5 :p1 [0 1 0]))',
    "a loop that reads what it changes": """(define x 0)
        (for/union ((i (range 3))) (set! x (+ x i)) (transform (call "cube") (translate [(* (- i 1) x) 0 0])))""",
    "an angle that is not linear": """(union-loop 4 (lambda (i) (transform (call "cube") (rotate (* i i) [0 1 0]))))""",
}


@pytest.mark.parametrize("name", UNCHANGED)
def test_what_stays(name: str) -> None:
    text = f'(bind "root" (lambda () {UNCHANGED[name]})) (scene "root")'
    found = check_lifted(text)
    assert "(ring" not in found
    assert "(grid" not in found


def test_draws_that_a_shadowed_name_hides() -> None:
    text = '(define (ring n x) (union x)) (bind "root" (lambda () (union-loop 6 (lambda (i) (transform (ring 2 (call "cube")) (rotate (/ (* i pi) 3) [0 1 0])))))) (scene "root")'
    assert "(ring 6" not in check_lifted(text)


def test_numbers_become_params() -> None:
    found = check_lifted(
        """; A wall.

        (define height 3)  ; in metres
        (bind "root" (lambda ((:width 4)) (define n 5) (define gone 6) (define unit (call "cube"))
          (union unit (transform unit (translate [width height n])) (transform unit (translate [n 0 0])))))
        (scene "root")"""
    )
    assert forms(found)[:3] == ["(param height 3)", "(param n 5)", "(param width 4)"]
    assert "; in metres" in found
    assert found.startswith("; A wall.")
    assert Session(scenelang.Options(defines={"width": "9"})).check(Source("<test>", found)).ok


def test_comments_stay() -> None:
    found = check_lifted(
        """; about the scene

        ; about the root
        (bind "root"
          (lambda ()
            ; the head
            (define top (call "sphere"))  ; round
            (define body (call "cube"))
            ; both
            (union body top)))
        (scene "root")  ; the end"""
    )
    for comment in ("; about the scene", "; about the root", "; the head", "; round", "; both", "; the end"):
        assert comment in found


def test_what_is_formatted_by_hand_stays() -> None:
    text = '(bind "root"\n  (lambda ()\n    ; fmt: off\n    (define   a (call "cube"))\n    (union a)))\n'
    assert lifted(text) == text


def test_macros_and_imports_stay() -> None:
    text = """(define-syntax two (syntax-rules () ((_ x) (union x x))))
        (bind "root" (lambda () (define a (call "cube")) (two a))) (scene "root")"""
    assert forms(lifted(text)) == forms(text)


@pytest.mark.parametrize(
    "make", [lambda n: "(" * n + ")" * n, lambda n: "(union " + "1 " * n + ")"], ids=["deep", "long"]
)
@pytest.mark.slow
def test_large_programs_are_left_alone(make: Callable[[int], str]) -> None:
    text = make(100_000) + "\n"
    assert lifted(text) == text


def test_api_and_errors() -> None:
    assert "(param n 2)" in scenelang.simplify('(define n 2) (bind "s" (lambda () (call "cube" :scale n))) (scene "s")')
    with pytest.raises(scenelang.SceneError, match="E101"):
        scenelang.simplify("(union")


# The commands.

TABLE = """(bind "table"
  (lambda ()
    (define top (call "cube" :scale [2 .1 1]))
    (define legs
      (union-loop 4
        (lambda (i)
          (transform (call "cylinder" :radius .1) (translate [i 0 0])))))
    (union legs (transform (transform top (translate [0 1 0])) (rotate .5 [0 1 0])))))

(scene "table")
"""


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    monkeypatch.chdir(tmp_path)
    Path("table.scene").write_text(TABLE)

    def run(*words: str, code: int = 0) -> tuple[str, str]:
        assert main(list(words)) == code
        return capsys.readouterr()

    return run


def test_lift_prints_the_changes(command: Command) -> None:
    out, _ = command("simplify", "table.scene")
    assert out.startswith("--- table.scene\n+++ table.scene (simplified)\n")
    assert "-    (define top" in out
    assert "(@ (rotate .5 [0 1 0]) (translate [0 1 0]))" in out
    assert Path("table.scene").read_text() == TABLE


def test_lift_writes_a_program(command: Command) -> None:
    assert command("simplify", "table.scene", "-o", "short.scene")[0] == ""
    assert command("diff", "table.scene", "short.scene")[0].startswith("equal")
    assert command("simplify", "short.scene")[0] == ""
    command("simplify", "table.scene", "-o", "table.scene")
    assert Path("table.scene").read_text() == Path("short.scene").read_text()


def test_lift_tells_mistakes(command: Command) -> None:
    Path("wrong.scene").write_text('(bind "a" (lambda () (call "cube" :scale size)))')
    Path("scene.py").write_text("x = 1\n")
    assert "E301" in command("simplify", "wrong.scene", code=1)[1]
    assert "`scenelang transpile` lifts what it translates" in command("simplify", "scene.py", code=1)[1]
    assert "there is no file" in command("simplify", "none.scene", code=1)[1]


def test_transpile_literally(command: Command) -> None:
    case = next(case for case in CORPUS if case.name == "t01-chessboard")
    Path("a.txt").write_text(case.text)
    literal, _ = command("transpile", "a.txt", "--literal")
    assert "(floor/ idx 8)" in literal
    lifted_text, _ = command("transpile", "a.txt")
    assert "(grid" in lifted_text
    assert nodes(lifted_text) < nodes(literal)


def test_the_test_of_a_loop_is_an_expression() -> None:
    (form,) = read(Source("a.scene", "(for/list ((x (range 5)) :when (flip) (y (rest xs))) (f x y))")).forms
    heads = [each.head for each in expressions(node_of(form, {}, {}))]
    assert [head for head in heads if head is not None] == ["for/list", "range", "flip", "rest", "f"]
