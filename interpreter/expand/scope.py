"""Names at expansion time: what an identifier is bound to where it stands.

Hygiene is by aliases. A macro's template gives each of its symbols a fresh ``Alias`` per expansion; an alias that
nothing binds on the way means what its symbol means where the macro was defined.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

from scenelang.grammar.datum import Keyword, Span, Symbol


class Alias(Symbol):
    """A symbol that came from a macro's template; compares by identity.

    ``scope`` is where the macro was defined. ``soft`` (``define-macro``): binding it also binds the plain name, and
    where the definition's scope does not know it, it means what the plain name means at the use.
    """

    __slots__ = ("base", "scope", "soft")
    base: Symbol
    scope: Scope
    soft: bool

    __eq__ = object.__eq__
    __hash__ = object.__hash__


def make_alias(base: Symbol, scope: Scope, soft: bool) -> Alias:
    alias = Alias(base)
    alias.base, alias.scope, alias.soft = base, scope, soft
    return alias


class TemplateKeyword(Keyword):
    """A keyword that came from a macro's template: as a parameter it binds what the template's symbol means."""

    __slots__ = ("alias",)
    alias: Alias

    def __new__(cls, keyword: Keyword, alias: Alias) -> TemplateKeyword:
        made = super().__new__(cls, keyword)
        made.alias = alias
        return made


def base_name(symbol: Symbol) -> str:
    """The symbol as the user wrote it."""
    while isinstance(symbol, Alias):
        symbol = symbol.base
    return str(symbol)


@dataclass(frozen=True, slots=True, eq=False)
class Annotated:
    """An identifier with the paper's annotation, ``name::Type``."""

    name: Symbol
    type: str
    keyword: bool = False


class Variable:
    """A binding that holds a value at run time. The expander and the analysis fill in what the compiler needs."""

    __slots__ = ("assigned", "captured", "from_macro", "is_global", "name", "owner", "recursive", "shadows", "span")

    def __init__(self, name: str, span: Span | None, is_global: bool = False, recursive: bool = False) -> None:
        self.name = name
        self.span = span
        self.is_global = is_global
        self.recursive = recursive  # visible before its definition has run: define, letrec
        self.assigned = False
        self.captured = False  # used by a closure inside the function or loop body that binds it
        self.owner: Any = None
        self.from_macro = False
        self.shadows = False  # hides a function of the library

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class Special:
    """A special form, by its name in ``forms``."""

    name: str


@dataclass(frozen=True, slots=True)
class PaperForm:
    """One of the paper's four macros: a procedure of the prelude whose call sites have a core form."""

    terminal: str
    variable: Variable


@dataclass(frozen=True, slots=True, eq=False)
class ConstantBinding:
    """A name that stands for a value, such as ``pi``."""

    value: Any


@dataclass(frozen=True, slots=True, eq=False)
class Macro:
    """``transform(form, use scope)`` gives the datum that replaces the form."""

    name: str
    transform: Callable[[Any, Any], Any]
    span: Span | None
    usage: str = ""


Binding: TypeAlias = Any  # Variable | Special | PaperForm | ConstantBinding | Macro | Builtin


class Scope:
    """A region of the program. ``fallback`` answers for names that no region knows (builtins and forms)."""

    __slots__ = ("bindings", "fallback", "parent")

    def __init__(self, parent: Scope | None, fallback: Callable[[str], Binding | None] | None = None) -> None:
        self.parent = parent
        self.bindings: dict[Symbol, Binding] = {}
        self.fallback = fallback

    def bind(self, symbol: Symbol, binding: Binding) -> None:
        self.bindings[symbol] = binding
        if isinstance(symbol, Alias) and symbol.soft:
            self.bindings[Symbol(base_name(symbol))] = binding

    def lookup(self, symbol: Symbol) -> Binding | None:
        """What ``symbol`` means here, or None."""
        use: Scope = self
        scope: Scope = self
        while True:
            found = scope._find(symbol)
            if found is not None:
                return found
            if not isinstance(symbol, Alias):
                return None
            if symbol.soft:
                inner = symbol.scope.lookup(symbol.base)
                return inner if inner is not None else use.lookup(symbol.base)
            scope, symbol = symbol.scope, symbol.base

    def _find(self, symbol: Symbol) -> Binding | None:
        scope: Scope | None = self
        while scope is not None:
            found = scope.bindings.get(symbol)
            if found is not None:
                return found
            if scope.fallback is not None and not isinstance(symbol, Alias):
                found = scope.fallback(str(symbol))
                if found is not None:
                    return found
            scope = scope.parent
        return None

    def names(self) -> Iterator[str]:
        """Every name bound in this and the enclosing regions, for suggestions."""
        scope: Scope | None = self
        while scope is not None:
            for symbol in scope.bindings:
                yield base_name(symbol)
            scope = scope.parent
