"""Resolution of identifiers and words in a version of a document, and their occurrences."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from lsprotocol import types as lsp

from scenelang.grammar import ast
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, walk
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.reader import lexemes, read
from scenelang.interpreter.checker.program import FileExpander, SourceFile, TopForm
from scenelang.interpreter.compile.analyze import pattern_variables
from scenelang.interpreter.evaluation.interactive import Piece, Version
from scenelang.interpreter.expand.expand import Expander, Use
from scenelang.interpreter.expand.scope import Macro, PaperForm, Scope, Variable, base_name
from scenelang.interpreter.runtime.types import STD
from scenelang.session.session import run_with_room

_TAKES_WORD = frozenset(("call", "bind", "retrieve", "bound?", "scene", "primitive"))
_LIBRARY = Path(__file__).parents[2]


@dataclass(frozen=True, slots=True)
class Word:
    """A string that denotes a word; ``defines``: the word is bound here. A string in a list may have another meaning;
    it is ``sure`` if a form expects a word."""

    span: Span
    text: str
    defines: bool = False
    sure: bool = True


@dataclass(frozen=True, eq=False)
class Names:
    """Names of one version. Positions are in the whole document, or in other files. ``known`` contains definitions of
    an earlier version, for parts of the text that cannot be parsed now."""

    version: Version
    known: Mapping[Any, Any] = field(default_factory=dict)

    def piece_at(self, offset: int) -> tuple[int, Piece] | None:
        """Return the top-level piece that contains an offset (end inclusive), with its start in the source."""
        low, high = 0, len(self.version.pieces)
        while low < high:
            middle = (low + high) // 2
            start, piece = self.version.pieces[middle]
            if start + len(piece.text) < offset:
                low = middle + 1
            else:
                high = middle
        if low == len(self.version.pieces):
            return None
        start, piece = self.version.pieces[low]
        return (start, piece) if start <= offset else None

    def use_at(self, offset: int) -> Use | None:
        """Return the identifier at or just before an offset, with its position in the document."""
        at = self.piece_at(offset)
        if at is None:
            return None
        start, piece = at
        best: Use | None = None
        for use in uses_of(piece.form):
            if use.span.source is piece.source and use.span.start + start <= offset <= use.span.end + start:
                if (
                    best is None
                    or getattr(use.binding, "name", None) == piece.source.text[use.span.start : use.span.end]
                ):
                    best = use  # of the names defined by a record, the one at this position
        return best and Use(self.version.place(best.span), best.binding, best.defines)

    def word_at(self, offset: int) -> Word | None:
        """Return the word of the string at an offset."""
        at = self.piece_at(offset)
        if at is None:
            return None
        start, piece = at
        for word in words_of(piece.form.datums):
            if word.span.start + start <= offset <= word.span.end + start:
                if word.sure or word.text in self.version.program.all_words:
                    return replace(word, span=self.version.place(word.span))
        return None

    def attribute_at(self, offset: int) -> tuple[Span, str, str] | None:
        """Return the attribute of a call at an offset: its position, the called word, its name."""
        at = self.piece_at(offset)
        start, piece = at if at is not None else (0, None)
        for datum in walk(*piece.form.datums) if piece is not None else ():
            items = datum.items if isinstance(datum, ListDatum) else ()
            if len(items) < 3 or not isinstance(items[1], Atom) or type(items[1].value) is not str:
                continue
            if not isinstance(items[0], Atom) or items[0].value not in ("call", "primitive"):
                continue
            for item in items[2:]:
                if isinstance(item, Atom) and isinstance(item.value, Keyword):
                    if item.span.start + start <= offset <= item.span.end + start:
                        return self.version.place(item.span), items[1].value, str(item.value)
        return None

    def uses_of_binding(self, binding: Any) -> Iterator[Use]:
        """Return all positions at which a name refers to ``binding``, without duplicates."""
        seen = set()
        for _, piece in self.version.pieces:
            for use in uses_of(piece.form):
                place = (id(use.span.source), use.span.start)
                if use.binding is binding and place not in seen and use.span.source is piece.source:
                    seen.add(place)
                    yield Use(self.version.place(use.span), binding, use.defines)

    def uses_of_word(self, text: str) -> Iterator[Word]:
        """Return all positions of a word in the document."""
        for _, piece in self.version.pieces:
            if f'"{text}"' in piece.text:
                for word in words_of(piece.form.datums):
                    if word.text == text:
                        yield replace(word, span=self.version.place(word.span))

    def bindings_named(self, name: str) -> list[Any]:
        """Return the bindings that were defined as ``name`` and occur in the document, with or without a prefix."""
        bindings = {}
        for _, piece in self.version.pieces:
            if name in piece.text:
                for use in uses_of(piece.form):
                    binding = use.binding.variable if isinstance(use.binding, PaperForm) else use.binding
                    if isinstance(binding, (Variable, Macro)) and binding.name == name:
                        bindings[id(use.binding)] = use.binding
        return list(bindings.values())

    @cached_property
    def made_by_records(self) -> set[str]:
        """Return the names of records and of the procedures that they define."""
        forms = self.version.program.forms
        made = (form.target for form in forms if type(form) is ast.Define and isinstance(form.target, tuple))
        spans: dict[Any, set[str]] = {}
        for target in made:
            for variable in pattern_variables(target):
                spans.setdefault(variable.span, set()).add(variable.name)
        return {name for names in spans.values() if len(names) > 1 for name in names}

    @cached_property
    def definitions(self) -> dict[Any, Any]:
        """Return the core AST of each top-level name of every file, and of each word (as a string)."""
        definitions: dict[Any, Any] = dict(self.known)
        for form in self.version.program.forms:
            if type(form) is ast.Define and isinstance(form.target, Variable):
                definitions[form.target] = form
            elif type(form) is ast.Bind and type(form.word) is ast.Constant:
                definitions[form.word.value] = form
        return definitions

    def definition_of(self, binding: Any) -> Span | None:
        """Return the origin of a binding, or None if it has no source."""
        if isinstance(binding, PaperForm):
            binding = binding.variable
        span = binding.span if isinstance(binding, (Variable, Macro)) else None
        return self.version.place(span) if span is not None else None


def uses_of(form: TopForm) -> Iterator[Use]:
    """Yield the identifiers of a form that occur in its text."""
    for step in (form.scan, form.expansion):
        if step is not None:
            yield from step.uses


def words_of(datums: tuple[Datum, ...]) -> Iterator[Word]:
    """Yield the strings at which a form expects a word, and those in lists, in document order."""
    stack: list[tuple[Datum, bool]] = [(datum, False) for datum in reversed(datums)]
    while stack:
        datum, listed = stack.pop()
        if isinstance(datum, Atom):
            if listed and type(datum.value) is str:
                yield Word(datum.span, datum.value, sure=False)
            continue
        items = datum.items
        head = items[0].value if items and isinstance(items[0], Atom) else None
        name = str(head) if isinstance(head, Symbol) else ""
        if name in _TAKES_WORD and len(items) > 1 and isinstance(items[1], Atom) and type(items[1].value) is str:
            yield Word(items[1].span, items[1].value, name == "bind")
            items = items[2:]
        quoted = name == "quote" or (listed and name != "list")
        stack += [(item, quoted or (name == "list" and isinstance(item, Atom))) for item in reversed(items)]


def file_of(span: Span) -> Path:
    """Return the file of a span, including the library's files."""
    name = span.source.name
    return _LIBRARY / "stdlib" / name[len(STD) :] if name.startswith(STD) else Path(name).absolute()


