"""Definitions and references of names and words across the files of a program, and renaming."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp

from scenelang.backends.files import read_regular
from scenelang.grammar.datum import Atom, Datum, Handle, Keyword, ListDatum, Source, Span, walk
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.checker.lint import apply_fixes
from scenelang.interpreter.evaluation.interactive import Piece, Version
from scenelang.interpreter.expand.scope import ConstantBinding, Macro, PaperForm, Special, Variable, base_name
from scenelang.interpreter.runtime.types import STD, Builtin
from scenelang.interpreter.scene.primitives import is_word
from scenelang.lsp.names import Names, file_of, offset, range_of, shown, uses_of, words_of
from scenelang.session.editing import Editing, VersionAnalysis
from scenelang.session.session import IMPORT_FORM, Options, Session

# Open documents with their analysis.


class Document:
    """An open document, and the result of the last complete analysis."""

    def __init__(self, path: Path, editing: Editing, text: str) -> None:
        self.path = path
        self.editing = editing
        self.source = Source(str(path), text)
        self.analysis: VersionAnalysis | None = None
        self._last: Version | None = None
        self._globals: dict[str, Any] = {}
        self._definitions: dict[Any, Any] = {}

    def change(self, text: str) -> None:
        """Set a new version of the text, not yet analyzed."""
        if text != self.source.text:
            self.source = Source(str(self.path), text)
            self.forget()

    def forget(self) -> None:
        """Mark the analysis as outdated after a change of the text or of an imported file."""
        self.analysis = None
        self.__dict__.pop("names", None)

    def analyse(self) -> VersionAnalysis:
        """Return the analysis of the current text."""
        if self.analysis is None:
            self.analysis = self.editing.check(self.source)
            if self.analysis.version is not None:
                self._keep(self.analysis.version, unreadable=any(d.code < "E2" for d in self.analysis.diagnostics))
        return self.analysis

    def _keep(self, version: Version, *, unreadable: bool) -> None:
        """Save data for completion; if the text cannot be parsed, keep definitions of the last valid version."""
        self._last = version
        names = {base_name(symbol): binding for symbol, binding in dict.items(version.file.names)}
        self._globals = {**self._globals, **names} if unreadable else names
        self._definitions = Names(version, self._definitions if unreadable else {}).definitions

    @cached_property
    def names(self) -> Names | None:
        """Resolve the names of the current text."""
        version = self.analyse().version
        return Names(version, self._definitions) if version is not None else None

    def last_version(self) -> Version | None:
        """Last analyzed version, possibly outdated: completion cannot wait for an analysis."""
        if self._last is None:
            self.analyse()
        return self._last

    def definitions(self) -> dict[Any, Any]:
        """Definitions of the last version by variable or word, including those of the last valid version."""
        self.last_version()
        return self._definitions

    def globals(self) -> dict[str, Any]:
        """Names of the top level, like ``definitions``."""
        self.last_version()
        return self._globals

    def form_around(self, cursor: int) -> tuple[int, int]:
        """Return the extent of the top-level form at a cursor, by the first column, since the text may be malformed."""
        text = self.source.text
        start = text.rfind("\n(", 0, cursor) + 1
        end = text.find("\n(", cursor)
        return start, len(text) if end < 0 else end


class Documents:
    """All open documents."""

    def __init__(self) -> None:
        self._open: dict[Path, Document] = {}
        self.texts: dict[Path, str] = {}  # by resolved path
        self.root: Path | None = None

    def open(self, path: Path, text: str) -> Document:
        project = self.root if self.root is not None and path.is_relative_to(self.root) else None
        editing = Editing(Session(Options(project=project)), self.texts)
        document = self._open[path] = Document(path, editing, text)
        self.texts[path.resolve()] = text
        return document

    def change(self, path: Path, text: str) -> Document:
        document = self._open.get(path) or self.open(path, text)
        document.change(text)
        self.texts[path.resolve()] = text
        return document

    def close(self, path: Path) -> None:
        self._open.pop(path, None)
        self.texts.pop(path.resolve(), None)

    def get(self, path: Path) -> Document | None:
        return self._open.get(path)

    def all(self) -> list[Document]:
        return list(self._open.values())


_MAX_FILES = 300
_MAX_SIZE = 2_000_000

Definition = tuple[Path, int]  # file and offset of a name's definition, as its identity across files


@dataclass(frozen=True, slots=True)
class Target:
    """Target of a request: a word, or a name with its ``definition``. ``span`` is its occurrence, ``name`` the name as
    defined; ``made``: it was generated by a record definition of another name."""

    span: Span
    name: str
    word: bool
    definition: Definition | None = None
    is_local: bool = False
    made: bool = False


@dataclass(frozen=True, slots=True)
class Location:
    """Return the range of a target; for a word, the text between the quotes."""

    span: Span
    defines: bool


def target_at(document: Document, cursor: int) -> Target | None:
    """Return the word or name at a cursor."""
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
    """Return the definition of the name, word or imported file at a cursor."""
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
    """Return the start of the file whose name is at the cursor in an ``import``."""
    start, end = document.form_around(cursor)
    match = IMPORT_FORM.search(document.source.text, start, end)
    if match is None or not match.start(1) <= cursor <= match.end(1) + 1:
        return None
    name = match[1] if match[1].startswith(STD) else str((document.path.parent / match[1]).resolve())
    for source in names.version.program.sources:
        if name in (source.name, str(file_of(Span(source, 0, 0)).resolve())):
            return Span(source, 0, 0)
    return None


def references(documents: Documents, document: Document, target: Target) -> list[Location]:
    """Return all references of a name or word in the workspace files of the same programs."""
    assert document.names is not None
    if target.is_local:
        return list(places(document.names, target))
    by_place: dict[tuple[Path, int], Location] = {}
    for names in connected(documents, document):
        for place in places(names, target):
            by_place.setdefault((file_of(place.span).resolve(), place.span.start), place)
    return list(by_place.values())


def places(names: Names, target: Target) -> Iterator[Location]:
    """Return the positions of a target in one document."""
    if target.word:
        for word in names.uses_of_word(target.name):
            yield Location(Span(word.span.source, word.span.start + 1, word.span.end - 1), word.defines)
        return
    for binding in names.bindings_named(target.name):
        place = names.definition_of(binding)
        if place is not None and key_of(place) == target.definition:
            yield from (Location(use.span, use.defines) for use in names.uses_of_binding(binding))


# --- the files of a workspace ----------------------------------------------------------------------------------------


def connected(documents: Documents, document: Document) -> Iterator[Names]:
    """Return the document, the files that it imports, and the workspace files that import any of these."""
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
    paths: list[Path] = []
    for path in root.rglob("*.scene"):
        if not any(part.startswith(".") or part == "node_modules" for part in path.relative_to(root).parts):
            paths.append(path)
        if len(paths) >= _MAX_FILES:
            break
    return sorted(paths)


def _names_of(path: Path, documents: Documents) -> Names | None:
    """Resolve the names of a file that is not open."""
    try:
        if path.stat().st_size > _MAX_SIZE:
            return None
        text = read_regular(path, _MAX_SIZE).decode("utf-8-sig")
    except (OSError, ValueError):
        return None
    version = Editing(session_for(path, documents), documents.texts).check(Source(str(path), text)).version
    return Names(version) if version is not None else None


def session_for(path: Path, documents: Documents) -> Session:
    """Create a session whose programs may import from the workspace."""
    inside = documents.root is not None and path.is_relative_to(documents.root)
    return Session(Options(project=documents.root if inside else None))


# Renaming of names and words across the files of a workspace.


_NAME = re.compile(r"[^\s()\[\]\";'`,:<#0-9][^\s()\[\]\";'`,:]*\Z")

Edits = dict[Path, list[tuple[Span, str]]]


class RefusedError(Exception):
    """Raised if a target cannot be renamed, with a one-line reason."""


def refusal(target: Target) -> str | None:
    """Return the reason why a target cannot be renamed, or None."""
    if target.word:
        return None
    assert target.definition is not None
    if target.definition[0].parent.name == "stdlib":
        return f"`{target.name}` is defined in the standard library"
    if target.made:
        return f"`{target.name}` is generated by `define-record`; rename the record and its uses manually"
    return None


def renamed_part(target: Target) -> Span:
    """Return the editable part of a target's name: without quotes, colon, prefix or annotation."""
    span, text = target.span, target.span.text
    if target.word:
        return Span(span.source, span.start + 1, span.end - 1)
    start = text.partition("::")[0].rfind(target.name)
    return span if start < 0 else Span(span.source, span.start + start, span.start + start + len(target.name))


