"""Evaluation forms, bodies, loops, errors (docs/language.md, section 5)."""

from __future__ import annotations

import pytest

from .conftest import error, log, refused, run, shown

EXPRESSIONS = {
    # choices
    '(if #t 1 2)': "1", '(if #f 1 2)': "2", '(if none 1 2)': "2", '(if 0 1 2)': "1", '(if "" 1 2)': "1",
    "(if '() 1 2)": "1", "(if #f 1)": "none", "(cond (#f 1) (2) (else 3))": "2", "(cond (#f 1) (else 3))": "3",
    "(cond (#f 1))": "none", "(cond ((assoc 2 '((1 a) (2 b))) => second) (else 0))": "b", "(cond (#f => car) (else 0))": "0",
    "(cond (#t 1 2 3))": "3", "(case 3 ((1 2) 'low) ((3 4) 'mid) (else 'high))": "mid",
    "(case \"b\" ((\"a\") 1) ((\"b\" \"c\") 2))": "2", "(case 9 ((1) 1))": "none", "(case 'x ((x y) 1) (else 2))": "1",
    "(case 1.0 ((1) 'a) (else 'b))": "b", "(case 1 ((1.0) 'a) ((1) 'b))": "b",
    "(case 1.5 ((1.5) 'a))": "a", "(case none ((#f) 'a) ((none) 'b))": "b", "(case [1 2] (([1 2]) 'a))": "a",
    "(case 5 ((1) 0) (else => (lambda (n) (* 2 n))))": "10", "(case (list 1 2) (((1 2)) 'pair) (else 'no))": "pair",
    "(when #t 1 2)": "2", "(when #f 1)": "none", "(unless #f 1 2)": "2", "(unless #t 1)": "none",
    "(and)": "#t", "(and 1 2)": "2", "(and 1 #f 2)": "#f", "(and 1 none 2)": "none",
    "(or)": "#f", "(or #f none 3 4)": "3", "(or #f none)": "none", "(not 0)": "#f", "(not none)": "#t",
    # local names
    "(let ((a 1) (b 2)) (+ a b))": "3", "(let* ((a 1) (b (+ a 1))) b)": "2", "(let () 5)": "5",
    "(let ((a 1)) (let ((a 2) (b a)) (list a b)))": "(2 1)", "(let* ((a 1) (a (+ a 1))) a)": "2",
    "(letrec ((even (lambda (n) (if (= n 0) #t (odd (- n 1))))) (odd (lambda (n) (if (= n 0) #f (even (- n 1)))))) (even 100))": "#t",
    "(letrec* ((a 1) (b (+ a 1))) b)": "2", "(let-values (((a b) (values 1 2)) ((c) (values 3))) (list a b c))": "(1 2 3)",
    "(let*-values (((a b) (values 1 2)) ((c) (values (+ a b)))) c)": "3", "(let-values (((a . rest) (list 1 2 3))) rest)": "(2 3)",
    "(values 1 2)": "(1 2)", "(begin 1 2 3)": "3", "(begin0 1 2 3)": "1", "(let ((a 1)) (begin0 a (set! a 9)))": "1",
    # patterns
    "(let (((a b) (list 1 2))) (+ a b))": "3", "(let* (((a . more) (list 1 2 3))) more)": "(2 3)",
    "(let (((a (b c) . d) (list 1 (list 2 3) 4 5))) (list a b c d))": "(1 2 3 (4 5))",
    "(let (((_ b) (list 1 2))) b)": "2", "(let (((x y z) [1 2 3])) (+ x y z))": "6", '(let (((a b) "xy")) b)': "y",
    "(let (((a b) (mutable-list 1 2))) a)": "1", "(let ((_ 1)) 2)": "2", "(let (((a . b) (list 1))) b)": "()",
    # functions
    "((lambda (x) (* x x)) 3)": "9", "((lambda xs xs) 1 2)": "(1 2)", "((lambda (a . b) b) 1)": "()", "((lambda (a . b) (list a b)) 1 2 3)": "(1 (2 3))",
    "(let ((f (lambda (x) (lambda () (set! x (+ x 1)) x)))) (let ((g (f 1))) (g) (g)))": "3",
    "(apply + 1 2 (list 3 4))": "10", "(apply max '(1 5 2))": "5", "(map + '(1 2) '(10 20))": "(11 22)",
    # loops
    "(let loop ((i 0) (sum 0)) (if (= i 5) sum (loop (+ i 1) (+ sum i))))": "10",
    "(do ((i 0 (+ i 1)) (xs (list) (cons i xs))) ((= i 3) xs))": "(2 1 0)", "(do ((i 0 (+ i 1))) ((= i 3)))": "none",
    "(let ((n 0)) (while (< n 3) (set! n (+ n 1))) n)": "3", "(while #f 1)": "none",
    "(map (lambda (f) (f)) (let loop ((i 0) (fs (list))) (if (= i 3) (reverse fs) (loop (+ i 1) (cons (lambda () i) fs)))))": "(0 1 2)",
    "(map (lambda (f) (f)) (do ((i 0 (+ i 1)) (fs (list) (cons (lambda () i) fs))) ((= i 3) (reverse fs))))": "(0 1 2)",
    # leaving early
    "(let/ec return (+ 1 (return 5)))": "5", "(let/ec return 7)": "7", "(let/ec k (for ((i 10)) (when (= i 3) (k i))) 'none)": "3",
    "(let/ec a (+ 1 (let/ec b (a 10))))": "10", "(let/ec k (k))": "none",
    "(let/ec k (map (lambda (x) (if (= x 2) (k 'found) x)) '(1 2 3)))": "found",
    # errors
    "(guard (e (#t (error-message e))) (error \"bad thing:\" 3))": "bad thing: 3", "(guard (e ((symbol? e) (list e))) (raise 'oops))": "(oops)",
    "(guard (e ((string? e) 1) ((number? e) (* 2 e))) (raise 4))": "8", '(guard (e ((error-is? e "zero-division") 0)) (/ 1 0))': "0",
    '(guard (e ((error-is? e "index") "out")) (ref (list 1) 5))': "out", "(guard (e (#f 1) (else 2)) (raise 0))": "2",
    "(guard (e ((= e 1) 'outer)) (guard (f ((= f 2) 'inner)) (raise 1)))": "outer", "(guard (e (#t 1)) 5)": "5",
    '(guard (e (#t (error-code e))) (car 5))': "E401", "(guard (e (#t e)) (raise (list 1 2)))": "(1 2)",
    '(guard (e ((error-is? e "user") "user")) (error "x"))': "user",
    "(guard (e ((assoc 'a e) => cdr) (else 0)) (raise (list (cons 'a 42))))": "42",
    # quotation
    "'(1 \"a\" b :c #t)": '(1 "a" b :c #t)', "'()": "()", "'(a . b)": "(a . b)", "'(1 . (2 3))": "(1 2 3)", "'[1 2]": "[1 2]",
    "`(1 ,(+ 1 1) ,@(list 3 4))": "(1 2 3 4)", "`(1 . ,(+ 1 1))": "(1 . 2)", "`,(+ 1 2)": "3",
    "`(a `(b ,(c ,(+ 1 2))))": "(a (quasiquote (b (unquote (c 3)))))",
    "`[1 ,(+ 1 1) 3]": "[1 2 3]", "`(x [,@(list 1 2)])": "(x [1 2])", "(quasiquote (1 (unquote (+ 1 1))))": "(1 2)", "''a": "(quote a)",
    # arrays
    "[1 2 3]": "[1 2 3]", "[[1 2] [3 4]]": "[[1 2] [3 4]]", "[(+ 1 1) 2.5]": "[2.0 2.5]", "[[1 2] (vector 3 4)]": "[[1 2] [3 4]]",
}  # fmt: skip


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_expressions(expression: str) -> None:
    assert shown(expression) in (EXPRESSIONS[expression], f'"{EXPRESSIONS[expression]}"')


