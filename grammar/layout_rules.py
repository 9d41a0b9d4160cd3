"""What the layout of programs knows of heads: which operands stand on the head's line, which parts are bodies,
bindings, clauses or data, and which forms always take several lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum, auto
from typing import NamedTuple

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Symbol


class Role(Enum):
    """What a datum is for the form around it."""

    TOP = auto()
    BODY = auto()  # a form of a body
    CODE = auto()
    FUNCTION = auto()  # the function that `bind` binds
    DATA = auto()
    BINDINGS = auto()
    BINDING = auto()
    CLAUSE = auto()
    PARAMETERS = auto()
    SIGNATURE = auto()


class Kind(Enum):
    """How a datum is laid out where it does not fit one line."""

    ORDINARY = auto()
    SPECIAL = auto()  # some operands on the head's line, the others indented by two
    IF = auto()
    BODIED = auto()  # SPECIAL, the others being a body
    DEFINE = auto()
    LAMBDA = auto()
    LET = auto()
    FOR = auto()
    DO = auto()
    GUARD = auto()
    BIND = auto()
    CLAUSES = auto()  # SPECIAL, the others being clauses
    CALL = auto()  # keyword pairs fill the lines
    TRANSFORM = auto()
    ALIGNED = auto()  # operands under the first operand
    TABLE = auto()
    QUOTE = auto()
    QUASIQUOTE = auto()
    GROUP = auto()  # a list in code whose head is no symbol
    ARRAY = auto()
    DATA = auto()
    BINDINGS = auto()
    BINDING = auto()
    CLAUSE = auto()
    PARAMETERS = auto()
    SIGNATURE = auto()


class Shape(NamedTuple):
    """How to lay a datum out; ``kept``: operands on the head's line."""

    kind: Kind
    kept: int = 0


WITH_BODY = frozenset((Kind.BODIED, Kind.DEFINE, Kind.LAMBDA, Kind.LET, Kind.FOR, Kind.DO, Kind.GUARD))
# a value of these kinds is too much to share a line with other keyword pairs
WEIGHTY = WITH_BODY | {Kind.CALL, Kind.TRANSFORM, Kind.CLAUSES}
# of the styles of these kinds the one with the fewest lines is taken, not the first one that fits
SHORTEST = frozenset((Kind.TRANSFORM,))
# heads whose operands are equals: none of them stays behind on the head's line
EVEN_HEADS = frozenset(("union", "append", "union*", "frames"))

_BY_ROLE = {
    Role.DATA: Shape(Kind.DATA),
    Role.BINDINGS: Shape(Kind.BINDINGS),
    Role.BINDING: Shape(Kind.BINDING),
    Role.CLAUSE: Shape(Kind.CLAUSE),
    Role.PARAMETERS: Shape(Kind.PARAMETERS),
    Role.SIGNATURE: Shape(Kind.SIGNATURE),
}
_ORDINARY, _GROUP, _ARRAY, _DATA = Shape(Kind.ORDINARY), Shape(Kind.GROUP), Shape(Kind.ARRAY), Shape(Kind.DATA)

_ALIGNED_HEADS = (
    *("+", "-", "*", "/", "//", "%", "**", "expt", "abs", "min", "max", "sqrt", "square", "hypot", "exp", "log"),
    *("sin", "cos", "tan", "asin", "acos", "atan", "radians", "degrees", "floor", "ceiling", "round"),
    *("=", "!=", "<", ">", "<=", ">=", "and", "or", "not", "list", "cons", "set", "ref", "@"),
)
_ALWAYS = {
    **dict.fromkeys(_ALIGNED_HEADS, Kind.ALIGNED),
    **dict.fromkeys(("call", "primitive", "scene", "param", "define-record"), Kind.CALL),
    **dict.fromkeys(("unquote", "unquote-splicing"), Kind.ORDINARY),
    "transform": Kind.TRANSFORM,
    "table": Kind.TABLE,
    "quote": Kind.QUOTE,
    "quasiquote": Kind.QUASIQUOTE,
}
_WHERE_INDENTED = {
    "if": Kind.IF,
    "lambda": Kind.LAMBDA,
    "define": Kind.DEFINE,
    "define-macro": Kind.DEFINE,
    "do": Kind.DO,
    "guard": Kind.GUARD,
    "bind": Kind.BIND,
    **dict.fromkeys(("let", "let*", "letrec", "letrec*", "let-values", "let*-values"), Kind.LET),
    **dict.fromkeys(("let-syntax", "letrec-syntax"), Kind.LET),
    **dict.fromkeys(("begin", "begin0", "when", "unless", "while", "let/ec"), Kind.BODIED),
    **dict.fromkeys(("cond", "case", "syntax-rules"), Kind.CLAUSES),
}


