"""Inferred kinds are compared with the values of a run: every value is in the kind of its expression, and no error is
reported about an expression that has a value. Searches by hand:

    PYTHONPATH=tests python -m kinds.test_soundness 20000 [seed]
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from random import Random

import pytest
from fuzz.scene_programs import Programs

from kinds.tracing import Traced, trace
from scenelang import Options, Session, Source
from scenelang.interpreter.values.limits import Limits

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").rglob("*.scene"))
_BLOCK = re.compile(r"^```scene\n(.*?)^```", re.S | re.M)
# Arguments of every kind, with the mistakes that are likely: a string for a number, a point of two numbers.
ARGUMENTS = (
    "0", "1", "3", "-2", "2.5", ".5", "#t", "#f", "none", '"a"', '"cube"', '"12"', "'b", ":k", "'()", "'(1 2 3)",
    "'(\"a\" \"b\")", '(list 1 "a")', "[1 2 3]", "[1 2]", "[1. 0 0]", "[[1 0] [0 1]]", "(eye 4)", "(translate [1 2 3])",
    '(call "cube")', '(transform (call "cube") (translate [1 0 0]))', '(union (call "cube") (call "sphere"))', "<z4>",
    "(embedding :a 1)", '(table "a" 1)', "(set 1 2)", "(mutable-list 1 2)", "(mutable-array [1 2 3])", "(lambda (x) x)",
    "(lambda () 1)", "(lambda (a b) a)", "even?", "+", "(random-stream 3)", "(cons 1 2)", "'(a . b)", "(rec 1 2)",
    '(frames (list (call "cube")))', "(iota 4)", '"{} {}"',
)  # fmt: skip


def session() -> Session:
    return Session(Options(limits=Limits(seconds=5)))


def assert_sound(traced: Traced, text: str) -> None:
    assert traced.wrong == [], text
    assert traced.false_alarms == [], text


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
@pytest.mark.sampled(3)
def test_examples(path: Path) -> None:
    text = re.sub(r":segments \d\d+", ":segments 12", path.read_text("utf-8"))  # the same kinds, fewer times
    traced = trace(Source(str(path), text), Session(Options(limits=Limits(seconds=30))))
    assert traced.error is None
    assert traced.findings == []
    assert_sound(traced, path.name)
    assert len(traced.evaluated) > 10


@pytest.mark.parametrize("page", ["README.md", "docs/language.md", "docs/tutorial.md"])
def test_documentation(page: str) -> None:
    blocks = _BLOCK.findall((ROOT / page).read_text("utf-8"))
    assert blocks
    for block in blocks:
        assert_sound(trace(Source(page, block), session()), block)


def random_call(random: Random, session: Session) -> str:
    """A call of a builtin, with about as many arguments as it takes."""
    builtins = session.library.builtins
    name = random.choice([name for name in builtins if name != "define-record"])
    signature = builtins[name].signature
    count = len(signature.required) + random.choice((0, 0, 0, 0, 1, 2, -1))
    arguments = [random.choice(ARGUMENTS) for _ in range(max(0, count))]
    if signature.keywords and random.random() < 0.4:
        names = [parameter.name for parameter in signature.keywords]
        arguments += [f":{random.choice([*names, 'foo'])}", random.choice(ARGUMENTS)]
    return f"({' '.join([name, *arguments])})"


def random_function(random: Random, session: Session) -> str:
    """A call of a function whose body passes its parameters to builtins, tests, guards and another function."""
    builtins = [name for name in session.library.builtins if name != "define-record"]

    def use() -> str:
        name = random.choice(builtins)
        count = max(1, len(session.library.builtins[name].signature.required))
        values = ["a", "b", random.choice(ARGUMENTS), random.choice(ARGUMENTS)]
        call = f"({name} {' '.join(random.choice(values) for _ in range(count))})"
        shape = random.choice(
            ("{}", "{}", "{}", "(if a {} 1)", "(guard (e (else 0)) {})", "(begin (inner b) {})", "(and b {})",
             "(let ((a b)) {})", "(map (lambda (x) {}) '(1))", "(begin (a 1) {})", "(a {})", "(call \"cube\" :scale {})",
             "(begin (set! b 1) {})", "(let/ec k (inner k) {})")
        )  # fmt: skip
        return shape.format(call)

    first, second = random.choice(ARGUMENTS), random.choice(ARGUMENTS)
    inner = random.choice(("(c 1)", "(+ c 1)", "c", "(if (number? c) (* c 2) c)", "(translate c)", "(length c)"))
    call = random.choice((f"(outer {first} {second})", f"(guard (e (else 0)) (outer {first} {second}))",
                          f"(outer {first} :b {second})", f"(if (random-chance) (outer {first} {second}) 1)",
                          f"(let ((f outer)) (f {first} {second}))"))  # fmt: skip
    call = call.replace("(random-chance)", random.choice(("#t", "(< (random) .5)")))
    parameters = random.choice(("a b", "a b", "a (b 2)", "a :b"))
    return f"(let () (define (inner c) {inner}) (define (outer {parameters}) {use()} {use()}) {call})"


def around(call: str) -> str:
    return f'(define-record rec p q)\n(define result {call})\n(bind "a" (lambda () (call "cube")))'


@pytest.mark.parametrize("call", ['(embedding-handle "12")', "(embedding-text <z4>)", "(list* (mutable-list 1 2))"])
def test_calls_that_were_not_sound(call: str) -> None:
    assert_sound(trace(Source("<call>", around(call)), session()), call)


@pytest.mark.parametrize(
    ("function", "is_endless"),
    [
        ("(define (f n) (when (= n 0) (raise 'done)) (f (- n 1)))", False),
        ("(define (f n) (assert (> n 0)) (f (- n 1)))", False),
        ('(define (f n k) (when (= n 0) (k (call "cube"))) (f (- n 1) k))', False),
        ("(define (f) (let/ec k (let loop ((i 0)) (when (> i 3) (k 1)) (loop (+ i 1)))))", False),
        ("(define (f n) (print n) (f n))", True),
    ],
)
def test_recursion_that_ends_by_an_exit_is_not_endless(function: str, is_endless: bool) -> None:
    found = session().check(Source("<test>", f'{function} (bind "a" (lambda () (call "cube")))')).diagnostics
    assert ("endless-recursion" in {d.name for d in found}) == is_endless


@pytest.mark.parametrize(
    "argument", ["z", "(first more)", "(ref more 0)", "(car more)", '(ref t "a")', "(r-name x)", "(g)"]
)
def test_an_embedding_of_unknown_kind_stands_before_attributes(argument: str) -> None:
    text = f"""
