"""Table of the special forms: syntax, documentation and indentation.

It is used by the expander, the built-in help, the formatter and the generated documentation.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING

from scenelang.grammar.datum import dataclass
from scenelang.grammar.lazy_patterns import lazy_pattern

if TYPE_CHECKING:
    from scenelang.grammar.export.model import Expression, Grammar


@dataclass(frozen=True, slots=True)
class Form:
    """Special form.

    Attributes
    ----------
    name, usage, doc
        Name, syntax and description in one line.
    indent
        Number of operands on the line of the head when it is formatted; None aligns the operands.
    """

    name: str
    usage: str
    doc: str
    indent: int | None = 1


_CLAUSES = "((x xs) ... :when test :unless test :break test)"


def _comprehensions() -> list[Form]:
    """Return the ``for`` forms: one of each kind, with parallel and with nested sequences."""
    kinds = {
        "": ("the value is `none`", "Evaluate the body for its side effects"),
        "/list": ("a list of the body's values", "Build a list"),
        "/union": ("parts, like those of `union`", "Combine entities"),
        "/append": ("the concatenation of the body's lists", "Concatenate lists"),
        "/sum": ("0 if there are none", "Sum the body's values, numbers or arrays"),
        "/and": ("the last value, or `#f` at the first false one", "Test whether all are true"),
        "/or": ("the first true value, or `#f`", "Test whether any is true"),
        "/first": ("the first value of the body, or `#f` if the loop is empty", "Find the first value"),
        "/table": ("a table; the body returns `(list key value)`", "Build a table"),
        "/set": ("a set of the body's values", "Build a set"),
    }
    forms = []
    for star in ("", "*"):
        order = "sequences are nested" if star else "sequences are iterated in parallel, nested after a test"
        for suffix, (value, effect) in kinds.items():
            name = f"for{star}{suffix}"
            forms.append(Form(name, f"({name} {_CLAUSES} body ...)", f"{effect}: {value}; {order}."))
        name = f"for{star}/fold"
        doc = f"Fold with accumulators; the body returns their next values (a list if there are several); {order}."
        forms.append(Form(name, f"({name} ((acc init) ...) {_CLAUSES} body ...)", doc, 2))
    return forms


_FORMS = [
    Form("quote", "(quote datum)", "Return the datum without evaluating it; short form `'x`.", None),
    Form("quasiquote", "(quasiquote template)", "Build data from a template: `` `(a ,x ,@xs) ``.", None),
    Form(
        "if",
        "(if test then [else])",
        "Conditional expression; `#f` and `none` are false, all other values are true.",
        1,
    ),
    Form("lambda", "(lambda (parameter ...) body ...)", "Create a function."),
    Form(
        "define",
        "(define name value) or (define (name parameter ...) body ...)",
        "Define a variable or function, at top level or in a body.",
    ),
    Form(
        "define-values",
        "(define-values (name ...) value)",
        "Destructure a sequence and define a variable for each item.",
    ),
    Form(
        "define-record",
        "(define-record name field (field default) ...)",
        "Define a record type: constructor `(name 1 :field 2)`, `name?`, `name-field`, `set-name-field!`.",
    ),
    Form("define-syntax", "(define-syntax name (syntax-rules ...))", "Define a hygienic macro."),
    Form(
        "syntax-rules",
        "(syntax-rules (literal ...) (pattern template) ...)",
        "Pattern-matching rules of a hygienic macro.",
        1,
    ),
    Form(
        "define-macro",
        "(define-macro (name parameter ...) body ...)",
        "Define a procedural macro, which computes code from its operands.",
    ),
    Form("let-syntax", "(let-syntax ((name (syntax-rules ...)) ...) body ...)", "Define local macros."),
    Form(
        "letrec-syntax",
        "(letrec-syntax ((name (syntax-rules ...)) ...) body ...)",
        "Define mutually recursive local macros.",
    ),
    Form("bind", '(bind "word" function)', "Bind a word to an entity function (paper, appendix A)."),
    Form(
        "import",
        '(import "file.scene" [:prefix name/])',
        "Import the definitions, words and macros of another file.",
        None,
    ),
    Form("scene", '(scene "word" argument ...)', "Declare the root of the scene, with arguments as for `call`.", None),
    Form(
        "param",
        '(param name value "doc" [:min a] [:max b])',
        "Define a constant that can be overridden on the command line.",
    ),
    Form("set!", "(set! name value)", "Assign a new value to an existing variable.", 1),
    Form(
        "let",
        "(let ((name value) ...) body ...) or (let loop ((name value) ...) body ...)",
        "Bind local variables, or define and run a named loop.",
    ),
    Form("let*", "(let* ((name value) ...) body ...)", "Bind local variables in sequence."),
    Form("letrec", "(letrec ((name value) ...) body ...)", "Bind mutually recursive local variables."),
    Form("letrec*", "(letrec* ((name value) ...) body ...)", "Bind mutually recursive local variables in order."),
    Form("let-values", "(let-values (((name ...) value) ...) body ...)", "Destructure sequences into local variables."),
    Form("let*-values", "(let*-values (((name ...) value) ...) body ...)", "Destructure sequences in order."),
    Form("begin", "(begin expression ...)", "Evaluate expressions in order and return the last value.", 0),
    Form("begin0", "(begin0 expression ...)", "Evaluate expressions in order and return the first value.", 0),
    Form(
        "cond",
        "(cond (test body ...) (test => function) ... (else body ...))",
        "Evaluate the clause of the first true test.",
        0,
    ),
    Form(
        "case",
        "(case key ((datum ...) body ...) ... (else body ...))",
        "Evaluate the clause with a constant equal to the key by `equal?`; 1 and 1.0 differ.",
    ),
    Form("when", "(when test body ...)", "Evaluate the body if the test is true."),
    Form("unless", "(unless test body ...)", "Evaluate the body if the test is false."),
    Form("and", "(and expression ...)", "Return the first false value, or the last value.", None),
    Form("or", "(or expression ...)", "Return the first true value, or the last value.", None),
    Form(
        "do",
        "(do ((name init step) ...) (test result ...) body ...)",
        "Loop with variables that are updated in each iteration, as in Scheme.",
        2,
    ),
    Form("while", "(while test body ...)", "Evaluate the body repeatedly while the test is true."),
    Form("let/ec", "(let/ec name body ...)", "Bind an escape procedure: `(name value)` exits the body early."),
    Form(
        "guard", "(guard (name (test handler ...) ...) body ...)", "Evaluate the body and handle the errors it raises."
    ),
    Form("assert", '(assert test ["message"])', "Raise an error if the test is false.", None),
    Form(
        "assert-that",
        '(assert-that (relation word ...) ... ["message"])',
        'State relations of objects, such as `(on "cup" "table")`, about the entity that is being made, or at top '
        "level about the scene; `check --run` tests whether they hold.",
        None,
    ),
    *_comprehensions(),
]

FORMS: dict[str, Form] = {form.name: form for form in _FORMS}

INDENTS: Mapping[str, int | None] = {
    form.name: form.indent for form in _FORMS
}  # by head, for the layout and the formatter

# Scheme's names that the language does not have, those of R7RS-small and a few more, with what to write instead.
_ABSENT: tuple[tuple[str, str], ...] = (
    ("call/cc call-with-current-continuation", "use `let/ec` to exit early"),
    ("dynamic-wind with-exception-handler raise-continuable", "use `guard` to handle errors"),
    ("error-object? error-object-message error-object-irritants read-error? file-error?",
     "use `error?`, `error-message` and `error-code`"),
    ("case-lambda", "give one function optional parameters: `(define (f a (b 2)) ...)`"),
    ("eval interaction-environment", "data cannot be evaluated; use functions or macros"),
    ("delay delay-force make-promise promise?", "wrap it in `(lambda () ...)`"),
    ("force", "call the function instead"),
    ("make-parameter parameterize", "pass the value as an argument"),
    ("call-with-values", "`values` returns a list; destructure it with `let-values`"),
    ("define-record-type", "write `(define-record name field ...)`"),
    ("read read-line read-char read-string peek-char char-ready? current-input-port eof-object eof-object? read-u8 "
     "peek-u8 u8-ready? read-bytevector read-bytevector!", "programs cannot read input; use `param`"),
    ("open-input-file open-binary-input-file with-input-from-file call-with-input-file load include include-ci",
     'programs cannot open files; use `import` or `(call "mesh" :file ...)`'),
    ("open-output-file open-binary-output-file with-output-to-file call-with-output-file delete-file file-exists?",
     "programs cannot open files"),
    ("open-input-string open-output-string get-output-string open-input-bytevector open-output-bytevector "
     "get-output-bytevector call-with-port close-port close-input-port close-output-port current-output-port "
     "current-error-port flush-output-port input-port? output-port? input-port-open? output-port-open? textual-port? "
     "binary-port?", "there are no ports; use `print` and `format`"),
    ("display newline write write-shared write-simple write-string write-char write-u8 write-bytevector",
     "use `print`"),
    ("string-set! string-fill! string-copy! make-string", "strings are immutable; build a new one"),
    ("string-copy vector-copy", "strings and arrays are immutable: a copy is not needed"),
    ("string-map string-for-each vector-for-each", "use `map` or `for-each`, which take any sequence"),
    ("string->vector vector->string vector-append", "use `append` or `string->list`"),
    ("vector-set! list-set! vector-fill! vector-copy!", "use `(set-ref! xs i value)` on a mutable list or array"),
    ("make-vector", "use `(make-list n x)`, `(zeros n)` or `(mutable-list ...)`"),
    ("hash-table-ref", "use `(ref table key default)`"),
    ("set-car! set-cdr!", "pairs are immutable; use `(mutable-list ...)`"),
    ("char? char=? char<? char>? char<=? char>=? char-ci=? char-ci<? char-ci>? char-ci<=? char-ci>=? char-upcase "
     "char-downcase char-foldcase char-alphabetic? char-numeric? char-whitespace? char-upper-case? char-lower-case? "
     "digit-value char->integer integer->char", "characters are strings of length 1"),
    ("string-foldcase string-ci<? string-ci>? string-ci<=? string-ci>=?", "compare what `string-downcase` gives"),
    ("bytevector bytevector? make-bytevector bytevector-length bytevector-u8-ref bytevector-u8-set! bytevector-append "
     "bytevector-copy bytevector-copy! string->utf8 utf8->string", "there are no byte strings; use lists of numbers"),
    ("complex? real? rational? exact-integer? symbol=?", "use `number?`, `integer?` and `equal?`"),
    ("make-rectangular make-polar real-part imag-part magnitude numerator denominator rationalize",
     "numbers are integers and floats"),
    ("floor-quotient", "use `//`"),
    ("floor-remainder", "use `modulo`"),
    ("truncate-quotient", "use `quotient`"),
    ("truncate-remainder", "use `remainder`"),
    ("cond-expand features syntax-error", "there is one implementation: nothing depends on features"),
    ("exit emergency-exit", "a program ends by its value; `(error ...)` ends it with a message"),
    ("command-line get-environment-variable get-environment-variables", "a program knows its params only; use `param`"),
    ("current-second current-jiffy jiffies-per-second", "a program gives the same scene at any time"),
)  # fmt: skip
ABSENT: Mapping[str, str] = {name: instead for names, instead in _ABSENT for name in names.split()}

# Names of earlier versions, with the names of today (docs/decisions.md, "Names of the field").
RENAMED: Mapping[str, str] = {"radians": "deg", "degrees": "to-degrees", "union-solid": "solid-union"}


# An example of every special form: a small program, and the value of its last expression (None for a definition).


FORM_EXAMPLES: Mapping[str, tuple[str, str | None]] = {
    "quote": ('(quote (a 1 "b"))', '(a 1 "b")'),
    "quasiquote": ("(let ((x 2)) `(x is ,x and then ,@(list 3 4)))", "(x is 2 and then 3 4)"),
    "if": ('(let ((x 2)) (if (> x 1) "more" "less"))', '"more"'),
    "lambda": ("((lambda (x (:by 2)) (* x by)) 5 :by 3)", "15"),
    "define": ("(define (square x)\n  (define factor x)\n  (* factor x))\n(square 4)", "16"),
    "define-values": ("(define-values (width height) (list 3 4))\n(* width height)", "12"),
    "define-record": ("(define-record leg (height .7) (count 4))\n(leg-height (leg :count 3))", "0.7"),
    "define-syntax": (
        "(define-syntax twice\n"
        "  (syntax-rules ()\n"
        "    ((_ part offset) (union part (transform part (translate offset))))))\n"
        '(length (twice (call "cube") [2 0 0]))',
        "2",
    ),
    "syntax-rules": (
        "(define-syntax sum-of\n"
        "  (syntax-rules (to)\n"
        "    ((_ a to b) (for/sum ((n (range a (+ b 1)))) n))))\n"
        "(sum-of 1 to 4)",
        "10",
    ),
    "define-macro": (
        '(define-macro (repeat n expression)\n  `(for/list ((_ (iota ,n))) ,expression))\n(repeat 3 "x")',
        '("x" "x" "x")',
    ),
    "let-syntax": ("(let-syntax ((double (syntax-rules () ((_ x) (* 2 x))))) (double 21))", "42"),
    "letrec-syntax": (
        "(letrec-syntax ((any (syntax-rules () ((_) #f) ((_ x . more) (if x #t (any . more))))))\n  (any #f 3 #f))",
        "#t",
    ),
    "bind": (
        '(bind "ball" (lambda ((:size 1)) (call "sphere" :radius (/ size 2))))\n(bind "pair"\n  (lambda ()\n'
        '    (union (call "ball") (transform (call "ball" :size 2) (translate [2 0 0])))))',
        None,
    ),
    "import": ('(import "std/python.scene" :prefix py/)\n(py/py-+ "a" "b")', '"ab"'),
    "scene": ('(bind "tree" (lambda ((:height 2)) (call "cone" :p1 [0 height 0])))\n(scene "tree" :height 5)', None),
    "param": (
        '(param floors 3 "number of floors" :min 1 :max 9)\n(bind "house"\n  (lambda ()\n'
        '    (union-loop floors (lambda (i) (transform (call "cube") (translate [0 i 0]))))))',
        None,
    ),
    "set!": ("(let ((n 1)) (set! n (+ n 1)) n)", "2"),
    "let": ("(let loop ((n 5) (product 1)) (if (= n 0) product (loop (- n 1) (* n product))))", "120"),
    "let*": ("(let* ((x 3) (y (* x x))) (+ x y))", "12"),
    "letrec": (
        "(letrec ((even (lambda (n) (if (= n 0) #t (odd (- n 1)))))\n"
        "         (odd (lambda (n) (if (= n 0) #f (even (- n 1))))))\n  (even 10))",
        "#t",
    ),
    "letrec*": ("(letrec* ((two 2) (double (lambda (x) (* two x)))) (double 4))", "8"),
    "let-values": ("(let-values (((x y) (list 1 2))) (+ x y))", "3"),
    "let*-values": ("(let*-values (((x y) (list 1 2)) ((z) (list (+ x y)))) z)", "3"),
    "begin": ("(begin 1 2 3)", "3"),
    "begin0": ("(let ((n 1)) (begin0 n (set! n 9)))", "1"),
    "cond": ('(let ((x 0)) (cond ((> x 0) "plus") ((< x 0) "minus") (else "nought")))', '"nought"'),
    "case": ('(case "rook" (("rook" "bishop") 1) (("king") 2) (else 0))', "1"),
    "when": ('(let ((x 2)) (when (> x 1) "more"))', '"more"'),
    "unless": ('(let ((x 2)) (unless (> x 1) "less"))', "none"),
    "and": ("(let ((x 2)) (and (> x 1) (* 2 x)))", "4"),
    "or": ("(let ((x none)) (or x 3))", "3"),
    "do": ("(do ((i 0 (+ i 1)) (sum 0 (+ sum i))) ((= i 5) sum))", "10"),
    "while": ("(let ((n 100)) (while (> n 10) (set! n (/ n 2))) n)", "6.25"),
    "let/ec": ('(let/ec leave (for ((x \'(1 2 7 4))) (when (> x 5) (leave x))) "none found")', "7"),
    "guard": ('(guard (e ((error-is? e "zero-division") "endless")) (/ 1 0))', '"endless"'),
    "assert": ('(let ((x 3)) (guard (e (#t (error-message e))) (assert (< x 2) "too large")))', '"too large"'),
    "assert-that": (
        '(bind "stack"\n  (lambda ()\n    (assert-that (on "ball" "box") (count "box" 1))\n'
        '    (union (call "box") (transform (call "ball") (translate [0 1 0])))))\n'
        '(bind "box" (lambda () (call "cube")))\n(bind "ball" (lambda () (call "sphere" :radius .5)))',
        None,
    ),
    "for": ("(let ((n 0)) (for ((x '(1 2 3))) (set! n (+ n x))) n)", "6"),
    "for/list": ("(for/list ((x '(1 2 3)) :when (odd? x)) (* x x))", "(1 9)"),
    "for/union": ('(length (for/union ((x \'(-1 1))) (transform (call "cube") (translate [x 0 0]))))', "2"),
    "for/append": ("(for/append ((n '(1 2 3))) (make-list n n))", "(1 2 2 3 3 3)"),
    "for/sum": ("(for/sum ((x '(1 2 3)) (y '(10 20 30))) (* x y))", "140"),
    "for/and": ("(for/and ((x '(1 3 5))) (odd? x))", "#t"),
    "for/or": ("(for/or ((x '(2 3 4))) (and (odd? x) (* 10 x)))", "30"),
    "for/first": ("(for/first ((x '(5 8 9)) :when (even? x)) x)", "8"),
    "for/table": ('(ref (for/table ((name \'("king" "queen")) (height \'(2 1.8))) (list name height)) "queen")', "1.8"),
    "for/set": ("(length (for/set ((x '(1 -1 2))) (abs x)))", "2"),
    "for/fold": ("(for/fold ((total 0) (largest 0)) ((x '(3 9 4))) (list (+ total x) (max largest x)))", "(16 9)"),
    "for*": ("(let ((n 0)) (for* ((x '(1 2)) (y '(10 20))) (set! n (+ n (* x y)))) n)", "90"),
    "for*/list": ("(for*/list ((x '(1 2)) (y (iota x))) (list x y))", "((1 0) (2 0) (2 1))"),
    "for*/union": (
        "(length\n  (for*/union ((x '(-1 0 1)) (z '(-1 0 1)) :unless (= x z 0))\n"
        '    (transform (call "cube") (translate [x 0 z]))))',
        "8",
    ),
    "for*/append": ("(for*/append ((x '(1 2)) (y '(3 4))) (list x y))", "(1 3 1 4 2 3 2 4)"),
    "for*/sum": ("(for*/sum ((x '(1 2)) (y '(10 20))) (* x y))", "90"),
    "for*/and": ("(for*/and ((row '((1 2) (3 4))) (x row)) (> x 0))", "#t"),
    "for*/or": ("(for*/or ((row '((1 2) (3 4))) (x row)) (> x 3))", "#t"),
    "for*/first": ("(for*/first ((x (range 1 20)) (y (range 1 x)) :when (= (* x y) 42)) (list x y))", "(7 6)"),
    "for*/table": ("(length (for*/table ((x '(1 2 3)) (y '(1 2))) (list (* x y) (list x y))))", "5"),
    "for*/set": ("(length (for*/set ((x '(1 2)) (y '(1 2))) (+ x y)))", "3"),
    "for*/fold": (
        '(for*/fold ((longest "")) ((row \'(("a" "oak") ("fir" "birch"))) (s row))\n'
        "  (if (> (length s) (length longest)) s longest))",
        '"birch"',
    ),
}


# Grammar of the special forms: the operands of each form, and shared rules.
#
# The notation is Lark's, over datums: `"("` is a bracket, upper-case names are tokens of ``grammar.export.model``. The
# expander checks the same syntax with readable messages; tests compare the two.


_LET = "bindings body"
_LOOP = "binder loop_bindings body"
_FOR = "clauses body"

# Forms that are expressions, by head.
EXPRESSIONS: Mapping[str, str] = MappingProxyType({
    "quote": "datum",
    "quasiquote": "template",
    "if": "expr expr expr?",
    "lambda": "parameters body",
    "let-syntax": "macro_bindings body",
    "letrec-syntax": "macro_bindings body",
    "bind": "expr expr",
    "set!": "name expr",
    "let": f"{_LET} | {_LOOP}",
    "let*": _LET,
    "letrec": _LET,
    "letrec*": _LET,
    "let-values": f"{_LET} | {_LOOP}",
    "let*-values": _LET,
    "begin0": "expr+",
    "cond": "cond_clauses",
    "case": "expr case_clauses",
    "when": "expr body",
    "unless": "expr body",
    "and": "expr*",
    "or": "expr*",
    "do": '"(" do_variable* ")" "(" expr body? ")" body?',
    "while": "expr body?",
    "let/ec": "binder body",
    "guard": '"(" binder cond_clauses? ")" body',
    "assert": "expr expr?",
    "assert-that": "relation+ STRING?",
    **{name: _FOR for name in FORMS if name.startswith("for") and not name.endswith("/fold")},
    **dict.fromkeys(("for/fold", "for*/fold"), f"accumulators {_FOR}"),
})  # fmt: skip

# Forms of bodies and of the top level that define names.
DEFINITIONS: Mapping[str, str] = MappingProxyType({
    "define": 'NAME expr | "(" NAME parameter_list? rest? ")" body',
    "define-values": "target expr",
    "define-record": "NAME field* default_field*",
})  # fmt: skip

# Forms that define macros; a body that contains only these is empty.
MACROS: Mapping[str, str] = MappingProxyType({
    "define-syntax": "NAME rules",
    "define-macro": '"(" NAME parameter_list? rest? ")" body',
})  # fmt: skip

# Forms that are only allowed at top level.
TOP_LEVEL: Mapping[str, str] = MappingProxyType({
    "import": 'STRING (":prefix" SYMBOL)?',
    "scene": "expr+",
    "param": 'NAME expr STRING? (":min" NUMBER | ":max" NUMBER)*',
})  # fmt: skip

# Forms with explicit rules below: the contents of `begin` depend on its context; `syntax-rules` is not an expression.
SPELLED_OUT = frozenset({"begin", "syntax-rules"})

RULES = """
start: top*
top: plain | "(" "begin" top* ")" | definition | macro_definition | top_form

