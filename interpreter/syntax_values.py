"""Between datums and values: quoted constants, and programs as data for macros."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Handle, Keyword, ListDatum, Symbol
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.arrays import array_literal
from scenelang.interpreter.scope import Alias, Annotated, TemplateKeyword, base_name
from scenelang.interpreter.types import type_name
from scenelang.interpreter.values import NIL, Embedding, MutableList, Pair, Vector, make_list

# The head of a list that stands for brackets where a macro sees its operands as data.
BRACKETS = Symbol("[ ]")
MAX_ITEMS = 1_000_000  # what macros make may share its parts, and so be exponentially larger than it looks


class _Budget:
    """How many items of a macro's data or of a constant may still be walked."""

    __slots__ = ("left",)

    def __init__(self) -> None:
        self.left = MAX_ITEMS

    def spend(self) -> None:
        self.left -= 1
        if self.left < 0:
            raise LimitError("expansion", f"what a macro made has more than {MAX_ITEMS:,} items")


def quoted_value(datum: Datum) -> Any:
    """The constant that ``(quote datum)`` stands for; macros' aliases become plain symbols."""
    return _value(datum, _constant, lambda datum, items: array_literal(items), _Budget())


def syntax_value(datum: Datum, origins: dict[int, Datum]) -> Any:
    """``datum`` as data for a macro; ``origins`` remembers which datum each pair came from, by identity."""

    def brackets(datum: Datum, items: list[Any]) -> Any:
        return Pair(BRACKETS, make_list(items))

    return _value(datum, _operand, brackets, _Budget(), origins)


def _constant(value: Any) -> Any:
    if isinstance(value, Alias):
        return Symbol(base_name(value))
    if type(value) is Annotated:
        return Symbol(f"{base_name(value.name)}::{value.type}")
    if type(value) is TemplateKeyword:
        return Keyword(value)
    return Embedding(str(value)) if type(value) is Handle else value


def _operand(value: Any) -> Any:
    return Keyword(value) if type(value) is TemplateKeyword else value


def _value(
    datum: Datum,
    atom: Callable[[Any], Any],
    array: Callable[[Datum, list[Any]], Any],
    budget: _Budget,
    origins: dict[int, Datum] | None = None,
) -> Any:
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
    """The datum that a macro's value is; parts of the macro's operands keep their own places."""
    return _datum_of(value, span, origins, _Budget())


def _datum_of(value: Any, span: Span, origins: dict[int, Datum], budget: _Budget) -> Datum:
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
    raise SceneError("macro", f"a macro gave {type_name(value)}, which is no piece of program", span=span)


def _list_datum(value: Pair, span: Span, origins: dict[int, Datum], budget: _Budget) -> Datum:
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
