"""Numbers of a program that place chosen instances, or give their sizes: components of vectors, params, arguments of
macros and functions.

Each number of the text is changed a little and the program is evaluated, which measures how the poses of the chosen
instances change, and which other primitives do. The fewest numbers that together make the change are solved for.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, subdatums, walk
from scenelang.grammar.diagnostics import Edit
from scenelang.grammar.reader import read
from scenelang.repairs.edit_trials import edited
from scenelang.repairs.form_candidates import FormCandidate, written_as
from scenelang.repairs.program_forms import (
    bound_name,
    enclosing_forms,
    forms_of,
    head_of,
    outermost_around,
    uses_around,
)

_STEP = 0.0625  # added to a number; a power of two, so that sums with short fractions stay exact
_MAX_REFERENCES = 3  # definitions that are followed one after another
_MAX_NUMBERS = 32  # that are tried, those near the forms of the instances first
_MAX_OWN_NUMBERS = 16  # the same if nothing else may depend on them
_MAX_TOGETHER = 4  # numbers of one edit: three sizes, and the height at which the object stands on its ground
_MAX_EFFECTIVE = 8  # numbers that are combined
_MAX_CORRECTIONS = 3  # of numbers on which the motion does not depend linearly
_LEAST_MOTION = 1e-6  # for one step; smaller ones are rounding
_TOLERANCE = 1e-9  # of the asked motion, relative
_UNPLACING = frozenset({"color", "assert-that", "camera", "light"})  # forms whose numbers place nothing
_UNPLACING_KEYS = frozenset({"color", "opacity", "roughness", "metallic", "emission", "texture"})


@dataclass(frozen=True, slots=True, eq=False)
class Shift:
    """Motion (3,) of the chosen instances, or change (K,) of their poses, and which of the others (N,) change, too."""

    motion: FloatArray
    others: Any


@dataclass(frozen=True, slots=True, eq=False)
class _Number:
    """A number of the text with its effect of one unit."""

    atom: Atom
    motion: FloatArray
    others: Any


def number_edits(
    source: Source,
    numbers: Sequence[Atom],
    move: Sequence[float] | FloatArray,
    shift: Callable[[str], Shift | None],
    *,
    shared: bool,
) -> Iterator[FormCandidate]:
    """Yield edits of numbers that move the chosen instances, or give them other sizes.

    Parameters
    ----------
    source
        Program.
    numbers
        Numbers that could place the instances, those to try first at the beginning.
    move
        Translation (3,) in the axes of the scene, or change (K,) of the poses.
    shift
        Effect of a text, as ``move`` is given; None if it is wrong, or does anything else to the instances.
    shared
        Whether other primitives have to change, too; otherwise none may.
    """
    target = np.array(move, np.float64)
    effective = list[_Number]()
    for atom in numbers[: _MAX_NUMBERS if shared else _MAX_OWN_NUMBERS]:
        effect = shift(edited(source.text, [Edit(atom.span, _text(atom, _STEP))]))
        if effect is None or np.abs(effect.motion).max() < _LEAST_MOTION or (effect.others.any() and not shared):
            continue
        effective.append(_Number(atom, effect.motion / _STEP, effect.others))
        if not shared and len(effective) <= _MAX_EFFECTIVE:  # the nearest numbers are as good as any
            solved = [_solved(source, each, target, shift) for each in _combinations(effective, target, shared=False)]
            yield from (candidate for candidate in solved if candidate is not None)
    if shared:
        for chosen in _combinations(effective[:_MAX_EFFECTIVE], target, shared=True):
            candidate = _solved(source, chosen, target, shift)
            if candidate is not None:
                yield candidate


def angle_edits(
    source: Source, numbers: Sequence[Atom], degrees: float, shift: Callable[[str], Shift | None]
) -> Iterator[FormCandidate]:
    """Yield edits of numbers that are angles, by which the instances turn: in degrees or radians, either way round."""
    for atom in numbers[:_MAX_OWN_NUMBERS]:
        effect = shift(edited(source.text, [Edit(atom.span, _text(atom, _STEP))]))
        if effect is None or np.abs(effect.motion).max() < _LEAST_MOTION or effect.others.any():
            continue
        for angle in (degrees, float(np.radians(degrees))):
            yield from (FormCandidate(atom.span, _text(atom, sign * angle), False) for sign in (1.0, -1.0))


def placing_numbers(source: Source, spans: Sequence[Span]) -> list[Atom]:
    """Return the numbers in some spans of a program that could place something or size it, in the spans' order."""
    atoms = _number_atoms(read(source).forms)
    order = {atom.span.start: next((k for k, span in enumerate(spans) if _is_in(atom, [span])), None) for atom in atoms}
    return sorted((a for a in atoms if order[a.span.start] is not None), key=lambda a: order[a.span.start] or 0)


