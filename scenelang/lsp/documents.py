"""The texts that are open in the editor, each with its analysis."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

from scenelang.editing import Analysis, Editing
from scenelang.grammar.source import Source
from scenelang.interpreter.incremental import Version
from scenelang.interpreter.scope import base_name
from scenelang.lsp.names import Names
from scenelang.session import Options, Session


class Document:
    """One open text, and what the last analysis found that read it whole."""

    def __init__(self, path: Path, editing: Editing, text: str) -> None:
        self.path = path
        self.editing = editing
        self.source = Source(str(path), text)
        self.analysis: Analysis | None = None
        self._last: Version | None = None
        self._globals: dict[str, Any] = {}
        self._definitions: dict[Any, Any] = {}

    def change(self, text: str) -> None:
        """A new version of the text, which ``analyse`` has not seen yet."""
        if text != self.source.text:
            self.source = Source(str(self.path), text)
            self.forget()

    def forget(self) -> None:
        """The text, or a file that it imports, has changed."""
        self.analysis = None
        self.__dict__.pop("names", None)

    def analyse(self) -> Analysis:
        """The analysis of the text as it is."""
        if self.analysis is None:
            self.analysis = self.editing.check(self.source)
            if self.analysis.version is not None:
                self._keep(self.analysis.version, any(d.code < "E2" for d in self.analysis.diagnostics))
        return self.analysis

    def _keep(self, version: Version, unreadable: bool) -> None:
        """Keep what completion needs; of text that does not read, what the last good version had besides."""
        self._last = version
        names = {base_name(symbol): binding for symbol, binding in dict.items(version.file.names)}
        self._globals = {**self._globals, **names} if unreadable else names
        self._definitions = Names(version, self._definitions if unreadable else {}).definitions

    @cached_property
    def names(self) -> Names | None:
        """What the names of the text mean."""
        version = self.analyse().version
        return Names(version, self._definitions) if version is not None else None

    def last_version(self) -> Version | None:
        """The version that was analysed last, perhaps before the last change: completion cannot wait."""
        if self._last is None:
            self.analyse()
        return self._last

    def definitions(self) -> dict[Any, Any]:
        """Definitions of the last version by variable or word; of broken text those of the last good one too."""
        self.last_version()
        return self._definitions

    def globals(self) -> dict[str, Any]:
        """The names of the top level, like ``definitions``."""
        self.last_version()
        return self._globals

    def form_around(self, cursor: int) -> tuple[int, int]:
        """Where the top-level form at a cursor begins and ends, going by the first column: the text may be broken."""
        text = self.source.text
        start = text.rfind("\n(", 0, cursor) + 1
        end = text.find("\n(", cursor)
        return start, len(text) if end < 0 else end


class Documents:
    """All open texts."""

    def __init__(self) -> None:
        self._open: dict[Path, Document] = {}
        self.texts: dict[Path, str] = {}  # by resolved path
        self.root: Path | None = None

    def open(self, path: Path, text: str) -> Document:
        project = self.root if self.root is not None and path.is_relative_to(self.root) else None
        editing = Editing(Session(Options(project=project)), self.texts)
        document = self._open[path] = Document(path, editing, text)
        self.texts[path.resolve()] = text
        return document

    def change(self, path: Path, text: str) -> Document:
        document = self._open.get(path) or self.open(path, text)
        document.change(text)
        self.texts[path.resolve()] = text
        return document

    def close(self, path: Path) -> None:
        self._open.pop(path, None)
        self.texts.pop(path.resolve(), None)

    def get(self, path: Path) -> Document | None:
        return self._open.get(path)

    def all(self) -> list[Document]:
        return list(self._open.values())
