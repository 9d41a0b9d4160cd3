"""Compact language reference for language-model prompts and help texts, generated from the reference's records."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import chain
from types import MappingProxyType

from scenelang.backends.surfaces.appearance import MATERIALS
from scenelang.grammar.diagnostics import CODES, diagnostic_named, explanation
from scenelang.interpreter.runtime.modelling_helpers import modelling_helpers, python_name
from scenelang.interpreter.runtime.types import STD
from scenelang.interpreter.scene import primitives
from scenelang.interpreter.scene.declarations import RELATIONS
from scenelang.stdlib.reference import ReferenceRecord, in_python_terms, lookup, records

# One-line descriptions of primitives and their attributes, for help and completion.

_PHYSICS = {attribute.name: attribute.doc for attribute in primitives.PHYSICS}


def attributes_of(word: str) -> tuple[str, ...]:
    """Return the attributes that the primitive ``word`` reads, those of its geometry first.

    Any other word is a semantic primitive, which is a box.
    """
    attributes = primitives.attributes_read(word)
    has_material = "color" in attributes  # materials apply only to visible geometry
    return (*attributes, *MATERIALS, *_PHYSICS) if has_material else attributes


def attribute_doc(word: str | None, name: str) -> str | None:
    """Return the meaning, range and default of attribute ``name`` in one line; None if ``word`` does not read it.

    ``word`` is a primitive, or None for any of them.
    """
    if word is not None and name not in attributes_of(word):
        return None
    if word is None:
        return primitives.docs_of_attributes().get(name) or MATERIALS.get(name) or _PHYSICS.get(name)
    return primitives.attribute_doc(word, name) or MATERIALS.get(name) or _PHYSICS.get(name)


def attribute_names() -> tuple[str, ...]:
    """Return the names of all attributes read by any primitive."""
    return (*primitives.docs_of_attributes(), *MATERIALS, *_PHYSICS)


# Names that a prompt teaches, by group: what scenes need, by a census of the examples and the corpus. All others work
# as in Scheme, Python or NumPy. A name with a tilde is explained by the first sentence of its doc, with two tildes by
# the first two, where the second one says how copies are oriented: models guess that, and turn chairs away.
TAUGHT: Mapping[str, str] = MappingProxyType({
    "Objects": "call~ union~ union-loop~ transform~",
    "Definitions": "define lambda bind~ scene~ param let let* define-values",
    "Choices": "if cond case when and or",
    "Loops": "for/union for*/union for/list for/sum for/fold for range iota zip",
    "Poses": "translate~ rotate~ scale~ reflect~ look-at~",
    "Combinators": "grid~ ring~~ row~ stack~ mirror~ on-top-of~ align~ attach~ along~ scatter~ jitter~",
    "Boxes": "compute-shape-min~ compute-shape-max compute-shape-center compute-shape-sizes",
    "Colors": "color~ rgb hsv",
    "Random": "random uniform normal randint choice shuffle noise",
    "Solids": "difference~ extrude~ lathe~",
    "Profiles": "circle~ rectangle~ polygon~",
    "Numbers": "+ * - / = < > <= >= // % expt atan min max round clamp lerp sqrt abs sign floor ceiling sin cos tan "
    "asin acos deg even? odd? not",
    "Lists": "list append make-list first last rest length reverse ref take drop map filter fold apply append-map "
    "contains? sort",
    "Vectors": "vector dot cross norm normalize distance linspace sum",
    "Others": "table string-append",
})  # fmt: skip
_BY_NAME = ("Numbers", "Lists", "Vectors")  # groups whose parameters are those of Scheme, Python or NumPy
# Relations that a prompt teaches; the others are for benchmarks and plans, which list all.
_STATED = (
    "on inside touching clear-of distance supported above left-of in-front-of between facing aligned evenly-spaced rows"
    " order symmetric tilt size count has-color"
)
_STATEMENTS = ('(on "cup" "table")', '(facing "chair" "table")', '(clear-of "chair" "chair" :min .1)',
               '(size "table" .75 :axis "y")')  # fmt: skip
# Options that a usage can do without.
_PLAIN_OPTION = re.compile(r' \[:(?!along "[xyz]"|across|around)[^][]*(?:\[[^][]*\][^][]*)*\]')
_CLAUSES = re.compile(r"\(\(x xs\) \.\.\.[^()]*\)")
_SURFACE = ("color", *(attribute.name for attribute in primitives.MATERIALS))
_SHOWN = ("color", "emission", "opacity", "material", "texture")  # a substance stands for the others of a surface
_OMITTED_KEYWORDS = (
    *_SURFACE,
    "segments",
    "stream",
    "size",
    "line-height",
    "fill",
    "slices",
    "limit",
)  # of solids and functions in a prompt


def primer(words: Sequence[str] | None = None, without: Collection[str] = ()) -> str:
    """Return primitives, forms and procedures as short Markdown, for prompts.

    Parameters
    ----------
    words
        Primitives to describe; None for all.
    without
        Names to leave out.
    """
    chosen = tuple(primitives.docs_of_words()) if words is None else words
    return "\n".join([*primitive_lines(chosen), *_names(chosen, without), *_declarations()])


def _declarations() -> Iterator[str]:
    """Yield five lines about declarations, which a program tests itself by."""
    yield "\n## What must hold\n"
    yield (
        f"`(assert-that {' '.join(_STATEMENTS)})` at the end of a program states what must hold of every object of a"
        f" word, and is tested. `:any`, `:min`, `:max`, `:within` and `(not (on ...))` exist. {_UNITS}"
    )
    yield f"Relations: `{' '.join(map(relation_usage, _STATED.split()))}`"


_UNITS = (
    "Lengths are in scene units, angles in degrees; left is -x, front is +z, and the front of an object its own +z."
)


def relation_usage(name: str) -> str:
    """Return how a relation is written, without the options that it can do without.

    >>> relation_usage("order")
    '(order A B ... [:along "x"] [:around C])'
    """
    return _PLAIN_OPTION.sub("", RELATIONS[name].usage)


def python_modelling(with_solids: bool = True) -> str:
    """Return what Python mode has beside the helper API, as Markdown: solids, profiles and declarations.

    Parameters
    ----------
    with_solids
        Whether to describe the solids, which blocks of Minecraft have not.
    """
    groups = taught_groups({group: TAUGHT[group] for group in ("Solids", "Profiles")})
    head = f"More functions, also with `color`, `roughness` and `metallic`. {_PYTHON_UNITS}"
    solids = [head, *python_lines(groups), ""] if with_solids else []
    return "\n".join([*solids, *_python_declarations()])


_PYTHON_UNITS = "Lengths are in scene units, angles in radians; profiles are arrays of points (x, y)."


def _python_declarations() -> Iterator[str]:
    """Yield lines about declarations in Python."""
    stated = ", ".join(map(in_python, _STATEMENTS))
    yield (
        f"`assert_that({stated})` at the end of the program states what must hold of every object of a word, and is"
        f" tested. `any=True`, `min=`, `max=`, `within=` and `not on(...)` exist. {_UNITS}"
    )
    yield f"Relations: `{', '.join(map(python_relation, _STATED.split()))}`"


def python_relation(name: str) -> str:
    """Return how Python mode writes a relation, without the options that it can do without.

    >>> python_relation("clear-of")
    'clear_of(a, b)'
    """
    call = re.sub(r"[\[\]]", "", relation_usage(name)).replace(" ...", "")
    return in_python(re.sub(r"(?<= )[A-Z](?=[ )])", lambda match: match[0].lower(), call))


def in_python(form: str) -> str:
    """Return a form of names, texts and numbers as Python writes the call.

    >>> in_python('(size "table" .75 :axis "y")')
    'size("table", .75, axis="y")'
    """
    name, *words = form[1:-1].split()
    text = re.sub(r":([\w-]+) ", lambda match: f"{python_name(match[1])}=", " ".join(words))
    arguments = [each if each.startswith('"') else each.replace("-", "_") for each in text.split()]
    return f"{python_name(name)}({', '.join(arguments)})"


def python_lines(groups: Mapping[str, Sequence[tuple[ReferenceRecord, int]]]) -> Iterator[str]:
    """Yield the functions of Python mode by group, those that are explained as lines; it has not all names."""
    for group, all_members in groups.items():
        members = [each for each in all_members if python_name(each[0].name) in modelling_helpers()]
        if not members:
            continue
        plain = [_python_usage(record) for record, explained in members if not explained]
        yield f"{group}:" + (f" {', '.join(f'`{usage}`' for usage in plain)}" if plain else "")
        yield from (
            f"- `{_python_usage(record)}`: {in_python_terms(_sentences(record.doc, explained))}"
            for record, explained in members
            if explained
        )


def _python_usage(record: ReferenceRecord) -> str:
    """Return the call of a function without attributes of materials."""
    helper = modelling_helpers()[python_name(record.name)]
    rest = [f"*{python_name(helper.signature.rest.name)}"] if helper.signature.rest else []
    left_out = {python_name(name) for name in _OMITTED_KEYWORDS}
    options = [f"{name}=" for name in helper.keywords if name not in left_out]
    return f"{helper.name}({', '.join([*helper.positional, *rest, *options])})"


def primitive_lines(words: Sequence[str]) -> Iterator[str]:
    """Yield the primitives with their attributes, each attribute explained once, and the materials of all."""
    if words:
        yield "## Primitives\n"
    docs = primitives.docs_of_words()
    explained: set[str] = set()
    for word in words:
        attributes = [name for name in attributes_of(word) if name not in _SURFACE and name not in _PHYSICS]
        yield f'- `(call "{word}"{"".join(f" :{name}" for name in attributes)})`: {docs[word]}'
        for name in attributes:
            doc = attribute_doc(word, name)
            if f"{name} {doc}" not in explained:
                explained.add(f"{name} {doc}")
                yield f"  - `:{name}` {doc}"
    if not set(words) <= set(primitives.block_words()):
        yield "\nMaterials of all primitives and solids:\n"
        yield from (f"- `:{name}` {attribute_doc(None, name)}" for name in _SHOWN)


def taught(without: Collection[str] = ()) -> dict[str, list[tuple[ReferenceRecord, int]]]:
    """Return the names that a prompt teaches by group, and by how many sentences each is explained."""
    return taught_groups(TAUGHT, without)


def taught_groups(
    texts: Mapping[str, str], without: Collection[str] = ()
) -> dict[str, list[tuple[ReferenceRecord, int]]]:
    """Return the names of groups, each with a tilde for every sentence that explains it, as records."""
    groups: dict[str, list[tuple[ReferenceRecord, int]]] = {}
    for group, text in texts.items():
        for item in text.split():
            name, explained = item.rstrip("~"), item.count("~")
            record = lookup(name)
            assert record is not None, name
            if name not in without:
                groups.setdefault(group, []).append((record, explained))
    return groups


def _names(words: Sequence[str], without: Collection[str]) -> Iterator[str]:
    """Yield the names of each group: the plain ones as one list, the explained ones as lines."""
    is_blocks = set(words) <= set(primitives.block_words())
    yield "\n## Names\n"
    yield "`clause` is `(x xs)`, `xs` a list or a number of turns, or `:when test`. What is in brackets is optional.\n"
    left_out = _NOT_FOR_BLOCKS if is_blocks else ()
    yield from group_lines({group: members for group, members in taught(without).items() if group not in left_out})
    yield "Constants: `pi`, `tau`, `none`, `#t`, `#f`"


def group_lines(groups: Mapping[str, Sequence[tuple[ReferenceRecord, int]]]) -> Iterator[str]:
    """Yield the names of each group: the plain ones as one list, the explained ones as lines."""
    for group, members in groups.items():
        if group in _BY_NAME:
            yield f"{group}: `{' '.join(record.name for record, _ in members)}`"
            continue
        plain = ", ".join(_together([_usage(record) for record, explained in members if not explained]))
        yield f"{group}:" + (f" {plain}" if plain else "")
        yield from (
            f"- {_quoted(_usage(record))}: {_sentences(record.doc, explained)}"
            for record, explained in members
            if explained
        )


def _together(usages: Sequence[str]) -> Iterator[str]:
    """Yield calls, those with the same parameters as one call with several names."""
    names: dict[str, list[str]] = {}
    for usage in usages:
        name, _, parameters = usage[1:].partition(" ")
        names.setdefault(parameters if " or (" not in usage else usage, []).append(name)
    for parameters, (first, *others) in names.items():
        usage = parameters if " or (" in parameters else f"({first} {parameters}".replace(" )", ")")
        also = f" (and {' '.join(f'`{name}`' for name in others)})" if others else ""
        yield _quoted(usage) + also


def _quoted(usage: str) -> str:
    """Return the alternatives of a usage as code."""
    return " or ".join(f"`{call}`" for call in re.split(r" or (?=\()", usage))


_NOT_FOR_BLOCKS = ("Colors", "Solids", "Profiles")


def _sentences(doc: str, count: int) -> str:
    """Return the first sentences of a description without "Return", which every second one starts with."""
    text = ". ".join(re.split(r"(?<![ .])\. ", doc.removeprefix("Return "))[:count]).removesuffix(".")
    return text[:1].upper() + text[1:]


def _usage(record: ReferenceRecord) -> str:
    """Return a call without types, defaults of loops, and attributes of materials, which all solids have."""
    call = re.sub(r"::\w+(\[[^\]]*\])?", "", record.signature.partition(" -> ")[0])
    call = _CLAUSES.sub("(clause ...)", call)
    return re.sub(rf" \[:(?:{'|'.join(_OMITTED_KEYWORDS)})\]| \(:stream none\)", "", call)


# Descriptions of names that a program does not define: library names, primitives, attributes, diagnostics.


def description(name: str) -> list[str]:
    """Return the description of ``name`` as lines; empty if it is unknown.

    It is a library name, a primitive (quoted or not), an attribute with its colon, a relation of declarations, or the
    code or name of a diagnostic.
    """
    for lines in (
        _of_library(name),
        _of_primitive(name),
        _of_attribute(name),
        _of_relation(name),
        _of_diagnostic(name),
    ):
        text_lines = list(lines)
        if text_lines:
            return text_lines
    return []


def known_names() -> Iterator[str]:
    """Return all names that have a description, without the codes of diagnostics."""
    attributes = (f":{name}" for name in attribute_names())
    return chain((record.name for record in records()), primitives.words(), attributes, RELATIONS, CODES)


def _of_library(name: str) -> Iterator[str]:
    """Yield the description of a library name."""
    record = lookup(name.removeprefix(STD))
    if record is None:
        return
    yield record.signature
    yield f"  {record.doc}"
    if record.module is not None:
        yield f'  Requires (import "{record.module}").'
    for example in record.examples:
        yield f"  {example.expression} gives {example.value}"


def _of_relation(name: str) -> Iterator[str]:
    """Yield the description of a relation."""
    relation = RELATIONS.get(name)
    if relation is None:
        return
    yield f"(assert-that {relation.usage})"
    yield f"  {relation.doc}"
    yield f"  {relation.example}"


def _of_primitive(name: str) -> Iterator[str]:
    """Yield the description of a primitive."""
    word = name.strip('"')
    docs = primitives.docs_of_words()
    if word not in docs:
        return
    yield f'(call "{word}" {" ".join(f":{attribute}" for attribute in attributes_of(word))})'
    yield f"  {docs[word]}"
    for attribute in attributes_of(word):
        yield f"  :{attribute}  {attribute_doc(word, attribute)}"


def _of_attribute(name: str) -> Iterator[str]:
    """Yield the description of an attribute."""
    attribute = name.removeprefix(":")
    doc = attribute_doc(None, attribute) if name.startswith(":") else None
    if doc is None:
        return
    yield name
    yield f"  {doc}"
    yield f"  read by {', '.join(word for word in primitives.words() if attribute in attributes_of(word))}"


def _of_diagnostic(name: str) -> Iterator[str]:
    """Yield the description of a diagnostic."""
    key = diagnostic_named(name)
    if key is not None:
        yield from explanation(key)


# Task description in the comment at the head of a program.


_TASK = re.compile(r"task\s*:\s*(.+)", re.I)
_SENTENCE = re.compile(r"(?<=[.!?])\s+")


def stated_task(text: str) -> str | None:
    """Return the task that the leading comment of a program states, or None without such a comment.

    It is the line `; task: ...` if there is one, else the first sentence of the comment without its full stop.
    """
    lines = _leading_comment(text)
    for line in lines:
        task = _TASK.match(line)
        if task is not None:
            return task[1].strip()
    paragraph: list[str] = []  # the first one; its sentences may go over several lines
    for line in lines:
        if not line and paragraph:
            break
        paragraph += [line] if line else []
    first = _SENTENCE.split(" ".join(paragraph), maxsplit=1)[0].rstrip(".").strip()
    return first or None


def _leading_comment(text: str) -> list[str]:
    """Return the lines of the comment before the first form, up to a blank line, without their semicolons."""
    lines: list[str] = []
    for line in text.lstrip("\ufeff").splitlines():  # without the byte order mark that some editors write
        stripped = line.strip()
        if stripped.startswith(";"):
            lines.append(stripped.lstrip(";").strip())
        elif stripped or lines:
            break
    return lines
