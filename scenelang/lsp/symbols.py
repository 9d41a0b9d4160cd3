"""The outline of a file, and its colours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from lsprotocol import types as lsp

from scenelang.grammar.datum import Atom, Datum, Handle, Keyword, ListDatum, Source, walk
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.expand.scope import ConstantBinding, Macro, PaperForm, Special, Variable
from scenelang.interpreter.lint.lint import apply_fixes
from scenelang.interpreter.program.interactive import Piece
from scenelang.interpreter.runtime.types import STD, Builtin
from scenelang.lsp.names import Names, offset, range_of, shown, uses_of, words_of
from scenelang.lsp.references import Document

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
