"""Reader: parse text into datums with spans, by the grammar ``reader.lark``.

Text is classified as complete, incomplete or wrong, so that the REPL knows when to prompt for more input.
"""

from __future__ import annotations

import re
import sys
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from enum import Enum
from functools import cache, cached_property
from typing import Any, NamedTuple, TypeAlias

from scenelang.grammar.datum import (
    PREFIXES,
    ArrayDatum,
    Atom,
    Datum,
    Handle,
    Keyword,
    ListDatum,
    Source,
    Span,
    Symbol,
    dataclass,
    replace,
)
from scenelang.grammar.diagnostics import Diagnostic, Note, SceneError
from scenelang.grammar.lalr import END, Misfit, Tables, tables_of
from scenelang.grammar.lazy_patterns import lazy_pattern

# Splitting a text into top-level chunks, so that an edited chunk can be read again without the others.
#
# This scanner only matches brackets; the reader decides whether a chunk is valid. If brackets do not match, a chunk
# ends where the next form seems to begin: at an opening bracket in the first column.

_TOKEN = lazy_pattern(
    r"""(?P<space>\s+)|(?P<comment>;[^\n]*)|(?P<block>\#\|)|(?P<hide>\#;)|(?P<string>"(?:[^"\\]|\\.)*")"""
    r"""|(?P<open>[(\[])|(?P<close>[)\]])|(?P<prefix>'|`|,@|,)|(?P<atom>[^\s()\[\]";'`,]+)|(?P<other>.)""",
    re.S,
)
_EDGE = lazy_pattern(r"#\||\|#")
_FIRST_COLUMN = lazy_pattern(r"^[(\[]", re.M)


@dataclass(frozen=True)
class Chunk:
    """Top-level piece of a source text, usually one form.

    Attributes
    ----------
    start
        Offset of the chunk in the whole text.
    text
        Text of the chunk.
    column
        Column of the first character, counted from 0.
    matched
        Whether all brackets, strings and block comments of the chunk are closed.
    """

    start: int
    text: str
    column: int = 0
    matched: bool = True

    @property
    def end(self) -> int:
        """Offset behind the chunk in the whole text."""
        return self.start + len(self.text)


@dataclass(frozen=True, eq=False)
class _Scan:
    """Text being split, with what its chunks share."""

    text: str

    @cached_property
    def resumptions(self) -> list[int]:
        """Offsets where a new top-level form seems to begin: opening brackets in the first column."""
        return [match.start() for match in _FIRST_COLUMN.finditer(self.text)]

    @cached_property
    def unclosed(self) -> set[int]:
        """Offsets of brackets that were found to be never closed, so that none is followed to the end twice."""
        return set()

    def next_resumption(self, after: int) -> int:
        """Return the first resumption behind an offset, or the end of the text."""
        place = bisect_right(self.resumptions, after)
        return self.resumptions[place] if place < len(self.resumptions) else len(self.text)


def split(text: str) -> tuple[Chunk, ...]:
    """Split ``text`` into its top-level chunks, usually one form each, separated by white space and comments."""
    return tuple(_pieces(_Scan(text)))


def _pieces(scan: _Scan) -> Iterator[Chunk]:
    """Iterate over the chunks of a text.

    A chunk in the first column is held back with the indented ones after it: if a stray closing bracket follows, one of
    them ended too early, and all become one unmatched chunk.
    """
    position = 0
    held: list[Chunk] = []
    while (piece := _next_piece(scan, position)) is not None:
        chunk, position = piece
        is_stray_closer = scan.text[chunk.start] in ")]"
        if is_stray_closer and held:
            first = held[0]
            held = [Chunk(first.start, scan.text[first.start : position], first.column, matched=False)]
        elif chunk.column == 0:
            yield from held
            held = [chunk]
        else:
            held.append(chunk)
    yield from held


def _next_piece(scan: _Scan, position: int) -> tuple[Chunk, int] | None:
    """Return the first chunk at or after ``position`` and the offset where the search for the next one starts."""
    text = scan.text
    begin = _skip_blank(text, position)
    if begin is None:
        return None
    closed = _piece_end(text, begin, scan.unclosed)
    end = scan.next_resumption(begin) if closed is None else closed.end
    matched = closed is not None and closed.matched
    return Chunk(begin, text[begin:end].rstrip(), begin - _line_start(text, begin), matched), end


def _line_start(text: str, position: int) -> int:
    """Return the offset at which the line of ``position`` starts."""
    return text.rfind("\n", 0, position) + 1


