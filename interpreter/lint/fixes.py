"""Mending programs: the fixes that a diagnostic's place alone suggests, and applying fixes to a text."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.grammar.reader import read_comments
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.lint.removal import spaced

_FRACTION = re.compile(r"([+-]?\d+)/(\d+)\Z")
_PIECES = re.compile(r"""(?:"(?:[^"\\]|\\.)*"|;[^\n]*|#\|.*?\|#|[()\[\]'`,]|[^\s()\[\]";'`,]+)""", re.S)
_NAME = re.compile(r"[^\s()\[\]\";'`,]+\Z")


def with_fixes(diagnostic: Diagnostic) -> Diagnostic:
    """A diagnostic with its fixes, or with those that its kind and the text at its place suggest. Its place is one in
    the whole text of a file."""
    span = diagnostic.span
    if diagnostic.fixes:
        return replace(diagnostic, fixes=tuple(_careful(_with_lines(fix)) for fix in diagnostic.fixes))
    if span is None or span.expansion is not None:
        return diagnostic
    text, fix = span.text, None
    if diagnostic.name == "bracket" and text.startswith("[") and text.endswith("]"):
        fix = Fix("Write parentheses", (Edit(span, f"({text[1:-1]})"),), safe=True)
    elif diagnostic.name == "word" and _NAME.match(text):
        fix = Fix("Write it in quotes", (Edit(span, f'"{text}"'),), safe=True)
    elif diagnostic.name == "bad-atom" and (match := _FRACTION.match(text)):
        fix = Fix("Write a division", (Edit(span, f"(/ {match[1]} {match[2]})"),), safe=not _is_quoted(span))
    return replace(diagnostic, fixes=(fix,)) if fix is not None else diagnostic


def _is_quoted(span: Span) -> bool:
    """Whether a place is inside quoted data, where a list is no call."""
    quoted = [False]
    last = ""
    for match in _PIECES.finditer(span.source.text, 0, span.start):
        piece = match.group()
        if piece == "(" or piece == "[":
            quoted.append(quoted[-1] or last in ("'", "`"))
        elif piece in ")]":
            quoted = quoted[:-1] or [False]
        elif last == "(" and piece in ("quote", "quasiquote"):
            quoted[-1] = True
        last = piece
    return quoted[-1] or last in ("'", "`")


def _careful(fix: Fix) -> Fix:
    """A fix that would throw comments away is not safe."""
    for edit in fix.edits:
        comments = read_comments(Source("<edit>", edit.span.text))
        if any(comment.text not in edit.text for comment in comments):
            return replace(fix, safe=False)
    return fix


def _with_lines(fix: Fix) -> Fix:
    """A fix whose removals take the lines with them on which nothing else stands."""
    return replace(fix, edits=tuple(_removal(edit.span) if not edit.text else edit for edit in fix.edits))


def _removal(form: Span) -> Edit:
    text = form.source.text
    line = text.rfind("\n", 0, form.start) + 1
    after = re.compile(r"[ \t]*\r?\n?").match(text, form.end)
    end = after.end() if after is not None else form.end
    alone = not text[line : form.start].strip() and (text[end - 1 : end] == "\n" or end == len(text))
    if alone:
        return Edit(Span(form.source, line, end), "")
    return Edit(form, spaced(form, "") or "")


def apply_fixes(source: Source, diagnostics: Iterable[Diagnostic]) -> tuple[str, int]:
    """The text of ``source`` with every safe fix applied that does not touch one before it, and their number."""
    text, applied, free_from = source.text, 0, len(source.text) + 1
    fixes = [fix for d in diagnostics for fix in d.fixes[:1] if fix.safe and _is_within(fix, source)]
    for fix in sorted(fixes, key=lambda fix: -max(edit.span.end for edit in fix.edits)):
        if max(edit.span.end for edit in fix.edits) > free_from:
            continue
        for edit in sorted(fix.edits, key=lambda edit: -edit.span.start):
            text = text[: edit.span.start] + edit.text + text[edit.span.end :]
        free_from = min(edit.span.start for edit in fix.edits)
        applied += 1
    return text, applied


def _is_within(fix: Fix, source: Source) -> bool:
    return all(edit.span.source.name == source.name and edit.span.expansion is None for edit in fix.edits)
