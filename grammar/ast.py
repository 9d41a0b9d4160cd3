"""The core AST: what every program is after expansion (see ``core.lark``).

Identifiers and builtins are opaque here: ``Reference.target`` is whatever the expander resolved a name to.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

from scenelang.grammar.source import Span


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
