"""Everything that programs can use, as plain records from its one place of definition.

Builtins come from the registry, special forms from ``interpreter.forms`` and ``interpreter.form_examples``, constants
from ``stdlib.constants``, the combinators from the comments of ``combinators.scene``. Help, completion and the pages
under ``docs/reference`` (``make docs``) read these records.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache

from scenelang.grammar.datum import Source, comment_above, print_datum
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.reader import read
from scenelang.interpreter.expand.forms import DEFINITIONS, FORM_EXAMPLES, FORMS, MACROS, TOP_LEVEL
from scenelang.interpreter.program.program import PAPER_FORMS
from scenelang.interpreter.runtime.types import BASE_TYPES, STD, Builtin
from scenelang.interpreter.scene.primitives import attributes_read, block_words, docs_of_attributes, docs_of_words
from scenelang.interpreter.transpile.python_text import HELPERS, Helper
from scenelang.stdlib.library import build_library
from scenelang.stdlib.numbers import CONSTANTS

COMBINATORS = "combinators.scene"


_KEYWORD = re.compile(r"(?<![^\s(\[]):([^\s()\[\]:]+)")


class RecordKind(Enum):
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
class ReferenceRecord:
    """One name. ``signature`` is how it is used, as help and diagnostics show it; ``topic`` groups the reference;
    ``module`` is the file that a program must import to have the name, None for what is always there; ``picture`` is an
    expression whose picture shows what the name does, None where there is none."""

    name: str
    kind: RecordKind
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
    "forms": ("Special forms", "Special forms are not functions: each decides which of its parts are evaluated."),
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
        "For programs that were made of Python: what Python does on values whose type could not be inferred. They need "
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
    "Embedding": "An embedding; a handle or a string is accepted as one.",
    "Matrix": "A pose: a finite 4x4 matrix whose last row is 0 0 0 1; nested lists and arrays of that shape serve.",
    "Vector": "A one-dimensional array of numbers; a list of numbers serves.",
    "Point": "A vector of three numbers.",
    "Array": "An array of numbers of any number of dimensions.",
    "Entity": "An entity.",
    "Parts": "An entity, a pair (entity . matrix), or a list of these.",
    "Integer": "A whole number; a Float that is whole becomes one.",
    "Float": "A number.",
    "Number": "A number.",
    "Numeric": "A number or an array of numbers.",
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
    "Record": "A record; the name of a record type denotes its records.",
}


# --- records -------------------------------------------------------------------------------------------------------


@cache
def records() -> tuple[ReferenceRecord, ...]:
    """Every name of the language, by topic in the order of ``TOPICS``."""
    found = [*_forms(), *_paper(), *_builtins(), *combinators(), *_constants(), *_types()]
    order = {topic: position for position, topic in enumerate(TOPICS)}
    return tuple(sorted(found, key=lambda record: order[record.topic]))


def lookup(name: str) -> ReferenceRecord | None:
    """What is known of ``name``; a function before a type of the same name."""
    return next((record for record in records() if record.name == name), None)


def about_names(diagnostics: Iterable[Diagnostic]) -> Iterator[str]:
    """Return the signature and an example of every name that diagnostics are about, for a model that repairs a program.

    These are the names that are misused, and those that a misspelled name may stand for. A function of the program has
    only a signature, and a helper of Python programs its signature in Python.
    """
    seen: dict[str, None] = {}
    for d in diagnostics:
        if d.signature is not None:
            seen.setdefault(_usage(d.signature))
        for name in d.near:
            record, helper = lookup(name), HELPERS.get(name)
            if helper is not None:
                seen.setdefault(f"{helper.name}({helper.signature}) -> {helper.result}")
            elif record is not None:
                seen.setdefault(_usage(record.signature))
    yield from seen


def _usage(signature: str) -> str:
    """Return a signature with the example of the record that it belongs to."""
    record = lookup(signature.lstrip("(").split(" ", 1)[0].rstrip(")"))
    if record is None or record.signature != signature or not record.examples:
        return signature
    example = record.examples[0]
    return f"{signature}\n  {example.expression} => {example.value}"


def _forms() -> Iterator[ReferenceRecord]:
    for form in FORMS.values():
        text, value = FORM_EXAMPLES[form.name]
        examples = (
            (Example(text, value),) if value is not None and len(read(Source(form.name, text)).forms) == 1 else ()
        )
        yield ReferenceRecord(form.name, RecordKind.FORM, form.usage, form.doc, examples, "forms")


def _paper() -> Iterator[ReferenceRecord]:
    for signature, doc, example in _PAPER:
        name = signature[1:].split(" ", 1)[0]
        yield ReferenceRecord(name, RecordKind.FUNCTION, signature, doc, (example,) if example else (), "paper")


def _builtins() -> Iterator[ReferenceRecord]:
    hidden = {record.name for record in combinators()}
    for name, entry in build_library().builtins.items():
        if name not in hidden:
            yield _builtin(name, entry)
    for module, builtins in build_library().imported.items():
        for name, entry in builtins.items():
            yield _builtin(name, entry, f"{STD}{module}")


def _builtin(name: str, entry: Builtin, module: str | None = None) -> ReferenceRecord:
    examples = (Example(*entry.example),) if entry.example else ()
    return ReferenceRecord(name, RecordKind.FUNCTION, entry.usage, entry.doc, examples, entry.topic, module)


def _constants() -> Iterator[ReferenceRecord]:
    for name, (_, doc) in CONSTANTS.items():
        yield ReferenceRecord(name, RecordKind.CONSTANT, name, doc, (), "constants")


def _types() -> Iterator[ReferenceRecord]:
    for name, doc in _TYPES.items():
        if name in BASE_TYPES or name == "Tuple":
            yield ReferenceRecord(name, RecordKind.TYPE, name, doc, (), "types")


@cache
def combinators() -> tuple[ReferenceRecord, ...]:
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


def _combinator(name: str, head: str, comment: list[str]) -> ReferenceRecord:
    said, _, picture = " ".join(comment).partition(" Picture: ")
    doc, *examples = said.split(" Example: ")
    shown = [example.rpartition(" => ") for example in examples]
    return ReferenceRecord(
        name,
        RecordKind.FUNCTION,
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


# The helper API as Python stubs, for a language model to write against (the paper, appendix "Language Model
# Prompts").
#
# Names and parameters are the transpiler's, descriptions the registry's: what each helper says is what its
# counterpart in the language says, in Python's words.


_CLAUSE = re.compile(r"(?<=[^.])(?:: |; |\. ).*", re.S)
_LISP = re.compile(r"[,:;] `\(.*", re.S)
_ARRAY = re.compile(r"\[([^\][]+)\]")
# What the language calls otherwise than Python does.
_WORDS: Mapping[str, str] = {
    "an entity or parts": "a shape", "An entity": "A shape", "The entity of a word": "The shape of a word",
    "list of parts": "shape", "members": "shapes", "`count`": "`n`", "`axis`": "`direction`", "the function": "`fn`",
    "an association list or table": "a dictionary", "#t": "True", "#f": "False",
}  # fmt: skip

# What the language calls otherwise than JSON does.
_JSON_WORDS: Mapping[str, str] = {"an association list or table": "an object", "#t": "true", "#f": "false"}

_HEAD = """import math
import random
from collections.abc import Callable, Generator
from typing import Any

