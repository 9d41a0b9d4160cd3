"""Reader: parse text into datums with spans, by the grammar ``reader.lark``.

Text is classified as complete, incomplete or wrong, so that the REPL knows when to prompt for more input.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache, cached_property
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

from lark import Lark, Token, Transformer, v_args
from lark.exceptions import UnexpectedCharacters, UnexpectedToken
from lark.lexer import BasicLexer, LexerState

from scenelang.grammar.datum import PREFIXES, ArrayDatum, Atom, Datum, Handle, Keyword, ListDatum, Source, Span, Symbol
from scenelang.grammar.diagnostics import Diagnostic, Note, SceneError

# Building Lark parsers. Their tables are cached in the user's cache folder because building them is slow.


def build_parser(grammar: str, start: str, lexer: Any, transformer: Any = None) -> Lark:
    """Build the LALR parser for a grammar file of this package, or load its cached tables.

    Lark rebuilds the tables if they do not match the text of the grammar.
    """
    text = Path(__file__).with_name(grammar).read_text("utf-8")
    options: dict[str, Any] = {"parser": "lalr", "lexer": lexer, "start": start, "transformer": transformer}
    folder = _cache_folder()
    if folder is not None:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        options["cache"] = str(folder / f"{Path(grammar).stem}-{start}-{version}.tables")
    return Lark(text, **options)


def _cache_folder() -> Path | None:
    """Return the folder for cached tables, or None if it is not writable."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folder = Path(base) / "scenelang"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


# Splitting a text into top-level chunks, so that an edited chunk can be read again without the others.
#
# This scanner only matches brackets; the reader decides whether a chunk is valid. If brackets do not match, a chunk
# ends where the next form seems to begin: at an opening bracket in the first column.


_TOKEN = re.compile(
    r"""(?P<space>\s+)|(?P<comment>;[^\n]*)|(?P<block>\#\|)|(?P<hide>\#;)|(?P<string>"(?:[^"\\]|\\.)*")"""
    r"""|(?P<open>[(\[])|(?P<close>[)\]])|(?P<prefix>'|`|,@|,)|(?P<atom>[^\s()\[\]";'`,]+)|(?P<other>.)""",
    re.S,
)
_EDGE = re.compile(r"#\||\|#")
_FIRST_COLUMN = re.compile(r"^[(\[]", re.M)


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
        return self.start + len(self.text)


@dataclass(frozen=True, eq=False)
class _Scan:
    text: str

    @cached_property
    def resumptions(self) -> list[int]:
        """Offsets where a new top-level form seems to begin: opening brackets in the first column."""
        return [match.start() for match in _FIRST_COLUMN.finditer(self.text)]

    def next_resumption(self, after: int) -> int:
        return next((start for start in self.resumptions if start > after), len(self.text))


def split(text: str) -> tuple[Chunk, ...]:
    """Split ``text`` into its top-level chunks, usually one form each, separated by white space and comments."""
    return tuple(_pieces(_Scan(text)))


def _pieces(scan: _Scan) -> Iterator[Chunk]:
    position = 0
    open_chunks: list[Chunk] = []  # a chunk in the first column and the indented ones after it
    while (found := _next_piece(scan, position)) is not None:
        chunk, position = found
        if (
            scan.text[chunk.start] in ")]" and open_chunks
        ):  # a stray closer: one of the held chunks may have ended too early
            open_chunks = [
                Chunk(
                    open_chunks[0].start,
                    scan.text[open_chunks[0].start : position],
                    open_chunks[0].column,
                    matched=False,
                )
            ]
        elif chunk.column == 0:
            yield from open_chunks
            open_chunks = [chunk]
        else:
            open_chunks.append(chunk)
    yield from open_chunks


def _next_piece(scan: _Scan, position: int) -> tuple[Chunk, int] | None:
    """Return the first chunk at or after ``position`` and the offset where the search for the next one starts."""
    text = scan.text
    begin = _skip_blank(text, position)
    if begin is None:
        return None
    closed = _piece_end(text, begin)
    end = scan.next_resumption(begin) if closed is None else closed.end
    matched = closed is not None and closed.matched
    return Chunk(begin, text[begin:end].rstrip(), begin - _line_start(text, begin), matched), end


