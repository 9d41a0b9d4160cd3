"""What is to be said of a name: a definition of the session, the library's, a primitive, an attribute, a diagnostic."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from scenelang.attributes import attribute_doc, attribute_names, attributes_of
from scenelang.grammar.codes import CODES
from scenelang.interpreter.interactive import TopLevel
from scenelang.interpreter.library import STD
from scenelang.interpreter.scope import Macro
from scenelang.interpreter.shapes import PRIMITIVES, READ
from scenelang.repl.display import displayed, signature_of
from scenelang.repl.saving import comment_of
from scenelang.repl.tracing import function_of


def description(top: TopLevel, name: str) -> list[str]:
    """The lines that describe ``name``, which may be a name, a word (in quotes or not), a primitive, an attribute with
    its colon, or a diagnostic's code or name; empty where nothing is known of it."""
    for lines in (_own(top, name), _of_library(name), _of_primitive(name), _of_attribute(name), _of_diagnostic(name)):
        found = list(lines)
        if found:
            return found
    return []


def known_names(top: TopLevel) -> Iterator[str]:
    """Everything that has a description."""
    from scenelang.stdlib.reference import records

    own = (name for name, _ in top.names())
    attributes = (f":{name}" for name in attribute_names())
    return chain(own, (record.name for record in records()), PRIMITIVES, attributes, CODES)


def _own(top: TopLevel, name: str) -> Iterator[str]:
    """Signature and comment of a definition of the session."""
    for key in (name, f'"{_bare(name)}"'):
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


def _of_library(name: str) -> Iterator[str]:
    from scenelang.stdlib.reference import lookup

    record = lookup(name.removeprefix(STD))
    if record is None:
        return
    yield record.signature
    yield f"  {record.doc}"
    if record.module is not None:
        yield f'  It comes with (import "{record.module}").'
    for example in record.examples:
        yield f"  {example.expression} gives {example.value}"


def _of_primitive(name: str) -> Iterator[str]:
    word = _bare(name)
    if word not in PRIMITIVES:
        return
    yield f'(call "{word}" {" ".join(f":{attribute}" for attribute in attributes_of(word))})'
    yield f"  {PRIMITIVES[word]}"
    for attribute in attributes_of(word):
        yield f"  :{attribute}  {attribute_doc(word, attribute)}"


def _of_attribute(name: str) -> Iterator[str]:
    attribute = name.removeprefix(":")
    doc = attribute_doc(None, attribute) if name.startswith(":") else None
    if doc is None:
        return
    yield name
    yield f"  {doc}"
    yield f"  read by {', '.join(word for word in READ if attribute in attributes_of(word))}"


def _of_diagnostic(name: str) -> Iterator[str]:
    """What `scenelang explain` says of a code or of a diagnostic's name."""
    from scenelang.grammar.mends import diagnostic_named, explanation

    key = diagnostic_named(name)
    if key is not None:
        yield from explanation(key)


def _bare(name: str) -> str:
    return name.strip('"')