def test_arguments_run_from_left_to_right() -> None:
    assert log("(define (f x) (print x) x) (list (f 1) (f 2) (f 3)) ((begin (print 'head) +) (f 4))") == [
        "1", "2", "3", "head", "4",
    ]  # fmt: skip
    assert log("(define (f x) (print x) x) [(f 1) (f 2)] (let ((a (f 3)) (b (f 4))) 0)") == ["1", "2", "3", "4"]


BODIES = {
    "function": "(define (f) (define a 1) (print 'x) (define b (+ a 1)) (* a b)) (print (f))",
    "let": "(print (let () (define a 1) (define b (+ a 1)) (* a b)))",
    "when": "(print (when #t (define a 1) (define b (+ a 1)) (* a b)))",
    "cond": "(print (cond (#t (define a 1) (define b (+ a 1)) (* a b))))",
    "case": "(print (case 1 ((1) (define a 1) (define b (+ a 1)) (* a b))))",
    "else": "(print (cond (#f 1) (else (define a 1) (define b (+ a 1)) (* a b))))",
    "for/list": "(print (first (for/list ((i 1)) (define a 1) (define b (+ a 1)) (* a b))))",
    "let/ec": "(print (let/ec k (define a 1) (define b (+ a 1)) (* a b)))",
    "guard": "(print (guard (e (#t 0)) (define a 1) (define b (+ a 1)) (* a b)))",
    "guard's clause": "(print (guard (e (#t (define a 1) (define b (+ a 1)) (* a b))) (raise 1)))",
    "named let": "(print (let loop () (define a 1) (define b (+ a 1)) (* a b)))",
    "begin": "(print (let () (begin (define a 1) (define b (+ a 1))) (* a b)))",
    "define-values": "(print (let () (define-values (a b) (list 1 2)) (* a b)))",
    "later function": "(define (f) (define (g) (* a b)) (define a 1) (define b 2) (g)) (print (f))",
}


