"""Forms of a program's text: the calls of a word with what encloses them, the bodies of its functions, and the names
that are in scope there.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, subdatums
from scenelang.grammar.reader import read

# Forms that bound an edit: what encloses them makes more than the call.
_SCOPES = frozenset({"bind", "define", "lambda", "param", "import", "scene", "let", "let*", "letrec", "quote"})


def forms_of(source: Source, word: str) -> tuple[list[list[ListDatum]], list[ListDatum]]:
    """Return the calls of a word, each with its enclosing forms up to a definition, and the bodies of its functions.

    Calls whose word is computed come last, as they may be of any word.
    """
    literal: list[list[ListDatum]] = []
    computed: list[list[ListDatum]] = []
    bodies: list[ListDatum] = []
    stack: list[tuple[Datum, tuple[ListDatum, ...]]] = [(form, ()) for form in reversed(read(source).forms)]
    while stack:
        datum, around = stack.pop()
        if isinstance(datum, ListDatum):
            if head_of(datum) == "call" and len(datum.items) > 1:
                name = datum.items[1]
                if isinstance(name, Atom) and type(name.value) is str:
                    if name.value == word:
                        literal.append([datum, *around])
                else:
                    computed.append([datum, *around])
            elif head_of(datum) == word:  # operations of solids make an entity of their name
                literal.append([datum, *around])
            if head_of(datum) == "bind" and binds(datum, word):
                bodies += bodies_of(datum)
            around = () if head_of(datum) in _SCOPES else (datum, *around)
        stack.extend((child, around) for child in reversed(list(subdatums(datum))))
    return [*literal, *computed], bodies


def binds(datum: ListDatum, word: str) -> bool:
    """Return whether a form binds a word."""
    return len(datum.items) > 2 and isinstance(datum.items[1], Atom) and datum.items[1].value == word


def bodies_of(datum: ListDatum) -> list[ListDatum]:
    """Return the last form of the function that a word is bound to."""
    function = datum.items[2]
    if head_of(function) != "lambda" or not isinstance(function, ListDatum) or len(function.items) < 3:
        return []
    last = function.items[-1]
    return [last] if isinstance(last, ListDatum) else []


def head_of(datum: Datum) -> str | None:
    """Return the symbol that a form begins with; None if it begins with none."""
    first = datum.items[0] if isinstance(datum, ListDatum) and datum.items else None
    return str(first.value) if isinstance(first, Atom) and isinstance(first.value, Symbol) else None


def enclosing_forms(source: Source, span: Span) -> list[ListDatum]:
    """Return the forms that enclose a span of a program, the innermost first."""
    forms: list[ListDatum] = []
    level: list[Datum] = list(read(source).forms)
    while True:
        outer = next((each for each in level if each.span.start <= span.start and span.end <= each.span.end), None)
        if outer is None or isinstance(outer, Atom) or (outer.span.start, outer.span.end) == (span.start, span.end):
            return forms[::-1]
        if isinstance(outer, ListDatum):
            forms.append(outer)
        level = list(subdatums(outer))


def outermost_around(source: Source, form: ListDatum) -> Span:
    """Return the outermost form around another one, up to a definition or a binding."""
    outermost = form.span
    for outer in enclosing_forms(source, form.span):
        if head_of(outer) in _SCOPES:
            break
        outermost = outer.span
    return outermost


def uses_around(source: Source, span: Span) -> list[ListDatum]:
    """Return the uses of the functions and macros that a span helps to define, those of the innermost first."""
    uses: list[ListDatum] = []
    for definition in enclosing_forms(source, span):
        name = _defined_name(definition)
        if name is not None:
            uses += _forms_with_head(source, name, definition)
    return uses


def _defined_name(form: ListDatum) -> str | None:
    """Return the name of the function or macro that a form defines; None if it defines none."""
    head, target = head_of(form), form.items[1] if len(form.items) > 2 else None
    if head in ("define", "define-macro") and isinstance(target, ListDatum):
        return head_of(target)
    is_function = head == "define-syntax" or (head == "define" and head_of(form.items[-1]) == "lambda")
    return bound_name(target) or None if is_function and isinstance(target, Atom) else None


def _forms_with_head(source: Source, name: str, definition: ListDatum) -> list[ListDatum]:
    """Return the forms that begin with a name, in order, except those in its definition."""
    uses: list[ListDatum] = []
    stack: list[Datum] = list(reversed(read(source).forms))
    while stack:
        datum = stack.pop()
        if datum.span.start == definition.span.start and datum.span.end == definition.span.end:
            continue
        if isinstance(datum, ListDatum) and head_of(datum) == name:
            uses.append(datum)
        stack.extend(reversed(list(subdatums(datum))))
    return uses


def bound_names(around: Iterable[ListDatum]) -> Iterator[tuple[str, ListDatum]]:
    """Yield the names that enclosing forms bind, each with its form, the innermost first."""
    for form in around:
        head, items = str(form.items[0].span.text) if form.items else "", form.items
        if len(items) > 1 and isinstance(items[0], ListDatum):  # a pattern of a macro, or a clause
            yield from ((name, form) for item in items[0].items[1:] if (name := bound_name(item)))
        if head in ("define", "lambda") and len(items) > 1 and isinstance(items[1], ListDatum):
            parameters = items[1].items[1 if head == "define" else 0 :]
            yield from ((name, form) for parameter in parameters if (name := bound_name(parameter)))
        elif re.match(r"let|for|do$", head):
            is_named = head == "let" and len(items) > 2 and isinstance(items[1], Atom)
            bindings = items[2] if is_named else items[1] if len(items) > 1 else None
            clauses = bindings.items if isinstance(bindings, ListDatum) else ()
            lists = [clause for clause in clauses if isinstance(clause, ListDatum)]
            yield from ((name, form) for clause in lists if (name := bound_name(clause)))
        for item in items[1:]:
            if isinstance(item, ListDatum) and len(item.items) == 3 and head_of(item) == "define":
                name = bound_name(item.items[1]) if isinstance(item.items[1], Atom) else ""
                if name:
                    yield name, form


def names_in_scope(around: Iterable[ListDatum], span: Span) -> Iterator[str]:
    """Yield the names that forms around a span bind, except those that are defined around it or after it."""
    for form in around:
        bindings = next((item for item in form.items[1:3] if isinstance(item, ListDatum)), None)
        if bindings is not None and _contains(bindings, span) and re.match(r"let|for|do$", head_of(form) or ""):
            continue
        later = {
            bound_name(item.items[1])
            for item in form.items[1:]
            if isinstance(item, ListDatum) and head_of(item) == "define" and len(item.items) == 3
            if item.span.end > span.start
        }
        yield from (name for name, _ in bound_names([form]) if name not in later)


def _contains(form: Datum, span: Span) -> bool:
    """Return whether a form encloses a span."""
    return form.span.start <= span.start and span.end <= form.span.end


def bound_name(datum: Datum) -> str:
    """Return the name of a parameter or clause; empty if it binds several."""
    first = datum.items[0] if isinstance(datum, ListDatum) and datum.items else datum
    is_name = isinstance(first, Atom) and type(first.value) in (Symbol, Keyword)
    return first.span.text.lstrip(":").partition("::")[0] if is_name else ""
