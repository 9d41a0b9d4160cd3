"""Concrete syntax tree: datums with their comments, empty lines, spelling and line breaks, for the formatter.

The tree differs from the reader's where a formatter requires it: `(a . (b))` remains a pair, `(quote x)` is
distinguished from `'x`, and text that must not change (`; fmt: off`, `; fmt: skip`, comments in odd places) is one
verbatim atom.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import NamedTuple

from scenelang.grammar.datum import PREFIXES, ArrayDatum, Atom, Datum, ListDatum, Source, Span, Symbol
from scenelang.grammar.layout import MAX_DEPTH, AuthorLayout, Hidden, Row, Trivia
from scenelang.grammar.layout_styles import head_of, is_keyword
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.grammar.reader import atom_value, block_comments, terminals, without_comments

# Tokenizing a text: tokens and comments, that is, everything except white space.

LINE_COMMENT = "LINE_COMMENT"
BLOCK_COMMENT = "BLOCK_COMMENT"


class Token(NamedTuple):
    """Token. ``kind`` is a terminal of ``reader.lark`` or a kind of comment; ``text`` is ``source[start:end]``."""

    kind: str
    text: str
    start: int
    end: int


@cache
def _terminals() -> re.Pattern[str]:
    """Return a pattern with the grammar's terminals as named groups."""
    return re.compile("|".join(f"(?P<{name}>{pattern})" for name, pattern in terminals()))


def tokens(text: str) -> Iterator[Token]:
    """Iterate over the tokens and comments of a valid text, in order."""
    places = block_comments(text)  # blanked out for the pattern and merged back by their offsets
    position, upcoming = 0, 0
    for match in _terminals().finditer(without_comments(text, places)):
        start, end = match.span()
        kind = str(match.lastgroup)
        if kind.startswith("__"):
            if text[start] != ";":
                continue  # white space
            kind = LINE_COMMENT
        while upcoming < len(places) and places[upcoming][0] < start:
            if places[upcoming][0] >= position:
                yield _block(text, *places[upcoming])
            upcoming += 1
        yield Token(kind, text[start:end], start, end)
        position = end
    for place in places[upcoming:]:
        if place[0] >= position:
            yield _block(text, *place)


def _block(text: str, start: int, end: int) -> Token:
    """Return a block comment or `#;` as a token."""
    return Token(BLOCK_COMMENT, text[start:end], start, end)


def essence(text: str) -> list[tuple[str, str]]:
    """Return everything that formatting must preserve: the kinds and texts of all tokens and comments.

    Trailing blanks of line comments are ignored.
    """
    return essence_of(tokens(text))


def essence_of(tokens: Iterable[Token]) -> list[tuple[str, str]]:
    """Return ``essence`` of the tokens of a text."""
    return [(t.kind, t.text.rstrip() if t.kind == LINE_COMMENT else t.text) for t in tokens]


# Gaps between two datums: comments on separate lines, at the end of a line or beside a datum, and empty lines.


_DIRECTIVE = lazy_pattern(r";+\s*fmt:\s*(off|on|skip)\s*")


@dataclass(frozen=True, slots=True)
class Comment:
    """Comment at the offsets ``start`` to ``end``.

    ``hidden`` is the datum commented out by a `#;`, if it can be laid out.
    """

    text: str
    start: int
    end: int
    hidden: Datum | None = None

    @property
    def has_lines(self) -> bool:
        """Whether the comment spans several lines."""
        return "\n" in self.text

    @property
    def is_line(self) -> bool:
        """Whether this is a line comment, which ends with its line."""
        return self.text[0] == ";"

    @property
    def exact(self) -> str:
        """Text of the comment without trailing blanks."""
        return self.text.rstrip() if self.is_line else self.text

    @property
    def directive(self) -> str | None:
        """Formatter directive of the comment, ``off``, ``on`` or ``skip``, or None."""
        match = _DIRECTIVE.fullmatch(self.text) if self.is_line else None
        return match[1] if match else None


@dataclass(frozen=True, slots=True)
class Gap:
    """Comments between two datums.

    Attributes
    ----------
    note
        Comments at the end of the line of the previous datum.
    rows
        Comments on separate lines.
    lead
        Comments just before the next datum, on its line.
    blank
        Whether an empty line precedes the rows.
    """

    note: tuple[Comment, ...] = ()
    rows: tuple[Row, ...] = ()
    lead: tuple[Comment, ...] = ()
    blank: bool = False