@pytest.mark.parametrize("name", BODIES)
def test_bodies_define_anywhere(name: str) -> None:
    assert log(BODIES[name])[-1] == "2"


def test_while_bodies_define_anew_at_each_turn() -> None:
    program = "(define fs (list)) (define i 0) (while (< i 3) (define j i) (set! fs (cons (lambda () j) fs)) (set! i (+ i 1)))"
    assert shown("(map (lambda (f) (f)) fs)", program) == "(2 1 0)"


def test_inner_definitions_do_not_leak() -> None:
    assert refused("(define (f) (define inner 1) inner) (print inner)") == "unbound"
    assert refused("(when #t (define inner 1)) (print inner)") == "unbound"


def test_top_level_definitions_see_one_another() -> None:
    assert log("(define (f) (g)) (define (g) 3) (print (f))") == ["3"]
    assert refused("(define a b) (define b 1)") == "undefined-yet"
    assert log("(define a 1) (define (f) a) (define a 2) (print (f))") == ["2"]


def test_define_values_at_top_level() -> None:
    assert log("(define-values (a (b . c)) (list 1 (list 2 3 4))) (print a b c)") == ["1 2 (3 4)"]
    assert refused("(define-values (a b) (list 1))") == "pattern"


def test_set_wants_a_variable_that_exists() -> None:
    assert refused("(set! nothing 1)") == "unbound"
    assert log("(define x 1) (define (f) (set! x (+ x 1))) (f) (f) (print x)") == ["3"]


def test_patterns_that_do_not_fit() -> None:
    assert refused("(let (((a b) (list 1 2 3))) a)") == "pattern"
    assert refused("(let (((a b . c) (list 1))) a)") == "pattern"
    assert refused("(let (((a b) 5)) a)") == "type"


