"""Names may be defined anew: earlier functions see it, nothing shared goes stale, and what fails leaves nothing."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.values.limits import Limits
from scenelang.repl.evaluation import ReplEvaluation, checked_program, program_text
from scenelang.session.session import Options, Session


def repl(**options: object) -> ReplEvaluation:
    return ReplEvaluation(Session(Options(**options)))  # type: ignore[arg-type]


def say(evaluation: ReplEvaluation, *inputs: str) -> str:
    """The values of the last input, or the names of its errors."""
    for text in inputs:
        outcome = evaluation.evaluate(evaluation.source(text))
    errors = [d.name for d in outcome.diagnostics if d.is_error]
    return " ".join(errors or [show(value, 200) for value in outcome.values])


REDEFINITIONS = [
    ("a function", ["(define (f x) (* x 2))", "(define (g) (f 10))", "(define (f x) (* x 3))", "(g)"], "30"),
    ("a value", ["(define k 1)", "(define (g) k)", "(define k 2)", "(g)"], "2"),
    ("a builtin", ["(define (g) (length '(1 2)))", "(g)", "(define (length x) 42)", "(g)"], "42"),
    ("a combinator", ["(define (g) (row 1))", "(define (row x) 5)", "(g)"], "5"),
    ("the paper's union", ["(define (g) (union 1 2))", "(define (union . x) x)", "(g)"], "(1 2)"),
    ("a macro", [
        "(define-syntax m (syntax-rules () ((_ x) (* 2 x))))", "(define (g) (m 10))",
        "(define-syntax m (syntax-rules () ((_ x) (* 20 x))))", "(g)",
    ], "200"),
    ("a macro's helper", [
        "(define-macro (m x) `(* 2 ,x))", "(define-macro (n x) `(m ,x))", "(define (g) (n 10))",
        "(define-macro (m x) `(* 20 ,x))", "(g)",
    ], "200"),
    ("a macro becomes a function", ["(define-macro (m x) 1)", "(define (g) (m 5))", "(define (m x) x)", "(g)"], "5"),
    ("a record", ["(define-record pt x)", "(define (g) (pt 1))", "(define-record pt x (y 7))", "(pt-y (g))"], "7"),
    ("mutual recursion", [
        "(define (ev n) (if (= n 0) #t (od (- n 1)))) (define (od n) (if (= n 0) #f (ev (- n 1))))", "(ev 100)",
    ], "#t"),
    ("a word", [
        '(bind "leg" (lambda () (call "cube")))', '(bind "table" (lambda () (call "leg")))', '(call "table")',
        '(bind "leg" (lambda () (call "cube" :scale 3)))', '(compute-shape-sizes (call "table"))',
    ], "[3.0 3.0 3.0]"),
]  # fmt: skip


@pytest.mark.parametrize("use", ["(pt-x p)", "(set-pt-x! p 2)"])
def test_a_record_of_an_old_definition_is_told_as_one(use: str) -> None:
    evaluation = repl()
    say(evaluation, "(define-record pt x)", "(define p (pt 1))", "(define-record pt x)")
    (problem,) = evaluation.evaluate(evaluation.source(use)).diagnostics
    assert problem.hint == "the record type was redefined; this value belongs to the old definition"
    (other,) = evaluation.evaluate(evaluation.source("(pt-x 5)")).diagnostics
    assert other.name == problem.name == "type"
    assert other.hint is None


@pytest.mark.parametrize(("inputs", "value"), [case[1:] for case in REDEFINITIONS], ids=[c[0] for c in REDEFINITIONS])
def test_earlier_functions_see_the_new_definition(inputs: list[str], value: str) -> None:
    assert say(repl(), *inputs) == value


SIZE = '(compute-shape-sizes (call "a"))'
CHANGES = [
    ("a variable", "(define k 1)", "k", "(define k 2)"),
    ("an assignment", "(define k 1)", "k", "(set! k 2)"),
    ("a function", "(define (k) 1)", "(k)", "(define (k) 2)"),
    ("a function behind a function", "(define (k) 1) (define (l) (k))", "(l)", "(define (k) 2)"),
    ("a table", "(define t (table 'k 1))", "(ref t 'k)", "(set-ref! t 'k 2)"),
    ("a macro", "(define-macro (k) 1)", "(k)", "(define-macro (k) 2)"),
    ("a builtin", "", "(max 1 1)", "(define (max a b) 2)"),
    ("a function kept in a value", "(define k 1) (define l (list (lambda () k)))", "((car l))", "(define k 2)"),
    ("a word behind a word", '(bind "b" (lambda () (call "cube")))', '(first (compute-shape-sizes (call "b")))',
     '(bind "b" (lambda () (call "cube" :scale 2)))'),
]  # fmt: skip


@pytest.mark.parametrize(("before", "size", "change"), [case[1:] for case in CHANGES], ids=[c[0] for c in CHANGES])
def test_shared_calls_do_not_go_stale(before: str, size: str, change: str) -> None:
    evaluation = repl()
    bind = f'(bind "a" (lambda () (call "cube" :scale {size})))'
    outer = '(bind "outer" (lambda () (call "a")))'
    assert say(evaluation, before, bind, outer, '(call "outer")', SIZE) == "[1.0 1.0 1.0]"
    assert say(evaluation, change, SIZE) == "[2.0 2.0 2.0]"
    assert say(evaluation, '(compute-shape-sizes (call "outer"))') == "[2.0 2.0 2.0]"


def test_a_call_is_still_shared_between_inputs() -> None:
    evaluation = repl()
    say(evaluation, '(bind "a" (lambda () (print "made") (call "cube")))', '(call "a")')
    assert evaluation.evaluate(evaluation.source('(call "a") (call "a")')).log in ((), ("made",))


FAILURES = [
    ("(begin (push! l 3) (error \"no\"))", "l", "(mutable-list 1 2)"),
    ("(begin (set! k 9) (car 5))", "k", "1"),
    ("(begin (define k 9) (define new 1) (car 5))", "k", "1"),
    ("(begin (define k 9) (define new 1) (car 5))", "new", "unbound"),
    ("(define k (car 5))", "k", "1"),
    ("(define new (car 5))", "new", "unbound"),
    ("(define (f) undefined-name)", "(f)", "7"),
    ("(define-record pt a (b (undefined-name)))", "(f)", "7"),
    ("(begin (set-ref! t 'a 2) (raise 5))", "(ref t 'a)", "1"),
    ('(begin (bind "w" (lambda () (call "sphere"))) (car 5))', '(entity-word (car (car (cdr (call "w")))))', '"cube"'),
    ("(begin (random) (car 5))", "(begin (set! r (random)) (= r 0.5488135039273248))", "#t"),
    ("(begin (set! k 3) (while #t 1))", "k", "1"),
]  # fmt: skip


@pytest.mark.parametrize(("failing", "form", "value"), FAILURES)
def test_a_failing_form_leaves_everything_as_it_was(failing: str, form: str, value: str) -> None:
    evaluation = repl(limits=Limits(steps=100_000))
    say(evaluation, "(define l (mutable-list 1 2)) (define k 1) (define (f) 7) (define t (table 'a 1)) (define r 0)")
    say(evaluation, '(bind "w" (lambda () (call "cube")))')
    error = say(evaluation, failing)
    assert error
    assert not error.startswith(("(", "["))
    assert say(evaluation, form) == value


def test_forms_before_the_failing_one_stay() -> None:
    evaluation = repl()
    assert say(evaluation, "(define a 1) (define b (car 5)) (define c 3)") == "type"
    assert [say(evaluation, name) for name in "abc"] == ["1", "unbound", "unbound"]


def test_limits_begin_anew_with_every_input() -> None:
    evaluation = repl(limits=Limits(steps=200_000))
    work = "(for/sum ((i (iota 20000))) i)"
    for _ in range(20):
        assert say(evaluation, work) == "199990000"
    assert say(evaluation, "(while #t 1)") == "steps"
    assert say(evaluation, "(define (loop) (loop))", "(loop)") == "steps"
    assert say(evaluation, work) == "199990000"


def test_time_is_limited_anew() -> None:
    evaluation = repl(limits=Limits(steps=10**12, seconds=0.3))
    for _ in range(2):
        assert say(evaluation, "(while #t 1)") == "time"


def test_a_recursion_without_end_is_an_error() -> None:
    assert say(repl(limits=Limits(depth=2_000)), "(define (f n) (+ 1 (f n)))", "(f 1)") == "depth"


def test_the_last_values_and_the_last_error() -> None:
    evaluation = repl()
    say(evaluation, "1 2 3")
    assert say(evaluation, "(list *1 *2 *3)") == "(3 2 1)"
    say(evaluation, "(car 5)")
    assert say(evaluation, "(error-code *e)").startswith('"E')
    assert "car" in say(evaluation, "(error-message *e)")
    assert say(evaluation, "(error-place *e)") == '"<repl 3>:1:1"'


def test_random_streams_go_on_and_begin_anew() -> None:
    evaluation = repl()
    first = [say(evaluation, "(random)") for _ in range(3)]
    assert len(set(first)) == 3
    evaluation.set_seed(0)
    assert [say(evaluation, "(random)") for _ in range(3)] == first


def test_the_root_is_what_a_run_gives(tmp_path: Path) -> None:
    text = '(bind "a" (lambda () (call "cube" :scale (uniform 1 2))))\n'
    evaluation = repl(seed=5)
    say(evaluation, "(random)", text)
    path = tmp_path / "a.scene"
    path.write_text(text)
    session = Session(Options(seed=5))
    expected = session.evaluate(session.source(str(path))).scene
    assert expected is not None
    size = lambda scene: scene.root.children[0].car.embedding.attributes["scale"]
    before = say(evaluation, "(random)")
    assert size(evaluation.root()) == size(expected)
    assert say(evaluation, "(random)") != before


# --- files ---------------------------------------------------------------------------------------------------------


def test_importing_again_takes_the_changed_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    inner, outer = tmp_path / "inner.scene", tmp_path / "outer.scene"
    inner.write_text("(define (size) 1)\n(define-macro (twice x) `(* 2 ,x))")
    outer.write_text('(import "inner.scene")\n(bind "leg" (lambda () (call "cube" :scale (size))))')
    evaluation = repl()
    say(evaluation, '(import "outer.scene")', '(import "inner.scene")', "(define (mine) (+ (twice 10) (size)))")
    leg = '(first (compute-shape-sizes (call "leg")))'
    assert say(evaluation, "(mine)", leg) == "1.0"
    assert say(evaluation, "(mine)") == "21"
    inner.write_text("(define (size) 4)\n(define-macro (twice x) `(* 3 ,x))")
    assert say(evaluation, '(import "outer.scene")', leg) == "4.0"
    assert say(evaluation, '(import "inner.scene")', "(mine)") == "34"


def test_a_broken_import_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "a.scene"
    path.write_text("(define (size) 1)")
    evaluation = repl()
    say(evaluation, '(import "a.scene")', "(define (g) (size))")
    path.write_text("(define (size) (oops))")
    assert say(evaluation, '(import "a.scene")') == "unbound"
    assert say(evaluation, "(g)") == "1"


def test_reloading_forgets_what_is_gone(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    path.write_text('(define (f) (g)) (define (g) 1) (define old 1) (bind "w" (lambda () (call "cube")))')
    evaluation = ReplEvaluation(Session(), str(path))
    assert evaluation.load(str(path)).ok
    say(evaluation, "(define (mine) (f))")
    path.write_text("(define (f) (g)) (define (g) 2)")
    assert evaluation.reload(str(path)).ok
    assert say(evaluation, "(mine)") == "2"
    assert say(evaluation, "old") == "unbound"
    assert say(evaluation, '(bound? "w")') == "#f"


SAVED = [
    ["(define (f) 1)", "(define (g) (f))", "(define (f) 2)"],
    ["(define k 1)", "(define y (+ k 1))", "(define k 5)"],
    ["(define k 1)", "(set! k 3)", "(define y k)"],
    ["(define t (mutable-list))", "(push! t 4)", "(define y (length t))"],
    ["(random)", "(define y (random))"],
    ["(define-record pt x)", "(define p (pt 1))", "(define y (pt-x p))"],
    ["; above", "(define y 1)  ; after"],
    ["(define a 1)", "(define y (list a))", "(define a 2)", "(define a 3)", "(define k a)"],
    ['(param n 3 "number")', "(define (g) n)", '(param n 5 "number")', "(define y (g))"],
]


@pytest.mark.parametrize("inputs", SAVED)
def test_what_is_saved_loads_again_and_gives_the_same(inputs: list[str]) -> None:
    evaluation = repl()
    say(evaluation, *inputs, '(bind "s" (lambda () (call "cube" :k (list (if (bound? "none") 1 2)))))')
    names = [name for name, _ in evaluation.top.names() if name in ("y", "k")]
    values = [say(evaluation, name) for name in names]
    text = checked_program(evaluation.session, evaluation.top, "saved.scene")
    again = repl()
    assert again.evaluate(again.source(text)).ok
    assert [say(again, name) for name in names] == values
    assert program_text(again.top) == text


@pytest.mark.parametrize(
    "inputs",
    [
        ["(define-macro (m) 1)", "(define b (m))", "(define (h) (m))", "(define-macro (m) 2)"],
        ["(define (f) 1)", "(define b (f))", "(define (f) 2)"],
        ["(define (f) 1)", "(define (g) (f))", "(define b (g))", "(define (f) 2)"],
        ['(param n 3 "number")', "(define b (list n))", '(param n 5 "number")'],
    ],
)
def test_a_value_that_a_program_cannot_give_is_not_saved(inputs: list[str]) -> None:
    evaluation = repl()
    say(evaluation, *inputs)
    with pytest.raises(SceneError, match=r"`b` is .* here, but .* in a saved program"):
        checked_program(evaluation.session, evaluation.top, "saved.scene")
    say(evaluation, "(define b 7)")
    assert "(define b 7)" in checked_program(evaluation.session, evaluation.top, "saved.scene")


def test_what_was_only_looked_at_is_not_saved() -> None:
    evaluation = repl()
    say(evaluation, "(define k 1)", "(+ k 1)", "(random)", '(call "cube")')
    assert program_text(evaluation.top) == "(define k 1)\n"


# --- sharing, against a session that shares nothing ------------------------------------------------------------------

_SIZES = (
    "k",
    "(f)",
    "(g 2)",
    "(m)",
    "(ref t 'k)",
    "(length xs)",
    '(first (compute-shape-sizes (call "{}")))',
    "(random)",
)
_CHANGES = (
    "(define k {})", "(set! k {})", "(define (f) {})", "(define (f) k)", "(define (g n) (* n {}))", "(define (g n) (f))",
    "(define-macro (m) {})", "(define-macro (m) '(f))", "(set-ref! t 'k {})", "(define t (table 'k {}))", "(push! xs {})",
    "(define (length x) {})", "(begin (set! k {}) (car 5))", "(begin (push! xs {}) (error))",
)  # fmt: skip


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.sampled(8)
def test_sharing_changes_no_value(seed: int) -> None:
    sharing, plain = repl(), repl()
    plain.top.rt._memoize = False
    draw = random.Random(seed)
    inputs = ["(define k 1) (define (f) k) (define (g n) n) (define-macro (m) 1) (define t (table 'k 1))"]
    inputs.append("(define xs (mutable-list 1))")
    inputs += [f'(bind "{word}" (lambda () (call "cube" :scale 1)))' for word in "abc"]
    for _ in range(40):
        kind = draw.randrange(3)
        if kind == 0:
            inputs.append(draw.choice(_CHANGES).format(draw.randint(1, 9)))
        elif kind == 1:
            word = draw.choice("bc")
            size = draw.choice(_SIZES).format("abc"["abc".index(word) - 1])
            inputs.append(f'(bind "{word}" (lambda () (call "cube" :scale {size})))')
        else:
            inputs.append(f'(compute-shape-sizes (call "{draw.choice("abc")}"))')
    for text in inputs:
        assert say(sharing, text) == say(plain, text), inputs[: inputs.index(text) + 1]
