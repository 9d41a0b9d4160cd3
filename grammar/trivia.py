"""What stands around datums in a text besides datums: comments, empty lines, and how an author wrote them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, TypeAlias

NOTE = "\0"  # stands before a comment at a line's end until all lines are known
# control characters, line and paragraph separators, marks of direction, halves of surrogate pairs
_UNSEEN = re.compile(r"[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]")
_UNEVEN = 12  # comments of neighbouring lines are aligned when the lines differ by no more


@dataclass(frozen=True, slots=True, eq=False)
class Hidden:
    """A datum that `#;` hides, laid out like any other."""

    datum: Any


Row: TypeAlias = str | Hidden | None  # a line of comments, exactly as it is; None is an empty line


@dataclass(frozen=True, slots=True)
class Trivia:
    """What stands around a datum besides datums. Comments are exact texts, such as ``; why``."""

    before: tuple[Row, ...] = ()  # comments above the datum
    after: str | None = None  # a comment at the end of the datum's last line
    blank: bool = False  # an empty line before the datum and its comments
    end: tuple[Row, ...] = ()  # comments after a list's last item, before its closing parenthesis
    opening: str | None = None  # a comment behind a list's opening parenthesis that ends the line
    closing: str | None = None  # a comment behind a list's last item that ends the line
    lead: str = ""  # comments on the datum's line just before it, and a space
    trail: str = ""  # a space, and comments on the datum's line just after it


@dataclass(frozen=True, slots=True)
class Written:
    """How an author wrote datums, by ``id(datum)``. ``breaks``: for each part of a list whether it begins on a new
    line; lists on one line are left out. ``plain``: lists such as ``(quote x)`` that are no ``'x``. ``raw``: atoms
    that are lines of text as they are, and whether they end with a comment."""

    breaks: Mapping[int, Sequence[bool]] = field(default_factory=dict)
    plain: Set[int] = frozenset()
    raw: Mapping[int, bool] = field(default_factory=dict)


NO_TRIVIA: Mapping[int, Trivia] = MappingProxyType({})
NOTHING_WRITTEN = Written()


def line_comment(text: str) -> str:
    """A comment of one line that says ``text``. What may end a line somewhere, or cannot be seen, becomes a space."""
    return "; {}".format(_UNSEEN.sub(" ", text)).rstrip()


def joined_notes(first: str, second: str | None) -> str:
    """Two comments for the end of one line."""
    return first + second if first and second else first or second or ""


def with_notes(lines: Iterable[str]) -> list[str]:
    """Put the comments at the ends of lines, aligned where neighbouring lines have some."""
    out: list[str] = []
    group: list[tuple[str, str]] = []
    for line in lines:
        code, marked, note = line.partition(NOTE)
        if group and (not marked or _indentation(code) != _indentation(group[-1][0])):
            out += _aligned(group)
            group = []
        if marked:
            group.append((code, note))
        else:
            out.append(code)
    return out + _aligned(group)


def _aligned(group: Sequence[tuple[str, str]]) -> list[str]:
    lengths = [len(code) - code.rfind("\n") - 1 for code, _ in group]  # a string may hold line ends
    column = max(lengths, default=0)
    even = column - min(lengths, default=0) <= _UNEVEN
    return [f"{code}{' ' * (column - length if even else 0)}  {note}" for (code, note), length in zip(group, lengths)]


def _indentation(line: str) -> int:
    return len(line) - len(line.lstrip(" "))