def shapes_by_head(indents: Mapping[str, int | None]) -> dict[str, Shape]:
    """The shape of every head that is more than an ordinary function."""
    shapes = {}
    for name, indent in indents.items():
        kind = Kind.FOR if name.startswith(("for/", "for*")) or name == "for" else Kind.SPECIAL
        kind = Kind.ALIGNED if indent is None else _WHERE_INDENTED.get(name, kind)
        shapes[name] = Shape(kind, indent or 0)
    for name, kind in _ALWAYS.items():
        shapes[name] = Shape(kind, 1)
    return shapes


def head_of(datum: Datum) -> str | None:
    """The symbol that a list begins with."""
    if isinstance(datum, ListDatum) and datum.items:
        head = datum.items[0]
        if isinstance(head, Atom) and type(head.value) is Symbol:
            return head.value
    return None


def is_keyword(datum: Datum) -> bool:
    return isinstance(datum, Atom) and type(datum.value) is Keyword


def is_ellipsis(datum: Datum) -> bool:
    """Whether ``datum`` is the `...` of a macro's pattern or template."""
    return isinstance(datum, Atom) and type(datum.value) is Symbol and datum.value == "..."


def shape_of(datum: ListDatum | ArrayDatum, role: Role, shapes: Mapping[str, Shape]) -> Shape:
    """The shape of a compound datum in its role."""
    if isinstance(datum, ArrayDatum):
        return _DATA if role is Role.DATA else _ARRAY
    fixed = _BY_ROLE.get(role)
    if fixed is not None:
        return fixed
    head = head_of(datum)
    if head is None:
        return _GROUP
    shape = shapes.get(head, _ORDINARY)
    if shape.kind is Kind.LET and len(datum.items) > 2 and isinstance(datum.items[1], Atom):
        return Shape(Kind.LET, 2)  # a named `let`
    return shape


def roles_of_parts(datum: ListDatum | ArrayDatum, shape: Shape, parts: Sequence[Datum]) -> list[Role]:
    """The role of every part of ``datum``, its tail included."""
    kind, kept = shape
    count = len(parts)
    if kind is Kind.DATA:
        unquoting = head_of(datum) in ("unquote", "unquote-splicing") and count == 2
        return [Role.CODE if unquoting else Role.DATA] * count
    if kind is Kind.BINDINGS or kind is Kind.PARAMETERS or kind is Kind.SIGNATURE:
        tested = kind is Kind.BINDINGS  # `:when test` among the clauses of a loop
        return [
            Role.CODE if tested and place and is_keyword(parts[place - 1]) else Role.BINDING for place in range(count)
        ]
    if kind is Kind.BINDING:
        return [Role.DATA] + [Role.CODE] * (count - 1)
    if kind is Kind.CLAUSE:
        return [Role.CODE] + [Role.BODY] * (count - 1)
    if kind is Kind.QUOTE:
        return [Role.DATA] * count
    if kind is Kind.QUASIQUOTE:  # a template of code, or of data
        return [Role.DATA if head_of(part) is None else Role.CODE for part in parts]
    roles = [Role.CODE] * count
    if kind in WITH_BODY:
        roles[1 + kept :] = [Role.BODY] * (count - 1 - kept)
    elif kind is Kind.CLAUSES:
        roles[1 + kept :] = [Role.CLAUSE] * (count - 1 - kept)
    _set_head_roles(kind, kept, parts, roles)
    return roles


