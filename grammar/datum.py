"""Datums, the syntax tree that the reader produces from text; every datum carries its source span."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias

# Source files and locations. Spans are character offsets; line and column are computed only on demand.


@dataclass(frozen=True, eq=False)
class Source:
    """Named source text. The name is the path as the user wrote it, or a placeholder such as ``<stdin>``."""

    name: str
    text: str = field(repr=False)

    @cached_property
    def _line_starts(self) -> list[int]:
        starts = [0]
        find = self.text.find
        position = find("\n")
        while position >= 0:
            starts.append(position + 1)
            position = find("\n", position + 1)
        return starts

    def position(self, offset: int) -> tuple[int, int]:
        """Return the line and column of ``offset``, both counted from 1; columns count characters."""
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def line_start(self, number: int) -> int:
        """Return the offset of the first character of line ``number`` (from 1)."""
        return self._line_starts[number - 1]

    def line(self, number: int) -> str:
        """Return the text of line ``number`` (from 1) without its line ending."""
        starts = self._line_starts
        end = starts[number] if number < len(starts) else len(self.text)
        return self.text[starts[number - 1] : end].rstrip("\r\n")


def comment_above(source: Source, offset: int) -> list[str]:
    """Return the comment lines directly above the line of ``offset``, unchanged."""
    number = source.position(offset)[0] - 1
    found: list[str] = []
    while number >= 1 and (line := source.line(number).strip()).startswith(";"):
        found.insert(0, line)
        number -= 1
    return found


class Expansion(NamedTuple):
    """Macro expansion that produced a datum: the macro's name, the span of its definition, the enclosing expansion."""

    macro: str
    definition: Span | None
    outer: Expansion | None = None


class Span(NamedTuple):
    """Half-open range of characters, ``source.text[start:end]``.

    ``expansion`` is set on datums produced by a macro; the span is then that of the macro use.
    """

    source: Source
    start: int
    end: int
    expansion: Expansion | None = None

    @property
    def text(self) -> str:
        return self.source.text[self.start : self.end]


class Symbol(str):
    """Symbol. Compares and hashes like its name; only its type distinguishes it from a string."""

    __slots__ = ()


class Keyword(str):
    """Keyword ``:name``; the text is the name without the colon."""

    __slots__ = ()


class Handle(str):
    """Embedding handle ``<z1>``; the text is the name without the angle brackets."""

    __slots__ = ()


@dataclass(frozen=True, slots=True, eq=False)
class Atom:
    """Leaf of the tree. ``value`` is a Symbol, Keyword, Handle, int, float, str or bool, or None for ``none``."""

    value: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class ListDatum:
    """Proper list ``(a b)``, or improper list ``(a . b)`` if ``tail`` is not None. ``'x`` reads as ``(quote x)``."""

    items: tuple[Any, ...]
    tail: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class ArrayDatum:
    """Array literal ``[a b]``."""

    items: tuple[Any, ...]
    span: Span


Datum: TypeAlias = Atom | ListDatum | ArrayDatum

PREFIXES = {"'": "quote", "`": "quasiquote", ",": "unquote", ",@": "unquote-splicing"}


def subdatums(datum: Datum) -> Iterator[Datum]:
    """Iterate over the direct children of a datum, including the tail of an improper list."""
    if not isinstance(datum, Atom):
        yield from datum.items
        if isinstance(datum, ListDatum) and datum.tail is not None:
            yield datum.tail


def walk(*datums: Datum) -> Iterator[Datum]:
    """Iterate over ``datums`` and all their descendants in unspecified order, without recursion."""
    stack = list(datums)
    while stack:
        datum = stack.pop()
        yield datum
        if not isinstance(datum, Atom):
            stack.extend(subdatums(datum))


# Printing datums as text that reads back equal. It is iterative, so that deep nesting cannot overflow the stack.


_MAX_BITS = 14_000  # Python refuses to print more than 4,300 digits
_NO_SPELLING: Mapping[int, str] = MappingProxyType({})
_PREFIX_OF = {name: prefix for prefix, name in PREFIXES.items()}
_STRING_ESCAPES = {
    '"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r", "\a": "\\a", "\b": "\\b", "\0": "\\0",
}  # fmt: skip


def number_text(value: int | float) -> str:
    """Return a number as text that reads back equal; ``nan`` and ``inf`` by name."""
    if type(value) is int and value.bit_length() > _MAX_BITS:
        return f"<integer of {value.bit_length():,} bits>"
    return repr(value)


def string_text(value: str) -> str:
    """Return ``value`` as a string literal, with escapes."""
    pieces = []
    for c in value:
        if c in _STRING_ESCAPES:
            pieces.append(_STRING_ESCAPES[c])
        else:
            pieces.append(c if c.isprintable() else f"\\x{ord(c):x};")
    return '"' + "".join(pieces) + '"'


def atom_text(value: Any) -> str:
    """Return the text of an atom's value; a value that is not an atom prints as ``<type>``."""
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
    """Return the text of ``datum`` on one line.

    Parameters
    ----------
    datum
        The datum to print.
    spelling
        Original spelling of atoms, by ``id``, which takes precedence over their canonical text.
    plain
        Ids of lists such as ``(quote x)`` that are printed in full rather than as ``'x``.
    """
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
    """Return the prefix character of a list such as ``(quote x)``, or None if it is not written with one."""
    if not isinstance(datum, ListDatum) or len(datum.items) != 2 or datum.tail is not None:
        return None
    head, operand = datum.items
    if isinstance(operand, Atom) and str(operand.value).startswith("@"):  # `,` before `@x` would read back as `,@`
        return None
    return _PREFIX_OF.get(head.value) if isinstance(head, Atom) and type(head.value) is Symbol else None


def _push(item: Any, stack: list[Any], plain: Set[int]) -> None:
    """Push the pieces of a compound datum onto ``stack``, in reverse order."""
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
