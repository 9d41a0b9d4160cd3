"""Whole programs: imports, params, roots, randomness (docs/language.md, sections 3 and 5)."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from scenelang import Options, Session
from scenelang.session.session import Evaluated

from .conftest import log, refused, run, scene, shown, warned

Write = Callable[..., None]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def put(**files: str) -> None:
        for name, text in files.items():
            path = tmp_path / (name.replace("__", "/") + ".scene")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)

    return put


def main(folder: Path, **options: object) -> Evaluated:
    session = Session(Options(**options))  # type: ignore[arg-type]
    return session.evaluate(session.source(str(folder / "main.scene")))


def names(result: Evaluated) -> list[str]:
    return [d.name for d in result.diagnostics]


ROOT = '(bind "root" (lambda () (call "cube")))'


# --- imports -----------------------------------------------------------------------------------------------------


def test_import(write: Write, tmp_path: Path) -> None:
    write(
        main=f'(import "lib.scene") (print (double 4) base) {ROOT}',
        lib="(define base 2) (define (double x) (* base x))",
    )
    assert main(tmp_path).log == ("8 2",)


def test_prefix_renames_definitions_and_macros_but_no_words(write: Write, tmp_path: Path) -> None:
    write(
        main='(import "lib.scene" :prefix f/) (print (f/double 4) (f/twice 3)) (bind "root" (lambda () (call "leg")))',
        lib='(define (double x) (* 2 x)) (define-syntax twice (syntax-rules () ((_ x) (double x)))) (bind "leg" (lambda () (call "cube")))',
    )
    result = main(tmp_path)
    assert result.log == ("8 6",)
    assert result.scene is not None
    assert result.scene.root.children[0].car.word == "leg"
    write(main=f'(import "lib.scene" :prefix f/) (print (double 4)) {ROOT}')
    assert names(main(tmp_path)) == ["unbound"]


def test_a_file_is_imported_once_and_in_order(write: Write, tmp_path: Path) -> None:
    write(
        main=f'(print 1) (import "a.scene") (print 4) (import "b.scene") (import "a.scene" :prefix x/) (print v x/v) {ROOT}',
        a='(print 2) (import "b.scene") (define v (list 1))', b="(print 3)",
    )  # fmt: skip
    assert main(tmp_path).log == ("1", "2", "3", "4", "(1) (1)")


def test_words_belong_to_the_importing_file(write: Write, tmp_path: Path) -> None:
    lib = '(bind "leg" (lambda () (call "from lib"))) (bind "top" (lambda () (call "top of lib")))'
    for order in ('(import "lib.scene") {}', '{} (import "lib.scene")'):
        mine = '(bind "leg" (lambda () (call "mine"))) (bind "root" (lambda () (union (call "leg") (call "top"))))'
        write(main=order.format(mine) + '(scene "root")', lib=lib)
        result = main(tmp_path)
        assert result.scene is not None
        assert [part.car.children[0].car.word for part in result.scene.root.children] == ["mine", "top of lib"]
        assert names(result) == []


def test_imported_names_may_be_redefined(write: Write, tmp_path: Path) -> None:
    write(main=f'(import "lib.scene") (define (f) 2) (print (f) (g)) {ROOT}', lib="(define (f) 1) (define (g) (f))")
    assert main(tmp_path).log == ("2 1",)


def test_imports_are_relative_to_their_file(write: Write, tmp_path: Path) -> None:
    write(
        main=f'(import "parts/a.scene") (print a b) {ROOT}',
        parts__a='(import "b.scene") (define a (+ b 1))',
        parts__b="(define b 1)",
    )
    assert main(tmp_path).log == ("2 1",)
    write(main=f'(import "parts/a.scene") (import "parts/b.scene") (print a b) {ROOT}')
    assert main(tmp_path).log == ("2 1",)
    write(parts__a='(import "../top.scene") (define a top)', top="(define top 9)")
    assert main(tmp_path).log == ("9 1",), "up is fine inside the project"


def test_macros_and_records_are_imported(write: Write, tmp_path: Path) -> None:
    write(
        main=f'(import "lib.scene") (print (inc 1) (proc 2) (point-x (point 3))) (define (f p::point) 1) (print (f (point 1))) {ROOT}',
        lib="(define n 1) (define-syntax inc (syntax-rules () ((_ x) (+ n x)))) (define-macro (proc x) `(* n ,x)) (define-record point x)",
    )
    assert main(tmp_path).log == ("2 2 3", "1")


def test_malformed_imports(write: Write, tmp_path: Path) -> None:
    for form, name in (
        ("(import lib)", "syntax"), ("(import)", "syntax"), ('(import "lib.scene" :as x)', "syntax"),
        ('(import "lib.scene" :prefix "x")', "syntax"), ('(define (f) (import "lib.scene"))', "misplaced"),
        ('(import "std/nothing.scene")', "file"),
    ):  # fmt: skip
        write(main=f"{form} {ROOT}", lib="(define x 1)")
        assert names(main(tmp_path)) == [name], form


def test_an_error_in_an_imported_file_names_that_file(write: Write, tmp_path: Path) -> None:
    write(main=f'(import "lib.scene") (f) {ROOT}', lib="(define (f)\n  (car (list-tail '(5) 1)))")
    (found,) = main(tmp_path).diagnostics
    assert found.span is not None
    assert found.span.source.name.endswith("lib.scene")
    assert found.chain[0][1] is not None
    assert found.chain[0][1].source.name.endswith("main.scene")


def test_a_missing_import_hides_the_errors_that_follow_from_it(write: Write, tmp_path: Path) -> None:
    write(main=f'(import "lib.scene") (print (double 4)) {ROOT}')
    assert names(main(tmp_path)) == ["file"]


def test_param_and_scene_of_imported_files(write: Write, tmp_path: Path) -> None:
    write(
        main=f'(import "lib.scene") (print height) {ROOT}',
        lib='(param height 2 "m") (scene "other") (bind "other" (lambda () (call "cube")))',
    )
    result = main(tmp_path)
    assert result.log == ("2",)
    assert result.scene is not None
    assert result.scene.word == "root"
    assert main(tmp_path, defines={"height": "5"}).log == ("5",)


# --- params --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "shown_as"),
    [
        ("3", "3"),
        ("2.5", "2.5"),
        ('"a b"', "a b"),
        ("word", "word"),
        ("#t", "#t"),
        ("none", "none"),
        ("[1 2 3]", "[1 2 3]"),
        ("-1e-3", "-0.001"),
    ],
)
def test_params(text: str, shown_as: str) -> None:
    assert log('(param p 0 "doc") (print p)', defines={"p": text}) == [shown_as]


def test_param_rules() -> None:
    assert log('(param p (+ 1 2) "doc") (define q (* 2 p)) (print p q)') == ["3 6"]
    assert log("(param p 1) (print p)") == ["1"]
    assert refused('(param p 1 "doc" :min 0 :max 2)', defines={"p": "3"}) == "param"
    assert refused('(param p 1 "doc" :min 0 :max 2)', defines={"p": "-1"}) == "param"
    assert refused('(param p 1 "doc")', defines={"q": "1"}) == "param"
    assert refused('(param p 1 "doc")', defines={"p": "(+ 1 2)"}) == "param"
    assert refused('(param p 1 "doc")', defines={"p": "1 2"}) == "param"
    assert refused('(param p 1 "doc")', defines={"p": ""}) == "param"
    assert refused('(param p 5 "doc" :max 2)') == "param"
    assert refused('(param p 1 "doc" :max 2)', defines={"p": "tall"}) == "param"
    assert log('(param p (+ 1 1) "doc" :max 2) (print p)') == ["2"]
    assert refused("(param)") == "syntax"
    assert refused("(param 5 1)") == "syntax"


# --- roots -----------------------------------------------------------------------------------------------------------

LEAF = '(lambda () (call "cube"))'


@pytest.mark.parametrize(
    ("program", "word", "warnings"),
    [
        (f'(bind "a" {LEAF})', "a", []),
        (f'(bind "a" (lambda () (call "b"))) (bind "b" {LEAF})', "a", []),
        (f'(bind "b" {LEAF}) (bind "a" (lambda () (call "b")))', "a", []),
        (f'(bind "a" {LEAF}) (bind "b" {LEAF})', "b", ["ambiguous-root"]),
        (f'(bind "a" {LEAF}) (bind "b" {LEAF}) (scene "a")', "a", ["unreachable-word"]),
        (f'(bind "a" {LEAF}) (bind "b" {LEAF}) (define words \'("b" "c"))', "a", ["unused"]),
        (f'(bind "a" {LEAF}) (bind "b" {LEAF}) (define words "b")', "a", ["unused"]),
        ('(bind "a" (lambda () (call "b"))) (bind "b" (lambda () (if #f (call "a") (call "cube"))))', "b", ["constant-condition"]),
        ('(bind "a" (lambda (:n) (if (= n 0) (call "cube") (call "a" :n (- n 1))))) (scene "a" :n 2)', "a", []),
        ('(bind "a" (lambda ((:n 2)) (if (= n 0) (call "cube") (call "a" :n (- n 1)))))', "a", []),
        (f'(bind "a" {LEAF}) (bind "b" (lambda () (define (helper) "a") (call (helper))))', "b", []),
    ],
)  # fmt: skip
def test_roots(program: str, word: str, warnings: list[str]) -> None:
    result = run(program)
    assert result.scene is not None
    assert (result.scene.word, [d.name for d in result.diagnostics]) == (word, warnings)


def test_root_options() -> None:
    program = f'(bind "a" {LEAF}) (bind "b" {LEAF}) (scene "b")'
    assert scene(program, root="a").word == "a"
    assert [d.name for d in run(program).diagnostics] == ["unreachable-word"]
    assert run(program, root="a").diagnostics == ()  # the other word is another variant
    assert refused(program, root="c") == "root"
    assert refused('(bind "a" (lambda () 5)) (scene "a")') == "parts"
    assert refused(f'(scene "nothing") (bind "a" {LEAF})') == "root"


def test_arguments_of_scene_join_those_of_the_root() -> None:
    root = '(bind "a" (lambda (z g (:n 0)) (print (embedding-handle z) (embedding-text z) n (map embedding-text (list-head g 1))) (union)))'
    assert log(f'{root} (scene "a" "text" "more" :n 3)') == ['z1 text 3 ("more")']
    assert log(f'{root} (scene "a" <s>)') == ["s none 0 (none)"]


def test_a_word_is_bound_as_an_effect() -> None:
    program = '(define (make n) (bind "leg" (lambda () (call "cube" :scale n)))) (make 3) (bind "root" (lambda () (call "leg")))'
    assert shown("1") == "1"
    assert scene(program).root.children[0].car.children[0].car.embedding.attributes == {"scale": 3}
    late = '(bind "root" (lambda () (bind "leg" (lambda () (call "cube"))) (call "leg"))) (scene "root")'
    assert len(scene(late).root.children[0].car.children) == 1


# --- randomness --------------------------------------------------------------------------------------------------------


def drawn(program: str, seed: int = 0) -> str:
    (line,) = log(f'(bind "r" (lambda () (print {program}) (union))) (scene "r")', seed=seed)
    return line


@pytest.mark.parametrize("seed", [0, 7, 123456])
def test_numpys_stream(seed: int) -> None:
    numpy = np.random.RandomState(seed)
    assert drawn("(random) (uniform) (uniform 2 5) (randint 10) (randint 3 9) (normal) (normal 1 2)", seed) == " ".join(
        map(repr, (numpy.random_sample(), numpy.uniform(), numpy.uniform(2, 5), int(numpy.randint(10)), int(numpy.randint(3, 9)), numpy.normal(), numpy.normal(1, 2)))
    )  # fmt: skip
    numpy = np.random.RandomState(seed)
    assert drawn("(permutation 6) (shuffle '(a b c d)) (choice '(1 2 3 4))", seed) == " ".join(
        [
            _listed(numpy.permutation(6)),
            _shuffled(numpy, ["a", "b", "c", "d"]),
            str([1, 2, 3, 4][int(numpy.choice(4))]),
        ]
    )
    numpy = np.random.RandomState(seed)
    assert drawn("(uniform 0 1 :size 3)", seed) == "[" + " ".join(map(repr, numpy.uniform(0, 1, 3).tolist())) + "]"


def _listed(values: object) -> str:
    return "[" + " ".join(str(int(v)) for v in np.asarray(values)) + "]"


def _shuffled(numpy: np.random.RandomState, items: list[str]) -> str:
    numpy.shuffle(items)
    return "(" + " ".join(items) + ")"


@pytest.mark.parametrize("seed", [0, 7, 123456])
def test_pythons_stream(seed: int) -> None:
    python = random.Random(seed)
    expected = [
        python.random(),
        python.uniform(2, 5),
        python.randint(1, 6),
        python.choice([1, 2, 3]),
        python.gauss(0, 1),
    ]
    assert drawn("(py-random) (py-uniform 2 5) (py-randint 1 6) (py-choice '(1 2 3)) (py-gauss 0 1)", seed) == " ".join(
        map(repr, expected)
    )
    python = random.Random(seed)
    sample, choices = python.sample(range(10), 4), python.choices([1, 2, 3], k=3)
    assert (
        drawn("(py-sample (iota 10) 4) (py-choices '(1 2 3) :k 3)", seed)
        == f"({' '.join(map(str, sample))}) ({' '.join(map(str, choices))})"
    )


def test_the_streams_are_seeded_just_before_the_root() -> None:
    plain = drawn("(random) (py-random)")
    (line,) = log('(random) (py-random) (bind "r" (lambda () (print (random) (py-random)) (union))) (scene "r")')
    assert line == plain
    assert drawn("(random)", 1) != drawn("(random)", 2)


def test_the_two_streams_are_apart() -> None:
    assert drawn("(begin (py-random) (random))") == drawn("(random)")
    assert drawn("(begin (random) (py-random))") == drawn("(py-random)")


def test_seeds_can_be_set() -> None:
    numpy, python = np.random.RandomState(42), random.Random(42)
    assert drawn("(begin (random) (set-seed! 42) (random))") == repr(numpy.random_sample())
    assert drawn("(begin (py-random) (py-set-seed! 42) (py-random))") == repr(python.random())


def test_streams_of_ones_own() -> None:
    assert drawn("(uniform :stream (random-stream 5))") == repr(np.random.RandomState(5).uniform())
    assert drawn("(uniform :stream (default-rng 5))") == repr(np.random.default_rng(5).uniform())
    assert drawn("(py-random :stream (py-random-stream 5))") == repr(random.Random(5).random())
    assert drawn("(begin (uniform :stream (random-stream 5)) (random))") == drawn("(random)")


def test_words_warn_when_called_early() -> None:
    assert warned(f'(call "a") (bind "a" {LEAF})') == ["undefined-word"]
