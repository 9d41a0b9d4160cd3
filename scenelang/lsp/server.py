"""Language server: one handler per protocol request. Texts are analyzed shortly after the last change."""

from __future__ import annotations

import asyncio
import logging
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

from scenelang.grammar import ast
from scenelang.grammar.datum import Source, Span
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.formatter import UnreadableError, edit_between, format_range, format_text
from scenelang.grammar.reader import lexemes
from scenelang.interpreter.compile.analyze import walk
from scenelang.interpreter.compile.kinds import ANY, Kind, describe
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.scene.primitives.base import encoded, linear
from scenelang.interpreter.values.values import Keyword
from scenelang.lsp import completion, references
from scenelang.lsp.completion import of_attribute, of_binding, of_word
from scenelang.lsp.names import file_of, offset, path_of, position, range_of, shown, uri_of
from scenelang.lsp.references import Document, Documents
from scenelang.session.checking import explained
from scenelang.session.formatting import indents_of
from scenelang.stdlib.colors import color_of

# Inlay hints: the parameters that literal arguments are for, and the kinds of definitions where they are requested.


def visible_inlays(document: Document, first: int, last: int, kinds: bool = False) -> list[lsp.InlayHint]:
    """Return the hints of the lines ``first`` to ``last``, counted from 0; with ``kinds``, those of definitions too."""
    names = document.names
    if names is None:
        return []
    version = names.version
    results = version.program.kinds.of(version.program)
    hints = []
    for form, result in zip(version.program.forms, results):
        place = version.place(form.span)
        if place.source is not document.source or not _overlaps(place, first, last):
            continue
        for span, label in _hints(form, result.kinds, with_kinds=kinds):
            at = version.place(span)
            if first <= at.source.position(at.start)[0] - 1 <= last:
                hints.append((at, label))
    return [_inlay(at, label) for at, label in sorted(hints, key=lambda row: row[0].start)]


def _overlaps(span: Span, first: int, last: int) -> bool:
    return span.source.position(span.start)[0] - 1 <= last and span.source.position(span.end)[0] - 1 >= first


def _inlay(at: Span, label: str) -> lsp.InlayHint:
    if label.startswith(":"):
        return lsp.InlayHint(position(at.source, at.end), label, kind=lsp.InlayHintKind.Type, padding_right=True)
    return lsp.InlayHint(position(at.source, at.start), label, kind=lsp.InlayHintKind.Parameter, padding_right=True)


def _hints(form: Any, kinds: dict[Any, Kind], *, with_kinds: bool) -> Iterator[tuple[Span, str]]:
    for node in walk(form):
        if node.span.expansion is not None:
            continue
        if type(node) is ast.Application:
            yield from _parameter_hints(node, kinds)
        elif with_kinds and type(node) is ast.Define and isinstance(node.target, Variable):
            kind = kinds.get(node.value, ANY)
            span = node.target.span
            if span is not None and kind is not ANY and kind.tag != "Function":
                yield span, f": {describe(kind).partition(' ')[2] or describe(kind)}"


def _parameter_hints(node: ast.Application, kinds: dict[Any, Kind]) -> Iterator[tuple[Span, str]]:
    names = _positional_names(kinds.get(node.function, ANY).code)
    if len(names) < 2:
        return
    pending = iter(node.arguments)
    positional = []
    for argument in pending:
        if type(argument) is ast.Constant and type(argument.value) is Keyword:
            next(pending, None)
        else:
            positional.append(argument)
    for name, argument in zip(names, positional):
        is_written = argument.span.expansion is None and argument.span.start > node.span.start  # not by a derived form
        if is_written and type(argument) in (ast.Constant, ast.ArrayLiteral):
            yield argument.span, f"{name}:"


def _positional_names(code: Any) -> list[str]:
    if isinstance(code, Builtin):
        return [parameter.name for parameter in (*code.signature.required, *code.signature.optional)]
    if isinstance(code, ast.Lambda):
        return [parameter.name for parameter in code.parameters if parameter.kind in ("required", "optional")]
    return []


# Color swatches: `(color "name")`, `(rgb r g b)` and arrays of three literal numbers as the value of `:color`.

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_COLORS = re.compile(
    rf"""\(color\s+"(?P<name>[^"\n]*)"\s*\)|\(rgb\s+(?P<rgb>{_NUMBER}(?:\s+{_NUMBER}){{2}})\s*\)"""
    rf"""|(?<=:color\s)\[\s*(?P<linear>{_NUMBER}(?:\s+{_NUMBER}){{2}})\s*\]"""
)


def color_swatches(document: Document) -> list[lsp.ColorInformation]:
    """Return the literal colors of a document, as sRGB."""
    text = document.source.text
    swatches = []
    for match in _COLORS.finditer(text):
        try:
            red, green, blue = _components(match)
        except SceneError:
            continue
        span = Span(document.source, *match.span())
        swatches.append(lsp.ColorInformation(range_of(span), lsp.Color(red, green, blue, 1.0)))
    return swatches


def _components(match: re.Match[str]) -> tuple[float, float, float]:
    if match["name"] is not None:
        values = [encoded(value) for value in color_of(match["name"])]
    elif match["rgb"] is not None:
        values = [float(value) / 255 for value in match["rgb"].split()]
    else:
        values = [encoded(float(value)) for value in match["linear"].split()]
    red, green, blue = (min(1.0, max(0.0, value)) for value in values)
    return red, green, blue


