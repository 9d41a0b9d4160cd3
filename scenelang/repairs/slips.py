"""Slips of an author: values and forms that a program suggests by its other values and forms.

A person who repairs a program asks which number is wrong before asking what it should be: the one that breaks a row,
that differs from those of its siblings, that has lost its sign or its point. What a slip suggests is exact, so an
object that then touches what it should touches it by more than chance. ``repairing`` tries each, as any other edit.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise, product

import numpy as np

from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, subdatums, walk
from scenelang.grammar.diagnostics import Edit
from scenelang.grammar.reader import read
from scenelang.repairs.program_forms import head_of

_MAX_PATTERN = 50  # numbers of a list whose pattern is looked for
_MIN_EQUAL = 3  # numbers of a list, of which all but one are equal
_MAX_SIBLINGS = 40  # forms of one kind that are compared
_MAX_LEAVES = 40  # numbers of a form that are compared
_OPPOSITES = {"+": "-", "-": "+"}
_MAX_ADDED = 60  # forms with one number more

# --- patterns --------------------------------------------------------------------------------------------------------


def patterns_of(form: Datum) -> Iterator[tuple[Atom, float]]:
    """Yield each number of a list with the value by which it would complete a pattern of all others.

    Patterns are equal steps, symmetry about 0, and equality; of a list of rows, those of each column. Arrays are places
    and points of profiles, not lists.

    Examples
    --------
    >>> [(atom.value, value) for atom, value in patterns_of(read(Source("a", "(-1 0 .4)")).forms[0])]
    [(-1, -0.4), (0.4, 1.0)]
    """
    for atoms in _sequences(form):
        yield from _completions(atoms)


def pattern_values(source: Source) -> dict[int, float]:
    """Return the values of ``patterns_of`` in a program, by the position of the number.

    The rows of a list have no patterns of their own: a place and a size have nothing to do with each other.
    """
    values: dict[int, float] = {}
    rows = set[int]()
    stack: list[Datum] = list(read(source).forms)
    while stack:
        datum = stack.pop()
        rows.update(id(row) for row in _rows_of(datum))
        if id(datum) not in rows:
            values.update((atom.span.start, value) for atom, value in patterns_of(datum))
        stack.extend(subdatums(datum))
    return values


def _items(form: Datum) -> tuple[Datum, ...]:
    """Return the items of a list that is written with ``'`` or ``list``."""
    return form.items[head_of(form) == "list" :] if isinstance(form, ListDatum) else ()


def _rows_of(form: Datum) -> list[tuple[Datum, ...]]:
    """Return the rows of a list of lists of one length, of which each begins with a number; empty for others."""
    rows = [item for item in _items(form) if isinstance(item, ListDatum)]
    lengths = {len(_items(row)) for row in rows}
    is_table = len(rows) == len(_items(form)) > 1 and len(lengths) == 1 and all(_is_number(_first(row)) for row in rows)
    return rows if is_table else []  # type: ignore[return-value]


def _first(form: Datum) -> Datum | None:
    """Return the first item of a list."""
    return next(iter(_items(form)), None)


def _sequences(form: Datum) -> Iterator[list[Atom]]:
    """Yield the numbers of a list, or of the columns of a list of rows."""
    rows = [_items(row) for row in _rows_of(form)]  # type: ignore[arg-type]
    for column in zip(*rows) if len(rows) >= _MIN_EQUAL else [] if rows else [_items(form)]:
        atoms = [item for item in column if _is_number(item)]
        if 2 <= len(atoms) == len(column) <= _MAX_PATTERN:
            yield atoms  # type: ignore[misc]


def _is_number(datum: Datum | None) -> bool:
    """Return whether a datum is a finite number."""
    return isinstance(datum, Atom) and type(datum.value) in (int, float) and bool(np.isfinite(datum.value))


