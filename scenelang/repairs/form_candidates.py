"""Candidate edits of forms: replacements of a form of the text, which a search tries by evaluation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import Atom, Keyword, ListDatum, Source, Span, subdatums
from scenelang.grammar.diagnostics import Edit
from scenelang.grammar.reader import read
from scenelang.repairs.program_forms import head_of


@dataclass(frozen=True, slots=True)
class FormCandidate:
    """Form of the text and its replacement. A direct one calls the word of the instances itself."""

    span: Span
    new: str
    is_direct: bool
    others: tuple[Edit, ...] = ()  # elsewhere in the text
    around: tuple[str, str] | None = None  # text before and after the vector of a translation

    @property
    def edits(self) -> tuple[Edit, ...]:
        """The replacement as an edit of the text, and the others."""
        return (Edit(self.span, self.new), *self.others)

    def translated(self, offset: FloatArray, *, in_place: bool = False) -> FormCandidate:
        """Return the candidate with a translation of its own; with ``in_place`` it is added to that of the form."""
        (form,) = read(Source(self.span.source.name, self.span.text)).forms
        if in_place and self.around is None and isinstance(form, ListDatum):
            for text in shifted(form, offset):
                return FormCandidate(self.span, text, False)
        before, after = self.around or (f"(transform {self.span.text} (translate ", "))")
        return FormCandidate(self.span, f"{before}{vector_text(offset)}{after}", False, around=self.around)


def space_before(span: Span) -> str:
    """Return what separates a form that follows: a line break with the indentation, if it has a line of its own."""
    before = span.source.text[: span.start].rpartition("\n")[2]
    return f"\n{before}" if before and not before.strip() else " "


def shifted(form: ListDatum, offset: FloatArray) -> Iterator[str]:
    """Yield a form `(transform X (translate [x y z]))` with the offset added to its numbers."""
    if head_of(form) != "transform" or len(form.items) != 3:
        return
    pose = form.items[2]
    if head_of(pose) != "translate" or not isinstance(pose, ListDatum) or len(pose.items) != 2:
        return
    numbers = [item.value for item in subdatums(pose.items[1]) if isinstance(item, Atom)]
    if len(numbers) == 3 and all(type(x) in (int, float) for x in numbers) and pose.items[1].span.text[0] == "[":
        place, start = pose.items[1].span, form.span.start
        new = vector_text(np.array(numbers, np.float64) + offset)
        yield form.span.text[: place.start - start] + new + form.span.text[place.end - start :]


def vector_text(offset: Any) -> str:
    """Write a translation as a vector with nine decimals."""
    return "[" + " ".join(f"{round(float(x), 9) + 0.0:.12g}" for x in offset) + "]"


def with_attribute(form: ListDatum, name: str, value: str) -> str:
    """Return a call with the value of an attribute replaced, or with the attribute added."""
    text, start = form.span.text, form.span.start
    for key, old in zip(form.items, form.items[1:]):
        if isinstance(key, Atom) and isinstance(key.value, Keyword) and key.value == name:
            return text[: old.span.start - start] + value + text[old.span.end - start :]
    return f"{text[:-1].rstrip()} :{name} {value})"
