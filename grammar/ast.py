"""Core AST: the forms that remain after macro expansion (see ``core.lark``).

Identifiers and builtins are opaque here: ``Reference.target`` is the expander's resolution of a name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, TypeAlias

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Handle, Keyword, ListDatum, Span, Symbol, dataclass
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.lalr import END, Builders, Misfit, Tables, tables_of


@dataclass(frozen=True, slots=True, eq=False)
class Constant:
    """Literal value, including a quoted datum."""

    value: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class HandleLiteral:
    """Embedding handle ``<z1>``, whose attributes may be overridden by the embeddings file Z."""

    name: str
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Use of a variable or builtin."""

    target: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Assignment:
    """``(set! target value)``."""

    target: Any
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class If:
    """``(if test then otherwise)``."""

    test: Expr
    then: Expr
    otherwise: Expr | None
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class And:
    """``(and item ...)``."""

    items: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Or:
    """``(or item ...)``."""

    items: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Parameter:
    """Parameter of a function.

    Attributes
    ----------
    target
        Variable that the parameter binds.
    name
        Name as spelled by the user, for keyword arguments and messages.
    kind
        ``required``, ``optional``, ``keyword``, ``rest`` or ``keys``.
    type
        Type annotation, if any.
    default
        Default expression of an optional or keyword parameter.
    """

    target: Any
    name: str
    kind: str
    type: Any = None
    default: Expr | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Lambda:
    """Function. ``usage`` is its signature for error messages."""

    name: str
    parameters: tuple[Parameter, ...]
    usage: str
    body: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Define:
    """Local definition inside a ``Body``, or top-level definition. ``target`` may be a destructuring pattern."""

    target: Any
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Sequence of definitions and expressions, evaluated in order; its value is that of the last one."""

    items: tuple[Define | Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class First:
    """``begin0``: evaluate all items in order and return the value of the first."""

    items: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Application:
    """Function call ``(function argument ...)``."""

    function: Expr
    arguments: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class ArrayLiteral:
    """Array literal ``[item ...]``."""

    items: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class While:
    """``(while test body)``."""

    test: Expr
    body: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Clause:
    """Clause of a ``for`` form.

    Attributes
    ----------
    kind
        "each" for parallel bindings; "when", "unless" or "break" for a test.
    targets, values
        Variables or patterns and their sequences; a test has one value and no target.
    """

    kind: str
    targets: tuple[Any, ...]
    values: tuple[Expr, ...]


@dataclass(frozen=True, slots=True, eq=False)
class For:
    """Loop or comprehension.

    Attributes
    ----------
    kind
        What is made of the body's values: each (nothing), list, union, append, sum, and, or, first, fold, table or set.
    accumulators
        Variables of a fold, with their initial values.
    clauses
        Sequences and tests.
    """

    kind: str
    accumulators: tuple[Define, ...]
    clauses: tuple[Clause, ...]
    body: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class LetEscape:
    """``(let/ec name body)``: bind an escape continuation."""

    target: Any
    name: str
    body: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Guard:
    """Evaluate ``body``; on an error, bind the error to ``target`` and evaluate ``handler``."""

    target: Any
    body: Expr
    handler: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Bind:
    """``<bind-expr>``: bind a word to an entity function.

    ``top_level`` is set if a literal word is bound at the top level of its file.
    """

    word: Expr
    function: Expr
    span: Span
    top_level: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Call:
    """``<entity>``: create an entity with ``(call word argument ...)``."""

    word: Expr
    arguments: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Union:
    """``<sub-entities>``: ``(union member ...)``."""

    members: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class UnionLoop:
    """``<sub-entities>``: ``(union-loop count function)``."""

    count: Expr
    function: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """``<entity-transform>``: ``(transform part matrix)``."""

    part: Expr
    matrix: Expr
    span: Span


Expr: TypeAlias = (
    Constant | HandleLiteral | Reference | Assignment | If | And | Or | Lambda | Body | First | Application
    | ArrayLiteral | While | For | LetEscape | Guard | Bind | Call | Union | UnionLoop | Transform
)  # fmt: skip


# Parsing datums into the core AST, by ``core.lark``. The output of macros is checked by the same grammar, and errors
# carry the span of the offending datum.


class Head(str):
    """Head of a core form in the expander's output; the text is the name of the grammar's terminal."""

    __slots__ = ()


class Opaque:
    """Value that the grammar treats as a single token; created by the expander, unpacked by the AST builder."""

    __slots__ = ("terminal", "value")

    def __init__(self, terminal: str, value: Any) -> None:
        self.terminal = terminal
        self.value = value


_TERMINALS: dict[type, str] = {
    Handle: "HANDLE", int: "CONSTANT", float: "CONSTANT", str: "CONSTANT", bool: "CONSTANT", type(None): "CONSTANT",
    Keyword: "CONSTANT",
}  # fmt: skip


def _terminal(value: Any) -> str:
    """Return the terminal of ``core.lark`` that an atom of expanded code stands for."""
    kind = type(value)
    if kind is Head:
        return str(value)
    return str(value.terminal) if kind is Opaque else _TERMINALS.get(kind, "IDENTIFIER")


_Stack: TypeAlias = list[tuple[ListDatum | ArrayDatum | None, Iterator[Datum]]]


def _tokens(datums: Sequence[Datum], terminal: Callable[[Any], str], stack: _Stack) -> Iterator[tuple[str, Any]]:
    """Iterate over the terminals of datums in depth-first order, without recursion.

    The value of an atom and of an opening bracket is its datum, that of a closing bracket the list. ``stack`` holds
    the open forms, the innermost last; after a syntax error it tells in which form the parser stopped.
    """
    stack.append((None, iter(datums)))
    while stack:
        form, parts = stack[-1]
        for datum in parts:
            if type(datum) is Atom:
                yield terminal(datum.value), datum
            else:
                assert not isinstance(datum, Atom)
                yield "LSQB" if type(datum) is ArrayDatum else "LPAR", datum
                stack.append((datum, iter(datum.items)))
                break
        else:
            if form is not None:
                yield "RSQB" if type(form) is ArrayDatum else "RPAR", form
            stack.pop()
    yield END, None


class _Builder:
    """Builds the AST bottom-up: one method for each rule of ``core.lark``, with the rule's name.

    Each method gets the parts of its rule in order, brackets included (hence ``items[:-1]``). The span of a form is
    that of the datum of its opening bracket.
    """

    def start(self, *forms: Any) -> tuple[Any, ...]:
        return forms

    def constant(self, atom: Atom) -> Constant:
        return Constant(atom.value, atom.span)

    def quotation(self, opener: Datum, _quote: Any, atom: Atom, _close: Any) -> Constant:
        return Constant(atom.value.value, opener.span)

    def handle(self, atom: Atom) -> HandleLiteral:
        return HandleLiteral(str(atom.value), atom.span)

    def reference(self, atom: Atom) -> Reference:
        return Reference(atom.value, atom.span)

    def target(self, atom: Atom) -> Any:
        value = atom.value
        return value.value if type(value) is Opaque else value

    def assignment(self, opener: Datum, _set: Any, name: Atom, value: Any, _close: Any) -> Assignment:
        return Assignment(name.value, value, opener.span)

    def conditional(self, opener: Datum, _if: Any, test: Any, then: Any, *rest: Any) -> If:
        otherwise = rest[0] if len(rest) == 2 else None
        return If(test, then, otherwise, opener.span)

    def conjunction(self, opener: Datum, _and: Any, *items: Any) -> And:
        return And(items[:-1], opener.span)

    def disjunction(self, opener: Datum, _or: Any, *items: Any) -> Or:
        return Or(items[:-1], opener.span)

    def defaults(self, _open: Any, *items: Any) -> tuple[Any, ...]:
        return items[:-1]

    def function(self, opener: Datum, _lambda: Any, parameters: Atom, defaults: Any, body: Any, _close: Any) -> Lambda:
        # The expander leaves a placeholder in each parameter that has a default, because parameters are opaque to the
        # grammar; the expressions follow in ``defaults``, in the same order.
        name, plain, usage = parameters.value.value
        pending = iter(defaults)
        filled = tuple(
            Parameter(p.target, p.name, p.kind, p.type, next(pending)) if p.default is not None else p for p in plain
        )
        return Lambda(name, filled, usage, body, opener.span)

    def definition(self, opener: Datum, _define: Any, target: Any, value: Any, _close: Any) -> Define:
        return Define(target, value, opener.span)

    def body(self, opener: Datum, _body: Any, *items: Any) -> Any:
        if len(items) == 2 and not isinstance(items[0], Define):  # one expression and the bracket
            return items[0]
        return Body(items[:-1], opener.span)

    def first(self, opener: Datum, _first: Any, *items: Any) -> First:
        return First(items[:-1], opener.span)

    def application(self, opener: Datum, function: Any, *rest: Any) -> Application:
        return Application(function, rest[:-1], opener.span)

    def array(self, opener: Datum, *items: Any) -> ArrayLiteral:
        return ArrayLiteral(items[:-1], opener.span)

    def while_loop(self, opener: Datum, _while: Any, test: Any, body: Any, _close: Any) -> While:
        return While(test, body, opener.span)

    def accumulators(self, _open: Any, *items: Any) -> tuple[Any, ...]:
        return items[:-1]

    def clauses(self, _open: Any, *items: Any) -> tuple[Any, ...]:
        return items[:-1]

    def each_clause(self, _open: Any, _clause: Any, *rest: Any) -> Clause:
        pairs = rest[:-1]
        return Clause("each", tuple(pairs[::2]), tuple(pairs[1::2]))

    def condition_clause(self, _left: Any, clause: Atom, test: Any, _close: Any) -> Clause:
        return Clause(clause.value.value, (), (test,))

    def for_loop(
        self, opener: Datum, _for: Any, kind: Atom, accumulators: Any, clauses: Any, body: Any, _close: Any
    ) -> For:
        return For(kind.value.value, accumulators, clauses, body, opener.span)

    def let_escape(self, opener: Datum, _head: Any, name: Atom, body: Any, _close: Any) -> LetEscape:
        return LetEscape(name.value, str(name.value), body, opener.span)

    def guard(self, opener: Datum, _head: Any, name: Atom, body: Any, handler: Any, _close: Any) -> Guard:
        return Guard(name.value, body, handler, opener.span)

    def bind_expr(self, opener: Datum, head: Atom, word: Any, function: Any, _close: Any) -> Bind:
        return Bind(word, function, opener.span)

    def union(self, opener: Datum, _union: Any, *members: Any) -> Union:
        return Union(members[:-1], opener.span)

    def union_loop(self, opener: Datum, _head: Any, count: Any, function: Any, _close: Any) -> UnionLoop:
        return UnionLoop(count, function, opener.span)

    def entity_transform(self, opener: Datum, _head: Any, part: Any, matrix: Any, _close: Any) -> Transform:
        return Transform(part, matrix, opener.span)

    def entity(self, opener: Datum, _call: Any, word: Any, *rest: Any) -> Call:
        return Call(word, rest[:-1], opener.span)


@cache
def _core() -> tuple[Tables, Builders]:
    """Load the tables of ``core.lark`` with the functions that build its nodes."""
    from scenelang.grammar.tables import core_tables

    tables = tables_of(core_tables)
    return tables, tables.builders(_Builder())


@dataclass(eq=False)
class FormError(SceneError):
    """Error in the structure of a core form; ``form`` is its datum."""

    form: Datum | None = None


def parse_core(datums: Sequence[Datum]) -> tuple[Any, ...]:
    """Parse expanded top-level forms into the core AST.

    Parameters
    ----------
    datums
        Output of the expander: forms whose heads are ``Head`` and whose names are resolved.

    Returns
    -------
    tuple
        One node for each form.

    Raises
    ------
    SceneError
        At the first datum that does not fit its form.
    """
    tables, build = _core()
    stack: _Stack = []
    forms: tuple[Any, ...] | Misfit = tables.parse(_tokens(datums, _terminal, stack), build)
    if isinstance(forms, Misfit):
        raise _misfit(forms, stack)
    return forms


def _misfit(misfit: Misfit, stack: _Stack) -> SceneError:
    """Return the error for a terminal that does not fit the innermost open form."""
    if misfit.terminal == END:
        return SceneError("syntax", "unexpected end of the program inside a form")
    form, datum = stack[-1][0], misfit.value
    span = form.span if form is not None else datum.span
    head = form.items[0] if isinstance(form, ListDatum) and form.items else None
    name = _spelling(head, span)
    if misfit.terminal in ("RPAR", "RSQB"):
        if name is None:
            hint = "write the empty list as `'()` or `(list)`"
            return FormError("empty-application", "`()` cannot be evaluated", hint, span, form=form)
        return FormError("syntax", f"incomplete `{name}` form", span=span, value=name, form=form)
    if name is None:
        return FormError("syntax", "malformed form", span=datum.span, form=form)
    return FormError("syntax", f"unexpected operand of `{name}`", span=datum.span, value=name, form=form)


def _spelling(head: Any, span: Span) -> str | None:
    """Return the head of a form as the user spelled it."""
    if not isinstance(head, Atom):
        return None
    text = head.span.text
    return text if text and " " not in text and "(" not in text else str(head.value).lower().replace("_", "-")


# --- the strict language -------------------------------------------------------------------------------------------

STRICT_HEADS = {
    "bind": "BIND", "lambda": "LAMBDA", "union": "UNION", "union-loop": "UNION_LOOP", "transform": "TRANSFORM",
    "call": "CALL", "list": "LIST", "if": "IF", "and": "AND", "or": "OR", "embedding": "EMBEDDING",
}  # fmt: skip
STRICT_OPERATORS = frozenset({
    "car", "cdr", "list-ref", "+", "-", "*", "/", "//", "%", "=", "<", ">", "<=", ">=", "not", "abs", "min",
    "max", "floor", "ceiling", "round", "truncate", "sqrt", "expt", "exp", "log", "sin", "cos", "tan", "asin",
    "acos", "atan", "hypot", "deg", "to-degrees", "quotient", "remainder", "modulo", "translate", "rotate",
    "scale", "reflect", "@", "vector", "norm", "normalize", "dot", "cross",
})  # fmt: skip
STRICT_MEASURES = frozenset(f"compute-shape-{measure}" for measure in ("center", "min", "max", "sizes"))
_RULE_OF_HEAD = {
    "bind": "<bind-expr>", "lambda": "<entity-func>", "union": "<sub-entities>", "union-loop": "<sub-entities>",
    "transform": "<entity-transform>", "call": "<entity>", "list": "<create-entity-list>",
}  # fmt: skip
_RULE_OF_TERMINALS = {
    frozenset({"BIND"}): "<bind-expr>", frozenset({"LAMBDA"}): "<entity-func>", frozenset({"CALL"}): "<entity>",
    frozenset({"UNION", "UNION_LOOP"}): "<sub-entities>", frozenset({"TRANSFORM"}): "<entity-transform>",
    frozenset({"LIST"}): "<create-entity-list>", frozenset({"STRING"}): "<word>",
    frozenset({"PARAMETER"}): "<entity-func>", frozenset({"PARAMETER", "RPAR"}): "<entity-func>",
}  # fmt: skip


def _strict_terminal(value: Any) -> str:
    """Return the terminal of ``strict.lark`` of an atom as read; names are classified by the three tables above."""
    kind = type(value)
    if kind is Symbol:
        name = str(value)
        if name in STRICT_HEADS:
            return STRICT_HEADS[name]
        if name in STRICT_OPERATORS:
            return "OPERATOR"
        return "MEASURE" if name in STRICT_MEASURES else "PARAMETER"
    if kind is int or kind is float:
        return "NUMBER"
    terminals: dict[type, str] = {str: "STRING", bool: "BOOLEAN", Handle: "HANDLE", Keyword: "KEYWORD"}
    return terminals.get(kind, "NONE")


@cache
def _strict_tables() -> Tables:
    from scenelang.grammar.tables import strict_tables

    return tables_of(strict_tables)


def check_strict(datums: Sequence[Datum]) -> None:
    """Check that ``datums`` are a program of the paper's grammar; raise ``SceneError`` naming the rule that fails."""
    tables = _strict_tables()
    stack: _Stack = []
    misfit = tables.parse(_tokens(datums, _strict_terminal, stack), [lambda *_: None] * len(tables.rules))
    if isinstance(misfit, Misfit):
        raise _strict_misfit(misfit, stack)


