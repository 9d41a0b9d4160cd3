"""Params: the constants of a program that the command line may override."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.expand import syntax_error


@dataclass(frozen=True, slots=True, eq=False)
class Param:
    """A ``(param name default "doc" :min a :max b)`` of a program."""

    name: str
    default: str
    doc: str
    minimum: float | None
    maximum: float | None
    span: Span


def read_param(datum: ListDatum, name: str) -> Param:
    """The ``(param name value "doc" :min a :max b)`` that ``datum`` is; raises SceneError for anything else in it."""
    rest = list(datum.items[3:])
    doc = ""
    if rest and isinstance(rest[0], Atom) and type(rest[0].value) is str:
        doc = rest.pop(0).value
    ends: dict[str, float] = {}
    while rest:
        key = rest.pop(0)
        known = isinstance(key, Atom) and isinstance(key.value, Keyword) and str(key.value) in ("min", "max")
        if not known or not rest or not isinstance(rest[0], Atom) or type(rest[0].value) not in (int, float):
            raise syntax_error("param", "`param` has no place for this", key.span)
        ends[str(key.value)] = rest.pop(0).value
    default = " ".join(datum.items[2].span.text.split())
    return Param(name, default, doc, ends.get("min"), ends.get("max"), datum.span)


def checked_value(param: Param, value: Any, span: Span) -> Datum:
    """The datum that takes the place of a param's default."""
    datum: Datum = value
    number = datum.value if isinstance(datum, Atom) and type(datum.value) in (int, float) else None
    for bound, sign, word in ((param.minimum, 1, "least"), (param.maximum, -1, "most")):
        if number is None and bound is not None:
            raise SceneError("param", f"`{param.name}` must be a number, at {word} {bound}", None, param.span)
        if number is not None and bound is not None and sign * number < sign * bound:
            raise SceneError("param", f"`{param.name}` must be at {word} {bound}, got {number}", None, param.span)
    return datum
