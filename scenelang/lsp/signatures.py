"""Signature help: how the form around the cursor is written, and which part of it the cursor is at."""

from __future__ import annotations

import re

from lsprotocol import types as lsp

from scenelang.grammar import ast
from scenelang.interpreter.library import STD
from scenelang.interpreter.scope import Variable
from scenelang.interpreter.shapes import GEOMETRY
from scenelang.lsp.context import Around, Context, context
from scenelang.lsp.describe import call_shape, quoted, signature
from scenelang.lsp.documents import Document
from scenelang.stdlib.reference import lookup

_PART = re.compile(r'"[^"]*"|\((?:[^()]|\([^()]*\))*\)|\[[^\]]*\]|\.\.\.|[^\s()]+')


def signature_help(document: Document, cursor: int) -> lsp.SignatureHelp | None:
    """The signature of the innermost form around a cursor that has one."""
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


def _signature(document: Document, around: Context, list_: Around) -> tuple[str, str | None] | None:
    head = list_.head
    if not head or head == "(" or list_.square:
        return None
    word = around.word(list_)
    if word is not None:
        form = document.definitions().get(word)
        if form is not None:
            return call_shape(word, form.function), None
        if word in GEOMETRY:
            return f"(call {quoted(word)} {' '.join(f':{name}' for name in GEOMETRY[word])})", None
    for binding, form in document.definitions().items():
        if isinstance(binding, Variable) and binding.name == head and type(form.value) is ast.Lambda:
            return signature(head, form.value), None
    record = lookup(head.removeprefix(STD))
    return (record.signature.split(" or (")[0], record.doc) if record is not None and "(" in record.signature else None


def _parts(label: str) -> list[tuple[int, int]]:
    """Where the parts of a signature after the head stand in it."""
    body = label.split(") -> ")[0]
    first = body.find(" ")
    if first < 0:
        return []
    end = len(body) if ") -> " in label else len(body) - 1
    return [match.span() for match in _PART.finditer(body, first, end) if match[0] != "..."]


def _active(label: str, parts: list[tuple[int, int]], list_: Around, here: Context | None) -> int | None:
    """Which part the cursor is at: that of the keyword just written, else by counting."""
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
