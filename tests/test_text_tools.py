"""Tools of texts: what `expand` prints reads back and runs as before, what `fmt` writes is understood as it was, and
what is malformed has a diagnostic in every command."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from searching import many
from support import evaluate, failure, geometry

import scenelang as sl
from scenelang.cli.main import main
from scenelang.grammar.datum import Atom, Source, Symbol, walk
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.formatter import format_text
from scenelang.grammar.reader import read
from scenelang.interpreter.expand.forms import INDENTS
from scenelang.session.session import Options, Session


def scene(body: str, before: str = "") -> str:
    return f'{before}\n(bind "it" (lambda () {body}))'


def found(text: str) -> list[tuple[str, str]]:
    """Codes and messages of a program."""
    return [(d.code, d.message) for d in Session(Options()).check(Source("<test>", text)).diagnostics]


# --- expand ----------------------------------------------------------------------------------------------------------

SYMBOLS = ["a b", "", "1", "1e5", ".5", "+7", "(", ")", "[", "a]", ";", "a;b", "#t", "#true", "none", ".", ":k", "<z1>", '"', "a\nb", "'x", ",x", "`x", "#|", "a|b", "x::y", "\u00e9", "\u00a0", "...", "=>", "else", "if", "->"]  # fmt: skip
QUOTED = "(define-macro (made) `(quote ,(string->symbol {})))"
NAMED = "(define-macro (made) `(let ((,(string->symbol {0}) 3)) ,(string->symbol {0})))"


def written(text: str) -> str:
    """A string of the language."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n").replace("\t", "\\t")
    return f'"{escaped}"'


def check_expansion(text: str) -> str | None:
    """Expand a program that runs: the result reads, runs as before and expands to itself; or it is refused."""
    try:
        printed = sl.expand(text)
    except SceneError as error:
        if error.name == "unsupported":
            return None
        raise
    assert geometry(evaluate(printed)) == geometry(evaluate(text))
    assert sl.expand(printed) == printed
    return printed


@pytest.mark.parametrize("symbol", SYMBOLS)
def test_symbols_read_back_or_are_refused(symbol: str) -> None:
    made = QUOTED.format(written(symbol))
    printed = check_expansion(scene('(call "cube" :scale (+ 1 (string-length (symbol->string (made)))))', made))
    forms = read(Source("<test>", symbol)).forms if "\n" not in symbol else ()
    reads = [form.value for form in forms if isinstance(form, Atom)] == [Symbol(symbol)] and type(
        forms[0].value
    ) is Symbol
    if reads:
        assert printed is not None
        names = [
            each.value
            for form in read(Source("<test>", printed)).forms
            for each in walk(form)
            if isinstance(each, Atom)
        ]
        assert Symbol(symbol) in names
    elif symbol not in ("'x", ",x", "`x"):
        assert printed is None


def test_a_symbol_with_a_space_is_refused_with_a_diagnostic(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "a.scene"
    program.write_text(scene('(print (made)) (call "cube")', QUOTED.format('"a b"')))
    assert main(["expand", str(program)]) == 1
    shown = capsys.readouterr()
    assert shown.out == ""
    assert re.search(r"error\[E\d+\]: the expansion has the symbol `a b`", shown.err)


@settings(max_examples=many(200), deadline=None)
@given(
    st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=4)
    | st.text("ab .;:'`,@#|()[]{}\"<>=1-", max_size=5)
)
@example("a b")
def test_any_symbol_reads_back_or_is_refused(symbol: str) -> None:
    body = '(call "cube" :scale (+ 1 (string-length (symbol->string (made)))))'
    check_expansion(scene(body, QUOTED.format(written(symbol))))
    if not found(scene('(call "cube" :scale (made))', NAMED.format(written(symbol)))):
        check_expansion(scene('(call "cube" :scale (made))', NAMED.format(written(symbol))))


