"""Text -> datums that know how they were written: comments, empty lines, spellings, line breaks.

The tree differs from the reader's where a formatter must: `(a . (b))` stays a pair, `(quote x)` is told from `'x`, and
what is to stay exactly as it is (`; fmt: off`, `; fmt: skip`, comments in odd places) is one atom spelled as in the
text.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from scenelang.grammar.datum import PREFIXES, ArrayDatum, Atom, Datum, ListDatum, Source, Span, Symbol
from scenelang.grammar.layout import DEEPEST, Hidden, Row, Trivia, Written
from scenelang.grammar.layout_styles import head_of, is_keyword
from scenelang.grammar.reader import atom_value, block_comments, terminals, without_comments

# Text -> tokens with the comments among them: all that a text holds but white space.


LINE_COMMENT = "LINE_COMMENT"
BLOCK_COMMENT = "BLOCK_COMMENT"


class Token(NamedTuple):
    """``kind``: a terminal of ``reader.lark``, or a kind of comment. ``text`` is ``source[start:end]``."""

    kind: str
    text: str
    start: int
    end: int


def tokens(text: str) -> Iterator[Token]:
    """The tokens and comments of a text that reads, in order."""
    places = block_comments(text)
    position, upcoming = 0, 0
    for match in terminals().finditer(without_comments(text, places)):
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
    return Token(BLOCK_COMMENT, text[start:end], start, end)


def essence(text: str) -> list[tuple[str, str]]:
    """What may never change when white space does: kinds and texts of tokens and comments, blanks at the end of a
    line's comment left aside."""
    return [(t.kind, t.text.rstrip() if t.kind == LINE_COMMENT else t.text) for t in tokens(text)]


# What stands between two datums of a text: comments in rows, at the end of a line, on a datum's line, empty lines.


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


_DEEPEST = DEEPEST - 4  # from there on lists with comments stay as they are: the layout writes one line
_TOP, _PREFIX, _HIDING = "TOP", "PREFIX", "DATUM_COMMENT"
_QUOTES = frozenset(PREFIXES.values())
_PLAIN = Trivia()


@dataclass(frozen=True, slots=True)
class Concrete:
    """A text that reads. ``trivia`` and ``spelling`` are keyed by ``id(datum)``; ``end``: rows after the last form.
    ``places``: the offsets where each form begins and ends, its comments included, and so the comments after the last
    form."""

    forms: tuple[Datum, ...]
    trivia: dict[int, Trivia]
    spelling: dict[int, str]
    written: Written
    end: tuple[Row, ...]
    places: tuple[tuple[int, int], ...]


def concrete(source: Source) -> Concrete:
    """The concrete tree of a text; the text must read without error."""
    return _Builder(source).build()


@dataclass(slots=True)
class _Item:
    """A datum of a list being read; ``first`` and ``last``: where it begins and ends with its comments."""

    datum: Datum
    start: int
    end: int
    first: int
    last: int
    trivia: Trivia


@dataclass(slots=True)
class _Frame:
    """A list, a prefix or a `#;` being read, or the text as a whole."""

    kind: str
    start: int
    body: int  # where what is inside begins
    text: str
    before: list[Comment]  # comments between the sibling before and this
    items: list[_Item] = field(default_factory=list)
    breaks: list[bool] = field(default_factory=list)
    comments: list[Comment] = field(default_factory=list)  # since the last item
    opening: str | None = None
    dotted: bool = False
    odd: bool = False  # to be left as it is
    has_comments: bool = False
    off: int | None = None  # since where the text stays as it is
    off_comments: list[Comment] = field(default_factory=list)
    reached: int = 0  # while `off`: the end of the last item or comment

    @property
    def end(self) -> int:
        return self.items[-1].end if self.items else self.body

    @property
    def is_top(self) -> bool:
        return self.kind == _TOP

    @property
    def takes_one(self) -> bool:
        """Whether a datum completes it."""
        return self.kind == _PREFIX or self.kind == _HIDING


