"""Everything that programs can use, as plain records from its one place of definition, and the generated part of
``docs/language.md``.

Builtins come from the registry, special forms from ``interpreter.forms``, constants from ``stdlib.constants``, the
combinators from the comments of ``combinators.scene``, diagnostics from ``grammar.codes``, limits from
``interpreter.limits``. ``python -m scenelang.stdlib.reference docs/language.md`` rewrites what stands between the two
markers of that file.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, fields
from enum import Enum
from functools import cache
from pathlib import Path

from scenelang.grammar.codes import CODES
from scenelang.grammar.printer import print_datum
from scenelang.grammar.reader import read
from scenelang.grammar.source import Source
from scenelang.interpreter.forms import FORMS
from scenelang.interpreter.library import Builtin
from scenelang.interpreter.limits import Limits
from scenelang.interpreter.types import BASE_TYPES
from scenelang.stdlib.constants import CONSTANTS
from scenelang.stdlib.library import build_library

BEGIN = "<!-- generated: python -m scenelang.stdlib.reference docs/language.md -->"
END = "<!-- end of the generated part -->"
COMBINATORS = "combinators.scene"


class Kind(Enum):
    FORM = "form"
    FUNCTION = "function"
    CONSTANT = "constant"
    TYPE = "type"


@dataclass(frozen=True, slots=True)
class Example:
    """An expression and the value that it prints."""

    expression: str
    value: str


@dataclass(frozen=True, slots=True)
class Record:
    """One name. ``signature`` is how it is used, as help and diagnostics show it; ``topic`` groups the reference."""

    name: str
    kind: Kind
    signature: str
    doc: str
    examples: tuple[Example, ...]
    topic: str


# The topics in the order of the reference: title and what a reader should know first.
TOPICS: dict[str, tuple[str, str]] = {
    "forms": ("Special forms", "Forms are no functions: they decide themselves what is evaluated."),
    "paper": (
        "The paper's macros",
        "The four names that the paper defines in the language. Here they are procedures, so they may be passed on.",
    ),
    "entities": ("Entities and embeddings", ""),
    "poses": ("Poses", "Lengths are the scene's units, angles are radians."),
    "combinators": (
        "Combinators",
        "A *thing* is an entity, a pair (entity . matrix) or parts, as `union` makes them; where copies are made it "
        "may also be a function of the copy's index. Every combinator gives parts, which go into a `union`. Boxes are the "
        "exact bounding boxes of `compute-shape-min` and its kin.",
    ),
    "colors": ("Colours", ""),
    "numbers": ("Numbers", "Arithmetic works on numbers and, element by element, on arrays."),
    "tests": ("Tests of type and equality", ""),
    "lists": ("Lists and pairs", ""),
    "sequences": (
        "Sequences",
        "A sequence is a list, a mutable list, an array, a string, a set or the keys of a table.",
    ),
    "changes": (
        "Changes",
        "These change mutable lists, mutable arrays, tables and sets. Lists, arrays and strings never change.",
    ),
    "tables": ("Tables and sets", ""),
    "strings": ("Strings", ""),
    "arrays": ("Arrays", "Vectors and matrices are arrays; `[1 2 3]` writes one."),
    "random": (
        "Random numbers",
        "Names without prefix draw from the stream of numpy's `RandomState`, those with `py-` from the stream of "
        "Python's `random`. `:stream` takes another stream.",
    ),
    "control": ("Control and errors", ""),
    "constants": ("Constants", ""),
    "types": ("Types", "The names that annotate a parameter, `name::Type`."),
}

_PAPER: tuple[tuple[str, str, Example | None], ...] = (
    (
        "(call word::Word embeddings ... :attribute value ...) -> Entity",
        "The entity of a word: applies the function bound to it, or makes a primitive when none is. Attributes join "
        "the first embedding. The same word with equal embeddings is evaluated once and shared.",
        Example('(entity-word (call "tree" "an old oak"))', '"tree"'),
    ),
    (
        "(union members ...) -> Parts",
        "One list of parts from entities, pairs (entity . matrix) and lists of these to any depth.",
        Example('(length (union (call "cube") (list (call "cone") (call "sphere"))))', "3"),
    ),
    (
        "(union-loop count::Integer function::Function) -> Parts",
        "Unites what the function makes of 0, 1, ... `count` - 1.",
        Example('(length (union-loop 8 (lambda (i) (call "cube"))))', "8"),
    ),
    (
        "(transform part matrix::Matrix) -> Pair",
        "An entity under a pose: the pair (entity . matrix). Pairs and parts are moved further, which gives a pair or "
        "parts.",
        Example('(compute-shape-max (transform (call "cube") (translate [1 2 3])))', "[1.5 2.5 3.5]"),
    ),
)

_TYPES: dict[str, str] = {
    "Any": "Anything.",
    "Word": "A string that names a class of entities.",
    "String": "Text.",
    "Embedding": "An embedding; a handle or a string where one is wanted is one too.",
    "Matrix": "A pose: a finite 4x4 matrix whose last row is 0 0 0 1; nested lists and arrays of that shape serve.",
    "Vector": "A one-dimensional array of numbers; a list of numbers serves.",
    "Point": "A vector of three numbers.",
    "Array": "An array of numbers of any number of dimensions.",
    "Entity": "An entity.",
    "Parts": "An entity, a pair (entity . matrix), or a list of these.",
    "Integer": "A whole number; a Float that is whole becomes one.",
    "Float": "A number.",
    "Number": "A number.",
    "Boolean": "`#t` or `#f`.",
    "Function": "A procedure, builtin or written.",
    "List": "A list or mutable list; `List[Type]` says what its items are.",
    "Tuple": "`Tuple[Type, ...]`: a list with one item of each type, or a pair of two.",
    "Sequence": "A list, mutable list, array, string, table (its keys) or set.",
    "Symbol": "A symbol, as `'name`.",
    "Keyword": "A keyword, as `:name`.",
    "Pair": "A pair or a list that is not empty.",
    "MutableList": "A mutable list.",
    "MutableArray": "A mutable array.",
    "Table": "A table.",
    "Set": "A set.",
    "Stream": "A random stream of one's own.",
    "Record": "A record; the name of a record type stands for its own records.",
}

_LIMITS: dict[str, str] = {
    "steps": "steps of evaluation",
    "depth": "nested calls",
    "entities": "distinct entities",
    "primitives": "primitives when a scene is expanded",
    "size": "items of a list, characters of a string, digits of an integer",
    "memory": "bytes of memory",
    "seconds": "seconds of wall time",
    "log": "characters that `print` may write",
}


# --- records -------------------------------------------------------------------------------------------------------


@cache
def records() -> tuple[Record, ...]:
    """Every name of the language, by topic in the order of ``TOPICS``."""
    found = [*_forms(), *_paper(), *_builtins(), *combinators(), *_constants(), *_types()]
    order = {topic: position for position, topic in enumerate(TOPICS)}
    return tuple(sorted(found, key=lambda record: order[record.topic]))


def lookup(name: str) -> Record | None:
    """What is known of ``name``; a function before a type of the same name."""
    return next((record for record in records() if record.name == name), None)


def _forms() -> Iterator[Record]:
    for form in FORMS.values():
        yield Record(form.name, Kind.FORM, form.usage, form.doc, (), "forms")


def _paper() -> Iterator[Record]:
    for signature, doc, example in _PAPER:
        name = signature[1:].split(" ", 1)[0]
        yield Record(name, Kind.FUNCTION, signature, doc, (example,) if example else (), "paper")


def _builtins() -> Iterator[Record]:
    hidden = {record.name for record in combinators()}
    for name, entry in build_library().builtins.items():
        if name not in hidden:
            yield _builtin(name, entry)


def _builtin(name: str, entry: Builtin) -> Record:
    examples = (Example(*entry.example),) if entry.example else ()
    return Record(name, Kind.FUNCTION, entry.usage, entry.doc, examples, entry.topic)


def _constants() -> Iterator[Record]:
    for name, (_, doc) in CONSTANTS.items():
        yield Record(name, Kind.CONSTANT, name, doc, (), "constants")


def _types() -> Iterator[Record]:
    for name, doc in _TYPES.items():
        if name in BASE_TYPES or name == "Tuple":
            yield Record(name, Kind.TYPE, name, doc, (), "types")


@cache
def combinators() -> tuple[Record, ...]:
    """The documented definitions of ``combinators.scene``.

    A definition is documented by the lines ``;;;`` directly above it: text, then ``;;; Example: expression => value``
    once or more.
    """
    text = build_library().modules[COMBINATORS]
    source = Source(COMBINATORS, text)
    found = []
    for datum in read(source).forms:
        comment = _comment_above(text, datum.span.start)
        if not comment:
            continue
        head = datum.items[1]  # type: ignore[union-attr]
        doc = " ".join(line for line in comment if not line.startswith("Example:"))
        examples = [line.removeprefix("Example:").rpartition(" => ") for line in comment if line.startswith("Example:")]
        signature = f"{print_datum(head)} -> Parts"
        name = str(head.items[0].value)
        shown = tuple(Example(expression.strip(), value.strip()) for expression, _, value in examples)
        found.append(Record(name, Kind.FUNCTION, signature, doc, shown, "combinators"))
    return tuple(found)


def _comment_above(text: str, start: int) -> list[str]:
    """The lines ``;;; ...`` that end directly before offset ``start``, without their semicolons."""
    lines = text[:start].splitlines()
    comment: list[str] = []
    while lines and lines[-1].startswith(";;; "):
        comment.insert(0, lines.pop()[4:].strip())
    return comment


# --- docs/language.md ----------------------------------------------------------------------------------------------


def render() -> str:
    """The generated part of the language reference, Markdown."""
    return "\n".join([*_render_records(), *_render_limits(), *_render_codes()])


def _render_records() -> Iterator[str]:
    everything = records()
    for topic, (title, introduction) in TOPICS.items():
        yield from (f"### {title}", "")
        if introduction:
            yield from (introduction, "")
        mine = [record for record in everything if record.topic == topic]
        if topic in ("constants", "types"):
            yield from _table(("name", "meaning"), [(f"`{record.name}`", record.doc) for record in mine])
            continue
        for record in mine:
            yield f"- `{record.signature}`:"
            yield f"  {record.doc}"
            for example in record.examples:
                yield f"  `{example.expression}` gives `{example.value}`."
        yield ""


def _render_limits() -> Iterator[str]:
    yield from ("### Limits by default", "")
    rows = [(_LIMITS[limit.name], f"{limit.default:,}", _flag(limit.name)) for limit in fields(Limits)]
    yield from _table(("limit on", "default", "option"), rows)


def _flag(name: str) -> str:
    return "" if name == "log" else f"`--max-{name}`"


def _render_codes() -> Iterator[str]:
    yield from ("### Codes of errors and warnings", "")
    rows = [(code.code, f"`{name}`", code.why) for name, code in CODES.items()]
    yield from _table(("code", "name", "meaning"), sorted(rows))


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> Iterator[str]:
    yield "| " + " | ".join(head) + " |"
    yield "|" + "---|" * len(head)
    for row in rows:
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"
    yield ""


def updated(text: str) -> str:
    """The text of a document with the part between its markers generated anew; ValueError without markers."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"the document lacks the markers {BEGIN} and {END}")
    return f"{before}{BEGIN}\n\n{render()}\n{END}{after}"


def main(paths: list[str]) -> int:
    """Rewrite the generated part of each document."""
    for path in paths:
        document = Path(path)
        document.write_text(updated(document.read_text("utf-8")), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