def _set_head_roles(kind: Kind, kept: int, parts: Sequence[Datum], roles: list[Role]) -> None:
    """The roles of the operands that stand on the head's line."""
    if len(parts) < 2:
        return
    if kind is Kind.LAMBDA:
        roles[1] = Role.PARAMETERS
    elif kind is Kind.DEFINE and isinstance(parts[1], ListDatum):
        roles[1] = Role.SIGNATURE
    elif kind is Kind.LET:
        roles[min(kept, len(parts) - 1)] = Role.BINDINGS
    elif kind is Kind.FOR:
        kept = min(kept, len(parts) - 1)
        roles[1 : 1 + kept] = [Role.BINDINGS] * kept
    elif kind is Kind.DO:
        roles[1:3] = [Role.BINDINGS, Role.CLAUSE][: len(parts) - 1]
    elif kind is Kind.GUARD:
        roles[1] = Role.CLAUSE
    elif kind is Kind.BIND:
        roles[-1] = Role.FUNCTION


def takes_lines(datum: ListDatum | ArrayDatum, shape: Shape, role: Role) -> bool:
    """Whether ``datum`` takes several lines even where one would do: functions of a file, Scheme's loops, bodies and
    clauses of several forms."""
    kind = shape.kind
    items = datum.items
    count = sum(not is_ellipsis(item) for item in items)
    if kind in WITH_BODY:
        if role is Role.FUNCTION:
            return True
        if kind is Kind.DEFINE:
            if len(items) < 3 or not isinstance(items[1], ListDatum):
                return False
            if role is Role.TOP:
                return True
        if kind is Kind.DO or (kind is Kind.LET and shape.kept == 2):
            return True
        return count > 2 + shape.kept
    if kind is Kind.CLAUSES:
        return count > 2 + shape.kept
    if kind is Kind.CLAUSE:
        return count > 2 and not (isinstance(items[1], Atom) and items[1].value == "=>")
    if kind is Kind.IF and (role is Role.BODY or role is Role.TOP):
        return len(items) == 4 and isinstance(items[2], ListDatum) and isinstance(items[3], ListDatum)
    return False


def parts_of(datum: ListDatum | ArrayDatum) -> Sequence[Datum]:
    """The items of a datum, and its tail."""
    if isinstance(datum, ListDatum) and datum.tail is not None:
        return (*datum.items, datum.tail)
    return datum.items


# --- line breaks of an author ----------------------------------------------------------------------------------------

_PASSING = frozenset(("set!", "define-values"))  # a value that fits on the head's line stands there
_BY_HEAD_LINE = WITH_BODY | {Kind.BIND, Kind.CLAUSES, Kind.IF, Kind.SPECIAL}


def stays_broken(datum: ListDatum | ArrayDatum, shape: Shape, parts: Sequence[Datum], breaks: Sequence[bool]) -> bool:
    """Whether line breaks that an author made are kept although one line has room: a body that begins on a line of its
    own, a function as the last operand, members of a union, a pose under its shape, bindings under each other.
    ``breaks`` tells which parts begin a line."""
    kind, kept = shape
    if kind in _BY_HEAD_LINE:
        if kind is Kind.DEFINE and len(parts) > 1 and isinstance(parts[1], Atom):
            return False
        return any(breaks[1 + kept : 2 + kept]) and head_of(datum) not in _PASSING
    if kind is Kind.CLAUSE:
        return any(breaks[1:2]) and not (isinstance(parts[1], Atom) and parts[1].value == "=>")
    if kind is Kind.ORDINARY and len(parts) > 2 and head_of(parts[-1]) == "lambda" and breaks[-1]:
        return True
    if kind is Kind.BINDINGS or kind is Kind.TRANSFORM or head_of(datum) in EVEN_HEADS:
        return any(breaks[1:])
    if kind is Kind.ALIGNED:
        compound = not any(isinstance(part, Atom) for part in parts[1:])
        return compound and len(parts) > 2 and all(breaks[2:])
    return kind is Kind.TABLE and any(breaks[1:2])


def has_rows(datum: ListDatum | ArrayDatum, shape: Shape, parts: Sequence[Datum], breaks: Sequence[bool]) -> bool:
    """Whether the author gave every row of a table of data, or every keyword pair of a call, a line of its own."""
    if shape.kind is Kind.DATA or shape.kind is Kind.ARRAY:
        return len(parts) > 1 and all(breaks[1:]) and not any(isinstance(part, Atom) for part in parts)
    if shape.kind is Kind.CALL or shape.kind is Kind.ORDINARY:
        keys = [place for place, part in enumerate(parts) if place and is_keyword(part)]
        return len(keys) > 1 and all(breaks[place] for place in keys)
    return False