# Context of the cursor, determined from the text alone, which also works for malformed text.


@dataclass(frozen=True, slots=True)
class Around:
    """An unclosed list at the cursor: its items before the cursor as texts, nested lists as ``(``."""

    start: int
    items: tuple[str, ...]
    square: bool = False

    @property
    def head(self) -> str:
        return self.items[0] if self.items else ""


@dataclass(frozen=True, slots=True)
class CursorContext:
    """Context of the cursor.

    ``lists`` are the unclosed lists, innermost last. ``token`` is the atom or string being typed, up to the cursor,
    which starts at ``start`` and is not part of any list. ``kind`` is atom, string, comment or gap.
    """

    lists: tuple[Around, ...]
    token: str
    start: int
    kind: str

    @property
    def inner(self) -> Around | None:
        return self.lists[-1] if self.lists else None

    @property
    def position(self) -> int:
        """Index of the item of the innermost list at the cursor; 0 is the head."""
        return len(self.lists[-1].items) if self.lists else 0

    def word(self, list_: Around | None) -> str | None:
        """Return the word of a ``(call "word" ...)``."""
        if list_ is None or len(list_.items) < 2 or list_.head not in ("call", "primitive"):
            return None
        return unquoted(list_.items[1])


def context(text: str, cursor: int, start: int = 0) -> CursorContext:
    """Return the context of a cursor; ``start`` is a preceding position at the top level."""
    open_lists: list[tuple[int, list[str], bool]] = []
    for kind, begin, end in lexemes(text, start, cursor):
        if end >= cursor and kind in ("atom", "string", "other", "comment", "block"):
            closed = kind in ("string", "block") and end == cursor
            if not closed:
                token = "comment" if kind in ("comment", "block") else "atom" if kind == "atom" else "string"
                return CursorContext(_frozen(open_lists), text[begin:cursor], begin, token)
        if kind == "open":
            if open_lists:
                open_lists[-1][1].append("(")
            open_lists.append((begin, [], text[begin] == "["))
        elif kind == "close":
            if open_lists:
                open_lists.pop()
        elif kind in ("atom", "string") and open_lists:
            open_lists[-1][1].append(text[begin:end])
    return CursorContext(_frozen(open_lists), "", cursor, "gap")


