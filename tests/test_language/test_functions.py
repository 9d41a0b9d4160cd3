"""Lambda lists and what fills them (docs/language.md, section 4)."""

from __future__ import annotations

import pytest

from scenelang import Options, Session, Source
from scenelang.grammar.diagnostics import render_text
from scenelang.interpreter.values.limits import Limits

from .conftest import error, log, refused, shown, warned

CALLS = {
    # definition -> {call: value}
    "(define (f a (b 2)) (list a b))": {"(f 1)": "(1 2)", "(f 1 5)": "(1 5)"},
    "(define (f a (b (* 2 a)) (c (+ a b))) (list a b c))": {"(f 1)": "(1 2 3)", "(f 1 1)": "(1 1 2)"},
    "(define (f x (y (let ((c 1)) (+ c x))) (z (for/sum ((i y)) i))) (let ((w 5)) (list x y z w)))": {
        "(f 1)": "(1 2 1 5)",
        "(f 1 4)": "(1 4 6 5)",
        "(f 1 4 0)": "(1 4 0 5)",
    },
    "(define (f (:n (let ((c 1)) (set! c 2) (lambda () c)))) (n))": {"(f)": "2"},
    "(define (f a . more) (list a more))": {"(f 1)": "(1 ())", "(f 1 2 3)": "(1 (2 3))"},
    "(define (f a (b 2) . more) (list a b more))": {"(f 1)": "(1 2 ())", "(f 1 3 4 5)": "(1 3 (4 5))"},
    "(define (f :n) n)": {"(f :n 3)": "3"},
    "(define (f (:n 1) (:m (+ n 1))) (list n m))": {"(f)": "(1 2)", "(f :m 9)": "(1 9)", "(f :m 9 :n 8)": "(8 9)"},
    "(define (f a :n) (list a n))": {"(f 1 :n 2)": "(1 2)", "(f :n 2 1)": "(1 2)"},
    "(define (f a (:n 5) . more) (list a n more))": {"(f 1 2 :n 3 4)": "(1 3 (2 4))", "(f 1 2)": "(1 5 (2))"},
    "(define (f &keys t) t)": {"(f :a 1 :bB 2)": '(table "a" 1 "bB" 2)', "(f)": "(table)"},
    "(define (f a &keys t) (list a t))": {"(f 1 :b 2)": '(1 (table "b" 2))'},
    "(define (f :a &keys t) (list a t))": {"(f :b 2 :a 1)": '(1 (table "b" 2))'},
    "(define (f a b) (list a b))": {"(f :x 1)": "(:x 1)", "(apply f (list :x 1))": "(:x 1)"},
    "(define (f . xs) xs)": {"(f :x 1)": "(:x 1)", "(f)": "()"},
    "(define (f (:n 1)) n)": {
        "(apply f (list :n 7))": "7",
        "(map f '())": "()",
        '(apply f (keywords (table "n" 4)))': "4",
        "(let ((g f)) (g :n 2))": "2",
    },
    "(define (f _ b) b)": {"(f 1 2)": "2"},
    "(define (f _ _) 1)": {"(f 1 2)": "1"},
    "(define f (lambda (x) (define (g y) (+ x y)) g))": {"((f 1) 2)": "3"},
    # annotations
    "(define (f n::Float) n)": {"(f 1)": "1", "(f 1.5)": "1.5"},
    "(define (f n::Integer) n)": {"(f 2.0)": "2"},
    "(define (f v::Vector) v)": {"(f (list 1 2))": "[1 2]", "(f [1 2])": "[1 2]"},
    "(define (f z::Embedding) (embedding-text z))": {'(f "ivory")': "ivory", "(f <z3>)": "none"},
    "(define (f xs::List) (length xs))": {"(f (list 1 2))": "2", "(f (mutable-list 1))": "1"},
    "(define (f xs::List[Integer]) xs)": {"(f (list 1 2.0))": "(1 2)"},
    "(define (f p::Tuple[Integer, Float]) p)": {"(f (list 1 2.5))": "(1 2.5)"},
    "(define (f _::Integer) 1)": {"(f 1)": "1"},
    "(define (f (n::Integer 3)) n)": {"(f)": "3", "(f 4.0)": "4"},
    "(define (f :c::Vector) c)": {"(f :c (list 1 2 3))": "[1 2 3]"},
    "(define (f (:c::Float 1)) c)": {"(f)": "1"},
    "(define (f . r::List) r)": {"(f 1 2)": "(1 2)"},
    "(define (f x::Any y::Boolean w::Word) (list x y w))": {'(f none #t "a")': '(none #t "a")'},
    "(define (f g::Function) (g 1))": {"(f (lambda (x) x))": "1", "(f -)": "-1"},
    "(define (f n::Number) n)": {"(f 1)": "1", "(f 1.5)": "1.5"},
}


