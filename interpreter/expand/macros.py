"""Macros: pattern-matching ``syntax-rules`` and procedural ``define-macro``.

Datums produced by a template carry the span of the macro use, annotated with the expansion.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import (
    ArrayDatum,
    Atom,
    Datum,
    Expansion,
    Handle,
    Keyword,
    ListDatum,
    Span,
    Symbol,
    dataclass,
    replace,
)
from scenelang.grammar.diagnostics import LimitError, Note, SceneError
from scenelang.interpreter.expand.scope import (
    Alias,
    Annotated,
    Macro,
    Scope,
    Special,
    TemplateKeyword,
    base_name,
    make_alias,
)
from scenelang.interpreter.runtime.show import array_literal
from scenelang.interpreter.runtime.types import type_name
from scenelang.interpreter.values.values import NIL, Embedding, MutableList, Pair, Vector, make_list

if TYPE_CHECKING:
    from scenelang.interpreter.expand.expand import Expander


# --- conversion between datums and values: quoted constants, and code as data for macros ------------------------------


# Head of the list that represents an array literal in the operands of a procedural macro.
BRACKETS = Symbol("[ ]")
MAX_ITEMS = 1_000_000  # of a constant or a macro's output: shared structure can make a tree of exponential size


class _Budget:
    """Number of items of macro data or a constant that may still be visited."""

    __slots__ = ("left",)

    def __init__(self) -> None:
        self.left = MAX_ITEMS

    def spend(self) -> None:
        """Count one item; raise ``LimitError`` after too many."""
        self.left -= 1
        if self.left < 0:
            raise LimitError("expansion", f"macro output exceeds the limit of {MAX_ITEMS:,} items")


def quoted_value(datum: Datum) -> Any:
    """Return the value of ``(quote datum)``; aliases become plain symbols."""
    return _value(datum, _constant, lambda datum, items: array_literal(items), _Budget())


def syntax_value(datum: Datum, origins: dict[int, Datum]) -> Any:
    """Convert ``datum`` to data for a macro; ``origins`` records the datum of each pair, by identity."""

    def brackets(datum: Datum, items: list[Any]) -> Any:
        return Pair(BRACKETS, make_list(items))

    return _value(datum, _operand, brackets, _Budget(), origins)


def _constant(value: Any) -> Any:
    """Return the value of a quoted atom."""
    if isinstance(value, Alias):
        return Symbol(base_name(value))
    if type(value) is Annotated:
        return Symbol(f"{base_name(value.name)}::{value.type}")
    if type(value) is TemplateKeyword:
        return Keyword(value)
    return Embedding(str(value)) if type(value) is Handle else value


def _operand(value: Any) -> Any:
    """Return the value of an atom in the operands of a macro, where aliases are kept."""
    return Keyword(value) if type(value) is TemplateKeyword else value


def _value(
    datum: Datum,
    atom: Callable[[Any], Any],
    array: Callable[[Datum, list[Any]], Any],
    budget: _Budget,
    origins: dict[int, Datum] | None = None,
) -> Any:
    """Convert a datum to data.

    ``atom`` converts atoms, ``array`` array literals; ``origins`` records the datum of each pair, by identity.
    """
    budget.spend()
    if isinstance(datum, Atom):
        return atom(datum.value)
    items = [_value(item, atom, array, budget, origins) for item in datum.items]
    if isinstance(datum, ArrayDatum):
        result = array(datum, items)
    else:
        tail = _value(datum.tail, atom, array, budget, origins) if datum.tail is not None else NIL
        result = make_list(items, tail)
    if origins is not None and type(result) is Pair:
        origins[id(result)] = datum
    return result


def datum_of(value: Any, span: Span, origins: dict[int, Datum]) -> Datum:
    """Convert the result of a macro to a datum; parts of the macro's operands keep their original spans."""
    return _datum_of(value, span, origins, _Budget())


def _datum_of(value: Any, span: Span, origins: dict[int, Datum], budget: _Budget) -> Datum:
    """Convert data to a datum; raise ``SceneError`` for a value that is not code."""
    budget.spend()
    if type(value) is Pair:
        if id(value) in origins:
            return origins[id(value)]
        return _list_datum(value, span, origins, budget)
    if value is NIL:
        return ListDatum((), None, span)
    if isinstance(value, MutableList):
        return ListDatum(tuple([_datum_of(item, span, origins, budget) for item in value.items]), None, span)
    if type(value) is Vector:
        return ArrayDatum(tuple(Atom(item, span) for item in value), span)
    if type(value) is Embedding and value.handle is not None:
        return Atom(Handle(value.handle), span)
    if value is None or isinstance(value, (bool, int, float, str, Symbol, Keyword, Annotated)):
        return Atom(value, span)
    raise SceneError("macro", f"a macro returned {type_name(value)}, which is not code", span=span)


