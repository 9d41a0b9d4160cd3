"""Datums: what the reader makes of a text. Every datum knows its span."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias

# Source files and places in them. Spans are offsets; line and column are worked out only when somebody asks.


@dataclass(frozen=True, eq=False)
class Source:
    """A text with a name: a file's path as the user wrote it, or ``<stdin>`` and the like."""

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
        """Line and column of ``offset``, both counted from 1; columns are characters."""
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def line_start(self, number: int) -> int:
        """The offset at which line ``number`` (from 1) begins."""
        return self._line_starts[number - 1]

    def line(self, number: int) -> str:
        """The text of line ``number`` (from 1) without its line end."""
        starts = self._line_starts
        end = starts[number] if number < len(starts) else len(self.text)
        return self.text[starts[number - 1] : end].rstrip("\r\n")


def comment_above(source: Source, offset: int) -> list[str]:
    """The lines of comment that end directly above the line of ``offset``, as they are written."""
    number = source.position(offset)[0] - 1
    found: list[str] = []
    while number >= 1 and (line := source.line(number).strip()).startswith(";"):
        found.insert(0, line)
        number -= 1
    return found


class Expansion(NamedTuple):
    """A macro use that made a piece of program: the macro, its definition, and the expansion around it."""

    macro: str
    definition: Span | None
    outer: Expansion | None = None


class Span(NamedTuple):
    """``source.text[start:end]``; ``expansion`` is set for what a macro made at this use of it."""

    source: Source
    start: int
    end: int
    expansion: Expansion | None = None

    @property
    def text(self) -> str:
        return self.source.text[self.start : self.end]


class Symbol(str):
    """A symbol; compares and hashes as its name, told from a string by its type."""

    __slots__ = ()


class Keyword(str):
    """A keyword ``:name``; the text is the name without the colon."""

    __slots__ = ()


class Handle(str):
    """An embedding handle ``<z1>``; the text is what stands between the angle brackets."""

    __slots__ = ()


@dataclass(frozen=True, slots=True, eq=False)
class Atom:
    """A leaf. ``value``: Symbol, Keyword, Handle, int, float, str, bool, or None for ``none``."""

    value: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class ListDatum:
    """``(a b)``, or ``(a . b)`` when ``tail`` is given. ``'x`` reads as ``(quote x)``."""

    items: tuple[Any, ...]
    tail: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class ArrayDatum:
    """``[a b]``."""

    items: tuple[Any, ...]
    span: Span


Datum: TypeAlias = Atom | ListDatum | ArrayDatum

PREFIXES = {"'": "quote", "`": "quasiquote", ",": "unquote", ",@": "unquote-splicing"}


def subdatums(datum: Datum) -> Iterator[Datum]:
    """The direct parts of a datum, the tail included."""
    if not isinstance(datum, Atom):
        yield from datum.items
        if isinstance(datum, ListDatum) and datum.tail is not None:
            yield datum.tail


def walk(*datums: Datum) -> Iterator[Datum]:
    """Every datum below and including ``datums``, in no particular order, without recursion."""
    stack = list(datums)
    while stack:
        datum = stack.pop()
        yield datum
        if not isinstance(datum, Atom):
            stack.extend(subdatums(datum))


# Datums -> text that reads back equal. Iterative, so that depth does not matter.


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