def renamed(documents: Documents, document: Document, cursor: int, new: str) -> Edits:
    """Return the edits that rename the target at a cursor, by file. Raises RefusedError if the meaning of a program
    would change."""
    target = target_at(document, cursor)
    if target is None:
        raise RefusedError("no name to rename at this position")
    reason = refusal(target) or _unfit(target, new)
    if reason is not None:
        raise RefusedError(reason)
    if target.word:
        _check_word(documents, document, new)
    locations = references(documents, document, target)
    edits: Edits = {}
    for place in locations:
        replaced = _respelled(place.span.text, target, new)
        if replaced is not None:
            edits.setdefault(file_of(place.span), []).append((place.span, replaced))
    for path in edits:
        _check_file(documents, path, edits, target, locations, new)
    return edits


def _unfit(target: Target, new: str) -> str | None:
    if target.word:
        bad = not new or any(c in new for c in '"\\\n\r')
        return "a word must not contain quotes, backslashes or line ends" if bad else None
    return None if _NAME.match(new) else f"`{new}` is not a valid name"


def _check_word(documents: Documents, document: Document, new: str) -> None:
    """Raise RefusedError if a word is already in use."""
    if is_word(new):
        raise RefusedError(f'"{new}" is the word of a primitive')
    for names in connected(documents, document):
        if new in names.version.program.all_words or any(names.uses_of_word(new)):
            raise RefusedError(f'there is a word "{new}" already')


