"""Names: what is reserved, what may be shadowed, macros and their hygiene (docs/language.md, sections 3 and 5)."""

from __future__ import annotations

import pytest

from scenelang.interpreter.expand.forms import FORMS

from .conftest import error, log, refused, run, scene, shown, warned

# --- shadowing -----------------------------------------------------------------------------------------------------

SHADOWED = ["grid", "clamp", "list", "scale", "translate", "vector", "length", "map", "ref", "color", "min", "row"]


@pytest.mark.parametrize("name", SHADOWED)
def test_builtins_may_be_shadowed(name: str) -> None:
    assert log(f"(define ({name} . xs) 'mine) (print ({name} 1 2))") == ["mine"]
    assert log(f"(define {name} 5) (print {name})") == ["5"]
    assert log(f"(print (let (({name} 5)) {name}))") == ["5"]
    assert log(f"(print ((lambda ({name}) {name}) 5))") == ["5"]
    assert log(f"(print (for/list (({name} 2)) {name}))") == ["(0 1)"]
    assert log(f"(define (f) (define {name} 5) {name}) (print (f))") == ["5"]
    assert log(f"(define (use) ({name} 1)) (define ({name} x) 'late) (print (use))") == ["late"], "in the whole file"


@pytest.mark.parametrize("name", ["list", "length", "map", "vector"])
def test_std_is_never_shadowed(name: str) -> None:
    use = {"list": "(std/list 1)", "length": "(std/length '(1))", "map": "(std/map - '(1))", "vector": "(std/vector 1)"}
    expected = {"list": "(1)", "length": "1", "map": "(-1)", "vector": "[1]"}
    assert log(f"(define ({name} . xs) 'mine) (print {use[name]})") == [expected[name]]


def test_forms_mean_the_builtins_whatever_is_shadowed() -> None:
    mine = "(define (list . xs) 'mine) (define (parts . xs) 'mine) (define (append . xs) 'mine) (define (cons . xs) 'mine) "
    mine += "(define (vector . xs) 'mine) (define (array . xs) 'mine) (define (contains? . xs) #f) (define (raise x) 'mine) "
    assert log(mine + "(print `(1 ,(+ 1 1) ,@'(3)))") == ["(1 2 3)"]
    assert log(mine + "(print [1 2 (+ 1 2)])") == ["[1 2 3]"]
    assert log(mine + "(print (for/append ((x '((1) (2)))) x))") == ["(1 2)"]
    assert log(mine + '(print (length (for/union ((i 2)) (call "cube"))))') == ["2"]
    assert log(mine + "(print (case 1 ((1) 'one) (else 'other)))") == ["one"]
    assert refused(mine + '(guard (e (#f 1)) (error "x"))') == "user"


def test_library_code_keeps_its_own_meaning() -> None:
    mine = (
        "(define (map . xs) 'mine) (define (iota n) 'mine) (define (parts . xs) 'mine) (define (transform . xs) 'mine)"
    )
    three = scene(f'{mine} (bind "r" (lambda () (std/union-loop 3 (lambda (i) (call "cube"))))) (scene "r")')
    assert len(three.root.children) == 3
    assert (
        len(scene('(define (iota n) 1) (bind "r" (lambda () (union-loop 3 (lambda (i) (call "cube")))))').root.children)
        == 3
    )


@pytest.mark.parametrize("name", ["union", "call", "transform", "union-loop"])
def test_the_papers_macros_may_be_shadowed_with_a_warning(name: str) -> None:
    program = f"(define ({name} . xs) 'mine) (print ({name} 1 2)) (bind \"r\" (lambda () '()))"
    assert warned(program) == ["shadowed-macro"]
    assert log(program) == ["mine"]
    assert log(f"(print (let (({name} (lambda xs 'mine))) ({name} 1 2)))") == ["mine"]
    assert log(f"(print ((lambda ({name}) ({name} 1)) -))") == ["-1"]
    assert log(f"(print (procedure? {name}))") == ["#t"]


