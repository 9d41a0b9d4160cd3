"""Datums -> text that reads back equal. Iterative, so that depth does not matter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from scenelang.grammar.datum import PREFIXES, ArrayDatum, Atom, Datum, Handle, Keyword, ListDatum, Symbol

_LONGEST_BITS = 14_000  # Python refuses to print more than 4,300 digits
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


def print_datum(datum: Datum) -> str:
    """``datum`` on one line. Atoms keep the spelling they were read with where the source still has it."""
    out: list[str] = []
    stack: list[Any] = [datum]
    while stack:
        item = stack.pop()
        if isinstance(item, str) and type(item) is str:
            out.append(item)
        elif isinstance(item, Atom):
            out.append(atom_text(item.value))
        else:
            _push(item, stack)
    return "".join(out)


def _push(item: Any, stack: list[Any]) -> None:
    """Push the pieces of a compound datum, last first."""
    if isinstance(item, ListDatum) and len(item.items) == 2 and item.tail is None:
        head = item.items[0]
        operand = item.items[1]
        splices = isinstance(operand, Atom) and str(operand.value).startswith("@")  # `,@x` is another form
        if isinstance(head, Atom) and type(head.value) is Symbol and head.value in _PREFIX_OF and not splices:
            stack += (item.items[1], _PREFIX_OF[head.value])
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


def pretty(datum: Datum, indents: Mapping[str, int | None], width: int = 88) -> str:
    """``datum`` over several lines where it does not fit one. ``indents``: operands on the head's line, by head."""
    return "\n".join(_lines(datum, indents, width))


def _lines(datum: Datum, indents: Mapping[str, int | None], width: int) -> list[str]:
    flat = print_datum(datum)
    if len(flat) <= width or isinstance(datum, (Atom, ArrayDatum)) or datum.tail is not None:
        return [flat]
    if not datum.items or not isinstance(datum.items[0], Atom):
        return _aligned(datum, indents, width)
    head = datum.items[0].value
    kept = indents.get(str(head)) if type(head) is Symbol else None
    if kept is None:
        kept = 0
    lines = _first_lines(datum.items[: 1 + kept], indents, width)
    for line_items in _with_keywords(datum.items[1 + kept :]):
        *before, last = line_items
        prefix = "".join(print_datum(item) + " " for item in before)
        rest = _lines(last, indents, width - 2 - len(prefix))
        lines += ["  " + (prefix if i == 0 else " " * len(prefix)) + line for i, line in enumerate(rest)]
    lines[-1] += ")"
    return lines


def _first_lines(items: Sequence[Datum], indents: Mapping[str, int | None], width: int) -> list[str]:
    """The head and the operands that stand on its line; the last of them may take several."""
    start = "(" + " ".join(print_datum(item) for item in items[:-1]) + (" " if len(items) > 1 else "")
    if len(items) == 1:
        return [start + print_datum(items[0])]
    rest = _lines(items[-1], indents, width - len(start))
    return [start + rest[0], *(" " * len(start) + line for line in rest[1:])]


def _with_keywords(items: Sequence[Datum]) -> list[list[Datum]]:
    """Operands line by line: a keyword stands with the value after it."""
    lines: list[list[Datum]] = []
    for item in items:
        last = lines[-1][-1] if lines else None
        if isinstance(last, Atom) and type(last.value) is Keyword and len(lines[-1]) == 1:
            lines[-1].append(item)
        else:
            lines.append([item])
    return lines


def _aligned(datum: ListDatum, indents: Mapping[str, int | None], width: int) -> list[str]:
    lines: list[str] = []
    for item in datum.items:
        lines += [" " + line for line in _lines(item, indents, width - 1)]
    lines[0] = "(" + lines[0][1:]
    lines[-1] += ")"
    return lines