def _list_datum(value: Pair, span: Span, origins: dict[int, Datum], budget: _Budget) -> Datum:
    """Convert a list to a datum; the unchanged rest of an operand keeps its span."""
    items: list[Datum] = []
    rest: Any = value
    while type(rest) is Pair:
        origin = origins.get(id(rest))
        if items and isinstance(origin, ListDatum):
            return ListDatum((*items, *origin.items), origin.tail, span)
        items.append(_datum_of(rest.car, span, origins, budget))
        rest = rest.cdr
    if value.car is BRACKETS:
        return ArrayDatum(tuple(items[1:]), span)
    tail = None if rest is NIL else _datum_of(rest, span, origins, budget)
    return ListDatum(tuple(items), tail, span)


MAX_EXPANDED_ITEMS = 200_000  # of one expansion of a template; nested ellipses can multiply its size


def use_span(use: Datum, name: str, definition: Span | None) -> Span:
    """Return the span of a macro's output: that of the macro use, annotated with the expansion."""
    span = use.span
    return Span(span.source, span.start, span.end, Expansion(name, definition, span.expansion))


# --- define-macro --------------------------------------------------------------------------------------------------


def procedural(
    expander: Expander, name: str, parameters: Datum, body: Sequence[Datum], scope: Scope, span: Span
) -> Macro:
    """Create the macro of ``(define-macro (name . parameters) body ...)``.

    Its body can use builtins and macros defined earlier, but no variables of the program. It may use the program's
    memory limit and one second more than its time limit, so that the program's limit is reported first (E507); the
    limits of macros (10 seconds, 2,000,000 steps) remain.

    Parameters
    ----------
    name, parameters, body
        Parts of the definition.
    scope
        Scope of the definition, in which the names of templates are looked up.
    span
        Location of the definition.
    """
    visible = _macro_scope(scope)
    outer, expander.template_scope = expander.template_scope, scope
    recovers, expander.recovers = expander.recovers, False  # the function runs at expansion time
    try:
        function = expander.expand_lambda(parameters, body, visible, span, name)
    finally:
        expander.template_scope, expander.recovers = outer, recovers

    def transform(use: Datum, use_scope: Scope) -> Datum:
        """Expand a use of the macro: run its function on the arguments as data."""
        origins: dict[int, Datum] = {}
        assert isinstance(use, ListDatum)
        expansion_span = use_span(use, name, span)
        saved, expander.template_aliases = expander.template_aliases, {}
        saved_scope, expander.template_scope = expander.template_scope, scope
        try:
            arguments = [syntax_value(item, origins) for item in use.items[1:]]
            value, repeatable = expander.run_macro(function, arguments)
            if not repeatable:
                expander.mark_random()
            return datum_of(value, expansion_span, origins)
        except LimitError as error:
            notes: tuple[Note, ...] = (Note("macro defined here", span),)
            hint = "look for an infinite loop or recursion; the body of a macro has separate limits"
            raise SceneError(
                "expansion", f"expansion of the macro `{name}` failed: {error.message}", hint, use.span, notes
            ) from None
        except SceneError as error:
            notes = (Note("macro defined here", span), *error.notes)
            raise SceneError(
                error.name, f"in the macro `{name}`: {error.message}", error.hint, use.span, notes
            ) from None
        finally:
            expander.template_aliases = saved
            expander.template_scope = saved_scope

    return Macro(name, transform, span)


def _macro_scope(scope: Scope) -> Scope:
    """Return the part of ``scope`` visible in a macro's body: builtins, forms and macros, but no variables."""
    chain: list[Scope] = []
    base: Scope | None = scope
    while base is not None and base.fallback is None:
        chain.append(base)
        base = base.parent
    visible = Scope(base)
    for region in reversed(chain):
        for symbol, binding in region.bindings.items():
            if isinstance(binding, (Macro, Special)):
                visible.bindings[symbol] = binding
    return visible


def broken(name: str, span: Span) -> Macro:
    """Return a placeholder for a macro with an invalid definition, so that its uses cause no further errors."""
    return Macro(name, lambda use, scope: Atom(None, use.span), span)


