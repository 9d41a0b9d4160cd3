"""What a tool answers: text for people and models, data for programs, a picture. All of it is bounded in size, and
holds no character that a terminal would act on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from scenelang.grammar.diagnostics import Diagnostic, printable, render_text, to_json

MOST_ITEMS = 100  # of a list of changes, of lines that a program printed
_MOST_DIAGNOSTICS = 20
_MOST_INSIDE = 10  # items of a list inside an item
_LONGEST_TEXT = 20_000  # characters
_LONGEST_STRING = 500


@dataclass(frozen=True, slots=True)
class Answer:
    """``data`` is None where a picture says everything; ``png`` is that picture."""

    text: str
    data: dict[str, Any] | None = None
    png: bytes | None = None


def answer(lines: Iterable[str], data: dict[str, Any]) -> Answer:
    """Text and data, cut to a size that a model can take."""
    return Answer(bounded_text(lines), bounded(data))


def bounded_text(lines: Iterable[str]) -> str:
    """The lines as one text; what is left out of it is counted."""
    text = printable("\n".join(lines))
    if len(text) <= _LONGEST_TEXT:
        return text
    return f"{text[:_LONGEST_TEXT]}\n... and {len(text) - _LONGEST_TEXT:,} characters more"


def bounded(data: dict[str, Any], most: int = MOST_ITEMS) -> dict[str, Any]:
    """Plain data with short lists and strings. Beside a list that was cut, ``NAME_left_out`` counts what is missing."""
    found: dict[str, Any] = {}
    for name, value in data.items():
        found[printable(name)] = _bounded(value, most)
        if isinstance(value, list) and len(value) > most:
            found[f"{name}_left_out"] = len(value) - most
    return found


def _bounded(value: Any, most: int) -> Any:
    if isinstance(value, str):
        return clipped(value)
    if isinstance(value, dict):
        return bounded(value, min(most, _MOST_INSIDE))
    if isinstance(value, list):
        return [_bounded(item, min(most, _MOST_INSIDE)) for item in value[:most]]
    return value


def clipped(text: str) -> str:
    """A string that is not too long, without control characters."""
    shown = printable(text[:_LONGEST_STRING])
    left = len(text) - _LONGEST_STRING
    return shown if left <= 0 else f"{shown}... and {left:,} characters more"


# --- diagnostics and logs ------------------------------------------------------------------------------------------


def diagnosed(diagnostics: Sequence[Diagnostic]) -> tuple[list[str], dict[str, Any]]:
    """Diagnostics as lines and as data, errors first; the first few of them, and how many more there are."""
    ordered = sorted(diagnostics, key=lambda diagnostic: not diagnostic.is_error)
    shown = ordered[:_MOST_DIAGNOSTICS]
    left = len(ordered) - len(shown)
    lines = [render_text(diagnostic) for diagnostic in shown] + ([f"... and {left:,} more"] if left else [])
    data: dict[str, Any] = {"diagnostics": [to_json(diagnostic) for diagnostic in shown]}
    return lines, data | ({"diagnostics_left_out": left} if left else {})


def printed(log: Sequence[str]) -> tuple[list[str], dict[str, Any]]:
    """What a program printed, as lines and as data."""
    left = len(log) - MOST_ITEMS
    lines = [clipped(line) for line in log[:MOST_ITEMS]] + ([f"... and {left:,} lines more"] if left > 0 else [])
    return ["printed:", *lines] if log else [], {"log": list(log)}


def refused(diagnostics: Sequence[Diagnostic], log: Sequence[str] = ()) -> Answer:
    """The answer about a program that is wrong."""
    lines, data = diagnosed(diagnostics)
    said, more = printed(log)
    return answer([*lines, *said], {"ok": False, **data, **(more if log else {})})
