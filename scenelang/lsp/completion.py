"""Completion of names, words in strings, attributes, files and types; also hover and signature help."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp

from scenelang.grammar import ast
from scenelang.grammar.datum import Span, comment_above
from scenelang.interpreter.checker.program import Param
from scenelang.interpreter.expand.forms import FORMS, snippet
from scenelang.interpreter.expand.scope import ConstantBinding, Macro, PaperForm, Special, Variable
from scenelang.interpreter.runtime.types import BASE_TYPES, STD, Builtin
from scenelang.interpreter.scene.primitives import docs_of_words, geometry_attributes, words
from scenelang.lsp.names import Around, CursorContext, Names, context, local_bindings, range_of
from scenelang.lsp.references import Document
from scenelang.reference.primer import attribute_doc, attributes_of
from scenelang.stdlib.colors import named_colors
from scenelang.stdlib.reference import RecordKind, ReferenceRecord, lookup, records

# Hover: signatures and documentation of names, words and attributes as Markdown.


def code(text: str) -> str:
    return f"```scene\n{text}\n```"


def of_record(record: ReferenceRecord) -> str:
    """Return the documentation of a library name."""
    parts = [code(record.signature), record.doc]
    parts += [f"`{example.expression}` gives `{example.value}`" for example in record.examples[:2]]
    if record.module is not None:
        parts.append(f'comes with `(import "{record.module}")`')
    return "\n\n".join(parts)


def of_library(binding: Any, name: str) -> ReferenceRecord | None:
    """Return the library's documentation of a binding, if it comes from the library."""
    if isinstance(binding, Builtin):
        return lookup(binding.name)
    if isinstance(binding, Special):
        return lookup(binding.name)
    if isinstance(binding, (PaperForm, ConstantBinding)):
        return lookup(name.removeprefix(STD))
    if isinstance(binding, Variable) and binding.span is not None and binding.span.source.name.startswith(STD):
        return lookup(binding.name)
    return None


def of_binding(names: Names, binding: Any, name: str) -> str:
    """Return the Markdown of the name at a position."""
    record = of_library(binding, name)
    if record is not None:
        return of_record(record)
    if isinstance(binding, Macro):
        return "\n\n".join([code(f"({binding.name} ...)"), "macro of this program", *_comment(names, binding.span)])
    if not isinstance(binding, Variable):
        return code(name)
    param = _param(names, binding)
    if param is not None:
        return "\n\n".join(part for part in (code(_param_text(param)), param.doc, "param") if part)
    form = names.definitions.get(binding)
    if form is None:
        return f"{code(binding.name)}\n\nlocal variable" if not binding.is_global else code(binding.name)
    return "\n\n".join([code(signature(binding.name, form.value)), *_comment(names, form.span)])


def of_word(names: Names, word: str) -> str:
    """Return the Markdown of a word: its call, the comment above its function, and its number of uses."""
    form = names.definitions.get(word)
    if form is None:
        docs = docs_of_words()
        if word in docs:
            shape = f"(call {quoted(word)} {' '.join(f':{name}' for name in attributes_of(word))})"
            rows = [f"- `:{name}`: {attribute_doc(word, name)}" for name in attributes_of(word)]
            return "\n\n".join([code(shape), docs[word], "\n".join(rows)])
        return f"{code(f'(call {quoted(word)} ...)')}\n\nunbound word: a semantic primitive"
    uses = sum(1 for use in names.uses_of_word(word) if not use.defines)
    times = "once" if uses == 1 else f"{uses} times"
    return "\n\n".join(
        [code(call_shape(word, form.function)), *_comment(names, form.span), f"used {times} in this file"]
    )


def of_attribute(names: Names, word: str, name: str) -> str | None:
    """Return the Markdown of an attribute in a call of a word."""
    form = names.definitions.get(word)
    if form is None:
        doc = attribute_doc(word, name)
        return f"{code(f':{name}')}\n\n{doc}" if doc is not None else None
    function = form.function
    for parameter in function.parameters if type(function) is ast.Lambda else ():
        if parameter.kind == "keyword" and parameter.name == name:
            return f"{code(_parameter_text(parameter))}\n\nparameter of {quoted(word)}"
    return None


def quoted(word: str) -> str:
    return '"' + word.replace("\\", "\\\\").replace('"', '\\"') + '"'