expr: plain | begin
begin: "(" "begin" expr+ ")"
plain: name | literal | array | form | application | quotation
name: NAME | "@" | "scene" | "param"
binder: name | "_"
literal: NUMBER | STRING | BOOLEAN | NONE | KEYWORD | ANNOTATED_KEYWORD | HANDLE
array: "[" expr* "]"
application: "(" callee operand* ")"
callee: NAME | "@" | literal | array | form | begin | application | quotation
operand: expr | definition | "else" | "=>"

body: silent* loud (silent | loud)*
silent: macro_definition | "(" "begin" silent+ ")"
loud: plain | definition | "(" "begin" body ")"

parameters: bare_parameter | "(" ")" | "(" parameter_list rest? ")"
parameter_list: early+ | early* optional late*
early: bare_parameter | keyword_parameter
late: optional | keyword_parameter
bare_parameter: binder | ANNOTATED
optional: "(" bare_parameter expr ")"
keyword_parameter: bare_keyword | "(" bare_keyword expr ")" | "&keys" bare_parameter
bare_keyword: KEYWORD | ANNOTATED_KEYWORD
rest: "." bare_parameter

relation: "(" NAME expr+ ")"

target: binder | "(" target* ")" | "(" target+ "." target ")"
bindings: "(" binding* ")"
binding: "(" target expr ")"
loop_bindings: "(" optional* ")"
accumulators: "(" accumulator* ")"
accumulator: "(" binder expr ")"
clauses: "(" clause* ")"
clause: binding | (":when" | ":unless" | ":break") expr
do_variable: "(" bare_parameter expr expr? ")"