def test_a_shadowing_value_that_is_no_procedure() -> None:
    assert "std/scale" in str(error("(define (f :scale) (scale 2)) (f :scale 3)").hint)
    assert "std/scale" in str(error("(define scale 3) (scale 2)").hint)
    assert "std/length" in str(error("(let ((length 3)) (length (list 1)))").hint)


@pytest.mark.parametrize("name", sorted(FORMS))
def test_forms_are_reserved(name: str) -> None:
    if name in ("scene", "param", "syntax-rules"):
        return
    for program in (f"(define {name} 1)", f"(define (f {name}) 1)", f"(let (({name} 1)) 1)"):
        assert refused(program) == "reserved"


@pytest.mark.parametrize("name", ["retrieve", "frames", "embedding", "primitive", "error", "raise", "apply", "print"])
def test_procedures_that_look_like_forms_may_be_shadowed(name: str) -> None:
    assert shown(f"((lambda ({name}) {name}) 5)") == "5"


def test_scene_and_param_are_forms_only_at_top_level() -> None:
    assert shown("((lambda (scene param) (list scene param)) 1 2)") in ("(1 2)",)
    assert refused('(define (f) (scene "x"))') == "misplaced"
    assert refused("(define (f) (param x 1))") == "misplaced"


def test_special_forms_are_no_values() -> None:
    assert refused("(print if)") == "misplaced"
    assert refused("(map lambda (list 1))") == "misplaced"
    assert refused("(define-syntax m (syntax-rules () ((_) 1))) (print m)") == "misplaced"


def test_unknown_names_suggest_near_ones() -> None:
    assert "`leg-height`" in str(error("(define leg-height 1) (print leg-hieght)").hint)
    assert "`translate`" in str(error("(translat [1 2 3])").hint)
    assert "`define`" in str(error("(defin x 1)").hint)
    assert "`inner`" in str(error("(let ((inner 1)) (print inne))").hint)
    assert error("(print qqqqqqqq)").hint is None


# --- syntax-rules --------------------------------------------------------------------------------------------------

SWAP = "(define-syntax swap! (syntax-rules () ((_ a b) (let ((tmp a)) (set! a b) (set! b tmp)))))"
MY_OR = "(define-syntax my-or (syntax-rules () ((_) #f) ((_ e) e) ((_ e r ...) (let ((t e)) (if t t (my-or r ...))))))"
WHILE = "(define-syntax repeat-until (syntax-rules () ((_ test body ...) (let loop () body ... (unless test (loop))))))"
FOR_IN = (
    "(define-syntax each (syntax-rules (in) ((_ x in xs body ...) (map (lambda (x) body ...) xs))"
    " ((_ other ...) 'no-in)))"
)
MY_LET = "(define-syntax my-let (syntax-rules () ((_ ((n v) ...) body ...) ((lambda (n ...) body ...) v ...))))"
MY_LET_STAR = (
    "(define-syntax my-let* (syntax-rules () ((_ () body ...) (let () body ...))"
    " ((_ ((n v) more ...) body ...) (let ((n v)) (my-let* (more ...) body ...)))))"
)
NESTED = "(define-syntax flat (syntax-rules () ((_ (a b ...) ...) '((a ...) (b ... ...)))))"
COND = (
    "(define-syntax my-cond (syntax-rules (else) ((_) 'end) ((_ (else e)) e)"
    " ((_ (c e) rest ...) (if c e (my-cond rest ...)))))"
)
BE_LIKE_BEGIN = (
    "(define-syntax be-like-begin (syntax-rules () ((_ name) (define-syntax name (syntax-rules ()"
    " ((_ expr (... ...)) (begin expr (... ...))))))))"
)