# --- syntax-rules (R7RS, section 4.3.2) ------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class _Rules:
    """Rules of a ``syntax-rules`` macro.

    ``ellipsis`` is the custom ellipsis identifier, or None for the usual ``...``. The ellipsis and the ``literals`` are
    identifiers rather than names: an identifier inserted by another macro may have the same name but be different.
    """

    name: str
    ellipsis: Symbol | None
    literals: frozenset[Symbol]
    rules: tuple[tuple[Datum, Datum], ...]
    scope: Scope
    span: Span

    def is_ellipsis(self, datum: Datum) -> bool:
        """Return whether ``datum`` is the ellipsis; a literal of the same name is not (R7RS, section 4.3.2)."""
        if not isinstance(datum, Atom) or not isinstance(datum.value, Symbol) or datum.value in self.literals:
            return False
        if self.ellipsis is not None:
            return _is_same(datum.value, self.ellipsis)
        return base_name(datum.value) == "..." and self.scope.lookup(datum.value) is None

    @property
    def dots(self) -> str:
        """The ellipsis as written in the source."""
        return "..." if self.ellipsis is None else base_name(self.ellipsis)


def _is_same(a: Symbol, b: Symbol) -> bool:
    """Return whether two identifiers of one form are the same."""
    return a is b if isinstance(a, Alias) or isinstance(b, Alias) else a == b


def check_proper(*datums: Datum) -> None:
    """Raise an error for a list of a form's own syntax that ends in a dotted pair, such as ``(else 1 . 2)``."""
    for datum in datums:
        if isinstance(datum, ListDatum) and datum.tail is not None:
            raise SceneError("bad-dot", "a list of this form cannot end in a dotted pair", None, datum.span)


def syntax_rules(expander: Expander, datum: Datum, scope: Scope, name: str, span: Span) -> Macro:
    """Create the macro of ``(syntax-rules (literal ...) (pattern template) ...)``.

    Parameters
    ----------
    datum
        The ``syntax-rules`` form.
    scope
        Scope of the definition, in which the names of the templates are looked up.
    name
        Name that the macro is defined as.
    span
        Location of the definition.

    Raises
    ------
    SceneError
        "macro" if the form or a rule is malformed.
    """
    items = datum.items if isinstance(datum, ListDatum) else ()
    head = expander.binding_of(items[0], scope) if items else None
    if not isinstance(head, Special) or head.name != "syntax-rules" or len(items) < 2:
        raise SceneError(
            "macro", f"the macro `{name}` requires `(syntax-rules (literal ...) (pattern template) ...)`", None, span
        )
    check_proper(datum)
    rest = items[1:]
    ellipsis: Symbol | None = None
    if isinstance(rest[0], Atom) and isinstance(rest[0].value, Symbol):
        ellipsis, rest = rest[0].value, rest[1:]
    if not rest or not isinstance(rest[0], ListDatum):
        raise SceneError("macro", "expected a list of literals in `syntax-rules`", None, datum.span)
    check_proper(rest[0])
    literals = frozenset(
        item.value for item in rest[0].items if isinstance(item, Atom) and isinstance(item.value, Symbol)
    )
    ruleset = _Rules(name, ellipsis, literals, (), scope, span)
    rules = []
    for rule in rest[1:]:
        if not isinstance(rule, ListDatum) or len(rule.items) != 2 or not isinstance(rule.items[0], ListDatum):
            raise SceneError("macro", "invalid rule; expected `(pattern template)`", None, rule.span)
        check_proper(rule)
        _check_pattern(ruleset, rule.items[0])
        rules.append((rule.items[0], rule.items[1]))
    ruleset = replace(ruleset, rules=tuple(rules))
    return Macro(name, lambda use, use_scope: _apply_rules(ruleset, use, use_scope), span)


def _name(datum: Datum) -> str | None:
    """Return the name of a symbol, None for other datums."""
    return base_name(datum.value) if isinstance(datum, Atom) and isinstance(datum.value, Symbol) else None


def _check_pattern(ruleset: _Rules, pattern: Datum) -> None:
    """Raise an error for a list in a pattern with more than one ellipsis or a leading one."""
    if isinstance(pattern, Atom):
        return
    dots = [index for index, item in enumerate(pattern.items) if ruleset.is_ellipsis(item)]
    if len(dots) > 1 or dots[:1] == [0]:
        raise SceneError(
            "macro", f"`{ruleset.dots}` may occur only once in a list, and only after a pattern", None, pattern.span
        )
    for item in pattern.items:
        _check_pattern(ruleset, item)