BODIES = {
    "rest": "(define f (lambda xs xs)) (call \"cube\" :scale (f 1 2 3))",
    "rest of some": "(define f (lambda (a . xs) (cons a xs))) (call \"cube\" :scale (f 1 2 3))",
    "rest at once": "(call \"cube\" :scale ((lambda xs xs) 1 2 3))",
    "keywords": "(define (f (:b 2) &keys more) (list b (ref more \"c\") 1)) (call \"cube\" :scale (f :c 3))",
    "defaults": "(define (f a (b (+ a 1)) (:c (* a b))) (list a b c)) (call \"cube\" :scale (f 1))",
    "types": "(define (f a::Number xs::List[Number]) (* a (first xs))) (call \"cube\" :scale (f 2 '(3)))",
    "no name": "(define (f _ x) x) (call \"cube\" :scale (f 1 2))",
    "patterns": "(define-values (a (b . more)) (list 1 (list 2 3 4))) (call \"cube\" :scale (list a b (first more)))",
    "let*": "(let* ((x 1) (x (+ x 1))) (call \"cube\" :scale x))",
    "loop": "(let loop ((i 1)) (if (> i 3) (call \"cube\" :scale i) (loop (+ i 1))))",
    "do": "(call \"cube\" :scale (do ((i 1 (+ i 1)) (s 0 (+ s i)) (k 2)) ((> i 3) (+ s k))))",
    "while": "(define i 1) (while (< i 3) (set! i (+ i 1))) (call \"cube\" :scale i)",
    "cond": "(call \"cube\" :scale (cond (#f 1) ((assoc 2 '((1 . 3) (2 . 4))) => cdr) (else 5)))",
    "case": "(call \"cube\" :scale (case 3 ((1 2) 1) ((3) 2) (else 3)))",
    "guard": "(call \"cube\" :scale (guard (e (#t 2)) (error \"x\")))",
    "let/ec": "(call \"cube\" :scale (let/ec k (k 3) 1))",
    "for": "(for*/union ((x '(1 2)) (y '(0 3)) :when (> y x)) (transform (call \"cube\") (translate [x y 0])))",
    "for/fold": "(call \"cube\" :scale (for/fold ((s 0)) ((i (iota 4))) (+ s i)))",
    "quasiquote": "(call \"cube\" :scale (let ((x '(2 3))) `(1 ,@x)))",
    "dotted": "(call \"cube\" :scale (let ((x '(2 3))) `(1 . ,x)))",
    "nested": "(call \"cube\" :scale (length `(1 `(2 ,(3 ,(+ 1 3))))))",
    "quoted": "(call \"cube\" :scale (length '(a \"b\" :c <z1> #t none (1 . 2) [1 2] ())))",
    "shadowed": "(define (union . xs) xs) (define list vector) (call \"cube\" :scale (list 1 2 3))",
    "a name of a form": "(let ((else #f)) (call \"cube\" :scale (cond (else 1) (#t 2))))",
    "embedding": "(call \"cube\" <z3> \"oak\" :scale 2)",
}  # fmt: skip
BEFORE = {
    "record": ("(define-record p x (y (+ x 1)))", "(call \"cube\" :scale (list (p-x (p 1)) (p-y (p 1)) (p-y (p 1 :y 9))))"),
    "set of a record": ("(define-record p (x 1))", "(define a (p)) (set-p-x! a 3) (call \"cube\" :scale (if (p? a) (p-x a) 1))"),
    "record in a macro": ("(define-syntax make (syntax-rules () ((_ n f) (define-record n f))))(make q size)", "(call \"cube\" :scale (q-size (q 2)))"),
    "hygiene": ("(define-syntax or2 (syntax-rules () ((_ a b) (let ((t a)) (if t t b)))))", "(define t 5) (call \"cube\" :scale (or2 #f t))"),
    "swap": ("(define-syntax swap! (syntax-rules () ((_ a b) (let ((t a)) (begin (set! a b) (set! b t))))))", "(define t 1) (define u 2) (swap! t u) (call \"cube\" :scale (list t u 1))"),
    "loop of a macro": ("(define-syntax times (syntax-rules () ((_ n e) (for/union ((i (iota n))) (transform e (translate [(* 2 i) 0 0]))))))", "(times 3 (call \"cube\"))"),
    "procedural": ("(define-macro (twice e) `(union ,e (transform ,e (translate [3 0 0]))))", "(twice (call \"cube\"))"),
    "a variable with a space": (NAMED.format('"a b"'), "(call \"cube\" :scale (made))"),
    "a variable like a number": (NAMED.format('"0"'), "(call \"cube\" :scale (made))"),
    "param": ('(param size 2 "a size" :min 1 :max 4)', "(call \"cube\" :scale size)"),
}  # fmt: skip
PROGRAMS = {name: scene(body) for name, body in BODIES.items()} | {name: scene(b, a) for name, (a, b) in BEFORE.items()}