cond_clauses: cond_clause+ else_clause? | else_clause
cond_clause: "(" expr ")" | "(" expr "=>" expr ")" | "(" expr body ")"
else_clause: "(" "else" body ")"
case_clauses: case_clause+ case_else? | case_else
case_clause: "(" "(" datum* ")" ("=>" expr | body) ")"
case_else: "(" "else" ("=>" expr | body) ")"

field: name | ANNOTATED
default_field: "(" field expr ")"

macro_bindings: "(" macro_binding* ")"
macro_binding: "(" NAME rules ")"
rules: "(" "syntax-rules" literals rule* ")" | "(" "syntax-rules" NAME literals free_rule* ")"
literals: "(" datum* ")"
rule: "(" pattern_list datum ")"
free_rule: "(" list datum ")"
pattern_list: "(" ")" | "(" pattern_items ("." PATTERN_SYMBOL)? ")"
pattern_items: pattern+ | pattern+ "..." pattern*
pattern: PATTERN_SYMBOL | ANNOTATED | literal | pattern_list | "[" pattern_items? "]" | "'" pattern

datum: SYMBOL | ANNOTATED | literal | list | "[" datum* "]"
     | "'" datum | "`" datum | "," datum | ",@" datum
list: "(" datum* ")" | "(" datum+ "." datum ")"

