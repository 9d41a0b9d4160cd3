"""Reference records of all names of the language, generated from their definitions.

Builtins come from the registry, special forms from ``interpreter.expand.forms``, constants from ``stdlib.numbers``, the
combinators from the comments of ``combinators.scene``, parts and their sockets from those of ``parts/*.scene``. Help,
completion, prompts and the pages of ``docs/reference`` (``make docs``) read these records; the grammars as text are
generated here as well.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import Any

from scenelang.grammar.datum import Source, comment_above, print_datum
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.grammar.python_helpers import HELPERS, Helper
from scenelang.grammar.reader import read
from scenelang.interpreter.expand.forms import DEFINITIONS, FORM_EXAMPLES, FORMS, MACROS, PAPER_FORMS, TOP_LEVEL
from scenelang.interpreter.runtime.modelling_helpers import python_name
from scenelang.interpreter.runtime.types import BASE_TYPES, STD, Builtin
from scenelang.interpreter.scene.primitives import attributes_read, block_words, docs_of_attributes, docs_of_words
from scenelang.stdlib.library import build_library, part_modules, registry_of
from scenelang.stdlib.numbers import CONSTANTS

COMBINATORS = "combinators.scene"


_KEYWORD = lazy_pattern(r"(?<![^\s(\[]):([^\s()\[\]:]+)")


class RecordKind(Enum):
    """Kind of a documented name."""

    FORM = "form"
    FUNCTION = "function"
    CONSTANT = "constant"
    TYPE = "type"
    PART = "part"


@dataclass(frozen=True, slots=True)
class Example:
    """Expression and its printed value."""

    expression: str
    value: str


@dataclass(frozen=True, slots=True)
class ReferenceRecord:
    """Documented name.

    Attributes
    ----------
    name, kind, doc, examples
        For help and the reference.
    signature
        Usage, as help and diagnostics show it.
    topic
        Section of the reference, a key of ``TOPICS``.
    module
        File that a program must import for the name; None if it is always available.
    picture
        Expression whose rendering illustrates the name, or None.
    """

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
        """Names of the keyword parameters."""
        return tuple(dict.fromkeys(_KEYWORD.findall(self.signature)))


# The topics in the order of the reference: title and introduction.
TOPICS: dict[str, tuple[str, str]] = {
    "forms": ("Special forms", "Special forms are not functions: each has its own rules of evaluation."),
    "paper": (
        "The paper's macros",
        "The four macros that the paper defines in the language. Here they are procedures, so they are first-class.",
    ),
    "entities": ("Entities and embeddings", ""),
    "poses": ("Poses", "Lengths are the scene's units, angles are radians."),
    "combinators": (
        "Combinators",
        "An *object* is an entity, a pair (entity . matrix) or parts, as returned by `union`; combinators that make "
        "copies also accept a function of the copy's index. Every combinator returns parts, which can be used in a "
        "`union`. Boxes are the exact bounding boxes of `compute-shape-min` and related functions.",
    ),
    "solids": (
        "Solid modeling",
        "Solids are entities, computed when they are drawn or measured. Operands are entities, pairs or parts: cubes, "
        "spheres and other primitives, closed mesh files and solids. A profile is an array of points [x y], or a list "
        "of such contours: outer ones counter-clockwise, holes clockwise. [Solids](../solids.md) has more.",
    ),
    "profiles": (
        "Profiles",
        "A profile is an array of points [x y], or a list of such contours: outer ones counter-clockwise, holes "
        "clockwise. What contours wind around a positive number of times is inside. A profile is plain data: "
        "`(+ contour [1 0])` moves one contour, `transform-profile` several.",
    ),
    "paths": (
        "Paths",
        "A path is an array of points [x y z]; points [x y] are in the plane z = 0. It is closed if it ends where it "
        "begins. `sweep` moves a profile along it, and `along` places objects on it.",
    ),
    "colors": ("Colors", ""),
    "setup": ("Cameras and lights", "Declarations at top level, in world coordinates, which are no objects."),
    "numbers": ("Numbers", "Arithmetic works on numbers and elementwise on arrays."),
    "predicates": ("Type predicates and equality", ""),
    "lists": ("Lists and pairs", ""),
    "sequences": (
        "Sequences",
        "A sequence is a list, a mutable list, an array, a string, a set or the keys of a table.",
    ),
    "mutation": (
        "Mutation",
        "These functions modify mutable lists, mutable arrays, tables and sets. Lists, arrays and strings are "
        "immutable.",
    ),
    "tables": ("Tables and sets", ""),
    "strings": ("Strings", ""),
    "arrays": ("Arrays", "Vectors and matrices are arrays; `[1 2 3]` is a literal."),
    "random": (
        "Random numbers",
        "Functions without a prefix draw from the stream of numpy's `RandomState`, those with `py-` from the stream of "
        "Python's `random`. `:stream` selects another stream. `noise` and `fbm` draw nothing: they are functions of a "
        "point.",
    ),
    "control": ("Control and errors", ""),
    "python": (
        "Python's semantics",
        "For programs transpiled from Python: operators with Python's semantics for values whose type could not be "
        'inferred. They need `(import "std/python.scene")`. In programs written by hand, prefer the plain operators.',
    ),
    "parts": (
        "Parts",
        "Everyday objects in metres, each with the middle of its foot at the origin and its front at +z, and sockets: "
        "poses where other objects go. [Parts](../parts.md) shows them.",
    ),
    "constants": ("Constants", ""),
    "types": ("Types", "The names that annotate a parameter, `name::Type`."),
}

_PAPER: tuple[tuple[str, str, Example | None], ...] = (
    (
        "(call word::Word embeddings ... :attribute value ...) -> Entity",
        "Return the entity of a word: apply the function bound to it, or make a primitive if it is unbound. Attributes "
        "are added to the first embedding. The same word with equal embeddings is evaluated once and shared.",
        Example('(entity-word (call "tree" "an old oak"))', '"tree"'),
    ),
    (
        "(union members ...) -> Parts",
        "Join members into one list of parts: entities, pairs (entity . matrix) and lists of these, nested to any "
        "depth.",
        Example('(length (union (call "cube") (list (call "cone") (call "sphere"))))', "3"),
    ),
    (
        "(union-loop count::Integer function::Function) -> Parts",
        "Join the results of the function for 0, 1, ... `count` - 1.",
        Example('(length (union-loop 8 (lambda (i) (call "cube"))))', "8"),
    ),
    (
        "(transform part matrix::Matrix) -> Pair",
        "Apply a pose to an entity: return the pair (entity . matrix). For a pair or parts, compose it with their "
        "poses.",
        Example('(compute-shape-max (transform (call "cube") (translate [1 2 3])))', "[1.5 2.5 3.5]"),
    ),
)

_TYPES: dict[str, str] = {
    "Any": "Any value.",
    "Word": "A string that names a class of entities.",
    "String": "Text.",
    "Embedding": "An embedding; a handle or a string is accepted as one.",
    "Matrix": "A pose: a finite 4x4 matrix whose last row is 0 0 0 1; nested lists and arrays of that shape are "
    "converted.",
    "Vector": "A one-dimensional array of numbers; a list of one or more numbers is converted.",
    "Point": "A vector of three numbers.",
    "Array": "An array of numbers of any number of dimensions.",
    "Entity": "An entity.",
    "Parts": "An entity, a pair (entity . matrix), or a list of these.",
    "Integer": "A whole number; a whole Float is converted.",
    "Float": "A number.",
    "Number": "A number.",
    "Numeric": "A number or an array of numbers.",
    "ArrayLike": "A number, an array, or nested lists of numbers.",
    "Boolean": "`#t` or `#f`.",
    "Function": "A procedure, builtin or user-defined.",
    "List": "A list or mutable list; `List[Type]` gives the type of its items.",
    "Tuple": "`Tuple[Type, ...]`: a list with one item of each type, or a pair of two.",
    "Sequence": "A list, mutable list, array, string, table (its keys) or set.",
    "Symbol": "A symbol, such as `'name`.",
    "Keyword": "A keyword, such as `:name`.",
    "Pair": "A pair or a list that is not empty.",
    "MutableList": "A mutable list.",
    "MutableArray": "A mutable array.",
    "Table": "A table.",
    "Set": "A set.",
    "Stream": "A random stream, separate from the default ones.",
    "Record": "A record; the name of a record type denotes its records.",
    "Axis": "`:x`, `:y` or `:z`.",
    "Alignment": "`:min`, `:center`, `:max`, `:before` or `:after`.",
    "Extent": "One number, or three: one for each axis.",
    "Template": "Parts, or a function that returns them for the index of a copy.",
}


# --- records -------------------------------------------------------------------------------------------------------


@cache
def records() -> tuple[ReferenceRecord, ...]:
    """Return the records of all names, sorted by topic in the order of ``TOPICS``."""
    all_records = [*_forms(), *_paper(), *_builtins(), *combinators(), *_parts(), *_constants(), *_types()]
    order = {topic: position for position, topic in enumerate(TOPICS)}
    return tuple(sorted(all_records, key=lambda record: order[record.topic]))


def lookup(name: str) -> ReferenceRecord | None:
    """Return the record of ``name``, or None; a function takes precedence over a type of the same name."""
    return next((record for record in records() if record.name == name), None)


def about_names(diagnostics: Iterable[Diagnostic]) -> Iterator[str]:
    """Yield the usage of each function that a language model may need to correct the errors of a program.

    These are the functions with wrong arguments, and those that a misspelled name may mean.

    Yields
    ------
    str
        Signature of a function; a function of the library also has an example. For a function of the Python API, the
        signature as in Python, ``name(parameters) -> result``. Each text is yielded once.
    """
    texts: dict[str, None] = {}
    for d in diagnostics:
        if d.signature is not None:
            texts.setdefault(_usage(d.signature))
        for name in d.near:
            record, helper = lookup(name), HELPERS.get(name)
            if helper is not None:
                texts.setdefault(f"{helper.name}({helper.signature}) -> {helper.result}")
            elif record is not None:
                texts.setdefault(_usage(record.signature))
    yield from texts


def _usage(signature: str) -> str:
    """Return a signature with the example of the record that it belongs to."""
    record = lookup(signature.lstrip("(").split(" ", 1)[0].rstrip(")"))
    if record is None or record.signature != signature or not record.examples:
        return signature
    example = record.examples[0]
    return f"{signature}\n  {example.expression} => {example.value}"


def _forms() -> Iterator[ReferenceRecord]:
    """Iterate over the special forms; an example is shown if it is one expression with a value."""
    for form in FORMS.values():
        text, value = FORM_EXAMPLES[form.name]
        examples = (
            (Example(text, value),) if value is not None and len(read(Source(form.name, text)).forms) == 1 else ()
        )
        yield ReferenceRecord(form.name, RecordKind.FORM, form.usage, form.doc, examples, "forms")


def _paper() -> Iterator[ReferenceRecord]:
    """Iterate over the paper's macros."""
    for signature, doc, example in _PAPER:
        name = signature[1:].split(" ", 1)[0]
        yield ReferenceRecord(name, RecordKind.FUNCTION, signature, doc, (example,) if example else (), "paper")


