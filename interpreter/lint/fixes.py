"""Mending programs: the fixes that a diagnostic's place alone suggests, and applying fixes to a text."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from scenelang.grammar.datum import Source, Span
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.grammar.reader import piece_at, read_comments
from scenelang.interpreter.lint.rules import spaced

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


# Warnings that a program's comments allow: ``; lint: allow unused W304``.
#
# At the end of a line it is about that line, on a line of its own about the form that follows, and ``; lint: allow-
# file`` is about the whole file. Errors cannot be allowed.


_ALLOW = re.compile(r";+\s*lint:\s*allow(?P<file>-file)?\s+(?P<names>.+)")


@dataclass(frozen=True, eq=False)
class Allowance:
    """What the comments of one text allow: names or codes of warnings, between two offsets."""

    source: Source

    @cached_property
    def _ranges(self) -> Sequence[tuple[int, int, frozenset[str]]]:
        if "lint:" not in self.source.text:
            return ()
        found = []
        for comment in read_comments(self.source):
            match = _ALLOW.match(comment.text)
            if match is not None:
                names = frozenset(re.split(r"[\s,]+", match["names"].strip()))
                found.append((*self._reach(comment.start, comment.end, bool(match["file"])), names))
        return found

    def _reach(self, start: int, end: int, whole: bool) -> tuple[int, int]:
        text = self.source.text
        if whole:
            return 0, len(text)
        line = text.rfind("\n", 0, start) + 1
        if text[line:start].strip():
            return line, end
        return piece_at(text, end)

    def allows(self, diagnostic: Diagnostic) -> bool:
        span = diagnostic.span
        if diagnostic.is_error or span is None or span.source.name != self.source.name:
            return False
        return any(
            start <= span.start < max(end, start + 1) and not names.isdisjoint((diagnostic.name, diagnostic.code))
            for start, end, names in self._ranges
        )


def not_allowed(diagnostics: Iterable[Diagnostic], sources: Iterable[Source]) -> list[Diagnostic]:
    """The diagnostics that no comment in these texts allows."""
    allowances = [Allowance(source) for source in sources]
    return [d for d in diagnostics if d.is_error or not any(each.allows(d) for each in allowances)]
