"""Datums -> a program as a person writes it: over several lines, indented, with comments.

Every datum is first measured, bottom up and without recursion: what fits a line has its flat text from then on. Then
the lines are made from the top down. A datum that does not fit is written onto a page by the style of its shape
(``layout_rules``, ``layout_styles``); where there are several styles the first one that stays within the width is
taken. Blocks are remembered by datum and column, so that trying styles out stays cheap.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, ListDatum, subdatums
from scenelang.grammar.layout_rules import (
    SHORTEST,
    Role,
    Shape,
    head_of,
    roles_of_parts,
    shape_of,
    shapes_by_head,
    takes_lines,
)
from scenelang.grammar.layout_styles import last_resort, styles_of
from scenelang.grammar.printer import atom_text, print_datum, quote_prefix

_DEEPEST = 80  # below that a datum stands on one line, so that Python's stack is safe from nesting
_NOTE = "\0"  # stands before a comment at a line's end until all lines are known
_UNEVEN = 12  # comments of neighbouring lines are aligned when the lines differ by no more


@dataclass(frozen=True, slots=True)
class Trivia:
    """What stands around a datum besides datums. Lines of comments come wrapped, without ``; `` before them; among
    them None is an empty line."""

    before: tuple[str | None, ...] = ()  # comments above the datum; "" is an empty comment line
    after: str | None = None  # a comment at the end of the datum's last line
    blank: bool = False  # an empty line before the datum and its comments
    end: tuple[str | None, ...] = ()  # comments after a list's last item, before its closing parenthesis


_NO_TRIVIA: Mapping[int, Trivia] = MappingProxyType({})
_NO_SPELLING: Mapping[int, str] = MappingProxyType({})


def layout(
    forms: Sequence[Datum],
    *,
    indents: Mapping[str, int | None],
    trivia: Mapping[int, Trivia] = _NO_TRIVIA,
    spelling: Mapping[int, str] = _NO_SPELLING,
    width: int = 88,
    end: Sequence[str | None] = (),
) -> str:
    """The text of a program. ``indents``: operands on the head's line, by head; None: operands are aligned.

    ``trivia`` and ``spelling`` (the exact text of an atom) are keyed by ``id(datum)``. ``end``: comments after the
    last form. Comments are as long as they are; only datums are held to ``width``.
    """
    work = Layout(forms, shapes_by_head(indents), trivia, spelling, width)
    lines: list[str] = []
    was_long = False
    for position, form in enumerate(forms):
        around = trivia.get(id(form))
        block = work.block(form, 0, 0, 0)
        is_long = len(block.lines) > 1
        blank = around.blank if around is not None else is_long or was_long
        if blank and position:
            lines.append("")
        lines += block.lines if around is None else _with_trivia(block, around)
        if around is None and block.note:
            lines[-1] += _NOTE + block.note
        was_long = is_long
    lines += comment_lines(end, 0)
    return "\n".join(_with_notes(lines)) + "\n" if lines else ""


def _with_trivia(block: Block, around: Trivia) -> list[str]:
    """The lines of a top-level form with its comments."""
    lines = [*comment_lines(around.before, 0), *block.lines]
    note = joined_notes(block.note, around.after)
    if note:
        lines[-1] += _NOTE + note
    return lines


def comment_lines(texts: Iterable[str | None], indent: int) -> list[str]:
    """Comments on lines of their own."""
    return ["" if text is None else f"{' ' * indent}; {text}".rstrip() for text in texts]


def joined_notes(first: str, second: str | None) -> str:
    """Two comments for the end of one line."""
    if not first or not second:
        return first or second or ""
    return f"{first}; {second}"


def _with_notes(lines: Sequence[str]) -> list[str]:
    """Put the comments at the ends of lines, aligned where neighbouring lines have some."""
    out: list[str] = []
    group: list[tuple[str, str]] = []
    for line in lines:
        code, marked, note = line.partition(_NOTE)
        if group and (not marked or _indentation(code) != _indentation(group[-1][0])):
            out += _aligned_notes(group)
            group = []
        if marked:
            group.append((code, note))
        else:
            out.append(code)
    return out + _aligned_notes(group)


def _aligned_notes(group: Sequence[tuple[str, str]]) -> list[str]:
    lengths = [len(code) for code, _ in group]
    column = max(lengths, default=0)
    even = column - min(lengths, default=0) <= _UNEVEN
    return [f"{code.ljust(column) if even else code}  ; {note}" for code, note in group]


def _indentation(line: str) -> int:
    return len(line) - len(line.lstrip())


# --- measuring -----------------------------------------------------------------------------------------------------


class Block(NamedTuple):
    """A datum's lines. The first one goes where the datum stands, the others have their indentation.

    ``note``: comments for the end of the last line. ``excess``: by how much the longest line is too long.
    """

    lines: Sequence[str]
    note: str
    excess: int


class Layout:
    """What is known of the datums of one text: shapes, flat texts, and the blocks made so far."""

    def __init__(
        self,
        forms: Sequence[Datum],
        shapes: Mapping[str, Shape],
        trivia: Mapping[int, Trivia],
        spelling: Mapping[int, str],
        width: int,
    ) -> None:
        self.by_head, self.trivia, self.spelling, self.width = shapes, trivia, spelling, width
        self.shapes: dict[int, Shape] = {}
        self.flat: dict[int, str] = {}  # the text of every datum that one line has room for
        self.notes: dict[int, str] = {}  # the comments that follow a flat text
        self._blocks: dict[tuple[int, int, int], Block] = {}
        self._measure(forms)

    def _measure(self, forms: Sequence[Datum]) -> None:
        """Shapes from the top down, then flat texts from the bottom up."""
        flat, shapes, by_head, spelling = self.flat, self.shapes, self.by_head, self.spelling
        compounds: list[tuple[ListDatum | ArrayDatum, Sequence[Datum], bool]] = []
        stack: list[tuple[Datum, Role]] = [(form, Role.TOP) for form in forms]
        while stack:
            datum, role = stack.pop()
            key = id(datum)
            if isinstance(datum, Atom):
                flat[key] = spelling.get(key) or atom_text(datum.value)
                continue
            shape = shapes[key] = shape_of(datum, role, by_head)
            parts = parts_of(datum)
            compounds.append((datum, parts, takes_lines(datum, shape, role)))
            stack += zip(parts, roles_of_parts(datum, shape, parts))
        for datum, parts, broken in reversed(compounds):
            if broken or (self.trivia and not self._joins(datum, parts)):
                continue
            text = self._flat_text(datum, parts)
            if text is not None and len(text) <= self.width:
                flat[id(datum)] = text

    def _flat_text(self, datum: ListDatum | ArrayDatum, parts: Sequence[Datum]) -> str | None:
        flat = self.flat
        texts = []
        for part in parts:
            text = flat.get(id(part))
            if text is None:
                return None
            texts.append(text)
        prefix = self.prefix(datum)
        if prefix is not None:
            return prefix + texts[1]
        if isinstance(datum, ArrayDatum):
            return "[" + " ".join(texts) + "]"
        if datum.tail is not None:
            texts.insert(-1, ".")
        return "(" + " ".join(texts) + ")"

    def _joins(self, datum: ListDatum | ArrayDatum, parts: Sequence[Datum]) -> bool:
        """Whether comments and empty lines let the parts of ``datum`` share a line; notes the comments after it."""
        around = self.trivia.get(id(datum))
        if around is not None and around.end:
            return False
        note = ""
        for part in parts:
            if note:
                return False  # a comment ends the line before this part
            note = self.notes.get(id(part), "")
            around = self.trivia.get(id(part))
            if around is not None:
                if around.before or around.blank:
                    return False
                note = joined_notes(note, around.after)
        if note:
            self.notes[id(datum)] = note
        return True

    def prefix(self, datum: ListDatum | ArrayDatum) -> str | None:
        """The prefix that ``datum`` is written with, such as ``'``, where no comment forbids it."""
        prefix = quote_prefix(datum)
        if prefix is None or not self.trivia:
            return prefix
        head, operand = (self.trivia.get(id(part)) for part in datum.items)
        own = self.trivia.get(id(datum))
        if head or (operand is not None and (operand.before or operand.blank)) or (own is not None and own.end):
            return None
        return prefix

    # --- making blocks -------------------------------------------------------------------------------------------

    def block(self, datum: Datum, column: int, trailing: int, depth: int) -> Block:
        """The lines of ``datum`` at ``column``, with ``trailing`` characters to come on its last line."""
        text = self.flat.get(id(datum))
        if text is not None:
            excess = column + len(text) + trailing - self.width
            if excess <= 0 or isinstance(datum, Atom):
                return Block((text,), self.notes.get(id(datum), ""), excess)
        key = (id(datum), column, trailing)
        block = self._blocks.get(key)
        if block is None:
            assert not isinstance(datum, Atom)  # atoms have a flat text
            block = self._blocks[key] = self._new_block(datum, column, trailing, depth)
        return block

    def _new_block(self, datum: ListDatum | ArrayDatum, column: int, trailing: int, depth: int) -> Block:
        if depth >= _DEEPEST:
            return self._one_line(datum)
        prefix = self.prefix(datum)
        if prefix is not None:
            return self._prefixed(prefix, datum.items[1], column, trailing, depth)
        shape = self.shapes[id(datum)]
        styles = styles_of(shape) if column < self.width else (last_resort,)
        shortest = shape.kind in SHORTEST
        best: Block | None = None
        for style in styles:
            page = Page(self, datum, shape, column, trailing, depth)
            if not style(page):
                continue
            block = page.finished()
            if best is None or self._is_better(block, best, shortest):
                best = block
            if best.excess <= 0 and (not shortest or len(best.lines) == 2):
                break
        assert best is not None  # the last style of every shape takes any datum
        return best

    @staticmethod
    def _is_better(block: Block, than: Block, shortest: bool) -> bool:
        """Whether to prefer the block of a later style."""
        excess, other = max(block.excess, 0), max(than.excess, 0)
        return excess < other or (excess == other and shortest and len(block.lines) <= len(than.lines))

    def _one_line(self, datum: Datum) -> Block:
        """``datum`` on one line whatever its length, its comments behind it."""
        note = ""
        if self.trivia:
            for comment in _comments_within(datum, self.trivia):
                note = joined_notes(note, comment)
        text = self.flat.get(id(datum))
        if text is None:
            text = self.flat[id(datum)] = print_datum(datum, self.spelling)
        self.notes[id(datum)] = note
        return Block((text,), note, 0)

    def _prefixed(self, prefix: str, operand: Datum, column: int, trailing: int, depth: int) -> Block:
        inner = self.block(operand, column + len(prefix), trailing, depth + 1)
        around = self.trivia.get(id(operand))
        note = joined_notes(inner.note, around.after if around is not None else None)
        return Block((prefix + inner.lines[0], *inner.lines[1:]), note, inner.excess)