def _line_start(text: str, position: int) -> int:
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
    scan, position, found = _Scan(text), unchanged[-1].end if unchanged else 0, list(unchanged)
    while (piece := _next_piece(scan, position)) is not None:
        chunk, position = piece
        if not chunk.matched or text[chunk.start] in ")]":
            return split(text)
        if chunk.start in after:
            rest = chunks[after[chunk.start] :]
            return (*found, *(_shifted(each, shift, text) for each in rest))
        found.append(chunk)
    return tuple(found)


def _shifted(chunk: Chunk, shift: int, text: str) -> Chunk:
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
    end: int
    matched: bool


def _piece_end(text: str, position: int) -> _End | None:
    """Return the end of the chunk at ``position``, or None if it is never closed.

    Adjacent data without white space between them form one chunk.
    """
    open_brackets: list[str] = []
    pending = False  # whether a prefix still lacks its datum
    while (match := _TOKEN.match(text, position)) is not None:
        kind, start = match.lastgroup, position
        position = match.end()
        if kind == "open":
            open_brackets.append(match[0])
            pending = False
        elif kind == "close":
            if not open_brackets:
                return _End(position, False)
            if open_brackets.pop() != _OPENING[match[0]]:
                return None
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
            return _End(position, True)
    return None if open_brackets or pending else _End(position, True)


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


MAX_NESTING = 5_000
_MAX_DIGITS = 4_000


class Completeness(Enum):
    COMPLETE = "complete"
    INCOMPLETE = "incomplete"  # further input could make it valid
    WRONG = "wrong"


@dataclass(frozen=True, slots=True)
class ReadResult:
    """Result of reading a text. ``forms`` is empty if the brackets do not match."""

    source: Source
    forms: tuple[Datum, ...]
    diagnostics: tuple[Diagnostic, ...]
    completeness: Completeness


# --- brackets --------------------------------------------------------------------------------------------------

_OPENER = {"RPAR": "LPAR", "RSQB": "LSQB"}
_CLOSING = {"LPAR": ")", "LSQB": "]"}


class _BracketLexer(BasicLexer):
    """Lexer that checks brackets, dots and nesting before the parser, while the offending opener is still known."""

    __future_interface__ = 1

    def lex(self, lexer_state: LexerState, parser_state: Any) -> Iterator[Token]:
        brackets = _Brackets()
        for token in super().lex(lexer_state, parser_state):
            brackets.check(token)
            yield token
        brackets.check_end()


class _Brackets:
    """Stack of open brackets, with the places where indentation contradicts the nesting."""

    def __init__(self) -> None:
        self.openers: list[Token] = []
        self.depths: list[int] = [0]  # nesting at each opener, including prefixes such as `'`
        self.prefixes = 0  # prefixes just before this point
        self.last: Token | None = None
        self.suspect: Token | None = None  # first unclosed opener that a later line is not indented beyond
        self.early_close: Token | None = None  # last top-level closer that is followed by an indented line

    def check(self, token: Token) -> None:
        kind, last, openers = token.type, self.last, self.openers
        if last is not None:
            if token.line != last.end_line:
                self._note_indentation(token, last)
            _check_neighbours(token, last)
        elif kind == "DOT":
            raise _bad_dot(token)
        if kind in _OPEN_ENDED:
            self.prefixes += 1
            self._check_depth(self.depths[-1] + self.prefixes, token)
        elif kind == "LPAR" or kind == "LSQB":
            openers.append(token)
            self.depths.append(self.depths[-1] + self.prefixes + 1)
            self._check_depth(self.depths[-1], token)
            self.prefixes = 0
        else:
            self.prefixes = 0
        if kind == "RPAR" or kind == "RSQB":
            self._close(kind, token)
        elif kind == "DOT" and (not openers or openers[-1].type == "LSQB"):
            raise _bad_dot(token)
        self.last = token

    @staticmethod
    def _check_depth(depth: int, token: Token) -> None:
        if depth > MAX_NESTING:
            raise _wrong("nesting", f"parentheses are nested too deeply (more than {MAX_NESTING:,} levels)", token)

    def _note_indentation(self, token: Token, last: Token) -> None:
        column = token.column or 1
        if self.openers and self.suspect is None and column <= (self.openers[-1].column or 1):
            self.suspect = self.openers[-1]
        if not self.openers and column > 1 and last.type == "RPAR":
            self.early_close = last

    def _close(self, kind: str, token: Token) -> None:
        if not self.openers:
            error = _wrong("extra-close", f"unmatched closing `{token}`", token, "remove it, or add the missing `(`")
            if self.early_close is not None:
                error.note("the previous form ends here, although the next line is indented", self.early_close)
            raise error
        opener = self.openers[-1]
        if opener.type != _OPENER[kind]:
            closing = _CLOSING[opener.type]
            message = f"mismatched closing `{token}`: expected `{closing}` to close `{opener}`"
            error = _wrong("extra-close", message, token)
            error.note("opened here", opener)
            raise error
        self.openers.pop()
        self.depths.pop()

    def check_end(self) -> None:
        last = self.last
        if self.openers:
            opener = self.suspect or self.openers[-1]
            raise _problem("unclosed", f"unclosed `{opener}`", opener, 1, Completeness.INCOMPLETE)
        if last is not None and last.type in _OPEN_ENDED:
            raise _problem("unclosed", f"expected a datum after `{last}`", last, len(last), Completeness.INCOMPLETE)