import numpy as np

P = Any  # a point or vector: three numbers, as a tuple, list or array
T = Any  # a pose: a 4x4 matrix, from the functions below; `A @ B` does B first, then A
Shape = Any  # primitives, each with its pose
"""


def helper_header(names: Sequence[str], words: Sequence[str]) -> str:
    """The stubs of the helpers ``names``, whose ``primitive_call`` makes the primitives ``words``."""
    pieces = [_HEAD]
    for name in names:
        helper = HELPERS[name]
        doc = _primitives(words) if name == "primitive_call" else [_described(helper)]
        signature = (
            _block_signature() if name == "primitive_call" and set(words) <= set(block_words()) else helper.signature
        )
        pieces.append(_stub(helper, signature, doc))
    return "\n\n".join(pieces)


def in_json(text: str) -> str:
    """What the registry says of a primitive or attribute, in the words of JSON."""
    text = _without_lisp(_without_colons(text))
    for words, others in _JSON_WORDS.items():
        text = text.replace(words, others)
    return _ARRAY.sub(lambda match: f"[{', '.join(match[1].split())}]", text)


def python_word(word: str) -> str:
    """A primitive's word as Python's programs write it."""
    return word.replace("-", "_")


def _stub(helper: Helper, signature: str, doc: Sequence[str]) -> str:
    body = doc[0] if len(doc) == 1 else "\n".join([doc[0], *(f"    {line}".rstrip() for line in doc[1:]), "    "])
    return f'def {helper.name}({signature}) -> {helper.result}:\n    """{body}"""\n'


def _described(helper: Helper) -> str:
    """The first statement of the counterpart's description, then what only Python has to say."""
    record = lookup(helper.counterpart) if helper.counterpart is not None else None
    if record is None:
        return helper.note
    return f"{_in_python(_CLAUSE.sub('', _LISP.sub('', record.doc)).rstrip('.'))}. {helper.note}".rstrip()


