"""Warnings that a program's comments allow: ``; lint: allow unused W304``.

At the end of a line it is about that line, on a line of its own about the form that follows, and ``; lint: allow-file``
is about the whole file. Errors cannot be allowed.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from scenelang.grammar.chunks import piece_at
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.reader import read_comments
from scenelang.grammar.source import Source

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
