"""Text -> datums with spans, by ``reader.lark``. Tells complete, incomplete and wrong text apart, for the REPL."""

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

# Building Lark parsers. Their tables are kept in the user's cache folder, since building them takes a while.


def build_parser(grammar: str, start: str, lexer: Any, transformer: Any = None) -> Lark:
    """The LALR parser of a grammar file of this package. Lark checks that cached tables belong to its text."""
    text = Path(__file__).with_name(grammar).read_text("utf-8")
    options: dict[str, Any] = {"parser": "lalr", "lexer": lexer, "start": start, "transformer": transformer}
    folder = _cache_folder()
    if folder is not None:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        options["cache"] = str(folder / f"{Path(grammar).stem}-{start}-{version}.tables")
    return Lark(text, **options)


def _cache_folder() -> Path | None:
    """The folder for cached tables, or None where none can be written."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folder = Path(base) / "scenelang"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


# A text cut into its top-level pieces, so that one can be read again without the others.
#
# Whether a text reads is the reader's business; this scanner only matches brackets. Where they do not match, a piece
# ends where the next one seems to begin: at an opening bracket in the first column.


_TOKEN = re.compile(
    r"""(?P<space>\s+)|(?P<comment>;[^\n]*)|(?P<block>\#\|)|(?P<hide>\#;)|(?P<string>"(?:[^"\\]|\\.)*")"""
    r"""|(?P<open>[(\[])|(?P<close>[)\]])|(?P<prefix>'|`|,@|,)|(?P<atom>[^\s()\[\]";'`,]+)|(?P<other>.)""",
    re.S,
)
_EDGE = re.compile(r"#\||\|#")
_FIRST_COLUMN = re.compile(r"^[(\[]", re.M)


@dataclass(frozen=True)
class Chunk:
    """``text`` stands at ``start`` of the whole text, ``column`` characters (from 0) into its line; ``matched``: its
    brackets, strings and comments are closed."""

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
        """Where text seems to begin anew."""
        return [match.start() for match in _FIRST_COLUMN.finditer(self.text)]

    def next_resumption(self, after: int) -> int:
        return next((start for start in self.resumptions if start > after), len(self.text))


def split(text: str) -> tuple[Chunk, ...]:
    """The pieces of ``text`` in order: usually one form each. What lies between them is blanks and comments."""
    return tuple(_pieces(_Scan(text)))


def _pieces(scan: _Scan) -> Iterator[Chunk]:
    position = 0
    held: list[Chunk] = []  # a piece of the first column and the indented ones after it
    while (found := _next_piece(scan, position)) is not None:
        chunk, position = found
        if scan.text[chunk.start] in ")]" and held:  # one of these ended too early, perhaps
            held = [Chunk(held[0].start, scan.text[held[0].start : position], held[0].column, matched=False)]
        elif chunk.column == 0:
            yield from held
            held = [chunk]
        else:
            held.append(chunk)
    yield from held


def _next_piece(scan: _Scan, position: int) -> tuple[Chunk, int] | None:
    """The first piece from ``position`` on, and where the search for the next one begins."""
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


# --- a text after an edit --------------------------------------------------------------------------------------------


def split_again(text: str, before: str, chunks: Sequence[Chunk]) -> tuple[Chunk, ...]:
    """What ``split(text)`` gives; ``chunks`` are the pieces of the text ``before``, of which those around the edit are
    used again."""
    if not all(chunk.matched for chunk in chunks):
        return split(text)
    head = _common_start(text, before)
    kept = [chunk for chunk in chunks if chunk.end < head]
    tail = _common_start(text[head:][::-1], before[head:][::-1])
    shift = len(text) - len(before)
    after = {chunk.start + shift: i for i, chunk in enumerate(chunks) if chunk.start > len(before) - tail}
    scan, position, found = _Scan(text), kept[-1].end if kept else 0, list(kept)
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
    """How many characters two texts begin with alike."""
    low, high = 0, min(len(a), len(b))
    while low < high:
        middle = (low + high + 1) // 2
        if a[low:middle] == b[low:middle]:
            low = middle
        else:
            high = middle - 1
    return low