def _frozen(lists: Sequence[tuple[int, list[str], bool]]) -> tuple[Around, ...]:
    return tuple(Around(start, tuple(items), square) for start, items, square in lists)


def unquoted(text: str) -> str | None:
    """Return the value of a string literal's text, or None."""
    if len(text) < 2 or not text.startswith('"') or not text.endswith('"'):
        return None
    try:
        value = json.loads(text)
    except ValueError:
        return text[1:-1]
    return value if isinstance(value, str) else None


def closed(text: str, start: int, cursor: int, token: str, name: str) -> str:
    """Return the text from ``start`` with ``name`` in place of the token at the cursor, and all brackets closed."""
    lists = context(text, cursor, start).lists
    closers = "".join("]" if each.square else ")" for each in reversed(lists))
    return f"{text[start : cursor - len(token)]}{name}{closers}"


# Names in scope at the cursor inside a form, determined by expanding the form with a marker at the cursor.


_MARKER = "cursor-stands-here"
_DEPTH = 20_000


class _FoundError(Exception):
    """Raised when the expansion reaches the marker."""

    def __init__(self, scope: Scope) -> None:
        super().__init__()
        self.scope = scope


class _ProbeExpander(FileExpander):
    def unbound(self, atom: Atom, scope: Scope) -> SceneError:
        if base_name(atom.value) == _MARKER:
            raise _FoundError(scope)
        return Expander.unbound(self, atom, scope)


def local_bindings(version: Version, text: str, start: int, end: int, cursor: int, token: str) -> dict[str, Any]:
    """Return the local names at a cursor in the top-level form from ``start`` to ``end``, innermost first."""
    whole = f"{text[start : cursor - len(token)]} {_MARKER} {text[cursor:end]}"
    for probe in (whole, closed(text, start, cursor, token, f" {_MARKER} ")):
        scope = run_with_room(lambda probe=probe: _scope_at_marker(version, probe), _DEPTH)  # type: ignore[misc]
        if scope is not None:
            return dict(_locals(scope, version))
    return {}


