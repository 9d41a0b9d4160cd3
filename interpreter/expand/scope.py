"""Scopes and bindings at expansion time: resolution of identifiers.

Hygiene is implemented with aliases (renaming, as in Clinger and Rees, "Macros That Work", 1991). Each expansion of a
macro's template renames its symbols to fresh ``Alias`` objects; an alias that is not bound by the expanded code refers
to the binding of its symbol where the macro was defined.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

from scenelang.grammar.datum import Keyword, Span, Symbol, dataclass


class Alias(Symbol):
    """Renamed symbol of a macro template; compares by identity.

    Attributes
    ----------
    base
        Original symbol.
    scope
        Scope of the macro's definition.
    soft
        Set for ``define-macro``: binding the alias also binds the plain name, and an alias that is unbound in the
        definition's scope is resolved as the plain name in the scope of the macro use.
    """

    __slots__ = ("base", "scope", "soft")
    base: Symbol
    scope: Scope
    soft: bool

    __eq__ = object.__eq__
    __hash__ = object.__hash__


def make_alias(base: Symbol, scope: Scope, soft: bool) -> Alias:
    """Return a new alias of a symbol in a template that was defined in ``scope``."""
    alias = Alias(base)
    alias.base, alias.scope, alias.soft = base, scope, soft
    return alias


class TemplateKeyword(Keyword):
    """Keyword of a macro template; as a keyword parameter, it binds the alias of the template's symbol."""

    __slots__ = ("alias",)
    alias: Alias

    def __new__(cls, keyword: Keyword, alias: Alias) -> TemplateKeyword:
        keyword_alias = super().__new__(cls, keyword)
        keyword_alias.alias = alias
        return keyword_alias


def base_name(symbol: Symbol) -> str:
    """Return the name of a symbol as the user wrote it.

    A symbol that a macro has inserted is an alias, or an alias of an alias, of the one in the template.
    """
    while isinstance(symbol, Alias):
        symbol = symbol.base
    return str(symbol)


@dataclass(frozen=True, slots=True, eq=False)
class Annotated:
    """Identifier with a type annotation in the paper's notation, ``name::Type``."""

    name: Symbol
    type: str
    keyword: bool = False


class Variable:
    """Variable, which has a value at run time. The expander and the analysis set the attributes for the compiler."""

    __slots__ = (
        "assigned",
        "captured",
        "from_macro",
        "hides",
        "is_global",
        "name",
        "owner",
        "recursive",
        "shadows",
        "span",
    )

    def __init__(self, name: str, span: Span | None, is_global: bool = False, recursive: bool = False) -> None:
        self.name = name
        self.span = span
        self.is_global = is_global
        self.recursive = recursive  # visible before its definition is evaluated: define, letrec
        self.assigned = False
        self.captured = False  # used by a closure within the function or loop body that binds it
        self.owner: Any = None
        self.from_macro = False
        self.shadows = False  # shadows a builtin function
        self.hides: Variable | None = None  # variable of an enclosing scope with the same name

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class Special:
    """Special form, by its name in ``forms``."""

    name: str


@dataclass(frozen=True, slots=True)
class PaperForm:
    """One of the paper's four macros: a procedure of the prelude whose direct calls become core forms.

    ``terminal`` is the head of the core form in ``core.lark``, ``variable`` the procedure.
    """

    terminal: str
    variable: Variable


@dataclass(frozen=True, slots=True, eq=False)
class ConstantBinding:
    """Named constant, such as ``pi``."""

    value: Any


@dataclass(frozen=True, slots=True, eq=False)
class Macro:
    """Macro.

    Attributes
    ----------
    name, span
        Name, and location of the definition.
    transform
        ``transform(form, use_scope)`` returns the datum that replaces a use of the macro.
    usage
        Parameter list in error messages.
    """

    name: str
    transform: Callable[[Any, Any], Any]
    span: Span | None
    usage: str = ""


Binding: TypeAlias = Any  # Variable | Special | PaperForm | ConstantBinding | Macro | Builtin


class Scope:
    """Lexical scope. ``fallback`` resolves predefined names (builtins and special forms) that no scope binds."""

    __slots__ = ("bindings", "fallback", "parent")

    def __init__(self, parent: Scope | None, fallback: Callable[[str], Binding | None] | None = None) -> None:
        self.parent = parent
        self.bindings: dict[Symbol, Binding] = {}
        self.fallback = fallback

    def bind(self, symbol: Symbol, binding: Binding) -> None:
        """Bind a symbol in this scope."""
        self.bindings[symbol] = binding
        if isinstance(symbol, Alias) and symbol.soft:
            self.bindings[Symbol(base_name(symbol))] = binding

    def lookup(self, symbol: Symbol) -> Binding | None:
        """Return the binding of ``symbol`` in this scope, or None if it is unbound."""
        use: Scope = self
        scope: Scope = self
        while True:
            binding = scope._find(symbol)
            if binding is not None:
                return binding
            if not isinstance(symbol, Alias):
                return None
            if symbol.soft:
                inner = symbol.scope.lookup(symbol.base)
                return inner if inner is not None else use.lookup(symbol.base)
            scope, symbol = symbol.scope, symbol.base

    def _find(self, symbol: Symbol) -> Binding | None:
        """Return the innermost binding of a symbol itself; predefined names have no aliases."""
        scope: Scope | None = self
        while scope is not None:
            binding = scope.bindings.get(symbol)
            if binding is not None:
                return binding
            if scope.fallback is not None and not isinstance(symbol, Alias):
                binding = scope.fallback(str(symbol))
                if binding is not None:
                    return binding
            scope = scope.parent
        return None

    def names(self) -> Iterator[str]:
        """Iterate over all names bound in this and the enclosing scopes, which a misspelled name is compared with."""
        scope: Scope | None = self
        while scope is not None:
            for symbol in scope.bindings:
                yield base_name(symbol)
            scope = scope.parent