_OPEN_ENDED = ("PREFIX", "DATUM_COMMENT")


def _check_neighbours(token: Token, last: Token) -> None:
    kind = token.type
    if kind == "LSQB" and last.type == "ATOM" and last.end_pos == token.start_pos and "::" not in last:
        hint = f"write `(ref {_short(last)} 0)`, or leave a space before `[`"
        raise _wrong("bad-atom", f"invalid indexing syntax `{_short(last)}[`", token, hint)
    if kind in ("RPAR", "RSQB"):
        if last.type in _OPEN_ENDED:
            raise _wrong("syntax", f"expected a datum after `{last}`", last)
        if last.type == "DOT":
            raise _bad_dot(last)
    elif kind == "DOT" and last.type in ("LPAR", "LSQB", "DOT", *_OPEN_ENDED):
        raise _bad_dot(token)


class _ReadProblem(Exception):
    """Unmatched brackets. Locations are offsets because the lexer does not know the source."""

    def __init__(self, name: str, message: str, start: int, end: int, state: Completeness, hint: str | None) -> None:
        super().__init__(message)
        self.name, self.message, self.start, self.end, self.state, self.hint = name, message, start, end, state, hint
        self.notes: list[tuple[str, int]] = []

    def note(self, message: str, token: Token) -> None:
        self.notes.append((message, token.start_pos or 0))

    def diagnostic(self, source: Source) -> Diagnostic:
        notes = tuple(Note(message, Span(source, start, start + 1)) for message, start in self.notes)
        return Diagnostic(self.name, self.message, Span(source, self.start, self.end), self.hint, notes)


def _problem(name: str, message: str, token: Token, width: int, state: Completeness, hint: str = "") -> _ReadProblem:
    start = token.start_pos or 0
    return _ReadProblem(name, message, start, start + width, state, hint or None)


def _wrong(name: str, message: str, token: Token, hint: str = "") -> _ReadProblem:
    return _problem(name, message, token, len(token), Completeness.WRONG, hint)


def _bad_dot(token: Token) -> _ReadProblem:
    hint = "write a pair as `(a . b)`, with exactly one datum after the dot"
    return _wrong("bad-dot", "unexpected dot outside a pair", token, hint)


# --- atoms -----------------------------------------------------------------------------------------------------

_INTEGER = re.compile(r"[+-]?\d+\Z")
_FLOAT = re.compile(r"[+-]?(?:\d+\.\d*|\.\d+|\d+)(?:[eE][+-]?\d+)?\Z")
_NUMBER_LIKE = re.compile(r"[+-]?\.?\d")
_HANDLE = re.compile(r"<([A-Za-z][A-Za-z0-9_-]*\*?)>\Z")
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


_KEYWORD_NAME = re.compile(r"""[^\s()\[\]{}";'`,:|#]+\Z""")


def is_keyword_name(text: str) -> bool:
    """Return whether ``:text`` always reads as one keyword of that name."""
    return text.isprintable() and _KEYWORD_NAME.match(text) is not None


def _number(text: str) -> int | float:
    if _INTEGER.match(text):
        if len(text) > _MAX_DIGITS:
            message = f"integer literal with {len(text):,} digits exceeds the limit of {_MAX_DIGITS:,}"
            raise SceneError("bad-atom", message)
        return int(text)
    if _FLOAT.match(text):
        return float(text)
    hint = "add a space after the number; a name must not start with a digit"
    if re.fullmatch(r"[+-]?\d+/\d+", text):
        top, bottom = text.split("/")
        hint = f"there are no fraction literals; write `(/ {top} {bottom})`"
    raise SceneError("bad-atom", f"invalid number `{_short(text)}`", hint)