def _builtins() -> Iterator[ReferenceRecord]:
    """Iterate over the builtins, except those that a combinator of the same name hides."""
    hidden = {record.name for record in combinators()}
    for name, entry in build_library().builtins.items():
        if name not in hidden:
            yield _builtin(name, entry)
    for module, builtins in build_library().imported.items():
        for name, entry in builtins.items():
            yield _builtin(name, entry, f"{STD}{module}")


def _builtin(name: str, entry: Builtin, module: str | None = None) -> ReferenceRecord:
    """Return the record of an entry of the registry."""
    examples = (Example(*entry.example),) if entry.example else ()
    return ReferenceRecord(
        name, RecordKind.FUNCTION, entry.usage, entry.doc, examples, entry.topic, module, entry.picture
    )


def _constants() -> Iterator[ReferenceRecord]:
    """Iterate over the constants."""
    for name, (_, doc) in CONSTANTS.items():
        yield ReferenceRecord(name, RecordKind.CONSTANT, name, doc, (), "constants")


def _types() -> Iterator[ReferenceRecord]:
    """Iterate over the types of annotations."""
    for name, doc in _TYPES.items():
        if name in BASE_TYPES or name == "Tuple":
            yield ReferenceRecord(name, RecordKind.TYPE, name, doc, (), "types")


