"""The pages of names: ``stdlib.md`` and ``forms.md``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from generator.markdown import NOTICE, anchor, block, formatted, table, valued
from scenelang.interpreter.expand.forms import ABSENT, FORM_EXAMPLES, FORMS
from scenelang.interpreter.scene.declarations import RELATIONS, example_of
from scenelang.interpreter.scene.primitives import all_primitives
from scenelang.reference.primer import attribute_doc, attribute_names
from scenelang.stdlib.reference import TOPICS, RecordKind, ReferenceRecord, records

_TABLES = ("constants", "types")
_OWN_PAGES = ("forms", "parts")
_PRIMITIVES = "Primitives and their attributes"
PICTURES = "pictures"  # the folder beside the page


def stdlib_page() -> str:
    """Every name of the standard library by topic, Markdown."""
    topics = [topic for topic in TOPICS if topic not in _OWN_PAGES]
    titles = [*(TOPICS[topic][0] for topic in topics), _PRIMITIVES]
    links = " · ".join(f"[{title}](#{anchor(title)})" for title in titles)
    lines = [
        "# The standard library",
        "",
        NOTICE,
        "",
        "Every name that programs can use. A signature shows required parameters, `[optional]` ones, `[:keyword]` ones",
        "and, before `...`, the rest; behind `->` stands the type of the value. The special forms have a page of their",
        "own, [forms](forms.md), and so have the [parts](../parts.md).",
        "",
        links,
        "",
    ]
    for topic in topics:
        lines += _topic(topic, [record for record in records() if record.topic == topic])
    return _page([*lines, *_attributes()])


def _attributes() -> Iterator[str]:
    """The primitives and the attributes that they read."""
    yield from (f"## {_PRIMITIVES}", "", "Words that no `bind` binds. Any other word is a box of its `:scale`.", "")
    rows = [
        (f'`"{cls.word}"`', cls.doc, " ".join(f"`:{name}`" for name in cls.attribute_names()))
        for cls in all_primitives()
    ]
    yield from table(("word", "what it is", "attributes"), rows)
    yield from ("All that has a `:color` reads the attributes of the material too.", "")
    meanings = [(f"`:{name}`", attribute_doc(None, name) or "") for name in attribute_names()]
    yield from table(("attribute", "meaning"), meanings)


def _topic(topic: str, mine: Sequence[ReferenceRecord]) -> Iterator[str]:
    title, introduction = TOPICS[topic]
    yield from (f"## {title}", "")
    if introduction:
        yield from (introduction, "")
    if topic in _TABLES:
        yield from table(("name", "meaning"), [(f"`{record.name}`", record.doc) for record in mine])
        return
    for record in mine:
        yield from _drawn(record) if record.picture is not None else _item(record)
    yield ""


def _item(record: ReferenceRecord) -> Iterator[str]:
    yield f"- `{record.signature}`:"
    yield f"  {record.doc}"
    for example in record.examples:
        yield f"  `{example.expression}` gives `{example.value}`."


def _drawn(record: ReferenceRecord) -> Iterator[str]:
    """A name with a section, a picture and the program that is drawn in it."""
    yield from (f"### {record.name}", "", f"`{record.signature}`", "", record.doc, "")
    yield from (f"`{example.expression}` gives `{example.value}`." for example in record.examples)
    yield from ("", f"![{record.name}]({PICTURES}/{record.name}.png)", "")
    yield from block("scene", picture_program(record))


def picture_program(record: ReferenceRecord) -> str:
    """The whole program whose picture shows what a name does."""
    head = f'(import "{record.module}")\n\n' if record.module is not None else ""
    word = "picture" if record.kind is RecordKind.PART else record.name  # a part's own word is bound by its module
    return formatted(f'{head}(bind "{word}" (lambda () {record.picture}))')


def relations_page() -> str:
    """Every relation that `assert-that` states, Markdown."""
    lines = [
        "# Relations",
        "",
        NOTICE,
        "",
        "What [`assert-that`](forms.md#assert-that) and `check --that` can state ([declarations](../relations.md)).",
        "Every example holds in the picture above it.",
        "",
        " · ".join(f"[{name}](#{anchor(name)})" for name in RELATIONS),
        "",
    ]
    for relation in RELATIONS.values():
        lines += [f"## {relation.name}", "", f"`{relation.usage}`", "", relation.doc, ""]
        lines += [f"![{relation.name}]({PICTURES}/relation-{relation.name}.png)", ""]
        lines += block("scene", formatted(example_of(relation)))
    return _page(lines)


def forms_page() -> str:
    """Every special form, Markdown."""
    lines = [
        "# The special forms",
        "",
        NOTICE,
        "",
        f"{TOPICS['forms'][1]} Their names are reserved. Behind `; =>` stands the value of the last expression.",
        "",
        " · ".join(f"[{name}](#{anchor(name)})" for name in FORMS),
        "",
    ]
    for form in FORMS.values():
        lines += [f"## {form.name}", "", f"`{form.usage}`", "", form.doc, ""]
        lines += block("scene", valued(*FORM_EXAMPLES[form.name]))
    lines += [
        "## What Scheme has and this language has not",
        "",
        "Using one of these names is an error that says so.",
        "",
    ]
    lines += table(("name", "instead"), [(f"`{name}`", instead) for name, instead in ABSENT.items()])
    return _page(lines)


def _page(lines: Sequence[str]) -> str:
    return "\n".join(lines).rstrip("\n") + "\n"
