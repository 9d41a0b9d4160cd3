"""Compact language reference for language-model prompts and help texts, generated from the reference's records."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from itertools import chain

from scenelang.backends.pictures.appearance import MATERIALS
from scenelang.grammar.diagnostics import CODES, diagnostic_named, explanation
from scenelang.interpreter.runtime.types import STD
from scenelang.interpreter.scene import primitives
from scenelang.stdlib.reference import TOPICS, ReferenceRecord, lookup, records

# One-line descriptions of primitives and their attributes, for help and completion.

_PHYSICS = {attribute.name: attribute.doc for attribute in primitives.PHYSICS}


def attributes_of(word: str) -> tuple[str, ...]:
    """Return the attributes that the primitive ``word`` reads, those of its geometry first. Other words are semantic
    primitives, which are boxes."""
    own = primitives.attributes_read(word)
    return (*own, *MATERIALS, *_PHYSICS) if "color" in own else own  # materials apply only to visible geometry


def attribute_doc(word: str | None, name: str) -> str | None:
    """Return the meaning, range and default of attribute ``name`` for the primitive ``word``, or for any primitive, in
    one line; None for an unknown attribute."""
    if word is not None and name not in attributes_of(word):
        return None
    if word is None:
        return primitives.docs_of_attributes().get(name) or MATERIALS.get(name) or _PHYSICS.get(name)
    return primitives.attribute_doc(word, name) or MATERIALS.get(name) or _PHYSICS.get(name)


def attribute_names() -> tuple[str, ...]:
    """Return the names of all attributes read by any primitive."""
    return (*primitives.docs_of_attributes(), *MATERIALS, *_PHYSICS)


_TOPICS = ("paper", "forms", "poses", "combinators", "entities", "colors", "random")
_WITH_USAGE = ("solids",)  # topics of names whose parameters no other language has
_LONG_CXR = re.compile("c[ad]{3,4}r")
_SURFACE = ("color", "emission", "opacity", "metallic", "roughness", "ior")


def primer(words: Sequence[str] | None = None, without: Collection[str] = ()) -> str:
    """Return primitives, forms and procedures as Markdown: the primitives ``words`` (None: all), except names in
    ``without``."""
    chosen = tuple(primitives.docs_of_words()) if words is None else words
    return "\n".join([*_primitives(chosen), *_names(without), *_rest(without)])


def _primitives(words: Sequence[str]) -> Iterator[str]:
    yield "## Primitives\n"
    docs = primitives.docs_of_words()
    for word in words:
        yield f"- `{word}`: {docs[word]}"
        own = (name for name in attributes_of(word) if name not in _SURFACE and name not in _PHYSICS)
        yield from (f"  - `:{name}` {attribute_doc(word, name)}" for name in own)
    if not set(words) <= set(primitives.block_words()):
        yield "\nAll visible primitives have the material attributes:\n"
        yield from (f"- `:{name}` {attribute_doc(None, name)}" for name in _SURFACE)


def _of_topic(topic: str, without: Collection[str]) -> list[ReferenceRecord]:
    found = (record for record in records() if record.topic == topic and record.module is None)
    return [record for record in found if record.name not in without]


def _names(without: Collection[str]) -> Iterator[str]:
    for topic in _TOPICS:
        title, intro = TOPICS[topic]
        yield f"\n## {title}\n\n{intro}\n" if intro else f"\n## {title}\n"
        yield from (f"- `{record.signature}`: {_short(record.doc)}" for record in _of_topic(topic, without))


def _short(doc: str) -> str:
    """Return a description without "Return", which every second one starts with, to save tokens."""
    text = doc.removeprefix("Return ")
    return text[0].upper() + text[1:]


def _rest(without: Collection[str]) -> Iterator[str]:
    """Yield the remaining names, which work as in Scheme, Python or NumPy."""
    yield "\n## Other names\n"
    for topic, (title, _) in TOPICS.items():
        found = [record for record in _of_topic(topic, without) if not _LONG_CXR.fullmatch(record.name)]
        names = [_usage(record) if topic in _WITH_USAGE else record.name for record in found]
        if topic not in _TOPICS and names:
            yield f"- {title}: {', '.join(f'`{name}`' for name in names)}"


def _usage(record: ReferenceRecord) -> str:
    """Return a call without types and without the attributes of materials, which all solids have."""
    call = re.sub(r"::[^\s)\]]+", "", record.signature.partition(" -> ")[0])
    return re.sub(rf" \[:(?:{'|'.join((*_SURFACE, 'segments'))})\]", "", call)


# Descriptions of names that a program does not define: library names, primitives, attributes, diagnostics.


def description(name: str) -> list[str]:
    """Return the description of ``name`` as lines: a library name, a primitive (quoted or not), an attribute with its
    colon, or the code or name of a diagnostic; empty if unknown."""
    for lines in (_of_library(name), _of_primitive(name), _of_attribute(name), _of_diagnostic(name)):
        found = list(lines)
        if found:
            return found
    return []


def known_names() -> Iterator[str]:
    """Return all names that have a description, without the codes of diagnostics."""
    attributes = (f":{name}" for name in attribute_names())
    return chain((record.name for record in records()), primitives.words(), attributes, CODES)


def _of_library(name: str) -> Iterator[str]:
    record = lookup(name.removeprefix(STD))
    if record is None:
        return
    yield record.signature
    yield f"  {record.doc}"
    if record.module is not None:
        yield f'  Requires (import "{record.module}").'
    for example in record.examples:
        yield f"  {example.expression} gives {example.value}"


def _of_primitive(name: str) -> Iterator[str]:
    word = name.strip('"')
    docs = primitives.docs_of_words()
    if word not in docs:
        return
    yield f'(call "{word}" {" ".join(f":{attribute}" for attribute in attributes_of(word))})'
    yield f"  {docs[word]}"
    for attribute in attributes_of(word):
        yield f"  :{attribute}  {attribute_doc(word, attribute)}"


def _of_attribute(name: str) -> Iterator[str]:
    attribute = name.removeprefix(":")
    doc = attribute_doc(None, attribute) if name.startswith(":") else None
    if doc is None:
        return
    yield name
    yield f"  {doc}"
    yield f"  read by {', '.join(word for word in primitives.words() if attribute in attributes_of(word))}"


def _of_diagnostic(name: str) -> Iterator[str]:
    """Yield the explanation of a diagnostic, as printed by `scenelang explain`."""
    key = diagnostic_named(name)
    if key is not None:
        yield from explanation(key)


# Task description in the comment at the head of a program.


_TASK = re.compile(r"task\s*:\s*(.+)", re.I)
_SENTENCE = re.compile(r"(?<=[.!?])\s+")


def stated_task(text: str) -> str | None:
    """Return the task of a program: the line `; task: ...` of its leading comment, else the comment's first sentence
    without the full stop; None without a leading comment."""
    lines: list[str] = []
    for line in text.lstrip("\ufeff").splitlines():
        stripped = line.strip()
        if stripped.startswith(";"):
            lines.append(stripped.lstrip(";").strip())
        elif stripped or lines:
            break
    for line in lines:
        task = _TASK.match(line)
        if task is not None:
            return task[1].strip()
    paragraph: list[str] = []
    for line in lines:
        if not line and paragraph:
            break
        paragraph += [line] if line else []
    first = _SENTENCE.split(" ".join(paragraph), maxsplit=1)[0].rstrip(".").strip()
    return first or None
