"""Completion: names where a name may stand, words in strings, attributes, files, types."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp

from scenelang.attributes import attribute_doc, attributes_of
from scenelang.grammar import ast
from scenelang.grammar.source import Span
from scenelang.interpreter.forms import FORMS
from scenelang.interpreter.library import STD
from scenelang.interpreter.scope import Macro, Variable
from scenelang.interpreter.shapes import GEOMETRY, WORDS
from scenelang.interpreter.snippets import snippet
from scenelang.interpreter.types import BASE_TYPES
from scenelang.lsp.context import Around, Context, context
from scenelang.lsp.describe import call_shape, of_record, of_word, quoted, signature
from scenelang.lsp.documents import Document
from scenelang.lsp.locals import local_bindings
from scenelang.lsp.texts import range_of
from scenelang.stdlib.reference import Kind, lookup, records

_MOST = 80
_WORDS = ("call", "bind", "retrieve", "bound?", "scene", "primitive")
_KINDS = {
    Kind.FORM: lsp.CompletionItemKind.Keyword,
    Kind.FUNCTION: lsp.CompletionItemKind.Function,
    Kind.CONSTANT: lsp.CompletionItemKind.Constant,
    Kind.TYPE: lsp.CompletionItemKind.TypeParameter,
}
_CLAUSES = ("when", "unless", "break")


def complete(document: Document, cursor: int) -> lsp.CompletionList:
    """What may stand at a cursor, the likeliest first."""
    text = document.source.text
    start, end = document.form_around(cursor)
    around = context(text, cursor, start)
    if around.kind == "comment":
        items: list[lsp.CompletionItem] = []
    elif around.kind == "string":
        items = list(_in_string(document, around))
    elif around.token[:1].isdigit():
        items = []
    elif around.token.startswith(":"):
        items = list(_keywords(document, around))
    elif "::" in around.token:
        items = list(_types(document))
    else:
        items = list(_names(document, around, start, end, cursor))
    fitting = [item for item in items if _fits(item.label, around.token)]
    place = lsp.Range(*(range_of(Span(document.source, at, at)).start for at in (around.start, cursor)))
    for item in fitting[:_MOST]:
        if around.kind == "atom" and "::" not in around.token:
            item.text_edit = lsp.TextEdit(place, item.insert_text or item.label)
    return lsp.CompletionList(is_incomplete=len(fitting) > _MOST, items=fitting[:_MOST])


def _fits(label: str, token: str) -> bool:
    """Whether a name holds what has been typed of it."""
    return token.lstrip('"').rpartition("::")[2].lower() in label.lower()


def resolve(document: Document | None, item: lsp.CompletionItem) -> lsp.CompletionItem:
    """The item with its documentation."""
    record = lookup(item.label)
    if record is not None and item.data == "library":
        item.documentation = lsp.MarkupContent(lsp.MarkupKind.Markdown, of_record(record))
    elif document is not None and document.names is not None and item.data == "word":
        item.documentation = lsp.MarkupContent(lsp.MarkupKind.Markdown, of_word(document.names, item.label))
    return item


# --- names ---------------------------------------------------------------------------------------------------------


def _names(document: Document, around: Context, start: int, end: int, cursor: int) -> Iterator[lsp.CompletionItem]:
    seen: set[str] = set()
    version = document.last_version()
    if version is not None:
        inner = local_bindings(version, document.source.text, start, end, cursor, around.token) if around.lists else {}
        for name, binding in inner.items():
            seen.add(name)
            yield lsp.CompletionItem(name, kind=_kind(binding), sort_text=f"0{name}", detail="local")
        for name, binding in document.globals().items():
            if name not in seen and not name.startswith(STD) and _fits(name, around.token):
                seen.add(name)
                form = document.definitions().get(binding)
                detail = signature(name, form.value) if form is not None else "this program"
                yield lsp.CompletionItem(name, kind=_kind(binding), sort_text=f"1{name}", detail=detail)
    at_head = around.position == 0 and bool(around.lists) and not around.lists[-1].square
    if not around.token and not at_head:
        return  # the whole library would be too much
    for record in records():
        if record.module is not None or record.kind is Kind.TYPE or record.name in seen:
            continue
        if not _fits(record.name, around.token):
            continue
        if record.kind is Kind.FORM and not at_head:
            continue
        yield _library_item(record.name, record.signature, _KINDS[record.kind], at_head)


def _library_item(name: str, detail: str, kind: lsp.CompletionItemKind, at_head: bool) -> lsp.CompletionItem:
    item = lsp.CompletionItem(name, kind=kind, detail=detail, sort_text=f"2{name}", data="library")
    if at_head and name in FORMS:
        body = snippet(FORMS[name])
        item.kind = lsp.CompletionItemKind.Snippet
        item.insert_text = body[1:].replace(")$0", "$0") if body.endswith(")$0") else body[1:]
        item.insert_text_format = lsp.InsertTextFormat.Snippet
        item.filter_text = name
    return item


def _kind(binding: Any) -> lsp.CompletionItemKind:
    if isinstance(binding, Macro):
        return lsp.CompletionItemKind.Keyword
    return lsp.CompletionItemKind.Variable if isinstance(binding, Variable) else lsp.CompletionItemKind.Function


# --- in strings ------------------------------------------------------------------------------------------------------


def _in_string(document: Document, around: Context) -> Iterator[lsp.CompletionItem]:
    head = around.inner.head if around.inner is not None else ""
    if head == "import" and around.position == 1:
        yield from _files(document)
    elif head in _WORDS and around.position == 1:
        for word, form in document.definitions().items():
            if not isinstance(word, str):
                continue
            detail = call_shape(word, form.function)
            yield lsp.CompletionItem(word, kind=lsp.CompletionItemKind.Class, detail=detail, sort_text=f"0{word}",
                                     data="word")  # fmt: skip
        if head in ("call", "primitive"):
            for word in sorted(WORDS):
                attributes = " ".join(f":{name}" for name in GEOMETRY.get(word, ()))
                yield lsp.CompletionItem(word, kind=lsp.CompletionItemKind.Constant, sort_text=f"1{word}",
                                         detail=f"(call {quoted(word)} {attributes})".replace(" )", ")"))  # fmt: skip


def _files(document: Document) -> Iterator[lsp.CompletionItem]:
    modules = document.editing.session.library.modules
    for module in modules:
        yield lsp.CompletionItem(f"{STD}{module}", kind=lsp.CompletionItemKind.Module, sort_text=f"1{module}")
    folder = document.path.parent
    for path in _scene_files(folder):
        if path != document.path:
            name = path.relative_to(folder).as_posix()
            yield lsp.CompletionItem(name, kind=lsp.CompletionItemKind.File, sort_text=f"0{name}")


def _scene_files(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    return [*sorted(folder.glob("*.scene"))[:100], *sorted(folder.glob("*/*.scene"))[:100]]


# --- attributes and types --------------------------------------------------------------------------------------------


def _keywords(document: Document, around: Context) -> Iterator[lsp.CompletionItem]:
    given = set(around.inner.items) if around.inner is not None else set()
    for name, detail in _keyword_names(document, around):
        if f":{name}" not in given:
            given.add(f":{name}")
            yield lsp.CompletionItem(f":{name}", kind=lsp.CompletionItemKind.Property, detail=detail)


def _keyword_names(document: Document, around: Context) -> Iterator[tuple[str, str]]:
    inner = around.inner
    word = around.word(inner)
    if word is not None:
        yield from _attributes(document, word)
    elif inner is not None:
        record = lookup(inner.head)
        if record is not None:
            yield from ((name, record.signature) for name in record.keywords)
        for binding, form in document.definitions().items():
            if isinstance(binding, Variable) and binding.name == inner.head and type(form.value) is ast.Lambda:
                yield from ((p.name, "") for p in form.value.parameters if p.kind == "keyword")
    if len(around.lists) > 1 and _is_loop(around.lists[-2]):
        yield from ((name, "a test between the clauses of a loop") for name in _CLAUSES)


def _is_loop(around: Around) -> bool:
    return around.head.startswith("for")


def _attributes(document: Document, word: str) -> Iterator[tuple[str, str]]:
    form = document.definitions().get(word)
    if form is not None and type(form.function) is ast.Lambda:
        for parameter in form.function.parameters:
            if parameter.kind == "keyword":
                default = parameter.default
                yield parameter.name, f"default {default.span.text}" if default is not None else "required"
        return
    yield from ((name, attribute_doc(word, name) or "") for name in attributes_of(word))


def _types(document: Document) -> Iterator[lsp.CompletionItem]:
    version = document.last_version()
    own = sorted(version.file.expander.record_names) if version is not None else []
    for name in [*own, *BASE_TYPES]:
        yield lsp.CompletionItem(name, kind=lsp.CompletionItemKind.TypeParameter)
