"""Formatter: rewrite a text in the standard style of the language, changing only white space.

The text is parsed into a concrete syntax tree (``concrete``) and laid out (``layout``). Because some line breaks of the
author are preserved, this is repeated until the text no longer changes, which makes formatting idempotent. Finally,
tokens and comments are compared with the original; a difference is a bug in the formatter, and nothing is returned.

Line breaks that carry structure are preserved: a body or a clause's body on its own line, each member of a union, a
pose under its shape, bindings under each other, rows of a table or matrix, a keyword pair per line, and a function as
the last operand (``layout_styles.stays_broken`` and ``has_rows``). Everything else is joined and wrapped. One program
written on one line and on several lines can therefore be formatted differently. Several empty lines become one; those
after an opening bracket, a head or a keyword are removed; one is inserted between multi-line top-level forms, except
between definitions of values.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import NamedTuple

from scenelang.grammar.concrete import Concrete, concrete, essence_of, tokens
from scenelang.grammar.datum import Atom, Datum, ListDatum, Source, Symbol, rare_collection, walk
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.layout import NOTE, Row, Trivia, hidden_datums, layout_lines
from scenelang.grammar.layout_styles import head_of
from scenelang.grammar.reader import read

# Indentation of macro uses, inferred from the macros' definitions.

# names of pattern variables that authors give to bodies
_BODY_NAMES = frozenset(("body", "bodies", "forms", "expressions", "statements", "clauses", "rows"))


def learnt_indents(forms: Iterable[Datum], indents: Mapping[str, int | None]) -> dict[str, int | None]:
    """Return ``indents`` extended with the macros that ``forms`` define at any level.

    If a rule of a macro ends in a body (``body ...``, or a rest parameter), the operands before the body go on the line
    of the head. A macro without a body is laid out like a function call, even if a special form has the same name.
    """
    learnt = dict(indents)
    for datum in walk(*forms):
        if not isinstance(datum, ListDatum):
            continue
        head, items = head_of(datum), datum.items
        if head == "define-syntax" and len(items) == 3:
            _learn(learnt, _symbol(items[1]), _rules_indent(items[2], indents))
        elif head == "define-macro" and len(items) > 2 and isinstance(items[1], ListDatum) and items[1].items:
            rest = items[1].tail is not None
            _learn(learnt, _symbol(items[1].items[0]), len(items[1].items) - 1 if rest else None)
        elif head in ("let-syntax", "letrec-syntax") and len(items) > 1 and isinstance(items[1], ListDatum):
            for binding in items[1].items:
                if isinstance(binding, ListDatum) and len(binding.items) == 2:
                    _learn(learnt, _symbol(binding.items[0]), _rules_indent(binding.items[1], indents))
    return learnt


def _learn(learnt: dict[str, int | None], name: str | None, indent: int | None) -> None:
    """Record the indentation of a macro; one without a body loses that of the form that it shadows."""
    if name is None:
        return
    if indent is None:
        learnt.pop(name, None)
    else:
        learnt[name] = indent


def _symbol(datum: Datum) -> str | None:
    """Return the name of a symbol, or None for any other datum."""
    return str(datum.value) if isinstance(datum, Atom) and type(datum.value) is Symbol else None


def _rules_indent(rules: Datum, indents: Mapping[str, int | None]) -> int | None:
    """Return the number of operands on the head's line for a ``syntax-rules`` macro, or None if it has no body.

    The rule with the most operands decides.
    """
    if not isinstance(rules, ListDatum) or head_of(rules) != "syntax-rules" or len(rules.items) < 3:
        return None
    named = _symbol(rules.items[1])
    ellipsis = named or "..."
    by_rule = [_rule_indent(rule, ellipsis, indents) for rule in rules.items[3 if named else 2 :]]
    return max((indent for indent in by_rule if indent is not None), default=None)


def _rule_indent(rule: Datum, ellipsis: str, indents: Mapping[str, int | None]) -> int | None:
    """Return the number of operands before the body of one ``syntax-rules`` rule, or None if it has no body."""
    if not isinstance(rule, ListDatum) or len(rule.items) != 2 or not isinstance(rule.items[0], ListDatum):
        return None
    pattern, template = rule.items
    if pattern.tail is not None:
        variable, before = pattern.tail, len(pattern.items) - 1
    elif len(pattern.items) > 2 and _symbol(pattern.items[-1]) == ellipsis:
        variable, before = pattern.items[-2], len(pattern.items) - 3
    else:
        return None
    name = _symbol(variable)
    if name is None:  # such as `(key value) ...`: clauses
        return before
    return before if name in _BODY_NAMES or _is_body(name, template, indents) else None


def _is_body(name: str, template: Datum, indents: Mapping[str, int | None]) -> bool:
    """Return whether a template uses a variable in the body of a form."""
    for datum in walk(template):
        if isinstance(datum, ListDatum):
            indent = indents.get(head_of(datum) or "")
            parts = [*datum.items, *([datum.tail] if datum.tail is not None else [])]
            if indent is not None and any(_symbol(part) == name for part in parts[1 + indent :]):
                return True
    return False


WIDTH = 88  # columns, as Black's
_MAX_PASSES = 20  # of layout until a fixed point; a few suffice, the limit guards against oscillation
_BYTE_ORDER_MARK = "\ufeff"


@dataclass(eq=False)
class UnreadableError(SceneError):
    """Syntax error in the text to format; ``diagnostics`` are all its errors, the first of which is this one."""

    diagnostics: tuple[Diagnostic, ...] = ()


class FormatFault(Exception):
    """Internal error: formatting would change more than white space. A bug in the formatter, not in the text."""


class FormatEdit(NamedTuple):
    """Replacement of the lines ``first`` to ``last`` (from 1, inclusive) by ``text``.

    For an insertion, ``last`` is ``first - 1``.
    """

    first: int
    last: int
    text: str


def format_text(text: str, indents: Mapping[str, int | None], *, name: str = "<text>", width: int = WIDTH) -> str:
    """Format a program.

    A byte order mark and the prevailing kind of line ending are preserved.

    Parameters
    ----------
    text
        Source text.
    indents
        Number of operands on the line of the head, by form; None aligns the operands. The indentation of macros is
        inferred from their definitions in ``text``.
    name
        Name of the source for error messages.
    width
        Maximum line width, which only long tokens and comments may exceed.

    Returns
    -------
    str
        The formatted text.

    Raises
    ------
    UnreadableError
        If the text has syntax errors.
    FormatFault
        If the formatter has a bug.
    """
    mark = _BYTE_ORDER_MARK if text.startswith(_BYTE_ORDER_MARK) else ""
    body = text[len(mark) :]
    placeholder = _unused(body) if NOTE in body else NOTE  # the layout uses NOTE as a mark of its own
    return mark + _formatted(Source(name, body.replace(NOTE, placeholder)), indents, width).replace(placeholder, NOTE)


def _unused(text: str) -> str:
    """Return a character that does not occur in a text, preferably a private one of Unicode."""
    used = set(text)
    return next(chr(code) for code in range(0xE000, 0x110000) if chr(code) not in used)


def _formatted(source: Source, indents: Mapping[str, int | None], width: int) -> str:
    """Format a source without byte order mark and without ``NOTE`` characters."""
    with rare_collection():
        return _settled(source, learnt_indents(read_forms(source), indents), width, is_checked=True)


def settled(text: str, indents: Mapping[str, int | None]) -> str:
    """Format a valid text as ``format_text`` does, without checks; for programs generated by this package."""
    return _settled(Source("<text>", text), indents, WIDTH)


def _settled(source: Source, indents: Mapping[str, int | None], width: int, *, is_checked: bool = False) -> str:
    """Repeat the layout until it is a fixed point; raise ``FormatFault`` if it changes tokens or comments.

    Comparing tokens suffices, because datums depend on nothing else: equal tokens are the same program.
    """
    text = source.text
    text_tokens = list(tokens(text))
    expected = essence_of(text_tokens) if is_checked else None
    tree = concrete(source, text_tokens)
    line_end = _line_end(text, tree)
    for _ in range(_MAX_PASSES):
        before, text = text, _laid_out(tree, indents, width, line_end)
        if text == before:
            break
        text_tokens = list(tokens(text))
        if expected is not None and essence_of(text_tokens) != expected:
            raise FormatFault(f"formatting {source.name} would change more than white space")
        tree = concrete(Source(source.name, text), text_tokens)
    return text


def _laid_out(tree: Concrete, indents: Mapping[str, int | None], width: int, line_end: str) -> str:
    """Return the text of one pass of the layout."""
    lines = layout_lines(
        tree.forms,
        indents=indents,
        trivia=tree.trivia,
        spelling=tree.spelling,
        width=width,
        end=tree.end,
        written=tree.written,
    )
    return line_end.join([*lines, ""]) if lines else ""


def read_forms(source: Source) -> tuple[Datum, ...]:
    """Return the forms of a text; raise ``UnreadableError`` if it has syntax errors."""
    result = read(source)
    if not result.diagnostics:
        return result.forms
    first = result.diagnostics[0]
    raise UnreadableError(
        first.name, first.message, first.hint, first.span, first.notes, diagnostics=result.diagnostics
    )


# --- line ends -----------------------------------------------------------------------------------------------------


def _line_end(text: str, tree: Concrete) -> str:
    """Return the prevailing line ending, outside strings, comments and other verbatim text."""
    if "\r\n" not in text:
        return "\n"
    pairs, ends = text.count("\r\n"), text.count("\n")
    for piece in _fixed(tree):
        pairs, ends = pairs - piece.count("\r\n"), ends - piece.count("\n")
    return "\r\n" if 2 * pairs > ends else "\n"


def _fixed(tree: Concrete) -> Iterable[str]:
    """Iterate over the verbatim texts of several lines."""
    yield from _comments(tree.end)
    stack = [*tree.forms, *hidden_datums(tree.end)]
    for datum in walk(*stack):
        yield tree.spelling.get(id(datum), "")
        around = tree.trivia.get(id(datum))
        if around is not None:
            yield from _around(tree, around)


def _around(tree: Concrete, around: Trivia) -> Iterable[str]:
    """Iterate over the comments of several lines around a datum, and the verbatim texts in hidden ones."""
    yield from _comments((*around.before, *around.end, around.after, around.opening, around.closing))
    for hidden in hidden_datums((*around.before, *around.end)):
        yield tree.spelling.get(id(hidden), "")


def _comments(rows: Iterable[Row]) -> Iterable[str]:
    """Return the comments of several lines."""
    return (row for row in rows if isinstance(row, str) and "\n" in row)


# --- parts of a text -----------------------------------------------------------------------------------------------


def format_range(
    text: str,
    first_line: int,
    last_line: int,
    indents: Mapping[str, int | None],
    *,
    name: str = "<text>",
    width: int = WIDTH,
) -> str:
    """Format only the top-level forms that overlap a range of lines, with their comments.

    Parameters
    ----------
    text
        Source text.
    first_line, last_line
        Range of lines, from 1 and inclusive.
    indents, name, width
        As for ``format_text``.

    Returns
    -------
    str
        The whole text.

    Raises
    ------
    UnreadableError, FormatFault
        As ``format_text`` does.
    """
    mark = _BYTE_ORDER_MARK if text.startswith(_BYTE_ORDER_MARK) else ""
    source = Source(name, text[len(mark) :])
    indents = learnt_indents(read_forms(source), indents)
    lines = source.text.split("\n")
    touched = [place for place in _line_runs(source) if place[0] <= last_line and place[1] >= first_line]
    if not touched:
        return text
    first, last = touched[0][0], touched[-1][1]
    part = "\n".join(lines[first - 1 : last])
    ended = part + "\n" if last < len(lines) else part
    done = format_text(ended, indents, name=name, width=width)
    rest = "\n".join(lines[last:])
    before = "".join(f"{line}\n" for line in lines[: first - 1])
    return mark + before + done + rest


def _line_runs(source: Source) -> list[tuple[int, int]]:
    """Return the first and last lines of all forms with their comments; forms that share a line are merged."""
    runs: list[tuple[int, int]] = []
    for start, end in concrete(source).places:
        first, last = source.position(start)[0], source.position(max(start, end - 1))[0]
        if runs and first <= runs[-1][1]:
            runs[-1] = (runs[-1][0], max(last, runs[-1][1]))
        else:
            runs.append((first, last))
    return runs


def edit_between(before: str, after: str) -> FormatEdit | None:
    """Return the smallest line edit that turns one text into the other, or None if they are equal."""
    if before == after:
        return None
    old, new = before.splitlines(keepends=True), after.splitlines(keepends=True)
    head = _common_lines(old, new)
    tail = _common_lines(old[head:][::-1], new[head:][::-1])
    return FormatEdit(head + 1, len(old) - tail, "".join(new[head : len(new) - tail]))


def _common_lines(a: Sequence[str], b: Sequence[str]) -> int:
    """Count the equal lines at the beginning of two lists."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(a, b)))
