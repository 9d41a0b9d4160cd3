"""Literals and ellipsis of ``syntax-rules`` are identifiers, not names (R7RS 4.3.2)."""

from __future__ import annotations

import pytest

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.session.session import Session

from .conftest import log

DEFINED = """
(define-syntax be-like-begin
  (syntax-rules () ((_ name) (define-syntax name (syntax-rules () ((_ expr (... ...)) (begin expr (... ...))))))))
(define-syntax be-like-begin2
  (syntax-rules () ((_ name) (define-syntax name (... (syntax-rules () ((_ expr ...) (begin expr ...))))))))
(define-syntax be-like-begin3
  (syntax-rules () ((_ name) (define-syntax name (syntax-rules dots () ((_ expr dots) (begin expr dots)))))))
(define-syntax escaped
  (syntax-rules () ((_) '(... ...)) ((_ x) '(... (x ...))) ((_ x y) '(... (... x y)))))
(define-syntax literal-dots (syntax-rules ... (...) ((_ x) '(x ...))))
(define-syntax dots-in-use (syntax-rules (...) ((_ x ...) '(x ...)) ((_ x y) 'two)))
(define-syntax count-to-2 (syntax-rules () ((_) 0) ((_ _) 1) ((_ _ _) 2) ((_ . _) 'many)))
(define-syntax jabberwocky
  (syntax-rules ()
    ((_ hatter) (begin (define march-hare 42) (define-syntax hatter (syntax-rules () ((_) march-hare)))))))
(define-syntax define-quoter
  (syntax-rules () ((_ bar y) (define-syntax bar (syntax-rules () ((bar x) 'y))))))
(define-syntax with-literal
  (syntax-rules () ((_ name lit) (define-syntax name (syntax-rules (lit) ((_ lit) 'literal) ((_ x) 'other))))))
(define-syntax with-own-literal
  (syntax-rules ()
    ((_ name var) (define-syntax name (syntax-rules (x) ((_ x var) (list 'literal var)) ((_ a b) 'no))))))
(define-syntax with-own-dots
  (syntax-rules () ((_ name var) (define-syntax name (syntax-rules dots () ((_ var dots) (list var dots)))))))
(define-syntax with-given-dots
  (syntax-rules () ((_ name e) (define-syntax name (syntax-rules e () ((_ x e) (list x e)))))))
(define-syntax my-if (syntax-rules (then) ((_ a then b) (if a b 0)) ((_ a b c) 'no-literal)))
"""

USES = {
    "(be-like-begin go) (print (go 1 2 3 4))": "4",
    "(be-like-begin2 go) (print (go 1 2 3 4))": "4",
    "(be-like-begin3 go) (print (go 2 3 4 5))": "5",
    "(print (escaped) (escaped 100) (escaped 100 200))": "... (100 ...) (... 100 200)",
    "(print (literal-dots 100))": "(100 ...)",
    "(print (dots-in-use 1 ...) (dots-in-use 1 2))": "(1 ...) two",
    "(print (count-to-2) (count-to-2 a) (count-to-2 a b) (count-to-2 a b c d))": "0 1 2 many",
    "(jabberwocky mad-hatter) (print (mad-hatter))": "42",
    "(define-quoter bar x) (print (bar 1))": "x",
    "(print (let ((=> #f)) (cond (#t => 'ok))))": "ok",
    "(with-literal m x) (print (m x) (m y) (m 5))": "literal other other",
    "(with-own-literal m x) (print (m 1 2) (m x 7))": "no (literal 7)",
    "(with-own-dots m dots) (print (m 1 2 3))": "(1 2 3)",
    "(with-given-dots m dots) (print (m 1 2 3))": "(1 2 3)",
    "(define (f then) (my-if #t then 6)) (print (my-if #t then 5) (f 1))": "5 no-literal",
}


@pytest.mark.parametrize("use", USES)
def test_identifiers_of_macros(use: str) -> None:
    assert log(DEFINED + use) == [USES[use]]


MEANT = {
    "a local hides a global": "(define-syntax get (syntax-rules () ((_) y))) (print (let ((y 3)) (list y (get))))",
    "a function hides a function": "(define (one) 1) (define-macro (get) `(one)) (print (let ((one car)) (get)))",
    "a keyword hides a global": "(define-syntax get (syntax-rules () ((_) y))) (define (f :y) (list y (get))) (print (f :y 3))",
    "a loop hides a global": "(define-syntax get (syntax-rules () ((_) y))) (print (for/list ((y 2)) (+ y (get))))",
    "a guard hides a global": '(define-syntax get (syntax-rules () ((_) y))) (print (guard (y (#t (get))) (error "x")))',
    "an escape hides a global": "(define-syntax get (syntax-rules () ((_) y))) (print (let/ec y (y (get))))",
    "temporaries hide each other": "(define-syntax or2 (syntax-rules () ((_ a b) (let ((t a)) (if t t b)))))"
    " (print (let ((t 5)) (or2 #f t)) (or2 #f (or2 #f 7)))",
    "a local is named else": '(define (f else) (guard (e (#t else)) (error "x"))) (print (f 4))',
}


@pytest.mark.parametrize("name", MEANT)
def test_expansions_keep_what_names_mean(name: str) -> None:
    text = f'(define y 10)\n{MEANT[name]}\n(call "cube")'
    session = Session()
    checked = session.check(Source("<a>", text))
    assert checked.program is not None, [d.message for d in checked.diagnostics]
    assert log(session.expansion(checked.program)) == log(text)


def test_keyword_parameters_of_a_template() -> None:
    lamp = "(define height 9) (define-syntax lamp (syntax-rules () ((_ n x) (bind n (lambda ((:height 1)) x (print height '(:a height))"
    lamp += ' (call "cube" :scale height)))))) (lamp "l" (print height)) (call "l" :height 2)'
    assert log(lamp) == ["9", "2 (:a height)", "9", "1 (:a height)"]


def test_names_that_cannot_change_are_refused() -> None:
    text = "(define-syntax with (syntax-rules () ((_ f) (lambda (:y) (f y)))))"
    text += '(define (outer :y) (with (lambda (z) (list y z)))) (print ((outer :y 1) :y 2)) (call "cube")'
    assert log(text) == ["(1 2)"]
    session = Session()
    program = session.check(Source("<a>", text)).program
    assert program is not None
    with pytest.raises(SceneError, match="`y` shadows another `y`"):
        session.expansion(program)
