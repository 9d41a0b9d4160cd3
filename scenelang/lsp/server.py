"""Language server: one handler per protocol request. Texts are analyzed shortly after the last change."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

from scenelang.formatting import indents_of
from scenelang.grammar.datum import Span
from scenelang.grammar.formatter import UnreadableError, edit_between, format_range, format_text
from scenelang.lsp import completion, decorations, references
from scenelang.lsp.completion import of_attribute, of_binding, of_word
from scenelang.lsp.names import file_of, offset, path_of, range_of, shown, uri_of
from scenelang.lsp.references import Document, Documents

PAUSE = 0.03  # debounce delay of the analysis, in seconds


class Server(LanguageServer):
    """The language server and the open documents."""

    def __init__(self, version: str) -> None:
        super().__init__("scenelang", version)
        self.documents = Documents()
        self.shows_kinds = False  # whether inlay hints have the inferred kinds of definitions
        self.completed: Document | None = None  # document of the last completion, to resolve its items
        self._uris: dict[Path, str] = {}  # URIs of open documents, as sent by the editor
        self._waiting: dict[str, asyncio.TimerHandle] = {}

    def opened(self, uri: str) -> None:
        self._uris[path_of(uri)] = uri
        self.changed(uri)

    def document(self, uri: str) -> Document | None:
        """Return the current state of an open document, or None."""
        path = path_of(uri)
        if path not in self._uris:
            return None
        return self.documents.change(path, self.workspace.get_text_document(uri).source)

    def uri(self, path: Path) -> str:
        """Return the editor's URI of an open file."""
        return self._uris.get(path) or uri_of(path)

    def changed(self, uri: str) -> None:
        """Schedule the analysis of a document, unless it changes again before."""
        waiting = self._waiting.pop(uri, None)
        if waiting is not None:
            waiting.cancel()
        self._waiting[uri] = asyncio.get_running_loop().call_later(PAUSE, self._publish_all, uri)

    def _publish_all(self, uri: str) -> None:
        """Publish the diagnostics of a document, then those of the documents that import it."""
        self._waiting.pop(uri, None)
        self.publish(uri)
        path = path_of(uri).resolve()
        for document in self.documents.all():
            version = document.analysis.version if document.analysis is not None else None
            imported = version.program.sources[1:] if version is not None else ()
            if document.path.resolve() != path and any(file_of(Span(s, 0, 0)).resolve() == path for s in imported):
                document.forget()
                self.publish(self.uri(document.path))

    def publish(self, uri: str) -> None:
        document = self.document(uri)
        if document is not None:
            found = [shown(diagnostic, document.source) for diagnostic in document.analyse().diagnostics]
            version = self.workspace.get_text_document(uri).version
            self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, found, version))

    def closed(self, uri: str) -> None:
        waiting = self._waiting.pop(uri, None)
        if waiting is not None:
            waiting.cancel()
        self._uris.pop(path_of(uri), None)
        self.documents.close(path_of(uri))
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))

    def answers(self, feature: str, options: Any = None) -> Callable[[Handler], Handler]:
        """Register a handler of requests about one document; requests about documents that are not open return None."""

        def register(handler: Handler) -> Handler:
            @self.feature(feature, options)
            def answer(params: Any) -> Any:
                document = self.document(params.text_document.uri)
                return None if document is None else handler(document, params)

            return handler

        return register


Handler = Callable[[Document, Any], Any]


def build_server(version: str) -> Server:
    """Create the server with all handlers."""
    server = Server(version)
    for register in (_lifecycle, _reading, _navigation, _changing):
        register(server)
    return server


def _cursor(document: Document, position: lsp.Position) -> int:
    return offset(document.source, position)


