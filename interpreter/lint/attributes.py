"""Attributes and parameters that never meet."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.interpreter.shapes import GEOMETRY
from scenelang.interpreter.values import Keyword

_ALL_GEOMETRY = frozenset(name for names in GEOMETRY.values() for name in names)


def optional_parameters(form: Any, word: str | None) -> Iterator[Diagnostic]:
    """Parameters of a word's function that a ``call`` never fills."""
    function = form.function if word is not None else None
    if type(function) is ast.Lambda:
        for parameter in function.parameters:
            if parameter.kind == "optional":
                hint = f"make it a keyword parameter: `(:{parameter.name} default)`"
                message = f'a `call` of "{word}" never fills `{parameter.name}`; it keeps its default'
                yield Diagnostic("optional-embedding", message, function.span, hint)


def idle_attributes(nodes: Iterable[Any]) -> Iterator[tuple[str, Diagnostic]]:
    """Attributes of a geometric primitive that its geometry does not read, though another's does, or nearly so."""
    for node in nodes:
        word = node.word.value if type(node) is ast.Call and type(node.word) is ast.Constant else None
        if word not in GEOMETRY:
            continue
        for argument in node.arguments:
            if type(argument) is ast.Constant and type(argument.value) is Keyword:
                name, span = str(argument.value), argument.span
                hint = idle_hint(word, name)
                if hint is not None:
                    near = near_attribute(word, name)
                    fixes = (Fix(f"Change to `:{near}`", (Edit(span, f":{near}"),)),) if near else ()
                    message = f'a "{word}" does not read the attribute `:{name}`'
                    yield word, Diagnostic("idle-attribute", message, span, hint, fixes=fixes)


def near_attribute(word: str, name: str) -> str | None:
    """An attribute that the primitive reads and ``name`` may be a misspelling of."""
    near = get_close_matches(name.lower(), GEOMETRY[word], n=1, cutoff=0.75)
    return near[0] if near else None


def idle_hint(word: str, name: str) -> str | None:
    """A hint for an attribute that a geometric primitive does not read, though another's geometry does, or nearly so;
    None where it is read, or may be the program's own."""
    read = GEOMETRY[word]
    if name in read:
        return None
    near = near_attribute(word, name)
    if near:
        return f"did you mean `:{near}`?"
    return "it reads " + ", ".join(f"`:{n}`" for n in read) if name in _ALL_GEOMETRY else None
