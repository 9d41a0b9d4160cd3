"""How values print, without recursion and never longer than asked."""

from __future__ import annotations

from typing import Any

from scenelang.grammar.printer import atom_text, number_text
from scenelang.interpreter.entity import Entity, Frames
from scenelang.interpreter.values import (
    NIL,
    Array,
    Embedding,
    HandleList,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Procedure,
    Record,
    RecordType,
    Set,
    Stream,
    Table,
    Vector,
)

LONGEST = 10_000


def display(value: Any, limit: int = LONGEST) -> str:
    """``value`` as ``print`` and ``format`` show it: strings without quotes."""
    return value if type(value) is str else show(value, limit)


def show(value: Any, limit: int = LONGEST) -> str:
    """``value`` as the REPL prints it, cut to about ``limit`` characters with ``...``."""
    out: list[str] = []
    size = 0
    stack: list[Any] = [value]
    while stack:
        item = stack.pop()
        text = item.text if type(item) is _Text else _piece(item, stack)
        out.append(text)
        size += len(text)
        if size > limit:
            return "".join(out)[: max(0, limit - 3)] + "..."
    return "".join(out)


class _Text:
    """A piece of output waiting on the stack."""

    __slots__ = ("text",)

    def __init__(self, text: str) -> None:
        self.text = text


_CLOSE = _Text(")")
_SPACE = _Text(" ")


class _Rest:
    """The tail of a list that is being printed."""

    __slots__ = ("value",)

    def __init__(self, value: Any) -> None:
        self.value = value


def _piece(item: Any, stack: list[Any]) -> str:
    """The text that begins ``item``; what follows is pushed on ``stack``."""
    if type(item) is _Rest:
        return _rest_piece(item.value, stack)
    if type(item) is Pair:
        stack += (_Rest(item.cdr), item.car)
        return "("
    if item is NIL:
        return "()"
    sequence = _sequence_parts(item)
    if sequence is not None:
        opening, members = sequence
        stack.append(_CLOSE)
        for position, member in enumerate(reversed(members[:LONGEST])):
            stack.append(member)
            if position < len(members) - 1 or opening != "(":
                stack.append(_SPACE)
        return opening
    return _leaf(item)


def _rest_piece(tail: Any, stack: list[Any]) -> str:
    if type(tail) is Pair:
        stack += (_Rest(tail.cdr), tail.car)
        return " "
    if tail is NIL:
        return ")"
    stack += (_CLOSE, tail)
    return " . "


def _sequence_parts(item: Any) -> tuple[str, list[Any]] | None:
    kind = type(item)
    if kind is MutableList:
        return "(mutable-list", item.items
    if kind is Table:
        return "(table", [part for entry in item.entries.values() for part in entry]
    if kind is Set:
        return "(set", list(item.entries.values())
    if kind is Record:
        return f"({item.type.name}", item.values
    if kind is Embedding:
        parts: list[Any] = []
        if item.handle is not None:
            parts.append(_Text(f"<{item.handle}>"))
        if item.text is not None:
            parts.append(item.text)
        for name, value in item.attributes.items():
            parts += (_Text(f":{name}"), value)
        return "(embedding", parts
    return None


def _leaf(item: Any) -> str:
    kind = type(item)
    if kind is Vector:
        return "[" + " ".join(map(number_text, item[:LONGEST])) + "]"
    if kind is Matrix:
        rows = [item[0:4], item[4:8], item[8:12], (0.0, 0.0, 0.0, 1.0)]
        return "[" + " ".join("[" + " ".join(map(number_text, row)) + "]" for row in rows) + "]"
    if kind is Array:
        return _nested(item.data)
    if kind is MutableArray:
        return f"(mutable-array {_nested(item.data)})"
    if kind is Entity:
        return f'<entity "{item.word}">'
    if kind is Frames:
        return f"<{len(item.frames)} frames>"
    if kind is HandleList:
        return f"(<z{item.start}> <z{item.start + 1}> ...)"
    if isinstance(item, Procedure):
        return f"<function {item.name}>"
    if kind is Stream:
        return f"<random stream {item.kind}>"
    if kind is RecordType:
        return f"<record type {item.name}>"
    return atom_text(item)


def _nested(data: Any) -> str:
    if data.ndim == 0:
        return number_text(data.item())
    if data.ndim == 1:
        return "[" + " ".join(number_text(x) for x in data[:LONGEST].tolist()) + "]"
    rows = data[: max(1, LONGEST * len(data) // max(1, data.size))]
    return "[" + " ".join(_nested(row) for row in rows) + "]"
