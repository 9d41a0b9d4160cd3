"""What the formatter learns of macros."""

from __future__ import annotations

from pathlib import Path

import pytest

from formatter.texts import INDENTS
from scenelang.grammar.datum import Source
from scenelang.grammar.formatter import format_text, learnt_indents
from scenelang.grammar.reader import read
from scenelang.session.formatting import indents_of

RULES = [
    ("(define-syntax m (syntax-rules () ((_ body ...) (begin body ...))))", 0),
    ("(define-syntax m (syntax-rules () ((_ a b body ...) (begin body ...))))", 2),
    ("(define-syntax m (syntax-rules () ((_ a things ...) (when a things ...))))", 1),
    ("(define-syntax m (syntax-rules () ((_ a . things) (when a . things))))", 1),
    ("(define-syntax m (syntax-rules () ((_ (key value) ...) (list key ...))))", 0),
    ("(define-syntax m (syntax-rules *** () ((_ a body ***) (begin body ***))))", 1),
    ("(define-syntax m (syntax-rules () ((_ a) a) ((_ a b body ...) (begin body ...))))", 2),
    ("(define-syntax m (syntax-rules () ((_ things ...) (list things ...))))", None),
    ("(define-syntax m (syntax-rules () ((_ a) a)))", None),
    ("(define-macro (m a b . rest) 1)", 2),
    ("(define-macro (m . rest) 1)", 0),
    ("(define-macro (m a) 1)", None),
    ("(let-syntax ((m (syntax-rules () ((_ a body ...) (begin body ...))))) 1)", 1),
    ("(define (f) (define-macro (m a . body) 1) 2)", 1),
    ("(define-syntax m)", None),
    ("(define-macro m 1 2)", None),
    ("(define-syntax 3 (syntax-rules () ((_ a body ...) 1)))", None),
]


@pytest.mark.parametrize(("text", "indent"), RULES)
def test_indent(text: str, indent: int | None) -> None:
    assert learnt_indents(read(Source("<test>", text)).forms, INDENTS).get("m") == indent


def test_a_macro_hides_a_form() -> None:
    text = "(define-macro (while test) test)\n"
    forms = read(Source("<test>", text)).forms
    assert INDENTS["while"] == 1
    assert "while" not in learnt_indents(forms, INDENTS)


def test_macros_of_imported_files(tmp_path: Path) -> None:
    (tmp_path / "inner.scene").write_text("(define-macro (deep . body) `(begin ,@body))")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "a.scene").write_text(
        '(import "../inner.scene")\n(import "a.scene")\n(define-macro (twice n . body) `(begin ,@body))'
    )
    text = '(import "sub/a.scene" :prefix a/) (import "missing.scene") (a/twice 2\n(f)\n(g))'
    known = indents_of(text, tmp_path)
    assert known["a/twice"] == 1
    assert "twice" not in known
    assert format_text(text, known).endswith("(a/twice 2\n  (f)\n  (g))\n")
    assert indents_of(text, None) == INDENTS
    assert indents_of("(import", tmp_path) == INDENTS