def _strict_misfit(misfit: Misfit, stack: _Stack) -> SceneError:
    """Return the error of ``--strict``, which names the rule of the paper's grammar that fails."""
    expected = misfit.expected
    hint = "expected " + " or ".join(sorted(_READABLE.get(name, f"`{_spelled(name)}`") for name in expected))
    if misfit.terminal == END:
        return SceneError("strict", "not in the paper's grammar: <START> must be one or more <bind-expr>", hint)
    form = stack[-1][0]
    head = form.items[0] if isinstance(form, ListDatum) and form.items else None
    by_head = _RULE_OF_HEAD.get(head.value, "<value>") if isinstance(head, Atom) else "<START>"
    rule = _RULE_OF_TERMINALS.get(expected, by_head)
    closing = misfit.terminal in ("RPAR", "RSQB")
    problem = "incomplete form" if closing else f"unexpected `{_clip(misfit.value.span.text)}`"
    return SceneError("strict", f"not in the paper's grammar: {problem} in {rule}", hint, misfit.value.span)


_READABLE = {
    "LPAR": "`(`", "RPAR": "`)`", "LSQB": "`[`", "RSQB": "`]`", "STRING": "a string", "NUMBER": "a number",
    "BOOLEAN": "a boolean", "NONE": "`none`", "HANDLE": "a handle", "PARAMETER": "a parameter", "$END": "the end",
    "OPERATOR": "an arithmetic or matrix function", "MEASURE": "`compute-shape-*`", "KEYWORD": "a keyword",
}  # fmt: skip


def _spelled(terminal: str) -> str:
    return terminal.lower().replace("_", "-")


_MAX_CLIP_CHARACTERS = 40  # of quoted source text: enough for a name or a short form, and the message stays one line


def _clip(text: str) -> str:
    """Shorten quoted source text to the beginning of its first line."""
    line = text.split("\n", 1)[0]
    if line == text and len(line) <= _MAX_CLIP_CHARACTERS:
        return line
    return line[: _MAX_CLIP_CHARACTERS - 3] + "..."
