"""An editor on one file, for the tests of the language server."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from pytest_lsp import LanguageClient


class Editor:
    """What a person does in an editor, on one file. ``|`` in a text marks the cursor."""

    def __init__(self, client: LanguageClient, name: str, text: str) -> None:
        self.client, self.path = client, Path(client.root, name)
        self.uri, self.version, self.text = self.path.as_uri(), 1, text
        client.published.pop(self.uri, None)
        client.text_document_did_open(lsp.DidOpenTextDocumentParams(lsp.TextDocumentItem(self.uri, "scene", 1, text)))

    @property
    def document(self) -> lsp.TextDocumentIdentifier:
        return lsp.TextDocumentIdentifier(self.uri)

    def at(self, needle: str, inside: int = 0) -> lsp.Position:
        """The position of ``needle``'s first place, ``inside`` characters into it."""
        return self.position(self.text.index(needle) + inside)

    def position(self, offset: int) -> lsp.Position:
        before = self.text[:offset]
        line = before.rsplit("\n", 1)[-1]
        return lsp.Position(before.count("\n"), len(line.encode("utf-16-le")) // 2)

    def replace(self, old: str, new: str) -> None:
        """An incremental change of the last place of ``old``, as editors send it."""
        start = self.text.rindex(old)
        place = lsp.Range(self.position(start), self.position(start + len(old)))
        self.version += 1
        self.text = self.text[:start] + new + self.text[start + len(old) :]
        self.client.text_document_did_change(
            lsp.DidChangeTextDocumentParams(
                lsp.VersionedTextDocumentIdentifier(self.version, self.uri),
                [lsp.TextDocumentContentChangePartial(range=place, text=new)],
            )
        )

    async def diagnostics(self) -> list[lsp.Diagnostic]:
        """The diagnostics that come for the text as it is now."""
        while (found := self.client.published.get(self.uri)) is None or found.version != self.version:
            await asyncio.sleep(0.002)
        return list(found.diagnostics)

    async def next_diagnostics(self) -> list[lsp.Diagnostic]:
        """The diagnostics that come although the text stays as it is."""
        self.client.published.pop(self.uri, None)
        return await self.diagnostics()


def applied(text: str, edits: Sequence[Any]) -> str:
    """``text`` after edits of the protocol."""
    lines = text.split("\n")
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line) + 1)
    places = []
    for edit in edits:
        ends = [
            min(starts[min(at.line, len(lines))] + at.character, len(text)) for at in (edit.range.start, edit.range.end)
        ]
        places.append((*ends, edit.new_text))
    for start, end, new in sorted(places, reverse=True):
        text = text[:start] + new + text[end:]
    return text