class _Builder:
    """Reads tokens onto a stack of frames."""

    def __init__(self, source: Source) -> None:
        self.source, self.text = source, source.text
        self.trivia: dict[int, Trivia] = {}
        self.spelling: dict[int, str] = {}
        self.breaks: dict[int, Sequence[bool]] = {}
        self.plain: set[int] = set()
        self.raw: dict[int, bool] = {}
        self.replaced: list[Datum] = []  # kept alive, so that their ids stay theirs
        self.stack = [_Frame(_TOP, 0, 0, "", [])]

    def build(self) -> Concrete:
        for token in tokens(self.text):
            self._take(token)
        (top,) = self.stack
        comments = top.comments
        end = self._close(top, len(self.text)).end
        self._keep_trivia(top)
        forms = tuple(item.datum for item in top.items)
        places = [(item.first, item.last) for item in top.items]
        rest = [comment for comment in comments if not places or comment.start >= places[-1][1]]
        if rest:
            places.append((rest[0].start, rest[-1].end))
        return Concrete(
            forms, self.trivia, self.spelling, Written(self.breaks, self.plain, self.raw), end, tuple(places)
        )

    def _take(self, token: Token) -> None:
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
            frame.odd = frame.odd or any(comment.directive for comment in frame.comments) or frame.off is not None
        else:
            before, frame.comments = frame.comments, []
            self.stack.append(_Frame(kind, token.start, token.end, token.text, before))

    def _verbatim(self, start: int, end: int, text: str | None = None) -> Atom:
        """An atom that is spelled as the text is."""
        datum = Atom(None, Span(self.source, start, end))
        self.spelling[id(datum)] = self.text[start:end] if text is None else text
        return datum

    # --- comments ------------------------------------------------------------------------------------------------

    @staticmethod
    def _comment(frame: _Frame, comment: Comment) -> None:
        frame.has_comments = True
        frame.odd = frame.odd or frame.takes_one or frame.dotted
        frame.comments.append(comment)

    def _directives(self, frame: _Frame, comments: list[Comment]) -> list[Comment]:
        """Mind `; fmt: off` and `; fmt: on` among the comments of a gap; gives the comments that are left."""
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
        return not self.text[self.text.rfind("\n", 0, place) + 1 : place].strip()

    def _end_off(self, frame: _Frame, end: int, inside: Sequence[Comment] = ()) -> list[Comment]:
        """Close a region that stays as it is: its lines become one atom. Gives the comments of an empty region."""
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
        """Give a datum to the frame that it stands in; a prefix or `#;` is complete with it."""
        frame = self.stack[-1]
        while frame.takes_one:
            self.stack.pop()
            parent = self.stack[-1]
            odd = frame.odd or bool(comments)
            self.replaced.append(datum)
            if frame.kind == _HIDING:
                text = self.text[frame.start : end]
                parent.comments = frame.before
                self._comment(parent, Comment(text, frame.start, end, None if odd else datum))
                return
            parent.has_comments = parent.has_comments or frame.has_comments
            datum, start, comments = self._prefixed(frame, datum, end, odd), frame.start, frame.before
            frame = parent
        if comments:
            comments = self._directives(frame, comments)
        if frame.off is None:
            self._place(frame, datum, start, end, comments)
        else:
            self.replaced.append(datum)
            frame.reached = end

    def _prefixed(self, frame: _Frame, operand: Datum, end: int, odd: bool) -> Datum:
        if odd or (frame.has_comments and len(self.stack) >= _DEEPEST):
            return self._verbatim(frame.start, end)
        text = self.spelling[id(operand)] if isinstance(operand, Atom) else ""
        if text.startswith("@"):
            return self._verbatim(frame.start, end, f"{frame.text} {text}")
        head = Atom(Symbol(PREFIXES[frame.text]), Span(self.source, frame.start, frame.body))
        self.spelling[id(head)] = head.value
        return ListDatum((head, operand), None, Span(self.source, frame.start, end))

    def _place(self, frame: _Frame, datum: Datum, start: int, end: int, comments: Sequence[Comment]) -> None:
        """Put a datum into its list with the comments before it."""
        begins = frame.is_top and not frame.items
        gap = gap_of(self.text, frame.end, start, comments, note=not begins, lead=not frame.dotted)
        frame.breaks.append("\n" in self.text[frame.end : start])
        if gap.note and frame.items:
            self._note(frame, gap)
        elif gap.note:
            frame.opening = _text_of(gap.note)
        own, trivia = comments[len(gap.note) :], _PLAIN
        if own or gap.blank:
            lead = "".join(f"{comment.exact} " for comment in gap.lead)
            trivia = Trivia(before=gap.rows, blank=gap.blank and self._may_be_blank(frame), lead=lead)
        frame.items.append(_Item(datum, start, end, own[0].start if own else start, end, trivia))

    @staticmethod
    def _may_be_blank(frame: _Frame) -> bool:
        """Whether an empty line may stand before the next item: not before the first one, a head's first operand or a
        keyword's value."""
        items = frame.items
        if not items or frame.is_top:
            return bool(items)
        first = items[0].datum
        is_head = frame.kind == "LPAR" and isinstance(first, Atom) and type(first.value) is Symbol
        return len(items) > is_head and not is_keyword(items[-1].datum)

    def _note(self, frame: _Frame, gap: Gap) -> str:
        """Put comments behind the last item; gives their text."""
        item, text = frame.items[-1], _text_of(gap.note)
        if gap.note[-1].directive == "skip" and id(item.datum) not in self.raw:
            self.replaced.append(item.datum)
            item.datum = self._verbatim(item.start, item.end)
        item.trivia, item.last = replace(item.trivia, after=text), gap.note[-1].end
        return text

    # --- lists ---------------------------------------------------------------------------------------------------

    def _end_list(self, frame: _Frame, end: int) -> None:
        trivia = self._close(frame, end - 1)
        parent = self.stack[-1]
        parent.has_comments = parent.has_comments or frame.has_comments
        if frame.odd or (frame.has_comments and len(self.stack) >= _DEEPEST):
            self.replaced += [item.datum for item in frame.items]
            self._finish(self._verbatim(frame.start, end), frame.start, end, frame.before)
            return
        self._keep_trivia(frame)
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

    def _keep_trivia(self, frame: _Frame) -> None:
        """Note what stands around the items of a list; what their own brackets hold is known already."""
        for item in frame.items:
            inner, outer = self.trivia.get(id(item.datum)), item.trivia
            if inner is None and outer is _PLAIN and not frame.is_top:
                continue
            if inner is not None:
                outer = replace(outer, end=inner.end, opening=inner.opening, closing=inner.closing)
            if frame.is_top or outer != _PLAIN:
                self.trivia[id(item.datum)] = outer

    def _close(self, frame: _Frame, end: int) -> Trivia:
        """What stands inside a list's brackets besides its items."""
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
    return " ".join(comment.exact for comment in comments)