@cache
def combinators() -> tuple[ReferenceRecord, ...]:
    """Return the documented definitions of ``combinators.scene``.

    The documentation is the lines that start with ``;;;`` directly above a definition: the description, then one or
    more examples ``;;; Example: expression => value``, then ``;;; Picture: expression``. Each can span several lines.
    """
    return tuple(
        _combinator(str(form.items[1].items[0].value), print_datum(form.items[1]), comment)
        for form, comment in _documented(COMBINATORS)
    )


def _documented(module: str) -> Iterator[tuple[Any, list[str]]]:
    """Yield the documented definitions of a module that is written in the language, with their documentation."""
    source = Source(module, build_library().modules[module])
    for datum in read(source).forms:
        comment = _documentation(comment_above(source, datum.span.start))
        if comment:
            yield datum, comment


def _combinator(name: str, head: str, comment: list[str]) -> ReferenceRecord:
    """Return the record of a combinator from the lines of its documentation."""
    text, _, picture = " ".join(comment).partition(" Picture: ")
    doc, *examples = text.split(" Example: ")
    parsed = [example.rpartition(" => ") for example in examples]
    return ReferenceRecord(
        name,
        RecordKind.FUNCTION,
        f"{head} -> Parts",
        doc,
        tuple(Example(expression, value) for expression, _, value in parsed),
        "combinators",
        picture=picture or None,
    )