def _in_python(text: str) -> str:
    for words, others in _WORDS.items():
        text = text.replace(words, others)
    return _ARRAY.sub(lambda match: f"({', '.join(match[1].split())})", text)


def _primitives(words: Sequence[str]) -> list[str]:
    """What each primitive is and what it takes, then what each argument means."""
    docs = docs_of_words()
    are_blocks = set(words) <= set(block_words())
    lines = ["Makes a primitive.", ""]
    for word in words:
        taken = [name for name in attributes_read(word) if name != "color"]
        keys = ", ".join(f"'{name}'" if not are_blocks else name.replace("-", "_") for name in taken)
        lines.append(f"'{python_word(word)}': {_plain(docs[word])}; takes {keys}")
    lines.append("")
    return [*lines, *_arguments(words, are_blocks)]


def _arguments(words: Sequence[str], are_blocks: bool) -> Iterator[str]:
    read = dict.fromkeys(name for word in words for name in attributes_read(word))
    docs = docs_of_attributes()
    for name in read:
        if not (are_blocks and name == "color"):
            yield f"{name.replace('-', '_')}: {_plain(_without_lisp(docs[name]))}"


def _without_lisp(text: str) -> str:
    return "; ".join(piece for piece in text.split("; ") if "`(" not in piece)


def _plain(text: str) -> str:
    return _in_python(_without_colons(text))


def _without_colons(text: str) -> str:
    return re.sub(r":(p0|p1)\b", r"\1", text)


def _block_signature() -> str:
    return "name: str, **block_arguments"


# The names of the language by what they are, for whatever colours programs.


PAPER = frozenset({"bind", "retrieve", *PAPER_FORMS})


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """``definitions`` are the forms that define names, ``paper`` the paper's forms; no name is in two sets."""

    forms: frozenset[str]
    definitions: frozenset[str]
    paper: frozenset[str]
    functions: frozenset[str]
    constants: frozenset[str]


@cache
def vocabulary() -> Vocabulary:
    """The names that every program sees; those of libraries to import are a program's own."""
    definitions = frozenset({*DEFINITIONS, *MACROS, *TOP_LEVEL}) - PAPER
    known = [record for record in records() if record.module is None and record.name not in PAPER]
    return Vocabulary(
        forms=frozenset({*FORMS, "else", "=>"}) - definitions - PAPER,
        definitions=definitions,
        paper=PAPER,
        functions=frozenset(record.name for record in known if record.kind is RecordKind.FUNCTION),
        constants=frozenset(record.name for record in known if record.kind is RecordKind.CONSTANT),
    )


# --- grammars as text, for decoders of language models, parser generators, editors and people ------------------------

PARSED = ("lark", "llguidance", "gbnf", "ebnf")  # the formats that say which programs there are
TEXTMATE = "textmate"
GRAMMARS = (*PARSED, TEXTMATE)


def grammar_text(form: str, strict: bool = False) -> str:
    """The grammar of programs in a format; docs/grammar.md says what each is for.

    Parameters
    ----------
    form : str
        "lark", "llguidance", "gbnf", "ebnf" or "textmate".
    strict : bool
        The paper's grammar, as ``check --strict`` has it.

    Raises
    ------
    SceneError
        There is no such format, or it has no strict form.

    Examples
    --------
    >>> "start" in grammar_text("lark")
    True
    """
    from scenelang.grammar.export.textmate import textmate_text

    if form not in GRAMMARS:
        raise SceneError("value", f"unknown grammar format `{form}`; expected {', '.join(GRAMMARS)}")
    if form != TEXTMATE:
        return _parsed(form, strict)
    if strict:
        raise SceneError("value", "a TextMate grammar colours tokens, so it has no strict form")
    return textmate_text(_scopes())


def _parsed(form: str, strict: bool) -> str:
    from scenelang.grammar.export.ebnf import ebnf_text
    from scenelang.grammar.export.gbnf import gbnf_text
    from scenelang.grammar.export.lark_text import lark_text, llguidance_text
    from scenelang.interpreter.expand.forms import full_grammar, strict_grammar

    writers = {"lark": lark_text, "llguidance": llguidance_text, "gbnf": gbnf_text, "ebnf": ebnf_text}
    return writers[form](strict_grammar() if strict else full_grammar())


def _scopes() -> dict[str, frozenset[str]]:
    """The names of the language by the scope that editors give them."""
    names = vocabulary()
    return {
        "keyword.control": names.forms,
        "storage.type": names.definitions,
        "keyword.other.paper": names.paper,
        "support.function": names.functions,
        "support.constant": names.constants,
    }