# --- incremental splitting after an edit ---------------------------------------------------------------------------


def split_again(text: str, before: str, chunks: Sequence[Chunk]) -> tuple[Chunk, ...]:
    """Return ``split(text)``, reusing the chunks of the previous text outside the edited region.

    Parameters
    ----------
    text
        Text after the edit.
    before
        Text before the edit.
    chunks
        Chunks of ``before``.
    """
    if not all(chunk.matched for chunk in chunks):
        return split(text)
    head = _common_start(text, before)
    unchanged = [chunk for chunk in chunks if chunk.end < head]
    tail = _common_start(text[head:][::-1], before[head:][::-1])
    shift = len(text) - len(before)
    after = {chunk.start + shift: i for i, chunk in enumerate(chunks) if chunk.start > len(before) - tail}
    scan, position, reused = _Scan(text), unchanged[-1].end if unchanged else 0, list(unchanged)
    while (piece := _next_piece(scan, position)) is not None:
        chunk, position = piece
        if not chunk.matched or text[chunk.start] in ")]":
            return split(text)
        if chunk.start in after:
            rest = chunks[after[chunk.start] :]
            return (*reused, *(_shifted(chunk_after, shift, text) for chunk_after in rest))
        reused.append(chunk)
    return tuple(reused)


def _shifted(chunk: Chunk, shift: int, text: str) -> Chunk:
    """Return a chunk at its place in the edited text; its column changes if the edit is on the same line."""
    start = chunk.start + shift
    column = start - _line_start(text, start) if chunk.column else 0
    return Chunk(start, chunk.text, column)


def _common_start(a: str, b: str) -> int:
    """Return the length of the common prefix of two texts, by binary search with slice comparisons."""
    low, high = 0, min(len(a), len(b))
    while low < high:
        middle = (low + high + 1) // 2
        if a[low:middle] == b[low:middle]:
            low = middle
        else:
            high = middle - 1
    return low


def _skip_blank(text: str, position: int) -> int | None:
    """Skip white space and comments; return the offset of the next chunk, or None at the end of the text."""
    while (match := _TOKEN.match(text, position)) is not None:
        if match.lastgroup not in ("space", "comment"):
            if match.lastgroup != "block":
                return position
            end = _block_comment_end(text, position)
            if end is None:
                return position
            position = end
        else:
            position = match.end()
    return None


def _block_comment_end(text: str, start: int) -> int | None:
    """Return the end of the nested ``#|`` comment at ``start``, or None if it is not closed."""
    depth, search = 1, start + 2
    while (edge := _EDGE.search(text, search)) is not None:
        search = edge.end()
        depth += 1 if edge[0] == "#|" else -1
        if depth == 0:
            return search
    return None


_OPENING = {")": "(", "]": "["}


class _End(NamedTuple):
    """End of a chunk, and whether its brackets match."""

    end: int
    matched: bool


def _piece_end(text: str, position: int, unclosed: set[int] | None = None) -> _End | None:
    """Return the end of the chunk at ``position``, or None if it is never closed.

    Adjacent data without white space between them form one chunk. The places of brackets that are never closed are
    added to ``unclosed``, so that none is followed to the end of the text twice.
    """
    if unclosed is not None and position in unclosed:
        return None
    open_brackets: list[tuple[str, int]] = []
    end = _followed(text, position, open_brackets)
    if end is None and unclosed is not None:
        unclosed.update(place for _, place in open_brackets)
    return end


def _followed(text: str, position: int, open_brackets: list[tuple[str, int]]) -> _End | None:
    """Return the end of the chunk at ``position``, or None if it is never closed.

    ``open_brackets`` is the stack of brackets with their offsets; it is left as it is where the scan ends.
    """
    pending = False  # whether a prefix still lacks its datum
    while (match := _TOKEN.match(text, position)) is not None:
        kind, start = match.lastgroup, position
        position = match.end()
        if kind == "open":
            open_brackets.append((match[0], start))
            pending = False
        elif kind == "close":
            if not open_brackets:
                return _End(position, matched=False)
            if open_brackets[-1][0] != _OPENING[match[0]]:
                return None
            open_brackets.pop()
            pending = False
        elif kind == "prefix" or kind == "hide":
            pending = True
        elif kind == "block":
            end = _block_comment_end(text, start)
            if end is None:
                return None
            position = end
        elif kind == "other":
            return None  # unterminated string
        elif kind in ("atom", "string"):
            pending = False
        if not open_brackets and not pending and (kind in ("space", "comment") or _is_gap(text, position)):
            return _End(position, matched=True)
    return None if open_brackets or pending else _End(position, matched=True)