def _documentation(lines: list[str]) -> list[str]:
    """Return the text of the lines ``;;; ...`` at the end of a comment."""
    documentation: list[str] = []
    for line in lines:
        documentation = [*documentation, line[4:].strip()] if line.startswith(";;; ") else []
    return documentation


# --- parts: everyday objects ------------------------------------------------------------------------------------

_TYPE = lazy_pattern(r"::\w+|[\[\]]")
_PAIR = lazy_pattern(r" :([a-z][\w-]*)(?: ([^\s:()]+))?")  # of a usage: name and plain default
_DEFAULT_COLOR = lazy_pattern(r" \((?:std/)?color [^)]*\)")
_LABEL = lazy_pattern(r" (Parameters|Size|Front|Sockets|Also|Example): ")


@dataclass(frozen=True, slots=True)
class LibraryPart:
    """Everyday object that a module of ``parts`` binds to a word.

    Attributes
    ----------
    record
        Its record; the picture is an example that uses it.
    summary, parameters, front
        What it is, what its parameters mean with their units, and where its front is.
    others
        Other words for it, and places where it is: what a search finds it by.
    size
        Width, height and depth of its box with the default parameters, in metres.
    sockets
        Functions that return where other objects go, or how it is placed itself.
    """

    record: ReferenceRecord
    summary: str
    parameters: str
    front: str
    others: tuple[str, ...]
    size: tuple[float, float, float]
    sockets: tuple[ReferenceRecord, ...]

    @property
    def word(self) -> str:
        """Word that it is bound to."""
        return self.record.name

    @property
    def usage(self) -> str:
        """Call with all parameters and their defaults, as short as a prompt needs it; colors without a default."""
        return _DEFAULT_COLOR.sub("", _TYPE.sub("", self.record.signature.removesuffix(" -> Entity")))

    @property
    def python_usage(self) -> str:
        """``usage`` in Python mode, ``chair(width=0.45, color=None)``; what is computed from others is None as well."""
        given = ", ".join(f"{python_name(name)}={value or None}" for name, value in _PAIR.findall(self.usage))
        return f"{python_name(self.word)}({given})"


@cache
def parts() -> tuple[LibraryPart, ...]:
    """Return the parts of all modules, by module in alphabetical order.

    The documentation of a part is a description, then the labels ``Parameters:``, ``Size:``, ``Front:``, ``Sockets:``,
    ``Also:`` and ``Example:``; that of a socket is like that of a combinator.

    Examples
    --------
    >>> [socket.name for part in parts() if part.word == "chair" for socket in part.sockets]
    ['chair-seat']
    """
    return tuple(part for module in part_modules() for part in _parts_of(module))


