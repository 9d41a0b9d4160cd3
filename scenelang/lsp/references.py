"""Definitions and references of names and words, over the files of a program."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from scenelang.backends.files import read_regular
from scenelang.editing import Editing
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.library import STD
from scenelang.interpreter.scope import PaperForm, Variable
from scenelang.lsp.documents import Document, Documents
from scenelang.lsp.names import Names, file_of
from scenelang.session import IMPORT_FORM, Options, Session

_MOST_FILES = 300
_LARGEST = 2_000_000

Definition = tuple[Path, int]  # the file and the offset of what defines a name: the same wherever the name is met


@dataclass(frozen=True, slots=True)
class Target:
    """What is asked about: a word, or a name by its ``definition``. ``span`` is where it stands, ``name`` how it was
    defined; ``made``: a record's definition made it, whose own name is another."""

    span: Span
    name: str
    word: bool
    definition: Definition | None = None
    is_local: bool = False
    made: bool = False


@dataclass(frozen=True, slots=True)
class Place:
    """Where a target stands; of a word what is between the quotes."""

    span: Span
    defines: bool


def target_at(document: Document, cursor: int) -> Target | None:
    """The word or name at a cursor."""
    names = document.names
    if names is None:
        return None
    word = names.word_at(cursor)
    if word is not None:
        return Target(word.span, word.text, True)
    use = names.use_at(cursor)
    place = names.definition_of(use.binding) if use is not None else None
    if use is None or place is None:
        return None
    binding = use.binding.variable if isinstance(use.binding, PaperForm) else use.binding
    local = isinstance(binding, Variable) and not binding.is_global
    made = isinstance(binding, Variable) and binding.name in names.made_by_records
    return Target(use.span, binding.name, False, key_of(place), local, made)


def key_of(place: Span) -> Definition:
    return file_of(place).resolve(), place.start


def definition(document: Document, cursor: int) -> list[Span]:
    """Where the name, word or imported file at a cursor is defined."""
    names = document.names
    if names is None:
        return []
    imported = _import_at(document, names, cursor)
    if imported is not None:
        return [imported]
    word = names.word_at(cursor)
    if word is not None:
        span = names.version.program.all_words.get(word.text)
        return [names.version.place(span)] if span is not None else []
    use = names.use_at(cursor)
    place = names.definition_of(use.binding) if use is not None else None
    return [place] if place is not None else []


def _import_at(document: Document, names: Names, cursor: int) -> Span | None:
    """The beginning of the file whose name stands at a cursor in an ``import``."""
    start, end = document.form_around(cursor)
    match = IMPORT_FORM.search(document.source.text, start, end)
    if match is None or not match.start(1) <= cursor <= match.end(1) + 1:
        return None
    wanted = match[1] if match[1].startswith(STD) else str((document.path.parent / match[1]).resolve())
    for source in names.version.program.sources:
        if wanted in (source.name, str(file_of(Span(source, 0, 0)).resolve())):
            return Span(source, 0, 0)
    return None


def references(documents: Documents, document: Document, target: Target) -> list[Place]:
    """Every place of a name or word in the files of the workspace that belong to the same programs."""
    assert document.names is not None
    if target.is_local:
        return list(places(document.names, target))
    found: dict[tuple[Path, int], Place] = {}
    for names in connected(documents, document):
        for place in places(names, target):
            found.setdefault((file_of(place.span).resolve(), place.span.start), place)
    return list(found.values())


def places(names: Names, target: Target) -> Iterator[Place]:
    """Where a target stands in one text."""
    if target.word:
        for word in names.uses_of_word(target.name):
            yield Place(Span(word.span.source, word.span.start + 1, word.span.end - 1), word.defines)
        return
    for binding in names.bindings_named(target.name):
        place = names.definition_of(binding)
        if place is not None and key_of(place) == target.definition:
            yield from (Place(use.span, use.defines) for use in names.uses_of_binding(binding))


# --- the files of a workspace ----------------------------------------------------------------------------------------


def connected(documents: Documents, document: Document) -> Iterator[Names]:
    """The text itself, the files that it imports, and those of the workspace that import one of these."""
    assert document.names is not None
    yield document.names
    mine = _files(document.names)
    seen = {document.path.resolve()}
    for path in [*sorted(mine), *_workspace_files(documents, document)]:
        resolved = path.resolve()
        if resolved in seen or path.suffix != ".scene" or resolved.parent.name == "stdlib":
            continue
        seen.add(resolved)
        opened = documents.get(path)
        names = opened.names if opened is not None else _names_of(path, documents)
        if names is not None and (resolved in mine or _files(names) & mine):
            yield names


def _files(names: Names) -> set[Path]:
    return {file_of(Span(source, 0, 0)).resolve() for source in names.version.program.sources}


def _workspace_files(documents: Documents, document: Document) -> list[Path]:
    root = documents.root or document.path.parent
    if not root.is_dir():
        return []
    found: list[Path] = []
    for path in root.rglob("*.scene"):
        if not any(part.startswith(".") or part == "node_modules" for part in path.relative_to(root).parts):
            found.append(path)
        if len(found) >= _MOST_FILES:
            break
    return sorted(found)


def _names_of(path: Path, documents: Documents) -> Names | None:
    """The names of a file that is not open."""
    try:
        if path.stat().st_size > _LARGEST:
            return None
        text = read_regular(path, _LARGEST).decode("utf-8-sig")
    except (OSError, ValueError):
        return None
    version = Editing(session_for(path, documents), documents.texts).check(Source(str(path), text)).version
    return Names(version) if version is not None else None


def session_for(path: Path, documents: Documents) -> Session:
    """A session whose programs may import from the workspace."""
    inside = documents.root is not None and path.is_relative_to(documents.root)
    return Session(Options(project=documents.root if inside else None))
