"""Hostile programs: each ends in a coded diagnostic, never in a traceback, a crash or a hang."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import copies
import pytest
from support import calls

from scenelang import Limits, Options, Session, Source, parse
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import render_text

ROOT = '\n(bind "dot" (lambda () (call "cube")))\n'

LOOPS = {
    "while": "(while #t 1)",
    "while that works": "(define n 0) (while #t (set! n (+ n 1)))",
    "named let": "(let loop ((i 0)) (loop (+ i 1)))",
    "do": "(do ((i 0 (+ i 1))) (#f) i)",
    "for over a list that grows": "(define xs (mutable-list 1)) (for ((x xs)) (push! xs x))",
    "for over a huge count": "(for ((i 1000000000000)) i)",
    "for* of for*": "(for* ((i 1000000) (j 1000000) (k 1000000)) k)",
    "for/fold": "(for/fold ((a 0)) ((i 100000000000)) (+ a i))",
    "for without clauses in while": "(while #t (for () 1))",
    "tail calls": "(define (f) (g)) (define (g) (f)) (f)",
    "tail calls inside map": "(define (f x) (f x)) (map f (list 1))",
    "tail calls inside sort": "(define (f x) (f x)) (sort (list 2 1) :key f)",
    "tail calls inside apply": "(define (f x) (f x)) (+ 1 (apply f (list 1)))",
    "tail calls inside for-each": "(define (f x) (g x)) (define (g x) (f x)) (for-each f (list 1))",
    "tail calls inside a word": '(bind "a" (lambda () (f 1))) (define (f x) (f x))',
    "tail calls inside union-loop": '(bind "a" (lambda () (union-loop 2 f))) (define (f x) (f x))',
    "tail calls of functions with rest": "(define (f . xs) (apply f xs)) (f 1)",
    "tail calls of functions with keywords": "(define (f :x) (f :x x)) (f :x 1)",
    "macro that loops at run time": "(define-syntax m (syntax-rules () ((_) (let l () (l))))) (m)",
    "let/ec in a loop": "(while #t (let/ec k (k 1)))",
    "guard in a loop": '(while #t (guard (e (#t 1)) (error "x")))',
    "string building": '(define s "") (while #t (set! s (string-append s "x")))',
    "builtin that does much": "(while #t (sort (iota 1000)))",
    "matrix power": "(define a (eye 300)) (while #t (set! a (@ a a)))",
    "repeated search": '(define s (apply string-append (make-list 100000 "a"))) (while #t (string-replace s "a" "bb"))',
    "union-loop": '(bind "row" (lambda () (union-loop 100000000000 (lambda (i) (call "cube")))))',
    "map of a large range": "(while #t (map (lambda (x) x) (iota 100000)))",
    "table that grows": "(define t (table)) (define n 0) (while #t (set! n (+ n 1)) (set-ref! t n n))",
    "words for ever": '(define n 0) (while #t (set! n (+ n 1)) (call "cube" :scale n))',
    "words of arithmetic": '(define n 0) (while #t (set! n (+ n 1)) (call (format "w{}" n)))',
    "random": "(while #t (random))",
    "shuffle": "(while #t (shuffle (iota 10000)))",
}

RECURSIONS = {
    "direct": "(define (f x) (+ 1 (f x))) (f 1)",
    "mutual": "(define (f x) (+ 1 (g x))) (define (g x) (+ 1 (f x))) (f 1)",
    "map": "(define (f x) (map f (list x))) (f 1)",
    "apply": "(define (f x) (+ 1 (apply f (list x)))) (f 1)",
    "sort with a key": "(define (f x) (sort (list 2 1) :key f)) (f 1)",
    "for-each": "(define (f x) (for-each f (list x)) 1) (f 1)",
    "fold": "(define (f a x) (fold f a (list x)) 1) (f 1 2)",
    "for": "(define (f x) (for/list ((i 2)) (f i))) (f 1)",
    "default": "(define (f (x (f))) (+ x 1)) (f)",
    "keyword": "(define (f (:x (f))) (+ x 1)) (f)",
    "guard": "(define (f x) (guard (e (#t 1)) (+ 1 (f x)))) (f 1)",
    "let/ec": "(define (f x) (let/ec k (+ 1 (f x)))) (f 1)",
    "words": '(bind "a" (lambda () (union (call "b")))) (bind "b" (lambda () (union (call "a")))) (scene "a")',
    "words with attributes": '(bind "a" (lambda (:n) (union (call "a" :n (+ n 1))))) (scene "a" :n 1)',
    "union-loop": '(bind "a" (lambda (:n) (union-loop 3 (lambda (i) (call "a" :n (+ n i)))))) (scene "a" :n 1)',
    "word in a measure": '(bind "a" (lambda () (compute-shape-sizes (call "a")) (call "cube"))) (scene "a")',
    "record default": "(define-record r (x (r))) (r)",
    "lambda": "((lambda (f) (+ 1 (f f))) (lambda (f) (+ 1 (f f))))",
    "while": "(define (f) (while (f) 1)) (f)",
    "cond": "(define (f x) (cond ((f x) 1) (else 2))) (f 1)",
    "map-parts": '(define (f p) (map-parts f (list p))) (f (call "cube"))',
    "exponential": "(define (fib n) (if (< n 2) n (+ (fib (- n 1)) (fib (- n 2))))) (fib 200)",
    "ackermann": "(define (a m n) (if (= m 0) (+ n 1) (if (= n 0) (a (- m 1) 1) (a (- m 1) (a m (- n 1)))))) (a 4 3)",
}

SIZES = {
    "append": "(define xs (list 1)) (while #t (set! xs (append xs xs)))",
    "string-append": '(define s "ab") (while #t (set! s (string-append s s)))',
    "extend!": "(define xs (mutable-list 1)) (while #t (extend! xs xs))",
    "expt": "(expt 10 (expt 10 10))",
    "expt tower": "(expt 9 (expt 9 (expt 9 9)))",
    "multiplication": "(define n 3) (while #t (set! n (* n n)))",
    "addition": "(define n 1) (while #t (set! n (+ n n)))",
    "product": "(product (iota 100000 1))",
    "make-list": "(make-list 10000000000 0)",
    "iota": "(iota 10000000000)",
    "range": "(range 0 10000000000)",
    "range of small steps": "(range 0 1 1e-12)",
    "zeros": "(zeros 100000 100000)",
    "ones": "(ones 1000000000000)",
    "full": "(full (list 100000 100000) 1)",
    "eye": "(eye 1000000)",
    "linspace": "(linspace 0 1 10000000000)",
    "arange": "(arange 0 1 1e-12)",
    "repeat": "(repeat (list 1 2 3) 10000000000)",
    "string repeat": '(string-pad "x" 10000000000)',
    "format width": '(format "{:10000000000}" 1)',
    "format precision": '(format "{:.10000000000f}" 1.5)',
    "format nested width": '(format "{:{}}" 1 10000000000)',
    "string-replace": '(define s "a") (while #t (set! s (string-replace s "a" "aaaa")))',
    "string-join": '(define s "a") (while #t (set! s (string-join (make-list 1000 s) s)))',
    "outer product": "(define v (reshape (arange 100000) (list 100000 1))) (+ v (transpose v))",
    "concatenate": "(define v (zeros 100)) (while #t (set! v (concatenate (list v v))))",
    "stack": "(define v (zeros 100)) (while #t (set! v (stack (list v v))))",
    "uniform": "(uniform 0 1 :size 10000000000)",
    "randint bounds": "(randint 0 (expt 10 1000))",
    "permutation": "(permutation 10000000000)",
    "list-head of gamma": '(bind "a" (lambda (z g) (list-head g 10000000000)))',
    "list-tail of gamma": '(bind "a" (lambda (z g) (union-loop (list-tail g 1e300) (lambda (i) (call "cube")))))',
    "gamma in a loop": '(bind "a" (lambda (z g) (for ((x g)) 1) (union)))',
    "number->string": "(define n 7) (while #t (set! n (* n 10)) (number->string n))",
    "cons": "(define xs (list)) (while #t (set! xs (cons xs xs)))",
    "push!": "(define xs (mutable-list)) (while #t (push! xs 1))",
    "flatten": "(define xs (list 1)) (for ((i 60)) (set! xs (list xs xs))) (flatten xs)",
    "entities": '(bind "a" (lambda () (union-loop 10000000 (lambda (i) (call "cube" :scale (+ i 1))))))',
    "parts of shared lists": '(define x (list (call "cube"))) (for ((i 60)) (set! x (list x x))) (parts x)',
    "parts of a cycle": "(define x (mutable-list)) (push! x x) (parts x)",
    "union of shared lists": '(define x (list (call "cube"))) (for ((i 60)) (set! x (list x x))) (union x)',
    "log": '(while #t (print "hello hello hello"))',
}

DEEP = "(define x (list)) (for ((i 30000)) (set! x (list x)))\n"
SHARED = "(define x (list 1)) (for ((i 60)) (set! x (list x x)))\n"
CYCLIC = "(define x (mutable-list 1)) (push! x x) (push! x x)\n"

# What must work, or end in a diagnostic: nothing here may crash or hang.
DATA = {
    "print": "(print x)",
    "equal?": "(define y x) (print (equal? x (list x)))",
    "equal? twins": "(print (equal? (list x x) (list x x)))",
    "contains?": "(print (contains? (list 1 x 2) x))",
    "table key": "(define t (table)) (set-ref! t x 1) (print (ref t x))",
    "set member": "(define s (set)) (add! s x) (print (length s))",
    "attribute": '(define e (call "cube" :x x)) (print e)',
    "attribute of a word": '(bind "w" (lambda (:x) (call "cube"))) (define e (call "w" :x x)) (scene "w" :x x)',
    "embedding": "(define z (embedding :x x)) (print z)",
    "parts": "(print (length (parts x)))",
    "union": "(define u (union x)) (print (length u))",
    "flatten": "(print (length (flatten x)))",
    "sort": "(print (length (sort (list x x))))",
    "format": '(print (format "{}" x))',
    "error": '(error "wrong:" x)',
    "raise": "(raise x)",
    "assert": "(assert #f x)",
    "vector": "(vector x)",
    "array": "(array x)",
    "mutable-array": "(mutable-array x)",
    "pose": "(pose x)",
    "translate": "(translate x)",
    "add": "(+ 1 x)",
    "apply": "(apply list x)",
    "delete-duplicates": "(print (length (delete-duplicates (list x x))))",
    "string-append": '(string-append "a" x)',
    "mutable": "(define m (mutable x))",
    "list->set": "(define s (list->set (list x)))",
    "pattern": "(let (((a b) x)) a)",
    "quasiquote": "(define q `(1 ,x ,@x))",
    "index-of": "(print (index-of (list 1 x) x))",
    "max": "(print (max x x))",
    "apply max": "(print (max-of (list x x)))",
    "->list": "(print (length (->list x)))",
    "compute-shape": "(print (compute-shape-sizes x))",
    "frames": '(bind "film" (lambda () (frames x))) (scene "film")',
}


RUNNER = """
import json, sys
from scenelang import Limits, Options, Session, Source
from scenelang.grammar.diagnostics import render_text
for name, text, limits in json.load(sys.stdin):
    result = Session(Options(limits=Limits(**limits))).evaluate(Source("hostile.scene", text))
    errors = [d.code for d in result.diagnostics if d.is_error]
    rendered = "\\n".join(render_text(d) for d in result.diagnostics)
    print(json.dumps([name, errors, len(rendered), len(result.log)]), flush=True)
