"""The core AST: what every program is after expansion (see ``core.lark``).

Identifiers and builtins are opaque here: ``Reference.target`` is whatever the expander resolved a name to.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

from lark import Lark, Transformer, v_args
from lark.exceptions import UnexpectedToken
from lark.lexer import Lexer

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Handle, Keyword, ListDatum, Span, Symbol
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.reader import build_parser


@dataclass(frozen=True, slots=True, eq=False)
class Constant:
    value: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class HandleLiteral:
    """``<z1>``: an embedding, with what Z says of it."""

    name: str
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    target: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Assignment:
    target: Any
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class If:
    test: Expr
    then: Expr
    otherwise: Expr | None
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class And:
    items: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Or:
    items: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Parameter:
    """``kind``: required, optional, keyword, rest or keys. ``name`` is the spelling, for keywords and messages."""

    target: Any
    name: str
    kind: str
    type: Any = None
    default: Expr | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Lambda:
    name: str
    parameters: tuple[Parameter, ...]
    usage: str
    body: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Define:
    """A local definition inside ``Body``, or one at top level. ``target`` may be a pattern."""

    target: Any
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Definitions and expressions in order; the value is that of the last one."""

    items: tuple[Define | Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class First:
    """``begin0``: the value of the first item, after the others have run."""

    items: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Application:
    function: Expr
    arguments: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class ArrayLiteral:
    items: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class While:
    test: Expr
    body: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Clause:
    """One step of a ``for`` form. ``kind``: each (parallel bindings), when, unless or break (one test)."""

    kind: str
    targets: tuple[Any, ...]
    values: tuple[Expr, ...]


@dataclass(frozen=True, slots=True, eq=False)
class For:
    """``kind`` is each, list, union, append, sum, and, or, first, fold, table or set."""

    kind: str
    accumulators: tuple[Define, ...]
    clauses: tuple[Clause, ...]
    body: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class LetEscape:
    target: Any
    name: str
    body: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Guard:
    """Run ``body``; on an error bind it to ``target`` and run ``handler``."""

    target: Any
    body: Expr
    handler: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Bind:
    """``<bind-expr>``. ``top_level``: a literal word bound at the top level of its file."""

    word: Expr
    function: Expr
    span: Span
    top_level: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Call:
    """``<entity>``: ``(call word argument ...)``."""

    word: Expr
    arguments: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Union:
    members: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class UnionLoop:
    count: Expr
    function: Expr
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """``<entity-transform>``."""

    part: Expr
    matrix: Expr
    span: Span


Expr: TypeAlias = (
    Constant | HandleLiteral | Reference | Assignment | If | And | Or | Lambda | Body | First | Application
    | ArrayLiteral | While | For | LetEscape | Guard | Bind | Call | Union | UnionLoop | Transform
)  # fmt: skip


# Datums -> core AST by ``core.lark``. What macros produce is checked by the same grammar; errors carry their place.


class Head(str):
    """The head of a core form in the expander's output; the text is the terminal's name."""

    __slots__ = ()


class Opaque:
    """A datum that is one token for the grammar: the expander made it, the AST builder unpacks it."""

    __slots__ = ("terminal", "value")

    def __init__(self, terminal: str, value: Any) -> None:
        self.terminal = terminal
        self.value = value


class CoreToken:
    """A token over a datum: ``type`` is the terminal, ``form`` the list that the datum stands in."""

    __slots__ = ("datum", "form", "type")
    start_pos = line = column = end_line = end_column = end_pos = 0  # Lark copies these to its end token

    def __init__(self, kind: str, datum: Any, form: Datum | None) -> None:
        self.type = kind
        self.datum = datum
        self.form = form


def _atom_terminal(value: Any) -> str:
    kind = type(value)
    if kind is Head:
        return str(value)
    if kind is Opaque:
        return str(value.terminal)
    if kind is Handle:
        return "HANDLE"
    if kind in (int, float, str, bool, type(None), Keyword):
        return "CONSTANT"
    return "IDENTIFIER"


def _tokens(datums: Sequence[Datum], terminal: Any) -> Iterator[CoreToken]:
    """Depth first, without recursion; closing brackets are tokens too."""
    stack: list[Any] = [(datum, None) for datum in reversed(datums)]
    while stack:
        item = stack.pop()
        if type(item) is CoreToken:
            yield item
            continue
        datum, form = item
        if isinstance(datum, Atom):
            yield CoreToken(terminal(datum.value), datum, form)
            continue
        square = isinstance(datum, ArrayDatum)
        yield CoreToken("LSQB" if square else "LPAR", datum, form)
        stack.append(CoreToken("RSQB" if square else "RPAR", datum, datum))
        stack.extend((part, datum) for part in reversed(datum.items))


class _CoreLexer(Lexer):
    def __init__(self, conf: Any) -> None:
        pass

    def lex(self, lexer_state: Any, parser_state: Any = None) -> Iterator[Any]:
        yield from lexer_state


@v_args(inline=True)
class _Builder(Transformer[Any, Any]):
    """Builds the AST bottom up. Every form's span is that of its opening bracket's datum."""

    def start(self, *forms: Any) -> tuple[Any, ...]:
        return forms

    def constant(self, token: CoreToken) -> Constant:
        return Constant(token.datum.value, token.datum.span)

    def quotation(self, opener: CoreToken, _quote: Any, token: CoreToken, _close: Any) -> Constant:
        return Constant(token.datum.value.value, opener.datum.span)

    def handle(self, token: CoreToken) -> HandleLiteral:
        return HandleLiteral(str(token.datum.value), token.datum.span)

    def reference(self, token: CoreToken) -> Reference:
        return Reference(token.datum.value, token.datum.span)

    def target(self, token: CoreToken) -> Any:
        value = token.datum.value
        return value.value if type(value) is Opaque else value

    def assignment(self, opener: CoreToken, _set: Any, name: CoreToken, value: Any, _close: Any) -> Assignment:
        return Assignment(name.datum.value, value, opener.datum.span)

    def conditional(self, opener: CoreToken, _if: Any, test: Any, then: Any, *rest: Any) -> If:
        otherwise = rest[0] if len(rest) == 2 else None
        return If(test, then, otherwise, opener.datum.span)

    def conjunction(self, opener: CoreToken, _and: Any, *items: Any) -> And:
        return And(items[:-1], opener.datum.span)

    def disjunction(self, opener: CoreToken, _or: Any, *items: Any) -> Or:
        return Or(items[:-1], opener.datum.span)

    def defaults(self, _open: Any, *items: Any) -> tuple[Any, ...]:
        return items[:-1]

    def function(
        self, opener: CoreToken, _lambda: Any, parameters: CoreToken, defaults: Any, body: Any, _close: Any
    ) -> Lambda:
        name, plain, usage = parameters.datum.value.value
        pending = iter(defaults)
        filled = tuple(
            Parameter(p.target, p.name, p.kind, p.type, next(pending)) if p.default is not None else p for p in plain
        )
        return Lambda(name, filled, usage, body, opener.datum.span)

    def definition(self, opener: CoreToken, _define: Any, target: Any, value: Any, _close: Any) -> Define:
        return Define(target, value, opener.datum.span)

    def body(self, opener: CoreToken, _body: Any, *items: Any) -> Any:
        if len(items) == 2 and not isinstance(items[0], Define):
            return items[0]
        return Body(items[:-1], opener.datum.span)

    def first(self, opener: CoreToken, _first: Any, *items: Any) -> First:
        return First(items[:-1], opener.datum.span)

    def application(self, opener: CoreToken, function: Any, *rest: Any) -> Application:
        return Application(function, rest[:-1], opener.datum.span)

    def array(self, opener: CoreToken, *items: Any) -> ArrayLiteral:
        return ArrayLiteral(items[:-1], opener.datum.span)

    def while_loop(self, opener: CoreToken, _while: Any, test: Any, body: Any, _close: Any) -> While:
        return While(test, body, opener.datum.span)

    def accumulators(self, _open: Any, *items: Any) -> tuple[Any, ...]:
        return items[:-1]

    def clauses(self, _open: Any, *items: Any) -> tuple[Any, ...]:
        return items[:-1]

    def each_clause(self, _open: Any, _clause: Any, *rest: Any) -> Clause:
        pairs = rest[:-1]
        return Clause("each", tuple(pairs[::2]), tuple(pairs[1::2]))

    def condition_clause(self, _left: Any, clause: CoreToken, test: Any, _close: Any) -> Clause:
        return Clause(clause.datum.value.value, (), (test,))

    def for_loop(
        self, opener: CoreToken, _for: Any, kind: CoreToken, accumulators: Any, clauses: Any, body: Any, _close: Any
    ) -> For:
        return For(kind.datum.value.value, accumulators, clauses, body, opener.datum.span)

    def let_escape(self, opener: CoreToken, _head: Any, name: CoreToken, body: Any, _close: Any) -> LetEscape:
        return LetEscape(name.datum.value, str(name.datum.value), body, opener.datum.span)

    def guard(self, opener: CoreToken, _head: Any, name: CoreToken, body: Any, handler: Any, _close: Any) -> Guard:
        return Guard(name.datum.value, body, handler, opener.datum.span)

    def bind_expr(self, opener: CoreToken, head: CoreToken, word: Any, function: Any, _close: Any) -> Bind:
        return Bind(word, function, opener.datum.span)

    def union(self, opener: CoreToken, _union: Any, *members: Any) -> Union:
        return Union(members[:-1], opener.datum.span)

    def union_loop(self, opener: CoreToken, _head: Any, count: Any, function: Any, _close: Any) -> UnionLoop:
        return UnionLoop(count, function, opener.datum.span)

    def entity_transform(self, opener: CoreToken, _head: Any, part: Any, matrix: Any, _close: Any) -> Transform:
        return Transform(part, matrix, opener.datum.span)

    def entity(self, opener: CoreToken, _call: Any, word: Any, *rest: Any) -> Call:
        return Call(word, rest[:-1], opener.datum.span)


@cache
def _core_parser() -> Lark:
    return build_parser("core.lark", "start", _CoreLexer, _Builder())


def prepare() -> None:
    """Load the parser's tables now, for a thread that will not be able to save them."""
    _core_parser()


def parse_core(datums: Sequence[Datum]) -> tuple[Any, ...]:
    """The core AST of expanded top-level forms. Raises SceneError at the datum that does not fit its form."""
    try:
        forms: tuple[Any, ...] = _core_parser().parse(_tokens(datums, _atom_terminal))  # type: ignore[assignment]
        return forms
    except UnexpectedToken as unexpected:
        raise _misfit(unexpected) from None


def _misfit(unexpected: UnexpectedToken) -> SceneError:
    token: Any = unexpected.token
    if not isinstance(token, CoreToken):
        return SceneError("syntax", "the program ends in the middle of a form")
    form, datum = token.form, token.datum
    span = form.span if form is not None else datum.span
    head = form.items[0] if isinstance(form, ListDatum) and form.items else None
    name = _spelling(head, span)
    if token.type in ("RPAR", "RSQB"):
        if name is None:
            return SceneError(
                "empty-application", "`()` cannot be evaluated", "the empty list is `'()` or `(list)`", span
            )
        return SceneError("syntax", f"`{name}` ends too early", span=span, value=name)
    if name is None:
        return SceneError("syntax", "this form is malformed", span=datum.span)
    return SceneError("syntax", f"`{name}` has no place for this", span=datum.span, value=name)


def _spelling(head: Any, span: Span) -> str | None:
    """How the user wrote the head of a form."""
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
    "acos", "atan", "hypot", "degrees", "radians", "quotient", "remainder", "modulo", "translate", "rotate",
    "scale", "reflect", "@", "vector", "norm", "normalize", "dot", "cross",
})  # fmt: skip
STRICT_MEASURES = frozenset(f"compute-shape-{what}" for what in ("center", "min", "max", "sizes"))
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
def _strict_parser() -> Lark:
    return build_parser("core.lark", "strict_start", _CoreLexer)


