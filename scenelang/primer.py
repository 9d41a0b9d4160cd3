"""The language on a few pages, for a model that is to write it: made of the records that the reference is made of."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from scenelang.attributes import attribute_doc, attributes_of
from scenelang.interpreter.shapes import BLOCK_WORDS, PRIMITIVES
from scenelang.stdlib.reference import TOPICS, Record, records

_TOPICS = ("paper", "forms", "poses", "combinators", "entities", "colors", "random")
_SURFACE = ("color", "emission", "opacity", "metallic", "roughness", "ior")


def primer(words: Sequence[str] = tuple(PRIMITIVES), without: Collection[str] = ()) -> str:
    """Primitives, forms and procedures as Markdown: the primitives ``words``, no name that is in ``without``."""
    return "\n".join([*_primitives(words), *_names(without), *_rest(without)])


def _primitives(words: Sequence[str]) -> Iterator[str]:
    yield "## Primitives\n"
    for word in words:
        yield f"- `{word}`: {PRIMITIVES[word]}"
        own = (name for name in attributes_of(word) if name not in _SURFACE)
        yield from (f"  - `:{name}` {attribute_doc(word, name)}" for name in own)
    if not set(words) <= set(BLOCK_WORDS):
        yield "\nAll that can be seen has the attributes of surfaces:\n"
        yield from (f"- `:{name}` {attribute_doc(None, name)}" for name in _SURFACE)


def _of_topic(topic: str, without: Collection[str]) -> list[Record]:
    found = (record for record in records() if record.topic == topic and record.module is None)
    return [record for record in found if record.name not in without]


def _names(without: Collection[str]) -> Iterator[str]:
    for topic in _TOPICS:
        title, intro = TOPICS[topic]
        yield f"\n## {title}\n\n{intro}\n" if intro else f"\n## {title}\n"
        yield from (f"- `{record.signature}`: {record.doc}" for record in _of_topic(topic, without))


def _rest(without: Collection[str]) -> Iterator[str]:
    """The other names, which are as in Scheme, Python or numpy."""
    yield "\n## Other names\n"
    for topic, (title, _) in TOPICS.items():
        names = [record.name for record in _of_topic(topic, without)]
        if topic not in _TOPICS and names:
            yield f"- {title}: {', '.join(f'`{name}`' for name in names)}"