def _respelled(old: str, target: Target, new: str) -> str | None:
    """Return the new spelling, preserving import prefixes, colons of keyword parameters, and annotations."""
    if target.word:
        return new
    body, sign, annotation = old.partition("::")
    if body.startswith(":"):
        return f":{new}{sign}{annotation}" if body[1:] == target.name else None
    if body.endswith(target.name):
        return f"{body[: len(body) - len(target.name)]}{new}{sign}{annotation}"
    return None


def _check_file(
    documents: Documents, path: Path, edits: Edits, target: Target, locations: Sequence[Location], new: str
) -> None:
    """Raise RefusedError if renaming adds errors to a file, or changes the meaning of its names."""
    texts = {other.resolve(): _edited(changes)[0] for other, changes in edits.items()}
    text, moved = _edited(edits[path])
    session = session_for(path, documents)
    before = Editing(session, dict(documents.texts)).check(Source(str(path), edits[path][0][0].source.text))
    after = Editing(session, {**documents.texts, **texts}).check(Source(str(path), text))
    if _errors(after) > _errors(before):
        problem = next(d for d in after.diagnostics if d.is_error)
        raise RefusedError(f"`{new}` cannot be used in {path.name}: {problem.message}")
    if target.word or after.version is None:
        return
    names = Names(after.version)
    place = next((names.definition_of(use.binding) for start in moved if (use := names.use_at(start + 1))), None)
    bindings = [use.binding for start in moved if (use := names.use_at(start + 1)) is not None]
    same = [b for b in bindings if place is not None and (d := names.definition_of(b)) and key_of(d) == key_of(place)]
    stands = {use.span.start for binding in set(map(id, same)) for b in same if id(b) == binding
              for use in names.uses_of_binding(b)}  # fmt: skip
    if len(same) < len(moved) or stands != set(moved):
        raise RefusedError(f"`{new}` is already in use in {path.name}")


def _errors(analysis: VersionAnalysis) -> int:
    return sum(d.is_error for d in analysis.diagnostics)


def _edited(changes: Sequence[tuple[Span, str]]) -> tuple[str, list[int]]:
    """Apply edits to a file's text; returns the text and the offsets of the new pieces."""
    text, starts, shift = changes[0][0].source.text, [], 0
    for span, replaced in sorted(changes, key=lambda change: change[0].start):
        text = text[: span.start + shift] + replaced + text[span.end + shift :]
        starts.append(span.start + shift)
        shift += len(replaced) - (span.end - span.start)
    return text, starts


