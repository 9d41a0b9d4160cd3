"""What is to be said of a name in a session: of its own definitions, and of what every program knows."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from scenelang import descriptions
from scenelang.interpreter.interactive import TopLevel
from scenelang.interpreter.scope import Macro
from scenelang.repl.display import displayed, signature_of
from scenelang.repl.saving import comment_of
from scenelang.repl.tracing import function_of


def description(top: TopLevel, name: str) -> list[str]:
    """The lines that describe ``name``, which may be a name or a word (in quotes or not) of the session, or whatever
    ``scenelang.descriptions`` knows; empty where nothing is known of it."""
    return list(_own(top, name)) or descriptions.description(name)


def known_names(top: TopLevel) -> Iterator[str]:
    """Everything that has a description."""
    return chain((name for name, _ in top.names()), descriptions.known_names())


def _own(top: TopLevel, name: str) -> Iterator[str]:
    """Signature and comment of a definition of the session."""
    for key in (name, f'"{name.strip(chr(34))}"'):
        form = top.definition_of(key)
        if form is None:
            continue
        function = function_of(top, key)
        yield _signature(top, key) if function is None else signature_of(function)
        for line in comment_of(form):
            yield f"  {line.lstrip('; ').rstrip()}"
        yield f"  defined in {form.datums[0].span.source.name}"
        return


def _signature(top: TopLevel, key: str) -> str:
    binding = dict(top.names()).get(key)
    if isinstance(binding, Macro):
        return f"macro {binding.usage or key}"
    try:
        value = top.value_of(key)
    except KeyError:
        return key
    return f"{key} = {displayed(value, 60).splitlines()[0] if value is not None else 'none'}"
