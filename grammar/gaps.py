"""What stands between two datums of a text: comments in rows, at the end of a line, on a datum's line, empty lines."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from scenelang.grammar.datum import Datum
from scenelang.grammar.trivia import Hidden, Row

_DIRECTIVE = re.compile(r";+\s*fmt:\s*(off|on|skip)\s*")


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment at ``start`` to ``end`` of its text. ``hidden``: the datum that a `#;` hides, if it can be laid out."""

    text: str
    start: int
    end: int
    hidden: Datum | None = None

    @property
    def has_lines(self) -> bool:
        return "\n" in self.text

    @property
    def is_line(self) -> bool:
        return self.text[0] == ";"

    @property
    def exact(self) -> str:
        """The text without what may go: blanks at the end of a line."""
        return self.text.rstrip() if self.is_line else self.text

    @property
    def directive(self) -> str | None:
        """``off``, ``on`` or ``skip`` for a comment that talks to the formatter."""
        match = _DIRECTIVE.fullmatch(self.text) if self.is_line else None
        return match[1] if match else None


@dataclass(frozen=True, slots=True)
class Gap:
    """Comments between what ends at ``start`` and what begins at ``end``. ``note``: on the line that ends there.
    ``rows``: on lines of their own. ``lead``: just before what follows. ``blank``: whether an empty line stands before
    the rows."""

    note: tuple[Comment, ...] = ()
    rows: tuple[Row, ...] = ()
    lead: tuple[Comment, ...] = ()
    blank: bool = False


_CLOSE, _BLANK = Gap(), Gap(blank=True)


def gap_of(text: str, start: int, end: int, comments: Sequence[Comment], *, note: bool, lead: bool) -> Gap:
    """Sort the comments of a gap. ``note``: something stands on the line before them; ``lead``: comments may share a
    line with what follows them, or, before a closing bracket, with what is before."""
    if not comments:
        return _BLANK if text.count("\n", start, end) > 1 else _CLOSE
    breaks = _breaks(text, start, end, comments)
    last = len(comments)
    while lead and last and not breaks[last] and not comments[last - 1].has_lines:
        last -= 1
    first = 0
    while note and first < last and not breaks[first] and not _wants_lines(comments[first]):
        first += 1
    rows = _rows(comments[first:last], breaks[first : last + 1])
    return Gap(tuple(comments[:first]), rows, tuple(comments[last:]), breaks[first] > 1)


def _breaks(text: str, start: int, end: int, comments: Sequence[Comment]) -> list[int]:
    """The line ends before each comment, and after the last one."""
    edges = [start, *(edge for comment in comments for edge in (comment.start, comment.end)), end]
    return [text.count("\n", a, b) for a, b in zip(edges[::2], edges[1::2])]


def _wants_lines(comment: Comment) -> bool:
    """Whether a comment is a hidden datum of several lines, which never ends another's line."""
    return comment.hidden is not None and comment.has_lines


def _rows(comments: Sequence[Comment], breaks: Sequence[int]) -> tuple[Row, ...]:
    """Comments as rows, with None for empty lines between and after them. ``breaks``: one more than comments."""
    rows: list[Row] = []
    row: list[Comment] = []
    for comment, following in zip(comments, breaks[1:]):
        row.append(comment)
        if following:
            rows += _joined(row)
            row = []
            if following > 1:
                rows.append(None)
    return (*rows, *_joined(row))


def _joined(row: Sequence[Comment]) -> list[Row]:
    """The comments of one line; a hidden datum of several lines, or alone, is laid out."""
    if len(row) == 1 or any(_wants_lines(comment) for comment in row):
        return [Hidden(comment.hidden) if comment.hidden is not None else comment.exact for comment in row]
    return [" ".join(comment.exact for comment in row)] if row else []
