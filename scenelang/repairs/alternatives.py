"""Fixes for errors that are tested: arguments in another order, an index that is one less, an argument that is missing,
notations of other languages that only a run finds.

A message alone does not say which of these was meant. Each candidate is evaluated, and one is offered only if the error
is gone with it, and no other came. An error in the expansion of a macro is fixed in its definition. Values are never
invented: what is put in place of a missing argument is a variable that is used nowhere, called as the parameter or
stands beside the call, or what all other calls of the function pass.
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

if TYPE_CHECKING:
    from scenelang.session.session import Evaluated

MAX_TRIALS = 40  # of a program
_EFFORT = 10.0  # of all trials: about 10 s
_MAX_ERRORS = 3
_MAX_TEXT = 100_000  # characters of a program

_BRACKETS = ("unclosed", "extra-close")  # hide all other errors, so that nothing can be tested
_CONSEQUENCES = ("unused", "unreachable-word", "ambiguous-root")  # of an error that ends

Evaluate: TypeAlias = "Callable[[Source], Evaluated]"


def with_tested(source: Source, found: Sequence[Diagnostic], evaluate: Evaluate) -> list[Diagnostic]:
    """Return findings where errors without a fix get the first candidate that resolves them; ``evaluate`` evaluates
    another text."""
    errors = [d for d in found if d.is_error]
    open_errors = [d for d in errors if not d.fixes and d.name in _CANDIDATES and _place(d, source) is not None]
    if not open_errors or len(source.text) > _MAX_TEXT or any(d.name in _BRACKETS for d in errors):
        return list(found)
    trials = Trials(source.name, evaluate, _EFFORT, MAX_TRIALS)
    fixed: dict[int, Diagnostic] = {}
    program = _Program(source)
    for error in open_errors[:_MAX_ERRORS]:
        others = Counter(_key(other) for other in found if other is not error)

        def resolving(fix: Fix, others: Counter[tuple[str, str]] = others) -> Fix | None:
            result = trials.evaluate(edited(source.text, fix.edits))
            remaining = Counter(_key(d) for d in result.diagnostics if d.name not in _CONSEQUENCES)
            return fix if remaining <= others else None

        fix = trials.first(_CANDIDATES[error.name](program, error), resolving)
        if fix is not None:
            fixed[id(error)] = replace(error, fixes=(fix,))
    added = {edit.text.strip() for d in fixed.values() for fix in d.fixes for edit in fix.edits}
    return [fixed.get(id(d), d) for d in found if not _is_of_use(d, added)]


def _is_of_use(diagnostic: Diagnostic, added: Collection[str]) -> bool:
    """Return whether a finding says that something is unused that a fix uses."""
    return diagnostic.name == "unused" and diagnostic.span is not None and diagnostic.span.text in added


def _place(diagnostic: Diagnostic, source: Source) -> Span | None:
    """Return the range of a program that an error is about: of the macro's definition, for one in its expansion."""
    span = diagnostic.span
    if span is not None and span.expansion is not None:
        span = span.expansion.definition
    return span if span is not None and span.source.name == source.name and span.expansion is None else None


def _key(diagnostic: Diagnostic) -> tuple[str, str]:
    return diagnostic.name, diagnostic.message