def _is_gap(text: str, position: int) -> bool:
    """Return whether a chunk may end at ``position``: at white space, a comment, a closing bracket or the end."""
    return position >= len(text) or text[position] in " \t\r\n\f\v;()]"


def lexemes(text: str, start: int, end: int) -> Iterator[tuple[str, int, int]]:
    """Iterate over the tokens between two offsets of a text that need not be valid.

    Yields
    ------
    tuple of (str, int, int)
        Kind (space, comment, block, hide, string, open, close, prefix, atom or other), start and end.
    """
    position = start
    while position < end and (match := _TOKEN.match(text, position)) is not None:
        kind = str(match.lastgroup)
        position = match.end()
        if kind == "block":
            position = _block_comment_end(text, match.start()) or len(text)
        elif kind == "other" and match[0] == '"':
            position = len(text)  # unterminated string
        yield kind, match.start(), position


def piece_at(text: str, position: int) -> tuple[int, int]:
    """Return the range of the first datum after ``position``, also inside a form; an empty range if there is none."""
    begin = _skip_blank(text, position)
    if begin is None:
        return len(text), len(text)
    closed = _piece_end(text, begin)
    return begin, len(text) if closed is None else closed.end


MAX_NESTING = 5_000  # levels; expansion and compilation recurse on them, in a thread with a stack of that size
_MAX_DIGITS = 4_000  # of an integer; CPython refuses to convert more than 4,300


class Completeness(Enum):
    """Whether a text is a program, the beginning of one, or neither."""

    COMPLETE = "complete"
    INCOMPLETE = "incomplete"  # further input could make it valid
    WRONG = "wrong"


@dataclass(frozen=True, slots=True)
class ReadResult:
    """Result of reading a text.

    Attributes
    ----------
    source
        The text.
    forms
        Its top-level forms; empty if the brackets do not match.
    diagnostics
        Errors of the syntax.
    completeness
        Whether the text is complete, could be continued, or is wrong.
    """

    source: Source
    forms: tuple[Datum, ...]
    diagnostics: tuple[Diagnostic, ...]
    completeness: Completeness


# --- tokens ----------------------------------------------------------------------------------------------------


Place: TypeAlias = tuple[int, int]  # offsets of a token
_WRONG = "WRONG"


@cache
def _tables() -> Tables:
    """Load the tables of ``reader.lark``."""
    from scenelang.grammar.tables import reader_tables

    return tables_of(reader_tables)


def terminals() -> list[tuple[str, str]]:
    """Return the names and regular expressions of the grammar's terminals, in the order in which they are tried.

    Names of ignored terminals start with ``__``.
    """
    return list(_tables().terminals)


@cache
def _token_pattern() -> re.Pattern[str]:
    """Return a pattern of one token with the blanks before it, or of the end; it matches at every offset.

    The quantifier of the blanks is possessive, because backtracking into them makes no token.
    """
    ignored = "|".join(pattern for name, pattern in terminals() if name.startswith("__"))
    named = "|".join(f"(?P<{name}>{pattern})" for name, pattern in terminals() if not name.startswith("__"))
    return re.compile(rf"(?:{ignored})*+(?:{named}|(?P<END>\Z)|(?P<{_WRONG}>.))", re.S)


def _tokens(text: str) -> Iterator[tuple[str, Place]]:
    """Iterate over the terminals of a text and their places, up to the end or the first invalid one."""
    for match in _token_pattern().finditer(text):
        terminal = match.lastgroup or ""
        if terminal == "END":
            break
        yield terminal, match.span(terminal)
    yield END, (len(text), len(text))


# --- brackets --------------------------------------------------------------------------------------------------
#
# The tables tell where a text is wrong. The cause is looked for by a second pass over the brackets, from the start: it
# knows the opener that is not closed, and where the indentation contradicts the nesting. Valid texts do not pay for it.

_OPENER = {"RPAR": "LPAR", "RSQB": "LSQB"}
_CLOSING = {"LPAR": ")", "LSQB": "]"}
_OPEN_ENDED = ("PREFIX", "DATUM_COMMENT")
_INDEXED = lazy_pattern(r"""[^\s()\[\]";'`,]\[""")  # where there may be an atom just before an array


class _Token(NamedTuple):
    """Token with its place; lines and columns count from 1."""

    type: str
    text: str
    start: int
    end: int
    line: int
    column: int
    end_line: int