HYGIENE = {
    SWAP: {
        "(let ((x 1) (y 2)) (swap! x y) (list x y))": "(2 1)",
        "(let ((tmp 1) (other 2)) (swap! tmp other) (list tmp other))": "(2 1)",
        "(let ((let 5)) let)": None,
    },
    MY_OR: {
        "(let ((t 5)) (my-or #f t))": "5", "(let ((if list)) 1)": None, "(my-or)": "#f", "(my-or #f #f 3)": "3",
        "(let ((t 1)) (my-or #f #f t))": "1",
    },
    WHILE: {"(let ((i 0) (loop 'mine)) (repeat-until (= i 3) (set! i (+ i 1))) (list i loop))": "(3 mine)"},
    FOR_IN: {
        "(each x in '(1 2) (* x x))": "(1 4)", "(each x of '(1 2) (* x x))": "no-in", "(let ((in 1)) (each x in '(1 2) x))": "no-in",
    },
    MY_LET: {"(my-let ((a 1) (b 2)) (+ a b))": "3", "(my-let () 1)": "1"},
    MY_LET_STAR: {"(my-let* ((a 1) (b (+ a 1))) (* a b))": "2"},
    NESTED: {"(flat (1 2 3) (4) (5 6))": "((1 4 5) (2 3 6))", "(flat)": "(() ())"},
    COND: {"(my-cond (#f 1) (else 2))": "2", "(my-cond (#t 1) (else 2))": "1", "(let ((else #f)) (my-cond (#f 1) (else 2)))": "end"},
    BE_LIKE_BEGIN: {"(let () (be-like-begin sequence) (sequence 1 2 3 4))": "4"},
    "(define-syntax tail (syntax-rules () ((_ a . b) 'b)))": {"(tail 1 2 3)": "(2 3)", "(tail 1)": "()"},
    "(define-syntax last-of (syntax-rules () ((_ a ... z) 'z)))": {"(last-of 1 2 3)": "3", "(last-of 1)": "1"},
    "(define-syntax vec (syntax-rules () ((_ [a b ...]) '(a b ...))))": {"(vec [1 2 3])": "(1 2 3)"},
    "(define-syntax arr (syntax-rules () ((_ a ...) [a ... 9])))": {"(arr 1 2)": "[1 2 9]"},
    '(define-syntax lit (syntax-rules () ((_ 1) \'one) ((_ "s") \'string) ((_ #t) \'true) ((_ :k) \'key) ((_ x) \'other)))': {
        "(lit 1)": "one", '(lit "s")': "string", "(lit #t)": "true", "(lit :k)": "key", "(lit 2)": "other", "(lit 1.0)": "other",
    },
    "(define-syntax under (syntax-rules () ((_ _ x) 'x)))": {"(under 1 2)": "2"},
    "(define-syntax dots (syntax-rules ::: () ((_ a :::) '(a ::: ...))))": {"(dots 1 2)": None},
    "(define-syntax ell (syntax-rules dots () ((_ a dots) '(a dots))))": {"(ell 1 2)": "(1 2)"},
    "(define-syntax const (syntax-rules () ((_) (length '(1 2)))))": {"(let ((length 5)) (const))": "2"},
    "(define helper 7) (define-syntax use (syntax-rules () ((_) helper)))": {"(let ((helper 1)) (use))": "7"},
    "(define-syntax def (syntax-rules () ((_ n v) (define n v))))": {"(let () (def x 5) x)": "5"},
    "(define-syntax both (syntax-rules () ((_ a b) (begin (define a 1) (define b 2)))))": {"(let () (both x y) (list x y))": "(1 2)"},
    "(define-syntax kw (syntax-rules () ((_ n) (lambda (:n) n))))": {"((kw 5) :n 3)": None},
    "(define-syntax fn (syntax-rules () ((_ p body) (lambda (p::Integer) body))))": {"((fn x x) 2)": None},
    "(define-syntax tmp-default (syntax-rules () ((_ e) (lambda ((tmp 1)) (+ tmp e)))))": {"(let ((tmp 10)) ((tmp-default tmp)))": "11"},
}  # fmt: skip


