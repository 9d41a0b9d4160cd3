"""Code actions: the fixes of diagnostics, comments that allow a warning, every safe fix at once."""

from __future__ import annotations

from collections.abc import Iterator

from lsprotocol import types as lsp

from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.source import Source
from scenelang.interpreter.lint.fixes import apply_fixes
from scenelang.lsp.diagnostics import shown
from scenelang.lsp.documents import Document
from scenelang.lsp.texts import offset, range_of


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