def _located_tokens(text: str) -> Iterator[_Token]:
    """Iterate over the tokens of a text with lines and columns."""
    source = Source("", text)
    for terminal, (start, end) in _tokens(text):
        line, column = source.position(start)
        yield _Token(terminal, text[start:end], start, end, line, column, source.position(end)[0])


@dataclass(frozen=True, eq=False)
class _ReadProblem:
    """Error in the brackets of a text; ``notes`` are messages with the offsets of the brackets that they are about."""

    name: str
    message: str
    start: int
    end: int
    state: Completeness
    hint: str | None = None
    notes: tuple[tuple[str, int], ...] = ()

    def diagnostic(self, source: Source) -> Diagnostic:
        """Return the problem as a diagnostic of ``source``."""
        notes = tuple(Note(message, Span(source, start, start + 1)) for message, start in self.notes)
        return Diagnostic(self.name, self.message, Span(source, self.start, self.end), self.hint, notes)


@dataclass(frozen=True, eq=False)
class _LocatedProblem:
    """Problem with the offsets of the token ``at`` which it shows and of the token before."""

    problem: _ReadProblem
    at: int
    previous: int


def _bracket_problem(text: str) -> _LocatedProblem | None:
    """Return the first problem of brackets, dots and nesting."""
    brackets = _Brackets()
    for token in _located_tokens(text):
        problem = brackets.problem(token)
        if problem is not None:
            return _LocatedProblem(problem, token.start, brackets.last.start if brackets.last is not None else 0)
        brackets.last = token
    return None


@dataclass(frozen=True, eq=False)
class _Unindented:
    """Opener with a later line that is not indented beyond it: probably a missing closing bracket.

    ``closing`` are the brackets that close all such openers, ``start`` is the offset of the line's first token.
    """

    opener: _Token
    closing: str
    start: int


class _Brackets:
    """Stack of open brackets, with the places where indentation contradicts the nesting."""

    def __init__(self) -> None:
        self.openers: list[_Token] = []
        self.depths: list[int] = [0]  # nesting at each opener, including prefixes such as `'`
        self.prefixes = 0  # prefixes just before this point
        self.last: _Token | None = None
        self.indents: list[int] = []  # the column at which the line of each opener starts
        self.indent = 1
        self.suspect: _Unindented | None = None
        self.closed_suspect: _Unindented | None = None
        self.early_close: _Token | None = None  # last top-level closer that is followed by an indented line

    def problem(self, token: _Token) -> _ReadProblem | None:
        """Process the next token; return the problem that it shows, if any."""
        kind, last, openers = token.type, self.last, self.openers
        if kind == END:
            return self._problem_at_end()
        if kind == _WRONG:
            return _problem("unclosed", "unclosed string", token, 1, Completeness.INCOMPLETE)
        if last is None:
            self.indent = token.column
        else:
            if token.line != last.end_line:
                self._note_indentation(token, last)
            wrong = _wrong_neighbors(token, last)
            if wrong is not None:
                return wrong
        if kind == "DOT" and last is None:
            return _bad_dot(token)
        if kind in ("RPAR", "RSQB"):
            self.prefixes = 0
            return self._close(kind, token)
        if kind == "DOT" and (not openers or openers[-1].type == "LSQB"):
            return _bad_dot(token)
        return self._open(kind, token)

    def _open(self, kind: str, token: _Token) -> _ReadProblem | None:
        """Process a token that is not a closing bracket; nesting that is too deep is a problem."""
        depth = 0
        if kind in _OPEN_ENDED:
            self.prefixes += 1
            depth = self.depths[-1] + self.prefixes
        elif kind == "LPAR" or kind == "LSQB":
            depth = self.depths[-1] + self.prefixes + 1
            self.openers.append(token)
            self.indents.append(self.indent)
            self.depths.append(depth)
            self.prefixes = 0
        else:
            self.prefixes = 0
        if depth <= MAX_NESTING:
            return None
        return _wrong("nesting", f"parentheses are nested too deeply (more than {MAX_NESTING:,} levels)", token)

    def _note_indentation(self, token: _Token, last: _Token) -> None:
        """Record a line that contradicts the nesting: too far left in a form, or indented outside all forms."""
        self.indent = token.column
        if self.openers and self.suspect is None and token.type not in _OPENER and token.column <= self.indents[-1]:
            closing = [_CLOSING[o.type] for o, n in zip(self.openers, self.indents, strict=True) if token.column <= n]
            self.suspect = _Unindented(self.openers[-1], "".join(reversed(closing)), token.start)
        if not self.openers and token.column > 1 and last.type == "RPAR":
            self.early_close = last

    def _close(self, kind: str, token: _Token) -> _ReadProblem | None:
        """Process a closing bracket; return the problem if it closes nothing, or a bracket of the other kind."""
        if not self.openers:
            wrong = _wrong(
                "extra-close", f"unmatched closing `{token.text}`", token, "remove it, or add the missing `(`"
            )
            if self.early_close is None:
                return wrong
            note = "the previous form ends here, although the next line is indented", self.early_close.start
            return replace(wrong, notes=(note,))
        opener = self.openers[-1]
        if opener.type != _OPENER[kind]:
            closing = _CLOSING[opener.type]
            message = f"mismatched closing `{token.text}`: expected `{closing}` to close `{opener.text}`"
            return replace(_wrong("extra-close", message, token), notes=(("opened here", opener.start),))
        self.openers.pop()
        self.indents.pop()
        self.depths.pop()
        if self.suspect is not None and self.suspect.opener is opener:
            self.closed_suspect, self.suspect = self.closed_suspect or self.suspect, None
        return None

    def _problem_at_end(self) -> _ReadProblem | None:
        """Return what is unclosed at the end; the hint points at the first line that contradicts the nesting."""
        last = self.last
        if self.openers:
            suspect = self.suspect or self.closed_suspect
            opener = suspect.opener if suspect is not None else self.openers[-1]
            closing = _short("".join(_CLOSING[o.type] for o in reversed(self.openers)))
            notes: tuple[tuple[str, int], ...] = ()
            hint = f"add `{closing}` at the end of the form"
            if suspect is not None:
                hint = f"add `{_short(suspect.closing)}` before the line that is not indented as a part of this form"
                notes = (("this line", suspect.start),)
            elif last is not None and last.line != opener.line:
                notes = (("the form ends here", last.start),)
            problem = _problem("unclosed", f"unclosed `{opener.text}`", opener, 1, Completeness.INCOMPLETE, hint)
            return replace(problem, notes=notes)
        if last is not None and last.type in _OPEN_ENDED:
            message = f"expected a datum after `{last.text}`"
            return _problem("unclosed", message, last, len(last.text), Completeness.INCOMPLETE)
        return None