@pytest.mark.parametrize("definition", HYGIENE, ids=lambda d: d.split()[1])
def test_syntax_rules(definition: str) -> None:
    for use, expected in HYGIENE[definition].items():
        if expected is not None:
            assert shown(use, definition) == expected, use


def test_the_macro_keeps_if_when_the_user_shadows_what_it_uses() -> None:
    definition = "(define-syntax my-if (syntax-rules () ((_ c a b) (cond (c a) (else b)))))"
    assert shown("(let ((else #f)) (my-if #f 1 2))", definition) == "2"
    pick = "(define-syntax pick (syntax-rules () ((_ xs) (first xs))))"
    assert shown("(let ((first last)) (pick '(1 2)))", pick) == "1"
    assert log(f"{pick} (define (first x) 'mine) (print (pick '(1 2)))") == ["mine"], "the file's own first"


def test_definitions_of_a_macro_are_its_own_unless_named_by_the_use() -> None:
    program = (
        "(define-syntax counter (syntax-rules () ((_ name) (begin (define n 0) (define (name) (set! n (+ n 1)) n)))))"
    )
    assert log(f"{program} (counter tick) (counter tock) (tick) (print (tick) (tock))") == ["2 1"]
    assert refused(f"{program} (counter tick) (print n)") == "unbound"


def test_local_macros() -> None:
    assert shown("(let-syntax ((m (syntax-rules () ((_ x) (+ x 1))))) (m 2))") == "3"
    assert shown("(let ((x 1)) (let-syntax ((m (syntax-rules () ((_) x)))) (let ((x 2)) (m))))") == "1"
    odd = (
        "(letrec-syntax ((e? (syntax-rules () ((_) #t) ((_ x . r) (o? . r)))) "
        "(o? (syntax-rules () ((_) #f) ((_ x . r) (e? . r))))) (e? 1 2 3))"
    )
    assert shown(odd) == "#f"
    assert shown("(let () (define-syntax m (syntax-rules () ((_ x) (* 2 x)))) (m 4))") == "8"
    assert refused("(let () (define-syntax m (syntax-rules () ((_) 1))) (m)) (m)") == "unbound"


MACRO_ERRORS = {
    "(define-syntax m (syntax-rules () ((_ a) a))) (m 1 2)": "macro",
    "(define-syntax m (syntax-rules () ((_ a ...) a))) (m 1)": "macro",
    "(define-syntax m (syntax-rules () ((_ a ... b ...) 1))) (m 1)": "macro",
    "(define-syntax m (syntax-rules () ((_ a) (a ...)))) (m 1)": "macro",
    "(define-syntax m (syntax-rules () ((_ (a ...) (b ...)) '((a b) ...)))) (m (1 2) (3))": "macro",
    "(define-syntax m 5)": "macro", "(define-syntax m (syntax-rules 5))": "macro", "(define-syntax m)": "syntax",
    "(define-syntax m (syntax-rules () (5 1))) (m)": "macro", "(define-syntax if (syntax-rules () ((_) 1)))": "reserved",
}  # fmt: skip


@pytest.mark.parametrize("program", MACRO_ERRORS)
def test_malformed_macros(program: str) -> None:
    assert refused(program) == MACRO_ERRORS[program]


def test_an_error_in_a_macro_shows_use_and_definition() -> None:
    found = error('(define-syntax twice (syntax-rules () ((_ x) (* 2 x))))\n(define (f) (twice "a"))\n(f)')
    assert found.name == "type"
    assert found.span is not None
    assert found.span.source.position(found.span.start) == (2, 13)
    assert found.span.expansion is not None
    assert found.span.expansion.macro == "twice"
    operand = error("(define-syntax twice (syntax-rules () ((_ x) (* 2 x))))\n(twice (car 5))")
    assert operand.span is not None
    assert operand.span.source.position(operand.span.start) == (2, 8), "what the user wrote keeps its place"