# Document symbols and semantic tokens.


_SYMBOLS = {
    "bind": lsp.SymbolKind.Class,
    "define": lsp.SymbolKind.Variable,
    "define-values": lsp.SymbolKind.Variable,
    "define-record": lsp.SymbolKind.Struct,
    "define-syntax": lsp.SymbolKind.Operator,
    "define-macro": lsp.SymbolKind.Operator,
    "param": lsp.SymbolKind.Constant,
    "scene": lsp.SymbolKind.Event,
    "import": lsp.SymbolKind.Module,
}


def outline(names: Names) -> list[lsp.DocumentSymbol]:
    """Return the top-level definitions of a file, with the definitions nested in their bodies."""
    place = names.version.place
    symbols = []
    for _, piece in names.version.pieces:
        for datum in piece.form.datums:
            symbol = _symbol(datum, place)
            if symbol is not None:
                symbol.children = list(_inner(datum, place))
                symbols.append(symbol)
    return symbols


def _symbol(datum: Datum, place: Any) -> lsp.DocumentSymbol | None:
    if not isinstance(datum, ListDatum) or len(datum.items) < 2 or not isinstance(datum.items[0], Atom):
        return None
    head, name = str(datum.items[0].value), datum.items[1]
    kind = _SYMBOLS.get(head)
    if kind is None:
        return None
    detail = head
    if isinstance(name, ListDatum) and name.items and isinstance(name.items[0], Atom):
        if head == "define":
            kind = lsp.SymbolKind.Function
        detail = " ".join(name.span.text.split())
        name = name.items[0]
    if not isinstance(name, Atom) or not str(name.value):
        return None
    return lsp.DocumentSymbol(str(name.value), kind, range_of(place(datum.span)), range_of(place(name.span)), detail)


def _inner(datum: Datum, place: Any) -> Iterator[lsp.DocumentSymbol]:
    inner = [part for part in walk(datum) if part is not datum and isinstance(part, ListDatum)]
    for part in sorted(inner, key=lambda part: part.span.start):
        head = part.items[0].value if part.items and isinstance(part.items[0], Atom) else None
        if head in ("define", "bind", "define-record"):
            symbol = _symbol(part, place)
            if symbol is not None:
                yield symbol


# --- semantic tokens -----------------------------------------------------------------------------------------------

TYPES = ["keyword", "macro", "function", "variable", "class", "property", "number", "enumMember", "string", "type"]
MODIFIERS = ["definition", "defaultLibrary", "readonly"]
LEGEND = lsp.SemanticTokensLegend(TYPES, MODIFIERS)
_DEFINITION, _LIBRARY, _READONLY = 1, 2, 4


def semantic_tokens(names: Names, first: int = 0, last: int | None = None) -> list[int]:
    """Return the tokens of lines ``first`` to ``last`` (zero-based) in the LSP's relative encoding of five numbers."""
    source = names.version.source
    data: list[int] = []
    line, column = 0, 0
    for start, piece in names.version.pieces:
        begin = source.position(max(start, 0))[0] - 1
        if last is not None and (begin > last or begin + piece.text.count("\n") < first):
            continue
        for at, length, kind, modifiers in _tokens(piece, names):
            offset = at + start
            row, spot = source.position(offset)
            row, spot = row - 1, spot - 1
            text = source.line(row + 1)
            if not text.isascii():
                units = len(text[: spot + length].encode("utf-16-le")) // 2
                spot = len(text[:spot].encode("utf-16-le")) // 2
                length = units - spot
            data += [row - line, spot - column if row == line else spot, length, kind, modifiers]
            line, column = row, spot
    return data