_CLOSE, _BLANK = Gap(), Gap(blank=True)


def gap_of(text: str, start: int, end: int, comments: Sequence[Comment], *, note: bool, lead: bool) -> Gap:
    """Classify the comments of the gap between two datums.

    Parameters
    ----------
    text
        Source text.
    start, end
        Offsets of the gap.
    comments
        Its comments, in order.
    note
        Whether the previous datum can have end-of-line comments.
    lead
        Whether the next datum can have comments before it on its line or, before a closing bracket, the previous datum
        comments after it.
    """
    if not comments:
        return _BLANK if text.count("\n", start, end) > 1 else _CLOSE
    breaks = _breaks(text, start, end, comments)
    last = len(comments)
    while lead and last and not breaks[last] and not comments[last - 1].has_lines:
        last -= 1
    first = 0
    while note and first < last and not breaks[first] and not _needs_lines(comments[first]):
        first += 1
    rows = _rows(comments[first:last], breaks[first : last + 1])
    return Gap(tuple(comments[:first]), rows, tuple(comments[last:]), breaks[first] > 1)


def _breaks(text: str, start: int, end: int, comments: Sequence[Comment]) -> list[int]:
    """Count the line breaks before each comment and after the last one."""
    edges = [start, *(edge for comment in comments for edge in (comment.start, comment.end)), end]
    return [text.count("\n", a, b) for a, b in zip(edges[::2], edges[1::2])]


def _needs_lines(comment: Comment) -> bool:
    """Return whether a comment is a hidden datum of several lines, which must start on a separate line."""
    return comment.hidden is not None and comment.has_lines


def _rows(comments: Sequence[Comment], breaks: Sequence[int]) -> tuple[Row, ...]:
    """Return comments as rows, with None for empty lines between and after them.

    ``breaks`` has one more element than ``comments``.
    """
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
    """Join the comments of one line; a hidden datum is laid out if it is alone or has several lines."""
    if len(row) == 1 or any(_needs_lines(comment) for comment in row):
        return [Hidden(comment.hidden) if comment.hidden is not None else comment.exact for comment in row]
    return [" ".join(comment.exact for comment in row)] if row else []


# Lists with comments that are nested more deeply stay verbatim: from ``MAX_DEPTH`` on the layout writes one line, in
# which a line comment would swallow the code behind it.
_MAX_DEPTH = MAX_DEPTH - 4
_TOP, _PREFIX, _HIDING = "TOP", "PREFIX", "DATUM_COMMENT"
_QUOTES = frozenset(PREFIXES.values())
_PLAIN = Trivia()


@dataclass(frozen=True, slots=True)
class Concrete:
    """Concrete syntax tree of a valid text.

    Attributes
    ----------
    forms
        Top-level forms.
    trivia, spelling
        Comments around datums and exact texts of atoms, by ``id(datum)``.
    written
        The author's line breaks.
    end
        Comments after the last form.
    places
        Start and end offset of each form including its comments, followed by those of the comments after the last form.
    replaced
        Datums in verbatim text, kept so that no later datum has the id of one of them, and with it its spelling.
    """

    forms: tuple[Datum, ...]
    trivia: dict[int, Trivia]
    spelling: dict[int, str]
    written: AuthorLayout
    end: tuple[Row, ...]
    places: tuple[tuple[int, int], ...]
    replaced: tuple[Datum, ...] = ()


def concrete(source: Source, known: Iterable[Token] | None = None) -> Concrete:
    """Build the concrete syntax tree of a valid text.

    Parameters
    ----------
    source
        Text that the reader accepts.
    known
        Its tokens, if the caller has them already.
    """
    return _Builder(source).build(tokens(source.text) if known is None else known)


@dataclass(slots=True)
class _Item:
    """Item of a list being read; ``first`` and ``last`` are its start and end including comments."""

    datum: Datum
    start: int
    end: int
    first: int
    last: int
    trivia: Trivia


