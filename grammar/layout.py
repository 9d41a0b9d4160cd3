"""Datums -> a program as a person writes it: over several lines, indented, with comments.

Every datum is first measured, bottom up and without recursion: what fits a line has its flat text from then on. Then
the lines are made from the top down. A datum that does not fit is written onto a page by the style of its shape
(``layout_rules``, ``layout_styles``); where there are several styles the first one that stays within the width is
taken. Blocks are remembered by datum and column, so that trying styles out stays cheap.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, ListDatum, subdatums
from scenelang.grammar.layout_page import Block, Page
from scenelang.grammar.layout_rules import (
    SHORTEST,
    Kind,
    Role,
    Shape,
    has_rows,
    parts_of,
    roles_of_parts,
    shape_of,
    shapes_by_head,
    stays_broken,
    takes_lines,
)
from scenelang.grammar.layout_styles import last_resort, styles_of
from scenelang.grammar.printer import atom_text, print_datum, quote_prefix
from scenelang.grammar.trivia import (
    NO_TRIVIA,
    NOTE,
    NOTHING_WRITTEN,
    Hidden,
    Row,
    Trivia,
    Written,
    joined_notes,
    with_notes,
)

DEEPEST = 80  # below that a datum stands on one line, so that Python's stack is safe from nesting
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
    """The text of a program. ``indents``: operands on the head's line, by head; None: operands are aligned.

    ``trivia`` and ``spelling`` (the exact text of an atom) are keyed by ``id(datum)``. ``end``: comments after the
    last form. Comments are as long as they are; only datums are held to ``width``.
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
    written: Written = NOTHING_WRITTEN,
) -> list[str]:
    """The lines of a program, as ``layout`` joins them. A line holds line ends where a string or a comment does.

    ``written``: how an author wrote the datums; some line breaks that have a meaning are kept.
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
        if blank and position:
            lines.append("")
        lines += _with_trivia(work, block, around)
        was_long, was_weighty = is_long, is_weighty
    lines += work.comment_lines(end, 0, 0)
    return with_notes(lines)


def _with_trivia(work: Layout, block: Block, around: Trivia | None) -> list[str]:
    """The lines of a top-level form with its comments."""
    before = work.comment_lines(around.before, 0, 0) if around is not None else []
    lines = [*before, *block.lines]
    note = joined_notes(block.note, around.after if around is not None else None)
    if note:
        lines[-1] += NOTE + note
    return lines


def hidden_datums(rows: Iterable[Row]) -> list[Datum]:
    return [row.datum for row in rows if isinstance(row, Hidden)]


# --- measuring -----------------------------------------------------------------------------------------------------


class Layout:
    """What is known of the datums of one text: shapes, flat texts, and the blocks made so far."""

    def __init__(
        self,
        forms: Sequence[Datum],
        shapes: Mapping[str, Shape],
        trivia: Mapping[int, Trivia],
        spelling: Mapping[int, str],
        width: int,
        written: Written = NOTHING_WRITTEN,
    ) -> None:
        self.by_head, self.trivia, self.spelling, self.width = shapes, trivia, spelling, width
        self.written = written
        self.shapes: dict[int, Shape] = {}
        self.rows: set[int] = set()  # lists whose every item their author put on a line of its own
        self.flat: dict[int, str] = {}  # the text of every datum that one line has room for
        self.notes: dict[int, str] = {}  # the comments that follow a flat text
        self._blocks: dict[tuple[int, int, int], Block] = {}
        self._measure(forms)

    def _measure(self, forms: Sequence[Datum]) -> None:
        """Shapes from the top down, then flat texts from the bottom up."""
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

    def _was_broken(self, datum: ListDatum | ArrayDatum, shape: Shape, parts: Sequence[Datum]) -> bool:
        """Whether the author's line breaks in ``datum`` are kept; notes lists of rows."""
        breaks = self.written.breaks.get(id(datum))
        if breaks is None:
            return False
        if has_rows(datum, shape, parts, breaks):
            self.rows.add(id(datum))
            return True
        return stays_broken(datum, shape, parts, breaks)

    def defines_value(self, form: Datum) -> bool:
        """Whether a form of a file defines a value, not a function: such lines may stand close together."""
        if isinstance(form, Atom):
            return True
        is_definition = self.shapes[id(form)].kind is Kind.DEFINE and len(form.items) > 1
        return is_definition and isinstance(form.items[1], Atom)

    def _flat_text(self, datum: ListDatum | ArrayDatum, parts: Sequence[Datum]) -> str | None:
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
        """Whether comments and empty lines let the parts of ``datum`` share a line; notes the comments after it."""
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
        """The prefix that ``datum`` is written with, such as ``'``, where no comment forbids it."""
        prefix = quote_prefix(datum) if id(datum) not in self.written.plain else None
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
            if "\n" in text:  # lines of a string or of a comment stay as they are
                excess = column + text.index("\n") - self.width
            if excess <= 0 or isinstance(datum, Atom):
                return Block((text,), self.notes.get(id(datum), ""), excess)
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
                block = Block((around.lead + lines[0], *lines[1:]), inner.note, inner.excess)
            self._blocks[key] = block
        return block

    def _new_block(self, datum: ListDatum | ArrayDatum, column: int, trailing: int, depth: int) -> Block:
        if depth >= DEEPEST:
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
            text = self.flat[id(datum)] = print_datum(datum, self.spelling, self.written.plain)
        self.notes[id(datum)] = note
        return Block((text,), note, 0)

    def comment_lines(self, rows: Iterable[Row], indent: int, depth: int) -> list[str]:
        """Comments on lines of their own."""
        lines: list[str] = []
        for row in rows:
            if isinstance(row, Hidden):
                block = self.block(row.datum, indent + 2, 0, depth + 1)
                lines += (f"{' ' * indent}#;{block.lines[0]}", *block.lines[1:])
            else:
                lines.append(f"{' ' * indent}{row}" if row else "")
        return lines

    def _prefixed(self, prefix: str, operand: Datum, column: int, trailing: int, depth: int) -> Block:
        inner = self.block(operand, column + len(prefix), trailing, depth + 1)
        around = self.trivia.get(id(operand))
        note = joined_notes(inner.note, around.after if around is not None else None)
        return Block((prefix + inner.lines[0], *inner.lines[1:]), note, inner.excess)


def _comments_within(datum: Datum, trivia: Mapping[int, Trivia]) -> list[str]:
    """The comments inside ``datum``, its ``end`` included, in order."""
    found: list[Row] = []
    stack: list[Datum | tuple[Row, ...]] = [datum]
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
    return [text for text in found if isinstance(text, str) and text]