def call_shape(word: str, function: Any) -> str:
    """Return the call of a word: ``(call "chair" :seat :color ...)``."""
    parameters = function.parameters if type(function) is ast.Lambda else ()
    keywords = [_parameter_text(p) for p in parameters if p.kind == "keyword"]
    return f"(call {' '.join([quoted(word), *keywords])})"


def signature(name: str, value: Any) -> str:
    """Return the usage of a definition."""
    if type(value) is not ast.Lambda:
        text = " ".join(value.span.text.split()) if value.span.expansion is None else "..."
        return f"(define {name} {text if len(text) <= 60 else text[:57] + '...'})"
    return f"({' '.join([name, *(_parameter_text(p) for p in value.parameters)])})"


def _parameter_text(parameter: ast.Parameter) -> str:
    typed = f"{parameter.name}::{parameter.type.name}" if parameter.type is not None else parameter.name
    name = f":{typed}" if parameter.kind == "keyword" else typed
    if parameter.kind in ("rest", "keys"):
        return f". {name}" if parameter.kind == "rest" else f"&keys {name}"
    if parameter.default is None:
        return name
    text = parameter.default.span.text
    return f"[{name} {text}]" if len(text) <= 24 and "\n" not in text else f"[{name}]"


def _param(names: Names, variable: Variable) -> Param | None:
    params = names.version.program.params
    return next((param for param in params if param.name == variable.name), None) if variable.is_global else None


def _param_text(param: Param) -> str:
    ends = "".join(
        f" :{name} {value:g}" for name, value in (("min", param.minimum), ("max", param.maximum)) if value is not None
    )
    return f"(param {param.name} {param.default}{ends})"


def _comment(names: Names, span: Span | None) -> list[str]:
    """Return the comment directly above a definition."""
    if span is None:
        return []
    place = names.version.place(span)
    comment = _comment_text(comment_above(place.source, place.start))
    return [comment] if comment else []


def _comment_text(lines: Iterable[str]) -> str:
    """Return the text of comment lines below the last separator line."""
    texts: list[str] = []
    for line in lines:
        texts = [] if set(line) <= {";", "-", " ", "="} else [*texts, line.lstrip("; ")]
    return "\n".join(texts)


_MAX_COUNT = 80
_WORDS = ("call", "bind", "retrieve", "bound?", "scene", "primitive")
_KINDS = {
    RecordKind.FORM: lsp.CompletionItemKind.Keyword,
    RecordKind.FUNCTION: lsp.CompletionItemKind.Function,
    RecordKind.CONSTANT: lsp.CompletionItemKind.Constant,
    RecordKind.TYPE: lsp.CompletionItemKind.TypeParameter,
}
_CLAUSES = ("when", "unless", "break")


def complete(document: Document, cursor: int) -> lsp.CompletionList:
    """Yield the completions at a cursor, the most likely ones first."""
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
    for item in fitting[:_MAX_COUNT]:
        if around.kind == "atom" and "::" not in around.token:
            item.text_edit = lsp.TextEdit(place, item.insert_text or item.label)
    return lsp.CompletionList(is_incomplete=len(fitting) > _MAX_COUNT, items=fitting[:_MAX_COUNT])


def _fits(label: str, token: str) -> bool:
    """Return whether a name contains the typed text."""
    return token.lstrip('"').rpartition("::")[2].lower() in label.lower()


def resolve(document: Document | None, item: lsp.CompletionItem) -> lsp.CompletionItem:
    """Add the documentation to a completion item."""
    record = lookup(item.label)
    if record is not None and item.data == "library":
        item.documentation = lsp.MarkupContent(lsp.MarkupKind.Markdown, of_record(record))
    elif document is not None and document.names is not None and item.data == "word":
        item.documentation = lsp.MarkupContent(lsp.MarkupKind.Markdown, of_word(document.names, item.label))
    return item


# --- names ---------------------------------------------------------------------------------------------------------


def _names(
    document: Document, around: CursorContext, start: int, end: int, cursor: int
) -> Iterator[lsp.CompletionItem]:
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
        return  # without a prefix, omit the library
    for record in records():
        if record.module is not None or record.kind is RecordKind.TYPE or record.name in seen:
            continue
        if not _fits(record.name, around.token):
            continue
        if record.kind is RecordKind.FORM and not at_head:
            continue
        yield _library_item(record.name, record.signature, _KINDS[record.kind], at_head=at_head)