def _wrong_neighbors(token: _Token, last: _Token) -> _ReadProblem | None:
    """Return the problem of two adjacent tokens that cannot follow each other, such as `(` and `.`."""
    kind = token.type
    if kind == "LSQB" and last.type == "ATOM" and last.end == token.start and "::" not in last.text:
        hint = f"write `(ref {_short(last.text)} i)` for the item at `i`, or leave a space before `[`"
        return _wrong("bad-atom", f"invalid indexing syntax `{_short(last.text)}[`", token, hint)
    if kind in ("RPAR", "RSQB"):
        if last.type in _OPEN_ENDED:
            return _wrong("syntax", f"expected a datum after `{last.text}`", last)
        if last.type == "DOT":
            return _bad_dot(last)
    elif kind == "DOT" and last.type in ("LPAR", "LSQB", "DOT", *_OPEN_ENDED):
        return _bad_dot(token)
    return None


def _problem(name: str, message: str, token: _Token, width: int, state: Completeness, hint: str = "") -> _ReadProblem:
    """Return a problem of the first ``width`` characters of a token."""
    return _ReadProblem(name, message, token.start, token.start + width, state, hint or None)


def _wrong(name: str, message: str, token: _Token, hint: str = "") -> _ReadProblem:
    """Return a problem of a token that no further input can solve."""
    return _problem(name, message, token, len(token.text), Completeness.WRONG, hint)


def _bad_dot(token: _Token) -> _ReadProblem:
    hint = "write a pair as `(a . b)`, with exactly one datum after the dot"
    return _wrong("bad-dot", "unexpected dot outside a pair", token, hint)


# --- atoms -----------------------------------------------------------------------------------------------------

_INTEGER = lazy_pattern(r"[+-]?\d+\Z")
_FLOAT = lazy_pattern(r"[+-]?(?:\d+\.\d*|\.\d+|\d+)(?:[eE][+-]?\d+)?\Z")
_NUMBER_LIKE = lazy_pattern(r"[+-]?\.?\d")
_HANDLE = lazy_pattern(r"<([A-Za-z][A-Za-z0-9_-]*\*?)>\Z")
_LITERALS = {"#t": True, "#true": True, "#f": False, "#false": False}