def _completions(atoms: Sequence[Atom]) -> Iterator[tuple[Atom, float]]:
    """Yield each of some numbers with the value by which it would complete their pattern."""
    values = np.array([atom.value for atom in atoms], np.float64)
    if _is_regular(values):
        return
    for at, atom in enumerate(atoms):
        others = np.delete(values, at)
        if len(values) >= _MIN_EQUAL and not np.ptp(others):
            yield atom, float(others[0])
            continue
        for value in dict.fromkeys([*_even_values(values, at), -float(values[-1 - at])]):
            fixed = values.copy()
            fixed[at] = value
            if len(np.unique(fixed)) == len(fixed) and _is_regular(fixed):
                yield atom, value
                break


def _even_values(values: FloatArray, at: int) -> Iterator[float]:
    """Yield the number at a position of a list that makes its steps equal; of an end, if three others do."""
    if 0 < at < len(values) - 1:
        yield float(values[at - 1] + values[at + 1]) / 2.0
    elif len(values) > 3:
        yield float(2.0 * values[1] - values[2] if at == 0 else 2.0 * values[-2] - values[-3])


def _is_regular(values: FloatArray) -> bool:
    """Return whether numbers have equal steps, or are symmetric about 0."""
    room = 1e-9 * float(np.abs(values).max(initial=0.0))
    steps = np.diff(values)
    is_even = len(values) > 2 and float(np.ptp(steps)) <= room
    return is_even or float(np.abs(values + values[::-1]).max()) <= room


# --- forms that lack or have too much --------------------------------------------------------------------------------


def completed_lists(source: Source) -> Iterator[Edit]:
    """Yield the lists of a program with one number more, by which they are symmetric about 0 or have equal steps.

    What is forgotten of a list is a leg of a table, or a post. An attribute that other calls of its word do without is
    left out, too.
    """
    count = 0
    for datum in walk(*read(source).forms):
        for atoms in _sequences(datum) if not _rows_of(datum) else ():
            for edit in _with_one_more(atoms):
                count += 1
                if count <= _MAX_ADDED:
                    yield edit
    single = _items_alone(source)
    yield from single


def _items_alone(source: Source) -> Iterator[Edit]:
    """Yield the lists of one number with its mirror image."""
    for datum in walk(*read(source).forms):
        if isinstance(datum, ListDatum) and head_of(datum) in ("quote", "list"):
            items = _items(datum.items[1]) if head_of(datum) == "quote" else _items(datum)
            if len(items) == 1 and _is_number(items[0]) and items[0].value:  # type: ignore[union-attr]
                yield _added(items[0], -float(items[0].value), after=True)  # type: ignore[union-attr, arg-type]


def _with_one_more(atoms: Sequence[Atom]) -> Iterator[Edit]:
    """Yield numbers with one more before, between or after them, by which they are regular."""
    values = [float(atom.value) for atom in atoms]
    steps = np.diff(values)
    new = [-value for value in values]
    if len(values) > 1:
        new += [values[0] - float(steps[-1]), values[-1] + float(steps[0])]
        new += [(a + b) / 2.0 for a, b in pairwise(values)]
    for value in dict.fromkeys(new):
        for at in range(len(values) + 1):
            longer = np.insert(np.array(values), at, value)
            if np.ptp(np.diff(longer)) and not _is_regular(longer):
                continue
            if len(np.unique(longer)) == len(longer) and (np.diff(np.sign(np.diff(longer))) == 0).all():
                yield _added(atoms[min(at, len(atoms) - 1)], value, after=at == len(atoms))


def _added(atom: Atom, value: float, *, after: bool) -> Edit:
    """Return the edit that writes a number before or after another one."""
    text = number_text(value)
    return Edit(atom.span, f"{atom.span.text} {text}" if after else f"{text} {atom.span.text}")


def number_text(value: float, decimals: int = 9) -> str:
    """Write a number as programs do: with at most so many decimals, and no zero before the point."""
    text = f"{round(value, decimals) + 0.0:.12g}"
    if "e" in text:
        return text
    if text.startswith("-0."):
        return text.replace("-0.", "-.", 1)
    return text.removeprefix("0") if text.startswith("0.") else text


