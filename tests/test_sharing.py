"""Sharing of calls is sound: random programs do the same with and without it, and it does share."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from searching import many
from support import evaluate, failure, outcome, session, value

from scenelang.grammar.datum import Source
from scenelang.interpreter.scene.entity import count_words
from scenelang.interpreter.values.limits import Limits

WORDS = ["wa", "wb", "wc", "wd"]


@st.composite
def expressions(draw: st.DrawFn, depth: int, words: list[str]) -> str:
    """Statements and values that read, write, draw, call and fail."""
    simple = [
        "(set! g (+ g 1))",
        "(push! xs g)",
        '(set-ref! t "k" (+ 1 (ref t "k" 0)))',
        "(set! local (+ local 1))",
        "(push! mine local)",
        "(set! late (+ 1 (guard (e (#t 0)) late)))",
    ]
    numbers = [
        "g", "(length xs)", "(ref t \"k\" 0)", "local", "(length mine)", "(uniform)", "(py-random)", "1", "x",
        "(guard (e (#t 7)) late)", "(counter)", "(ref (box) 0)", "(random :stream s)",
    ]  # fmt: skip
    kind = draw(st.integers(0, 9))
    if kind <= 2:
        return draw(st.sampled_from(simple))
    if kind == 3:
        inner = draw(expressions(depth - 1, words)) if depth else "(void)"
        return f"(when (even? (floor {draw(st.sampled_from(numbers))})) {inner})"
    if kind == 4 and words:
        word = draw(st.sampled_from(words))
        return f'(bind "{word}" (lambda ((:x 1)) (call "sphere" :radius (+ x {draw(st.sampled_from(["1", "g"]))}))))'
    if kind == 5 and depth:
        return f'(guard (e (#t (void))) (begin {draw(expressions(depth - 1, words))} (error "x")))'
    if kind == 6 and depth:
        return f"(let/ec k (begin {draw(expressions(depth - 1, words))} (k 1)))"
    number = draw(st.sampled_from(numbers))
    if words and draw(st.booleans()):
        return f'(add! (call "{draw(st.sampled_from(words))}" :x {number}))'
    return f'(add! (call "cube" :scale (+ 1 {number})))'


@st.composite
def programs(draw: st.DrawFn) -> str:
    forms = [
        "(define g 0)", "(define xs (mutable-list))", "(define t (table))", "(define s (random-stream 3))",
        "(define (counter) (let ((n 0)) (set! n (+ n 1)) n))", "(define cell (mutable-list 0))",
        "(define (box) (set-ref! cell 0 (+ 1 (ref cell 0))) cell)",
    ]  # fmt: skip
    for index, word in enumerate(WORDS):
        body = [draw(expressions(2, WORDS[:index])) for _ in range(draw(st.integers(1, 4)))]
        forms.append(
            f'(bind "{word}" (lambda ((:x 1)) (define local 0) (define mine (mutable-list)) (define out (mutable-list))'
            f" (define (add! e) (push! out e)) {' '.join(body)} (union out)))"
        )
    calls = [
        f'(call "{draw(st.sampled_from(WORDS))}" :x {draw(st.sampled_from(["1", "2", "g", "(uniform)"]))})'
        for _ in range(draw(st.integers(2, 6)))
    ]
    between = draw(st.sampled_from(["(set! g 5)", "(push! xs 1)", "(void)", '(set-ref! t "k" 9)']))
    half = len(calls) // 2
    forms.append(
        f'(bind "root" (lambda () (union {" ".join(calls[:half])} (begin {between} (union)) {" ".join(calls[half:])})))'
    )
    forms.append("(define late 5)")
    return "\n".join([*forms, '(scene "root")'])


@pytest.mark.slow
@settings(max_examples=many(150), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(programs())
def test_sharing_changes_nothing(program: str) -> None:
    assert outcome(program, memoize=True) == outcome(program, memoize=False)


def test_equal_calls_are_one_entity() -> None:
    root = evaluate(
        '(bind "leg" (lambda (:h) (call "cube" :scale h)))'
        '(bind "t" (lambda () (union (call "leg" :h 1) (call "leg" :h 1) (call "leg" :h 1.0))))'
    ).root
    a, b, c = (part.car for part in root.children)
    assert a is b
    assert a is not c, "1 and 1.0 are told apart"


def test_a_call_that_draws_is_not_shared() -> None:
    root = evaluate(
        '(bind "r" (lambda () (call "cube" :scale (uniform))))(bind "t" (lambda () (union (call "r") (call "r"))))'
    ).root
    a, b = (part.car for part in root.children)
    assert a.children[0].car.shape.size != b.children[0].car.shape.size


def test_a_converted_mutable_argument_counts_as_read() -> None:
    text = (
        '(define p (mutable-list 3 4 0)) (bind "b" (lambda () (call "cube" :scale (cross p [0 0 1]))))'
        '(bind "t" (lambda () (define a (call "b")) (set-ref! p 0 9) (union a (call "b"))))'
    )
    a, b = (part.car.children[0].car.shape.size for part in evaluate(text).root.children)
    assert a != b


def test_exponential_recursion_costs_its_distinct_calls() -> None:
    text = (
        '(bind "n" (lambda (:k) (if (= k 0) (call "cube") (union (call "n" :k (- k 1)) (call "n" :k (- k 1))))))'
        '(scene "n" :k 60)'
    )
    assert count_words(evaluate(text).root)["cube"] == 2**60


def test_first_class_call_shares_too() -> None:
    text = (
        '(define c call) (bind "n" (lambda (:k)'
        "\n"
        '(if (= k 0) (c "cube") (union (c "n" :k (- k 1)) (c "n" :k (- k 1))))))'
        '(scene "n" :k 18)'
    )
    assert count_words(evaluate(text, limits=Limits(steps=100_000)).root)["cube"] == 2**18


def test_a_shared_call_prints_once() -> None:
    text = '(bind "a" (lambda () (print "made") (call "cube"))) (bind "t" (lambda () (union (call "a") (call "a"))))'
    assert session().evaluate(Source("<t>", text)).log == ("made",)


PAPER_PROGRAMS = [
    '(call "cube" :color [1 0 0])',
    '(call "cube" <z3> :scale 2)',
    '(call "cube" "ivory" :scale [1 2 3])',
    '(call "leg" :h 2)',
    '(call "two" <z1> <z2>)',
    '(call "two" <z1>)',
    '(union (call "cube") (list (call "leg" :h 1) (list)) (transform (call "leg" :h 1) (translate [1 0 0])))',
    '(union-loop 3 (lambda (i) (transform (call "cube") (translate [i 0 0]))))',
    '(union-loop 3 (lambda (i) (list (call "leg" :h i) (call "cube"))))',
    '(transform (transform (call "leg" :h 1) (translate [1 0 0])) (rotate 1 [0 1 0]))',
    '(transform (union (call "cube") (call "leg" :h 1)) (scale 2))',
    '(transform (call "cube") [[1 0 0 5] [0 1 0 0] [0 0 1 0] [0 0 0 1]])',
    '(call "nothing" :a "b")',
    '(union)',
    '(call "leg")',
    '(call "leg" :nope 3)',
    '(call "cube" 3)',
    '(call 3)',
    '(union 3)',
    '(union none)',
    '(transform (call "cube") [1 0 0])',
    '(transform 3 (translate [0 0 0]))',
    '(union-loop 2 (lambda (i) i))',
    '(call "cube" :scale)',
    '(call "cube" :scale 1 :scale 2)',
]  # fmt: skip


def test_call_sites_do_what_the_prelude_does() -> None:
    """The same expressions through the fast paths, and through the paper's definitions as ordinary procedures."""
    header = (
        '(bind "leg" (lambda (:h) (call "cube" :scale (+ 1 h))))'
        '(bind "two" (lambda (z gamma) (union (call "cube" z) (if (null? gamma) (union) (call "cube" (car gamma))))))'
    )
    slow = (
        "(define (identity-function f) f) (define c (identity-function call)) (define u (identity-function union))"
        "(define l (identity-function union-loop)) (define t (identity-function transform))"
    )
    for expression in PAPER_PROGRAMS:
        plain = expression
        for name, short in (("union-loop", "l"), ("union", "u"), ("call", "c"), ("transform", "t")):
            plain = plain.replace(f"({name} ", f"({short} ").replace(f"({name})", f"({short})")
        fast_outcome = outcome(f'{header} (bind "root" (lambda (z) {expression})) (scene "root")', True)
        slow_outcome = outcome(f'{header} {slow} (bind "root" (lambda (z) {plain})) (scene "root")', True)
        if isinstance(fast_outcome, tuple):
            assert isinstance(slow_outcome, tuple), (expression, slow_outcome)
            assert fast_outcome[0] == slow_outcome[0] or "type" in (fast_outcome[0], slow_outcome[0]), expression
        else:
            assert fast_outcome == slow_outcome, expression