def atom_value(text: str) -> Any:
    """Return the value of an atom; raise ``SceneError`` without a span if it is malformed."""
    first = text[0]
    if first.isdigit() or (first in "+-." and _NUMBER_LIKE.match(text)):
        return _number(text)
    if first == ":":
        if len(text) == 1 or text[1] == ":":
            raise SceneError("bad-atom", f"invalid keyword `{_short(text)}`", "write a keyword as `:name`")
        return Keyword(text[1:])
    if first == "<":
        match = _HANDLE.match(text)
        if match:
            return Handle(match[1])
    elif first == "#":
        if text in _LITERALS:
            return _LITERALS[text]
        hint = 'write a boolean as `#t` or `#f`, a string as `"..."`, an array as `[1 2 3]`'
        raise SceneError("bad-atom", f"unknown literal `{_short(text)}`", hint)
    elif text == "none":
        return None
    if not text.isprintable():
        raise SceneError("bad-atom", f"`{_short(text)}` contains invisible characters")
    return Symbol(text)


_KEYWORD_NAME = lazy_pattern(r"""[^\s()\[\]{}";'`,:|#]+\Z""")


def is_keyword_name(text: str) -> bool:
    """Return whether ``:text`` always reads as one keyword of that name."""
    return text.isprintable() and _KEYWORD_NAME.match(text) is not None


def _number(text: str) -> int | float:
    """Return the value of an atom that begins like a number."""
    if _INTEGER.match(text):
        if len(text) > _MAX_DIGITS:
            message = f"integer literal with {len(text):,} digits exceeds the limit of {_MAX_DIGITS:,}"
            raise SceneError("bad-atom", message)
        return int(text)
    if _FLOAT.match(text):
        return float(text)
    hint = "add a space after the number; a name must not start with a digit"
    if re.fullmatch(r"0[xX][0-9a-fA-F]{6}", text):
        hint = f'a color in hexadecimal is `(color "#{text[2:]}")`'
    if re.fullmatch(r"[+-]?\d+/\d+", text):
        top, bottom = text.split("/")
        hint = f"there are no fraction literals; write `(/ {top} {bottom})`"
    raise SceneError("bad-atom", f"invalid number `{_short(text)}`", hint)


_MAX_QUOTED_CHARACTERS = 40  # of source text in a message


def _short(text: str) -> str:
    """Return source text for a message: shortened, and without invisible characters."""
    shown = "".join(c if c.isprintable() else "�" for c in text[:_MAX_QUOTED_CHARACTERS])
    return shown + "..." if len(text) > _MAX_QUOTED_CHARACTERS else shown


_ESCAPES = {
    "n": "\n", "t": "\t", "r": "\r", '"': '"', "\\": "\\", "a": "\a", "b": "\b", "0": "\0",
}  # fmt: skip
_ESCAPE = lazy_pattern(r"\\(?:x([0-9A-Fa-f]+);|u([0-9A-Fa-f]{4})|([ \t]*\r?\n[ \t]*)|(.))", re.S)


def _unescape(body: str) -> str:
    """Replace the escapes of a string literal (R7RS 6.7, and ``\\u0041`` of JSON); an error has its offset as value."""
    if "\\" not in body:
        return body

    def replacement(match: re.Match[str]) -> str:
        """Return the text of an escape; a backslash at the end of a line joins it with the next one."""
        digits = match[1] or match[2]
        if digits:
            point = int(digits, 16) if len(digits) < 9 else -1
            if not 0 <= point < 0x110000 or 0xD800 <= point < 0xE000:
                raise SceneError("bad-string", f"invalid character code `{_short(match[0])}`", value=match.start() + 1)
            return chr(point)
        if match[3]:
            return ""
        if match[4] not in _ESCAPES:
            hint = 'supported escapes: \\n \\t \\r \\a \\b \\0 \\" \\\\ \\x41; \\u0041'
            raise SceneError("bad-string", f"unknown escape `\\{_short(match[4])}`", hint, value=match.start() + 1)
        return _ESCAPES[match[4]]

    return _ESCAPE.sub(replacement, body)


# --- trees -----------------------------------------------------------------------------------------------------

_SKIPPED = object()