def _parts_of(module: str) -> Iterator[LibraryPart]:
    """Yield the parts of a module."""
    documented = list(_documented(module))
    sockets = {
        record.name: record
        for form, comment in documented
        if form.items[0].value == "define"
        for record in (_socket(module, print_datum(form.items[1]), comment),)
    }
    for form, comment in documented:
        if form.items[0].value == "bind":
            yield _part(module, form, comment, sockets)


def _part(module: str, form: Any, comment: list[str], sockets: Mapping[str, ReferenceRecord]) -> LibraryPart:
    """Return a part from its definition and the lines of its documentation."""
    summary, *labeled = _LABEL.split(" ".join(comment))
    fields = dict(zip(labeled[::2], labeled[1::2], strict=True))
    word, parameters = form.items[1].value, form.items[2].items[1]
    signature = f'(call "{word}" {" ".join(f"[{print_datum(each)[1:-1]}]" for each in parameters.items)}) -> Entity'
    width, height, depth = map(float, fields["Size"].split())
    mine = tuple(sockets[name] for name in fields["Sockets"].split() if name != "none")
    doc = f"{summary} {fields['Parameters']} Front: {fields['Front']} Also: {fields['Also']}"
    where = f" Sockets: {', '.join(f'`{socket.name}`' for socket in mine)}." if mine else ""
    record = ReferenceRecord(
        word, RecordKind.PART, signature, doc + where, (), "parts", f"{STD}{module}", fields["Example"]
    )
    others = tuple(fields["Also"].rstrip(".").split(", "))
    return LibraryPart(record, summary, fields["Parameters"], fields["Front"], others, (width, height, depth), mine)


def _socket(module: str, head: str, comment: list[str]) -> ReferenceRecord:
    """Return the record of a socket from the lines of its documentation."""
    doc, *examples = " ".join(comment).split(" Example: ")
    parsed = [example.rpartition(" => ") for example in examples]
    result = "List[Matrix]" if doc.startswith("Return the poses") else "Matrix"
    return ReferenceRecord(
        head[1:].rstrip(")").split(" ", 1)[0],
        RecordKind.FUNCTION,
        f"{head} -> {result}",
        doc,
        tuple(Example(expression, value) for expression, _, value in parsed),
        "parts",
        f"{STD}{module}",
    )


def _parts() -> Iterator[ReferenceRecord]:
    """Iterate over the records of parts and sockets."""
    for part in parts():
        yield part.record
        yield from part.sockets


# --- Python stubs of the helper API ----------------------------------------------------------------------------

# For the prompts of language models (paper, appendix "Language Model Prompts"). Names and parameters come from the
# transpiler; the description of a helper is that of its counterpart in the language, in Python's terms.

_CLAUSE = lazy_pattern(r"(?<=[^.])(?:: |; |\. ).*", re.S)
_LISP = lazy_pattern(r"[,:;] `\(.*", re.S)
_ARRAY = lazy_pattern(r"\[([^\][]+)\]")
# Terms of the language and their equivalents in Python.
_WORDS: Mapping[str, str] = {
    "an entity or parts": "a shape", "an entity": "a shape", "the entity of a word": "the shape of a word",
    "list of parts": "shape", "members": "shapes", "`count`": "`n`", "`axis`": "`direction`", "the function": "`fn`",
    "an association list or table": "a dictionary", "#t": "True", "#f": "False",
}  # fmt: skip

# Terms of the language and their equivalents in JSON.
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
    """Return the stubs of the helpers ``names``, with ``words`` as the primitives of ``primitive_call``."""
    pieces = [_HEAD]
    for name in names:
        helper = HELPERS[name]
        doc = _primitive_call(words) if name == "primitive_call" else [_description(helper)]
        signature = (
            _block_signature() if name == "primitive_call" and set(words) <= set(block_words()) else helper.signature
        )
        pieces.append(_stub(helper, signature, doc))
    return "\n\n".join(pieces)


def in_json(text: str) -> str:
    """Return the description of a primitive or attribute in terms of JSON."""
    text = _without_lisp(_without_colons(text))
    for words, others in _JSON_WORDS.items():
        text = text.replace(words, others)
    return _ARRAY.sub(lambda match: f"[{', '.join(match[1].split())}]", text)