class _Program:
    """A program as datums."""

    def __init__(self, source: Source) -> None:
        self.source = source
        datums = list(walk(*read_pieces(source).forms))
        self.lists = [each for each in datums if isinstance(each, ListDatum) and each.items]
        self.arrays = [each for each in datums if isinstance(each, ArrayDatum) and each.items]

    @property
    def variables(self) -> Iterator[str]:
        """Names of the variables that the program defines, wherever."""
        return (
            _bound(form.items[1]) for form in self.lists if _head(form) == "define" and len(form.items) == _DEFINITION
        )

    def at(self, diagnostic: Diagnostic) -> list[ListDatum]:
        """The smallest list that has all that an error is about; in a macro, the lists of the named function."""
        span = _place(diagnostic, self.source)
        if span is None:
            return []
        if diagnostic.span is not None and diagnostic.span.expansion is not None:
            name = re.match(r"`([^`]+)` expects", diagnostic.message)
            inside = [each for each in self.lists if _has_span(span, each)]
            return [each for each in inside if name is not None and _head(each) == name[1]]
        around = [each for each in self.lists if _has(each, span.start, span.end)]
        return sorted(around, key=lambda each: each.span.end - each.span.start)[:1]

    def around(self, form: ListDatum) -> list[ListDatum]:
        """The lists that a list stands in, from the inside to the outside, after itself."""
        found = [each for each in self.lists if _has(each, form.span.start, form.span.end)]
        return sorted(found, key=lambda each: each.span.end - each.span.start)

    def unused(self, around: Sequence[ListDatum]) -> Iterator[str]:
        """What is defined for a place and used nowhere: variables from the inside to the outside, and words."""
        yield from (name for name, owner in _scope(around) if _uses(owner.span.text, name) == 1)
        text = self.source.text
        for form in self.lists:
            if len(form.items) > 1 and not any(_has(form, each.span.start, each.span.end) for each in around):
                second = form.items[1]
                if _head(form) == "define" and isinstance(second, Atom) and _uses(text, second.span.text) == 1:
                    yield second.span.text
                elif _head(form) == "bind" and isinstance(second, Atom) and text.count(second.span.text) == 1:
                    yield f"(call {second.span.text})"

    def span(self, start: int, end: int) -> Span:
        return Span(self.source, start, end, None)


_DEFINITION = 3  # items of `(define name value)`


def _has(form: ListDatum, start: int, end: int) -> bool:
    return form.span.start <= start and end <= form.span.end


def _has_span(span: Span, form: ListDatum) -> bool:
    return span.start <= form.span.start and form.span.end <= span.end


def _head(form: ListDatum) -> str:
    return str(form.items[0].span.text)


# --- candidates ------------------------------------------------------------------------------------------------------


def _of_type(program: _Program, diagnostic: Diagnostic) -> Iterator[Fix]:
    """A string for a symbol, a point of three components, arguments in another order, or one more that is used
    nowhere."""
    yield from _strings(program, diagnostic)
    yield from _points(program, "three" in diagnostic.message)
    for form in program.at(diagnostic):
        yield from _other_arguments(program, form)


_QUOTED = re.compile(r"'([^\s()\[\]'\"]+)'")


def _strings(program: _Program, diagnostic: Diagnostic) -> Iterator[Fix]:
    """Double quotes for the single ones around a name, which is read as a symbol and another quote."""
    if "got a symbol" in diagnostic.message:
        for found in _QUOTED.finditer(program.source.text):
            yield Fix("Write double quotes", (Edit(program.span(*found.span()), f'"{found[1]}"'),))


def _points(program: _Program, is_about_three: bool) -> Iterator[Fix]:
    """Points without a fourth component, and with a third; arrays of points without a number at their end."""
    for array in program.arrays:
        last = array.items[-1].span
        is_odd = len(array.items) > 1 and [isinstance(item, ArrayDatum) for item in array.items[-2:]] == [True, False]
        if is_odd or (is_about_three and len(array.items) == _COMPONENTS + 1):
            yield Fix("Leave out the last component", (Edit(program.span(array.items[-2].span.end, last.end), ""),))
        elif is_about_three and len(array.items) == _COMPONENTS - 1:
            yield Fix("Add the third component", (Edit(program.span(last.end, last.end), " 0"),))


def _other_arguments(program: _Program, form: ListDatum) -> Iterator[Fix]:
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
    given = _positional(form)
    pairs = [(i, j) for gap in (1, 2) for i in range(len(given)) if (j := i + gap) < len(given)]
    for i, j in pairs:
        a, b = given[i].span, given[j].span
        if a.text != b.text:
            yield Fix("Swap the arguments", (Edit(a, b.text), Edit(b, a.text)))