def _lifecycle(server: Server) -> None:
    @server.feature(lsp.INITIALIZE)
    def initialize(params: lsp.InitializeParams) -> None:
        options = params.initialization_options
        server.shows_kinds = isinstance(options, dict) and options.get("inlayHintsOfKinds") is True

    @server.feature(lsp.INITIALIZED)
    def initialized(_: lsp.InitializedParams) -> None:
        root = server.workspace.root_path
        server.documents.root = Path(root).resolve() if root else None

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    def did_open(params: lsp.DidOpenTextDocumentParams) -> None:
        server.opened(params.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def did_change(params: lsp.DidChangeTextDocumentParams) -> None:
        server.changed(params.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
    def did_save(params: lsp.DidSaveTextDocumentParams) -> None:
        server.changed(params.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def did_close(params: lsp.DidCloseTextDocumentParams) -> None:
        server.closed(params.text_document.uri)


def _reading(server: Server) -> None:
    @server.answers(lsp.TEXT_DOCUMENT_HOVER)
    def hover(document: Document, params: lsp.HoverParams) -> lsp.Hover | None:
        cursor, names = _cursor(document, params.position), document.names
        if names is None:
            return None
        word, use = names.word_at(cursor), names.use_at(cursor)
        if word is not None:
            return _hover(of_word(names, word.text), word.span)
        if use is not None:
            return _hover(of_binding(names, use.binding, use.span.text), use.span)
        attribute = names.attribute_at(cursor)
        text = of_attribute(names, *attribute[1:]) if attribute is not None else None
        return _hover(text, attribute[0]) if text is not None and attribute is not None else None

    @server.answers(
        lsp.TEXT_DOCUMENT_COMPLETION,
        lsp.CompletionOptions(trigger_characters=["(", '"', ":", "<"], resolve_provider=True),
    )
    def complete(document: Document, params: lsp.CompletionParams) -> lsp.CompletionList:
        server.completed = document
        return completion.complete(document, _cursor(document, params.position))

    @server.feature(lsp.COMPLETION_ITEM_RESOLVE)
    def resolve(item: lsp.CompletionItem) -> lsp.CompletionItem:
        return completion.resolve(server.completed, item)

    @server.answers(
        lsp.TEXT_DOCUMENT_SIGNATURE_HELP,
        lsp.SignatureHelpOptions(trigger_characters=["(", " "], retrigger_characters=[":", " "]),
    )
    def signature_help(document: Document, params: lsp.SignatureHelpParams) -> lsp.SignatureHelp | None:
        return completion.signature_help(document, _cursor(document, params.position))

    @server.answers(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def document_symbol(document: Document, params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        return references.outline(document.names) if document.names is not None else []

    @server.answers(lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, references.LEGEND)
    def tokens(document: Document, params: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
        return lsp.SemanticTokens(references.semantic_tokens(document.names) if document.names is not None else [])

    @server.answers(lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE, references.LEGEND)
    def range_tokens(document: Document, params: lsp.SemanticTokensRangeParams) -> lsp.SemanticTokens:
        names, lines = document.names, (params.range.start.line, params.range.end.line)
        return lsp.SemanticTokens(references.semantic_tokens(names, *lines) if names is not None else [])

    @server.answers(lsp.TEXT_DOCUMENT_INLAY_HINT)
    def inlay_hints(document: Document, params: lsp.InlayHintParams) -> list[lsp.InlayHint]:
        first, last = params.range.start.line, params.range.end.line
        return decorations.inlay_hints(document, first, last, server.shows_kinds)

    @server.answers(lsp.TEXT_DOCUMENT_DOCUMENT_COLOR)
    def document_colors(document: Document, params: lsp.DocumentColorParams) -> list[lsp.ColorInformation]:
        return decorations.colors(document)

    @server.answers(lsp.TEXT_DOCUMENT_COLOR_PRESENTATION)
    def color_presentation(document: Document, params: lsp.ColorPresentationParams) -> list[lsp.ColorPresentation]:
        return decorations.color_presentations(document.source, params.color, params.range)

    @server.answers(lsp.TEXT_DOCUMENT_FOLDING_RANGE)
    def folding_ranges(document: Document, params: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
        return decorations.folding_ranges(document)


def _hover(text: str, span: Span) -> lsp.Hover:
    return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, text), range_of(span))


def _navigation(server: Server) -> None:
    def target_at(document: Document, params: Any) -> references.Target | None:
        return references.target_at(document, _cursor(document, params.position))

    @server.answers(lsp.TEXT_DOCUMENT_DEFINITION)
    def definition(document: Document, params: lsp.DefinitionParams) -> list[lsp.Location]:
        return [_location(server, span) for span in references.definition(document, _cursor(document, params.position))]

    @server.answers(lsp.TEXT_DOCUMENT_REFERENCES)
    def all_references(document: Document, params: lsp.ReferenceParams) -> list[lsp.Location]:
        target = target_at(document, params)
        if target is None:
            return []
        found = references.references(server.documents, document, target)
        with_definition = params.context.include_declaration
        return [_location(server, place.span) for place in found if with_definition or not place.defines]

    @server.answers(lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
    def highlight(document: Document, params: lsp.DocumentHighlightParams) -> list[lsp.DocumentHighlight]:
        target = target_at(document, params)
        if target is None or document.names is None:
            return []
        return [lsp.DocumentHighlight(range_of(place.span)) for place in references.places(document.names, target)]

    @server.answers(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
    def prepare_rename(document: Document, params: lsp.PrepareRenameParams) -> lsp.Range | None:
        target = target_at(document, params)
        if target is None or references.refusal(target) is not None:
            return None
        return range_of(references.renamed_part(target))

    @server.answers(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
    def rename(document: Document, params: lsp.RenameParams) -> lsp.WorkspaceEdit:
        try:
            edits = references.renamed(server.documents, document, _cursor(document, params.position), params.new_name)
        except references.RefusedError as refused:
            raise JsonRpcInvalidParams(str(refused)) from None
        return lsp.WorkspaceEdit(
            {server.uri(path): [lsp.TextEdit(range_of(span), text) for span, text in changes]
             for path, changes in edits.items()}
        )  # fmt: skip


def _location(server: Server, span: Span) -> lsp.Location:
    return lsp.Location(server.uri(file_of(span)), range_of(span))


def _changing(server: Server) -> None:
    @server.answers(lsp.TEXT_DOCUMENT_FORMATTING)
    def formatting(document: Document, params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit] | None:
        return _formatted(document, format_text)

    @server.answers(lsp.TEXT_DOCUMENT_RANGE_FORMATTING)
    def range_formatting(document: Document, params: lsp.DocumentRangeFormattingParams) -> list[lsp.TextEdit] | None:
        first, last = params.range.start.line + 1, params.range.end.line + 1
        return _formatted(document, lambda text, indents: format_range(text, first, last, indents))

    @server.answers(
        lsp.TEXT_DOCUMENT_CODE_ACTION,
        lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix, lsp.CodeActionKind.SourceFixAll]),
    )
    def code_action(document: Document, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        return references.code_actions(document, params.text_document.uri, params)


def _formatted(document: Document, format_: Callable[[str, Any], str]) -> list[lsp.TextEdit] | None:
    """Return the edit that formats a document; none if it cannot be parsed."""
    source = document.source
    try:
        after = format_(source.text, indents_of(source.text, document.path.parent))
    except UnreadableError:
        return None
    edit = edit_between(source.text, after)
    if edit is None:
        return []
    changed = lsp.Range(lsp.Position(edit.first - 1, 0), lsp.Position(edit.last, 0))
    return [lsp.TextEdit(changed, edit.text)]


def serve(version: str) -> None:
    """Serve one editor over standard input and output until it disconnects."""
    logging.getLogger("pygls").setLevel(logging.CRITICAL)
    build_server(version).start_io()
