"""Warnings before running: each says what is nearly always a mistake, and leaves alone what looks like it."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenelang.cli.main import main
from scenelang.grammar.datum import Source
from scenelang.session.session import Session

session = Session()


def warned(text: str) -> list[tuple[str, str]]:
    """The name of each warning, and the text that it marks."""
    return [(d.name, d.span.text if d.span else "") for d in session.check(Source("a.scene", text)).diagnostics]


def test_an_attribute_may_be_none_through_a_parameter() -> None:
    text = '(define (f c) (call "cube" :color c)) (bind "a" (lambda () (union (f none) (f [1 0 0]))))'
    assert session.check(Source("a.scene", text)).diagnostics == ()


def scene(body: str, parameters: str = "") -> str:
    return f'(bind "a" (lambda ({parameters}) {body}))'


@pytest.mark.parametrize(
    ("program", "names"),
    [
        (scene('(define x 1) (call "cube")'), ["x"]),
        (scene('(let ((x 1) (y 2)) (call "cube" :scale y))'), ["x"]),
        (scene('(let* ((x 1) (y x)) (call "cube"))'), ["y"]),
        (scene('(define (f p q) (call "cube" :scale q)) (f 1 2)'), ["p"]),
        (scene('(call "cube" :scale size)', ":size :tint"), [":tint"]),
        (scene('(call "cube")', "(:tint [1 0 0])"), [":tint"]),
        ('(define spare 1) (bind "a" (lambda () (call "cube")))', ["spare"]),
        ('(define (spare x) x) (bind "a" (lambda () (call "cube")))', ["spare"]),
        ('(define (f x y) x) (bind "a" (lambda () (call "cube" :scale (f 1 2))))', []),  # others may pass it on
        # what a caller prescribes, what is meant to be unused, what a macro may read, what nobody can rename
        (scene('(call "cube")', "z gamma"), []),
        (scene('(union-loop 3 (lambda (i) (call "cube")))'), []),
        (scene('(for/union ((i (iota 3))) (call "cube"))'), []),
        (scene('(define _x 1) (call "cube")'), []),
        (scene('(define x 1) (define-syntax m (syntax-rules () ((_) x))) (call "cube")'), []),
        (scene('(define (f p) (call "cube")) (union (map f (list 1 2)))'), []),
        (scene('(case 3 ((1) (call "cube")) (else (call "sphere")))'), []),
        (scene('(do ((i 0 (+ i 1))) ((= i 3) (call "cube")))'), []),
        ('(define helper 1)', []),  # no scene: a file for others
        ('(define helper 1) (bind "a" (lambda () (call "cube"))) (bind "b" (lambda () (call "cube")))', []),
        ('(define-syntax m (syntax-rules () ((_) kept))) (define kept 1) (bind "a" (lambda () (call "cube")))', []),
    ],
)  # fmt: skip
def test_unused(program: str, names: list[str]) -> None:
    found = [text for name, text in warned(program) if name == "unused"]
    assert found == names


@pytest.mark.parametrize(
    ("program", "marked"),
    [
        (scene('(transform (call "cube") (scale 2))', ":scale"), ["scale"]),
        (scene('(transform (call "cube") (scale 2))', "(:scale [1 1 1])"), ["scale"]),
        (scene('(define rotate 3) (transform (call "cube") (rotate 1 [0 1 0]))'), ["rotate"]),
        (scene('(transform (call "cube") (scale scale))', "s scale::Float"), ["scale"]),
        (scene('(transform (call "cube") (std/scale scale))', ":scale"), []),
        (scene('(define (scale x) (translate [x 0 0])) (transform (call "cube") (scale 2))'), []),
        (scene('(define (twice reverse x) (reverse (reverse x))) (twice cdr (list 1)) (call "cube")'), []),
        (scene('(call "cube" :scale scale)', ":scale"), []),
    ],
)
def test_calls_of_what_hides_a_builtin(program: str, marked: list[str]) -> None:
    assert [text for name, text in warned(program) if name == "shadowed-builtin"] == marked


@pytest.mark.parametrize(
    ("condition", "always"),
    [
        ("#t", "#t"), ("#f", "#f"), ("none", "none"), ("3", "3"), ("(< 1 2)", "(< 1 2)"), ("(= n n)", "(= n n)"),
        ("odd?", "odd?"), ("(lambda () n)", "(lambda () n)"), ("(and #t n)", "#t"), ("(or n 3 n)", "3"),
        ("n", None), ("(< n 2)", None), ("(odd? 3)", None), ("(or n 3)", None),
    ],
)  # fmt: skip
def test_constant_conditions(condition: str, always: str | None) -> None:
    found = warned(scene(f'(if {condition} (call "cube" :scale n) (call "sphere"))', ":n"))
    assert [text for name, text in found if name == "constant-condition"] == ([always] if always else [])


def test_the_last_clause_of_cond_may_be_true() -> None:
    assert warned(scene('(cond ((> n 1) (call "cube")) (#t (call "sphere")))', ":n")) == []
    assert warned(scene('(while #t (raise n)) (call "cube")', ":n")) == []


@pytest.mark.parametrize(
    ("pose", "is_odd"),
    [
        ("(transform (transform x (translate [1 0 0])) (rotate 1 [0 1 0]))", True),
        ("(transform x (@ (rotate (/ pi 2) [0 0 1]) (translate [0 1 0])))", True),
        ("(transform x (@ (rotate 1 [0 1 0]) (translate [0 n 0])))", False),  # along the axis
        ("(transform x (@ (rotate n [0 1 0]) (translate [1 0 0])))", False),  # round a circle
        ("(transform x (@ (translate [1 0 0]) (rotate 1 [0 1 0])))", False),
        ("(transform x (@ (rotate 1 [0 1 0] [1 0 0]) (translate [1 0 0])))", False),
        ("(transform (transform x (translate [n 0 0])) (rotate pi [0 1 0]))", False),
        ("(transform x (@ (translate [1 0 0]) (rotate 1 [0 1 0]) (translate [-1 0 0])))", False),  # about a pivot
    ],
)
def test_turns_after_moves(pose: str, is_odd: bool) -> None:
    found = [name for name, _ in warned(scene(f'(define x (call "cube" :scale n)) {pose}', ":n"))]
    assert found == (["turned-after-moved"] if is_odd else [])


def test_words_that_the_root_never_reaches() -> None:
    words = '(bind "a" (lambda () (call "b"))) (bind "b" (lambda () (part "c"))) (define (part w) (call w)) '
    words += (
        '(bind "c" (lambda () (call "cube"))) (bind "d" (lambda () (call "e"))) (bind "e" (lambda () (call "cube")))'
    )
    assert warned(words + '(scene "a")') == [("unreachable-word", '"d"'), ("unreachable-word", '"e"')]
    assert warned(words.replace("(call w)", '(call (string-append w ""))') + '(scene "a")') == []
    assert [name for name, _ in warned(words)] == ["ambiguous-root"]


def test_comments_allow_warnings_but_no_errors() -> None:
    program = scene('\n(define x 1) ; lint: allow unused\n(define y 2)\n(call "cube")')
    assert warned(program) == [("unused", "y")]
    assert warned(program.replace("(define y", "; lint: allow W306, W309\n(define y")) == []
    assert warned("; lint: allow-file unused\n" + program) == []
    assert warned("; lint: allow W309\n" + program) == [("unused", "y")]
    assert warned("; lint: allow-file unbound E301\n(print nothing)") == [("unbound", "nothing")]


def test_fixes_are_safe_and_complete(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.scene"
    path.write_bytes(
        b"\xef\xbb\xbf; a part\r\n(bind part\r\n  (lambda ()\r\n    (define one 1)\r\n    (define two one)\r\n"
        b'    (let ([half 1/2])\r\n      (if #t (call "cube" :scale half) (call "sphere")))))\r\n'
    )
    assert main(["check", "--fix", str(path)]) == 0
    assert path.read_bytes() == (
        b'\xef\xbb\xbf; a part\r\n(bind "part"\r\n  (lambda ()\r\n    (let ((half (/ 1 2)))\r\n      (call "cube" :scale half))))\r\n'
    )
    assert "fixes applied" in capsys.readouterr().err
    assert main(["check", "--fix", str(path)]) == 0
    assert capsys.readouterr().err == ""


def test_what_a_fix_could_change_stays(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    text = scene('(define x (random)) (define y (print 1)) (call "cbue") (call "cube" :scal 1) (nowhere)')
    path.write_text(text)
    assert main(["check", "--fix", str(path)]) == 1
    assert path.read_text() == text
    assert main(["check", "--fix", "-"]) == 2


def test_fixes_keep_definitions_that_others_may_import_and_comments(tmp_path: Path) -> None:
    path = tmp_path / "a.scene"
    for text in (
        '(define oak 1)\n(bind "a" (lambda () (call "cube")))\n',
        scene('(define w ; why\n 3)\n (call "cube")'),
        scene('(if #t #|keep|# (call "cube") ; why\n (call "sphere"))'),
    ):
        path.write_text(text)
        assert main(["check", "--fix", str(path)]) == 0
        assert path.read_text() == text


def test_a_file_that_another_imports_is_no_scene(tmp_path: Path) -> None:
    part = tmp_path / "parts" / "part.scene"
    part.parent.mkdir()
    part.write_text('(define oak 1) (bind "a" (lambda () (call "cube")))')
    assert [d.name for d in session.check(session.source(str(part))).diagnostics] == ["unused"]
    (tmp_path / "whole.scene").write_text('(import "parts/part.scene") (bind "b" (lambda () (call "a" :n oak)))')
    assert session.check(session.source(str(part))).diagnostics == ()


def test_forms_are_looked_at_although_others_are_wrong() -> None:
    program = scene('(define x 1) (call "cube")') + "\n(nowhere)"
    assert [name for name, _ in warned(program)] == ["unused", "unbound"]


# --- what fixes leave alone ------------------------------------------------------------------------------------------


def fixed(text: str) -> str:
    return Session().autofix(Source("<a>", text))[0].text


@pytest.mark.parametrize(
    "form",
    [
        "(let () (begin (define q 1)) n)",  # the only form of a body
        "(let () (define q 1) (set! q 2) n)",  # assigned further on
        "(let () (define q later) (define later 1) (+ n later))",  # fails
        '(let () (define q [1 "a"]) n)',  # no array
        "(let () (define q [1 n]) n)",  # an array if n is a number
        "(let () (define q (random)) n)",
        '(let () (define q (print "q")) n)',
        '(let () (define q 1) "a text" n)',  # the string would open the body
        "(both (define q 1) n)",  # a macro that also quotes it
        "(if (= n n) 1 2)",  # fails for no number, and nan is not equal to itself
        "(if (equal? 1 1.) 1 2)",  # equal numbers of two types
        "(both (define q (if #t 1 2)) q)",
        '(if #t (call "cube") (call "part"))',  # the root is the word that nothing mentions
        '(if #t (call "cube") (call "p\\x61;rt"))',
        "(cond (else (define q (random)) n))",
    ],
)
def test_fixes_that_could_change_a_program_are_not_safe(form: str) -> None:
    macro = "(define-syntax both (syntax-rules () ((_ a b) (begin (print (quote a)) (let () a b)))))\n"
    text = f'{macro}(bind "part" (lambda () (call "cube")))\n(bind "s" (lambda ((:n 1)) {form}))\n'
    assert fixed(text) == text


@pytest.mark.parametrize(
    ("form", "wanted"),
    [
        ("(+ 1(if #t n 2)3)", "(+ 1 n 3)"),
        ("(list n(if #f 1 n)n)", "(list n n n)"),
        ("(list (if #t `(a ,n) 1))", "(list `(a ,n))"),
        ("(list (if #t 'a 1))", "(list 'a)"),
        ("(let ()n(define q 1)n)", "(let ()n n)"),
        ("(let () (define q 1) (define r q) n)", "(let ()   n)"),
        ("(let ((m n)) (define q m) n)", "(let ((m n))  n)"),
        ("(let () (define (f a) (print a)) n)", "(let ()  n)"),
        ("(list '(1 a) (+ 1/2 n))", "(list '(1 a) (+ (/ 1 2) n))"),
    ],
)
def test_fixes_keep_tokens_apart(form: str, wanted: str) -> None:
    assert fixed(f'(bind "s" (lambda ((:n 1)) {form}))') == f'(bind "s" (lambda ((:n 1)) {wanted}))'


@pytest.mark.parametrize("data", ["'(1/3 2)", "`(a ,1/3)", "(quote (1/3))", "'1/3", '(list ";" \'(a (1/3)))'])
def test_fractions_in_data_are_no_calls(data: str) -> None:
    text = f'(bind "s" (lambda () {data}))'
    assert fixed(text) == text
