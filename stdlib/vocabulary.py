"""The names of the language by what they are, for whatever colours programs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from scenelang.interpreter.form_shapes import DEFINITIONS, MACROS, TOP_LEVEL
from scenelang.interpreter.forms import FORMS
from scenelang.interpreter.prelude import PAPER_FORMS
from scenelang.stdlib.reference import Kind, records

PAPER = frozenset({"bind", "retrieve", *PAPER_FORMS})


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """``definitions`` are the forms that define names, ``paper`` the paper's forms; no name is in two sets."""

    forms: frozenset[str]
    definitions: frozenset[str]
    paper: frozenset[str]
    functions: frozenset[str]
    constants: frozenset[str]


@cache
def vocabulary() -> Vocabulary:
    """The names that every program sees; those of libraries to import are a program's own."""
    definitions = frozenset({*DEFINITIONS, *MACROS, *TOP_LEVEL}) - PAPER
    known = [record for record in records() if record.module is None and record.name not in PAPER]
    return Vocabulary(
        forms=frozenset({*FORMS, "else", "=>"}) - definitions - PAPER,
        definitions=definitions,
        paper=PAPER,
        functions=frozenset(record.name for record in known if record.kind is Kind.FUNCTION),
        constants=frozenset(record.name for record in known if record.kind is Kind.CONSTANT),
    )
