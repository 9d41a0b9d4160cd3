"""How values print, without recursion and in time that depends on the length asked for alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain
from typing import Any

from scenelang.grammar.codes import CODES
from scenelang.grammar.printer import atom_text, number_text, string_text
from scenelang.interpreter.entity import Entity, Frames
from scenelang.interpreter.values import (
    NIL,
    Array,
    Condition,
    Embedding,
    HandleList,
    Keyword,
    Matrix,
    Mutable,
    MutableArray,
    MutableList,
    Pair,
    Procedure,
    Record,
    RecordType,
    Set,
    Stream,
    Symbol,
    Table,
    Vector,
)

LONGEST = 10_000
Read = Callable[[Mutable], None]


def _unread(_: Mutable) -> None:
    """For text that no program sees."""


def display(value: Any, limit: int = LONGEST, read: Read = _unread) -> str:
    """``value`` as ``print`` and ``format`` show it: strings without quotes, and whole."""
    return value if type(value) is str else show(value, limit, read)


def show(value: Any, limit: int = LONGEST, read: Read = _unread) -> str:
    """``value`` as the REPL prints it, cut to about ``limit`` characters with ``...``.

    ``read`` is told of every mutable thing whose content is looked at; a program that sees the text has read it."""
    if type(value) in _PLAIN:
        text = atom_text(value)
        return text if len(text) <= limit else text[: max(0, limit - 3)] + "..."
    out: list[str] = []
    size = 0
    stack: list[Iterator[Any]] = [iter((value,))]
    while stack:
        item = next(stack[-1], _END)
        if item is _END:
            stack.pop()
            continue
        text = item.text if type(item) is _Text else _piece(item, stack, limit - size, read)
        out.append(text)
        size += len(text)
        if size > limit:
            return "".join(out)[: max(0, limit - 3)] + "..."
    return "".join(out)


_END = object()
_PLAIN = frozenset((int, float, bool, type(None)))


class _Text:
    """A piece of output between the items."""

    __slots__ = ("text",)

    def __init__(self, text: str) -> None:
        self.text = text


_CLOSE = _Text(")")
_BRACKET = _Text("]")
_SPACE = _Text(" ")
_DOT = _Text(" . ")


def _piece(item: Any, stack: list[Iterator[Any]], room: int, read: Read) -> str:
    """The text that begins ``item``; what follows is pushed on ``stack``. No more than about ``room`` is looked at."""
    if type(item) is Pair:
        stack.append(_list_pieces(item))
        return "("
    if item is NIL:
        return "()"
    if isinstance(item, Mutable):
        read(item)
    sequence = _sequence_parts(item)
    if sequence is not None:
        opening, members = sequence
        stack.append(_call_pieces(members, opening == "("))
        return opening
    if type(item) is Vector:
        stack.append(_row_pieces(item))
        return "["
    if type(item) is Array or type(item) is _Rows:
        return _array_piece(item.data, stack)
    if type(item) is MutableArray:
        stack.append(iter((_CLOSE,)))
        return "(mutable-array " + _array_piece(item.data, stack)
    return _leaf(item, room)


def _list_pieces(pair: Pair) -> Iterator[Any]:
    yield pair.car
    rest = pair.cdr
    while type(rest) is Pair:
        yield _SPACE
        yield rest.car
        rest = rest.cdr
    if rest is not NIL:
        yield _DOT
        yield rest
    yield _CLOSE


def _call_pieces(members: Iterator[Any], first: bool) -> Iterator[Any]:
    """``members`` behind the name of what makes the value; ``first``: there is no name."""
    for member in members:
        if not first:
            yield _SPACE
        first = False
        yield member
    yield _CLOSE


def _row_pieces(members: Iterator[Any] | Vector) -> Iterator[Any]:
    between = False
    for member in members:
        if between:
            yield _SPACE
        between = True
        yield member
    yield _BRACKET


def _array_piece(data: Any, stack: list[Iterator[Any]]) -> str:
    if data.ndim == 0:
        return number_text(data.item())
    stack.append(_row_pieces(_rows(data)))
    return "["


def _rows(data: Any) -> Iterator[Any]:
    for row in data:
        yield row.item() if data.ndim == 1 else _Rows(row)


class _Rows:
    """A part of an array that is being printed."""

    __slots__ = ("data",)

    def __init__(self, data: Any) -> None:
        self.data = data


def _sequence_parts(item: Any) -> tuple[str, Iterator[Any]] | None:
    kind = type(item)
    if kind is MutableList:
        return "(mutable-list", iter(item.items)
    if kind is Table:
        return "(table", chain.from_iterable(item.entries.values())
    if kind is Set:
        return "(set", iter(item.entries.values())
    if kind is Record:
        return f"({item.type.name[:LONGEST]}", iter(item.values)
    if kind is Embedding:
        return "(embedding", _embedding_parts(item)
    return None


def _embedding_parts(item: Embedding) -> Iterator[Any]:
    if item.handle is not None:
        yield _Text(f"<{item.handle[:LONGEST]}>")
    if item.text is not None:
        yield item.text
    for name, value in item.attributes.items():
        yield _Text(f":{name[:LONGEST]}")
        yield value


def _leaf(item: Any, room: int) -> str:
    kind = type(item)
    if kind is str:
        return string_text(_cut(item, room))
    if kind is Symbol or kind is Keyword:
        return atom_text(kind(_cut(item, room)))
    if kind is Matrix:
        rows = [item[0:4], item[4:8], item[8:12], (0.0, 0.0, 0.0, 1.0)]
        return "[" + " ".join("[" + " ".join(map(number_text, row)) + "]" for row in rows) + "]"
    if kind is Entity:
        return f'<entity "{_cut(item.word, room)}">'
    if kind is Frames:
        return f"<{len(item.frames)} frames>"
    if kind is HandleList:
        return f"(<z{item.start}> <z{item.start + 1}> ...)"
    if isinstance(item, Procedure):
        return f"<procedure {_cut(item.name, room)}>"
    if kind is Condition:
        return f"<error {CODES[item.error.name].code}>"
    if kind is Stream:
        return f"<random stream {item.kind}>"
    if kind is RecordType:
        return f"<record type {_cut(item.name, room)}>"
    return atom_text(item)


def _cut(text: str, room: int) -> str:
    """``text``, or so much of it that what is shown is cut."""
    return text if len(text) <= room + 8 else text[: max(0, room) + 8]