def _positional(form: ListDatum) -> list[Datum]:
    """Return the arguments of a call before its first keyword."""
    found: list[Datum] = []
    for item in form.items[1:]:
        if isinstance(item, Atom) and type(item.value) is Keyword:
            break
        found.append(item)
    return found


_OUTSIDE = re.compile(r"index (-?\d+) is outside .* of length (\d+)")


def _of_index(program: _Program, diagnostic: Diagnostic) -> Iterator[Fix]:
    """An index, or the count of a loop, that is one too high, in the call and what is around it."""
    forms = program.at(diagnostic)
    for form in forms:
        yield from _lowered(form)
        for outer in program.around(form)[1:]:
            yield from (fix for fix in _lowered(outer) if not _within(fix, form))
    match = _OUTSIDE.search(diagnostic.message)
    if match is not None:
        index, length = map(int, match.groups())
        counts = [
            atom for each in program.lists for atom in loop_counts(each) if int(str(atom.value)) == index + 1 > length
        ]
        yield from (_fix(atom.span, str(length)) for atom in counts)
    for form in forms:
        yield from _swaps(form)


def _within(fix: Fix, form: ListDatum) -> bool:
    return all(_has(form, edit.span.start, edit.span.end) for edit in fix.edits)


def _lowered(form: ListDatum) -> Iterator[Fix]:
    """Leave out the one that is added in a list, or in the lists in it."""
    for each in walk(form):
        if isinstance(each, ListDatum) and len(each.items) == 3 and _head(each) == "+":
            one, other = each.items[2], each.items[1]
            if one.span.text == "1":
                yield _fix(each.span, other.span.text)


def loop_counts(form: Datum) -> Iterator[Atom]:
    """Yield the whole numbers in a form that say how often something is done or made."""
    if not isinstance(form, ListDatum) or not form.items:
        return
    head, items = _head(form), form.items
    places: list[Datum] = []
    if head in ("union-loop", "ring", "scatter", "iota", "range", "make-list"):
        places += items[1:2]
    elif head.startswith("for") and len(items) > 1 and isinstance(items[1], ListDatum):
        places += [each.items[1] for each in items[1].items if isinstance(each, ListDatum) and len(each.items) == 2]
    yield from (each for each in places if isinstance(each, Atom) and type(each.value) is int)


def _fix(span: Span, text: str) -> Fix:
    return Fix(f"Change to `{text}`", (Edit(span, text),))


_CALLED = re.compile(r"calls its parameter `([^`]+)`")


def _of_call(program: _Program, diagnostic: Diagnostic) -> Iterator[Fix]:
    """Brackets of a vector for the parentheses of a list that calls what is no function, such as a parameter."""
    match = _CALLED.search(diagnostic.message)
    forms = program.at(diagnostic) if match is None else [each for each in program.lists if _head(each) == match[1]]
    for form in forms:
        meant = NAMES.get(_head(form))
        if meant is not None and meant.instead:
            yield _fix(form.items[0].span, meant.instead)
        yield Fix("Write a vector", (Edit(form.span, f"[{form.span.text[1:-1]}]"),))


# --- missing arguments -----------------------------------------------------------------------------------------------


def _of_arity(program: _Program, diagnostic: Diagnostic) -> Iterator[Fix]:
    """The last argument, where the program tells what it is."""
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
    """The last three arguments as the components of a vector."""
    given = _positional(form)
    if len(given) >= _COMPONENTS:
        span = program.span(given[-_COMPONENTS].span.start, given[-1].span.end)
        yield Fix("Write a vector", (Edit(span, f"[{span.text}]"),))


_COMPONENTS = 3


def _is_short(diagnostic: Diagnostic) -> bool:
    """Return whether a call has fewer arguments than the function expects."""
    expected, found = (re.search(r"\d+", text or "") for text in (diagnostic.expected, diagnostic.found))
    if expected is None or found is None:
        return diagnostic.name == "syntax"
    return int(found[0]) < int(expected[0])