def _stub(helper: Helper, signature: str, doc: Sequence[str]) -> str:
    """Return a Python function without a body but its docstring."""
    body = doc[0] if len(doc) == 1 else "\n".join([doc[0], *(f"    {line}".rstrip() for line in doc[1:]), "    "])
    return f'def {helper.name}({signature}) -> {helper.result}:\n    """{body}"""\n'


def _description(helper: Helper) -> str:
    """Return the first statement of the counterpart's description, and the note of the helper."""
    record = lookup(helper.counterpart) if helper.counterpart is not None else None
    if record is None:
        return helper.note
    return f"{_in_python(_CLAUSE.sub('', _LISP.sub('', record.doc)).rstrip('.'))}. {helper.note}".rstrip()


_QUOTED = lazy_pattern(r"`(:?[a-z][\w-]*)`")


def in_python_terms(text: str) -> str:
    """Return a description in Python's terms: names as Python writes them, vectors as tuples.

    >>> in_python_terms("A path at `:start`, as by `frame-at`, from [0 0 1].")
    'A path at `start`, as by `frame_at`, from (0, 0, 1).'
    """
    return _in_python(_QUOTED.sub(lambda match: f"`{match[1].lstrip(':').replace('-', '_')}`", text))


def _in_python(text: str) -> str:
    """Return a description in Python's terms, vectors as tuples."""
    for words, others in _WORDS.items():
        text = text.replace(words, others)
    return _ARRAY.sub(lambda match: f"({', '.join(match[1].split())})", text)


def _primitive_call(words: Sequence[str]) -> list[str]:
    """Return the description of ``primitive_call``; without words, those stand elsewhere."""
    return ["Make a primitive.", *(["", *python_primitives(words)] if words else [])]


def python_primitives(words: Sequence[str]) -> list[str]:
    """Return the lines that describe the primitives in Python, their attributes and the arguments."""
    docs = docs_of_words()
    are_blocks = set(words) <= set(block_words())
    lines: list[str] = []
    for word in words:
        attributes = [name for name in attributes_read(word) if name != "color"]
        keys = ", ".join(f"'{name}'" if not are_blocks else name.replace("-", "_") for name in attributes)
        lines.append(f"'{python_name(word)}': {_plain(docs[word])}; arguments {keys}")
    lines.append("")
    return [*lines, *_arguments(words, are_blocks=are_blocks)]


def _arguments(words: Sequence[str], *, are_blocks: bool) -> Iterator[str]:
    """Iterate over the descriptions of the attributes of primitives, each once."""
    read = dict.fromkeys(name for word in words for name in attributes_read(word))
    docs = docs_of_attributes()
    for name in read:
        if not (are_blocks and name == "color"):
            yield f"{name.replace('-', '_')}: {_plain(_without_lisp(docs[name]))}"


def _without_lisp(text: str) -> str:
    """Leave out the clauses of a description that contain expressions of the language."""
    return "; ".join(piece for piece in text.split("; ") if "`(" not in piece)


def _plain(text: str) -> str:
    """Return the description of a primitive or attribute in Python's terms."""
    return _in_python(_without_colons(text))


def _without_colons(text: str) -> str:
    """Write the names of end points without the colon of keywords."""
    return re.sub(r":(p0|p1)\b", r"\1", text)


def _block_signature() -> str:
    """Return the parameters of ``primitive_call`` for block primitives."""
    return "name: str, **block_arguments"


# --- names by category, for syntax highlighting ----------------------------------------------------------------

PAPER = frozenset({"bind", "retrieve", *PAPER_FORMS})


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """Disjoint categories of names: ``definitions`` are the forms that define names, ``paper`` those of the paper."""

    forms: frozenset[str]
    definitions: frozenset[str]
    paper: frozenset[str]
    functions: frozenset[str]
    constants: frozenset[str]