def _apply_rules(ruleset: _Rules, use: Datum, scope: Scope) -> Datum:
    """Expand a macro use by the first rule whose pattern matches; the name of the macro itself is not matched."""
    assert isinstance(use, ListDatum)
    for pattern, template in ruleset.rules:
        bound: dict[Any, Any] = {}
        assert isinstance(pattern, ListDatum)
        operands = ListDatum(use.items[1:], use.tail, use.span)
        shape = ListDatum(pattern.items[1:], pattern.tail, pattern.span)
        if _match(ruleset, shape, operands, scope, bound):
            span = use_span(use, ruleset.name, ruleset.span)
            return _Instance(ruleset, span).build(template, bound)
    usages = " or ".join(_usage(ruleset.name, pattern) for pattern, _ in ruleset.rules[:3])
    note = Note(f"the macro `{ruleset.name}` is defined here", ruleset.span)
    raise SceneError(
        "macro", f"no rule of the macro `{ruleset.name}` matches this use", f"expected {usages}", use.span, (note,)
    )


def _usage(name: str, pattern: Datum) -> str:
    """Return the usage of a macro according to one of its patterns."""
    text = " ".join(pattern.span.text.split())
    return re.sub(r"^\(\s*[^\s()]+", f"`({name}", text) + "`"


def _match(ruleset: _Rules, pattern: Datum, datum: Datum, scope: Scope, bound: dict[Any, Any]) -> bool:
    """Return whether a datum matches a pattern, and enter the captures of pattern variables into ``bound``.

    A variable under an ellipsis captures a list with one item for each repetition.
    """
    if isinstance(pattern, Atom):
        return _match_atom(ruleset, pattern, datum, scope, bound)
    if type(pattern) is not type(datum):
        return False
    assert not isinstance(datum, Atom)
    items, tail = list(pattern.items), getattr(pattern, "tail", None)
    operands, rest = list(datum.items), getattr(datum, "tail", None)
    dots = next((i for i, item in enumerate(items) if ruleset.is_ellipsis(item)), None)
    if dots is None:
        return _match_fixed(ruleset, pattern, datum, scope, bound)
    before, repeated, after = items[: dots - 1], items[dots - 1], items[dots + 1 :]
    repeats = len(operands) - len(before) - len(after)
    if repeats < 0 or (tail is None and rest is not None):
        return False
    captures = []
    for item in operands[len(before) : len(before) + repeats]:
        match: dict[Any, Any] = {}
        if not _match(ruleset, repeated, item, scope, match):
            return False
        captures.append(match)
    for variable in _pattern_variables(ruleset, repeated):
        bound[variable] = [match[variable] for match in captures]
    pairs = [*zip(before, operands), *zip(after, operands[len(before) + repeats :])]
    if not all(_match(ruleset, item_pattern, operand, scope, bound) for item_pattern, operand in pairs):
        return False
    return tail is None or _match(ruleset, tail, rest or ListDatum((), None, datum.span), scope, bound)


def _match_fixed(
    ruleset: _Rules, pattern: ListDatum | ArrayDatum, datum: ListDatum | ArrayDatum, scope: Scope, bound: dict[Any, Any]
) -> bool:
    """Match a list or array pattern without an ellipsis; its tail matches the rest of a longer list."""
    items, tail = pattern.items, getattr(pattern, "tail", None)
    operands, rest = datum.items, getattr(datum, "tail", None)
    if len(operands) < len(items) or (tail is None and (len(operands) > len(items) or rest is not None)):
        return False
    if not all(_match(ruleset, item, operand, scope, bound) for item, operand in zip(items, operands)):
        return False
    if tail is None:
        return True
    remaining = operands[len(items) :]
    if not remaining and rest is not None:
        return _match(ruleset, tail, rest, scope, bound)
    return _match(ruleset, tail, ListDatum(tuple(remaining), rest, datum.span), scope, bound)


def _match_atom(ruleset: _Rules, pattern: Atom, datum: Datum, scope: Scope, bound: dict[Any, Any]) -> bool:
    """Match a constant, a literal, which must have the same binding in both scopes, or a variable."""
    value = pattern.value
    if not isinstance(value, Symbol):
        return isinstance(datum, Atom) and type(datum.value) is type(value) and bool(datum.value == value)
    name = base_name(value)
    if value in ruleset.literals:
        if _name(datum) != name or not isinstance(datum, Atom):
            return False
        return scope.lookup(datum.value) is ruleset.scope.lookup(value)
    if name != "_":
        bound[value] = datum
    return True


def _pattern_variables(ruleset: _Rules, pattern: Datum) -> list[Any]:
    """Return the variables of a pattern."""
    variables: list[Any] = []
    stack = [pattern]
    while stack:
        item = stack.pop()
        if isinstance(item, Atom):
            if not isinstance(item.value, Symbol) or item.value in ruleset.literals or ruleset.is_ellipsis(item):
                continue
            if base_name(item.value) != "_":
                variables.append(item.value)
        else:
            stack.extend(item.items)
            if isinstance(item, ListDatum) and item.tail is not None:
                stack.append(item.tail)
    return variables


