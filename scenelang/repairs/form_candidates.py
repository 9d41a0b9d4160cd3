"""Candidate edits of forms: replacements of a form of the text, which a search tries by evaluation."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Source, Span, subdatums
from scenelang.grammar.diagnostics import Edit
from scenelang.grammar.reader import read
from scenelang.repairs.program_forms import head_of

_DECIMAL_NUMBER = re.compile(r"(?<![^\s()\[\]])[-+]?\d*\.\d+(?![^\s()\[\]])")


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

    def rounded(self, decimals: int) -> FormCandidate:
        """Return the candidate with at most so many decimals of the numbers that were not in the text before."""
        new = _rounded(self.new, self.span.text, decimals)
        others = tuple(Edit(edit.span, _rounded(edit.text, edit.span.text, decimals)) for edit in self.others)
        return replace(self, new=new, others=others)

    def translated(self, offset: FloatArray, *, in_place: bool = False) -> FormCandidate:
        """Return the candidate with a translation of its own; with ``in_place`` it is added to that of the form."""
        (form,) = read(Source(self.span.source.name, self.span.text)).forms
        if in_place and self.around is None and isinstance(form, ListDatum):
            for text in shifted(form, offset, computes=True):
                return FormCandidate(self.span, text, False)
        before, after = self.around or (f"(transform {self.span.text} (translate ", "))")
        return FormCandidate(self.span, f"{before}{vector_text(offset)}{after}", False, around=self.around)


def _rounded(text: str, old: str, decimals: int) -> str:
    """Return a text with at most so many decimals of the numbers that ``old`` does not have."""
    known = set(_DECIMAL_NUMBER.findall(old))

    def shorter(match: re.Match[str]) -> str:
        """Return a number with fewer decimals."""
        number = match[0]
        if number in known or len(number.partition(".")[2]) <= max(decimals, 1):
            return number
        shortened = written_as(number, round(float(number), decimals))
        return shortened if "." in shortened else f"{shortened}.0"  # it stays what it is: no integer

    return _DECIMAL_NUMBER.sub(shorter, text)


def written_as(old: str, value: float) -> str:
    """Write a number as those of a text are written: without a zero before the point, such as `.5`, or with it."""
    text = number_text(value)
    return re.sub(r"^(-?)0\.", r"\1.", text) if re.search(r"(?<!\d)\.\d", old) else text


def space_before(span: Span) -> str:
    """Return what separates a form that follows: a line break with the indentation, if it has a line of its own."""
    before = span.source.text[: span.start].rpartition("\n")[2]
    return f"\n{before}" if before and not before.strip() else " "


def shifted(form: ListDatum, offset: FloatArray, *, computes: bool = False) -> Iterator[str]:
    """Yield a form `(transform X (translate [x y z]))` with the offset added to its numbers.

    With ``computes``, it is added to expressions too: `(translate [(+ x .5) 1 0])`, `(translate (+ p [.5 1 0]))`.
    """
    if head_of(form) != "transform" or len(form.items) != 3:
        return
    pose = form.items[2]
    if head_of(pose) != "translate" or not isinstance(pose, ListDatum) or len(pose.items) != 2:
        return
    new = _added(pose.items[1], offset, computes=computes)
    if new is not None:
        place, start = pose.items[1].span, form.span.start
        yield form.span.text[: place.start - start] + new + form.span.text[place.end - start :]


def _added(place: Datum, offset: FloatArray, *, computes: bool) -> str | None:
    """Return a vector with an offset added; None if it has expressions and ``computes`` is false."""
    is_vector = head_of(place) == "vector"
    parts = list(subdatums(place))[is_vector:]
    numbers = [part for part in parts if isinstance(part, Atom) and type(part.value) in (int, float)]
    is_written = len(parts) == 3 and (is_vector or place.span.text.startswith("["))
    is_literal = is_written and not is_vector and len(numbers) == 3
    if not is_literal and not computes:
        return None
    if not is_written:
        return f"(+ {place.span.text} {vector_text(offset)})"
    sums = " ".join(_sum(part, added, place.span.text) for part, added in zip(parts, offset))
    return f"(vector {sums})" if is_vector else f"[{sums}]"


def _sum(part: Datum, offset: float, vector: str) -> str:
    """Return the text of a component of a vector with a number added."""
    added = number_text(offset)
    if added == "0":
        return part.span.text
    if isinstance(part, Atom) and type(part.value) in (int, float):
        return written_as(vector, part.value + offset)
    return f"(+ {part.span.text} {added})"


def vector_text(offset: Any) -> str:
    """Write a translation as a vector with nine decimals."""
    return "[" + " ".join(map(number_text, offset)) + "]"


def number_text(value: float) -> str:
    """Write a number with nine decimals."""
    return f"{round(float(value), 9) + 0.0:.12g}"


def with_attribute(form: ListDatum, name: str, value: str) -> str:
    """Return a call with the value of an attribute replaced, or with the attribute added."""
    text, start = form.span.text, form.span.start
    for key, old in zip(form.items, form.items[1:]):
        if isinstance(key, Atom) and isinstance(key.value, Keyword) and key.value == name:
            return text[: old.span.start - start] + value + text[old.span.end - start :]
    return f"{text[:-1].rstrip()} :{name} {value})"