def attributes_left_out(source: Source) -> Iterator[Edit]:
    """Yield the calls of a program without one attribute that another call of the same word does without."""
    groups = [group for group, is_word in sibling_forms(source) if is_word]
    for group in groups:
        calls = [next(form for form in walk(each) if head_of(form) == "call") for each in group]
        for call in dict.fromkeys(calls):
            for key, value in zip(call.items[2:], call.items[3:]):  # type: ignore[union-attr]
                if isinstance(key, Atom) and isinstance(key.value, Keyword):
                    if any(f":{key.value}" not in other.span.text.split() for other in calls):
                        text, start = call.span.source.text, key.span.start
                        while start > 0 and text[start - 1].isspace():
                            start -= 1
                        yield Edit(Span(call.span.source, start, value.span.end), "")


# --- siblings --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Slip:
    """A form to write in place of a number or vector, and how likely it is as a slip.

    Attributes
    ----------
    edit
        The text in place of the form.
    kind
        "sibling" for what a form of the same word has, "other" for what one of another word has, "sign", "turn" for the
        sign of an angle, "operation" for the opposite one, "point" for a number with its point elsewhere, "zero" for
        one on an axis, "order" for another order of components or poses.
    """

    edit: Edit
    kind: str


def sibling_forms(source: Source) -> Iterator[tuple[list[ListDatum], bool]]:
    """Yield the forms of each definition that begin alike and call the same word, then those of any word.

    Each group comes with whether its forms call one word.
    """
    for top in read(source).forms:
        by_word: dict[tuple[str, str], list[ListDatum]] = {}
        by_head: dict[str, list[ListDatum]] = {}
        for form in walk(top):
            head, word = head_of(form), _word_in(form)
            if isinstance(form, ListDatum) and head is not None and word is not None and head != "call":
                if _is_placement(form):
                    by_word.setdefault((head, word), []).append(form)
                    by_head.setdefault(head, []).append(form)
        yield from ((group[:_MAX_SIBLINGS], True) for group in by_word.values() if len(group) > 1)
        yield from ((group[:_MAX_SIBLINGS], False) for group in by_head.values() if len(group) > 1)


def _is_placement(form: ListDatum) -> bool:
    """Return whether a form places one call: no other list or definition is between them."""
    return sum(head_of(item) == "call" for item in form.items) == 1


def _word_in(form: Datum) -> str | None:
    """Return the word of the call that a form places, None if it places none."""
    calls = [item for item in getattr(form, "items", ()) if isinstance(item, ListDatum) and head_of(item) == "call"]
    word = calls[0].items[1] if len(calls) == 1 and len(calls[0].items) > 1 else None
    return word.value if isinstance(word, Atom) and type(word.value) is str else None


def _leaves(form: Datum) -> dict[tuple[int, ...], Datum]:
    """Return the numbers of a form, and the forms that stand where numbers may, by their path."""
    leaves: dict[tuple[int, ...], Datum] = {}
    stack: list[tuple[tuple[int, ...], Datum]] = [((), form)]
    while stack and len(leaves) < _MAX_LEAVES:
        path, datum = stack.pop()
        if path:
            leaves[path] = datum
        if isinstance(datum, ArrayDatum) or (isinstance(datum, ListDatum) and head_of(datum) != "call"):
            stack.extend(((*path, k), item) for k, item in reversed(list(enumerate(datum.items))))
    return leaves


def sibling_values(source: Source) -> Iterator[Slip]:
    """Yield in place of each number what the siblings of its form have there, and the opposite numbers."""
    for group, is_word in sibling_forms(source):
        leaves = [_leaves(form) for form in group]
        for own in leaves:
            for path, datum in own.items():
                if _is_number(datum):
                    others = [each[path] for each in leaves if each is not own and path in each]
                    yield from _in_place(datum, others, "sibling" if is_word else "other")


