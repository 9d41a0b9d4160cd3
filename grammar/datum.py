"""Datums: what the reader makes of a text. Every datum knows its span."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

from scenelang.grammar.source import Span


class Symbol(str):
    """A symbol; compares and hashes as its name, told from a string by its type."""

    __slots__ = ()


class Keyword(str):
    """A keyword ``:name``; the text is the name without the colon."""

    __slots__ = ()


class Handle(str):
    """An embedding handle ``<z1>``; the text is what stands between the angle brackets."""

    __slots__ = ()


@dataclass(frozen=True, slots=True, eq=False)
class Atom:
    """A leaf. ``value``: Symbol, Keyword, Handle, int, float, str, bool, or None for ``none``."""

    value: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class ListDatum:
    """``(a b)``, or ``(a . b)`` when ``tail`` is given. ``'x`` reads as ``(quote x)``."""

    items: tuple[Any, ...]
    tail: Any
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class ArrayDatum:
    """``[a b]``."""

    items: tuple[Any, ...]
    span: Span


Datum: TypeAlias = Atom | ListDatum | ArrayDatum

PREFIXES = {"'": "quote", "`": "quasiquote", ",": "unquote", ",@": "unquote-splicing"}


def subdatums(datum: Datum) -> Iterator[Datum]:
    """The direct parts of a datum, the tail included."""
    if not isinstance(datum, Atom):
        yield from datum.items
        if isinstance(datum, ListDatum) and datum.tail is not None:
            yield datum.tail


def walk(*datums: Datum) -> Iterator[Datum]:
    """Every datum below and including ``datums``, in no particular order, without recursion."""
    stack = list(datums)
    while stack:
        datum = stack.pop()
        yield datum
        if not isinstance(datum, Atom):
            stack.extend(subdatums(datum))