"""
TIGHT = {"steps": 500_000, "seconds": 1.2, "memory": 700_000_000}


def outcomes(programs: dict[str, str], **limits: Any) -> dict[str, tuple[list[str], int, int]]:
    """Evaluate programs one after the other in one process: codes of errors, sizes of what was said."""
    jobs = [(name, text if "(bind" in text else text + ROOT, {**TIGHT, **limits}) for name, text in programs.items()]
    done = subprocess.run(
        [sys.executable, "-c", RUNNER], input=json.dumps(jobs), capture_output=True, text=True, check=False
    )
    found = {name: (codes, size, log) for name, codes, size, log in map(json.loads, done.stdout.splitlines())}
    missing = [name for name in programs if name not in found]
    assert not missing, f"{missing[0]} ended the process ({done.returncode}): {done.stderr[-500:]}"
    return found


def refused(programs: dict[str, str], code: str, **limits: Any) -> None:
    """Assert that every program ends in one error whose code fits."""
    wrong = {
        name: codes
        for name, (codes, _, _) in outcomes(programs, **limits).items()
        if len(codes) != 1 or not re.fullmatch(code, codes[0])
    }
    assert not wrong


@pytest.mark.slow
def test_loops() -> None:
    refused(LOOPS, r"E50[15678]", seconds=0.4, steps=60_000)


def test_recursions() -> None:
    refused(RECURSIONS, r"E50[12]", depth=3000, seconds=20)


@pytest.mark.slow
def test_recursions_as_deep_as_the_default_allows() -> None:
    some = ("direct", "sort with a key", "words with attributes")
    refused({name: RECURSIONS[name] for name in some}, "E50[27]")  # on a slow machine time runs out first


def test_sizes() -> None:
    refused(SIZES, r"E(50[1-7]|40\d|608)", seconds=0.4)


@pytest.mark.parametrize("make", [DEEP, SHARED, CYCLIC], ids=["deep", "shared", "cyclic"])
@pytest.mark.sampled(3)
def test_data(make: str) -> None:
    """Deep, exponentially shared and cyclic data in every operation that walks it: done, or refused."""
    for name, (codes, said, _) in outcomes({name: make + text for name, text in DATA.items()}, seconds=0.4).items():
        assert len(codes) <= 1, name
        assert said < 10_000, name


# --- text ----------------------------------------------------------------------------------------------------------


def codes_of(text: str, **options: Any) -> list[str]:
    return [
        d.code for d in Session(Options(**options)).evaluate(Source("hostile.scene", text)).diagnostics if d.is_error
    ]


NESTED = {
    "parentheses": ("(", ")", "E106", "E106"),
    "brackets": ("[", "]", "E106", "E106"),
    "calls": ("(list ", ")", "E106", "E106"),
    "lambdas": ("(lambda () ", ")", "E106", "E106"),
    "quotes": ("'", "", "E101", "E106"),
    "quasiquotes": ("`", "", "E101", "E106"),
    "quoted lists": ("'(", ")", "E106", "E106"),
    "datum comments": ("#;", "", "E101", "E106"),
    "block comments": ("#|", "|#", "E101", None),
}


@pytest.mark.parametrize("name", NESTED)
@pytest.mark.parametrize("depth", [100_000, 400_000])
@pytest.mark.sampled(4)
def test_nesting_in_text(name: str, depth: int) -> None:
    """Never closed, and closed: refused by the reader, with little work."""
    opening, closing, open_code, closed_code = NESTED[name]

    def read() -> None:
        result = parse(opening * depth)
        assert [d.code for d in result.diagnostics] in ([open_code], ["E106"])
        closed = parse(opening * depth + "1 " + closing * depth)
        assert [d.code for d in closed.diagnostics] == ([closed_code] if closed_code else [])

    assert calls(read) < 25 * depth


@pytest.mark.slow
def test_nesting_up_to_the_readers_limit_goes_through_everything() -> None:
    """What the reader lets pass, expansion, compilation and running bear too, or refuse."""
    depth = 4_900
    for opening, closing in (("(list ", ")"), ("(+ 1 ", ")"), ("(let ((x 1)) ", ")"), ("(if #t ", ")"), ("[", "]"),
                             ("'(", ")"), ("`(,", ")"), ("((lambda () ", "))"), ("(union ", ")"), ("(begin ", ")"),
                             ("(when #t ", ")"), ("(cond (#t ", "))"), ("(for ((i 1)) ", ")")):  # fmt: skip
        count = depth // (opening.count("(") + opening.count("["))
        value = '(call "cube")' if "union" in opening else "1"
        text = f"(define x {opening * count}{value}{closing * count})" + ROOT
        assert codes_of(text) in ([], ["E502"], ["E409"], ["E401"], ["E106"], ["E301"]), opening


# --- scenes --------------------------------------------------------------------------------------------------------

SPONGE = """
(bind "sponge" (lambda (:level)
  (if (= level 0)
      (call "cube")
      (union-loop 20 (lambda (i) (transform (call "sponge" :level (- level 1)) (@ (translate [i 0 0]) (scale 0.3))))))))
