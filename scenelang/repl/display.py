"""How the REPL shows values: never more than a dozen lines, whatever the value; no control characters."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from typing import Any

from scenelang.grammar.codes import CODES
from scenelang.grammar.diagnostics import SceneError, printable
from scenelang.interpreter.entity import Entity, Frames, Scene
from scenelang.interpreter.library import Builtin
from scenelang.interpreter.procedures import Closure, Condition
from scenelang.interpreter.show import show
from scenelang.interpreter.values import (
    Array,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Procedure,
    Set,
    Table,
    Vector,
)
from scenelang.repl.short_tree import parts_tree, tree_lines

MOST_LINES = 12
_MOST_ROWS, _MOST_COLUMNS = 10, 10
_COUNTED = 100_000  # longer chains of pairs are not counted


def displayed(value: Any, width: int = 80) -> str:
    """The text for a value, at most ``MOST_LINES`` lines of at most ``width`` columns; empty for none."""
    lines = [clean(line) for line in _lines(value, max(width, 20))]
    if len(lines) > MOST_LINES:
        lines = [*lines[: MOST_LINES - 1], f"... {len(lines) - MOST_LINES + 1:,} more lines"]
    return "\n".join(line if len(line) <= width else line[: width - 3] + "..." for line in lines)


def clean(text: str) -> str:
    """A line without characters that a terminal would act on."""
    return printable(text).replace("\n", "\\xa;")


def _lines(value: Any, width: int) -> Sequence[str]:
    if value is None:
        return []
    kind = type(value)
    if kind is Entity or kind is Scene or kind is Frames:
        return tree_lines(value, MOST_LINES)
    if kind is Matrix:
        return aligned([value[0:4], value[4:8], value[8:12], (0.0, 0.0, 0.0, 1.0)])
    if kind is Array or kind is MutableArray:
        return _array_lines(value.data, width)
    if kind is Vector:
        return _row(value[: _most_items(width)], len(value), width)
    if kind is Table:
        return _table_lines(value, width)
    if kind is Condition:
        return error_lines(value.error)
    if isinstance(value, Procedure):
        return [signature_of(value)]
    if (kind is Pair or kind is MutableList) and (lines := parts_tree(value, MOST_LINES)):
        return lines
    return _text_lines(value, width)


def _text_lines(value: Any, width: int) -> Sequence[str]:
    """Whatever has no form of its own: as text, cut, with its length when it is cut."""
    limit = width * 4
    text = show(value, limit)
    if len(text) < limit:
        return _wrapped(text, width)
    return [*_wrapped(text, width), f"({_length(value)})"] if _length(value) else _wrapped(text, width)


def _length(value: Any) -> str:
    if type(value) is str:
        return f"{len(value):,} characters"
    if type(value) is MutableList:
        return f"{len(value.items):,} items"
    if type(value) is Set:
        return f"{len(value.entries):,} members"
    if type(value) is int:
        return f"{len(str(abs(value))):,} digits"
    count = 0
    while type(value) is Pair:
        value, count = value.cdr, count + 1
        if count >= _COUNTED * 100:
            return f"more than {count:,} items"
    return f"{count:,} items" if count else ""


def _wrapped(text: str, width: int) -> list[str]:
    return textwrap.wrap(clean(text), width, subsequent_indent=" ", drop_whitespace=True) or [""]


def _most_items(width: int) -> int:
    return width // 2


def _row(shown: Sequence[Any], count: int, width: int) -> Sequence[str]:
    """The first items of a vector of ``count``."""
    return _wrapped("[" + " ".join(map(_number, shown)) + _rest(count, width) + "]", width)


def _rest(count: int, width: int) -> str:
    return f" ... {count - _most_items(width):,} more" if count > _most_items(width) else ""


def _number(x: Any) -> str:
    if isinstance(x, (bool, int)) or not isinstance(x, float):
        return str(x)
    text = f"{x:.6g}"
    return text if any(c in text for c in ".en") else text + ".0"


def aligned(rows: Iterable[Sequence[Any]]) -> list[str]:
    """Rows of numbers in columns, with four significant digits."""
    cells = [[_short(x) for x in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    lines = ["[" + " ".join(c.rjust(w) for c, w in zip(row, widths)) + "]" for row in cells]
    return [("[" if i == 0 else " ") + line + ("]" if i == len(lines) - 1 else "") for i, line in enumerate(lines)]


def _short(x: Any) -> str:
    number = float(x)
    if abs(number) < 1e-12:
        return "0"
    return f"{number:.4g}"


def _array_lines(data: Any, width: int) -> Sequence[str]:
    if data.ndim == 1:
        return _row(data[: _most_items(width)].tolist(), len(data), width)
    if data.ndim != 2 or not data.size:
        shape = " x ".join(map(str, data.shape))
        return [f"array of {shape}", *(_text_lines(data.tolist(), width) if data.size < 50 else ())]
    columns = min(data.shape[1], _MOST_COLUMNS)
    lines = aligned(data[:_MOST_ROWS, :columns].tolist())
    if data.shape[0] > _MOST_ROWS or data.shape[1] > columns:
        lines.append(f"... {data.shape[0]:,} x {data.shape[1]:,}")
    return lines


def _table_lines(table: Table, width: int) -> list[str]:
    entries = list(table.entries.values())
    if not entries:
        return ["(table)"]
    shown = [(show(key, 30), show(value, width)) for key, value in entries[: MOST_LINES - 2]]
    across = max(len(key) for key, _ in shown)
    lines = [f"table of {len(entries):,}:", *(f"  {key.ljust(across)}  {value}" for key, value in shown)]
    return [*lines, f"  ... {len(entries) - len(shown):,} more"] if len(entries) > len(shown) else lines


def signature_of(function: Procedure) -> str:
    """A function as it is called."""
    if isinstance(function, Builtin):
        return f"function {function.usage}"
    if type(function) is Closure:
        usage = function.code.usage
        inner = usage[1:-1] if usage.startswith("(") and usage.endswith(")") else usage
        named = inner if inner.split(" ")[0] == function.code.name else f"{function.code.name} {inner}".rstrip()
        return f"function ({named})"
    return show(function)


def error_lines(error: SceneError) -> list[str]:
    """An error as a value: code, message, place."""
    lines = [f"error {CODES[error.name].code}: {error.message}"]
    if error.span is not None:
        line, column = error.span.source.position(error.span.start)
        lines.append(f"  at {error.span.source.name}:{line}:{column}")
    return lines