def _library_item(name: str, detail: str, kind: lsp.CompletionItemKind, *, at_head: bool) -> lsp.CompletionItem:
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


def _in_string(document: Document, around: CursorContext) -> Iterator[lsp.CompletionItem]:
    head = around.inner.head if around.inner is not None else ""
    if head == "import" and around.position == 1:
        yield from _files(document)
    elif head == "color" and around.position == 1:
        for name, digits in named_colors().items():
            yield lsp.CompletionItem(name, kind=lsp.CompletionItemKind.Color, documentation=f"#{digits}")
    elif head in _WORDS and around.position == 1:
        for word, form in document.definitions().items():
            if not isinstance(word, str):
                continue
            detail = call_shape(word, form.function)
            yield lsp.CompletionItem(word, kind=lsp.CompletionItemKind.Class, detail=detail, sort_text=f"0{word}",
                                     data="word")  # fmt: skip
        if head in ("call", "primitive"):
            for word in sorted(words()):
                attributes = " ".join(f":{name}" for name in geometry_attributes(word) or ())
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


def _keywords(document: Document, around: CursorContext) -> Iterator[lsp.CompletionItem]:
    given = set(around.inner.items) if around.inner is not None else set()
    for name, detail in _keyword_names(document, around):
        if f":{name}" not in given:
            given.add(f":{name}")
            yield lsp.CompletionItem(f":{name}", kind=lsp.CompletionItemKind.Property, detail=detail)


def _keyword_names(document: Document, around: CursorContext) -> Iterator[tuple[str, str]]:
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
        yield from ((name, "condition between the clauses of a loop") for name in _CLAUSES)


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


# Signature help: the signature of the form at the cursor, and its active parameter.


_PART = re.compile(r'"[^"]*"|\((?:[^()]|\([^()]*\))*\)|\[[^\]]*\]|\.\.\.|[^\s()]+')


def signature_help(document: Document, cursor: int) -> lsp.SignatureHelp | None:
    """Return the signature of the innermost enclosing form that has one."""
    start, _ = document.form_around(cursor)
    around = context(document.source.text, cursor, start)
    for depth in range(len(around.lists) - 1, -1, -1):
        shown = _signature(document, around, around.lists[depth])
        if shown is not None:
            label, doc = shown
            parts = _parts(label)
            active = _active(label, parts, around.lists[depth], around if depth == len(around.lists) - 1 else None)
            parameters = [lsp.ParameterInformation(part) for part in parts]
            information = lsp.SignatureInformation(label, doc, parameters, active)
            return lsp.SignatureHelp([information], 0, active)
    return None


def _signature(document: Document, around: CursorContext, list_: Around) -> tuple[str, str | None] | None:
    head = list_.head
    if not head or head == "(" or list_.square:
        return None
    word = around.word(list_)
    if word is not None:
        form = document.definitions().get(word)
        if form is not None:
            return call_shape(word, form.function), None
        read = geometry_attributes(word)
        if read is not None:
            return f"(call {quoted(word)} {' '.join(f':{name}' for name in read)})", None
    for binding, form in document.definitions().items():
        if isinstance(binding, Variable) and binding.name == head and type(form.value) is ast.Lambda:
            return signature(head, form.value), None
    record = lookup(head.removeprefix(STD))
    return (record.signature.split(" or (")[0], record.doc) if record is not None and "(" in record.signature else None


def _parts(label: str) -> list[tuple[int, int]]:
    """Return the label offsets of the parameters of a signature."""
    body = label.split(") -> ")[0]
    first = body.find(" ")
    if first < 0:
        return []
    end = len(body) if ") -> " in label else len(body) - 1
    return [match.span() for match in _PART.finditer(body, first, end) if match[0] != "..."]


def _active(label: str, parts: list[tuple[int, int]], list_: Around, here: CursorContext | None) -> int | None:
    """Return the active parameter: that of the preceding keyword, else by position."""
    if not parts:
        return None
    items = list_.items
    keyword = here.token if here is not None and here.token.startswith(":") else ""
    if not keyword and len(items) > 1 and items[-1].startswith(":"):
        keyword = items[-1]
    if keyword:
        for index, (start, end) in enumerate(parts):
            if label[start:end].lstrip("[").partition("::")[0].partition(" ")[0].rstrip("]") == keyword:
                return index
    return max(0, min(len(items) - 1, len(parts) - 1))