@pytest.mark.parametrize("name", PROGRAMS)
def test_expansions_run_as_before(name: str) -> None:
    if name == "record in a macro" and found(PROGRAMS[name]):
        pytest.skip("a record of this kind is refused")
    assert check_expansion(PROGRAMS[name]) is not None


@pytest.mark.parametrize("place", ["(1 ,@2)", "(1 ,@2 3)", "(,@2)", "(,@(+ 1 1) . 3)", "((1 ,@2))"])
def test_what_is_spliced_is_blamed(place: str) -> None:
    name, message = failure(scene(f'(print `{place}) (call "cube")'))
    assert name == "type"
    assert message.startswith("`,@` expects a list")
    assert "append" not in message


@pytest.mark.parametrize("template", ["(1 ,unknown)", "(1 2 ,(+ 1 unknown))", "(a ,unknown)", "((1 ,unknown) 2)"])
def test_templates_are_not_python(template: str) -> None:
    assert found(scene(f'(print `{template}) (call "cube")')) == [("E301", "`unknown` is not defined")]


@pytest.mark.parametrize("place", ["(a . ,@b)", "(a b . ,@(list 1))", "((a . ,@b))", "(a . ,@'())"])
def test_nothing_is_spliced_behind_a_dot(place: str) -> None:
    text = scene(f'(define b \'(1)) (print `{place}) (call "cube")')
    errors = [(code, message) for code, message in found(text) if code.startswith("E")]
    assert len(errors) == 1
    assert "`,@`" in errors[0][1]


DEEP = {
    "calls": ("(+ 1 ", "1", ")"), "lists": ("(list ", "1", ")"), "data": ("'(", "1", ")"), "quoted": ("(", "1", ")"),
    "arrays": ("[", "1", "]"), "templates": ("`(1 ,(list 1 ", "1", "))"), "functions": ("(lambda () ", "1", ")"),
    "let": ("(let ((x 1)) ", "x", ")"), "if": ("(if #t ", "1", " 2)"), "cond": ("(cond (#f 1) (else ", "1", "))"),
    "when": ("(when #t ", "1", ")"), "for": ("(for/list ((i '(1))) ", "i", ")"), "macro": ("(id ", "1", ")"),
    "comments": ("#;(", "", ") 1"), "patterns": ("(let (((a . b) (list 1 2))) ", "a", ")"),
}  # fmt: skip


@pytest.mark.parametrize("depth", [800, pytest.param(4_900, marks=pytest.mark.slow), 10_000])
@pytest.mark.parametrize("kind", DEEP)
def test_deep_programs_are_expanded_or_refused(kind: str, depth: int) -> None:
    opening, middle, closing = DEEP[kind]
    nested = ("'" if kind == "quoted" else "") + opening * depth + middle + closing * depth
    text = scene(f'(define q {nested}) (call "cube")', "(define-syntax id (syntax-rules () ((_ x) x)))")
    if depth > 5_000:
        with pytest.raises(SceneError, match="nested too deeply"):
            sl.expand(text)
    else:
        check_deep(text)


