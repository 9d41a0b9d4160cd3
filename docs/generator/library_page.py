"""The pages of names: one page for each topic of the library, primitives, forms, relations, and the index of all."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import groupby
from typing import Any

import scenelang as sl
from generator.errors import errors_of
from generator.markdown import NOTICE, anchor, block, formatted, heading, identifier, table, valued
from scenelang.grammar.diagnostics import CODES
from scenelang.interpreter.expand.forms import ABSENT, FORM_EXAMPLES, FORMS
from scenelang.interpreter.scene.declarations import RELATIONS, example_of
from scenelang.interpreter.scene.primitives import all_primitives
from scenelang.interpreter.scene.primitives.base import Primitive
from scenelang.reference.primer import attribute_doc, attribute_names
from scenelang.reference.searching import other_words, synonyms_of
from scenelang.stdlib.library import build_library
from scenelang.stdlib.reference import TOPICS, RecordKind, ReferenceRecord, records

_TABLES = ("constants", "types")
_OWN_PAGES = ("forms", "parts")
PICTURES = "pictures"  # the folder beside the page
_MAX_RELATED = 6  # names after "See also"
_QUOTED = re.compile(r"`\(?([^\s`()\"]+)")
_PARAMETER = re.compile(r"[\s\[(:]([^\s\[\]():]+)")
_PRIMITIVES = (
    "Words that no `bind` binds. Any other unbound word is a labeled box of its `:scale`. Whatever has a `:color` "
    "reads the attributes of the material too. An attribute with an invalid value is "
    "[E603](diagnostics.md#e603-attribute), one with an improbable value "
    "[W402](diagnostics.md#w402-out-of-range), one that a primitive does not read "
    "[W608](diagnostics.md#w608-idle-attribute)."
)
_EVERY_CALL = (
    "A signature shows required parameters, `[optional]` ones, `[:keyword]` ones and, before `...`, the rest; the type "
    "of the value is after `->`. An argument of another type is [E401](diagnostics.md#e401-type), a wrong number of "
    "arguments [E402](diagnostics.md#e402-arity), an unknown keyword [E404](diagnostics.md#e404-keyword). For "
    "functions without keywords a keyword is an argument like any other: one too many (E402), of another type (E401), "
    "or a value that they accept."
)
_EVERY_RELATION = (
    "A relation that does not hold is [E612](diagnostics.md#e612-declaration), a word that does not occur "
    "[E613](diagnostics.md#e613-declaration-subject). An operand of another kind is "
    "[E401](diagnostics.md#e401-type), a wrong number of operands and an unknown option "
    "[E201](diagnostics.md#e201-syntax). The default of `:within` is 1 % of the stated length or ratio; for "
    "`tilt` and `turns` 1 % and at least one degree, for `angle` one degree."
)
# Values of the attributes that have no default, in examples of primitives.
_SHOWN = {"file": '"examples/meshes/hook.stl"', "block-type": '"oak_planks"'}


def library_pages() -> Mapping[str, Callable[[], str]]:
    """Return the functions that write the topic pages as Markdown, by file name."""
    pages = {f"{topic}.md": partial(_topic_page, topic) for topic in TOPICS if topic not in _OWN_PAGES}
    return {**pages, "primitives.md": _primitives_page, "index.md": _index_page}


def _topic_page(topic: str) -> str:
    """Return the page of a topic: every name with its own section."""
    title, introduction = TOPICS[topic]
    mine = [record for record in records() if record.topic == topic]
    lines = [f"# {title}", "", NOTICE, ""]
    if introduction:
        lines += [introduction, ""]
    if topic in _TABLES:
        lines += ["The [reference](index.md) lists all names.", ""]
        for record in mine:
            lines += [heading(3, record.name), ""]
            if record.name in build_library().constants:
                lines += [f"`{record.name} = {build_library().constants[record.name]}`", ""]
            lines += [record.doc, ""]
        return _page(lines)
    lines += [_EVERY_CALL, "", " · ".join(f"[`{r.name}`](#{identifier(r.name)})" for r in mine), ""]
    for record in mine:
        lines += _section(record)
    return _page(lines)


def _section(record: ReferenceRecord) -> Iterator[str]:
    """Yield the section of a name: signature, meaning, examples, picture, errors, other words and related names."""
    yield from (heading(3, record.name), "", f"`{record.signature}`", "", record.doc, "")
    yield from _examples(record)
    if record.picture is not None:
        yield from (f"![{record.name}]({PICTURES}/{record.name}.png)", "")
        yield from block("scene", picture_program(record))
    yield from _notes(record.name, errors_of(record))


def _examples(record: ReferenceRecord) -> Iterator[str]:
    """Yield the examples as a program, or as a sentence where the program would be warned about."""
    if not record.examples:
        return
    head = f'(import "{record.module}")\n' if record.module is not None else ""
    program = head + "\n".join(f"{e.expression}  ; => {e.value}" for e in record.examples)
    if sl.check(program).diagnostics:
        yield from (*(f"`{e.expression}` gives `{e.value}`." for e in record.examples), "")
    else:
        yield from block("scene", program)


def _notes(name: str, errors: Sequence[str] = ()) -> Iterator[str]:
    """Yield what stands below a name: its errors, words of other tools that mean it, and related names."""
    others, related = synonyms_of([name.removeprefix(":")]), _related(name)
    notes = []
    if errors:
        notes.append("Errors: " + ", ".join(_code(error) for error in errors))
    if others:
        notes.append("In other words: " + ", ".join(others))
    if related:
        notes.append("See also: " + ", ".join(f"[`{other}`]({place_of(other)})" for other in related))
    yield from (". ".join([*notes, ""]).rstrip(), "") if notes else ()


def _code(name: str) -> str:
    """Return a diagnostic as a link with its meaning."""
    code, why = CODES[name]
    return f"[{code}](diagnostics.md#{code.lower()}-{name}) ({why[:1].lower()}{why[1:].rstrip('.')})"


@cache
def _places() -> Mapping[str, str]:
    """Return where each name has its section, relative to the folder of the reference."""
    places = {f":{name}": f"primitives.md#{identifier(':' + name)}" for name in attribute_names()}
    places |= {word: f"primitives.md#{identifier(word)}" for cls in all_primitives() for word in (cls.word,)}
    places |= {name: f"relations.md#{identifier(name)}" for name in RELATIONS}
    for record in reversed(records()):
        if record.topic == "parts":
            places[record.name] = f"../parts.md#{identifier(record.name)}"
        else:
            places[record.name] = f"{record.topic}.md#{identifier(record.name)}"
    return places


def place_of(name: str) -> str:
    """Return where a name has its section, relative to the folder of the reference."""
    return _places()[name]


@cache
def _mentions() -> Mapping[str, Collection[str]]:
    """Return for each name those that its documentation quotes."""
    documented = [record for record in records() if record.kind is not RecordKind.TYPE and record.topic != "parts"]
    known = {record.name for record in documented}
    return {
        record.name: known.intersection(_QUOTED.findall(record.doc))
        - {record.name, *_PARAMETER.findall(record.signature)}
        for record in documented
    }


def _related(name: str) -> list[str]:
    """Return the names that the documentation of a name quotes, then those that quote it."""
    quoted = sorted(_mentions().get(name, ()))
    quoting = sorted(other for other, mentioned in _mentions().items() if name in mentioned and other not in quoted)
    return [*quoted, *quoting][:_MAX_RELATED]


def _primitives_page() -> str:
    """Return the page of primitives and their attributes."""
    lines = ["# Primitives and their attributes", "", NOTICE, ""]
    lines += [_PRIMITIVES, ""]
    words = [cls.word for cls in all_primitives()]
    lines += [" · ".join(f"[`{word}`](#{identifier(word)})" for word in words), "", "## Primitives", ""]
    for cls in all_primitives():
        linked = " ".join(f"[`:{name}`](#{identifier(':' + name)})" for name in cls.attribute_names())
        signature = " ".join(_typed(cls, name) for name in cls.attribute_names())
        lines += [heading(3, cls.word), "", f'`(call "{cls.word}" {signature})`', ""]
        lines += [f"{cls.doc[:1].upper()}{cls.doc[1:].rstrip('.')}.", "", f"Attributes: {linked}", ""]
        lines += [*block("scene", _example_of(cls)), *_notes(cls.word)]
    lines += ["## Attributes", ""]
    for name in attribute_names():
        doc = (attribute_doc(None, name) or "").rstrip(".")
        lines += [heading(3, f":{name}"), "", f"{doc[:1].upper()}{doc[1:]}.", ""]
        having = [cls.word for cls in all_primitives() if name in cls.attribute_names()]
        if having:
            lines += ["Read by " + ", ".join(f"[`{word}`](#{identifier(word)})" for word in having) + ".", ""]
        lines += _notes(f":{name}")
    return _page(lines)


def _typed(cls: type[Primitive], name: str) -> str:
    """Return an attribute of a primitive with its types and its default, in brackets if it is optional."""
    attribute = next((each for each in cls.attributes if each.name == name), None)
    if attribute is None:
        return f"[:{name}]"
    kinds = f"::{'|'.join(attribute.accepts)}" if attribute.accepts else ""
    typed = f":{name}{kinds}{'' if attribute.default is None else f' {_written(attribute.default)}'}"
    return typed if attribute.needed else f"[{typed}]"


def _example_of(cls: type[Primitive]) -> str:
    """Return a program with a primitive, whose attributes have their defaults."""
    values = {each.name: _SHOWN.get(each.name) or _written(each.default) for each in cls.attributes}
    given = " ".join(f":{name} {value}" for name, value in values.items() if value != "none")
    return formatted(f'(bind "example" (lambda () (call "{cls.word}" {given})))')


def _written(value: Any) -> str:
    """Return a value as it is written in a program."""
    if value is None or isinstance(value, bool):
        return {None: "none", True: "#t", False: "#f"}[value]
    if isinstance(value, Sequence):
        return f"[{' '.join(_written(each) for each in value)}]"
    return f"{value:g}"


def _index_page() -> str:
    """Return the index: topics, words of other tools, and all names from A to Z."""
    lines = [
        "# Reference", "", NOTICE, "",
        "Every name of the language has a section: a function with its signature, an example and the errors that its "
        "calls raise besides those of wrong arguments (E401, E402, E404) and of limits, a primitive with its "
        "attributes and their defaults, a constant with its value.", "",
    ]  # fmt: skip
    topics = [topic for topic in TOPICS if topic not in ("parts",)]
    rows = [(f"[{TOPICS[topic][0]}]({topic}.md)", _names_of(topic)) for topic in topics]
    rows.append(("[Primitives and their attributes](primitives.md)", _linked([c.word for c in all_primitives()])))
    rows.append(("[Relations](relations.md)", _linked(list(RELATIONS))))
    rows.append(("[Parts](../parts.md)", "everyday objects in metres"))
    rows.append(("[Errors and warnings](diagnostics.md), [command line](cli.md), [tolerances](tolerances.md)", ""))
    lines += [*table(("topic", "names"), rows), "## Words of other tools", ""]
    lines += ["What is called otherwise elsewhere, or is a word of a task, and the names for it here.", ""]
    known = [(word, [name for name in names if name in _places()]) for word, names in other_words().items()]
    lines += table(("word", "here"), [(word, _linked(names)) for word, names in sorted(known) if names])
    lines += ["## All names", ""]
    names = sorted({record.name for record in records() if record.topic != "parts"}, key=lambda name: _letter(name))
    for letter, group in groupby(names, key=lambda name: _letter(name)[0]):
        lines += [f"**{letter}**: {_linked(list(group))}", ""]
    return _page(lines)


def _letter(name: str) -> tuple[str, str, str]:
    """Return the key of a name in the index: its first letter, signs before all letters."""
    first = name[0].upper()
    return (first if first.isalpha() else "Signs"), name.lower(), name


def _names_of(topic: str) -> str:
    return _linked([record.name for record in records() if record.topic == topic])


def _linked(names: Sequence[str]) -> str:
    return ", ".join(f"[`{name}`]({place_of(name)})" for name in names)


def picture_program(record: ReferenceRecord) -> str:
    """Return the whole program whose picture shows what a name does."""
    head = f'(import "{record.module}")\n\n' if record.module is not None else ""
    word = "picture" if record.kind is RecordKind.PART else record.name  # a part's own word is bound by its module
    return formatted(f'{head}(bind "{word}" (lambda () {record.picture}))')


def relations_page() -> str:
    """Return every relation that `assert-that` states, Markdown."""
    lines = [
        "# Relations",
        "",
        NOTICE,
        "",
        "What [`assert-that`](forms.md#assert-that) and `check --that` can state ([declarations](../relations.md)).",
        "Every example holds in the image above it.",
        "",
        _EVERY_RELATION,
        "",
        " · ".join(f"[{name}](#{anchor(name)})" for name in RELATIONS),
        "",
    ]
    for relation in RELATIONS.values():
        lines += [f"## {relation.name}", "", f"`{relation.usage}`", "", relation.doc, ""]
        lines += [f"![{relation.name}]({PICTURES}/relation-{relation.name}.png)", ""]
        lines += block("scene", formatted(example_of(relation)))
        lines += _notes(relation.name)
    return _page(lines)


def forms_page() -> str:
    """Return every special form, Markdown."""
    lines = [
        "# The special forms",
        "",
        NOTICE,
        "",
        f"{TOPICS['forms'][1]} Their names are reserved. A comment `; =>` gives the value of the last expression.",
        "",
        " · ".join(f"[{name}](#{identifier(name)})" for name in FORMS),
        "",
    ]
    for form in FORMS.values():
        lines += [heading(2, form.name), "", f"`{form.usage}`", "", form.doc, ""]
        lines += block("scene", valued(*FORM_EXAMPLES[form.name]))
        lines += _notes(form.name)
    lines += [
        "## Scheme features that do not exist here",
        "",
        "Using one of these names is an error that says so.",
        "",
    ]
    absent = groupby(ABSENT.items(), key=lambda item: item[1])
    rows = [(" ".join(f"`{name}`" for name, _ in names), instead) for instead, names in absent]
    lines += table(("name", "instead"), rows)
    return _page(lines)


def _page(lines: Sequence[str]) -> str:
    return "\n".join(lines).rstrip("\n") + "\n"
