"""The language in a few pages, for a language model that is to write it: from the same records as the reference."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scenelang.interpreter.shapes import ATTRIBUTES, PRIMITIVES, READ
from scenelang.stdlib.reference import Record, records

# What is told in full: whole topics, and single names of others.
_TOPICS = ("paper", "poses", "combinators", "colors")
_FORMS = (
    "bind", "scene", "param", "define", "lambda", "let", "let*", "if", "cond", "case", "when", "unless", "and", "or",
    "begin", "for/list", "for/union", "for*/union", "for/append", "for/sum", "for/fold",
)  # fmt: skip
_ENTITIES = (
    "frames", "primitive", "primitives", "embedding", "compute-shape-min", "compute-shape-max",
    "compute-shape-center", "compute-shape-sizes",
)  # fmt: skip
# What is told by name only.
_NAMED = ("numbers", "tests", "lists", "sequences", "arrays", "strings", "tables", "random")


def primer(words: Sequence[str], without: Sequence[str] = ()) -> str:
    """The forms, procedures and the primitives ``words``; names in ``without`` are left out."""
    by_name = {record.name: record for record in records() if record.module is None}
    told = [by_name[name] for name in (*_FORMS, *_ENTITIES)]
    told += [record for record in by_name.values() if record.topic in _TOPICS]
    shown = [record for record in told if record.name not in without]
    pieces = ["Forms and procedures:", "", *map(_line, shown), "", "Primitives, words that nobody binds:", ""]
    pieces += [*_primitives(words), "", "Further procedures, as in Scheme or numpy:", ""]
    pieces += _names(without)
    return "\n".join(pieces)


def _line(record: Record) -> str:
    return f"- `{record.signature}`: {record.doc}"


def _primitives(words: Sequence[str]) -> Iterator[str]:
    for word in words:
        taken = ", ".join(f":{name}" for name in READ[word])
        yield f'- "{word}": {PRIMITIVES[word]}; takes {taken}'
    yield ""
    for name in dict.fromkeys(name for word in words for name in READ[word]):
        yield f"- :{name}: {ATTRIBUTES[name]}"


def _names(without: Sequence[str]) -> Iterator[str]:
    for topic in _NAMED:
        found = [r.name for r in records() if r.topic == topic and r.module is None and r.name not in without]
        if found:
            yield f"- {topic}: {' '.join(found)}"