def color_notations(source: Source, color: lsp.Color, range_: lsp.Range) -> list[lsp.ColorPresentation]:
    """Return the ways to write a color that was picked, the one that the text uses first."""
    components = (color.red, color.green, color.blue)
    digits = "".join(f"{round(value * 255):02x}" for value in components)
    array = "[" + " ".join(f"{linear(value):.4g}" for value in components) + "]"
    texts = [f'(color "#{digits}")', f"(rgb {' '.join(str(round(value * 255)) for value in components)})", array]
    line = source.line(range_.start.line + 1)[range_.start.character :]
    texts.sort(key=lambda text: not line.startswith(text[:4] if text[0] == "(" else "["))
    return [lsp.ColorPresentation(text, lsp.TextEdit(range_, text)) for text in texts]


# Folding: brackets and comments that take several lines.


def foldable_ranges(document: Document) -> list[lsp.FoldingRange]:
    """Return the forms and the runs of comment lines that take several lines."""
    source = document.source
    ranges: list[lsp.FoldingRange] = []
    opened: list[int] = []
    comment: tuple[int, int] | None = None  # first and last line of a run of comment lines
    for kind, start, end in lexemes(source.text, 0, len(source.text)):
        line = source.position(start)[0] - 1
        if kind == "comment":
            comment = (comment[0] if comment is not None and line == comment[1] + 1 else line, line)
            continue
        if kind == "space":
            continue
        if comment is not None and comment[1] > comment[0]:
            ranges.append(lsp.FoldingRange(*comment, kind=lsp.FoldingRangeKind.Comment))
        comment = None
        if kind == "open":
            opened.append(line)
        elif kind == "close" and opened:
            first, last = opened.pop(), line
            if last > first and not any(each.start_line == first and each.end_line == last for each in ranges[-1:]):
                ranges.append(lsp.FoldingRange(first, last))
        elif kind in ("block", "string") and (last := source.position(end)[0] - 1) > line:
            kind_ = lsp.FoldingRangeKind.Comment if kind == "block" else None
            ranges.append(lsp.FoldingRange(line, last, kind=kind_))
    if comment is not None and comment[1] > comment[0]:
        ranges.append(lsp.FoldingRange(*comment, kind=lsp.FoldingRangeKind.Comment))
    return _outermost(ranges)


def _outermost(ranges: list[lsp.FoldingRange]) -> list[lsp.FoldingRange]:
    """Keep one range for each first line, the longest: an editor folds one there."""
    longest: dict[int, lsp.FoldingRange] = {}
    for each in ranges:
        known = longest.get(each.start_line)
        if known is None or known.end_line < each.end_line:
            longest[each.start_line] = each
    return [longest[line] for line in sorted(longest)]


PAUSE = 0.03  # debounce delay of the analysis, in seconds
# Delay of what trials of other texts show, as where brackets are missing; they take .04 to .3 s for texts up to this
# length, in which no request is answered.
REST = 0.4
_MAX_EXPLAINED = 20_000  # characters


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
        """Publish the diagnostics of a document, and after a rest those that `check` explains further."""
        document = self.document(uri)
        if document is None:
            return
        diagnostics = document.analyse().diagnostics
        self._publish(uri, document, diagnostics)
        if any(each.is_error for each in diagnostics) and len(document.source.text) <= _MAX_EXPLAINED:
            self._waiting[uri] = asyncio.get_running_loop().call_later(REST, self._publish_explained, uri)

    def _publish_explained(self, uri: str) -> None:
        """Publish the diagnostics of a document as `check` reports them, if they differ."""
        self._waiting.pop(uri, None)
        document = self.document(uri)
        if document is None:
            return
        diagnostics = document.analyse().diagnostics
        further = explained(document.editing.session, document.source, diagnostics)
        if list(further) != list(diagnostics):
            self._publish(uri, document, further)

    def _publish(self, uri: str, document: Document, diagnostics: Sequence[Diagnostic]) -> None:
        data = [shown(diagnostic, document.source) for diagnostic in diagnostics]
        version = self.workspace.get_text_document(uri).version
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, data, version))

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
    """Register the handlers of initialization and of document synchronization."""

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
    """Register the handlers of requests that only read a document, such as hover and completion."""

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
        return visible_inlays(document, first, last, server.shows_kinds)

    @server.answers(lsp.TEXT_DOCUMENT_DOCUMENT_COLOR)
    def document_colors(document: Document, params: lsp.DocumentColorParams) -> list[lsp.ColorInformation]:
        return color_swatches(document)

    @server.answers(lsp.TEXT_DOCUMENT_COLOR_PRESENTATION)
    def color_presentation(document: Document, params: lsp.ColorPresentationParams) -> list[lsp.ColorPresentation]:
        return color_notations(document.source, params.color, params.range)

    @server.answers(lsp.TEXT_DOCUMENT_FOLDING_RANGE)
    def folding_ranges(document: Document, params: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
        return foldable_ranges(document)


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
        locations = references.references(server.documents, document, target)
        with_definition = params.context.include_declaration
        return [_location(server, place.span) for place in locations if with_definition or not place.defines]

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
    is_last = edit.last > source.text.count("\n")  # a last line without an end has no line after it
    end = position(source, len(source.text)) if is_last else lsp.Position(edit.last, 0)
    changed = lsp.Range(lsp.Position(edit.first - 1, 0), end)
    return [lsp.TextEdit(changed, edit.text)]


def serve(version: str) -> None:
    """Serve one editor over standard input and output until it disconnects."""
    logging.getLogger("pygls").setLevel(logging.CRITICAL)
    build_server(version).start_io()
