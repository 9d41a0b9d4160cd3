"""Tested fixes of errors: arguments in another order, an index that is one less, a missing argument, notations of other
languages that only a run detects.

A message alone does not say which of these was meant. Each candidate is evaluated, and one is offered only if the error
is gone with it and no other appears. An error in the expansion of a macro is fixed in its definition. Values are never
invented: a missing argument is a variable that is unused, has the name of the parameter or is an operand next to the
call, or the constant that all other calls of the function pass. For the axis of `rotate` it is the most frequent one,
or the vertical.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, TypeAlias

from scenelang.grammar.datum import (
    ArrayDatum,
    Atom,
    Datum,
    Keyword,
    ListDatum,
    Source,
    Span,
    Symbol,
    replace,
    walk,
)
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.grammar.reader import read_pieces
from scenelang.interpreter.checker.idioms import NAMES
from scenelang.repairs.edit_trials import Trials, edited
from scenelang.repairs.program_forms import bound_name, bound_names

if TYPE_CHECKING:
    from scenelang.session.session import Evaluated

MAX_TRIALS = 40  # evaluations for one program
_TRIALS_EFFORT = 10.0  # budget of all trials in units of `Trials`: about 10 s
_MAX_ERRORS = 3  # errors that get candidates; later ones often follow from the first
_MAX_TEXT_LENGTH = 100_000  # characters of a program
_DEFINITION_LENGTH = 3  # items of `(define name value)`
_POINT_LENGTH = 3  # components
_MIN_TELLING_NAME_LENGTH = 3  # letters; a shorter parameter name, such as `x`, does not identify a variable
_MIN_AGREEING_CALLS = 2  # calls that pass the same constant, before it is taken for a missing argument

_BRACKETS = ("unclosed", "extra-close")  # they hide all other errors, so that no candidate can be tested
_CONSEQUENCES = ("unused", "unreachable-word", "ambiguous-root")  # findings that an error causes, and that end with it

Evaluate: TypeAlias = "Callable[[Source], Evaluated]"


def with_tested(source: Source, diagnostics: Sequence[Diagnostic], evaluate: Evaluate) -> list[Diagnostic]:
    """Return diagnostics in which errors without a fix have the first candidate that resolves them.

    Parameters
    ----------
    diagnostics
        All diagnostics of ``source``; a candidate must not add to them.
    evaluate
        Evaluates another text of the program.
    """
    errors = [d for d in diagnostics if d.is_error]
    open_errors = [d for d in errors if not d.fixes and d.name in _CANDIDATES and _place(d, source) is not None]
    if not open_errors or len(source.text) > _MAX_TEXT_LENGTH or any(d.name in _BRACKETS for d in errors):
        return list(diagnostics)
    trials = Trials(source.name, evaluate, _TRIALS_EFFORT, MAX_TRIALS)
    fixed: dict[int, Diagnostic] = {}
    program = _Program(source)
    for error in open_errors[:_MAX_ERRORS]:
        others = Counter(_key(other) for other in diagnostics if other is not error)

        def resolving(fix: Fix, others: Counter[tuple[str, str]] = others) -> Fix | None:
            """Return the fix if all that is reported with it was reported before, besides the error."""
            result = trials.evaluate(edited(source.text, fix.edits))
            remaining = Counter(_key(d) for d in result.diagnostics if d.name not in _CONSEQUENCES)
            return fix if remaining <= others else None

        fix = trials.first(_CANDIDATES[error.name](program, error), resolving)
        if fix is not None:
            fixed[id(error)] = replace(error, fixes=(fix,))
    added = {edit.text.strip() for d in fixed.values() for fix in d.fixes for edit in fix.edits}
    return [fixed.get(id(d), d) for d in diagnostics if not _is_of_use(d, added)]


def _is_of_use(diagnostic: Diagnostic, added: Collection[str]) -> bool:
    """Return whether a diagnostic calls a name unused that a fix adds a use of."""
    return diagnostic.name == "unused" and diagnostic.span is not None and diagnostic.span.text in added


def _place(diagnostic: Diagnostic, source: Source) -> Span | None:
    """Return the span of the program that an error concerns; for an expansion, that of the macro definition."""
    span = diagnostic.span
    if span is not None and span.expansion is not None:
        span = span.expansion.definition
    return span if span is not None and span.source.name == source.name and span.expansion is None else None


def _key(diagnostic: Diagnostic) -> tuple[str, str]:
    """Return the identity of a diagnostic across versions of a program, whose positions differ."""
    return diagnostic.name, diagnostic.message


class _Program:
    """Forms of a program, including those of pieces that can be read when others cannot."""

    def __init__(self, source: Source) -> None:
        self.source = source
        datums = list(walk(*read_pieces(source).forms))
        self.lists = [datum for datum in datums if isinstance(datum, ListDatum) and datum.items]
        self.arrays = [datum for datum in datums if isinstance(datum, ArrayDatum) and datum.items]

    @property
    def variables(self) -> Iterator[str]:
        """Names of the variables that the program defines, in any scope."""
        return (
            bound_name(form.items[1])
            for form in self.lists
            if _head(form) == "define" and len(form.items) == _DEFINITION_LENGTH
        )

    def at(self, diagnostic: Diagnostic) -> list[ListDatum]:
        """Return the smallest list around an error; in a macro definition, all lists that call the named function."""
        span = _place(diagnostic, self.source)
        if span is None:
            return []
        if diagnostic.span is not None and diagnostic.span.expansion is not None:
            name = re.match(r"`([^`]+)` expects", diagnostic.message)
            inside = [form for form in self.lists if _has_span(span, form)]
            return [form for form in inside if name is not None and _head(form) == name[1]]
        around = [form for form in self.lists if _has(form, span.start, span.end)]
        return sorted(around, key=lambda form: form.span.end - form.span.start)[:1]

    def around(self, form: ListDatum) -> list[ListDatum]:
        """Return a list and those that enclose it, the innermost first."""
        enclosing = [outer for outer in self.lists if _has(outer, form.span.start, form.span.end)]
        return sorted(enclosing, key=lambda outer: outer.span.end - outer.span.start)

    def unused(self, around: Sequence[ListDatum]) -> Iterator[str]:
        """Yield unused names in scope: variables of ``around``, the innermost first, then global ones and words."""
        yield from (name for name, owner in bound_names(around) if _uses(owner.span.text, name) == 1)
        text = self.source.text
        for form in self.lists:
            if len(form.items) > 1 and not any(_has(form, outer.span.start, outer.span.end) for outer in around):
                second = form.items[1]
                if _head(form) == "define" and isinstance(second, Atom) and _uses(text, second.span.text) == 1:
                    yield second.span.text
                elif _head(form) == "bind" and isinstance(second, Atom) and text.count(second.span.text) == 1:
                    yield f"(call {second.span.text})"

    def span(self, start: int, end: int) -> Span:
        """Return the span between two offsets of the program."""
        return Span(self.source, start, end, None)


def _has(form: ListDatum, start: int, end: int) -> bool:
    """Return whether a form encloses a range."""
    return form.span.start <= start and end <= form.span.end


def _has_span(span: Span, form: ListDatum) -> bool:
    """Return whether a span encloses a form."""
    return span.start <= form.span.start and form.span.end <= span.end


def _head(form: ListDatum) -> str:
    """Return the text of the first item of a form."""
    return str(form.items[0].span.text)


# --- candidates ------------------------------------------------------------------------------------------------------


def _of_type(program: _Program, diagnostic: Diagnostic) -> Iterator[Fix]:
    """Yield fixes of a wrong type.

    They are a string for a symbol, a point of three components, arguments in another order, and an unused variable as
    one more argument.
    """
    yield from _strings(program, diagnostic)
    yield from _points(program, is_about_three="three" in diagnostic.message)
    for form in program.at(diagnostic):
        yield from _other_arguments(program, form)


_QUOTED = re.compile(r"'([^\s()\[\]'\"]+)'")


def _strings(program: _Program, diagnostic: Diagnostic) -> Iterator[Fix]:
    """Yield double quotes for single ones around a name, which are read as a quoted symbol and another quote."""
    if "got a symbol" in diagnostic.message:
        for match in _QUOTED.finditer(program.source.text):
            yield Fix("Write double quotes", (Edit(program.span(*match.span()), f'"{match[1]}"'),))


def _points(program: _Program, *, is_about_three: bool) -> Iterator[Fix]:
    """Yield points without a fourth component or with a third, and arrays of points without a number at their end."""
    for array in program.arrays:
        last = array.items[-1].span
        ends = [isinstance(item, ArrayDatum) for item in array.items[-2:]]
        is_odd = ends == [True, False]  # a point, then a number
        if is_odd or (is_about_three and len(array.items) == _POINT_LENGTH + 1):
            yield Fix("Leave out the last component", (Edit(program.span(array.items[-2].span.end, last.end), ""),))
        elif is_about_three and len(array.items) == _POINT_LENGTH - 1:
            yield Fix("Add the third component", (Edit(program.span(last.end, last.end), " 0"),))


def _other_arguments(program: _Program, form: ListDatum) -> Iterator[Fix]:
    """Yield calls in and around a form with two arguments swapped, then with an unused variable added."""
    yield from _swaps(form)
    for inner in form.items[1:]:
        if isinstance(inner, ListDatum) and inner.items:
            yield from _swaps(inner)
    for name in dict.fromkeys(program.unused(program.around(form))):
        for call in walk(form):
            if isinstance(call, ListDatum) and call.items:
                end = call.items[len(_positional(call))].span.end
                yield Fix(f"Add `{name}`", (Edit(program.span(end, end), f" {name}"),))


def _swaps(form: ListDatum) -> Iterator[Fix]:
    """Yield a call with two arguments swapped, neighbors first."""
    arguments = _positional(form)
    pairs = [(i, j) for gap in (1, 2) for i in range(len(arguments)) if (j := i + gap) < len(arguments)]
    for i, j in pairs:
        a, b = arguments[i].span, arguments[j].span
        if a.text != b.text:
            yield Fix("Swap the arguments", (Edit(a, b.text), Edit(b, a.text)))


def _positional(form: ListDatum) -> list[Datum]:
    """Return the arguments of a call before its first keyword."""
    arguments: list[Datum] = []
    for item in form.items[1:]:
        if isinstance(item, Atom) and type(item.value) is Keyword:
            break
        arguments.append(item)
    return arguments


_OUTSIDE = re.compile(r"index (-?\d+) is outside .* of length (\d+)")


def _of_index(program: _Program, diagnostic: Diagnostic) -> Iterator[Fix]:
    """Yield forms in which an index or the count of a loop is lower by one, the call before the enclosing forms."""
    forms = program.at(diagnostic)
    for form in forms:
        yield from _lowered(form)
        for outer in program.around(form)[1:]:
            yield from (fix for fix in _lowered(outer) if not _within(fix, form))
    match = _OUTSIDE.search(diagnostic.message)
    if match is not None:
        index, length = map(int, match.groups())
        atoms = [atom for loop in program.lists for atom in loop_counts(loop)]
        counts = [atom for atom in atoms if int(str(atom.value)) == index + 1 > length]
        yield from (_fix(atom.span, str(length)) for atom in counts)
    for form in forms:
        yield from _swaps(form)


def _within(fix: Fix, form: ListDatum) -> bool:
    """Return whether all edits of a fix are inside a form."""
    return all(_has(form, edit.span.start, edit.span.end) for edit in fix.edits)


def _lowered(form: ListDatum) -> Iterator[Fix]:
    """Yield fixes that replace an addition of 1, such as `(+ i 1)`, by its other operand."""
    for inner in walk(form):
        if isinstance(inner, ListDatum) and len(inner.items) == 3 and _head(inner) == "+":
            augend, addend = inner.items[1], inner.items[2]
            if addend.span.text == "1":
                yield _fix(inner.span, augend.span.text)


def loop_counts(form: Datum) -> Iterator[Atom]:
    """Yield the integers of a form that are numbers of repetitions or items."""
    if not isinstance(form, ListDatum) or not form.items:
        return
    head, items = _head(form), form.items
    places: list[Datum] = []
    if head in ("union-loop", "ring", "scatter", "iota", "range", "make-list"):
        places += items[1:2]
    elif head.startswith("for") and len(items) > 1 and isinstance(items[1], ListDatum):
        clauses = [clause for clause in items[1].items if isinstance(clause, ListDatum) and len(clause.items) == 2]
        places += [clause.items[1] for clause in clauses]
    yield from (datum for datum in places if isinstance(datum, Atom) and type(datum.value) is int)


def _fix(span: Span, text: str) -> Fix:
    """Return the fix that replaces a span by a text."""
    return Fix(f"Change to `{text}`", (Edit(span, text),))


_CALLED = re.compile(r"calls its parameter `([^`]+)`")


def _of_call(program: _Program, diagnostic: Diagnostic) -> Iterator[Fix]:
    """Yield brackets of a vector for the parentheses around values, which are read as a call."""
    match = _CALLED.search(diagnostic.message)
    forms = program.at(diagnostic) if match is None else [call for call in program.lists if _head(call) == match[1]]
    for form in forms:
        idiom = NAMES.get(_head(form))  # a name of another language
        if idiom is not None and idiom.instead:
            yield _fix(form.items[0].span, idiom.instead)
        yield Fix("Write a vector", (Edit(form.span, f"[{form.span.text[1:-1]}]"),))


# --- missing arguments -----------------------------------------------------------------------------------------------


def _of_arity(program: _Program, diagnostic: Diagnostic) -> Iterator[Fix]:
    """Yield calls with a value for the missing last argument, or with too many arguments gathered in a vector."""
    if not _is_short(diagnostic):
        for form in program.at(diagnostic):
            yield from _gathered(program, form)
        return
    for form in program.at(diagnostic):
        place = len(_positional(form))
        end = form.items[place].span.end
        for value in dict.fromkeys(_values(program, form, place, diagnostic.signature or "")):
            yield Fix(f"Add `{value}`", (Edit(program.span(end, end), f" {value}"),))
        if _head(form) == "transform" and place == 1:
            yield _fix(form.span, form.items[1].span.text)


def _gathered(program: _Program, form: ListDatum) -> Iterator[Fix]:
    """Yield a call whose last three arguments are the components of a vector."""
    arguments = _positional(form)
    if len(arguments) >= _POINT_LENGTH:
        span = program.span(arguments[-_POINT_LENGTH].span.start, arguments[-1].span.end)
        yield Fix("Write a vector", (Edit(span, f"[{span.text}]"),))


def _is_short(diagnostic: Diagnostic) -> bool:
    """Return whether a call has fewer arguments than the function expects."""
    expected, given = (re.search(r"\d+", text or "") for text in (diagnostic.expected, diagnostic.found))
    if expected is None or given is None:
        return diagnostic.name == "syntax"
    return int(given[0]) < int(expected[0])


def _values(program: _Program, form: ListDatum, place: int, signature: str) -> Iterator[str]:
    """Yield texts for the argument that is missing at the end of a call, the best evidence first."""
    names = _parameters(signature)
    name = names[place] if place < len(names) else ""
    around = program.around(form)
    variables = {*program.variables, *(variable for variable, _ in bound_names(around))}
    if len(name) >= _MIN_TELLING_NAME_LENGTH and name in variables:
        yield name
    yield from program.unused(around)
    siblings = list(_siblings(form, around))  # as in `(list x (- x))` and `(union a (on-top-of b a))`
    if _head(form) == "-":
        yield from siblings
    # `(define (f x) ...)` is not a call of `f`.
    heads = {id(define.items[1]) for define in program.lists if _head(define) == "define" and len(define.items) > 1}
    calls = [call for call in program.lists if call is not form and id(call) not in heads]
    near = [call for call in calls if _has(around[-1], call.span.start, call.span.end)]
    for group, is_usable, least in ((calls, _is_constant, _MIN_AGREEING_CALLS), (near, _is_variable, 1)):
        passed = _passed(group, form, place)
        texts = {argument.span.text for argument in passed}
        if len(texts) == 1 and is_usable(passed[0]) and len(passed) >= least:
            yield from texts
    yield from siblings
    if name == "axis" and _head(form) == "rotate":
        axes = Counter(argument.span.text for argument in _passed(calls, form, place))
        yield max(axes, key=lambda axis: axes[axis], default="[0 1 0]")  # most objects turn about the vertical


def _passed(calls: Iterable[ListDatum], form: ListDatum, place: int) -> list[Datum]:
    """Return the arguments at a place that calls of the same function pass."""
    return [arguments[place] for call in calls if len(arguments := _arguments_of(call, form)) > place]


def _siblings(form: ListDatum, around: Sequence[ListDatum]) -> Iterator[str]:
    """Yield the variables that are operands of the enclosing form, and not of the form."""
    used = {item.span.text for item in form.items}
    for outer in around[1:2]:
        for item in outer.items[1:]:
            if _is_variable(item) and item.span.text not in used:
                yield item.span.text


_COMPANIONS = (("sin", "cos"), ("x-of", "y-of", "z-of"))  # functions that are called together, of the same argument


def _arguments_of(other: ListDatum, form: ListDatum) -> list[Datum]:
    """Return the arguments of another call if it is one of the same function, else none."""
    names = next((names for names in _COMPANIONS if _head(form) in names), (_head(form),))
    return _positional(other) if _head(other) in names else []


def _parameters(signature: str) -> list[str]:
    """Return the names of the parameters that a signature requires."""
    inner = re.sub(r"\[[^\]]*\]|->.*", "", signature).strip().strip("()")
    return [word.partition("::")[0] for word in inner.split()[1:] if not word.startswith((":", "(", "...", "&"))]


def _is_constant(datum: Datum) -> bool:
    """Return whether a datum is a number, a string, or an array of numbers, which mean the same everywhere."""
    if isinstance(datum, ArrayDatum):
        return all(_is_constant(item) for item in datum.items)
    return isinstance(datum, Atom) and type(datum.value) in (int, float, str)


def _is_variable(datum: Datum) -> bool:
    """Return whether a datum is a symbol."""
    return isinstance(datum, Atom) and type(datum.value) is Symbol


def _uses(text: str, name: str) -> int:
    """Return the number of occurrences of a name in a text, as a variable or a parameter."""
    return len(re.findall(rf"(?<![^\s()\[\]'`,:]){re.escape(name)}(?![^\s()\[\]:])", text))


# Candidates for an error, by the name of its diagnostic (``grammar/diagnostics``).
_CANDIDATES: dict[str, Callable[[_Program, Diagnostic], Iterator[Fix]]] = {
    "type": _of_type,
    "value": _of_type,
    "parts": _of_type,
    "pose": _of_type,
    "not-a-procedure": _of_call,
    "attribute": _of_type,
    "index": _of_index,
    "key": _of_index,
    "arity": _of_arity,
    "syntax": _of_arity,
}