def parts_of(datum: ListDatum | ArrayDatum) -> Sequence[Datum]:
    """The items of a datum, and its tail."""
    if isinstance(datum, ListDatum) and datum.tail is not None:
        return (*datum.items, datum.tail)
    return datum.items


def _comments_within(datum: Datum, trivia: Mapping[int, Trivia]) -> list[str]:
    """The comments inside ``datum``, its ``end`` included, in order."""
    found: list[str | None] = []
    stack: list[Datum | tuple[str | None, ...]] = [datum]
    while stack:
        item = stack.pop()
        if isinstance(item, tuple):
            found += item
            continue
        around = trivia.get(id(item)) or Trivia()
        if item is not datum:
            found += around.before
            stack.append((around.after,))
        stack.append(around.end)
        stack += reversed(list(subdatums(item)))
    return [text for text in found if text]


# --- a list being written -------------------------------------------------------------------------------------------


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
        self._note = ""
        self._excess = 0

    @property
    def head(self) -> str | None:
        return head_of(self.datum)

    @property
    def broken(self) -> bool:
        """Whether there is more than one line so far."""
        return bool(self._lines)

    def kind_shape(self, position: int) -> Shape | None:
        """The shape of a part; None for an atom."""
        return self.work.shapes.get(id(self.parts[position]))

    def flat_width(self, position: int) -> int | None:
        """How wide a part is on one line, what must follow it included; None where it takes several lines."""
        text = self.work.flat.get(id(self.parts[position]))
        if text is None:
            return None
        return len(text) + self._trailing(position) + (2 if position >= self._tail else 0)

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
        if fresh or self._note or (around is not None and (around.before or around.blank)):
            self._new_line(indent, around)
        elif position:
            self._write(" ")
        if position >= self._tail:
            self._write(". ")
        self._place(work.block(datum, self.column, self._trailing(position), self.depth + 1))
        if around is not None:
            self._note = joined_notes(self._note, around.after)

    def finished(self) -> Block:
        """Close the list."""
        if self._around is not None and self._around.end:
            self._end_line()
            self._lines += comment_lines(self._around.end, self._indent)
            self._start_line(self.start)
        self._write("]" if isinstance(self.datum, ArrayDatum) else ")")
        self._excess = max(self._excess, self.column + self.trailing - self.width)
        return Block((*self._lines, self._line), self._note, self._excess)

    def _write(self, text: str) -> None:
        self._line += text
        self.column += len(text)

    def _place(self, block: Block) -> None:
        lines = block.lines
        self._write(lines[0])
        if len(lines) > 1:
            self._lines.append(self._line)
            self._lines += lines[1:-1]
            self._line = lines[-1]
            self.column = len(self._line)
        self._excess = max(self._excess, block.excess)
        self._note = block.note

    def _new_line(self, indent: int, around: Trivia | None) -> None:
        self._end_line()
        if around is not None:
            if around.blank:
                self._lines.append("")
            self._lines += comment_lines(around.before, indent)
        self._indent = indent
        self._start_line(indent)

    def _end_line(self) -> None:
        self._excess = max(self._excess, self.column - self.width)
        self._lines.append(self._line + _NOTE + self._note if self._note else self._line)

    def _start_line(self, indent: int) -> None:
        self._line = " " * indent
        self.column = indent
        self._note = ""