@pytest.mark.parametrize("definition", CALLS)
def test_calls(definition: str) -> None:
    for call, expected in CALLS[definition].items():
        assert shown(call, definition) in (expected, f'"{expected}"'), call


REFUSED = {
    "(define (f a) a) (f)": "arity", "(define (f a) a) (f 1 2)": "arity", "(define (f a (b 1)) a) (f 1 2 3)": "arity",
    "(define (f :n) n) (f)": "keyword", "(define (f :n) n) (f :m 1)": "keyword", "(define (f :n) n) (f :n 1 :n 2)": "keyword",
    "(define (f :n) n) (f :n)": "keyword", "(define (f :n) n) (f 1)": "arity", "(define (f :n) n) (f 1 :n 1)": "arity",
    "(define (f n::Integer) n) (f 1.5)": "type", "(define (f n::Integer) n) (f #t)": "type",
    '(define (f n::Float) n) (f "1")': "type", "(define (f v::Vector) v) (f (list 1 #t))": "type",
    "(define (f m::Matrix) m) (f [1 2 3])": "type", "(define (f s::String) s) (f 'a)": "type",
    "(define (f g::Function) g) (f 1)": "type", "(define (f e::Entity) e) (f 1)": "type",
    "(define (f xs::List[Integer]) xs) (f (list 1 2.5))": "type", "(define (f n::Whole) n)": "type-name",
    "(define (f a b a) a)": "duplicate", "(define (f a :a) a)": "duplicate", "(define (f (a 1) b) b)": "lambda-list",
    "(define (f &keys) 1)": "lambda-list", "(define (f (a 1 2)) a)": "lambda-list", "(define (f 1) 1)": "lambda-list",
    "(define f (lambda [a] a))": "bracket", "(define x::Integer 1)": "lambda-list", "(let ((x::Integer 1)) x)": "lambda-list",
    "(print x::Integer)": "unbound",
}  # fmt: skip


@pytest.mark.parametrize("program", REFUSED)
def test_refused(program: str) -> None:
    assert refused(program) == REFUSED[program]


def test_defaults_are_evaluated_at_the_call() -> None:
    program = "(define n 0) (define (f (x (begin (set! n (+ n 1)) n))) x) (print (f) (f) (f 9) (f))"
    assert log(program) == ["1 2 9 3"]


def test_arity_errors_show_the_parameters() -> None:
    assert "(area w h)" in str(error("(define (area w h) (* w h)) (area 1)").hint)
    assert "(list-ref" in str(error("(list-ref (list 1))").hint)
    assert "did you mean `:height`" in str(error("(define (f (:height 1)) height) (f :hieght 2)").hint)


# --- called by `call` -------------------------------------------------------------------------------------------------

ENTITY_FUNCTIONS = {
    # parameters and body -> what is printed when (call "w" "z" "a" "b" :n 1) runs it
    "(lambda () (print 'none) (union))": "none",
    "(lambda (z) (print (embedding-text z)) (union))": "z",
    "(lambda (z more) (print (embedding-text z) (length more)) (union))": "z 2",
    "(lambda all (print (map embedding-text all)) (union))": '("z" "a" "b")',
    "(lambda (z . more) (print (map embedding-text more)) (union))": '("a" "b")',
    "(lambda (z (more 5)) (print more) (union))": "5",
    "(lambda (:n) (print n) (union))": "1",
    "(lambda (z :n) (print (embedding-text z) n) (union))": "z 1",
    "(lambda (&keys t) (print t) (union))": '(table "n" 1)',
    "(lambda ((:n 5)) (print n) (union))": "1",
}


