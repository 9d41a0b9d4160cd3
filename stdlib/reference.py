"""Everything that programs can use, as plain records from its one place of definition.

Builtins come from the registry, special forms from ``interpreter.forms`` and ``interpreter.form_examples``, constants
from ``stdlib.constants``, the combinators from the comments of ``combinators.scene``. Help, completion and the pages
under ``docs/reference`` (``make docs``) read these records.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cache

from scenelang.grammar.printer import print_datum
from scenelang.grammar.reader import read
from scenelang.grammar.source import Source, comment_above
from scenelang.interpreter.form_examples import FORM_EXAMPLES
from scenelang.interpreter.forms import FORMS
from scenelang.interpreter.library import STD, Builtin
from scenelang.interpreter.types import BASE_TYPES
from scenelang.stdlib.constants import CONSTANTS
from scenelang.stdlib.library import build_library

COMBINATORS = "combinators.scene"


_KEYWORD = re.compile(r"(?<![^\s(\[]):([^\s()\[\]:]+)")


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
    """One name. ``signature`` is how it is used, as help and diagnostics show it; ``topic`` groups the reference;
    ``module`` is the file that a program must import to have the name, None for what is always there; ``picture`` is an
    expression whose picture shows what the name does, None where there is none."""

    name: str
    kind: Kind
    signature: str
    doc: str
    examples: tuple[Example, ...]
    topic: str
    module: str | None = None
    picture: str | None = None

    @property
    def keywords(self) -> tuple[str, ...]:
        """The names of its keyword parameters."""
        return tuple(dict.fromkeys(_KEYWORD.findall(self.signature)))


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
        "may also be a function of the copy's index. Every combinator gives parts, which go into a `union`. Boxes are "
        "the exact bounding boxes of `compute-shape-min` and its kin.",
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
    "python": (
        "Python's dynamic rules",
        "For programs that were made of Python: what Python does on values whose type could not be told. They need "
        '`(import "std/python.scene")`. In programs that people write, the plain operators say what is meant.',
    ),
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
        "Joins members into one list of parts: entities, pairs (entity . matrix) and lists of these to any depth.",
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
        text, value = FORM_EXAMPLES[form.name]
        examples = (
            (Example(text, value),) if value is not None and len(read(Source(form.name, text)).forms) == 1 else ()
        )
        yield Record(form.name, Kind.FORM, form.usage, form.doc, examples, "forms")


def _paper() -> Iterator[Record]:
    for signature, doc, example in _PAPER:
        name = signature[1:].split(" ", 1)[0]
        yield Record(name, Kind.FUNCTION, signature, doc, (example,) if example else (), "paper")


def _builtins() -> Iterator[Record]:
    hidden = {record.name for record in combinators()}
    for name, entry in build_library().builtins.items():
        if name not in hidden:
            yield _builtin(name, entry)
    for module, builtins in build_library().imported.items():
        for name, entry in builtins.items():
            yield _builtin(name, entry, f"{STD}{module}")


def _builtin(name: str, entry: Builtin, module: str | None = None) -> Record:
    examples = (Example(*entry.example),) if entry.example else ()
    return Record(name, Kind.FUNCTION, entry.usage, entry.doc, examples, entry.topic, module)


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
    once or more, then ``;;; Picture: expression``, over as many lines as it takes.
    """
    text = build_library().modules[COMBINATORS]
    source = Source(COMBINATORS, text)
    found = []
    for datum in read(source).forms:
        comment = _documentation(comment_above(source, datum.span.start))
        if comment:
            head = datum.items[1]  # type: ignore[union-attr]
            found.append(_combinator(str(head.items[0].value), print_datum(head), comment))
    return tuple(found)


def _combinator(name: str, head: str, comment: list[str]) -> Record:
    said, _, picture = " ".join(comment).partition(" Picture: ")
    doc, *examples = said.split(" Example: ")
    shown = [example.rpartition(" => ") for example in examples]
    return Record(
        name,
        Kind.FUNCTION,
        f"{head} -> Parts",
        doc,
        tuple(Example(expression, value) for expression, _, value in shown),
        "combinators",
        picture=picture or None,
    )


def _documentation(lines: list[str]) -> list[str]:
    """The lines ``;;; ...`` that a comment ends with, without their semicolons."""
    found: list[str] = []
    for line in lines:
        found = [*found, line[4:].strip()] if line.startswith(";;; ") else []
    return found