def _short(text: str) -> str:
    shown = "".join(c if c.isprintable() else "�" for c in text[:40])
    return shown + "..." if len(text) > 40 else shown


_ESCAPES = {
    "n": "\n", "t": "\t", "r": "\r", '"': '"', "\\": "\\", "a": "\a", "b": "\b", "0": "\0",
}  # fmt: skip
_ESCAPE = re.compile(r"\\(?:x([0-9A-Fa-f]+);|u([0-9A-Fa-f]{4})|([ \t]*\r?\n[ \t]*)|(.))", re.S)


def _unescape(body: str) -> str:
    if "\\" not in body:
        return body

    def replacement(match: re.Match[str]) -> str:
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


@v_args(inline=True)
class _Builder(Transformer[Token, Any]):
    """Builds datums bottom-up during parsing; problems of malformed atoms are collected rather than raised."""

    def begin(self, source: Source, problems: list[Diagnostic]) -> None:
        self._source = source
        self._problems = problems

    def _span(self, first: Token, last: Token) -> Span:
        return Span(self._source, first.start_pos or 0, last.end_pos or 0)

    def _leaf(self, token: Token, parse: Callable[[str], Any], text: str) -> Atom:
        span = self._span(token, token)
        try:
            return Atom(parse(text), span)
        except SceneError as error:
            at = error.value if type(error.value) is int else None  # offset of the error within the text
            error.span = span if at is None else Span(self._source, span.start + at, min(span.start + at + 2, span.end))
            self._problems.append(error.diagnostic)
            return Atom(None, span)

    def atom(self, token: Token) -> Atom:
        return self._leaf(token, atom_value, str(token))

    def string(self, token: Token) -> Atom:
        return self._leaf(token, _unescape, token[1:-1])

    def proper_list(self, opener: Token, *rest: Any) -> ListDatum:
        return ListDatum(_without_skipped(rest[:-1]), None, self._span(opener, rest[-1]))

    def dotted_list(self, opener: Token, *rest: Any) -> ListDatum:
        dot = next(i for i, item in enumerate(rest) if isinstance(item, Token) and item.type == "DOT")
        before, after = _without_skipped(rest[:dot]), _without_skipped(rest[dot + 1 : -1])
        span = self._span(opener, rest[-1])
        if len(after) != 1 or not before:
            hint = "write a pair as `(a . b)`, with exactly one datum after the dot"
            self._problems.append(Diagnostic("bad-dot", "unexpected dot outside a pair", span, hint))
            return ListDatum(before + after, None, span)
        if isinstance(after[0], ListDatum):
            return ListDatum(before + after[0].items, after[0].tail, span)
        return ListDatum(before, after[0], span)

    def array(self, opener: Token, *rest: Any) -> ArrayDatum:
        return ArrayDatum(_without_skipped(rest[:-1]), self._span(opener, rest[-1]))

    def prefixed(self, prefix: Token, *rest: Any) -> ListDatum:
        head = Atom(Symbol(PREFIXES[str(prefix)]), self._span(prefix, prefix))
        return ListDatum((head, rest[-1]), None, Span(self._source, prefix.start_pos or 0, rest[-1].span.end))

    def skipped(self, *_: Any) -> Any:
        return _SKIPPED

    def start(self, *rest: Any) -> tuple[Any, ...]:
        return _without_skipped(rest)


def _without_skipped(items: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(item for item in items if item is not _SKIPPED) if _SKIPPED in items else tuple(items)


class _Parser:
    """The Lark parser and its transformer. Lark couples the two, so a lock admits one text at a time."""

    def __init__(self) -> None:
        self._builder = _Builder()
        self._lark = build_parser("reader.lark", "start", _BracketLexer, self._builder)
        self._lock = Lock()

    def parse(self, text: str, source: Source, problems: list[Diagnostic]) -> tuple[Datum, ...]:
        with self._lock:
            self._builder.begin(source, problems)
            forms: tuple[Datum, ...] = self._lark.parse(text)  # type: ignore[assignment]
            return forms

    def terminals(self) -> list[tuple[str, str]]:
        """Return the names and regular expressions of the grammar's terminals, in the order the lexer tries them."""
        order = lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name)
        return [(t.name, t.pattern.to_regexp()) for t in sorted(self._lark.terminals, key=order)]


