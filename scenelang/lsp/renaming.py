"""Renaming of names and words in all files of a workspace, or the reason why not."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from scenelang.editing import Analysis, Editing
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.shapes import WORDS
from scenelang.lsp.documents import Document, Documents
from scenelang.lsp.names import Names, file_of
from scenelang.lsp.references import Place, Target, connected, key_of, references, session_for, target_at

_NAME = re.compile(r"[^\s()\[\]\";'`,:<#0-9][^\s()\[\]\";'`,:]*\Z")

Edits = dict[Path, list[tuple[Span, str]]]


class RefusedError(Exception):
    """Why something cannot be renamed, in one line."""


def refusal(target: Target) -> str | None:
    """Why a target has a name that cannot be changed; None when it can."""
    if target.word:
        return None
    assert target.definition is not None
    if target.definition[0].parent.name == "stdlib":
        return f"`{target.name}` belongs to the standard library"
    if target.made:
        return f"`{target.name}` is named after its record; change `define-record` and its uses by hand"
    return None


def renamed_part(target: Target) -> Span:
    """What a person edits to rename the target: no quotes, colon, prefix or annotation."""
    span, text = target.span, target.span.text
    if target.word:
        return Span(span.source, span.start + 1, span.end - 1)
    start = text.partition("::")[0].rfind(target.name)
    return span if start < 0 else Span(span.source, span.start + start, span.start + start + len(target.name))


def renamed(documents: Documents, document: Document, cursor: int, new: str) -> Edits:
    """The edits that rename what stands at a cursor, by file. Raises RefusedError where a program would mean something
    else, or nothing, afterwards."""
    target = target_at(document, cursor)
    if target is None:
        raise RefusedError("nothing here has a name that could be changed")
    reason = refusal(target) or _unfit(target, new)
    if reason is not None:
        raise RefusedError(reason)
    if target.word:
        _check_word(documents, document, new)
    found = references(documents, document, target)
    edits: Edits = {}
    for place in found:
        replaced = _respelled(place.span.text, target, new)
        if replaced is not None:
            edits.setdefault(file_of(place.span), []).append((place.span, replaced))
    for path in edits:
        _check_file(documents, path, edits, target, found, new)
    return edits


def _unfit(target: Target, new: str) -> str | None:
    if target.word:
        bad = not new or any(c in new for c in '"\\\n\r')
        return "a word may not hold quotes, backslashes or line ends" if bad else None
    return None if _NAME.match(new) else f"`{new}` is no name"


def _check_word(documents: Documents, document: Document, new: str) -> None:
    """Refuse a word that something else has already."""
    if new in WORDS:
        raise RefusedError(f'"{new}" is the word of a primitive')
    for names in connected(documents, document):
        if new in names.version.program.all_words or any(names.uses_of_word(new)):
            raise RefusedError(f'there is a word "{new}" already')


def _respelled(old: str, target: Target, new: str) -> str | None:
    """The new spelling: prefixes of imports, colons of keyword parameters and annotations stay."""
    if target.word:
        return new
    body, sign, annotation = old.partition("::")
    if body.startswith(":"):
        return f":{new}{sign}{annotation}" if body[1:] == target.name else None
    if body.endswith(target.name):
        return f"{body[: len(body) - len(target.name)]}{new}{sign}{annotation}"
    return None


def _check_file(
    documents: Documents, path: Path, edits: Edits, target: Target, found: Sequence[Place], new: str
) -> None:
    """Refuse a renaming after which a file has more errors, or its names mean something else."""
    texts = {other.resolve(): _edited(changes)[0] for other, changes in edits.items()}
    text, moved = _edited(edits[path])
    session = session_for(path, documents)
    before = Editing(session, dict(documents.texts)).check(Source(str(path), edits[path][0][0].source.text))
    after = Editing(session, {**documents.texts, **texts}).check(Source(str(path), text))
    if _errors(after) > _errors(before):
        problem = next(d for d in after.diagnostics if d.is_error)
        raise RefusedError(f"`{new}` cannot stand in {path.name}: {problem.message}")
    if target.word or after.version is None:
        return
    names = Names(after.version)
    place = next((names.definition_of(use.binding) for start in moved if (use := names.use_at(start + 1))), None)
    bindings = [use.binding for start in moved if (use := names.use_at(start + 1)) is not None]
    same = [b for b in bindings if place is not None and (d := names.definition_of(b)) and key_of(d) == key_of(place)]
    stands = {use.span.start for binding in set(map(id, same)) for b in same if id(b) == binding
              for use in names.uses_of_binding(b)}  # fmt: skip
    if len(same) < len(moved) or stands != set(moved):
        raise RefusedError(f"`{new}` has a meaning in {path.name} already")


def _errors(analysis: Analysis) -> int:
    return sum(d.is_error for d in analysis.diagnostics)


def _edited(changes: Sequence[tuple[Span, str]]) -> tuple[str, list[int]]:
    """A file's text after edits, and where the new pieces begin in it."""
    text, starts, shift = changes[0][0].source.text, [], 0
    for span, replaced in sorted(changes, key=lambda change: change[0].start):
        text = text[: span.start + shift] + replaced + text[span.end + shift :]
        starts.append(span.start + shift)
        shift += len(replaced) - (span.end - span.start)
    return text, starts
