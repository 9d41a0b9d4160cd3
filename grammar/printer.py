"""Datums -> text that reads back equal. Iterative, so that depth does not matter."""

from __future__ import annotations

from collections.abc import Mapping, Set
from types import MappingProxyType
from typing import Any

from scenelang.grammar.datum import PREFIXES, ArrayDatum, Atom, Datum, Handle, Keyword, ListDatum, Symbol

_LONGEST_BITS = 14_000  # Python refuses to print more than 4,300 digits
_NO_SPELLING: Mapping[int, str] = MappingProxyType({})
_PREFIX_OF = {name: prefix for prefix, name in PREFIXES.items()}
_STRING_ESCAPES = {
    '"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r", "\a": "\\a", "\b": "\\b", "\0": "\\0",
}  # fmt: skip


def number_text(value: int | float) -> str:
    """A number as the reader reads it back; ``nan`` and ``inf`` by their names."""
    if type(value) is int and value.bit_length() > _LONGEST_BITS:
        return f"<integer of {value.bit_length():,} bits>"
    return repr(value)


def string_text(value: str) -> str:
    """A string literal."""
    pieces = []
    for c in value:
        if c in _STRING_ESCAPES:
            pieces.append(_STRING_ESCAPES[c])
        else:
            pieces.append(c if c.isprintable() else f"\\x{ord(c):x};")
    return '"' + "".join(pieces) + '"'


def atom_text(value: Any) -> str:
    """The text of an atom's value; anything that is no atom prints as ``<type>``."""
    kind = type(value)
    if kind is Symbol:
        return str(value)
    if kind is Keyword:
        return f":{value}"
    if kind is Handle:
        return f"<{value}>"
    if kind is str:
        return string_text(value)
    if kind is bool:
        return "#t" if value else "#f"
    if value is None:
        return "none"
    if kind is int or kind is float:
        return number_text(value)
    return f"<{kind.__name__}>"


def print_datum(datum: Datum, spelling: Mapping[int, str] = _NO_SPELLING, plain: Set[int] = frozenset()) -> str:
    """``datum`` on one line. ``spelling``: the exact text of atoms, by ``id``; ``plain``: the ids of lists such as
    ``(quote x)`` that are not to be written with a prefix."""
    out: list[str] = []
    stack: list[Any] = [datum]
    while stack:
        item = stack.pop()
        if isinstance(item, str) and type(item) is str:
            out.append(item)
        elif isinstance(item, Atom):
            out.append(spelling.get(id(item)) or atom_text(item.value))
        else:
            _push(item, stack, plain)
    return "".join(out)


def quote_prefix(datum: Datum) -> str | None:
    """The prefix that a list such as ``(quote x)`` is written with."""
    if not isinstance(datum, ListDatum) or len(datum.items) != 2 or datum.tail is not None:
        return None
    head, operand = datum.items
    if isinstance(operand, Atom) and str(operand.value).startswith("@"):  # `,@x` is another form
        return None
    return _PREFIX_OF.get(head.value) if isinstance(head, Atom) and type(head.value) is Symbol else None


def _push(item: Any, stack: list[Any], plain: Set[int]) -> None:
    """Push the pieces of a compound datum, last first."""
    prefix = quote_prefix(item) if id(item) not in plain else None
    if prefix is not None:
        stack += (item.items[1], prefix)
        return
    opening, closing = ("[", "]") if isinstance(item, ArrayDatum) else ("(", ")")
    stack.append(closing)
    if isinstance(item, ListDatum) and item.tail is not None:
        stack += (item.tail, " . ")
    for position in range(len(item.items) - 1, -1, -1):
        stack.append(item.items[position])
        if position:
            stack.append(" ")
    stack.append(opening)