FOR = {
    "(for/list ((x (list 1 2 3))) (* x x))": "(1 4 9)", "(for/list ((i 3)) i)": "(0 1 2)", "(for/list ((x [1 2])) x)": "(1 2)",
    '(for/list ((c "ab")) c)': '("a" "b")', '(for/list ((k (table "a" 1 "b" 2))) k)': '("a" "b")', "(for/list ((x (set 1 2))) x)": "(1 2)",
    "(for/list ((row [[1 2] [3 4]])) row)": "([1 2] [3 4])", "(for/list ((x (mutable-list 1 2))) x)": "(1 2)", "(for/list ((x '())) x)": "()",
    "(for/list ((x '(1 2 3)) (i (iota 3))) (list x i))": "((1 0) (2 1) (3 2))", "(for/list ((x '(1 2 3)) (i 2)) (list x i))": "((1 0) (2 1))",
    "(for*/list ((x '(1 2)) (y '(a b))) (list x y))": "((1 a) (1 b) (2 a) (2 b))",
    "(for/list ((x '(1 2 3 4)) :when (odd? x)) x)": "(1 3)", "(for/list ((x '(1 2 3 4)) :unless (odd? x)) x)": "(2 4)",
    "(for/list ((x '(1 2 3 4)) :break (= x 3)) x)": "(1 2)",
    "(for/list ((x '(1 2)) :when #t (y '(a b))) (list x y))": "((1 a) (1 b) (2 a) (2 b))",
    "(for/list ((x '(1 2 3)) :when (odd? x) (y x)) (list x y))": "((1 0) (3 0) (3 1) (3 2))",
    "(for*/list ((x 3) (y x)) (list x y))": "((1 0) (2 0) (2 1))",
    "(for*/list ((x 5) (y 5) :break (= (+ x y) 3)) (list x y))": "((0 0) (0 1) (0 2))",
    "(for/list (((x z) '((0 1) (2 3)))) (+ x z))": "(1 5)", "(for/list (((a . b) '((1 2 3)))) b)": "((2 3))",
    "(for/list ((_ 3)) 'x)": "(x x x)", "(for ((i 3)) i)": "none", "(for/sum ((x '(1 2 3))) x)": "6", "(for/sum ((x '())) x)": "0",
    "(for/sum ((x '(1 2))) [x x])": "[3 3]", "(for/append ((x '(1 2))) (list x x))": "(1 1 2 2)",
    "(for/and ((x '(1 2 3))) (< x 9))": "#t", "(for/and ((x '(1 20 3))) (< x 9))": "#f", "(for/and ((x '())) #f)": "#t",
    "(for/or ((x '(1 2 3))) (and (> x 1) x))": "2", "(for/or ((x '())) #t)": "#f", "(for/first ((x '(1 2 3)) :when (even? x)) (* 10 x))": "20",
    "(for/first ((x '())) x)": "#f", "(for/fold ((sum 0)) ((x '(1 2 3))) (+ sum x))": "6",
    "(for/fold ((a 0) (b 1)) ((i 5)) (list b (+ a b)))": "(5 8)",
    "(for*/fold ((n 0)) ((i 3) (j 3)) (+ n 1))": "9", '(for/table ((x \'("a" "b")) (i 2)) (list x i))': '(table "a" 0 "b" 1)',
    "(for/set ((x '(1 2 1))) x)": "(set 1 2)", "(for*/sum ((i 3) (j 3)) (* i j))": "9", "(for*/set ((i 2) (j 2)) (+ i j))": "(set 0 1 2)",
    "(for*/or ((i 3) (j 3)) (and (= (* i j) 4) (list i j)))": "(2 2)", "(for*/and ((i 3) (j 3)) (< i 3))": "#t",
    "(for*/first ((i 3) (j 3) :when (> i j)) (list i j))": "(1 0)", "(for*/append ((i 2) (j 2)) (list i))": "(0 0 1 1)",
    "(for*/table ((i 2)) (list i i))": "(table 0 0 1 1)", "(length (for/union ((i 3)) (call \"cube\")))": "3",
    '(length (for*/union ((i 2) (j 2)) (list (call "cube") (call "sphere"))))': "8",
    "(map (lambda (f) (f)) (for/list ((i 3)) (lambda () i)))": "(0 1 2)", "(let ((i 9)) (for ((i 3)) i) i)": "9",
    "(let/ec k (for/list ((i 10)) (if (= i 2) (k i) i)))": "2", "(for/list () 1)": "(1)", "(let ((xs '(1 2))) (for/list ((xs xs)) xs))": "(1 2)",
}  # fmt: skip


@pytest.mark.parametrize("expression", FOR)
def test_for(expression: str) -> None:
    assert shown(expression) == FOR[expression]


def test_for_refuses() -> None:
    assert refused("(for ((x 5.5)) x)") == "type"
    assert refused("(for ((x none)) x)") == "type"
    assert refused("(for/list ((x '(1)) (x '(2))) x)") == "duplicate"
    assert refused("(for ((x '(1)) :until #t) x)") == "syntax"
    assert refused("(for ((x '(1)) :when) x)") == "syntax"
    assert refused("(for/table ((x 2)) x)") in ("pattern", "value", "type")
    assert refused("(for/append ((x 2)) x)") == "type"
    assert refused("(define t (table 1 1)) (for ((k t)) (set-ref! t (+ k 1) 1))") == "changed"


def test_a_list_that_grows_in_a_loop_is_seen() -> None:
    assert shown(
        "(begin (for ((x xs)) (when (< (length xs) 5) (push! xs x))) xs)", "(define xs (mutable-list 1 2))"
    ) == ("(mutable-list 1 2 1 2 1)")


TAIL_CALLS = {
    "if": "(define (f n) (if (= n 0) 'done (f (- n 1))))",
    "cond": "(define (f n) (cond ((= n 0) 'done) (else (f (- n 1)))))",
    "case": "(define (f n) (case n ((0) 'done) (else (f (- n 1)))))",
    "and, or": "(define (f n) (or (and (= n 0) 'done) (f (- n 1))))",
    "when": "(define (f n) (if (= n 0) 'done (when #t (f (- n 1)))))",
    "let": "(define (f n) (let ((m (- n 1))) (define k m) (if (< k 0) 'done (f k))))",
    "begin": "(define (f n) (begin 1 (if (= n 0) 'done (f (- n 1)))))",
    "mutual": "(define (f n) (if (= n 0) 'done (g (- n 1)))) (define (g n) (if (= n 0) 'done (f (- n 1))))",
    "local": "(define (f n) (define (go k) (if (= k 0) 'done (go (- k 1)))) (go n))",
    "rest": "(define (f n . more) (if (= n 0) 'done (f (- n 1) n n)))",
    "optional": "(define (f n (m 2)) (if (= n 0) 'done (f (- n 1))))",
    "keyword": "(define (f :n) (if (= n 0) 'done (f :n (- n 1))))",
    "closure": "(define (f n) ((lambda (k) (if (= k 0) 'done (f (- k 1)))) n))",
    "passed": "(define (f n (k none)) (define (loop self n) (if (= n 0) 'done (self self (- n 1)))) (loop loop n))",
    "named let": "(define (f n) (let loop ((i n)) (if (= i 0) 'done (loop (- i 1)))))",
    "do": "(define (f n) (do ((i n (- i 1))) ((= i 0) 'done)))",
    "apply": "(define (f n) (if (= n 0) 'done (apply f (list (- n 1)))))",
    "set": "(define f none) (set! f (lambda (n) (if (= n 0) 'done (f (- n 1)))))",
}


