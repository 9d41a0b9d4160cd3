"""The reader over Lark's own lexer and parser, as it was before the tables were driven by ``grammar.lalr``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from lark import Lark, Token, Transformer, v_args
from lark.exceptions import UnexpectedCharacters, UnexpectedToken
from lark.lexer import BasicLexer, LexerState

from scenelang.grammar.datum import PREFIXES, ArrayDatum, Atom, ListDatum, Source, Span, Symbol
from scenelang.grammar.diagnostics import Diagnostic, Note, SceneError
from scenelang.grammar.reader import (
    MAX_NESTING,
    Completeness,
    ReadResult,
    _block_comment_end,
    _short,
    _unescape,
    atom_value,
    block_comments,
    without_comments,
)

GRAMMARS = Path(__file__).parents[1] / "grammar"


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
        self.indents: list[int] = []  # the column at which the line of each opener starts
        self.indent = 1
        self.suspect: tuple[Token, str, Token] | None = None  # opener that a later line is not indented beyond
        self.closed_suspect: tuple[Token, str, Token] | None = None
        self.early_close: Token | None = None  # last top-level closer that is followed by an indented line

    def check(self, token: Token) -> None:
        kind, last, openers = token.type, self.last, self.openers
        if last is None:
            self.indent = token.column or 1
            if kind == "DOT":
                raise _bad_dot(token)
        else:
            if token.line != last.end_line:
                self._note_indentation(token, last)
            _check_neighbors(token, last)
        if kind in _OPEN_ENDED:
            self.prefixes += 1
            self._check_depth(self.depths[-1] + self.prefixes, token)
        elif kind == "LPAR" or kind == "LSQB":
            openers.append(token)
            self.indents.append(self.indent)
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
        self.indent = column = token.column or 1
        if self.openers and self.suspect is None and token.type not in _OPENER and column <= self.indents[-1]:
            closing = [_CLOSING[o.type] for o, n in zip(self.openers, self.indents, strict=True) if column <= n]
            self.suspect = self.openers[-1], "".join(closing[::-1]), token
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
        self.indents.pop()
        self.depths.pop()
        if self.suspect is not None and self.suspect[0] is opener:
            self.closed_suspect, self.suspect = self.closed_suspect or self.suspect, None

    def check_end(self) -> None:
        last = self.last
        if self.openers:
            closing = "".join(_CLOSING[o.type] for o in reversed(self.openers))
            opener = self.openers[-1]
            hint = f"add `{_short(closing)}` at the end of the form"
            suspect = self.suspect or self.closed_suspect
            if suspect is not None:
                opener, closing, start = suspect
                hint = f"add `{_short(closing)}` before the line that is not indented as a part of this form"
            error = _problem("unclosed", f"unclosed `{opener}`", opener, 1, Completeness.INCOMPLETE, hint)
            if suspect is not None:
                error.note("this line", start)
            elif last is not None and last.line != opener.line:
                error.note("the form ends here", last)
            raise error
        if last is not None and last.type in _OPEN_ENDED:
            raise _problem("unclosed", f"expected a datum after `{last}`", last, len(last), Completeness.INCOMPLETE)


_OPEN_ENDED = ("PREFIX", "DATUM_COMMENT")


def _check_neighbors(token: Token, last: Token) -> None:
    kind = token.type
    if kind == "LSQB" and last.type == "ATOM" and last.end_pos == token.start_pos and "::" not in last:
        hint = f"write `(ref {_short(last)} i)` for the item at `i`, or leave a space before `[`"
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


@cache
def _lark() -> tuple[Lark, _Builder]:
    builder = _Builder()
    text = (GRAMMARS / "reader.lark").read_text("utf-8")
    return Lark(text, parser="lalr", lexer=_BracketLexer, start="start", transformer=builder), builder


def read_by_lark(source: Source) -> ReadResult:
    """Return what ``read`` returned."""
    text = source.text
    problems: list[Diagnostic] = []
    try:
        comments = block_comments(text)
        if comments and _block_comment_end(text, comments[-1][0]) is None:
            hint = "block comments nest: close every `#|` with its own `|#`"
            start = comments[-1][0]
            raise _ReadProblem("unclosed", "unclosed `#|` comment", start, start + 2, Completeness.INCOMPLETE, hint)
        lark, builder = _lark()
        builder.begin(source, problems)
        forms: Any = lark.parse(without_comments(text, comments))
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
