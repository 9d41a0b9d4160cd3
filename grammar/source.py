"""Source files and places in them. Spans are offsets; line and column are worked out only when somebody asks."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple


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