def _in_place(datum: Datum, others: Iterable[Datum], kind: str) -> Iterator[Slip]:
    """Yield the values of others in place of a number."""
    texts = []
    for other in others:
        if isinstance(other, Atom) and _is_number(other):
            texts += [other.span.text, number_text(-float(other.value))]
        elif isinstance(other, ListDatum) or (isinstance(other, Atom) and type(other.value) is Symbol):
            texts.append(other.span.text)
    yield from (Slip(Edit(datum.span, text), kind) for text in dict.fromkeys(texts) if text != datum.span.text)


# --- numbers by themselves -------------------------------------------------------------------------------------------


def changed_numbers(source: Source) -> Iterator[Slip]:
    """Yield each number with the other sign and its point elsewhere, and angles and operations turned round."""
    for datum in walk(*read(source).forms):
        if isinstance(datum, ArrayDatum):  # a place on an axis
            numbers = [item.span for item in datum.items if _is_number(item)]
            yield from (Slip(Edit(span, "0"), "zero") for span in numbers if span.text != "0")
        elif isinstance(datum, Atom) and _is_number(datum) and datum.value:
            value = float(datum.value)
            yield Slip(Edit(datum.span, number_text(-value)), "sign")
            if type(datum.value) is float:
                yield Slip(Edit(datum.span, number_text(10.0 * value)), "point")
        elif not isinstance(datum, ListDatum):
            continue
        elif head_of(datum) == "rotate" and len(datum.items) > 2 and not _is_number(datum.items[1]):
            angle = datum.items[1]
            is_negative = head_of(angle) == "-" and len(angle.items) == 2
            yield Slip(Edit(angle.span, angle.items[1].span.text if is_negative else f"(- {angle.span.text})"), "turn")
        elif head_of(datum) in _OPPOSITES and len(datum.items) == 3:
            yield Slip(Edit(datum.items[0].span, _OPPOSITES[head_of(datum) or ""]), "operation")


def changed_orders(source: Source) -> Iterator[Slip]:
    """Yield each vector of numbers with two components exchanged, and each product of poses in the other order."""
    for datum in walk(*read(source).forms):
        if isinstance(datum, ArrayDatum) and 2 <= len(datum.items) <= 3 and all(map(_is_number, datum.items)):
            for i, j in combinations(range(len(datum.items)), 2):
                texts = [item.span.text for item in datum.items]
                is_level = (i, j) == (0, 2) or "0" in (texts[i], texts[j])  # a height is not taken for a breadth
                if is_level and float(texts[i]) != float(texts[j]):
                    texts[i], texts[j] = texts[j], texts[i]
                    yield Slip(Edit(datum.span, f"[{' '.join(texts)}]"), "order")
        elif head_of(datum) == "@" and isinstance(datum, ListDatum) and len(datum.items) == 3:
            first, second = (item.span.text for item in datum.items[1:])
            yield Slip(Edit(datum.span, f"(@ {second} {first})"), "order")


def completed_grids(source: Source) -> Iterator[tuple[Edit, ...]]:
    """Yield the clauses of a loop over two lists with the one corner more that their grid lacks."""
    for datum in walk(*read(source).forms):
        clauses = [_clause_numbers(item) for item in datum.items] if isinstance(datum, ListDatum) else []
        columns = [numbers for numbers in clauses if numbers]
        if len(columns) != 2 or len(clauses) != len(columns) or len(columns[0]) != len(columns[1]):
            continue
        values = [[float(atom.value) for atom in column] for column in columns]
        points = set(zip(*values))
        missing = [corner for corner in product(*map(dict.fromkeys, values)) if corner not in points]
        if len(missing) == 1 and len(points) == len(values[0]):
            yield tuple(_added(column[-1], value, after=True) for column, value in zip(columns, missing[0]))


def _clause_numbers(clause: Datum) -> list[Atom]:
    """Return the numbers of the list of a clause such as ``(x '(-1 1))``."""
    if not isinstance(clause, ListDatum) or len(clause.items) != 2:
        return []
    quoted = clause.items[1]
    items = _items(quoted.items[1]) if head_of(quoted) == "quote" else ()
    numbers = [item for item in items if isinstance(item, Atom)]
    return numbers if len(numbers) == len(items) and all(map(_is_number, items)) else []