@pytest.mark.parametrize("depth", [900, 10_000])
def test_what_macros_nest_deeply(depth: int) -> None:
    macro = f"(define-macro (m) (let loop ((i {depth}) (e 1)) (if (= i 0) e (loop (- i 1) (list '+ 1 e)))))"
    check_deep(scene('(define q (m)) (call "cube")', macro))


def check_deep(text: str) -> None:
    """Expand a program of great depth: what comes reads, or it is refused because of its depth."""
    try:
        printed = sl.expand(text)
    except SceneError as error:
        refused = error
    else:
        assert not read(Source("<test>", printed)).diagnostics
        return
    assert refused.name in ("nesting", "size"), refused


# --- fmt, and what is read as another language -----------------------------------------------------------------------

HABITS = ["=>", "->", "==", "===", "!=", "&&", "||", "++", "+=", ":=", "//", "/*", "*/", "...", "$x", "@app", "def", "class", "const", "let*", "var", "function", "return", "import-x", "from", "for-each", "while-x", "module", "cube()", "x.y", "x=1", "a,b", "async", "public", "#include", "<z2>", "self.", "lambda:", "else"]  # fmt: skip
HABITS = [habit for habit in HABITS if not read(Source("<test>", f"({habit})")).diagnostics]
LINES = ["const x = 1;", "=> g", "def f(x):", "function f(x) { return x }", "cube([1, 2, 3]);", "import numpy as np", "for (let i = 0; i < 3; i++) {", "module m() cube(1);", "return x", "} else {"]  # fmt: skip
WIDTHS = (20, 30, 60, 88)


def wide(habit: str) -> str:
    """A right program in which a habit stands between long words of data."""
    data = " ".join(f"a-word-of-some-length {habit} another-word-of-some-length-{k}" for k in range(4))
    return f'(define words \'({data}))\n(bind "it" (lambda () (call "cube" :scale (length words))))\n'


@pytest.mark.parametrize("habit", HABITS)
def test_formatted_programs_are_read_as_before(habit: str) -> None:
    text = wide(habit)
    expected = geometry(evaluate(text))
    for width, wrong in product(
        WIDTHS, ("", "(define x (unknown-name 1))\n", '(bind "b" (lambda () (call "cube" :sacle 2)))\n')
    ):
        done = format_text(text + wrong, INDENTS, width=width)
        assert sorted(found(done)) == sorted(found(text + wrong)), (width, wrong)
        if not wrong:
            assert geometry(evaluate(done)) == expected


def test_an_arrow_of_cond_is_no_javascript() -> None:
    clause = "((assoc a-name-of-some-length '((1 . 2) (3 . 4) (5 . 6))) => (lambda (a-pair-of-some-length) (cdr a-pair-of-some-length)))"
    text = f'(define a-name-of-some-length 3)\n(bind "it" (lambda () (call "cube" :scale (cond {clause} (else 1)))))\n'
    for width, more in product(WIDTHS, ("", "(define x (unknown 1))\n", "(define (f)\n  (g\n")):
        done = format_text(text, INDENTS, width=width) + more
        assert sorted(found(done)) == sorted(found(text + more))
        for ragged in (done, "\n".join(line.lstrip() for line in text.split(" ")) + more):
            assert not [message for _, message in found(ragged) if "JavaScript" in message]


@pytest.mark.parametrize(
    "wrong", ["(define x (unknown-name 1))", '(bind "b" (lambda () (call "cube" 1 2 3 :sacle 2)))']
)
@pytest.mark.parametrize("line", LINES)
def test_lines_inside_of_brackets_strings_and_comments_are_no_other_language(line: str, wrong: str) -> None:
    alone = found(wrong + '\n(bind "it" (lambda () (call "cube")))')
    for inside in (f'(define s "\n{line}\n")', f"#|\n{line}\n|#", f'(define s (list "a\n{line}" \'(\n=> b\nelse\n)))'):
        text = f'{inside}\n{wrong}\n(bind "it" (lambda () (call "cube")))'
        assert found(text) == alone, inside
        assert found(format_text(text, INDENTS)) == alone, inside


