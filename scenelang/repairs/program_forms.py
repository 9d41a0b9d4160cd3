"""Forms of a program's text: the calls of a word with what encloses them, and the bodies of its functions."""

from __future__ import annotations

from scenelang.grammar.datum import Atom, Datum, ListDatum, Source, Symbol, subdatums
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
