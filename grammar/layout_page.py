"""A list or array being written part by part."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from scenelang.grammar.datum import ArrayDatum, Atom, ListDatum
from scenelang.grammar.layout_rules import Shape, head_of, parts_of
from scenelang.grammar.trivia import NOTE, Trivia, joined_notes

if TYPE_CHECKING:
    from scenelang.grammar.layout import Layout


class Block(NamedTuple):
    """A datum's lines. The first one goes where the datum stands, the others have their indentation.

    ``note``: comments for the end of the last line. ``excess``: by how much the longest line is too long.
    """

    lines: Sequence[str]
    note: str
    excess: int


class Page:
    """A list or array being written part by part. Styles decide where the parts go; the page minds comments."""

    def __init__(
        self, work: Layout, datum: ListDatum | ArrayDatum, shape: Shape, column: int, trailing: int, depth: int
    ) -> None:
        self.work, self.datum, self.shape = work, datum, shape
        self.parts = parts_of(datum)
        self.start, self.trailing, self.depth = column, trailing, depth
        self.column = column + 1
        self.width = work.width
        self._tail = len(datum.items)  # where a dotted tail stands among the parts
        self._around = work.trivia.get(id(datum))
        self._line = "[" if isinstance(datum, ArrayDatum) else "("
        self._lines: list[str] = []
        self._indent = column + (1 if self.head is None else 2)  # of the last line begun
        self._note = self._around.opening or "" if self._around is not None else ""
        self._raw: bool | None = None  # after lines taken as they are: whether they end with a comment
        self._excess = 0

    @property
    def head(self) -> str | None:
        return head_of(self.datum)

    @property
    def broken(self) -> bool:
        """Whether there is more than one line so far."""
        return bool(self._lines)

    @property
    def breaks(self) -> Sequence[bool] | None:
        """For each part whether its author put it on a new line; None where all was on one line."""
        return self.work.written.breaks.get(id(self.datum))

    @property
    def has_rows(self) -> bool:
        """Whether the author put every item on a line of its own."""
        return id(self.datum) in self.work.rows

    def kind_shape(self, position: int) -> Shape | None:
        """The shape of a part; None for an atom."""
        return self.work.shapes.get(id(self.parts[position]))

    def flat_width(self, position: int) -> int | None:
        """How wide a part is on one line, what must follow it included; None where it takes several lines."""
        text = self.work.flat.get(id(self.parts[position]))
        if text is None or "\n" in text:
            return None
        return len(text) + self._trailing(position) + (2 if position >= self._tail else 0)

    def holds_lines(self, position: int) -> bool:
        """Whether a part is a string of several lines."""
        part = self.parts[position]
        is_raw = id(part) in self.work.written.raw
        return isinstance(part, Atom) and not is_raw and self.flat_width(position) is None

    def fits(self, position: int, column: int) -> bool:
        """Whether a part fits on one line from ``column`` on."""
        width = self.flat_width(position)
        return width is not None and column + width <= self.width

    def _trailing(self, position: int) -> int:
        return self.trailing + 1 if position == len(self.parts) - 1 else 0

    def item(self, position: int, indent: int, fresh: bool = False) -> None:
        """Write a part: after a space, or, where ``fresh`` or a comment asks for it, on a new line at ``indent``."""
        work = self.work
        datum = self.parts[position]
        around = work.trivia.get(id(datum)) if work.trivia else None
        raw = work.written.raw.get(id(datum)) if work.written.raw else None
        wants = around is not None and (around.before or around.blank)
        if fresh or self._note or wants or raw is not None or self._raw is not None:
            self._new_line(indent, around)
            self._raw = raw
        elif position:
            self._write(" ")
        if position >= self._tail:
            self._write(". ")
        if raw is not None:
            self._start_line(0)
        self._place(work.block(datum, self.column, self._trailing(position), self.depth + 1))
        if around is not None:
            self._note = joined_notes(self._note, around.after)

    def finished(self) -> Block:
        """Close the list."""
        around = self._around
        if around is not None and around.closing:
            self._note = joined_notes(self._note, around.closing)
        if self._raw or (around is not None and (around.end or around.closing)):
            self._end_line()
            self._lines += self.work.comment_lines(around.end if around is not None else (), self._indent, self.depth)
            self._start_line(self.start)
        self._write("]" if isinstance(self.datum, ArrayDatum) else ")")
        self._excess = max(self._excess, self.column + self.trailing - self.width)
        return Block((*self._lines, self._line), self._note, self._excess)

    def _write(self, text: str) -> None:
        self._line += text
        if "\n" in text:
            self.column = len(text) - text.rfind("\n") - 1
        else:
            self.column += len(text)

    def _place(self, block: Block) -> None:
        lines = block.lines
        self._write(lines[0])
        if len(lines) > 1:
            self._lines.append(self._line)
            self._lines += lines[1:-1]
            self._line = lines[-1]
            self.column = len(self._line) - self._line.rfind("\n") - 1
        self._excess = max(self._excess, block.excess)
        self._note = block.note

    def _new_line(self, indent: int, around: Trivia | None) -> None:
        self._end_line()
        if around is not None:
            if around.blank:
                self._lines.append("")
            self._lines += self.work.comment_lines(around.before, indent, self.depth)
        self._indent = indent
        self._start_line(indent)

    def _end_line(self) -> None:
        self._excess = max(self._excess, self.column - self.width)
        self._lines.append(self._line + NOTE + self._note if self._note else self._line)

    def _start_line(self, indent: int) -> None:
        self._line = " " * indent
        self.column = indent
        self._note = ""
