"""Warnings about forms that join a session: nothing is said of what only a whole program can tell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.lint.facts import FactBook
from scenelang.interpreter.lint.words import word_warnings
from scenelang.interpreter.program import Program

WHOLE_FILE = frozenset(("unused", "bound-twice", "undefined-word", "unreachable-word"))


def new_form_warnings(
    main: Source, forms: tuple[Any, ...], words: Mapping[str, Span], all_words: Mapping[str, Span]
) -> list[Diagnostic]:
    """What is suspicious about core forms, among words that are known already; those of ``WHOLE_FILE`` included."""
    program = Program(main, (), forms, None, words, all_words, (), (), FactBook())
    return [*(d for each in program.facts for d in each.local), *word_warnings(program)]