def _skip_blank(text: str, position: int) -> int | None:
    """Where the next piece begins; None at the end."""
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
    """Where the nested ``#|`` comment at ``start`` ends, None where it is not closed."""
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
    """Where the piece that begins at ``position`` ends; None when it is never closed. Pieces that touch are one."""
    open_brackets: list[str] = []
    wanted = False  # a prefix still wants its datum
    while (match := _TOKEN.match(text, position)) is not None:
        kind, start = match.lastgroup, position
        position = match.end()
        if kind == "open":
            open_brackets.append(match[0])
            wanted = False
        elif kind == "close":
            if not open_brackets:
                return _End(position, False)
            if open_brackets.pop() != _OPENING[match[0]]:
                return None
            wanted = False
        elif kind == "prefix" or kind == "hide":
            wanted = True
        elif kind == "block":
            end = _block_comment_end(text, start)
            if end is None:
                return None
            position = end
        elif kind == "other":
            return None  # a string that is never closed
        elif kind in ("atom", "string"):
            wanted = False
        if not open_brackets and not wanted and (kind in ("space", "comment") or _is_gap(text, position)):
            return _End(position, True)
    return None if open_brackets or wanted else _End(position, True)


def _is_gap(text: str, position: int) -> bool:
    """Whether what follows cannot join: white space, a comment, most brackets, the end."""
    return position >= len(text) or text[position] in " \t\r\n\f\v;()]"


def lexemes(text: str, start: int, end: int) -> Iterator[tuple[str, int, int]]:
    """The tokens between two offsets, however broken the text: kind (space, comment, block, hide, string, open, close,
    prefix, atom, other), start and end."""
    position = start
    while position < end and (match := _TOKEN.match(text, position)) is not None:
        kind = str(match.lastgroup)
        position = match.end()
        if kind == "block":
            position = _block_comment_end(text, match.start()) or len(text)
        elif kind == "other" and match[0] == '"':
            position = len(text)  # a string that is never closed
        yield kind, match.start(), position


def piece_at(text: str, position: int) -> tuple[int, int]:
    """Where the first piece after ``position`` begins and ends, inside a form too; empty when none follows."""
    begin = _skip_blank(text, position)
    if begin is None:
        return len(text), len(text)
    closed = _piece_end(text, begin)
    return begin, len(text) if closed is None else closed.end


MAX_NESTING = 5_000
_MAX_DIGITS = 4_000


class Completeness(Enum):
    COMPLETE = "complete"
    INCOMPLETE = "incomplete"  # more input could make it right
    WRONG = "wrong"


@dataclass(frozen=True, slots=True)
class ReadResult:
    """``forms`` are the datums read; they are empty when the brackets do not match."""

    source: Source
    forms: tuple[Datum, ...]
    diagnostics: tuple[Diagnostic, ...]
    completeness: Completeness


# --- brackets --------------------------------------------------------------------------------------------------

_OPENER = {"RPAR": "LPAR", "RSQB": "LSQB"}
_CLOSING = {"LPAR": ")", "LSQB": "]"}


class _BracketLexer(BasicLexer):
    """Checks brackets, dots and nesting on the way to the parser, where the opener at fault is still known."""

    __future_interface__ = 1

    def lex(self, lexer_state: LexerState, parser_state: Any) -> Iterator[Token]:
        brackets = _Brackets()
        for token in super().lex(lexer_state, parser_state):
            brackets.check(token)
            yield token
        brackets.check_end()


