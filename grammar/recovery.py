"""Recovery from missing and superfluous brackets: the edits that make a text read and fit its indentation.

Programs are usually indented as they were meant, so the lines show where a form ends. The edits that contradict the
fewest lines are candidates; ``Session.check`` checks the program after each of them and takes the one with the fewest
findings.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from scenelang.grammar.datum import ListDatum, Source, Span, dataclass, field, replace, walk
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.grammar.reader import Chunk, lexemes, read_pieces, split

MAX_CHUNKS = 4  # malformed forms of a text that are repaired; each costs up to 16 checks of the program
_MAX_TOKENS = 4_000  # of a malformed form: the cost of an edit is linear in them, and there are as many edits
_MAX_TRIED = 300  # edits of a form whose indentation is compared, the last ones before the contradiction
_MAX_CANDIDATES = 16  # edits of a form that are returned: the program is checked once for each of them
_FORM_START = lazy_pattern(r"(?:[ \t]*(?:;[^\n]*)?\n)*(?=\()")  # at the margin, behind blank lines and comments
_CONTEXT_CHARACTERS = 30  # before an edit, in a hint
# Costs of a line: one that begins left of its list contradicts the nesting more than one that lines up with nothing.
_LEFT_COST, _UNALIGNED_COST = 2, 1
_PAIRS = {"(": ")", "[": "]"}


class BracketEdit(NamedTuple):
    """Replacement of the text from ``start`` to ``end``, offsets of the whole text, by brackets or nothing."""

    start: int
    end: int
    text: str


@dataclass(frozen=True, eq=False)
class Recovered:
    """Text after edits of its brackets.

    Attributes
    ----------
    written
        Text as the user wrote it.
    source
        Text after the edits.
    edits
        Edits in the order in which they were applied; their offsets are those of the text before each of them.
    """

    written: Source
    source: Source
    edits: tuple[BracketEdit, ...] = ()

    def edited(self, edit: BracketEdit) -> Recovered:
        """Return the text after one more edit."""
        text = self.source.text
        source = Source(self.written.name, text[: edit.start] + edit.text + text[edit.end :])
        return Recovered(self.written, source, (*self.edits, edit))

    def original(self, span: Span) -> Span:
        """Return the place of a span of the edited text in the text as it was written."""
        if span.source is not self.source:
            return span
        return Span(self.written, self._offset(span.start), self._offset(span.end), span.expansion)

    def _offset(self, offset: int) -> int:
        """Return the offset in the written text of an offset in the edited one."""
        for edit in reversed(self.edits):
            after = edit.start + len(edit.text)
            if offset >= after and offset > edit.start:
                offset += edit.end - after
            elif offset > edit.start:
                offset = edit.start
        return offset

    def explained(self, problems: Sequence[Diagnostic], is_sure: bool) -> list[Diagnostic]:
        """Return the bracket errors of the written text, each with the edit of its form as a fix.

        Parameters
        ----------
        problems
            Diagnostics of the written text.
        is_sure
            Whether the edited text has no errors. A fix that removes the very bracket that is reported is then safe.
        """
        explained: list[Diagnostic] = []
        edits = [self._written_edit(i) for i in range(len(self.edits))]
        chunks = wrong_chunks(self.written.text)
        for problem in problems:
            at = problem.span.start if problem.span is not None else -1
            chunk = next((chunk for chunk in chunks if chunk.start <= at < chunk.end), None)
            edit = next((e for e in edits if chunk is not None and chunk.start <= e.start <= chunk.end), None)
            if "string" in problem.message:  # an open string swallows quotes, so it seems to begin somewhere else
                edit = next((e for e in edits if e.text == '"'), None)
            if edit is None or problem.name not in ("unclosed", "extra-close"):
                explained.append(problem)
                continue
            span = Span(self.written, edit.start, edit.end)
            is_same = is_sure and not edit.text and span == problem.span
            title, hint = _advice(self.written, edit)
            fix = Fix(title, (Edit(span, edit.text),), safe=is_same)
            if edit.text == '"':
                problem = _open_string(problem, edit)
                hint = f'write `{problem.span.text if problem.span is not None else ""}"`'
            notes = () if problem.name == "unclosed" else problem.notes  # where brackets of two kinds begin
            explained.append(replace(problem, hint=hint, notes=notes, fixes=(fix,)))
        return explained

    def _written_edit(self, number: int) -> BracketEdit:
        """Return an edit with its offsets in the written text."""
        before = replace(self, edits=self.edits[:number])
        edit = self.edits[number]
        return BracketEdit(before._offset(edit.start), before._offset(edit.end), edit.text)


def _open_string(problem: Diagnostic, edit: BracketEdit) -> Diagnostic:
    """Return the error about an open string at the place where the string begins, which the next quote seems to end."""
    assert problem.span is not None
    source = problem.span.source
    start = source.text.rfind('"', 0, edit.start)
    span = Span(source, start, edit.start)
    return replace(problem, span=span, message=f"the string that begins with `{span.text}` is never closed")


def _advice(source: Source, edit: BracketEdit) -> tuple[str, str]:
    """Return the title of a fix, and a hint with its place."""
    line = source.position(edit.start)[0]
    before = source.text[source.line_start(line) : edit.start].strip()
    rest = source.line(line)[edit.end - source.line_start(line) :].rstrip("\n")
    place = f"in line {line}"
    if before and edit.start == edit.end and not rest.strip().strip(edit.text[0]):
        place = f"at the end of line {line}"
        following = _FORM_START.match(source.text, edit.end + len(rest) + 1)
        if following is not None:
            place += f": a new form begins in line {source.position(following.end())[0]}"
    elif before:
        place = f"after `{_end(before)}` in line {line}"
    if not edit.text:
        return "Remove the bracket", f"remove `{source.text[edit.start : edit.end]}` {place}"
    if edit.start == edit.end:
        return f"Add `{edit.text}`", f"add `{edit.text}` {place}"
    return f"Change to `{edit.text}`", f"write `{edit.text}` for `{source.text[edit.start : edit.end]}` {place}"


def moved_brackets(span: Span, *, only_lists: bool = False) -> Iterator[tuple[Fix, str]]:
    """Iterate over the fixes that move one closing bracket in or around the call at ``span``, with their hints.

    A list inside the call, or inside the one around it, is closed before its last item, or behind the next item; with
    ``only_lists``, if that item is a list.
    """
    source = span.source
    if span.expansion is not None:
        return
    lists = [form for form in walk(*read_pieces(source).forms) if isinstance(form, ListDatum) and form.items]
    around = [form for form in lists if form.span.start <= span.start and span.end <= form.span.end]
    around.sort(key=lambda form: form.span.end - form.span.start)
    owners = [*around[:2], *(item for form in around[:1] for item in form.items if isinstance(item, ListDatum))]
    for owner in owners:
        for number, item in enumerate(owner.items):
            if not isinstance(item, ListDatum) or not item.span.text.endswith(")") or not item.items:
                continue
            before = Span(source, item.span.end - 1, item.span.end)
            head = item.items[0].span.text
            if len(item.items) > _MIN_CLOSED and (isinstance(item.items[-1], ListDatum) or not only_lists):
                at, last = item.items[-2].span.end, item.items[-1].span
                yield _moved(source, before, at, f"close `({head}` before `{_beginning(last.text)}`")
            if number + 1 < len(owner.items) and len(item.items) >= _MIN_CLOSED:
                if only_lists and not isinstance(owner.items[number + 1], ListDatum):
                    continue
                following = owner.items[number + 1].span
                yield _moved(source, before, following.end, f"close `({head}` after `{_beginning(following.text)}`")


_MIN_CLOSED = 2  # items of a call of which one is an argument


def _moved(source: Source, before: Span, at: int, hint: str) -> tuple[Fix, str]:
    """Return the fix that moves a closing bracket to an offset, and the hint with its line."""
    edits = sorted((Edit(before, ""), Edit(Span(source, at, at), ")")), key=lambda edit: edit.span.start)
    line = source.position(at)[0]
    return Fix("Move the bracket", tuple(edits)), f"{hint}, in line {line}"


def _beginning(text: str) -> str:
    """Return the beginning of a datum for a hint."""
    text = " ".join(text.split())
    return text if len(text) <= _CONTEXT_CHARACTERS else f"{text[:_CONTEXT_CHARACTERS].rsplit(' ', 1)[0]} ..."


def _end(text: str) -> str:
    """Return the last tokens of a text that are not longer than the context of an edit, at least one."""
    tokens = [text[start:end] for _, start, end in lexemes(text, 0, len(text))]
    kept = tokens.pop()
    while tokens and len(tokens[-1]) + len(kept) <= _CONTEXT_CHARACTERS:
        kept = tokens.pop() + kept
    return kept.strip()


class _Token(NamedTuple):
    """Token of a malformed form, with offsets in the whole text."""

    text: str
    start: int
    end: int
    column: int
    is_first: bool  # of its line


@dataclass(slots=True)
class _Frame:
    """Open list: its bracket and column, the column of its second item, and those where its lines begin."""

    opener: str
    column: int
    items: int = 0
    second: int = -1
    starts: set[int] = field(default_factory=set)


def wrong_chunks(text: str) -> list[Chunk]:
    """Return the top-level pieces of a text whose brackets do not match."""
    return [chunk for chunk in split(text) if not chunk.matched][:MAX_CHUNKS]


def bracket_edits(chunk: Chunk) -> list[BracketEdit]:
    """Return the edits that balance the brackets of a piece and fit its indentation best.

    They are in the order of the text, at most 16, and each results in a different text. If several brackets are missing
    at different places, only the first edit is returned, after which others are still missing.
    """
    tokens = _tokens(chunk)
    if tokens is None:
        return []
    missing = _missing(tokens)
    cost, best = _best(chunk, tokens, _edits(tokens, *missing), 0)
    if sum(missing) > 1 and min(missing) >= 0:
        single = (1, 0) if missing[0] else (0, 1)
        part, several = _best(chunk, tokens, _edits(tokens, *single), sum(missing) - 1)
        if several and (not best or part < cost):
            return several[-1:]
    at_end = [BracketEdit(tokens[-1].end, tokens[-1].end, ")")] if missing == (1, 0) else []
    return [*at_end, *best] if at_end and at_end[0] not in best else best


def quote_edits(text: str) -> list[BracketEdit]:
    """Return the edits that insert a missing closing quote.

    The quote is missing in the first line with an odd number of quotes. There is one edit for each place where the
    string may end: behind each word of that line that follows a quote, at most 16. Without an unclosed string there are
    none. A string of several lines, which is rare, counts as unclosed.
    """
    if not any(kind == "other" and text[start] == '"' for kind, start, _ in lexemes(text, 0, len(text))):
        return []
    start = 0
    for line in text.splitlines(keepends=True):
        quotes = [match.start() for match in _QUOTE.finditer(_COMMENT.sub(_blanked, line))]
        if len(quotes) % 2 == 1:
            places: dict[int, None] = {}  # an ordered set
            for quote, following in zip(quotes, [*quotes[1:], len(line)]):
                places |= {start + match.end(): None for match in _WORD_END.finditer(line, quote + 1, following)}
            return [BracketEdit(place, place, '"') for place in places][:_MAX_CANDIDATES]
        start += len(line)
    return []


_QUOTE = lazy_pattern(r'(?<!\\)"')
_COMMENT = lazy_pattern(r'"(?:[^"\\\n]|\\.)*"|;[^\n]*')
_WORD_END = lazy_pattern(r"""[^\s()\[\]";]+(?=[\s()\[\]";]|\Z)""")


def _blanked(match: re.Match[str]) -> str:
    """Return a comment as blanks, and a string as it is."""
    return match[0] if match[0].startswith('"') else " " * len(match[0])


def _best(
    chunk: Chunk, tokens: Sequence[_Token], edits: Iterator[tuple[BracketEdit, list[_Token]]], missing: int
) -> tuple[int, list[BracketEdit]]:
    """Return the least cost of the edits, and the edits that have it.

    ``missing`` is the number of brackets that are still missing after each of them.
    """
    best: dict[str, BracketEdit] = {}  # by resulting text: the last edit that results in it
    least = sys.maxsize
    for edit, changed in list(edits)[-_MAX_TRIED:]:
        cost = _cost(changed, missing)
        if cost is None or cost > least:
            continue
        if cost < least:
            least, best = cost, {}
        text = chunk.text[: edit.start - chunk.start] + edit.text + chunk.text[edit.end - chunk.start :]
        best[text] = edit
    return least, list(best.values())[-_MAX_CANDIDATES:]


def _missing(tokens: Sequence[_Token]) -> tuple[int, int]:
    """Return the numbers of missing closing parentheses and brackets, negative if there are too many."""
    counts = {bracket: sum(token.text == bracket for token in tokens) for bracket in "()[]"}
    return counts["("] - counts[")"], counts["["] - counts["]"]


def _tokens(chunk: Chunk) -> list[_Token] | None:
    """Return the tokens of a piece without comments; None if there are too many, or a string is open."""
    tokens: list[_Token] = []
    line = chunk.start - chunk.column
    is_first = True
    for kind, start, end in lexemes(chunk.text, 0, len(chunk.text)):
        piece = chunk.text[start:end]
        if kind == "other" or len(tokens) > _MAX_TOKENS:
            return None
        if kind not in ("space", "comment", "block"):
            tokens.append(_Token(piece, chunk.start + start, chunk.start + end, chunk.start + start - line, is_first))
            is_first = False
        if "\n" in piece:
            line = chunk.start + start + piece.rindex("\n") + 1
            is_first = kind in ("space", "block")
    return tokens


def _edits(tokens: Sequence[_Token], round_: int, square: int) -> Iterator[tuple[BracketEdit, list[_Token]]]:
    """Yield the edits that add or remove ``round_`` closing parentheses and ``square`` brackets.

    Each comes with the tokens after it. At most two brackets of one kind are added, in one place; (1, -1) replaces
    `]` by `)`.
    """
    limit = _first_contradiction(tokens)
    if (round_, square) in ((1, 0), (2, 0), (0, 1), (0, 2)):
        closing = ")" * round_ + "]" * square
        for i, token in enumerate(tokens[: limit + 1]):
            if token.text in _PAIRS and not _is_empty_list(tokens, i, closing):
                continue
            added = [_Token(c, token.end, token.end, token.column, is_first=False) for c in closing]
            yield BracketEdit(token.end, token.end, closing), [*tokens[: i + 1], *added, *tokens[i + 1 :]]
    elif (round_, square) in ((-1, 0), (0, -1)):
        wrong = ")" if round_ else "]"
        for i, token in enumerate(tokens[: limit + 1]):
            if token.text == wrong:
                yield BracketEdit(token.start, token.end, ""), [*tokens[:i], *tokens[i + 1 :]]
    elif (round_, square) in ((1, -1), (-1, 1)):
        wrong, right = ("]", ")") if round_ == 1 else (")", "]")
        for i, token in enumerate(tokens[: limit + 1]):
            if token.text == wrong:
                replaced = token._replace(text=right)
                yield BracketEdit(token.start, token.end, right), [*tokens[:i], replaced, *tokens[i + 1 :]]


def _is_empty_list(tokens: Sequence[_Token], i: int, closing: str) -> bool:
    """Return whether a list may be closed directly after its opening bracket.

    Only the parameter list of a function may be empty, and only where the line ends after it.
    """
    is_behind = i > 0 and tokens[i - 1].text == "lambda"
    return is_behind and closing == ")" and (i + 1 == len(tokens) or tokens[i + 1].is_first)


def _first_contradiction(tokens: Sequence[_Token]) -> int:
    """Return the number of the first token whose bracket does not match; edits behind it cannot help."""
    stack: list[str] = []
    for i, token in enumerate(tokens):
        if token.text in _PAIRS:
            stack.append(_PAIRS[token.text])
        elif token.text in (")", "]") and (not stack or stack.pop() != token.text):
            return i
    return len(tokens) - 1


def _cost(tokens: Sequence[_Token], missing: int) -> int | None:
    """Return how much the lines contradict the nesting.

    None if the brackets do not match, apart from ``missing`` closing ones at the end.
    """
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
    """Return the cost of a line that begins at ``column`` in a list, or outside of all at the column ``outer``.

    It lines up with an earlier line of the list, with its second item, or is indented by the usual one, two or four.
    """
    if frame is None:
        return 0 if column == outer else _LEFT_COST
    if column <= frame.column:
        return _LEFT_COST
    lined_up = frame.starts or {frame.column + 1, frame.column + 2, frame.column + 4, frame.second}
    return 0 if column in lined_up or column == frame.second else _UNALIGNED_COST
