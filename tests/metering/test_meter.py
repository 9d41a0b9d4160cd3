"""The meter itself, and programs that a limit ends in time, whatever a builtin is given."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support import session, unchecked, value

from scenelang.grammar.datum import Symbol
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.runtime.limits import Limits, Meter, resident_bytes
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.values import Array, Embedding, MutableList, Pair, Set, Table, Vector, make_list
from scenelang.interpreter.scene.entity import Entity
from scenelang.stdlib.library import build_library

LONG = 300_000
COLLIDING = "(map (lambda (i) (* i 2305843009213693951)) (iota 3000))"
DOUBLED = "(define x '(1)) (for ((i 28)) (set! x (list x x)))"


def ended(expression: str, definitions: str = "", seconds: float = 0.25) -> float:
    """How long a program takes until a limit ends it."""
    started = time.monotonic()
    with pytest.raises(LimitError):
        _run(
            f'(import "std/python.scene") {definitions} {expression}',
            Limits(seconds=seconds, steps=10**9, memory=2_000_000_000),
        )
    return time.monotonic() - started


def _run(text: str, limits: Limits) -> Any:
    from scenelang.grammar.datum import Source
    from scenelang.interpreter.runtime.evaluate import ProgramRun
    from scenelang.interpreter.runtime.runtime import Runtime

    checked = session().check(Source("<test>", text))
    program = checked.program
    assert checked.ok and program is not None, checked.diagnostics  # noqa: PT018
    run = ProgramRun(build_library(), Runtime(build_library(), limits))
    result = None
    for form in program.forms:
        result = run.run_form(form)
    return result


def test_seconds_may_have_begun_earlier() -> None:
    meter = Meter(Limits(seconds=1e6))
    meter.reset(1e6 - 1e5)
    meter.spend(1)
    meter.reset(1e6 + 1)
    with pytest.raises(LimitError, match="limit of 1e.06 seconds of CPU time"):
        meter.spend(1)
    meter.reset()
    meter.spend(1)


def test_memory_is_refused_before_it_is_there() -> None:
    meter = Meter(Limits(memory=100_000_000))
    meter.reserve(50_000_000)
    with pytest.raises(LimitError, match="memory"):
        meter.reserve(200_000_000)
    before = resident_bytes()
    with pytest.raises(LimitError, match="memory"):
        _run("(zeros 9000000)", Limits(memory=50_000_000))
    assert resident_bytes() - before < 50_000_000


@pytest.mark.parametrize(
    "expression",
    [
        "(while #t (sort (list x 1) :key list))", "(min-of (list x x))", "(sort (list 3 1) :key (lambda (i) x))",
        "(while #t (flatten x))", "(while #t (array x))", "(py-str x)", "(while #t (equal? x (list x 1)))",
        '(while #t (guard (e (#t 0)) (call "cube" :a x)))', "(while #t (guard (e (#t 0)) (set x)))",
    ],
)  # fmt: skip
@pytest.mark.sampled(2)
def test_shared_data_ends_in_time(expression: str) -> None:
    assert ended(expression, DOUBLED) < 3.0


@pytest.mark.parametrize(
    "expression",
    [
        '(define s (string-join (map chr (iota 20000 1000)) "")) (while #t (string-trim s (string-append (reverse s) "")))',
        "(while #t (expt (arange 2 4000) 300))",
        "(while #t (number->string (expt 3 8000) 2))",
        "(while #t (transpose (zeros 500 500)))",
        '(define s (string-pad "" 1000000)) (while #t (guard (e (#t 0)) (+ s 1)))',
        '(define t (list->table (map (lambda (i) (list (string i) i)) (iota 20000)))) (while #t (guard (e (#t 0)) (ref t "x")))',
        '(define u (union (call "cube"))) (while #t (set! u (union u u)))',
        "(while #t (permutation 100000))",
        "(while #t (concatenate (make-list 5000 [1 2])))",
    ],
)  # fmt: skip
@pytest.mark.sampled(2)
def test_costly_builtins_end_in_time(expression: str) -> None:
    assert ended(expression) < 3.0


def test_colliding_integers_are_as_fast_as_others() -> None:
    """The multiples of 2^61 - 1 have one hash in CPython: sets, tables and shared calls must not become lists."""

    def seconds(numbers: str, use: str) -> float:
        best = 9.0
        for _ in range(3):
            started = time.thread_time()
            value(use.format(numbers))
            best = min(best, time.thread_time() - started)
        return best

    other = COLLIDING.replace("2305843009213693951", "2305843009213693000")
    for use in ("(length (list->set {}))", '(for ((n {})) (call "cube" :scale n))', "(length (delete-duplicates {}))"):
        assert seconds(COLLIDING, use) < 3 * seconds(other, use) + 0.02, use


def test_long_integers_and_floats_that_are_equal_are_one_key() -> None:
    assert value("(length (set (expt 2 70) (inexact (expt 2 70)) inf inf (- (expt 2 70))))") == 3
    assert value("(has-key? (table [1 1180591620717411303424] 1) (list 1))") is False
    assert value("(ref (table (expt 2 64) 1) (expt 2. 64))") == 1


BIG: dict[str, Callable[[], Any]] = {
    "string": lambda: "a" * LONG,
    "controls": lambda: "\x01" * LONG,
    "list": lambda: make_list(range(LONG)),
    "vector": lambda: Vector(range(LONG)),
    "array": lambda: Array(np.ones((LONG // 100, 100))),
    "mutable list": lambda: MutableList(list(range(LONG)), 1),
    "table": lambda: Table({i: (i, i) for i in range(LONG)}, 1),
    "set": lambda: Set({i: i for i in range(LONG)}, 1),
    "embedding": lambda: Embedding("z" * LONG, "b" * LONG, {f"a{i}": i for i in range(LONG)}),
    "entity": lambda: Entity("w" * LONG, Embedding(), ()),
    "symbol": lambda: Symbol("s" * LONG),
    "strings": lambda: make_list(["a" * LONG] * 100),
    "integer": lambda: 10**3999,
}


@pytest.mark.parametrize("name", BIG)
def test_text_in_messages_takes_time_by_its_length(name: str) -> None:
    thing = BIG[name]()
    assert len(show(thing, 60)) == 60
    started = time.thread_time()
    for _ in range(20):
        show(thing, 60)
    assert (time.thread_time() - started) / 20 < 0.002


def test_deep_and_dotted_data_prints() -> None:
    deep: Any = make_list(())
    for _ in range(100_000):
        deep = Pair(deep, deep)
    assert show(deep, 40) == "(" * 37 + "..."
    assert show(Pair(1, Pair(2, 3))) == "(1 2 . 3)"


def test_python_never_shows() -> None:
    text = value("(string car (lambda (x) x) (let/ec k k) (guard (e (#t e)) (car 5)) (random-stream 1) (set car) grid)")
    assert not any(python in text for python in ("<function", "object at", "0x"))
    assert all(shown in text for shown in ("<procedure car>", "<error E"))
    with unchecked(), pytest.raises(SceneError) as caught:
        value("(+ car 1)")
    assert "<procedure car>" in caught.value.message