class _Builder:
    """Builds datums bottom-up during parsing: one method for each rule of ``reader.lark``, with the rule's name.

    Errors of malformed atoms are collected rather than raised, so that one run reports all of them.
    """

    def __init__(self, source: Source, text: str) -> None:
        self._source = source
        self._text = text
        self._values: dict[str, Any] = {}  # values of atoms by text: most names of a program occur many times
        self.problems: list[Diagnostic] = []

    def atom(self, place: Place) -> Atom:
        """Return an atom; its value is computed once for each spelling."""
        start, end = place
        text = self._text[start:end]
        span = Span(self._source, start, end)
        values = self._values
        if text in values:
            return Atom(values[text], span)
        try:
            value = values[text] = atom_value(text)
            return Atom(value, span)
        except SceneError as error:
            return self._malformed(error, span)

    def string(self, place: Place) -> Atom:
        """Return a string literal without its quotes and escapes."""
        start, end = place
        span = Span(self._source, start, end)
        try:
            return Atom(_unescape(self._text[start + 1 : end - 1]), span)
        except SceneError as error:
            return self._malformed(error, span)

    def _malformed(self, error: SceneError, span: Span) -> Atom:
        """Record the error of an atom, and return a placeholder for it."""
        at = error.value if type(error.value) is int else None  # offset of the error within the text
        error.span = span if at is None else Span(self._source, span.start + at, min(span.start + at + 2, span.end))
        self.problems.append(error.diagnostic)
        return Atom(None, span)

    def proper_list(self, opener: Place, *rest: Any) -> ListDatum:
        return ListDatum(_without_skipped(rest[:-1]), None, Span(self._source, opener[0], rest[-1][1]))

    def dotted_list(self, opener: Place, *rest: Any) -> ListDatum:
        """Return an improper list; ``(a . (b))`` reads as ``(a b)``."""
        dot = next(i for i, item in enumerate(rest) if type(item) is tuple)  # a place; the other items are datums
        before, after = _without_skipped(rest[:dot]), _without_skipped(rest[dot + 1 : -1])
        span = Span(self._source, opener[0], rest[-1][1])
        if len(after) != 1 or not before:
            hint = "write a pair as `(a . b)`, with exactly one datum after the dot"
            self.problems.append(Diagnostic("bad-dot", "unexpected dot outside a pair", span, hint))
            return ListDatum(before + after, None, span)
        if isinstance(after[0], ListDatum):
            return ListDatum(before + after[0].items, after[0].tail, span)
        return ListDatum(before, after[0], span)

    def array(self, opener: Place, *rest: Any) -> ArrayDatum:
        return ArrayDatum(_without_skipped(rest[:-1]), Span(self._source, opener[0], rest[-1][1]))

    def prefixed(self, prefix: Place, *rest: Any) -> ListDatum:
        start, end = prefix
        head = Atom(Symbol(PREFIXES[self._text[start:end]]), Span(self._source, start, end))
        return ListDatum((head, rest[-1]), None, Span(self._source, start, rest[-1].span.end))

    def skipped(self, *_: Any) -> Any:
        return _SKIPPED

    def start(self, *rest: Any) -> tuple[Any, ...]:
        return _without_skipped(rest)