def _tokens(piece: Piece, names: Names) -> Sequence[tuple[int, int, int, int]]:
    """Yield offset, length, type and modifiers of each token in order; no token spans lines."""
    kinds: dict[int, tuple[int, int, int]] = {}
    for use in uses_of(piece.form):
        if use.span.source is piece.source:
            kind, modifiers = _kind_of(use.binding, names)
            if use.defines:
                modifiers |= _DEFINITION
            kinds[use.span.start] = (use.span.end - use.span.start, kind, modifiers)
    for datum in walk(*piece.form.datums):
        if isinstance(datum, Atom) and datum.span.start not in kinds:
            value = datum.value
            if isinstance(value, (Keyword, Handle)):
                kind = TYPES.index("property" if isinstance(value, Keyword) else "enumMember")
                kinds[datum.span.start] = (datum.span.end - datum.span.start, kind, 0)
    for word in words_of(piece.form.datums):
        if word.sure and "\n" not in word.span.text:
            modifiers = _DEFINITION if word.defines else 0
            kinds[word.span.start] = (word.span.end - word.span.start, TYPES.index("class"), modifiers)
    return [(start, *rest) for start, rest in sorted(kinds.items())]


def _kind_of(binding: Any, names: Names) -> tuple[int, int]:
    if isinstance(binding, (Special, PaperForm)):
        return TYPES.index("keyword"), _LIBRARY
    if isinstance(binding, Macro):
        return TYPES.index("macro"), 0
    if isinstance(binding, Builtin):
        return TYPES.index("function"), _LIBRARY
    if isinstance(binding, ConstantBinding):
        return TYPES.index("variable"), _LIBRARY | _READONLY
    assert isinstance(binding, Variable)
    form = names.definitions.get(binding)
    library = _LIBRARY if binding.span is not None and binding.span.source.name.startswith(STD) else 0
    is_function = library or (form is not None and type(form.value).__name__ == "Lambda")
    return TYPES.index("function" if is_function else "variable"), library


# Code actions: fixes of diagnostics, suppression comments, and applying all safe fixes.


def code_actions(document: Document, uri: str, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    """Return the code actions for a range of the document."""
    source = document.source
    first, last = offset(source, params.range.start), offset(source, params.range.end)
    diagnostics = document.analyse().diagnostics
    kinds = params.context.only
    actions: list[lsp.CodeAction] = []
    if kinds is None or any(lsp.CodeActionKind.QuickFix.startswith(kind) for kind in kinds):
        for diagnostic in diagnostics:
            span = diagnostic.span
            if span is not None and span.source is source and span.start <= last and first <= span.end:
                actions += _for(diagnostic, source, uri)
    if kinds is None or any(lsp.CodeActionKind.SourceFixAll.startswith(kind) for kind in kinds):
        actions += _fix_all(document, uri)
    return actions


def _for(diagnostic: Diagnostic, source: Source, uri: str) -> Iterator[lsp.CodeAction]:
    about = [shown(diagnostic, source)]
    for number, fix in enumerate(diagnostic.fixes):
        if all(edit.span.source is source for edit in fix.edits):
            edits = [lsp.TextEdit(range_of(edit.span), edit.text) for edit in fix.edits]
            yield _action(fix.title, uri, edits, about, preferred=number == 0 and len(diagnostic.fixes) == 1)
    if not diagnostic.is_error and diagnostic.span is not None:
        line = source.position(diagnostic.span.start)[0]
        text = source.line(line)
        indent = text[: len(text) - len(text.lstrip())]
        at = lsp.Position(line - 1, 0)
        edit = lsp.TextEdit(lsp.Range(at, at), f"{indent}; lint: allow {diagnostic.name}\n")
        yield _action(f"Suppress `{diagnostic.name}` here", uri, [edit], about)


def _fix_all(document: Document, uri: str) -> Iterator[lsp.CodeAction]:
    text, number = apply_fixes(document.source, document.analyse().diagnostics)
    if number:
        whole = lsp.Range(lsp.Position(0, 0), lsp.Position(document.source.text.count("\n") + 1, 0))
        edit = lsp.WorkspaceEdit({uri: [lsp.TextEdit(whole, text)]})
        yield lsp.CodeAction("Apply all safe fixes", lsp.CodeActionKind.SourceFixAll, edit=edit)


def _action(
    title: str, uri: str, edits: list[lsp.TextEdit], about: list[lsp.Diagnostic], *, preferred: bool = False
) -> lsp.CodeAction:
    edit = lsp.WorkspaceEdit({uri: edits})
    return lsp.CodeAction(title, lsp.CodeActionKind.QuickFix, about, is_preferred=preferred or None, edit=edit)
