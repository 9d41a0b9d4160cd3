"""Definitions and references of names and words, over the files of a program."""

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
from scenelang.interpreter.expand.scope import ConstantBinding, Macro, PaperForm, Special, Variable, base_name
from scenelang.interpreter.lint.lint import apply_fixes
from scenelang.interpreter.program.interactive import Piece, Version
from scenelang.interpreter.runtime.types import STD, Builtin
from scenelang.interpreter.scene.primitives import is_word
from scenelang.lsp.names import Names, file_of, offset, range_of, shown, uses_of, words_of
from scenelang.session import IMPORT_FORM, Editing, Options, Session, VersionAnalysis

# The texts that are open in the editor, each with its analysis.


class Document:
    """One open text, and what the last analysis found that read it whole."""

    def __init__(self, path: Path, editing: Editing, text: str) -> None:
        self.path = path
        self.editing = editing
        self.source = Source(str(path), text)
        self.analysis: VersionAnalysis | None = None
        self._last: Version | None = None
        self._globals: dict[str, Any] = {}
        self._definitions: dict[Any, Any] = {}

    def change(self, text: str) -> None:
        """A new version of the text, which ``analyse`` has not seen yet."""
        if text != self.source.text:
            self.source = Source(str(self.path), text)
            self.forget()

    def forget(self) -> None:
        """The text, or a file that it imports, has changed."""
        self.analysis = None
        self.__dict__.pop("names", None)

    def analyse(self) -> VersionAnalysis:
        """The analysis of the text as it is."""
        if self.analysis is None:
            self.analysis = self.editing.check(self.source)
            if self.analysis.version is not None:
                self._keep(self.analysis.version, any(d.code < "E2" for d in self.analysis.diagnostics))
        return self.analysis

    def _keep(self, version: Version, unreadable: bool) -> None:
        """Keep what completion needs; of text that does not read, what the last good version had besides."""
        self._last = version
        names = {base_name(symbol): binding for symbol, binding in dict.items(version.file.names)}
        self._globals = {**self._globals, **names} if unreadable else names
        self._definitions = Names(version, self._definitions if unreadable else {}).definitions

    @cached_property
    def names(self) -> Names | None:
        """What the names of the text mean."""
        version = self.analyse().version
        return Names(version, self._definitions) if version is not None else None

    def last_version(self) -> Version | None:
        """The version that was analysed last, perhaps before the last change: completion cannot wait."""
        if self._last is None:
            self.analyse()
        return self._last

    def definitions(self) -> dict[Any, Any]:
        """Definitions of the last version by variable or word; of broken text those of the last good one too."""
        self.last_version()
        return self._definitions

    def globals(self) -> dict[str, Any]:
        """The names of the top level, like ``definitions``."""
        self.last_version()
        return self._globals

    def form_around(self, cursor: int) -> tuple[int, int]:
        """Where the top-level form at a cursor begins and ends, going by the first column: the text may be broken."""
        text = self.source.text
        start = text.rfind("\n(", 0, cursor) + 1
        end = text.find("\n(", cursor)
        return start, len(text) if end < 0 else end


class Documents:
    """All open texts."""

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
class Location:
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


def references(documents: Documents, document: Document, target: Target) -> list[Location]:
    """Every place of a name or word in the files of the workspace that belong to the same programs."""
    assert document.names is not None
    if target.is_local:
        return list(places(document.names, target))
    found: dict[tuple[Path, int], Location] = {}
    for names in connected(documents, document):
        for place in places(names, target):
            found.setdefault((file_of(place.span).resolve(), place.span.start), place)
    return list(found.values())


def places(names: Names, target: Target) -> Iterator[Location]:
    """Where a target stands in one text."""
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


# Renaming of names and words in all files of a workspace, or the reason why not.


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
    if is_word(new):
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
    documents: Documents, path: Path, edits: Edits, target: Target, found: Sequence[Location], new: str
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


def _errors(analysis: VersionAnalysis) -> int:
    return sum(d.is_error for d in analysis.diagnostics)


def _edited(changes: Sequence[tuple[Span, str]]) -> tuple[str, list[int]]:
    """A file's text after edits, and where the new pieces begin in it."""
    text, starts, shift = changes[0][0].source.text, [], 0
    for span, replaced in sorted(changes, key=lambda change: change[0].start):
        text = text[: span.start + shift] + replaced + text[span.end + shift :]
        starts.append(span.start + shift)
        shift += len(replaced) - (span.end - span.start)
    return text, starts


# The outline of a file, and its colours.


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
    """What the file defines at top level, and the definitions in the bodies of these."""
    place = names.version.place
    found = []
    for _, piece in names.version.pieces:
        for datum in piece.form.datums:
            symbol = _symbol(datum, place)
            if symbol is not None:
                symbol.children = list(_inner(datum, place))
                found.append(symbol)
    return found


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


# --- colours -------------------------------------------------------------------------------------------------------

TYPES = ["keyword", "macro", "function", "variable", "class", "property", "number", "enumMember", "string", "type"]
MODIFIERS = ["definition", "defaultLibrary", "readonly"]
LEGEND = lsp.SemanticTokensLegend(TYPES, MODIFIERS)
_DEFINITION, _LIBRARY, _READONLY = 1, 2, 4


def semantic_tokens(names: Names, first: int = 0, last: int | None = None) -> list[int]:
    """The tokens of lines ``first`` to ``last`` (from 0): five numbers each, relative to the one before."""
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
    """Offset in the piece's source, length, type and modifiers of each token, in order; none spans lines."""
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


# Code actions: the fixes of diagnostics, comments that allow a warning, every safe fix at once.


def code_actions(document: Document, uri: str, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    """The actions for a range of the text."""
    source = document.source
    first, last = offset(source, params.range.start), offset(source, params.range.end)
    diagnostics = document.analyse().diagnostics
    wanted = params.context.only
    found: list[lsp.CodeAction] = []
    if wanted is None or any(lsp.CodeActionKind.QuickFix.startswith(kind) for kind in wanted):
        for diagnostic in diagnostics:
            span = diagnostic.span
            if span is not None and span.source is source and span.start <= last and first <= span.end:
                found += _for(diagnostic, source, uri)
    if wanted is None or any(lsp.CodeActionKind.SourceFixAll.startswith(kind) for kind in wanted):
        found += _fix_all(document, uri)
    return found


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
        yield _action(f"Allow `{diagnostic.name}` here", uri, [edit], about)


def _fix_all(document: Document, uri: str) -> Iterator[lsp.CodeAction]:
    text, number = apply_fixes(document.source, document.analyse().diagnostics)
    if number:
        whole = lsp.Range(lsp.Position(0, 0), lsp.Position(document.source.text.count("\n") + 1, 0))
        edit = lsp.WorkspaceEdit({uri: [lsp.TextEdit(whole, text)]})
        yield lsp.CodeAction("Apply every safe fix", lsp.CodeActionKind.SourceFixAll, edit=edit)


def _action(
    title: str, uri: str, edits: list[lsp.TextEdit], about: list[lsp.Diagnostic], preferred: bool = False
) -> lsp.CodeAction:
    edit = lsp.WorkspaceEdit({uri: edits})
    return lsp.CodeAction(title, lsp.CodeActionKind.QuickFix, about, is_preferred=preferred or None, edit=edit)
