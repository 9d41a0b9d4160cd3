"""What is to be said of a name that no program defines: of the library, a primitive, an attribute, a diagnostic."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from scenelang.attributes import attribute_doc, attribute_names, attributes_of
from scenelang.grammar.codes import CODES
from scenelang.interpreter.library import STD
from scenelang.interpreter.shapes import PRIMITIVES, READ


def description(name: str) -> list[str]:
    """The lines that describe ``name``, which may be a name of the library, a primitive (in quotes or not), an
    attribute with its colon, or a diagnostic's code or name; empty where nothing is known of it."""
    for lines in (_of_library(name), _of_primitive(name), _of_attribute(name), _of_diagnostic(name)):
        found = list(lines)
        if found:
            return found
    return []


def known_names() -> Iterator[str]:
    """Everything that has a description; of diagnostics only the names."""
    from scenelang.stdlib.reference import records

    attributes = (f":{name}" for name in attribute_names())
    return chain((record.name for record in records()), PRIMITIVES, attributes, CODES)


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
    word = name.strip('"')
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