@cache
def vocabulary() -> Vocabulary:
    """Return the names that are visible in every program; names of modules to import are not included."""
    definitions = frozenset({*DEFINITIONS, *MACROS, *TOP_LEVEL}) - PAPER
    visible = [record for record in records() if record.module is None and record.name not in PAPER]
    return Vocabulary(
        forms=frozenset({*FORMS, "else", "=>"}) - definitions - PAPER,
        definitions=definitions,
        paper=PAPER,
        functions=frozenset(record.name for record in visible if record.kind is RecordKind.FUNCTION),
        constants=frozenset(record.name for record in visible if record.kind is RecordKind.CONSTANT),
    )


# --- grammars as text, for constrained decoding, parser generators and editors ---------------------------------

PARSED = ("lark", "llguidance", "gbnf", "ebnf")  # the formats that define the syntax
TEXTMATE = "textmate"
GRAMMARS = (*PARSED, TEXTMATE)


def grammar_text(form: str, strict: bool = False) -> str:
    """Return the grammar of programs in a format; docs/grammar.md describes their uses.

    Parameters
    ----------
    form : str
        "lark", "llguidance", "gbnf", "ebnf" or "textmate".
    strict : bool
        The paper's grammar, as for ``check --strict``.

    Raises
    ------
    SceneError
        The format is unknown, or it has no strict form.

    Examples
    --------
    >>> "start" in grammar_text("lark")
    True
    """
    from scenelang.grammar.export.notations import textmate_text

    if form not in GRAMMARS:
        raise SceneError("value", f"unknown grammar format `{form}`; expected {', '.join(GRAMMARS)}")
    if form != TEXTMATE:
        return _parsed(form, strict=strict)
    if strict:
        raise SceneError("value", "the format `textmate` highlights tokens and has no strict form")
    return textmate_text(_scopes())


def _parsed(form: str, *, strict: bool) -> str:
    """Return the grammar in a format that defines the syntax."""
    from scenelang.grammar.export.notations import ebnf_text, gbnf_text, lark_text, llguidance_text
    from scenelang.interpreter.expand.forms import full_grammar, strict_grammar

    writers = {"lark": lark_text, "llguidance": llguidance_text, "gbnf": gbnf_text, "ebnf": ebnf_text}
    return writers[form](strict_grammar() if strict else full_grammar())


def _scopes() -> dict[str, frozenset[str]]:
    """Return the names of the language by TextMate scope."""
    names = vocabulary()
    return {
        "keyword.control": names.forms,
        "storage.type": names.definitions,
        "keyword.other.paper": names.paper,
        "support.function": names.functions,
        "support.constant": names.constants,
    }


# Signatures for Python mode, which ``make tables`` writes.

_MODELLING = ("solids.registry", "profiles.registry", "paths.registry")


def modelling_text() -> str:
    """Return the text of ``interpreter.runtime.modelling_signatures``: parameters and results for Python mode.

    The interpreter does not import the library, and a translation of Python imports neither the builtins nor the parts.
    """
    entries = [entry for topic in _MODELLING for entry in registry_of(topic).entries.values()]
    rows = [f"    {entry.name!r}: ({entry.parameters!r}, {entry.result!r}),\n" for entry in entries]
    records = [record for part in parts() for record in (part.record, *part.sockets)]
    described = {
        each.name: (_keywords_of(each.signature), each.signature.rpartition(" -> ")[2], each.module) for each in records
    }
    further = [f"    {name!r}: {row!r},\n" for name, row in described.items()]
    title = (
        '"""Parameters and results of the builtins of solids, profiles and paths, and of the library of parts.\n\n'
        'Written by ``make tables``.\n"""'
    )
    signatures = f"SIGNATURES: dict[str, tuple[str, str]] = {{\n{''.join(rows)}}}\n"
    return f"{title}\n\n{signatures}\nPARTS: dict[str, tuple[str, str, str]] = {{\n{''.join(further)}}}\n"


def _keywords_of(signature: str) -> str:
    """Return the keyword parameters of a part or socket as a builtin has them, without their defaults."""
    return " ".join(f"[{name}::{kind}]" for name, kind in re.findall(r"(:[a-z][\w-]*)::([A-Za-z]+)", signature))


if __name__ == "__main__":
    with open(sys.argv[1], "w", encoding="utf-8") as output:
        output.write(modelling_text())