def test_a_shadowed_paper_form_is_a_plain_call() -> None:
    assert value("(union 1 2)", "(define (union a b) (+ a b))") == 3
    assert value("((lambda (call) (call 4)) (lambda (x) (* x x)))") == 16


def test_a_misspelt_attribute_is_an_error_in_this_call_only() -> None:
    name, message = failure(
        '(bind "leg" (lambda ((:height 1)) (call "cube"))) (bind "t" (lambda () (call "leg" :heigth 3)))'
    )
    assert name == "keyword"
    assert "heigth" in message


@pytest.mark.parametrize(
    ("thing", "change", "text"),
    [
        ("(mutable-list 1 2)", "(push! m 3)", "(string m)"),
        ("(mutable-list 1 2)", "(push! m 3)", '(format "{}" m)'),
        ("(mutable-list 1 2)", "(push! m 3)", '(format "{!r:>20}" m)'),
        ("(table 1 2)", "(set-ref! m 3 4)", "(string (list 1 m))"),
        ("(mutable-array [1 2])", "(set-ref! m 0 9)", "(string m)"),
        ("(mutable-array [1 2])", "(set-ref! m 0 9)", "(string [m m])"),
        ("(set 1)", "(add! m 2)", '(guard (e (#t (error-message e))) (error "no" m))'),
        ("(mutable-list 1 2)", "(push! m 3)", "(guard (e (#t (error-message e))) (+ m 1))"),
        ("(mutable-list 1 2)", "(push! m 3)", "(guard (e (#t (string e))) (raise m))"),
        ('(mutable-list "a" 1 2)', "(set-ref! m 0 1)", "(guard (e (#t (error-code e))) (string (translate m)))"),
        ("(point 1)", "(set-point-x! m 2)", "(string m)"),
        ("(mutable-list 1)", "(push! m 3)", "(py-str m)"),
        ("(mutable-list 1)", "(push! m 3)", '(py-% "%s" (list m))'),
    ],
)
def test_text_of_a_mutable_value_counts_as_read(thing: str, change: str, text: str) -> None:
    program = (
        f'(import "std/python.scene") (define-record point x) (define m {thing})'
        f'(bind "b" (lambda () (call "cube" :text {text})))'
        f'(bind "t" (lambda () (define a (call "b")) {change} (union a (call "b"))))'
    )
    a, b = (part.car.children[0].car.embedding.attributes["text"] for part in evaluate(program).root.children)
    assert a != b
