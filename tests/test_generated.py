"""Hot code that is compiled to Python functions does what the closures do."""

from __future__ import annotations

from typing import Any

import pytest
from differential import HotPrograms, difference, published
from fuzz.scene_programs import Programs
from support import session

from scenelang import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.evaluation.evaluate import ProgramRun
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.values.limits import Limits
from scenelang.session.session import run_with_room

SESSION = session()


def run(text: str, hot: int | None = 1, depth: int = 100_000, **limits: Any) -> tuple[Any, Runtime]:
    """The value of the last form, and the runtime."""
    program = SESSION.check(Source("<test>", text)).program
    assert program is not None
    rt = Runtime(SESSION.library, Limits(**limits), hot=hot)
    run = ProgramRun(SESSION.library, rt)

    def go() -> Any:
        return [run.run_form(form) for form in program.forms][-1]

    return run_with_room(go, depth), rt


@pytest.mark.parametrize("first", range(0, 80, 20))
@pytest.mark.sampled(2)
def test_random_programs(first: int) -> None:
    for seed in range(first, first + 20):
        text = HotPrograms(seed).program() if seed % 4 else Programs(seed).program()
        assert difference(text, 1 + seed % 3) is None, f"seed {seed}"


def test_an_argument_without_a_value_is_told() -> None:
    """A loop has no value; its code was taken for the name of a variable."""
    assert difference(HotPrograms(8585).program(), 3) is None


@pytest.mark.parametrize("first", range(4))
@pytest.mark.sampled(2)
def test_published_programs(first: int) -> None:
    texts = [text for text in published() if len(text) < 20_000][first::20]
    assert [difference(text, 1) for text in texts] == [None] * len(texts)


def test_calls_with_a_literal_list_are_shared_by_both_ways() -> None:
    program = """(bind "a" (lambda (:width) (for/union ((x (list 0 4))) (call "post" :tags '(("axis" "y")) :scale 2))))
(bind "s" (lambda () (call "a" :width 5)))
(scene "s")"""
    assert difference(program, 1) is None


def test_recursion_60_000_deep() -> None:
    value, _ = run("(define (count n) (if (= n 0) 0 (+ 1 (count (- n 1))))) (count 3) (count 3) (count 60000)")
    assert value == 60_000
    mutual = "(define (even? n) (if (= n 0) #t (not (odd? (- n 1))))) (define (odd? n) (if (= n 0) #f (not (even? (- n 1)))))"
    assert run(f"{mutual} (even? 4) (even? 4) (even? 60000)")[0] is True


def test_tail_calls_need_no_stack() -> None:
    text = """
    (define (ping n) (if (= n 0) 'done (pong (- n 1))))
    (define (pong n) (let ((m n)) (cond ((< m 0) 1) (else (ping m)))))
    (define (count n other) (if (> n 0) (count (- n 1) other) n))
    (ping 5) (ping 5) (ping 50000)
    (count 3 1) (count 3 1) (count 50000 1)
    """
    assert run(text, depth=500)[0] == 0


def test_error_has_the_place_and_the_calls() -> None:
    text = "(define (f x) (+ 1 (g x))) (define (g x) (car (h x))) (define (h x) (if (> x 3) (car x) (list x)))"
    errors = []
    for hot in (None, 1):
        with pytest.raises(SceneError) as caught:
            run(f"{text} (for ((i 9)) (f i))", hot)
        error = caught.value
        assert error.span is not None
        errors.append((error.message, error.span.text, [(name, span.text) for name, span in error.chain if span]))
    assert errors[0] == errors[1]
    assert errors[1][1:] == ("(car x)", [("`h`", "(h x)"), ("`g`", "(g x)"), ("`f`", "(f i)")])


def test_step_limit_has_the_same_place() -> None:
    text = "(define (f x) (let loop ((i 0)) (g i) (loop (+ i 1)))) (define (g i) i) (f 1)"
    places = []
    for hot in (None, 1):
        with pytest.raises(SceneError) as caught:
            run(text, hot, steps=10_000)
        error = caught.value
        assert error.span is not None
        places.append((error.message, error.span.text, [name for name, _ in error.chain]))
    assert places[0] == places[1]


@pytest.mark.parametrize("depth", [30, 200, 2_000])
@pytest.mark.sampled(3)
def test_deep_code_stays_with_the_closures(depth: int) -> None:
    nested = "(if (> x 100) 0 (+ 1 " * depth + "x" + "))" * depth
    turns = min(depth, 500)
    loops = "(let l ((i 0)) (if (< i 1) (l (+ i 1)) " * turns + "x" + "))" * turns
    for body in (nested, loops):
        assert run(f"(define (f x) {body}) (f 1) (f 1) (f 1)")[0] == run(f"(define (f x) {body}) (f 1)", None)[0]


def test_no_text_of_a_program_enters_the_source(monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.interpreter.compile import generate

    sources: list[str] = []

    def recorded(source: str, *arguments: Any, **options: Any) -> Any:
        sources.append(source)
        return compile(source, *arguments, **options)

    monkeypatch.setattr(generate, "compile", recorded, raising=False)
    run('(define (secret hidden) (string-append "visible" hidden)) (secret "x") (secret "x") (secret "x")', 1)
    assert sources
    assert not any(word in source for source in sources for word in ("secret", "hidden", "visible"))


def test_integers_have_a_limit_in_loops() -> None:
    for text in (
        "(let loop ((i 0) (n 1)) (if (= i 100000) n (loop (+ i 1) (+ n n))))",
        "(let loop ((i 0) (n 3)) (if (= i 100000) n (loop (+ i 1) (* n n))))",
    ):
        with pytest.raises(SceneError) as caught:
            run(text)
        assert caught.value.name == "size"


def test_a_loop_that_is_entered_once_becomes_hot() -> None:
    """Bodies of ``for`` and ``while`` are replaced by generated code, which reports errors in the same places."""
    text = """
        (define xs (mutable (make-list 900 0)))
        (define (fill n)
          (for ((i (range n))) (set-ref! xs i (* 2 i)))
          (ref xs 899))
        (fill 900)
        (fill 901)"""
    program = SESSION.check(Source("<test>", text)).program
    assert program is not None
    runtime = Runtime(SESSION.library)
    run = ProgramRun(SESSION.library, runtime)
    for form in program.forms[:2]:
        run.run_form(form)
    assert runtime.units == []
    assert run.run_form(program.forms[2]) == 1798
    assert len(runtime.units) == 1
    with pytest.raises(SceneError, match="outside the list") as caught:
        run.run_form(program.forms[3])
    assert caught.value.span is not None
    assert caught.value.span.text == "(set-ref! xs i (* 2 i))"