quotation: "'" datum | "`" template
template: TEMPLATE_SYMBOL | ANNOTATED | literal | "[" member* "]" | "'" template | "`" inner_template
        | "," unquoted | "(" "unquote" expr ")" | "(" "quasiquote" inner_template ")"
        | "(" member* ")" | "(" member+ "." template ")"
inner_template: TEMPLATE_SYMBOL | ANNOTATED | literal | "[" inner_template* "]" | "'" inner_template | "," template
      | ",@" template | "(" inner_template* ")" | "(" inner_template+ "." inner_template ")"
unquoted: NAME | "scene" | "param" | literal | array | form | begin | application | quotation
member: template | ",@" expr | "(" "unquote-splicing" expr ")"
"""


# Editor snippets of the special forms, such as `(if ${1:test} ${2:then})`.


_LITERAL_WORDS = frozenset({"else", "=>", "syntax-rules", "_"})  # literal words of a usage text
_RULES = "(syntax-rules () ((_ pattern) template))"
_TOKEN = lazy_pattern(r'"[^"]*"|[()]|[^\s()"]+|\s+')


def snippet(form: Form) -> str:
    """Return a snippet of the first usage of ``form`` with numbered placeholders, without optional parts."""
    usage = form.usage.split(" or ")[0].replace("(syntax-rules ...)", _RULES)
    usage = re.sub(r"\s*\[[^\]]*\]", "", usage)  # optional parts
    usage = re.sub(r"\s+:\w+ test", "", usage)
    usage = re.sub(r" \([^()]*\) \.\.\.(?= \()", "", usage).replace(" ...", "")
    number = 0
    pieces = []
    for position, token in enumerate(_TOKEN.findall(usage)):
        name = token.strip('"')
        if position == 1 or token in ("(", ")") or token.isspace() or name in _LITERAL_WORDS or name.startswith(":"):
            pieces.append(token)
            continue
        number += 1
        placeholder = f"${{{number}:{name}}}"
        pieces.append(f'"{placeholder}"' if token.startswith('"') else placeholder)
    return "".join(pieces) + "$0"


# The grammar of programs, full and strict, which combines the special forms and the paper's rules.


_GROUPS: Mapping[str, Mapping[str, str]] = MappingProxyType({
    "form": EXPRESSIONS,
    "definition": DEFINITIONS,
    "macro_definition": MACROS,
    "top_form": TOP_LEVEL,
})  # fmt: skip


@cache
def full_grammar() -> Grammar:
    """Return the grammar of all syntactically valid programs."""
    from scenelang.grammar.export.model import literals, parse_rules

    rules = parse_rules(RULES)
    for group, shapes in _GROUPS.items():
        rules |= _forms(group, shapes)
    return _grammar(rules, literals(rules), "The Scene Language")


@cache
def strict_grammar() -> Grammar:
    """Return the grammar of the language as in the Scene Language paper (arXiv:2410.16770), for ``check --strict``."""
    from scenelang.grammar.export.model import literals, strict_rules

    full = full_grammar().rules
    # Datum comments, `#;`, are allowed as well, and may contain any datum.
    rules = {**strict_rules(), **{name: full[name] for name in ("datum", "list", "literal")}}
    reserved = literals(rules) | literals(full)
    return _grammar(rules, reserved, "The Scene Language, exactly the paper's grammar")


def _grammar(rules: Mapping[str, Expression], reserved: frozenset[str], title: str) -> Grammar:
    from scenelang.grammar.export.model import Grammar, tokens, used_terminals

    used = used_terminals(rules)
    known = {name: token for name, token in tokens(reserved).items() if name in used}
    return Grammar("start", MappingProxyType(dict(rules)), MappingProxyType(known), title)


def _forms(group: str, shapes: Mapping[str, str]) -> dict[str, Expression]:
    """Return a rule for each syntax, named after the first form that has it, and the rule ``group`` of all of them."""
    from scenelang.grammar.export.model import Literal, Ref, choice, parse_expression, sequence

    heads: dict[str, list[str]] = {}
    for head, shape in shapes.items():
        heads.setdefault(shape, []).append(head)
    rules: dict[str, Expression] = {}
    for shape, names in heads.items():
        word = choice(*(Literal(name) for name in names))
        rules[_rule_name(names[0])] = sequence(Literal("("), word, parse_expression(shape), Literal(")"))
    return {group: choice(*(Ref(name) for name in rules)), **rules}


def _rule_name(head: str) -> str:
    """Return the rule name of a form, such as ``let_star_values_form``."""
    spelled = head.replace("*", "_star").replace("!", "").replace("/", "_").replace("-", "_")
    return f"{spelled}_form"


# Procedures of the paper whose direct calls the compiler knows, with the terminals of ``core.lark``.
PAPER_FORMS = {"call": "CALL", "union": "UNION", "union-loop": "UNION_LOOP", "transform": "TRANSFORM"}