@cache
def _parser() -> _Parser:
    return _Parser()


def prepare() -> None:
    """Load the parser tables now, on behalf of sandboxed threads that cannot write the cache."""
    _parser()


@cache
def terminals() -> re.Pattern[str]:
    """Return a pattern with the grammar's terminals as named groups; names of ignored terminals start with ``__``."""
    return re.compile("|".join(f"(?P<{name}>{pattern})" for name, pattern in _parser().terminals()))


_BLOCK = re.compile(r'"(?:[^"\\]|\\.)*"|#;|;[^\n]*|#\||\|#', re.S)


def block_comments(text: str) -> list[tuple[int, int]]:
    """Return the ranges of the outermost ``#| |#`` comments; raise ``_ReadProblem`` for an unclosed one."""
    found: list[tuple[int, int]] = []
    search = 0 if "#|" in text else len(text)
    while (match := _BLOCK.search(text, search)) is not None:
        search = match.end()
        if match[0] == "#|":
            search = _block_end(text, match.start())
            found.append((match.start(), search))
    return found


def without_comments(text: str, places: Sequence[tuple[int, int]]) -> str:
    """Replace the ``#| |#`` comments at ``places`` with blanks; offsets and line endings are preserved."""
    pieces: list[str] = []
    position = 0
    for start, end in places:
        pieces += [text[position:start], _blank(text[start:end])]
        position = end
    return "".join([*pieces, text[position:]]) if places else text


def _block_end(text: str, start: int) -> int:
    end = _block_comment_end(text, start)
    if end is not None:
        return end
    message = "unclosed `#|` comment"
    hint = "block comments nest: close every `#|` with its own `|#`"
    raise _ReadProblem("unclosed", message, start, start + 2, Completeness.INCOMPLETE, hint)


def read_comments(source: Source) -> tuple[Span, ...]:
    """Return the comments of a text in order: ``; line``, ``#| block |#``, and the ``#;`` of a datum comment."""
    found: list[Span] = []
    search = 0
    while (match := _BLOCK.search(source.text, search)) is not None:
        start, search = match.span()
        if match[0] == "#|":
            try:
                search = _block_end(source.text, start)
            except _ReadProblem:
                search = len(source.text)
        if match[0][0] in "#;" and match[0] != "|#":
            found.append(Span(source, start, search))
    return tuple(found)


def read(source: Source) -> ReadResult:
    """Read all datums of ``source``. Never raises: errors are returned in ``diagnostics``."""
    return _read(source, source.text)


def read_pieces(source: Source) -> ReadResult:
    """Read ``source`` with error recovery: chunks that do not parse are skipped, and all others are read."""
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


_MAX_WRONG = 20  # maximum number of malformed chunks that are reported
_MAX_RETRIED = 1_000_000


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
    problems: list[Diagnostic] = []
    try:
        forms = _parser().parse(without_comments(text, block_comments(text)), source, problems)
    except _ReadProblem as problem:
        return ReadResult(source, (), (*problems, problem.diagnostic(source)), problem.state)
    except UnexpectedCharacters as unexpected:  # only an unclosed string leaves no token
        start = unexpected.pos_in_stream or 0
        diagnostic = Diagnostic("unclosed", "unclosed string", Span(source, start, start + 1))
        return ReadResult(source, (), (*problems, diagnostic), Completeness.INCOMPLETE)
    except UnexpectedToken as unexpected:  # such as a prefix with only a comment after it
        if unexpected.token.type == "$END":
            last = len(text.rstrip())
            span = Span(source, last - 1, last)
            diagnostic = Diagnostic("unclosed", "unexpected end of input, expected a datum", span)
            return ReadResult(source, (), (*problems, diagnostic), Completeness.INCOMPLETE)
        start = unexpected.token.start_pos or 0
        diagnostic = Diagnostic("syntax", "expected a datum before this", Span(source, start, start + 1))
        return ReadResult(source, (), (*problems, diagnostic), Completeness.WRONG)
    state = Completeness.WRONG if problems else Completeness.COMPLETE
    return ReadResult(source, forms, tuple(problems), state)