class _Brackets:
    """The brackets open at a point of the text, and the places where indentation and nesting disagree."""

    def __init__(self) -> None:
        self.openers: list[Token] = []
        self.depths: list[int] = [0]  # nesting at each opener, prefixes such as `'` counted
        self.prefixes = 0  # prefixes just before this point
        self.last: Token | None = None
        self.suspect: Token | None = None  # the first opener that a later line steps out of before it is closed
        self.early: Token | None = None  # the last top-level closer that an indented line follows

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
            raise _wrong("nesting", f"parentheses nested deeper than {MAX_NESTING:,}", token)

    def _note_indentation(self, token: Token, last: Token) -> None:
        column = token.column or 1
        if self.openers and self.suspect is None and column <= (self.openers[-1].column or 1):
            self.suspect = self.openers[-1]
        if not self.openers and column > 1 and last.type == "RPAR":
            self.early = last

    def _close(self, kind: str, token: Token) -> None:
        if not self.openers:
            error = _wrong(
                "extra-close", f"this `{token}` closes nothing", token, "remove it, or look for a `(` missing"
            )
            if self.early is not None:
                error.note("the form before it ended here, although the next line is indented", self.early)
            raise error
        opener = self.openers[-1]
        if opener.type != _OPENER[kind]:
            wanted = _CLOSING[opener.type]
            error = _wrong("extra-close", f"this `{token}` closes a `{opener}`, which wants `{wanted}`", token)
            error.note("opened here", opener)
            raise error
        self.openers.pop()
        self.depths.pop()

    def check_end(self) -> None:
        last = self.last
        if self.openers:
            opener = self.suspect or self.openers[-1]
            raise _problem("unclosed", f"this `{opener}` is never closed", opener, 1, Completeness.INCOMPLETE)
        if last is not None and last.type in _OPEN_ENDED:
            raise _problem("unclosed", f"`{last}` is followed by nothing", last, len(last), Completeness.INCOMPLETE)


_OPEN_ENDED = ("PREFIX", "DATUM_COMMENT")


def _check_neighbours(token: Token, last: Token) -> None:
    kind = token.type
    if kind == "LSQB" and last.type == "ATOM" and last.end_pos == token.start_pos and "::" not in last:
        hint = f"write `(ref {_short(last)} 0)`, or leave a space before `[`"
        raise _wrong("bad-atom", f"`{_short(last)}[` is no way to index", token, hint)
    if kind in ("RPAR", "RSQB"):
        if last.type in _OPEN_ENDED:
            raise _wrong("syntax", f"`{last}` must be followed by something", last)
        if last.type == "DOT":
            raise _bad_dot(last)
    elif kind == "DOT" and last.type in ("LPAR", "LSQB", "DOT", *_OPEN_ENDED):
        raise _bad_dot(token)


class _ReadProblem(Exception):
    """A text whose brackets do not match, with offsets for places: the lexer does not know the source."""

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
    hint = "a pair is `(a . b)`: something before the dot and one datum after it"
    return _wrong("bad-dot", "a dot stands where no pair can be", token, hint)


# --- atoms -----------------------------------------------------------------------------------------------------

_INTEGER = re.compile(r"[+-]?\d+\Z")
_FLOAT = re.compile(r"[+-]?(?:\d+\.\d*|\.\d+|\d+)(?:[eE][+-]?\d+)?\Z")
_NUMBER_LIKE = re.compile(r"[+-]?\.?\d")
_HANDLE = re.compile(r"<([A-Za-z][A-Za-z0-9_-]*\*?)>\Z")
_LITERALS = {"#t": True, "#true": True, "#f": False, "#false": False}


def atom_value(text: str) -> Any:
    """The value of an atom; raises SceneError (without place) for one that is malformed."""
    first = text[0]
    if first.isdigit() or (first in "+-." and _NUMBER_LIKE.match(text)):
        return _number(text)
    if first == ":":
        if len(text) == 1 or text[1] == ":":
            raise SceneError("bad-atom", f"`{_short(text)}` is no keyword", "a keyword is `:name`")
        return Keyword(text[1:])
    if first == "<":
        match = _HANDLE.match(text)
        if match:
            return Handle(match[1])
    elif first == "#":
        if text in _LITERALS:
            return _LITERALS[text]
        hint = 'booleans are `#t` and `#f`; a text is a string, "..."; an array is `[1 2 3]`'
        raise SceneError("bad-atom", f"`{_short(text)}` means nothing here", hint)
    elif text == "none":
        return None
    if not text.isprintable():
        raise SceneError("bad-atom", f"`{_short(text)}` holds characters that cannot be seen")
    return Symbol(text)


_KEYWORD_NAME = re.compile(r"""[^\s()\[\]{}";'`,:|#]+\Z""")


def is_keyword_name(text: str) -> bool:
    """Whether ``:text`` reads as one keyword of that name, wherever it stands."""
    return text.isprintable() and _KEYWORD_NAME.match(text) is not None


