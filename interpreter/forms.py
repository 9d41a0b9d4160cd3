"""The special forms: shape, doc and indentation of each. Expansion, help, formatter and docs read this table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Form:
    """``indent``: how many operands stand on the head's line before the body is indented by two; None: aligned."""

    name: str
    usage: str
    doc: str
    indent: int | None = 1


_CLAUSES = "((x xs) ... :when test :unless test :break test)"


def _comprehensions() -> list[Form]:
    kinds = {
        "": ("the value is `none`", "Run the body for its effects"),
        "/list": ("a list of the body's values", "Collect"),
        "/union": ("parts, as `union` makes them", "Unite entities"),
        "/append": ("the body's lists, joined", "Join lists"),
        "/sum": ("a number", "Add up the body's values"),
        "/and": ("the last value, or `#f` at the first false one", "Test all"),
        "/or": ("the first true value, or `#f`", "Test whether any"),
        "/first": ("the body's first value, or `#f` when there is none", "Find the first"),
        "/table": ("a table; the body gives `(list key value)`", "Build a table"),
        "/set": ("a set of the body's values", "Build a set"),
    }
    forms = []
    for star in ("", "*"):
        how = "sequences run nested" if star else "sequences run side by side, nested after a test"
        for suffix, (value, what) in kinds.items():
            name = f"for{star}{suffix}"
            forms.append(Form(name, f"({name} {_CLAUSES} body ...)", f"{what}: {value}; {how}."))
        name = f"for{star}/fold"
        doc = f"Carry accumulators through the loop; the body gives their next values (a list when several); {how}."
        forms.append(Form(name, f"({name} ((acc init) ...) {_CLAUSES} body ...)", doc, 2))
    return forms


_FORMS = [
    Form("quote", "(quote datum)", "The datum itself, as data: `'x`.", None),
    Form("quasiquote", "(quasiquote template)", "A template: `` `(a ,x ,@xs) ``.", None),
    Form("if", "(if test then [else])", "Choose: `#f` and `none` are false, all else is true.", 1),
    Form("lambda", "(lambda (parameter ...) body ...)", "A function."),
    Form(
        "define", "(define name value) or (define (name parameter ...) body ...)", "Define a name, here or in a body."
    ),
    Form("define-values", "(define-values (name ...) value)", "Take a sequence apart and define its items."),
    Form(
        "define-record",
        "(define-record name field (field default) ...)",
        "A record: constructor `(name 1 :field 2)`, `name?`, `name-field`, `set-name-field!`.",
    ),
    Form("define-syntax", "(define-syntax name (syntax-rules ...))", "A hygienic macro."),
    Form("syntax-rules", "(syntax-rules (literal ...) (pattern template) ...)", "Rules of a hygienic macro.", 1),
    Form("define-macro", "(define-macro (name parameter ...) body ...)", "A macro computed from its operands as data."),
    Form("let-syntax", "(let-syntax ((name (syntax-rules ...)) ...) body ...)", "Local macros."),
    Form(
        "letrec-syntax", "(letrec-syntax ((name (syntax-rules ...)) ...) body ...)", "Local macros that see each other."
    ),
    Form("bind", '(bind "word" function)', "Define and bind an entity function (paper, appendix A)."),
    Form("import", '(import "file.scene" [:prefix name/])', "Use another file's definitions, words and macros.", None),
    Form("scene", '(scene "word" argument ...)', "Name the root of the scene; arguments as in `call`.", None),
    Form("param", '(param name value "doc" [:min a] [:max b])', "A constant that the command line may override."),
    Form("set!", "(set! name value)", "Assign a variable that exists.", 1),
    Form(
        "let", "(let ((name value) ...) body ...) or (let loop ((name value) ...) body ...)", "Local names, or a loop."
    ),
    Form("let*", "(let* ((name value) ...) body ...)", "Local names, each seeing those before it."),
    Form("letrec", "(letrec ((name value) ...) body ...)", "Local names that see one another."),
    Form("letrec*", "(letrec* ((name value) ...) body ...)", "Local names that see one another, in order."),
    Form("let-values", "(let-values (((name ...) value) ...) body ...)", "Local names from sequences."),
    Form("let*-values", "(let*-values (((name ...) value) ...) body ...)", "Local names from sequences, in order."),
    Form("begin", "(begin expression ...)", "One after the other; the value is the last one's.", 0),
    Form("begin0", "(begin0 expression ...)", "One after the other; the value is the first one's.", 0),
    Form("cond", "(cond (test body ...) (test => function) ... (else body ...))", "The first true test decides.", 0),
    Form(
        "case",
        "(case key ((datum ...) body ...) ... (else body ...))",
        "Choose by an equal constant, as `equal?` has it: 1 and 1.0 differ.",
    ),
    Form("when", "(when test body ...)", "Run the body if the test is true."),
    Form("unless", "(unless test body ...)", "Run the body if the test is false."),
    Form("and", "(and expression ...)", "The first false value, or the last one.", None),
    Form("or", "(or expression ...)", "The first true value, or the last one.", None),
    Form("do", "(do ((name init step) ...) (test result ...) body ...)", "Scheme's loop.", 2),
    Form("while", "(while test body ...)", "Run the body as long as the test is true."),
    Form("let/ec", "(let/ec name body ...)", "Call `(name value)` to leave the body early."),
    Form("guard", "(guard (name (test handler ...) ...) body ...)", "Catch errors that the body raises."),
    Form("assert", '(assert test ["message"])', "Raise an error unless the test is true.", None),
    *_comprehensions(),
]

FORMS: dict[str, Form] = {form.name: form for form in _FORMS}

INDENTS: Mapping[str, int | None] = {form.name: form.indent for form in _FORMS}  # as layout and formatter take them

# Scheme's features that are left out on purpose, with what to do instead.
ABSENT: dict[str, str] = {
    "call/cc": "leave early with `let/ec`",
    "call-with-current-continuation": "leave early with `let/ec`",
    "dynamic-wind": "catch errors with `guard`",
    "eval": "nothing evaluates data; use functions or macros",
    "delay": "wrap it in `(lambda () ...)`",
    "force": "call the function instead",
    "make-promise": "wrap it in `(lambda () ...)`",
    "call-with-values": "`values` makes a list; take it apart with `let-values`",
    "define-record-type": "write `(define-record name field ...)`",
    "read": "programs cannot read input; use `param`",
    "read-line": "programs cannot read input; use `param`",
    "open-input-file": 'programs cannot open files; use `import` or "asset"',
    "open-output-file": "programs cannot open files",
    "with-output-to-file": "programs cannot open files",
    "display": "use `print`",
    "newline": "use `print`",
    "write": "use `print`",
    "string-set!": "strings do not change; build a new one",
    "vector-ref": "`(ref xs i)` reads any sequence",
    "vector-set!": "`(set-ref! xs i value)` changes a mutable list or array",
    "make-vector": "use `(make-list n x)`, `(zeros n)` or `(mutable-list ...)`",
    "hash-table-ref": "`(ref table key default)` reads a table",
    "set-car!": "pairs do not change; use `(mutable-list ...)`",
    "set-cdr!": "pairs do not change; use `(mutable-list ...)`",
    "char?": "characters are strings of length 1",
}
