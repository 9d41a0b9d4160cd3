"""Offsets of a source and positions of the protocol: lines from 0, columns in UTF-16 code units."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote, urlsplit

from lsprotocol import types as lsp

from scenelang.grammar.source import Source, Span


def position(source: Source, offset: int) -> lsp.Position:
    line, column = source.position(min(offset, len(source.text)))
    before = source.line(line)[: column - 1]
    return lsp.Position(line - 1, column - 1 if before.isascii() else len(before.encode("utf-16-le")) // 2)


def offset(source: Source, at: lsp.Position) -> int:
    """The offset of a position; the end of the line, or of the text, for one beyond it."""
    lines = source.text.count("\n") + 1
    if at.line >= lines:
        return len(source.text)
    start, text = source.line_start(at.line + 1), source.line(at.line + 1)
    if text.isascii():
        return start + min(at.character, len(text))
    units = 0
    for index, character in enumerate(text):
        if units >= at.character:
            return start + index
        units += 2 if ord(character) > 0xFFFF else 1
    return start + len(text)


def range_of(span: Span) -> lsp.Range:
    return lsp.Range(position(span.source, span.start), position(span.source, span.end))


def path_of(uri: str) -> Path:
    """The file of a URI; for text that is in no file, a path that no file has."""
    parts = urlsplit(uri)
    if parts.scheme != "file":
        return Path("/", "untitled", unquote(parts.path).strip("/") or "scene")
    path = unquote(parts.path)
    return Path(path[1:] if path[2:3] == ":" else path)  # file:///C:/scene


def uri_of(path: Path) -> str:
    return path.as_uri()