(scene "sponge" :level 30)
"""


def test_a_huge_sponge_is_counted_and_measured_but_never_expanded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "sponge.scene"
    file.write_text(SPONGE)
    for command in ("run", "count", "bounds"):
        assert main([command, str(file)]) == 0
    assert f"{20**30:,}" in capsys.readouterr().out
    for command, *rest in (
        ("flatten",), ("flatten", "--json"), ("export", "-o", "o.glb"), ("render", "-o", "o.png"),
    ):  # fmt: skip
        rest = [str(tmp_path / word) if word.startswith("o.") else word for word in rest]
        assert main([command, str(file), *rest]) == 1, command
        captured = capsys.readouterr()
        assert re.search(r"E50\d", captured.err), command
        assert len(captured.out) < 1000
    assert main(["tree", str(file)]) == 0
    assert main(["tree", str(file), "--all"]) == 0
    assert len(capsys.readouterr().out) < 1_000_000
    assert main(["embeddings", str(file), "list"]) == 0
    assert os.listdir(tmp_path) == ["sponge.scene"]


CHAIN = """
(define e (call "cube"))
(bind "link" (lambda (:inner) inner))
(for ((i LEVELS)) (set! e (call "link" :inner (union e (call "sphere")))))
(bind "chain" (lambda () e))
(scene "chain")
"""


@pytest.mark.parametrize(
    ("command", "levels"), [("run", 10000), ("count", 10000), ("bounds", 10000), ("flatten", 2000), ("tree", 10000)]
)
@pytest.mark.sampled(5)
def test_thousands_of_levels_of_entities(command: str, levels: int, tmp_path: Path) -> None:
    """Done, or refused: a chain this deep is no reason to crash."""
    file = tmp_path / "chain.scene"
    file.write_text(CHAIN.replace("LEVELS", str(levels)))
    done = copies.command(command, str(file), "--max-seconds", "20")
    assert "Traceback" not in done.stderr, done.stderr[-500:]
    assert done.returncode in (0, 1), done.stderr[-300:]
    assert (done.returncode == 1) == ("error[E" in done.stderr)


def test_guard_catches_no_limit() -> None:
    for body in ("(while #t 1)", "(define (f) (+ 1 (f))) (f)", "(make-list 10000000000 0)"):
        text = f'(define (go) {body}) (define x (guard (e (#t "caught")) (go))) (print x)' + ROOT
        (code,) = codes_of(text, limits=Limits(steps=200_000, depth=2000))
        assert code in ("E501", "E502", "E505")


# --- imports -------------------------------------------------------------------------------------------------------


def imported(folder: Path, path: str, **options: Any) -> list[str]:
    main_file = folder / "main.scene"
    main_file.write_text(f'(import "{path}"){ROOT}')
    session = Session(Options(**options))
    return [d.code for d in session.evaluate(session.source(str(main_file))).diagnostics if d.is_error]


def test_paths_do_not_escape(tmp_path: Path) -> None:
    project = tmp_path / "project"
    project.mkdir()
    outside = tmp_path / "outside.scene"
    outside.write_text("(define secret 1)")
    (project / "link.scene").symlink_to(outside)
    (project / "folder").symlink_to(tmp_path)
    for path in (
        "../outside.scene", str(outside), "link.scene", "folder/outside.scene", "./x/../../outside.scene",
        "/etc/passwd", "/dev/zero", "/proc/self/mem",
    ):  # fmt: skip
        assert imported(project, path) == ["E703"], path
    for path in (
        "~/x.scene",
        "nothing.scene",
        "a" * 5000,
        "x\\0y",
        "std/../prelude.scene",
        "std/nothing.scene",
        "",
        ".",
    ):
        assert imported(project, path) in (["E701"], ["E703"]), path
    assert imported(project, "../outside.scene", allow_outside=True) == []
    (project / "loop").symlink_to(project / "loop")
    assert imported(project, "loop") in (["E701"], ["E703"])


def test_special_files_do_not_hang(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.scene")
    done = subprocess.run(
        [sys.executable, "-c", "import sys, pathlib; sys.path.insert(0, '.');"
         "from scenelang import Session, Source; import os; os.chdir(sys.argv[1]);"
         "r = Session().evaluate(Source('main.scene', '(import \"pipe.scene\")'));"
         "print([d.code for d in r.diagnostics])", str(tmp_path)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert "E701" in done.stdout


def test_import_cycles(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text('(import "b.scene")')
    (tmp_path / "b.scene").write_text('(import "a.scene")')
    (tmp_path / "self.scene").write_text('(import "self.scene")')
    assert imported(tmp_path, "a.scene") == ["E702"]
    assert imported(tmp_path, "self.scene") == ["E702"]
    assert imported(tmp_path, "main.scene") == ["E702"]


def test_a_long_chain_of_imports(tmp_path: Path) -> None:
    for i in range(1500):
        (tmp_path / f"f{i}.scene").write_text(f'(import "f{i + 1}.scene")')
    (tmp_path / "f1500.scene").write_text("(define x 1)")
    codes = imported(tmp_path, "f0.scene")
    assert codes == [] or codes[0][0] == "E"


# --- macros --------------------------------------------------------------------------------------------------------

MACROS = {
    "itself": "(define-syntax m (syntax-rules () ((_) (m)))) (m)",
    "itself in an operand": "(define-syntax m (syntax-rules () ((_) (list (m))))) (m)",
    "itself, deeper": "(define-syntax m (syntax-rules () ((_ x) (m (x x))))) (m 1)",
    "itself twice": "(define-syntax m (syntax-rules () ((_) (begin (m) (m))))) (m)",
    "growth": "(define-syntax m (syntax-rules () ((_ x) (m (x x x))) )) (m 1)",
    "growth of a list": "(define-syntax m (syntax-rules () ((_ x ...) (m x ... x ...)))) (m 1)",
    "growth in a quotation": "(define-syntax m (syntax-rules () ((_ x ...) (m (x ...) (x ...) x ... x ...)))) (m 1)",
    "each other": "(define-syntax a (syntax-rules () ((_) (b)))) (define-syntax b (syntax-rules () ((_) (a)))) (a)",
    "local": "(let-syntax ((m (syntax-rules () ((_) 1)))) (letrec-syntax ((n (syntax-rules () ((_) (n))))) (n)))",
    "procedural, itself": "(define-macro (m) `(m)) (m)",
    "procedural, growth": "(define-macro (m x) `(m (,x ,x))) (m 1)",
    "procedural, growth of a list": "(define-macro (m . xs) `(m ,@xs ,@xs)) (m 1)",
    "procedural, loop": "(define-macro (m) (while #t 1)) (m)",
    "procedural, recursion": "(define-macro (m) (define (f) (+ 1 (f))) (f)) (m)",
    "procedural, memory": "(define-macro (m) (define x (list 1)) (while #t (set! x (append x x)))) (m)",
    "procedural, huge": "(define-macro (m) (make-list 1000000 1)) (m)",
    "procedural, deep": "(define-macro (m) (define x (list)) (for ((i 100000)) (set! x (list 'list x))) x) (m)",
    "procedural, shared": "(define-macro (m) (define x 1) (for ((i 60)) (set! x (list '+ x x))) x) (m)",
    "procedural, cyclic": "(define-macro (m) (define x (mutable-list 1)) (push! x x) x) (m)",
    "procedural, deep quotation": (
        "(define-macro (m) (define x 1) (for ((i 500000)) (set! x (list x))) `(quote ,x)) (m)"
    ),
    "procedural, counted": "(define-macro (m n x) (if (= n 0) x `(m ,(- n 1) (list ,x ,x)))) (print (m 40 1))",
    "counted": (
        f"(define-syntax m (syntax-rules () ((_ () x) x) ((_ (a . r) x) (m r (list x x))))) (print (m ({'1 ' * 40}) 1))"
    ),
    "counted, quoted": (
        "(define-syntax m (syntax-rules () ((_ () x) 'x) ((_ (a . r) x) (m r (list x x))))) "
        f"(print (m ({'1 ' * 40}) 1))"
    ),
    "doubling, nested": ("(define-syntax m (syntax-rules () ((_ x) (+ x x)))) " + f"(print {'(m ' * 40}1{')' * 40})"),
    "defining macros": (
        "(define-syntax m (syntax-rules () ((_ n)"
        " (begin (define-syntax n (syntax-rules () ((_ k) (m k)))) (n q))))) (m a)"
    ),
}


_LONG = ("growth of a list", "counted", "growth", "deep quotation", "deep", "huge", "shared")  # until a limit of time
_SLOW = {"counted", "counted, quoted", "doubling, nested", *(f"procedural, {name}" for name in _LONG)}


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in _SLOW else n for n in MACROS])
@pytest.mark.sampled(5)
def test_macros(name: str) -> None:
    codes = codes_of(MACROS[name] + ROOT)
    assert codes
    assert set(codes) <= {"E106", "E205", "E207", "E208", "E211", "E401", "E403"}, codes


# --- limits --------------------------------------------------------------------------------------------------------

FLAGS = {
    "E501": (["--max-steps", "1000"], "(for ((i 100000)) i)", True),
    "E502": (["--max-depth", "50"], "(define (f n) (if (= n 0) 0 (+ 1 (f (- n 1))))) (f 10000)", True),
    "E503": (["--max-entities", "10"], '(define xs (for/list ((i 100)) (call "cube" :scale (+ i 1))))', True),
    "E505": (["--max-size", "1000"], "(iota 2000)", True),
    "E506": (["--max-memory", "20M"], "(define xs (for/list ((i 300000)) (list i i i)))", True),
    "E507": (["--max-seconds", "0.3"], "(for ((i 10000000)) (sort (iota 100)))", False),
}


@pytest.mark.parametrize("code", FLAGS)
@pytest.mark.sampled(3)
def test_every_limit_has_a_flag(code: str, tmp_path: Path) -> None:
    """In a process of its own: this one may have so much memory at hand that it takes none."""
    flags, program, ends = FLAGS[code]
    file = tmp_path / "p.scene"
    file.write_text(program + ROOT)
    done = copies.command("run", str(file), *flags)
    assert done.returncode == 1
    assert f"error[{code}]" in done.stderr
    assert flags[0] in done.stderr, "the hint names the flag"
    if ends:
        assert copies.command("run", str(file)).returncode == 0


def test_max_primitives(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "p.scene"
    file.write_text('(bind "row" (lambda () (union-loop 100 (lambda (i) (call "cube")))))')
    assert main(["flatten", str(file), "--max-primitives", "99"]) == 1
    assert "error[E504]" in capsys.readouterr().err
    assert main(["flatten", str(file), "--max-primitives", "100"]) == 0
    assert main(["render", str(file), "-o", str(tmp_path / "o.png"), "--max-primitives", "99", "--size", "64x64"]) == 1
    assert "error[E504]" in capsys.readouterr().err


def test_messages_cannot_drive_a_terminal() -> None:
    program = '(bind "a\\x1b;[2Jb" (lambda () (error "x\\x1b;]0;title\\a")))'
    result = Session().evaluate(Source("\x1b[31m.scene", program))
    text = "\n".join(render_text(d) for d in result.diagnostics)
    assert "x\\x1b;]0;title\\x7;" in text
    assert "\x1b" not in text
    assert "\a" not in text