def check_strict(datums: Sequence[Datum]) -> None:
    """Raise SceneError, naming the rule that fails, unless ``datums`` are a program of the paper's grammar."""
    try:
        _strict_parser().parse(_tokens(datums, _strict_terminal))
    except UnexpectedToken as unexpected:
        raise _strict_misfit(unexpected) from None


def _strict_misfit(unexpected: UnexpectedToken) -> SceneError:
    token: Any = unexpected.token
    expected = frozenset(unexpected.expected)
    wanted = "expected " + " or ".join(sorted(_READABLE.get(name, f"`{_spelled(name)}`") for name in expected))
    if not isinstance(token, CoreToken):
        return SceneError("strict", "not in the paper's grammar: <START> is one or more <bind-expr>", wanted)
    head = token.form.items[0] if isinstance(token.form, ListDatum) and token.form.items else None
    by_head = _RULE_OF_HEAD.get(head.value, "<value>") if isinstance(head, Atom) else "<START>"
    rule = _RULE_OF_TERMINALS.get(expected, by_head)
    closing = token.type in ("RPAR", "RSQB")
    what = "the form ends too early" if closing else f"`{_clip(token.datum.span.text)}` does not fit"
    return SceneError("strict", f"not in the paper's grammar: {what} in {rule}", wanted, token.datum.span)


_READABLE = {
    "LPAR": "`(`", "RPAR": "`)`", "LSQB": "`[`", "RSQB": "`]`", "STRING": "a string", "NUMBER": "a number",
    "BOOLEAN": "a boolean", "NONE": "`none`", "HANDLE": "a handle", "PARAMETER": "a parameter", "$END": "the end",
    "OPERATOR": "an arithmetic or matrix function", "MEASURE": "`compute-shape-*`", "KEYWORD": "a keyword",
}  # fmt: skip


def _spelled(terminal: str) -> str:
    return terminal.lower().replace("_", "-")


def _clip(text: str) -> str:
    line = text.split("\n", 1)[0]
    return line if len(line) <= 40 and line == text else line[:37] + "..."