def _values(program: _Program, form: ListDatum, place: int, signature: str) -> Iterator[str]:
    """What may be missing at the end of a call, the best evidence first."""
    names = _parameters(signature)
    name = names[place] if place < len(names) else ""
    around = program.around(form)
    if len(name) >= _NAME and name in {*program.variables, *(each for each, _ in _scope(around))}:
        yield name
    yield from program.unused(around)
    beside = list(_beside(form, around))  # as in `(list x (- x))` and `(union a (on-top-of b a))`
    if _head(form) == "-":
        yield from beside
    heads = {id(each.items[1]) for each in program.lists if _head(each) == "define" and len(each.items) > 1}
    calls = [each for each in program.lists if each is not form and id(each) not in heads]
    near = [each for each in calls if _has(around[-1], each.span.start, each.span.end)]
    for group, is_known in ((calls, _is_constant), (near, _is_variable)):
        given = [arguments[place] for each in group if len(arguments := _same(each, form)) > place]
        known = {each.span.text for each in given}
        if len(known) == 1 and is_known(given[0]) and len(given) >= (_AGREE if group is calls else 1):
            yield from known
    yield from beside
    if name == "axis" and _head(form) == "rotate":
        axes = Counter(given[place].span.text for each in calls if len(given := _same(each, form)) > place)
        yield max(axes, key=lambda axis: axes[axis], default="[0 1 0]")  # most things turn about the vertical


def _beside(form: ListDatum, around: Sequence[ListDatum]) -> Iterator[str]:
    """Yield the variables that stand beside a form, and not in it."""
    used = {each.span.text for each in form.items}
    yield from (each.span.text for outer in around[1:2] for each in outer.items[1:]
                if _is_variable(each) and each.span.text not in used)  # fmt: skip


_NAME = 3  # letters of a parameter's name that say what it is, unlike `x`
_AGREE = 2  # calls that pass the same constant
_COMPANIONS = (("sin", "cos"), ("x-of", "y-of", "z-of"))  # functions that are called together, of the same argument


def _same(other: ListDatum, form: ListDatum) -> list[Datum]:
    """Return the arguments of another call of the same function, or none."""
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
    return isinstance(datum, Atom) and type(datum.value) is Symbol


_BINDING = ("define", "lambda")


def _scope(around: Iterable[ListDatum]) -> Iterator[tuple[str, ListDatum]]:
    """Yield the names that forms around a place bind, with the forms, from the inside to the outside."""
    for form in around:
        head, items = _head(form), form.items
        if len(items) > 1 and isinstance(items[0], ListDatum):  # a pattern of a macro, or a clause
            yield from ((name, form) for each in items[0].items[1:] if (name := _bound(each)))
        if head in _BINDING and len(items) > 1 and isinstance(items[1], ListDatum):
            parameters = items[1].items[1 if head == "define" else 0 :]
            yield from ((name, form) for each in parameters if (name := _bound(each)))
        elif re.match(r"let|for", head) and len(items) > 1 and isinstance(items[1], ListDatum):
            yield from (
                (name, form) for each in items[1].items if isinstance(each, ListDatum) and (name := _bound(each))
            )
        for item in items[1:]:
            if isinstance(item, ListDatum) and len(item.items) == 3 and _head(item) == "define":
                name = _bound(item.items[1]) if isinstance(item.items[1], Atom) else ""
                if name:
                    yield name, form


def _bound(datum: Datum) -> str:
    """Return the name of a parameter or clause, empty for what binds several."""
    first = datum.items[0] if isinstance(datum, ListDatum) and datum.items else datum
    is_name = isinstance(first, Atom) and type(first.value) in (Symbol, Keyword)
    return first.span.text.lstrip(":").partition("::")[0] if is_name else ""


def _uses(text: str, name: str) -> int:
    """Return how often a text has a name, as a variable or a parameter."""
    return len(re.findall(rf"(?<![^\s()\[\]'`,:]){re.escape(name)}(?![^\s()\[\]:])", text))


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