def _scope_at_marker(version: Version, text: str) -> Scope | None:
    source = Source("<probe>", text)
    file = SourceFile(source, version.file.scope)
    file.expander = _ProbeExpander(file, version.file.expander.run_macro)
    file.expander.record_names = set(version.file.expander.record_names)
    file.forms = [TopForm(read(source).forms)]
    try:
        file.scan()
        file.finish()
    except _FoundError as found:
        return found.scope
    except (SceneError, RecursionError):
        pass
    return None


def _locals(scope: Scope | None, version: Version) -> Iterator[tuple[str, Any]]:
    seen = set()
    while scope is not None and scope is not version.file.scope:
        for symbol, binding in scope.bindings.items():
            name = base_name(symbol)
            if name not in seen and name != _MARKER:
                seen.add(name)
                yield name, binding
        scope = scope.parent


# Conversion between source offsets and LSP positions: zero-based lines, columns in UTF-16 code units.


def position(source: Source, offset: int) -> lsp.Position:
    line, column = source.position(min(offset, len(source.text)))
    before = source.line(line)[: column - 1]
    return lsp.Position(line - 1, column - 1 if before.isascii() else len(before.encode("utf-16-le")) // 2)


def offset(source: Source, at: lsp.Position) -> int:
    """Return the offset of a position; positions beyond the end are clamped to the end of the line or text."""
    lines = source.text.count("\n") + 1
    if at.line >= lines:
        return len(source.text)
    start, text = source.line_start(at.line + 1), source.line(at.line + 1)
    if text.isascii():
        return start + min(at.character, len(text))
    units = 0
    for index, character in enumerate(text):
        if units >= at.character:
            return start + index
        units += 2 if ord(character) > 0xFFFF else 1
    return start + len(text)


def range_of(span: Span) -> lsp.Range:
    return lsp.Range(position(span.source, span.start), position(span.source, span.end))


def path_of(uri: str) -> Path:
    """Return the file of a URI; for a document without a file, a path that does not exist."""
    parts = urlsplit(uri)
    if parts.scheme != "file":
        return Path("/", "untitled", unquote(parts.path).strip("/") or "scene")
    path = unquote(parts.path)
    return Path(path[1:] if path[2:3] == ":" else path)  # file:///C:/scene


def uri_of(path: Path) -> str:
    return path.as_uri()


# Conversion of diagnostics to the protocol.


_SEVERITIES = {
    "error": lsp.DiagnosticSeverity.Error,
    "warning": lsp.DiagnosticSeverity.Warning,
    "note": lsp.DiagnosticSeverity.Information,
}
_START = lsp.Range(lsp.Position(0, 0), lsp.Position(0, 1))


def shown(diagnostic: Diagnostic, source: Source) -> lsp.Diagnostic:
    """Convert a diagnostic of ``source``; one about an imported file is placed at the top, with a link to that file."""
    message = diagnostic.message if diagnostic.hint is None else f"{diagnostic.message}\nhint: {diagnostic.hint}"
    span = diagnostic.span
    here = span is not None and span.source is source
    related = [
        lsp.DiagnosticRelatedInformation(lsp.Location(uri_of(file_of(note.span)), range_of(note.span)), note.message)
        for note in diagnostic.notes
        if note.span is not None
    ]
    if span is not None and not here:
        place = lsp.Location(uri_of(file_of(span)), range_of(span))
        related.insert(0, lsp.DiagnosticRelatedInformation(place, diagnostic.message))
    return lsp.Diagnostic(
        range_of(span) if here and span is not None else _START,
        message,
        _SEVERITIES[diagnostic.severity],
        diagnostic.code,
        source="scenelang",
        tags=[lsp.DiagnosticTag.Unnecessary] if diagnostic.name == "unused" else None,
        related_information=related or None,
    )