def _number(text: str) -> int | float:
    if _INTEGER.match(text):
        if len(text) > _MAX_DIGITS:
            raise SceneError("bad-atom", f"an integer of {len(text):,} digits is too long")
        return int(text)
    if _FLOAT.match(text):
        return float(text)
    hint = "is a space missing after the number? a name must not begin with a digit"
    if re.fullmatch(r"[+-]?\d+/\d+", text):
        top, bottom = text.split("/")
        hint = f"there are no fractions; write `(/ {top} {bottom})`"
    raise SceneError("bad-atom", f"`{_short(text)}` begins like a number and is none", hint)


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
                raise SceneError("bad-string", f"`{_short(match[0])}` is no character", value=match.start() + 1)
            return chr(point)
        if match[3]:
            return ""
        if match[4] not in _ESCAPES:
            hint = 'the escapes are \\n \\t \\r \\a \\b \\0 \\" \\\\ \\x41; \\u0041'
            raise SceneError("bad-string", f"there is no escape `\\{_short(match[4])}`", hint, value=match.start() + 1)
        return _ESCAPES[match[4]]

    return _ESCAPE.sub(replacement, body)


# --- trees -----------------------------------------------------------------------------------------------------

_SKIPPED = object()


@v_args(inline=True)
class _Builder(Transformer[Token, Any]):
    """Builds datums bottom up while the parser runs; malformed atoms are collected, not raised."""

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
            at = error.value if type(error.value) is int else None  # where in the text the fault is
            error.span = span if at is None else Span(self._source, span.start + at, min(span.start + at + 2, span.end))
            self._problems.append(error.diagnostic)
            return Atom(None, span)

    def atom(self, token: Token) -> Atom:
        return self._leaf(token, atom_value, str(token))

    def string(self, token: Token) -> Atom:
        return self._leaf(token, _unescape, token[1:-1])

    def proper_list(self, opener: Token, *rest: Any) -> ListDatum:
        return ListDatum(_kept(rest[:-1]), None, self._span(opener, rest[-1]))

    def dotted_list(self, opener: Token, *rest: Any) -> ListDatum:
        dot = next(i for i, item in enumerate(rest) if isinstance(item, Token) and item.type == "DOT")
        before, after = _kept(rest[:dot]), _kept(rest[dot + 1 : -1])
        span = self._span(opener, rest[-1])
        if len(after) != 1 or not before:
            hint = "a pair is `(a . b)`: something before the dot and one datum after it"
            self._problems.append(Diagnostic("bad-dot", "a dot stands where no pair can be", span, hint))
            return ListDatum(before + after, None, span)
        if isinstance(after[0], ListDatum):
            return ListDatum(before + after[0].items, after[0].tail, span)
        return ListDatum(before, after[0], span)

    def array(self, opener: Token, *rest: Any) -> ArrayDatum:
        return ArrayDatum(_kept(rest[:-1]), self._span(opener, rest[-1]))

    def prefixed(self, prefix: Token, *rest: Any) -> ListDatum:
        head = Atom(Symbol(PREFIXES[str(prefix)]), self._span(prefix, prefix))
        return ListDatum((head, rest[-1]), None, Span(self._source, prefix.start_pos or 0, rest[-1].span.end))

    def skipped(self, *_: Any) -> Any:
        return _SKIPPED

    def start(self, *rest: Any) -> tuple[Any, ...]:
        return _kept(rest)


def _kept(items: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(item for item in items if item is not _SKIPPED) if _SKIPPED in items else tuple(items)


class _Parser:
    """The parser and its builder. Lark ties the two together, so one text at a time goes through them."""

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
        """Names and regular expressions of the grammar's terminals, in the order in which its lexer tries them."""
        order = lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name)
        return [(t.name, t.pattern.to_regexp()) for t in sorted(self._lark.terminals, key=order)]


@cache
def _parser() -> _Parser:
    return _Parser()


def prepare() -> None:
    """Load the parser's tables now, for a thread that will not be able to save them."""
    _parser()


@cache
def terminals() -> re.Pattern[str]:
    """A pattern of the grammar's terminals as named groups; what is ignored has a name that begins with ``__``."""
    return re.compile("|".join(f"(?P<{name}>{pattern})" for name, pattern in _parser().terminals()))


_BLOCK = re.compile(r'"(?:[^"\\]|\\.)*"|#;|;[^\n]*|#\||\|#', re.S)


