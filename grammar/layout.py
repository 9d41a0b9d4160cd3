"""Pretty printer: lay datums out over indented lines, with comments, as a person would write them.

First every datum is measured, bottom-up and without recursion; a datum that fits on one line has a flat text from then
on. Then the lines are produced top-down: a datum that does not fit is written onto a page by one of the styles for its
shape (``layout_styles``). If a shape has several styles, the first one within the line width is used. Blocks are
memoized by datum and column, which keeps trying out several styles cheap.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, ListDatum, atom_text, print_datum, quote_prefix, subdatums
from scenelang.grammar.layout_styles import (
    SHORTEST,
    HeadKind,
    HeadShape,
    Role,
    has_rows,
    head_of,
    last_resort,
    parts_of,
    roles_of_parts,
    shape_of,
    shapes_by_head,
    stays_broken,
    styles_of,
    takes_lines,
)
from scenelang.grammar.lazy_patterns import lazy_pattern

# The text around datums: comments, empty lines, and the author's line breaks.

NOTE = "\0"  # separates code from an end-of-line comment until all lines are known and can be aligned
# control characters, line and paragraph separators, bidirectional marks, surrogates
_UNSEEN = lazy_pattern(r"[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]")
_MAX_UNEVENNESS = 12  # columns; aligned further apart, a comment is hard to assign to its line


@dataclass(frozen=True, slots=True, eq=False)
class Hidden:
    """Datum commented out with `#;`, which is laid out like any other."""

    datum: Any


Row: TypeAlias = str | Hidden | None  # a line of comments, verbatim; None is an empty line


@dataclass(frozen=True, slots=True)
class Trivia:
    """Comments and empty lines around a datum. Comments are verbatim texts, such as ``; why``."""

    before: tuple[Row, ...] = ()  # comments above the datum
    after: str | None = None  # a comment at the end of the datum's last line
    blank: bool = False  # an empty line before the datum and its comments
    end: tuple[Row, ...] = ()  # comments after a list's last item, before its closing parenthesis
    opening: str | None = None  # an end-of-line comment after a list's opening parenthesis
    closing: str | None = None  # an end-of-line comment after a list's last item
    lead: str = ""  # comments before the datum on its line, followed by a space
    trail: str = ""  # a space followed by comments after the datum on its line


@dataclass(frozen=True, slots=True)
class AuthorLayout:
    """The author's original layout of datums, by ``id(datum)``.

    Attributes
    ----------
    breaks
        For each part of a list, whether it starts a new line; lists on one line are omitted.
    plain
        Lists such as ``(quote x)`` that were not written as ``'x``.
    raw
        Atoms that consist of verbatim lines of text, and whether they end with a comment.
    """

    breaks: Mapping[int, Sequence[bool]] = field(default_factory=dict)
    plain: Set[int] = frozenset()
    raw: Mapping[int, bool] = field(default_factory=dict)


NO_TRIVIA: Mapping[int, Trivia] = MappingProxyType({})
NO_AUTHOR_LAYOUT = AuthorLayout()


def line_comment(text: str) -> str:
    """Return ``text`` as a line comment; line separators and invisible characters are replaced by spaces."""
    return "; {}".format(_UNSEEN.sub(" ", text)).rstrip()


def joined_notes(first: str, second: str | None) -> str:
    """Join two end-of-line comments."""
    return first + second if first and second else first or second or ""


def with_notes(lines: Iterable[str]) -> list[str]:
    """Append the end-of-line comments to their lines, aligned across adjacent lines of equal indentation."""
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
    """Join lines of code with their comments, in one column unless the lengths differ too much."""
    lengths = [len(code) - code.rfind("\n") - 1 for code, _ in group]  # a string may contain line breaks
    column = max(lengths, default=0)
    even = column - min(lengths, default=0) <= _MAX_UNEVENNESS
    return [f"{code}{' ' * (column - length if even else 0)}  {note}" for (code, note), length in zip(group, lengths)]


def _indentation(line: str) -> int:
    """Return the number of spaces at the beginning of a line."""
    return len(line) - len(line.lstrip(" "))


# Pages, on which a list or array is written part by part.


class ListPage(NamedTuple):
    """Lines of a laid-out datum. The first line starts at the datum's column; the others include their indentation.

    ``note`` is the end-of-line comment of the last line, ``excess`` the number of columns by which the longest line
    exceeds the width.
    """

    lines: Sequence[str]
    note: str
    excess: int


class Page:
    """List or array being written part by part. Styles decide on the positions; the page handles comments."""

    def __init__(
        self, work: Layout, datum: ListDatum | ArrayDatum, shape: HeadShape, column: int, trailing: int, depth: int
    ) -> None:
        """Begin a page at ``column``; ``trailing`` is the number of brackets that follow on the last line."""
        self.work, self.datum, self.shape = work, datum, shape
        self.parts = parts_of(datum)
        self.start, self.trailing, self.depth = column, trailing, depth
        self.column = column + 1
        self.width = work.width
        self._tail = len(datum.items)  # position of a dotted tail among the parts
        self._around = work.trivia.get(id(datum))
        self._line = "[" if isinstance(datum, ArrayDatum) else "("
        self._lines: list[str] = []
        self._indent = column + (1 if self.head is None else 2)  # of the line started last
        self._note = self._around.opening or "" if self._around is not None else ""
        self._raw: bool | None = None  # after verbatim lines: whether they end with a comment
        self._excess = 0

    @property
    def head(self) -> str | None:
        """Symbol at the head of the list, or None."""
        return head_of(self.datum)

    @property
    def broken(self) -> bool:
        """Whether there is more than one line so far."""
        return bool(self._lines)

    @property
    def breaks(self) -> Sequence[bool] | None:
        """For each part, whether the author started a new line with it; None if the list was on one line."""
        return self.work.written.breaks.get(id(self.datum))

    @property
    def has_rows(self) -> bool:
        """Whether the author put every item on a separate line."""
        return id(self.datum) in self.work.rows

    def kind_shape(self, position: int) -> HeadShape | None:
        """Return the shape of a part, or None for an atom."""
        return self.work.shapes.get(id(self.parts[position]))

    def flat_width(self, position: int) -> int | None:
        """Return the width of a part on one line including closing brackets, or None if it takes several lines."""
        text = self.work.flat.get(id(self.parts[position]))
        if text is None or "\n" in text:
            return None
        return len(text) + self._trailing(position) + (2 if position >= self._tail else 0)

    def holds_lines(self, position: int) -> bool:
        """Return whether a part is a string of several lines."""
        part = self.parts[position]
        is_raw = id(part) in self.work.written.raw
        return isinstance(part, Atom) and not is_raw and self.flat_width(position) is None

    def fits(self, position: int, column: int) -> bool:
        """Return whether a part fits on one line starting at ``column``."""
        width = self.flat_width(position)
        return width is not None and column + width <= self.width

    def _trailing(self, position: int) -> int:
        """Return the number of closing brackets behind a part."""
        return self.trailing + 1 if position == len(self.parts) - 1 else 0

    def item(self, position: int, indent: int, *, fresh: bool = False) -> None:
        """Write a part after a space, or on a new line at ``indent`` if ``fresh`` is set or a comment requires it."""
        work = self.work
        datum = self.parts[position]
        around = work.trivia.get(id(datum)) if work.trivia else None
        raw = work.written.raw.get(id(datum)) if work.written.raw else None
        needs_line = around is not None and (around.before or around.blank)
        if fresh or self._note or needs_line or raw is not None or self._raw is not None:
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

    def finished(self) -> ListPage:
        """Close the list and return its lines."""
        around = self._around
        if around is not None and around.closing:
            self._note = joined_notes(self._note, around.closing)
        if self._raw or (around is not None and (around.end or around.closing)):
            # A comment ends the last line, so the bracket needs one of its own.
            self._end_line()
            self._lines += self.work.comment_lines(around.end if around is not None else (), self._indent, self.depth)
            self._start_line(self.start)
        self._write("]" if isinstance(self.datum, ArrayDatum) else ")")
        self._excess = max(self._excess, self.column + self.trailing - self.width)
        return ListPage((*self._lines, self._line), self._note, self._excess)

    def _write(self, text: str) -> None:
        """Append text to the current line; a string may contain line breaks."""
        self._line += text
        if "\n" in text:
            self.column = len(text) - text.rfind("\n") - 1
        else:
            self.column += len(text)

    def _place(self, block: ListPage) -> None:
        """Append the lines of a laid-out part."""
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
        """Start a line for a part, after the comments above it."""
        self._end_line()
        if around is not None:
            if around.blank:
                self._lines.append("")
            self._lines += self.work.comment_lines(around.before, indent, self.depth)
        self._indent = indent
        self._start_line(indent)

    def _end_line(self) -> None:
        """Finish the current line with its end-of-line comment."""
        self._excess = max(self._excess, self.column - self.width)
        self._lines.append(self._line + NOTE + self._note if self._note else self._line)

    def _start_line(self, indent: int) -> None:
        """Begin a line that consists of indentation."""
        self._line = " " * indent
        self.column = indent
        self._note = ""


MAX_DEPTH = 80  # levels; nested deeper, a datum is written on one line, which bounds Python's recursion
_NO_SPELLING: Mapping[int, str] = MappingProxyType({})


def layout(
    forms: Sequence[Datum],
    *,
    indents: Mapping[str, int | None],
    trivia: Mapping[int, Trivia] = NO_TRIVIA,
    spelling: Mapping[int, str] = _NO_SPELLING,
    width: int = 88,
    end: Sequence[Row] = (),
) -> str:
    """Lay out a program and return its text.

    Parameters
    ----------
    forms
        Top-level forms.
    indents
        Number of operands on the line of the head, by head; None aligns the operands.
    trivia
        Comments and empty lines, by ``id(datum)``.
    spelling
        Exact text of atoms, by ``id(datum)``.
    width
        Maximum line width of datums. Comments are never wrapped.
    end
        Comments after the last form.
    """
    lines = layout_lines(forms, indents=indents, trivia=trivia, spelling=spelling, width=width, end=end)
    return "\n".join(lines) + "\n" if lines else ""


def layout_lines(
    forms: Sequence[Datum],
    *,
    indents: Mapping[str, int | None],
    trivia: Mapping[int, Trivia] = NO_TRIVIA,
    spelling: Mapping[int, str] = _NO_SPELLING,
    width: int = 88,
    end: Sequence[Row] = (),
    written: AuthorLayout = NO_AUTHOR_LAYOUT,
) -> list[str]:
    """Lay out a program and return its lines.

    A line contains line breaks if a string or comment in it does.

    Parameters
    ----------
    forms, indents, trivia, spelling, width, end
        As for ``layout``.
    written
        The author's line breaks; those with a meaning, such as between the rows of tabular data, are preserved.
    """
    work = Layout([*forms, *hidden_datums(end)], shapes_by_head(indents), trivia, spelling, width, written)
    lines: list[str] = []
    was_long = was_weighty = False
    for position, form in enumerate(forms):
        around = trivia.get(id(form))
        block = work.block(form, 0, 0, 0)
        is_long = len(block.lines) > 1
        is_weighty = is_long and not work.defines_value(form)
        if around is None:
            blank = is_long or was_long
        else:
            blank = around.blank or ((is_weighty or was_weighty) and None not in around.before)
        is_after_raw = position and id(forms[position - 1]) in work.written.raw  # an empty line would be part of it
        if blank and position and not is_after_raw:
            lines.append("")
        lines += _with_trivia(work, block, around)
        was_long, was_weighty = is_long, is_weighty
    lines += work.comment_lines(end, 0, 0)
    return with_notes(lines)


def _with_trivia(work: Layout, block: ListPage, around: Trivia | None) -> list[str]:
    """Return the lines of a top-level form with its comments."""
    before = work.comment_lines(around.before, 0, 0) if around is not None else []
    lines = [*before, *block.lines]
    note = joined_notes(block.note, around.after if around is not None else None)
    if note:
        lines[-1] += NOTE + note
    return lines


def hidden_datums(rows: Iterable[Row]) -> list[Datum]:
    """Return the datums that are commented out with `#;` among rows of comments."""
    return [row.datum for row in rows if isinstance(row, Hidden)]


# --- measuring -----------------------------------------------------------------------------------------------------


class Layout:
    """Layout of one text: the shapes and flat texts of its datums, and the memoized blocks."""

    def __init__(
        self,
        forms: Sequence[Datum],
        shapes: Mapping[str, HeadShape],
        trivia: Mapping[int, Trivia],
        spelling: Mapping[int, str],
        width: int,
        written: AuthorLayout = NO_AUTHOR_LAYOUT,
    ) -> None:
        """Measure all forms for lines of at most ``width`` columns; see ``layout_lines`` for the arguments."""
        self.by_head, self.trivia, self.spelling, self.width = shapes, trivia, spelling, width
        self.written = written
        self.shapes: dict[int, HeadShape] = {}
        self.rows: set[int] = set()  # lists whose author put every item on a separate line
        self.flat: dict[int, str] = {}  # text of every datum that fits on one line
        self.notes: dict[int, str] = {}  # end-of-line comment that follows a flat text
        self._blocks: dict[tuple[int, int, int], ListPage] = {}
        self._measure(forms)

    def _measure(self, forms: Sequence[Datum]) -> None:
        """Compute the shapes top-down, then the flat texts bottom-up."""
        flat, shapes, by_head, trivia = self.flat, self.shapes, self.by_head, self.trivia
        compounds: list[tuple[ListDatum | ArrayDatum, Sequence[Datum], bool]] = []
        stack: list[tuple[Datum, Role]] = [(form, Role.TOP) for form in forms]
        while stack:
            datum, role = stack.pop()
            key = id(datum)
            around = trivia.get(key) if trivia else None
            if around is not None:
                stack += [(hidden, Role.CODE) for hidden in hidden_datums((*around.before, *around.end))]
            if isinstance(datum, Atom):
                text = self.spelling.get(key) or atom_text(datum.value)
                flat[key] = text if around is None else f"{around.lead}{text}{around.trail}"
                continue
            shape = shapes[key] = shape_of(datum, role, by_head)
            parts = parts_of(datum)
            broken = takes_lines(datum, shape, role) or self._was_broken(datum, shape, parts)
            compounds.append((datum, parts, broken))
            stack += zip(parts, roles_of_parts(datum, shape, parts))
        for datum, parts, broken in reversed(compounds):
            if broken or (trivia and not self._joins(datum, parts)):
                continue
            joined = self._flat_text(datum, parts)
            if joined is not None and len(joined) <= self.width:
                flat[id(datum)] = joined

    def _was_broken(self, datum: ListDatum | ArrayDatum, shape: HeadShape, parts: Sequence[Datum]) -> bool:
        """Return whether the author's line breaks in ``datum`` are preserved; also record lists of rows."""
        breaks = self.written.breaks.get(id(datum))
        if breaks is None:
            return False
        if has_rows(datum, shape, parts, breaks):
            self.rows.add(id(datum))
            return True
        return stays_broken(datum, shape, parts, breaks)

    def defines_value(self, form: Datum) -> bool:
        """Return whether a top-level form defines a value rather than a function; such forms need no blank lines."""
        if isinstance(form, Atom):
            return True
        is_definition = self.shapes[id(form)].kind is HeadKind.DEFINE and len(form.items) > 1
        return is_definition and isinstance(form.items[1], Atom)

    def _flat_text(self, datum: ListDatum | ArrayDatum, parts: Sequence[Datum]) -> str | None:
        """Return the text of a list on one line, or None if a part of it takes several."""
        flat = self.flat
        texts = []
        for part in parts:
            text = flat.get(id(part))
            if text is None or "\n" in text:
                return None
            texts.append(text)
        prefix = self.prefix(datum)
        if prefix is not None:
            text = prefix + texts[1]
        elif isinstance(datum, ArrayDatum):
            text = "[" + " ".join(texts) + "]"
        else:
            if datum.tail is not None:
                texts.insert(-1, ".")
            text = "(" + " ".join(texts) + ")"
        around = self.trivia.get(id(datum)) if self.trivia else None
        return text if around is None else f"{around.lead}{text}{around.trail}"

    def _joins(self, datum: ListDatum | ArrayDatum, parts: Sequence[Datum]) -> bool:
        """Return whether comments and empty lines allow the parts of ``datum`` to share a line.

        Also record the end-of-line comment after ``datum``.
        """
        around = self.trivia.get(id(datum))
        if around is not None and (around.end or around.opening or around.closing):
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
        """Return the prefix of ``datum``, such as ``'``, unless a comment prevents its use."""
        prefix = quote_prefix(datum) if id(datum) not in self.written.plain else None
        if prefix is None or not self.trivia:
            return prefix
        head, operand = (self.trivia.get(id(part)) for part in datum.items)
        around = self.trivia.get(id(datum))
        if head or (operand is not None and (operand.before or operand.blank)) or (around is not None and around.end):
            return None
        return prefix

    # --- making blocks -------------------------------------------------------------------------------------------

    def block(self, datum: Datum, column: int, trailing: int, depth: int) -> ListPage:
        """Return the lines of ``datum`` at ``column``, with ``trailing`` characters reserved on its last line."""
        text = self.flat.get(id(datum))
        if text is not None:
            excess = column + len(text) + trailing - self.width
            if "\n" in text:  # lines of a string or comment cannot be changed
                excess = column + text.index("\n") - self.width
            if excess <= 0 or isinstance(datum, Atom):
                return ListPage((text,), self.notes.get(id(datum), ""), excess)
        key = (id(datum), column, trailing)
        block = self._blocks.get(key)
        if block is None:
            assert not isinstance(datum, Atom)  # atoms have a flat text
            around = self.trivia.get(id(datum)) if self.trivia else None
            if around is None or not (around.lead or around.trail):
                block = self._new_block(datum, column, trailing, depth)
            else:
                inner = self._new_block(datum, column + len(around.lead), trailing + len(around.trail), depth)
                *most, last = inner.lines
                lines = (*most, last + around.trail)
                block = ListPage((around.lead + lines[0], *lines[1:]), inner.note, inner.excess)
            self._blocks[key] = block
        return block

    def _new_block(self, datum: ListDatum | ArrayDatum, column: int, trailing: int, depth: int) -> ListPage:
        """Return the lines of a list by the first style that stays within the width, or that exceeds it least."""
        if depth >= MAX_DEPTH:
            return self._one_line(datum)
        prefix = self.prefix(datum)
        if prefix is not None:
            return self._prefixed(prefix, datum.items[1], column, trailing, depth)
        shape = self.shapes[id(datum)]
        styles = styles_of(shape) if column < self.width else (last_resort,)
        prefers_short = shape.kind in SHORTEST
        best: ListPage | None = None
        for style in styles:
            page = Page(self, datum, shape, column, trailing, depth)
            if not style(page):
                continue
            block = page.finished()
            if best is None or self._is_better(block, best, prefers_short=prefers_short):
                best = block
            if best.excess <= 0 and (not prefers_short or len(best.lines) == 2):
                break  # no later style can be better
        assert best is not None  # the last style of every shape accepts any datum
        return best

    @staticmethod
    def _is_better(block: ListPage, than: ListPage, *, prefers_short: bool) -> bool:
        """Return whether ``block``, made by a later style, is better than ``than``."""
        excess, other = max(block.excess, 0), max(than.excess, 0)
        return excess < other or (excess == other and prefers_short and len(block.lines) <= len(than.lines))

    def _one_line(self, datum: Datum) -> ListPage:
        """Write ``datum`` on one line regardless of its length, followed by its comments."""
        note = ""
        if self.trivia:
            for comment in _comments_within(datum, self.trivia):
                note = joined_notes(note, comment)
        text = self.flat.get(id(datum))
        if text is None:
            text = self.flat[id(datum)] = print_datum(datum, self.spelling, self.written.plain)
        self.notes[id(datum)] = note
        return ListPage((text,), note, 0)

    def comment_lines(self, rows: Iterable[Row], indent: int, depth: int) -> list[str]:
        """Return the lines of comments that are not at the end of a line of code.

        Parameters
        ----------
        rows
            Comments and empty lines.
        indent
            Column in which they begin.
        depth
            Number of open lists around them.
        """
        lines: list[str] = []
        for row in rows:
            if isinstance(row, Hidden):
                block = self.block(row.datum, indent + 2, 0, depth + 1)
                lines += (f"{' ' * indent}#;{block.lines[0]}", *block.lines[1:])
            else:
                lines.append(f"{' ' * indent}{row}" if row else "")
        return lines

    def _prefixed(self, prefix: str, operand: Datum, column: int, trailing: int, depth: int) -> ListPage:
        """Return the lines of a prefix and its operand, such as ``'x``."""
        inner = self.block(operand, column + len(prefix), trailing, depth + 1)
        around = self.trivia.get(id(operand))
        note = joined_notes(inner.note, around.after if around is not None else None)
        return ListPage((prefix + inner.lines[0], *inner.lines[1:]), note, inner.excess)


def _comments_within(datum: Datum, trivia: Mapping[int, Trivia]) -> list[str]:
    """Return the comments inside ``datum`` in order, including those before its closing bracket."""
    rows: list[Row] = []
    stack: list[Datum | tuple[Row, ...]] = [datum]
    while stack:
        item = stack.pop()
        if isinstance(item, tuple):
            rows += item
            continue
        around = trivia.get(id(item)) or Trivia()
        if item is not datum:
            rows += around.before
            stack.append((around.after,))
        stack.append(around.end)
        stack += reversed(list(subdatums(item)))
    return [text for text in rows if isinstance(text, str) and text]