@dataclass(slots=True)
class _Frame:
    """Stack frame of the builder: a list, a prefix or a `#;` being read, or the whole text."""

    kind: str
    start: int
    body: int  # offset where the contents begin
    text: str
    before: list[Comment]  # comments between the previous sibling and this one
    items: list[_Item] = field(default_factory=list)
    breaks: list[bool] = field(default_factory=list)
    comments: list[Comment] = field(default_factory=list)  # since the last item
    opening: str | None = None
    dotted: bool = False
    verbatim: bool = False  # whether it must stay verbatim
    has_comments: bool = False
    off: int | None = None  # offset of the start of a `fmt: off` region
    off_comments: list[Comment] = field(default_factory=list)
    reached: int = 0  # while `off`: the end of the last item or comment

    @property
    def end(self) -> int:
        """Offset behind the last item, or behind the opening bracket."""
        return self.items[-1].end if self.items else self.body

    @property
    def is_top(self) -> bool:
        """Whether the frame is the whole text."""
        return self.kind == _TOP

    @property
    def takes_one(self) -> bool:
        """Whether the frame is complete after one datum."""
        return self.kind == _PREFIX or self.kind == _HIDING


class _Builder:
    """Builds the tree from tokens with a stack of frames."""

    def __init__(self, source: Source) -> None:
        self.source, self.text = source, source.text
        self.trivia: dict[int, Trivia] = {}
        self.spelling: dict[int, str] = {}
        self.breaks: dict[int, Sequence[bool]] = {}
        self.plain: set[int] = set()
        self.raw: dict[int, bool] = {}
        self.replaced: list[Datum] = []  # keeps replaced datums alive, so that their ids are not reused
        self.stack = [_Frame(_TOP, 0, 0, "", [])]

    def build(self, tokens: Iterable[Token]) -> Concrete:
        """Read all tokens and return the tree of the whole text."""
        for token in tokens:
            self._take(token)
        (top,) = self.stack
        comments = top.comments  # after the last form, on its line or below
        end = self._close(top, len(self.text)).end
        self._record_trivia(top)
        places = [(item.first, item.last) for item in top.items]
        trailing = [comment for comment in comments if not places or comment.start >= places[-1][1]]
        if trailing:  # comments after the last form, or of a text without forms, are a place of their own
            places.append((trailing[0].start, trailing[-1].end))
        return Concrete(
            forms=tuple(item.datum for item in top.items),
            trivia=self.trivia,
            spelling=self.spelling,
            written=AuthorLayout(self.breaks, self.plain, self.raw),
            end=end,
            places=tuple(places),
            replaced=tuple(self.replaced),
        )

    def _take(self, token: Token) -> None:
        """Add a token to the innermost frame; a closing bracket ends the frame, an opening one or prefix begins one."""
        frame, kind = self.stack[-1], token.kind
        if kind == "ATOM" or kind == "STRING":
            datum = Atom(atom_value(token.text) if kind == "ATOM" else None, Span(self.source, token.start, token.end))
            self.spelling[id(datum)] = token.text
            comments, frame.comments = frame.comments, []
            self._finish(datum, token.start, token.end, comments)
        elif kind == "RPAR" or kind == "RSQB":
            self._end_list(self.stack.pop(), token.end)
        elif kind in (LINE_COMMENT, BLOCK_COMMENT):
            self._comment(frame, Comment(token.text, token.start, token.end))
        elif kind == "DOT":
            frame.dotted = True
            has_directive = frame.off is not None or any(comment.directive for comment in frame.comments)
            frame.verbatim = frame.verbatim or has_directive
        else:
            before, frame.comments = frame.comments, []
            self.stack.append(_Frame(kind, token.start, token.end, token.text, before))

    def _verbatim(self, start: int, end: int, text: str | None = None) -> Atom:
        """Return an atom spelled exactly like the source text."""
        datum = Atom(None, Span(self.source, start, end))
        self.spelling[id(datum)] = self.text[start:end] if text is None else text
        return datum

    # --- comments ------------------------------------------------------------------------------------------------

    @staticmethod
    def _comment(frame: _Frame, comment: Comment) -> None:
        """Add a comment to the gap; behind a prefix, `#;` or dot no layout can place it, so the form stays verbatim."""
        frame.has_comments = True
        frame.verbatim = frame.verbatim or frame.takes_one or frame.dotted
        frame.comments.append(comment)

    def _directives(self, frame: _Frame, comments: list[Comment]) -> list[Comment]:
        """Process `; fmt: off` and `; fmt: on` among the comments of a gap; return the remaining comments."""
        place = 0
        while place < len(comments):
            comment = comments[place]
            begins_line = comment.directive is not None and self._begins_line(comment.start)
            if frame.off is None and comment.directive == "off" and begins_line:
                frame.off, frame.off_comments = comment.end + 1, comments[: place + 1]
                frame.reached = comment.end
                comments, place = comments[place + 1 :], 0
                continue
            if frame.off is not None and comment.directive == "on" and begins_line:
                left = self._end_off(frame, self.text.rfind("\n", 0, comment.start), comments[:place])
                comments, place = [*left, *comments[place:]], len(left)
            place += 1
        if frame.off is None:
            return comments
        frame.reached = max([frame.reached, *(comment.end for comment in comments)])
        return []

    def _begins_line(self, place: int) -> bool:
        """Return whether only blanks precede an offset on its line."""
        return not self.text[self.text.rfind("\n", 0, place) + 1 : place].strip()

    def _end_off(self, frame: _Frame, end: int, inside: Sequence[Comment] = ()) -> list[Comment]:
        """Close a `fmt: off` region: its lines become one verbatim atom. Return the comments of an empty region."""
        assert frame.off is not None
        start, frame.off = frame.off, None
        text = self.text[start:end].removesuffix("\r")
        if not text.strip():
            return [*frame.off_comments, *inside]
        datum = self._verbatim(start, end, text)
        *_, last = tokens(text)
        self.raw[id(datum)] = last.kind == LINE_COMMENT
        self._place(frame, datum, start, end, frame.off_comments)
        return []

    # --- datums --------------------------------------------------------------------------------------------------

    def _finish(self, datum: Datum, start: int, end: int, comments: list[Comment]) -> None:
        """Add a datum to the enclosing frame; it completes a prefix or `#;`."""
        frame = self.stack[-1]
        while frame.takes_one:
            self.stack.pop()
            parent = self.stack[-1]
            verbatim = frame.verbatim or bool(comments)
            self.replaced.append(datum)
            if frame.kind == _HIDING:
                text = self.text[frame.start : end]
                parent.comments = frame.before
                self._comment(parent, Comment(text, frame.start, end, None if verbatim else datum))
                return
            parent.has_comments = parent.has_comments or frame.has_comments
            datum, start, comments = self._prefixed(frame, datum, end, verbatim=verbatim), frame.start, frame.before
            frame = parent
        if comments:
            comments = self._directives(frame, comments)
        if frame.off is None:
            self._place(frame, datum, start, end, comments)
        else:
            self.replaced.append(datum)
            frame.reached = end

    def _prefixed(self, frame: _Frame, operand: Datum, end: int, *, verbatim: bool) -> Datum:
        """Return the list of a prefix and its operand, such as `(quote x)` of `'x`."""
        if verbatim or (frame.has_comments and len(self.stack) >= _MAX_DEPTH):
            return self._verbatim(frame.start, end)
        text = self.spelling[id(operand)] if isinstance(operand, Atom) else ""
        if text.startswith("@"):  # `, @x` without its blank would read as `,@ x`
            return self._verbatim(frame.start, end, f"{frame.text} {text}")
        head = Atom(Symbol(PREFIXES[frame.text]), Span(self.source, frame.start, frame.body))
        self.spelling[id(head)] = head.value
        return ListDatum((head, operand), None, Span(self.source, frame.start, end))

    def _place(self, frame: _Frame, datum: Datum, start: int, end: int, comments: Sequence[Comment]) -> None:
        """Append a datum to its list with the comments before it."""
        begins = frame.is_top and not frame.items
        gap = gap_of(self.text, frame.end, start, comments, note=not begins, lead=not frame.dotted)
        frame.breaks.append("\n" in self.text[frame.end : start])
        if gap.note and frame.items:
            self._note(frame, gap)
        elif gap.note:
            frame.opening = _text_of(gap.note)
        remaining, trivia = comments[len(gap.note) :], _PLAIN
        if remaining or gap.blank:
            lead = "".join(f"{comment.exact} " for comment in gap.lead)
            trivia = Trivia(before=gap.rows, blank=gap.blank and self._may_be_blank(frame), lead=lead)
        frame.items.append(_Item(datum, start, end, remaining[0].start if remaining else start, end, trivia))

    @staticmethod
    def _may_be_blank(frame: _Frame) -> bool:
        """Return whether an empty line is allowed before the next item.

        It is not allowed before the first item, the first operand of a head or the value of a keyword.
        """
        items = frame.items
        if not items or frame.is_top:
            return bool(items)
        first = items[0].datum
        is_head = frame.kind == "LPAR" and isinstance(first, Atom) and type(first.value) is Symbol
        return len(items) > is_head and not is_keyword(items[-1].datum)

    def _note(self, frame: _Frame, gap: Gap) -> str:
        """Attach end-of-line comments to the last item; return their text."""
        item, text = frame.items[-1], _text_of(gap.note)
        if gap.note[-1].directive == "skip" and id(item.datum) not in self.raw:
            self.replaced.append(item.datum)
            item.datum = self._verbatim(item.start, item.end)
        item.trivia, item.last = replace(item.trivia, after=text), gap.note[-1].end
        return text

    # --- lists ---------------------------------------------------------------------------------------------------

    def _end_list(self, frame: _Frame, end: int) -> None:
        """Complete a list at its closing bracket and add it to the enclosing frame."""
        trivia = self._close(frame, end - 1)
        parent = self.stack[-1]
        parent.has_comments = parent.has_comments or frame.has_comments
        if frame.verbatim or (frame.has_comments and len(self.stack) >= _MAX_DEPTH):
            self.replaced += [item.datum for item in frame.items]
            self._finish(self._verbatim(frame.start, end), frame.start, end, frame.before)
            return
        self._record_trivia(frame)
        parts, span = tuple(item.datum for item in frame.items), Span(self.source, frame.start, end)
        datum: ListDatum | ArrayDatum
        if frame.kind == "LSQB":
            datum = ArrayDatum(parts, span)
        elif frame.dotted:
            datum = ListDatum(parts[:-1], parts[-1], span)
        else:
            datum = ListDatum(parts, None, span)
            if head_of(datum) in _QUOTES:
                self.plain.add(id(datum))
        if "\n" in self.text[frame.start : end]:
            self.breaks[id(datum)] = frame.breaks
        if trivia != _PLAIN:
            self.trivia[id(datum)] = trivia
        self._finish(datum, frame.start, end, frame.before)

    def _record_trivia(self, frame: _Frame) -> None:
        """Record the comments around the items of a list; those inside their brackets are recorded already."""
        for item in frame.items:
            inner, outer = self.trivia.get(id(item.datum)), item.trivia
            if inner is None and outer is _PLAIN and not frame.is_top:
                continue
            if inner is not None:
                outer = replace(outer, end=inner.end, opening=inner.opening, closing=inner.closing)
            if frame.is_top or outer != _PLAIN:
                self.trivia[id(item.datum)] = outer

    def _close(self, frame: _Frame, end: int) -> Trivia:
        """Return the comments inside a list's brackets after its last item and after its opening bracket."""
        comments = self._directives(frame, frame.comments)
        if frame.off is not None:
            comments = self._end_off(frame, frame.reached)
        has_items = bool(frame.items)
        inline = has_items and not frame.is_top and "\n" not in self.text[frame.end : end]
        gap = gap_of(self.text, frame.end, end, comments, note=has_items, lead=inline)
        rows = (None, *gap.rows) if gap.blank and gap.rows and has_items else gap.rows
        if rows and rows[-1] is None:
            rows = rows[:-1]
        closing = self._note(frame, gap) if gap.note else None
        if closing and not frame.is_top:
            frame.items[-1].trivia = replace(frame.items[-1].trivia, after=None)
        if gap.lead:
            item = frame.items[-1]
            item.trivia = replace(item.trivia, trail="".join(f" {comment.exact}" for comment in gap.lead))
        return Trivia(end=rows, closing=None if frame.is_top else closing, opening=frame.opening)


def _text_of(comments: Sequence[Comment]) -> str:
    """Join comments with blanks, without their trailing ones."""
    return " ".join(comment.exact for comment in comments)
