"""Where a bracket that is missing or superfluous was meant: the edits that make a text read and fit its indentation.

Most programs are indented by hand or by a tool as they were meant, so that the lines show where a form ends. The edits
that contradict the fewest lines are candidates; what they mean for the program decides among them (``Session.check``).
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from scenelang.grammar.datum import Source, Span, dataclass, field, replace
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.grammar.reader import Chunk, lexemes, split

MAX_CHUNKS = 4  # malformed forms of a text that are repaired
_MAX_TOKENS = 4_000  # of a malformed form
_MAX_TRIED = 300  # edits of a form whose indentation is compared
_MAX_FOUND = 16
_SHOWN = 30  # characters before an edit that a hint shows
_LEFT, _OUTSIDE = 2, 1  # what a line costs that begins left of its list, or where nothing in it lines up
_PAIRS = {"(": ")", "[": "]"}


class BracketEdit(NamedTuple):
    """Replacement of the text from ``start`` to ``end``, offsets of the whole text, by brackets or nothing."""

    start: int
    end: int
    text: str


@dataclass(frozen=True, eq=False)
class Recovered:
    """A text whose brackets match, after edits in the order in which they were made, and the text as it was written."""

    written: Source
    source: Source
    edits: tuple[BracketEdit, ...] = ()

    def edited(self, edit: BracketEdit) -> Recovered:
        text = self.source.text
        source = Source(self.written.name, text[: edit.start] + edit.text + text[edit.end :])
        return Recovered(self.written, source, (*self.edits, edit))

    def original(self, span: Span) -> Span:
        """Return the place of a span of the edited text in the text as it was written."""
        if span.source is not self.source:
            return span
        return Span(self.written, self._offset(span.start), self._offset(span.end), span.expansion)

    def _offset(self, offset: int) -> int:
        for edit in reversed(self.edits):
            after = edit.start + len(edit.text)
            if offset >= after and offset > edit.start:
                offset += edit.end - after
            elif offset > edit.start:
                offset = edit.start
        return offset

    def explained(self, problems: Sequence[Diagnostic], is_sure: bool) -> list[Diagnostic]:
        """Return what was wrong with the brackets, each with the edit of its form as a fix.

        ``is_sure`` says that the edited text has no errors. A superfluous bracket that is reported where it stands is
        then surely the one.
        """
        found: list[Diagnostic] = []
        edits = [self._written_edit(i) for i in range(len(self.edits))]
        chunks = wrong_chunks(self.written.text)
        for problem in problems:
            at = problem.span.start if problem.span is not None else -1
            chunk = next((chunk for chunk in chunks if chunk.start <= at < chunk.end), None)
            edit = next((e for e in edits if chunk is not None and chunk.start <= e.start <= chunk.end), None)
            if "string" in problem.message:  # which is not closed where it seems to begin
                edit = next((e for e in edits if e.text == '"'), None)
            if edit is None or problem.name not in ("unclosed", "extra-close"):
                found.append(problem)
                continue
            span = Span(self.written, edit.start, edit.end)
            is_same = is_sure and not edit.text and span == problem.span
            title, hint = _advice(self.written, edit)
            fix = Fix(title, (Edit(span, edit.text),), safe=is_same)
            found.append(replace(problem, hint=hint, notes=(), fixes=(fix,)))
        return found

    def _written_edit(self, number: int) -> BracketEdit:
        before = replace(self, edits=self.edits[:number])
        edit = self.edits[number]
        return BracketEdit(before._offset(edit.start), before._offset(edit.end), edit.text)


def _advice(source: Source, edit: BracketEdit) -> tuple[str, str]:
    """Return the title of a fix, and a hint that says where it is made."""
    line = source.position(edit.start)[0]
    before = source.text[source.line_start(line) : edit.start].strip()
    place = f"after `{before[-_SHOWN:].strip()}` in line {line}" if before else f"in line {line}"
    if not edit.text:
        return "Remove the bracket", f"remove `{source.text[edit.start : edit.end]}` {place}"
    if edit.start == edit.end:
        return f"Add `{edit.text}`", f"add `{edit.text}` {place}"
    return f"Change to `{edit.text}`", f"write `{edit.text}` for `{source.text[edit.start : edit.end]}` {place}"


class _Token(NamedTuple):
    text: str
    start: int
    end: int
    column: int
    is_first: bool  # of its line


@dataclass(slots=True)
class _Frame:
    """An open list: its bracket, the column of it and of its second item, and the columns where its lines begin."""

    opener: str
    column: int
    items: int = 0
    second: int = -1
    starts: set[int] = field(default_factory=set)


def wrong_chunks(text: str) -> list[Chunk]:
    """Return the top-level pieces of a text whose brackets do not match."""
    return [chunk for chunk in split(text) if not chunk.matched][:MAX_CHUNKS]


def bracket_edits(chunk: Chunk) -> list[BracketEdit]:
    """Return the edits that make a piece read, those that fit its indentation best.

    They are in the order of the text, at most 16, and each makes another text. If more brackets are missing than one
    edit can add, the first of them is returned, behind which others are still missing.
    """
    tokens = _tokens(chunk)
    if tokens is None:
        return []
    missing = _missing(tokens)
    cost, found = _best(chunk, tokens, _edits(tokens, *missing), 0)
    if sum(missing) > 1 and min(missing) >= 0:
        single = (1, 0) if missing[0] else (0, 1)
        part, several = _best(chunk, tokens, _edits(tokens, *single), sum(missing) - 1)
        if several and (not found or part < cost):
            return several[-1:]
    return found


def quote_edits(text: str) -> list[BracketEdit]:
    """Return the edits that close a string in the first line with an odd number of quotes, at the ends of its words.

    There are none if all strings are closed. Strings of several lines are not told apart: they are rare.
    """
    if not any(kind == "other" and text[start] == '"' for kind, start, _ in lexemes(text, 0, len(text))):
        return []
    start = 0
    for line in text.splitlines(keepends=True):
        quotes = [match.start() for match in _QUOTE.finditer(_COMMENT.sub(_blanked, line))]
        if len(quotes) % 2 == 1:
            places = dict.fromkeys(
                start + match.end()
                for i, quote in enumerate(quotes)
                for match in _WORD_END.finditer(line, quote + 1, quotes[i + 1] if i + 1 < len(quotes) else len(line))
            )
            return [BracketEdit(place, place, '"') for place in places][:_MAX_FOUND]
        start += len(line)
    return []


_QUOTE = re.compile(r'(?<!\\)"')
_COMMENT = re.compile(r'"(?:[^"\\\n]|\\.)*"|;[^\n]*')
_WORD_END = re.compile(r"""[^\s()\[\]";]+(?=[\s()\[\]";]|\Z)""")


def _blanked(match: re.Match[str]) -> str:
    """Return a comment as blanks, and a string as it is."""
    return match[0] if match[0].startswith('"') else " " * len(match[0])


def _best(
    chunk: Chunk, tokens: Sequence[_Token], edits: Iterator[tuple[BracketEdit, list[_Token]]], missing: int
) -> tuple[int, list[BracketEdit]]:
    """Return the least cost of edits after which some brackets are still missing, and those that have it."""
    best: dict[str, BracketEdit] = {}  # by the text that is made: the last one that makes it
    least = sys.maxsize
    for edit, changed in list(edits)[-_MAX_TRIED:]:
        cost = _cost(changed, missing)
        if cost is None or cost > least:
            continue
        if cost < least:
            least, best = cost, {}
        best[chunk.text[: edit.start - chunk.start] + edit.text + chunk.text[edit.end - chunk.start :]] = edit
    return least, list(best.values())[-_MAX_FOUND:]


def _missing(tokens: Sequence[_Token]) -> tuple[int, int]:
    """Return how many closing parentheses and brackets are missing, below 0 if there are too many."""
    counts = {bracket: sum(token.text == bracket for token in tokens) for bracket in "()[]"}
    return counts["("] - counts[")"], counts["["] - counts["]"]


def _tokens(chunk: Chunk) -> list[_Token] | None:
    """Return the tokens of a piece without comments; None if there are too many, or a string is open."""
    found: list[_Token] = []
    line = chunk.start - chunk.column
    is_first = True
    for kind, start, end in lexemes(chunk.text, 0, len(chunk.text)):
        piece = chunk.text[start:end]
        if kind == "other" or len(found) > _MAX_TOKENS:
            return None
        if kind not in ("space", "comment", "block"):
            found.append(_Token(piece, chunk.start + start, chunk.start + end, chunk.start + start - line, is_first))
            is_first = False
        if "\n" in piece:
            line = chunk.start + start + piece.rindex("\n") + 1
            is_first = kind in ("space", "block")
    return found


def _edits(tokens: Sequence[_Token], round_: int, square: int) -> Iterator[tuple[BracketEdit, list[_Token]]]:
    """Yield the edits that add or remove so many closing brackets, with the tokens that they leave."""
    limit = _first_contradiction(tokens)
    if (round_, square) in ((1, 0), (2, 0), (0, 1), (0, 2)):
        closing = ")" * round_ + "]" * square
        for i, token in enumerate(tokens[: limit + 1]):
            if token.text in _PAIRS and not _is_empty_list(tokens, i, closing):
                continue
            made = [_Token(c, token.end, token.end, token.column, False) for c in closing]
            yield BracketEdit(token.end, token.end, closing), [*tokens[: i + 1], *made, *tokens[i + 1 :]]
    elif (round_, square) in ((-1, 0), (0, -1)):
        wrong = ")" if round_ else "]"
        for i, token in enumerate(tokens[: limit + 1]):
            if token.text == wrong:
                yield BracketEdit(token.start, token.end, ""), [*tokens[:i], *tokens[i + 1 :]]
    elif (round_, square) in ((1, -1), (-1, 1)):
        wrong, right = ("]", ")") if round_ == 1 else (")", "]")
        for i, token in enumerate(tokens[: limit + 1]):
            if token.text == wrong:
                yield BracketEdit(token.start, token.end, right), [
                    *tokens[:i], token._replace(text=right), *tokens[i + 1 :],
                ]  # fmt: skip


def _is_empty_list(tokens: Sequence[_Token], i: int, closing: str) -> bool:
    """Return whether a list may be closed where it begins: that of a function without parameters, behind which a line
    ends."""
    is_behind = i > 0 and tokens[i - 1].text == "lambda"
    return is_behind and closing == ")" and (i + 1 == len(tokens) or tokens[i + 1].is_first)


def _first_contradiction(tokens: Sequence[_Token]) -> int:
    """Return the number of the token at which the brackets do not match any more, beyond which no edit can help."""
    stack: list[str] = []
    for i, token in enumerate(tokens):
        if token.text in _PAIRS:
            stack.append(_PAIRS[token.text])
        elif token.text in (")", "]") and (not stack or stack.pop() != token.text):
            return i
    return len(tokens) - 1


def _cost(tokens: Sequence[_Token], missing: int) -> int | None:
    """Return how much the lines contradict the nesting, None if brackets do not match but for some that are missing."""
    stack: list[_Frame] = []
    outer = tokens[0].column if tokens else 0
    cost = 0
    for token in tokens:
        is_closing = token.text in (")", "]")
        if token.is_first and not is_closing:
            cost += _cost_of_line(stack[-1] if stack else None, token.column, outer)
        if is_closing:
            if not stack or _PAIRS[stack.pop().opener] != token.text:
                return None
            continue
        if stack:
            frame = stack[-1]
            frame.items += 1
            if frame.items == 2:
                frame.second = token.column
            if token.is_first:
                frame.starts.add(token.column)
        if token.text in _PAIRS:
            stack.append(_Frame(token.text, token.column))
    return None if len(stack) != missing else cost


def _cost_of_line(frame: _Frame | None, column: int, outer: int) -> int:
    if frame is None:
        return 0 if column == outer else _LEFT
    if column <= frame.column:
        return _LEFT
    lined_up = frame.starts or {frame.column + 1, frame.column + 2, frame.column + 4, frame.second}
    return 0 if column in lined_up or column == frame.second else _OUTSIDE
