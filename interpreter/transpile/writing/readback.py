"""What was written must read back as the forms that were meant: the net under everything that writes text."""

from __future__ import annotations

import math
from collections.abc import Sequence

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, ListDatum, Symbol
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.reader import read
from scenelang.grammar.source import Source, Span

_NUMBER_NAMES = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}


def misread(forms: Sequence[Datum], text: str, outer: Span) -> Diagnostic | None:
    """The diagnostic for the first form that ``text`` does not hold as it was meant; None where all is well."""
    try:
        found = read(Source("<translation>", text))
    except (SceneError, RecursionError):
        return _problem(outer)
    if found.diagnostics:
        return _problem(outer)
    if len(found.forms) != len(forms):
        return _problem(outer)
    stack = list(zip(forms, found.forms))
    while stack:
        meant, got = stack.pop()
        parts = _pairs(meant, got)
        if parts is None:
            return _problem(meant.span)
        stack += parts
    return None


def _problem(span: Span) -> Diagnostic:
    message = "this cannot be written in the language: its text would read as something else"
    return Diagnostic("python-unsupported", message, span)


def _pairs(meant: Datum, got: Datum) -> list[tuple[Datum, Datum]] | None:
    """The parts of two datums side by side; None where the datums differ."""
    if isinstance(meant, Atom):
        return [] if isinstance(got, Atom) and _same(meant.value, got.value) else None
    if type(meant) is not type(got) or isinstance(got, Atom) or len(meant.items) != len(got.items):
        return None
    parts = list(zip(meant.items, got.items))
    if isinstance(meant, ListDatum) and isinstance(got, ListDatum):
        if (meant.tail is None) != (got.tail is None):
            return None
        if meant.tail is not None:
            parts.append((meant.tail, got.tail))
    assert isinstance(meant, (ListDatum, ArrayDatum))
    return parts


def _same(meant: object, got: object) -> bool:
    if type(meant) is float and type(got) is Symbol:
        named = _NUMBER_NAMES.get(str(got))
        return named is not None and (named == meant or (math.isnan(named) and math.isnan(meant)))
    if type(meant) is float and type(got) is float:
        return meant == got and math.copysign(1, meant) == math.copysign(1, got)
    return type(meant) is type(got) and meant == got