def block_comments(text: str) -> list[tuple[int, int]]:
    """Where the outermost ``#| |#`` comments begin and end; raises _ReadProblem for one never closed."""
    found: list[tuple[int, int]] = []
    search = 0 if "#|" in text else len(text)
    while (match := _BLOCK.search(text, search)) is not None:
        search = match.end()
        if match[0] == "#|":
            search = _block_end(text, match.start())
            found.append((match.start(), search))
    return found


def without_comments(text: str, places: Sequence[tuple[int, int]]) -> str:
    """``text`` with the ``#| |#`` comments at ``places`` blanked, offsets and line ends kept."""
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
    message = "this `#|` comment is never closed"
    hint = "comments nest: every `#|` inside wants a `|#` of its own"
    raise _ReadProblem("unclosed", message, start, start + 2, Completeness.INCOMPLETE, hint)


def read_comments(source: Source) -> tuple[Span, ...]:
    """The comments of a text in order: ``; line``, ``#| block |#``, and the ``#;`` that hides a datum."""
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
    """Read every datum of ``source``. Never raises: what is wrong is in ``diagnostics``."""
    return _read(source, source.text)


def read_pieces(source: Source) -> ReadResult:
    """Like ``read``, but what stands around a piece that does not read, such as one whose brackets do not match, is
    read all the same."""
    result = read(source)
    if result.forms or result.completeness is Completeness.COMPLETE or len(source.text) > _LONGEST_RETRIED:
        return result
    chunks = split(source.text)
    wrong = [chunk for chunk in chunks if not chunk.matched]
    rest = result
    while len(wrong) <= _MOST_WRONG:
        rest = _read(source, _without(source.text, wrong))
        if rest.forms or rest.completeness is Completeness.COMPLETE:
            break
        place = rest.diagnostics[-1].span
        named = [chunk for chunk in chunks if place is not None and chunk.start <= place.start < chunk.end]
        if not named:
            break
        wrong += named
    problems = list(rest.diagnostics if rest.forms else ())
    for chunk in wrong[:_MOST_WRONG]:
        problems += _read(source, _blank(source.text[: chunk.start]) + chunk.text).diagnostics
    if not problems:
        return result
    return ReadResult(source, rest.forms, tuple(problems), result.completeness)


_MOST_WRONG = 20  # pieces that do not read are reported up to this number
_LONGEST_RETRIED = 1_000_000


def _without(text: str, chunks: Sequence[Chunk]) -> str:
    """``text`` with blanks in place of some pieces."""
    for chunk in chunks:
        text = text[: chunk.start] + _blank(chunk.text) + text[chunk.end :]
    return text


def _blank(text: str) -> str:
    """White space of the same lines and columns."""
    return re.sub(r"[^\n]", " ", text)


def _read(source: Source, text: str) -> ReadResult:
    """Read ``text``, which is that of ``source`` or has blanks in place of some of it."""
    problems: list[Diagnostic] = []
    try:
        forms = _parser().parse(without_comments(text, block_comments(text)), source, problems)
    except _ReadProblem as problem:
        return ReadResult(source, (), (*problems, problem.diagnostic(source)), problem.state)
    except UnexpectedCharacters as unexpected:  # every other character begins a token
        start = unexpected.pos_in_stream or 0
        diagnostic = Diagnostic("unclosed", "this string is never closed", Span(source, start, start + 1))
        return ReadResult(source, (), (*problems, diagnostic), Completeness.INCOMPLETE)
    except UnexpectedToken as unexpected:  # such as a prefix with only a comment after it
        if unexpected.token.type == "$END":
            last = len(text.rstrip())
            diagnostic = Diagnostic("unclosed", "the text ends where a datum is wanted", Span(source, last - 1, last))
            return ReadResult(source, (), (*problems, diagnostic), Completeness.INCOMPLETE)
        start = unexpected.token.start_pos or 0
        diagnostic = Diagnostic("syntax", "a datum is wanted before this", Span(source, start, start + 1))
        return ReadResult(source, (), (*problems, diagnostic), Completeness.WRONG)
    state = Completeness.WRONG if problems else Completeness.COMPLETE
    return ReadResult(source, forms, tuple(problems), state)