class _Instance:
    """Instance of a template: symbols other than pattern variables become fresh aliases."""

    def __init__(self, ruleset: _Rules, span: Span) -> None:
        self.ruleset = ruleset
        self.span = span
        self.aliases: dict[Symbol, Alias] = {}
        self.size = 0

    def build(self, template: Datum, bound: dict[Any, Any], *, escaped: bool = False) -> Datum:
        """Return the expansion of a template; ``escaped`` is set inside ``(... template)``."""
        self.size += 1
        if self.size > MAX_EXPANDED_ITEMS:
            raise LimitError("expansion", f"the expansion of `{self.ruleset.name}` is too large", None, self.span)
        if isinstance(template, Atom):
            return self._atom(template, bound)
        items = template.items
        if not escaped and len(items) == 2 and self.ruleset.is_ellipsis(items[0]):
            return self.build(items[1], bound, escaped=True)  # (... template) escapes the ellipsis
        built: list[Datum] = []
        position = 0
        while position < len(items):
            item, depth = items[position], 0
            while not escaped and position + 1 < len(items) and self.ruleset.is_ellipsis(items[position + 1]):
                depth, position = depth + 1, position + 1
            built += self._repeat(item, bound, depth) if depth else [self.build(item, bound, escaped=escaped)]
            position += 1
        if isinstance(template, ArrayDatum):
            return ArrayDatum(tuple(built), self.span)
        if template.tail is None:
            return ListDatum(tuple(built), None, self.span)
        tail = self.build(template.tail, bound, escaped=escaped)
        if isinstance(tail, ListDatum):
            return ListDatum((*built, *tail.items), tail.tail, self.span)
        return ListDatum(tuple(built), tail, self.span)

    def _atom(self, atom: Atom, bound: dict[Any, Any]) -> Datum:
        """Return the capture of a pattern variable, an alias of another symbol, or the atom.

        A keyword parameter in a template is hygienic, like other parameters: ``(lambda ((:height 1)) height)`` binds
        the ``height`` of the template. The keyword itself is not renamed.
        """
        value = atom.value
        if not isinstance(value, (Symbol, Keyword)):
            return Atom(value, self.span)
        if isinstance(value, Symbol) and value in bound:
            capture = bound[value]
            if isinstance(capture, list):
                name = base_name(value)
                raise SceneError(
                    "macro",
                    f"the pattern variable `{name}` stands for several forms, and must be repeated here",
                    f"write `{self.ruleset.dots}` after the form around it that is to be repeated",
                    atom.span,
                )
            return capture  # type: ignore[no-any-return]
        if isinstance(value, Keyword) and "::" not in value:
            return Atom(TemplateKeyword(value, self._fresh(Symbol(value))), self.span)
        return Atom(self._alias(value), self.span)

    def _alias(self, value: Symbol | Keyword) -> Any:
        """Return the alias of a template symbol, with its type annotation if it has one."""
        text = str(value) if isinstance(value, Keyword) else base_name(value)
        name, sign, annotation = text.partition("::")
        if sign and name and annotation:
            return Annotated(self._fresh(Symbol(name)), annotation, isinstance(value, Keyword))
        return self._fresh(value)  # type: ignore[arg-type]

    def _fresh(self, symbol: Symbol) -> Alias:
        """Return the alias of a symbol in this expansion."""
        alias = self.aliases.get(symbol)
        if alias is None:
            alias = self.aliases[symbol] = make_alias(symbol, self.ruleset.scope, soft=False)
        return alias

    def _repeat(self, item: Datum, bound: dict[Any, Any], depth: int) -> list[Datum]:
        """Return the expansions of a template under ``depth`` ellipses.

        There is one for each item that the variables of the template captured.
        """
        variables = [v for v in _pattern_variables(self.ruleset, item) if isinstance(bound.get(v), list)]
        if not variables:
            message = f"no repeated pattern variable before `{self.ruleset.dots}` in this template"
            raise SceneError("macro", message, None, item.span)
        lengths = {len(bound[v]) for v in variables}
        if len(lengths) > 1:
            message = "pattern variables repeated together matched different numbers of items"
            raise SceneError("macro", message, None, self.span)
        out: list[Datum] = []
        for index in range(lengths.pop()):
            iteration = {**bound, **{v: bound[v][index] for v in variables}}
            out += self._repeat(item, iteration, depth - 1) if depth > 1 else [self.build(item, iteration)]
        return out
