"""Every format accepts and rejects the same programs, in the programs that read it."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenelang.interpreter.expand.forms import FORMS, full_grammar, strict_grammar

from .cases import BAD, GOOD, NOT_STRICT, OTHERS, ROOT, STRICT, UNSEEN, WRONG
from .decoders import FORMATS, acceptor

NAME = lambda path: str(path.relative_to(ROOT))


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("path", GOOD, ids=NAME)
@pytest.mark.sampled(8)
def test_every_example_is_accepted(form: str, path: Path) -> None:
    assert acceptor(form)(path.read_bytes())


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("path", OTHERS, ids=NAME)
def test_mistakes_of_other_kinds_are_not_the_grammars_business(form: str, path: Path) -> None:
    assert acceptor(form)(path.read_bytes())


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("path", WRONG, ids=NAME)
def test_every_mistake_of_shape_is_rejected(form: str, path: Path) -> None:
    assert not acceptor(form)(path.read_bytes())


@pytest.mark.parametrize("form", FORMATS)
def test_the_exceptions_are_exceptions(form: str) -> None:
    assert all(acceptor(form)((BAD / name).read_bytes()) for name in UNSEEN)


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize(
    ("text", "is_accepted"),
    [
        (b"(define (f scene) (+ scene 1))", True),
        (b"(let ((param 1)) param)", True),
        (b"(define (f if) 1)", False),
        (b"(define scene 1)", False),
        (b"(define (f scene) (scene 1))", False),
        (b"(define (f else) 1)", False),
    ],
)
def test_names_of_forms_as_variables(form: str, text: bytes, is_accepted: bool) -> None:
    assert acceptor(form)(text) == is_accepted


@pytest.mark.parametrize("form", FORMATS)
def test_the_strict_grammar_is_the_papers(form: str) -> None:
    assert acceptor(form, True)(STRICT.read_bytes())
    others = [path for path in GOOD if path != STRICT]
    assert not [path for path in (*NOT_STRICT, *WRONG, *others) if acceptor(form, True)(path.read_bytes())]


def test_every_form_has_a_rule_and_every_rule_a_form() -> None:
    from scenelang.interpreter.expand import forms as shapes

    tables = (shapes.EXPRESSIONS, shapes.DEFINITIONS, shapes.MACROS, shapes.TOP_LEVEL)
    heads = [head for table in tables for head in table]
    assert len(heads) == len(set(heads))
    assert {*heads, *shapes.SPELLED_OUT} == set(FORMS)


@pytest.mark.parametrize("grammar", [full_grammar(), strict_grammar()], ids=["full", "strict"])
def test_every_rule_that_is_used_exists_and_is_used(grammar: object) -> None:
    from scenelang.grammar.export.model import Grammar, Ref, parts

    assert isinstance(grammar, Grammar)
    used = {part.name for rule in grammar.rules.values() for part in parts(rule) if isinstance(part, Ref)}
    hidden = {"datum"}  # what `#;` hides
    assert used | hidden | {grammar.start} == set(grammar.rules) | hidden


RIGHT_TEXTS = {
    "a name that begins a form's": "(define iffy 1) (let*ish 2) (for/listing 3)",
    "no white space where none is needed": "(define(f x)(+ x 1))(f 2)'a`(b ,x ,@y)",
    "signs and comparisons": "(- 1) (+) (@ a b) (map @ `(,a @)) (< 1 2) (-> 3) (<= .5 1e-3) (list -a +b)",
    "comments": "; a\n#| b #| c |# ##|# d |# ||# (f #| e |# 1 #; (g 2) 3 #;4 ) #;(h) ; end",
    "types": "(lambda (a::List[Tuple[Word, Any]] (b::Float 2) :c::Vector (:d 3) &keys t . r::List) a)",
    "strings": r'(f "a\n\x41; \u0041 \" \\ (" "b" "line' + "\n" + r'two")',
    "a name for what is a form elsewhere": "(lambda (scene param) (+ scene param))",
    "letters beyond ASCII": "(define größe 1) (define π 3.14) (f größe → α)",
    "operands of macros": "(several i of 3 (define x i) x) (choose a else b => c)",
    "patterns": "(let ((((a . b) (c _)) 1)) (for/list (((x . more) xs) :when x (y x) :break y) x))",
    "templates in templates": "`(a `(b ,(c ,d) ,',e) '(f ,@g) [,h])",
    "rules": "(define-syntax m (syntax-rules (else) ((_ (a b) ... . c) '(a ... (b . c))) ((m [x ...]) ,if)))",
    "an ellipsis of one's own": "(define-syntax m (syntax-rules ___ () ((_ a ___ b ___) (list ...))))",
    "an empty program": "",
    "only a comment": "; nothing",
}
WRONG_TEXTS = {
    "a number that touches a name": "(f 3px)",
    "an index": "(f xs[0])",
    "a fraction": "(f 1/2)",
    "a keyword without a name": "(f :)",
    "an escape that does not exist": r'(f "\q")',
    "a surrogate": r'(f "\ud800")',
    "a form as a value": "(map if xs)",
    "a form without its parts": "(if)",
    "a form's name as a parameter": "(lambda (cond) cond)",
    "a form's name with a type": "(lambda (if::Float) 1)",
    "brackets around bindings": "(let [(a 1)] a)",
    "a loop without its list": "(for/list (x xs) x)",
    "an else in the middle": "(cond (else 1) (#t 2))",
    "an else alone": "(else 1)",
    "an arrow with two functions": "(cond (a => f g))",
    "definitions as values": "(if a (define b 1))",
    "a body of macros": "(lambda () (define-syntax m (syntax-rules ())))",
    "a required parameter after an optional one": "(lambda ((a 1) b) a)",
    "a form of the top level in a body": '(define (f) (import "a.scene"))',
    "an ellipsis": "(union ...)",
    "an ellipsis first": "(define-syntax m (syntax-rules () ((_ (... a)) 1)))",
    "a splice without a list": "`,@(f)",
    "nothing evaluated": "()",
    "nothing evaluated in a template of a template": "`(a `(b ,(c ,())))",
    "nothing evaluated in a template": "`(a ,())",
    "a pair": "(f . x)",
    "a comment that is open": "#| #| |#",
    "half a comment hides": "(f #;",
}


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("case", RIGHT_TEXTS)
def test_right(form: str, case: str) -> None:
    assert acceptor(form)(RIGHT_TEXTS[case].encode())


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("case", WRONG_TEXTS)
def test_wrong(form: str, case: str) -> None:
    assert not acceptor(form)(WRONG_TEXTS[case].encode())