# --- define-macro --------------------------------------------------------------------------------------------------

PROCEDURAL = {
    "(define-macro (twice x) `(* 2 ,x))": {"(twice 4)": "8", "(let ((* +)) (twice 4))": "8"},
    "(define-macro (my-list . xs) `(list ,@xs))": {"(my-list 1 2)": "(1 2)", "(let ((list 5)) (my-list 1))": "(1)"},
    "(define-macro (my-or a b) (let ((t (gensym))) `(let ((,t ,a)) (if ,t ,t ,b))))": {"(let ((t 5)) (my-or #f t))": "5"},
    "(define-macro (my-or2 a b) `(let ((t ,a)) (if t t ,b)))": {"(my-or2 #f 3)": "3"},
    "(define-macro (aif test then else) `(let ((it ,test)) (if it ,then ,else)))": {
        "(aif (assoc 2 '((2 b))) it 0)": "(2 b)", "(aif #f it 0)": "0",
    },
    "(define-macro (unroll n body) `(list ,@(map (lambda (i) body) (iota n))))": {"(unroll 3 (+ 1 1))": "(2 2 2)"},
    "(define-macro (quoted x) `',x)": {"(quoted (a b))": "(a b)"},
    "(define-macro (second-of xs) `(quote ,(second xs)))": {"(second-of (1 2 3))": "2"},
    "(define-macro (arr . xs) `[,@xs])": {"(arr 1 2)": "[1 2]"},
    "(define-macro (type-of x) (cond ((symbol? x) ''symbol) ((number? x) ''number) ((string? x) ''string) (else ''list)))": {
        "(type-of a)": "symbol", "(type-of 1)": "number", '(type-of "s")': "string", "(type-of (1))": "list",
    },
    "(define-macro (with (x 1)) `(list ,x))": {"(with)": "(1)", "(with 2)": "(2)"},
    "(define-macro (helper x) `(+ 1 ,x)) (define-macro (outer x) `(helper (helper ,x)))": {"(outer 1)": "3"},
    "(define-macro (handle z) `(embedding-handle ,z))": {"(handle <z7>)": '"z7"'},
    "(define-macro (keys . xs) `(list ,@xs))": {"(keys :a 1)": "(:a 1)"},
}  # fmt: skip


@pytest.mark.parametrize("definition", PROCEDURAL, ids=lambda d: d.split("(")[2].split()[0])
def test_define_macro(definition: str) -> None:
    for use, expected in PROCEDURAL[definition].items():
        assert shown(use, definition) == expected, use


def test_define_macro_defines() -> None:
    assert log("(define-macro (def n v) `(define ,n ,v)) (def x 5) (print x)") == ["5"]
    assert log("(define-macro (two a b) `(begin (define ,a 1) (define ,b 2))) (two x y) (print x y)") == ["1 2"]
    program = '(define-macro (boxes . words) `(begin ,@(map (lambda (w) `(bind ,w (lambda () (call "cube")))) words)))'
    assert run(f'{program} (boxes "a" "b") (scene "b")').ok


def test_bodies_of_define_macro_see_builtins_and_macros_only() -> None:
    assert refused("(define helper 1) (define-macro (m) helper) (m)") == "unbound"
    assert refused("(define-macro (m) (set! x 1)) (define x 0) (m)") == "unbound"
    assert refused("(define-macro (m x) (car x)) (m 5)") == "type"
    assert refused('(define-macro (m) (error "no")) (m)') == "user"
    assert refused("(define-macro (m) car) (m)") == "macro"
    assert refused("(define-macro (m x) x) (m)") == "arity"
    assert refused("(define-macro m 5)") == "syntax"


def test_expansion_has_no_effect_on_the_run() -> None:
    assert shown("(random)", "(define-macro (m) (random) 1) (m)") == shown("(random)")


def test_gensym_is_fresh() -> None:
    assert shown("(eq? (gensym) (gensym))") == "#f"