def _without_skipped(items: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return items without those commented out by ``#;``."""
    return tuple(item for item in items if item is not _SKIPPED) if _SKIPPED in items else items


_BLOCK = lazy_pattern(r'"(?:[^"\\]|\\.)*"|#;|;[^\n]*|#\||\|#', re.S)


def block_comments(text: str) -> list[tuple[int, int]]:
    """Return the ranges of the outermost ``#| |#`` comments; the last one ends with the text if it is not closed."""
    ranges: list[tuple[int, int]] = []
    search = 0 if "#|" in text else len(text)
    while (match := _BLOCK.search(text, search)) is not None:
        search = match.end()
        if match[0] == "#|":
            search = _block_comment_end(text, match.start()) or len(text)
            ranges.append((match.start(), search))
    return ranges


def without_comments(text: str, places: Sequence[tuple[int, int]]) -> str:
    """Replace the ``#| |#`` comments at ``places`` with blanks; offsets and line endings are preserved."""
    pieces: list[str] = []
    position = 0
    for start, end in places:
        pieces += [text[position:start], _blank(text[start:end])]
        position = end
    return "".join([*pieces, text[position:]]) if places else text


def read_comments(source: Source) -> tuple[Span, ...]:
    """Return the comments of a text in order: ``; line``, ``#| block |#``, and the ``#;`` of a datum comment."""
    comments: list[Span] = []
    search = 0
    while (match := _BLOCK.search(source.text, search)) is not None:
        start, search = match.span()
        if match[0] == "#|":
            search = _block_comment_end(source.text, start) or len(source.text)
        if match[0][0] in "#;" and match[0] != "|#":
            comments.append(Span(source, start, search))
    return tuple(comments)


def read(source: Source) -> ReadResult:
    """Read all datums of ``source``. Never raises: errors are returned in ``diagnostics``."""
    return _read(source, source.text)


def read_part(part: Span) -> ReadResult:
    """Read the datums of a part of a source, whose spans are those of the whole source. Never raises."""
    return _read(part.source, " " * part.start + part.text)


def read_pieces(source: Source) -> ReadResult:
    """Read ``source`` with error recovery: chunks that do not parse are skipped, and all others are read.

    The parser is run again without the chunks at fault, until the others read. Their errors are those of each chunk
    alone, with the text before it blanked out.
    """
    result = read(source)
    if result.forms or result.completeness is Completeness.COMPLETE or len(source.text) > _MAX_RETRIED:
        return result
    chunks = split(source.text)
    wrong = [chunk for chunk in chunks if not chunk.matched]
    rest = result
    while len(wrong) <= _MAX_WRONG:
        rest = _read(source, _without(source.text, wrong))
        if rest.forms or rest.completeness is Completeness.COMPLETE:
            break
        place = rest.diagnostics[-1].span
        named = [chunk for chunk in chunks if place is not None and chunk.start <= place.start < chunk.end]
        if not named:
            break
        wrong += named
    problems = list(rest.diagnostics if rest.forms else ())
    for chunk in wrong[:_MAX_WRONG]:
        problems += _read(source, _blank(source.text[: chunk.start]) + chunk.text).diagnostics
    if not problems:
        return result
    return ReadResult(source, rest.forms, tuple(problems), result.completeness)


_MAX_WRONG = 20  # malformed chunks that are reported; each costs a run of the parser over the text
_MAX_RETRIED = 1_000_000  # characters of a text that is read again without its malformed chunks


def _without(text: str, chunks: Sequence[Chunk]) -> str:
    """Replace ``chunks`` of ``text`` with blanks."""
    for chunk in chunks:
        text = text[: chunk.start] + _blank(chunk.text) + text[chunk.end :]
    return text


def _blank(text: str) -> str:
    """Replace all characters except line breaks with blanks, so that positions do not change."""
    return re.sub(r"[^\n]", " ", text)


def _read(source: Source, text: str) -> ReadResult:
    """Read ``text``, which is the text of ``source``, possibly with parts replaced by blanks."""
    comments = block_comments(text)
    if comments and _block_comment_end(text, comments[-1][0]) is None:
        start = comments[-1][0]
        hint = "block comments nest: close every `#|` with its own `|#`"
        diagnostic = Diagnostic("unclosed", "unclosed `#|` comment", Span(source, start, start + 2), hint)
        return ReadResult(source, (), (diagnostic,), Completeness.INCOMPLETE)
    clean = without_comments(text, comments)
    result, problems = _parsed(source, clean, MAX_NESTING)
    if isinstance(result, Misfit) or _INDEXED.search(clean):
        fault = _bracket_problem(clean)
        if isinstance(result, Misfit) and not result.expected:  # the stack is high, whether or not the nesting is deep
            result, problems = _parsed(source, clean if fault is None else clean[: fault.at])
        if fault is not None and not (isinstance(result, Misfit) and result.value[0] < fault.at):
            read_before = [other for other in problems if other.span is not None and other.span.end <= fault.previous]
            return ReadResult(source, (), (*read_before, fault.problem.diagnostic(source)), fault.problem.state)
    if isinstance(result, Misfit):
        diagnostic, state = _misfit(source, text, result)
        return ReadResult(source, (), (*problems, diagnostic), state)
    return ReadResult(source, result, tuple(problems), Completeness.WRONG if problems else Completeness.COMPLETE)


def _parsed(source: Source, text: str, max_height: int = sys.maxsize) -> tuple[Any, list[Diagnostic]]:
    """Parse a text without block comments; return its datums or the ``Misfit``, and the malformed atoms."""
    builder = _Builder(source, text)
    tables = _tables()
    return tables.parse(_tokens(text), tables.builders(builder), max_height), builder.problems


def _misfit(source: Source, text: str, misfit: Misfit) -> tuple[Diagnostic, Completeness]:
    """Return the error of a token where all brackets match, such as a prefix with only a comment after it."""
    if misfit.terminal == END:
        last = len(text.rstrip())
        message = "unexpected end of input, expected a datum"
        return Diagnostic("unclosed", message, Span(source, last - 1, last)), Completeness.INCOMPLETE
    start = misfit.value[0]
    return Diagnostic("syntax", "expected a datum before this", Span(source, start, start + 1)), Completeness.WRONG
