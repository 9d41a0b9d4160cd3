"""Diagnostics as the protocol has them."""

from __future__ import annotations

from lsprotocol import types as lsp

from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.source import Source
from scenelang.lsp.names import file_of
from scenelang.lsp.texts import range_of, uri_of

_START = lsp.Range(lsp.Position(0, 0), lsp.Position(0, 1))


def shown(diagnostic: Diagnostic, source: Source) -> lsp.Diagnostic:
    """A diagnostic in the text of ``source``; one about an imported file stands at the top and leads there."""
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
        lsp.DiagnosticSeverity.Error if diagnostic.is_error else lsp.DiagnosticSeverity.Warning,
        diagnostic.code,
        source="scenelang",
        tags=[lsp.DiagnosticTag.Unnecessary] if diagnostic.name == "unused" else None,
        related_information=related or None,
    )