(define-record r name)
(define t (table "a" "oak"))
(define x (r "old"))
(define (draw g z more) (call "sphere" {argument} :radius .5))
(bind "s" (lambda (z more) (draw (lambda () "new") z more)))
"""
    traced = trace(Source("<test>", text), session())
    assert traced.error is None
    assert [d for d in traced.findings if d.is_error or d.name == "conditional-failure"] == []


def test_random_calls_of_builtins() -> None:
    random, here = Random(20), session()
    failed = found = 0
    for _ in range(400):
        call = random_call(random, here)
        text = around(call)
        traced = trace(Source("<call>", text), here)
        assert_sound(traced, call)
        reported = [d for d in traced.findings if d.is_error]
        if reported:
            assert traced.error is not None, call
        if traced.error is not None and traced.error.code[:2] in ("E4", "E6"):
            failed += 1
            found += bool(reported)
    assert failed >= 150
    assert found >= 0.8 * failed  # of calls that fail at run time


def test_random_calls_of_functions() -> None:
    random, here = Random(21), session()
    found = 0
    for _ in range(300):
        call = random_function(random, here)
        traced = trace(Source("<call>", around(call)), here)
        assert_sound(traced, call)
        found += any(d.notes for d in traced.findings)
    assert found >= 15  # arguments that fail in the body


def test_random_programs() -> None:
    programs, here = Programs(20), session()
    ran = 0
    for _ in range(300):
        text = programs.program()
        traced = trace(Source("<program>", text), here)
        assert_sound(traced, text)
        if traced.error is None and traced.errors == () and traced.program is not None:
            ran += 1
    assert ran >= 100


def main(count: int, seed: int) -> int:
    """Trace ``count`` programs, half of them calls of builtins; print each that is not sound, and the figures."""
    random, programs, here = Random(seed), Programs(seed), session()
    wrong = reported = 0
    for number in range(count):
        kinds = (
            programs.program,
            lambda: around(random_call(random, here)),
            lambda: around(random_function(random, here)),
        )
        text = kinds[number % 3]()
        traced = trace(Source("<program>", text), here)
        reported += any(d.is_error for d in traced.findings)
        if traced.wrong or traced.false_alarms:
            wrong += 1
            print(text, traced.wrong, traced.false_alarms, sep="\n", flush=True)
    print(f"{count} programs, {reported} with errors before the run, {wrong} not sound")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0))