def spans_behind(source: Source, calls: Sequence[Sequence[ListDatum]]) -> list[Span]:
    """Return where the literals are that what some calls make could depend on, the nearest first.

    They are in the forms around the calls, in the calls of the functions and macros that these define, and in the
    definitions of the names that all of these use. Each call comes with the forms that enclose it.
    """
    forms = read(source).forms
    spans = [chain[-1].span for chain in calls]
    for chain in calls:
        spans += _spans_of_uses(source, chain[0].span)
        for outer in enclosing_forms(source, chain[0].span):
            if head_of(outer) == "bind" and len(outer.items) > 1 and isinstance(outer.items[1], Atom):
                spans += [call[0].span for call in forms_of(source, str(outer.items[1].value))[0]]
    lists = [datum for datum in walk(*forms) if isinstance(datum, ListDatum) and len(datum.items) > 1]
    known, new = set[str](), spans
    for _ in range(_MAX_REFERENCES):
        names = {
            str(datum.value)
            for datum in walk(*forms)
            if isinstance(datum, Atom) and isinstance(datum.value, Symbol) and _is_in(datum, new)
        } - known
        new = [form.span for form in lists if _named(form) in names]
        known |= names
        spans += new
    return spans


def _spans_of_uses(source: Source, span: Span) -> list[Span]:
    """Return the uses of the functions and macros that a span helps to define, and the forms around them."""
    spans, around = list[Span](), list[Span]()
    level = [span]
    for _ in range(_MAX_REFERENCES):
        uses = {use.span.start: use for inner in level for use in uses_around(source, inner)}
        level = [use.span for use in uses.values()]
        spans += level
        around += [outermost_around(source, use) for use in uses.values()]
    return [*spans, *around]


def _is_in(datum: Datum, spans: Sequence[Span]) -> bool:
    """Return whether a datum is in one of some spans."""
    return any(span.start <= datum.span.start and datum.span.end <= span.end for span in spans)


def _named(form: ListDatum) -> str:
    """Return the name that a definition or a clause of a `let` or a parameter list binds, else what the form calls."""
    if head_of(form) in ("define", "param"):
        target = form.items[1]
        return head_of(target) or "" if isinstance(target, ListDatum) else bound_name(target)
    return bound_name(form)


def _number_atoms(forms: Sequence[Datum]) -> list[Atom]:
    """Return the finite numbers of a program that could place something, in order."""
    numbers: list[Atom] = []
    stack: list[Datum] = list(reversed(forms))
    while stack:
        datum = stack.pop()
        if isinstance(datum, Atom):
            if type(datum.value) in (int, float) and np.isfinite(datum.value):
                numbers.append(datum)
        elif head_of(datum) not in _UNPLACING:
            items = list(subdatums(datum))
            kept = [item for k, item in enumerate(items) if not (k and _is_look(items[k - 1]))]
            stack.extend(reversed(kept if isinstance(datum, ListDatum) else items))
    return numbers


def _is_look(key: Datum) -> bool:
    """Return whether a datum is the keyword of an attribute that does not place anything."""
    return isinstance(key, Atom) and isinstance(key.value, Keyword) and str(key.value) in _UNPLACING_KEYS


def _combinations(numbers: Sequence[_Number], target: FloatArray, *, shared: bool) -> list[tuple[_Number, ...]]:
    """Return the sets of numbers that make a motion to first order, the fewest other primitives and numbers first."""
    sets: list[tuple[int, int, int, tuple[_Number, ...]]] = []
    tolerance = 1e-3 * np.abs(target).max()
    for size in range(1, _MAX_TOGETHER + 1):
        for order, chosen in enumerate(combinations(numbers, size)):
            columns = np.stack([each.motion for each in chosen], axis=1)
            if np.linalg.matrix_rank(columns) < size:
                continue
            amounts = np.linalg.lstsq(columns, target, rcond=None)[0]
            others = int(sum(each.others.astype(np.int64) for each in chosen).astype(bool).sum())
            is_needed = np.abs(amounts * np.abs(columns).max(axis=0)).min() > tolerance * 1e-3
            if np.abs(columns @ amounts - target).max() <= tolerance and is_needed and (others > 0) == shared:
                sets.append((others, size, order, chosen))
    return [chosen for *_, chosen in sorted(sets, key=lambda each: each[:3])[:3]]


def _solved(
    source: Source, chosen: Sequence[_Number], target: FloatArray, shift: Callable[[str], Shift | None]
) -> FormCandidate | None:
    """Return the edit that gives numbers the values at which the instances change as asked."""
    columns = np.stack([each.motion for each in chosen], axis=1)
    amounts = np.zeros(len(chosen))
    rest = target
    for _ in range(_MAX_CORRECTIONS):
        amounts = amounts + np.linalg.lstsq(columns, rest, rcond=None)[0]
        edits = [Edit(each.atom.span, _text(each.atom, float(x))) for each, x in zip(chosen, amounts)]
        effect = shift(edited(source.text, edits))
        if effect is None:
            return None
        rest = target - effect.motion
        if np.abs(rest).max() <= _TOLERANCE * max(1.0, np.abs(target).max()):
            break
    first, *others = edits
    return FormCandidate(first.span, first.text, False, tuple(others))


def _text(atom: Atom, added: float) -> str:
    """Return the text of a number after an addition, with nine decimals, written as the number is.

    One that is no integer stays so: the control of a param depends on it.
    """
    text = written_as(atom.span.text, float(atom.value) + added)
    return f"{text}.0" if type(atom.value) is float and re.fullmatch(r"-?\d+", text) else text