@pytest.mark.parametrize("name", TAIL_CALLS)
def test_tail_calls_need_no_room(name: str) -> None:
    call = "(f :n 30000)" if name == "keyword" else "(f 30000)"
    from scenelang.interpreter.values.limits import Limits

    assert shown(call, TAIL_CALLS[name], limits=Limits(depth=300)) == "done"


def test_a_million_turns() -> None:
    from scenelang.interpreter.values.limits import Limits

    text = "(define (f n acc) (if (= n 0) acc (f (- n 1) (+ acc 1))))"
    assert shown("(f 1000000 0)", text, limits=Limits(depth=100, memory=50_000_000)) == "1000000"


def test_uncaught_errors() -> None:
    assert error('(error "bad:" (list 1 2))').message == "bad: (1 2)"
    assert refused("(raise 5)") == "user"
    assert refused("(guard (e ((string? e) 1)) (raise 5))") == "user"
    assert refused('(guard (e ((error-is? e "key") 1)) (car 5))') == "type"
    assert refused("(assert (= 1 2))") == "assert"
    assert error('(assert #f "one is not two")').message == "one is not two"
    assert refused("(define k (let/ec k k)) (k 1)") == "escape"


def test_an_error_that_is_raised_again_keeps_its_place() -> None:
    caught = error("(define (f) (car 5))\n(guard (e (#f 1)) (f))")
    assert caught.name == "type"
    assert caught.span is not None
    assert caught.span.source.position(caught.span.start) == (1, 13)


@pytest.mark.parametrize(
    "name",
    ["call/cc", "call-with-current-continuation", "dynamic-wind", "eval", "delay", "force", "read", "display", "write",
     "newline", "open-input-file", "set-car!", "char?", "call-with-values"],
)  # fmt: skip
def test_what_is_absent_says_so(name: str) -> None:
    found = error(f"({name} 1)")
    assert (found.name, name in found.message) == ("absent", True)
    assert found.hint


def test_a_program_may_define_what_is_absent() -> None:
    assert log("(define (display x) (print x)) (display 1)") == ["1"]


RECORDS = {
    "(point 1)": "(point 1 0)", "(point 1 :y 2)": "(point 1 2)", "(point 1 2)": "(point 1 2)", "(point-x (point 3))": "3",
    "(point? (point 1))": "#t", "(point? 1)": "#f", "(let ((p (point 1))) (set-point-y! p 5) (point-y p))": "5",
    "(ref (point 1) :x)": "1", "(equal? (point 1) (point 1))": "#t", "(let ((p (point 1))) (eq? p p))": "#t",
    "(map point-x (list (point 1) (point 2)))": "(1 2)",
}  # fmt: skip


@pytest.mark.parametrize("expression", RECORDS)
def test_records(expression: str) -> None:
    assert shown(expression, "(define-record point x (y 0))") == RECORDS[expression]


def test_records_refuse() -> None:
    record = "(define-record point x (y 0))"
    assert refused(f"{record} (point)") in ("arity", "keyword")
    assert refused(f"{record} (point 1 2 3)") == "arity"
    assert refused(f"{record} (point 1 :z 2)") == "keyword"
    assert refused(f"{record} (point-x 5)") == "type"
    assert refused(f"{record} (define (f p::point) p) (f 1)") == "type"
    assert log(f"{record} (define (f p::point) (point-x p)) (print (f (point 4)))") == ["4"]


def test_the_log_and_the_scene() -> None:
    result = run('(print "one" 2 (list "three"))')
    assert result.log == ('one 2 ("three")',)
    assert result.scene is not None


def test_splicing_before_a_dotted_tail() -> None:
    assert shown("`(,@(list 1 2) . 3)") == "(1 2 . 3)"
