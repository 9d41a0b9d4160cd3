"""The meter itself, and programs that a limit of steps ends, whatever a builtin is given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support import calls, peak_bytes, session, unchecked, value

from scenelang.grammar.datum import Symbol
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.values.limits import Limits, Meter, resident_bytes
from scenelang.interpreter.values.values import (
    NIL,
    Array,
    Embedding,
    MutableList,
    Pair,
    Set,
    Table,
    Vector,
    embedding_key,
    make_list,
    memo_key,
    table_key,
)
from scenelang.stdlib.library import build_library

LONG = 300_000
COLLIDING = (1 << 61) - 1  # CPython gives all its multiples one hash
DOUBLED = "(define x '(1)) (for ((i 28)) (set! x (list x x)))"


def run_until_ended(expression: str, definitions: str = "") -> None:
    """A limit must end the program, which else goes on for hours."""
    with pytest.raises(LimitError):
        _run(
            f'(import "std/python.scene") {definitions} {expression}',
            Limits(steps=50_000, seconds=1e6, memory=2_000_000_000),
        )


def _run(text: str, limits: Limits) -> Any:
    from scenelang.grammar.datum import Source
    from scenelang.interpreter.evaluation.evaluate import ProgramRun
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
    with pytest.raises(LimitError, match=r"limit of 1e\+06 seconds of CPU time"):
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
def test_shared_data_ends(expression: str) -> None:
    run_until_ended(expression, DOUBLED)


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
def test_costly_builtins_end(expression: str) -> None:
    run_until_ended(expression)


@pytest.mark.parametrize(
    "key",
    [table_key, lambda n: table_key(Pair(n, NIL)), memo_key, lambda n: embedding_key(Embedding(None, None, {"x": n}))],
    ids=["a number", "a list", "an argument", "an attribute"],
)
def test_keys_of_colliding_integers_do_not_collide(key: Callable[[int], Any]) -> None:
    """Tables, sets and shared calls would become lists."""
    assert len({hash(i * COLLIDING) for i in range(3_000)}) == 1
    assert len({hash(key(i * COLLIDING)) for i in range(3_000)}) == 3_000


@pytest.mark.parametrize(
    ("use", "count"),
    [
        ("(list->set {})", 100_000),
        ("(delete-duplicates {})", 100_000),
        ('(map (lambda (n) (call "cube" :x n)) {})', 40_000),
    ],
)
def test_colliding_integers_are_no_more_work_than_others(use: str, count: int) -> None:
    """In lists they would take more than the time that `value` has."""
    numbers = f"(map (lambda (i) (* i {COLLIDING})) (iota {count}))"
    assert value(f"(length {use.format(numbers)})") == count


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
def test_text_in_messages_takes_work_by_its_length(name: str) -> None:
    thing = BIG[name]()
    assert len(show(thing, 60)) == 60
    assert calls(lambda: show(thing, 60)) < 2_000
    assert peak_bytes(lambda: show(thing, 60)) < 50_000


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
