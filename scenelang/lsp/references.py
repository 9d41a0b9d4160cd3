"""Definitions, references and renaming of names and words, over the files of a program."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenelang.editing import Editing
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.scope import Macro, Variable
from scenelang.lsp.documents import Document, Documents
from scenelang.lsp.names import Names, Word, file_of
from scenelang.session import Options, Session

_MOST_FILES = 300
_LARGEST = 2_000_000
_IMPORT = re.compile(r'\(import\s+"([^"\n]*)"')
_NAME = re.compile(r"[^\s()\[\]\";'`,:<#0-9][^\s()\[\]\";'`,]*\Z")


@dataclass(frozen=True, slots=True)
class Target:
    """What is asked about: a word, or the definition of a name by its file and offset. ``span`` is where it stands;
    ``name`` how it was defined."""

    span: Span
    name: str
    word: bool
    definition: tuple[Path, int] | None = None
    is_local: bool = False


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
    local = isinstance(use.binding, Variable) and not use.binding.is_global
    return Target(use.span, use.binding.name, False, _key(names, use.binding, place), local)


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
    match = _IMPORT.search(document.source.text, start, end)
    if match is None or not match.start(1) <= cursor <= match.end(1) + 1:
        return None
    wanted = match[1] if match[1].startswith("std/") else str((document.path.parent / match[1]).resolve())
    for source in names.version.program.sources:
        if wanted in (source.name, str(file_of(Span(source, 0, 0)).resolve())):
            return Span(source, 0, 0)
    return None


def _key(names: Names, binding: Any, place: Span) -> tuple[Path, int]:
    """The same for a name in whatever file it is met."""
    if isinstance(binding, Macro):  # its span is the whole definition
        for use in names.uses_of_binding(binding):
            if use.defines:
                return file_of(use.span).resolve(), use.span.start
    return file_of(place).resolve(), place.start


# --- references ------------------------------------------------------------------------------------------------------


def references(documents: Documents, document: Document, target: Target) -> list[Span]:
    """Every place of a name or word in the files of the workspace that belong to the same programs."""
    if target.is_local:
        assert document.names is not None
        return list(places(document.names, target))
    found: dict[tuple[str, int], Span] = {}
    for names in _connected(documents, document, target):
        for span in places(names, target):
            found.setdefault((str(file_of(span)), span.start), span)
    return list(found.values())


def places(names: Names, target: Target) -> Iterator[Span]:
    """Where a name or word stands in one text; of a word what is between the quotes."""
    if target.word:
        yield from (_inside(word) for word in names.uses_of_word(target.name))
        return
    bindings = {}
    for _, piece in names.version.pieces:
        if target.name in piece.text:
            for step in (piece.form.scan, piece.form.expansion):
                for use in step.uses if step is not None else ():
                    bindings[id(use.binding)] = use.binding
    for binding in bindings.values():
        place = names.definition_of(binding)
        if place is not None and _key(names, binding, place) == target.definition and binding.name == target.name:
            yield from (use.span for use in names.uses_of_binding(binding))


def _inside(word: Word) -> Span:
    """The text between the quotes."""
    return Span(word.span.source, word.span.start + 1, word.span.end - 1)


def _connected(documents: Documents, document: Document, target: Target) -> Iterator[Names]:
    """The files that the document imports, and those of the workspace that import it or a file that it imports."""
    assert document.names is not None
    yield document.names
    session = document.editing.session
    mine = {file_of(Span(source, 0, 0)).resolve() for source in document.names.version.program.sources}
    seen = {document.path.resolve()}
    for path in [*sorted(mine), *_workspace_files(documents, document)]:
        resolved = path.resolve()
        if resolved in seen or "scenelang/stdlib" in path.as_posix() or path.suffix != ".scene":
            continue
        seen.add(resolved)
        opened = documents.get(path)
        names = opened.names if opened is not None else _names_of(path, documents, session)
        if names is None:
            continue
        theirs = {file_of(Span(source, 0, 0)).resolve() for source in names.version.program.sources}
        if resolved in mine or theirs & mine:
            yield names


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


def _names_of(path: Path, documents: Documents, session: Session) -> Names | None:
    try:
        if path.stat().st_size > _LARGEST:
            return None
        text = path.read_text("utf-8")
    except (OSError, ValueError):
        return None
    project = documents.root if documents.root is not None and path.is_relative_to(documents.root) else None
    editing = Editing(Session(Options(project=project)), documents.texts)
    version = editing.check(Source(str(path), text)).version
    return Names(version) if version is not None else None


# --- renaming --------------------------------------------------------------------------------------------------------


def is_definition(target: Target, span: Span) -> bool:
    """Whether a reference is where the target is defined."""
    if target.word:
        return bool(re.search(r"\(bind\s+\"$", span.source.text[: span.start][-40:]))
    return (file_of(span).resolve(), span.start) == target.definition


def renamed_part(target: Target) -> Span:
    """What a person edits to rename the target: no quotes, colon or annotation."""
    span, text = target.span, target.span.text
    if target.word:
        return Span(span.source, span.start + 1, span.end - 1)
    start = text.find(target.name)
    return span if start < 0 else Span(span.source, span.start + start, span.start + start + len(target.name))


class RenameRefusedError(Exception):
    """Why something cannot be renamed, in one line."""


def renaming(documents: Documents, document: Document, cursor: int, new: str) -> dict[Path, list[tuple[Span, str]]]:
    """The edits that rename what stands at a cursor, by file. Raises RenameRefusedError."""
    target = target_at(document, cursor)
    if target is None:
        raise RenameRefusedError("nothing here has a name that could be changed")
    if not target.word and target.definition is not None and "stdlib" in target.definition[0].parts[-2:]:
        raise RenameRefusedError(f"`{target.name}` belongs to the standard library")
    if not target.word and not _NAME.match(new):
        raise RenameRefusedError(f"`{new}` is no name")
    if target.word and ('"' in new or "\\" in new or "\n" in new or not new):
        raise RenameRefusedError("a word may not hold quotes, backslashes or line ends")
    edits: dict[Path, list[tuple[Span, str]]] = {}
    for span in references(documents, document, target):
        old = span.text
        replaced = _renamed(old, target, new)
        if replaced is not None:
            edits.setdefault(file_of(span), []).append((span, replaced))
    _check_renaming(document, target, edits, new)
    return edits


def _renamed(old: str, target: Target, new: str) -> str | None:
    """The new spelling: prefixes of imports, colons of keyword parameters and annotations stay."""
    if target.word:
        return new
    body, sign, annotation = old.partition("::")
    if body.startswith(":"):
        return f":{new}{sign}{annotation}" if body[1:] == target.name else None
    if body.endswith(target.name):
        return f"{body[: len(body) - len(target.name)]}{new}{sign}{annotation}"
    return None


def _check_renaming(document: Document, target: Target, edits: dict[Path, list[tuple[Span, str]]], new: str) -> None:
    """Refuse a renaming after which the names of the document would mean something else."""
    mine = sorted(edits.get(document.path, ()), key=lambda edit: edit[0].start)
    text, moved, shift = document.source.text, [], 0
    for span, replaced in mine:
        text = text[: span.start + shift] + replaced + text[span.end + shift :]
        moved.append(span.start + shift)
        shift += len(replaced) - (span.end - span.start)
    after = Editing(document.editing.session, {}).check(Source(document.source.name, text))
    before = document.analyse()
    if sum(d.is_error for d in after.diagnostics) > sum(d.is_error for d in before.diagnostics):
        problem = next(d for d in after.diagnostics if d.is_error)
        if problem.name not in ("file", "unbound") or len(edits) == 1:
            raise RenameRefusedError(f"`{new}` cannot stand there: {problem.message}")
    if after.version is None or not moved or target.word:
        return
    names = Names(after.version)
    use = names.use_at(moved[0] + 1)
    places = sorted(other.span.start for other in names.uses_of_binding(use.binding)) if use is not None else []
    if places != moved and places != sorted(set(moved)):
        raise RenameRefusedError(f"`{new}` has a meaning there already")