# --- malformed clauses in every command ------------------------------------------------------------------------------

ODD = ['((call "a") 0 (+ i 4))', "((x) 0)", "(3 0 1)", '("x" 0)', "([1 2] 0)", "(:k 0)", "()", "(i)", "(i 0 1 2)", "i", "(i . 0)", "((a . b) 0)", "(<z1> 0)", "(i::Foo 0)", "(_ 0 1)", "((:k 1) 2)", "(if 0)", "((i i) 0)"]  # fmt: skip
FORMS = {
    "do": "(do ({}) ((> 4 3) 1))", "let": "(let ({}) 1)", "let*": "(let* ({}) 1)", "letrec": "(letrec ({}) 1)",
    "named let": "(let loop ({}) 1)", "for": "(for ({}) 1)", "for/list": "(for/list ({}) 1)", "for*/union": "(for*/union ({}) '())",
    "for/fold": "(for/fold ({}) ((i '(1))) 1)", "lambda": "((lambda {} 1) 1)", "define": "(let () (define {} 1) 1)",
    "let-values": "(let-values ({}) 1)", "guard": "(guard {} 1)", "case": "(case 1 {})", "cond": "(cond {})",
    "let/ec": "(let/ec {} 1)", "define-record": "(let () (define-record {} x) 1)", "when": "(when {} 1)",
}  # fmt: skip


@pytest.mark.parametrize(("form", "odd"), list(product(FORMS, ODD)))
@pytest.mark.sampled(6)
def test_malformed_clauses_have_codes(form: str, odd: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "a.scene"
    program.write_text(scene(f'(print {FORMS[form].format(odd)}) (call "cube")'))
    codes = {command: main([command, str(program)]) for command in ("check", "run", "simplify", "expand", "fmt")}
    said = capsys.readouterr().err
    assert "Traceback" not in said
    assert "E5" not in said or "E50" in said
    assert set(codes.values()) <= {0, 1}
    if codes["run"] == 1:
        assert re.search(r"error\[E\d{3}\]", said), said


@pytest.mark.parametrize("command", ["check", "run", "simplify"])
def test_a_loop_over_a_call_has_a_code(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "a.scene"
    program.write_text('(bind "a" (lambda () (do (((call "a") 0 (+ i 4))) ((> i 3) 1))))')
    assert main([command, str(program)]) == 1
    assert re.search(r"error\[E2\d\d\]: ", capsys.readouterr().err)


FOLD = '(bind "p" (lambda () (call "cube" :scale ({form} ((n 1)) ((i (range 2)) (j (range 2))) (+ n 1)))))'


@pytest.mark.parametrize(("form", "size"), [("for*/fold", 5.0), ("for/fold", 3.0)])
def test_folds_over_several_sequences_expand_to_themselves(form: str, size: float) -> None:
    program = FOLD.format(form=form)
    for text in (program, sl.expand(program)):
        low, high = sl.evaluate(text).bounds
        assert high[0] - low[0] == size


def test_the_second_of_a_pair_may_be_a_number() -> None:
    program = '(bind "p" (lambda () (let (((a . b) (cons 1 2))) (call "cube" :scale (+ a b)))))'
    assert sl.check(program).diagnostics == ()
    assert sl.expand(program)


def test_declarations_of_one_form_expand_to_themselves() -> None:
    """Forms of a `begin` at top level are forms of the program, as the second expansion had them."""
    text = '(bind "a" (lambda () (call "cube")))\n(assert-that (count "cube" 1) (size "cube" 1 :axis "x"))'
    once = sl.expand(text)
    assert "(begin" not in once
    assert sl.expand(once) == once