@pytest.mark.parametrize("function", ENTITY_FUNCTIONS)
def test_entity_functions_take_what_they_ask_for(function: str) -> None:
    program = f'(bind "w" {function}) (bind "r" (lambda () (call "w" "z" "a" "b" :n 1))) (scene "r")'
    if ":n" not in function and "&keys" not in function:
        program = program.replace(" :n 1)", ")")
    assert log(program) == [ENTITY_FUNCTIONS[function]]


def test_entity_functions_that_do_not_fit() -> None:
    def called(function: str, call: str = '(call "w")') -> str:
        return refused(f'(bind "w" {function}) (bind "r" (lambda () {call})) (scene "r")')

    assert called("(lambda (a b c) (union))") == "arity"
    assert called("(lambda (:n) (union))") == "keyword"
    assert called("(lambda (:n) (union))", '(call "w" :m 1 :n 2)') == "keyword"
    assert called("(lambda (:n::Integer) (union))", '(call "w" :n "x")') == "type"
    assert called("(lambda () 5)") == "parts"
    assert called("(lambda () none)") == "parts"
    assert called("(lambda () (union))", '(call "w" 3)') == "embedding"
    assert called("(lambda () (union))", "(call 'w)") == "word"
    assert called("(lambda () (union))", '(call "w" :n)') == "keyword"


def test_attributes_that_an_embedding_brings_along_may_be_unknown() -> None:
    program = """(bind "w" (lambda ((:n 1)) (print n) (union)))
    (bind "r" (lambda () (union (call "w" (embedding :m 5)) (call "w" (embedding :m 5 :n 2)))))(scene "r")"""
    assert log(program) == ["1", "2"]


def test_optional_positionals_of_a_word_are_warned_of() -> None:
    assert "optional-embedding" in warned('(bind "w" (lambda ((n 1)) (union)))')


def test_apply_entity_function() -> None:
    define = '(define z (embedding "t" :n 4)) (define zs (list (embedding "a")))'
    assert shown("(apply-entity-function (lambda () 1) z zs)", define) == "1"
    assert shown("(apply-entity-function (lambda (z) (embedding-text z)) z zs)", define) == '"t"'
    assert shown("(apply-entity-function (lambda (z zs) (length zs)) z zs)", define) == "1"
    assert shown("(apply-entity-function (lambda all (length all)) z zs)", define) == "2"
    assert shown("(apply-entity-function (lambda (:n) n) z zs)", define) == "4"
    assert refused(f"{define} (apply-entity-function (lambda (a b c) 1) z zs)") == "arity"
    assert refused(f"{define} (apply-entity-function 5 z zs)") in ("type", "not-a-procedure")


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ('(bind "leg" (lambda ((:height 1)) (call "cube" :scale height))) (call (string-append "l" "eg") :hieght 2)',
         '"leg" has no parameter `:hieght`'),
        ('(define (leg (:height 1)) height) ((car (list leg)) :hieght 2)', "`leg` has no parameter `:hieght`"),
    ],
)  # fmt: skip
def test_an_unknown_keyword_of_a_callee_that_is_computed(program: str, message: str) -> None:
    found = Session().evaluate(Source("a.scene", f'{program} (bind "a" (lambda () (call "cube")))')).diagnostics
    assert message in [d.message for d in found]


def test_a_function_that_is_called_twice_in_a_row_is_one_line_of_the_chain() -> None:
    program = """(define (f n) (if (= n 0) (ref (list 1) 9) (+ 1 (f (- n 1)))))
(bind "a" (lambda () (call "cube" :scale (f 1))))"""
    (found,) = (d for d in Session().evaluate(Source("a.scene", program)).diagnostics if d.is_error)
    assert 'in `f`, called at a.scene:1:49 (and 1 more)\n   in "a"' in render_text(found)


@pytest.mark.parametrize("times", [120, 20_000])  # by closures, and by generated code
def test_apply_in_tail_position_is_no_deeper_call(times: int) -> None:
    program = f"""(define (down n) (if (= n 0) .5 (apply down (list (- n 1)))))
(bind "a" (lambda () (call "cube" :scale (down {times}))))"""
    result = Session(Options(limits=Limits(depth=40))).evaluate(Source("a.scene", program))
    assert result.scene is not None, result.diagnostics
