"""Formatting of programs and files: supplies the formatter with the forms of the language and the macros of imported
files."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import unified_diff
from pathlib import Path
from typing import Any

from scenelang.backends.files import read_regular
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.formatter import FormatFault, UnreadableError, format_range, format_text, learnt_indents
from scenelang.grammar.layout_styles import head_of
from scenelang.grammar.reader import read
from scenelang.interpreter.expand.forms import INDENTS

_MAX_FILES = 200  # imported files whose macros are read
_MAX_FILE_SIZE = 4_000_000  # bytes of an imported file
_MAX_PROGRAM_SIZE = 16_000_000  # bytes, as in `session`


@dataclass(frozen=True, slots=True)
class FormattedFile:
    """Result of formatting a file.

    Attributes
    ----------
    name
        Path of the file.
    before, after
        Its text, and the formatted text; None if formatting failed.
    diagnostics
        Errors of the syntax.
    fault
        Text of an internal error.
    """

    name: str
    before: str = ""
    after: str | None = None
    diagnostics: tuple[Diagnostic, ...] = ()
    fault: str | None = None

    @property
    def changes(self) -> bool:
        """Whether formatting changes the text."""
        return self.after is not None and self.after != self.before

    def data(self) -> dict[str, Any]:
        """Return the result as JSON data."""
        return {"file": self.name, "changed": self.changes, "formatted": self.after is not None}

    def difference(self) -> Iterator[str]:
        """Return the lines of the unified diff."""
        return difference(self.before, self.after or "", self.name, "formatted")


def format_file(name: str, lines: tuple[int, int] | None = None) -> FormattedFile:
    """Format a program file, or only the forms on the given lines; "-" is standard input.

    Nothing is written. Errors are returned in the result.
    """
    shown = "<stdin>" if name == "-" else name
    try:
        before = _program_text(name)
        indents = indents_of(before, Path.cwd() if name == "-" else Path(name).parent)
        if lines is not None:
            after = format_range(before, *lines, indents, name=shown)
        else:
            after = format_text(before, indents, name=shown)
    except UnreadableError as error:
        return FormattedFile(shown, diagnostics=error.diagnostics)
    except SceneError as error:
        return FormattedFile(shown, diagnostics=(error.diagnostic,))
    except FormatFault as fault:
        return FormattedFile(shown, fault=str(fault))
    return FormattedFile(shown, before, after)


def difference(before: str, after: str, name: str, how: str) -> Iterator[str]:
    """Return the lines of the unified diff of a file's text; ``how`` says what was done to it."""
    return unified_diff(_lines(before), _lines(after), name, f"{name} ({how})", lineterm="")


def _lines(text: str) -> list[str]:
    """Split a text at line feeds; unlike ``splitlines``, at no other character."""
    lines = text.split("\n")
    return lines if lines[-1] else lines[:-1]


def _program_text(name: str) -> str:
    """Read the text of a program, preserving byte order mark and line ends; raises SceneError."""
    if name.endswith((".py", ".txt", ".ipynb")):
        kind = "a text, as language models answer" if name.endswith(".txt") else "Python"
        convert = f"`scenelang transpile {name} -o {os.path.splitext(name)[0]}.scene`"
        hint = f"name a program, as `x.scene`; an answer of a model, or Python, is converted by {convert}"
        raise SceneError("unsupported", f"{name} is {kind}, not a program", hint)
    if name.endswith(".json"):
        raise SceneError("unsupported", f"{name} is a JSON scene, not a program")
    if name != "-" and os.path.isdir(name):
        raise SceneError("file", f"no programs (.scene) in {name}")
    try:
        most = _MAX_PROGRAM_SIZE + 1
        data = sys.stdin.buffer.read(most) if name == "-" else read_regular(name, most)
    except (OSError, ValueError) as error:
        from scenelang.backends.unreadable import unreadable

        raise unreadable(name, name, getattr(error, "strerror", None) or "invalid path") from None
    if len(data) > _MAX_PROGRAM_SIZE:
        raise SceneError("file", f"{name} exceeds the maximum program size of {_MAX_PROGRAM_SIZE:,} bytes")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        from scenelang.backends.unreadable import undecodable

        raise undecodable(data, name, error) from None


def formatted(text: str) -> str:
    """Format a program that imports no macros. Raises SceneError if the text cannot be parsed."""
    return format_text(text, INDENTS)


def indents_of(text: str, folder: Path | None) -> dict[str, int | None]:
    """Return the indentation rules of forms, including the macros of imported files, for ``format_text``.

    Imports are resolved relative to ``folder``; files that cannot be read are ignored.
    """
    known = dict(INDENTS)
    if folder is not None and "import" in text:
        _learn(known, Source("<text>", text.removeprefix("\ufeff")), folder, set())
    return known


def _learn(known: dict[str, int | None], source: Source, folder: Path, visited: set[Path]) -> None:
    """Add the macros of the files that ``source`` imports, directly or through others, to ``known``."""
    for name, prefix in _imports(read(source).forms):
        path = _resolved(folder, name)
        if path is None or path in visited or len(visited) >= _MAX_FILES:
            continue
        visited.add(path)
        text = _text_of(path)
        if text is None:
            continue
        imported = Source(name, text)
        inner = dict(INDENTS)
        _learn(inner, imported, path.parent, visited)
        for macro, indent in learnt_indents(read(imported).forms, inner).items():
            if macro not in INDENTS:
                known[prefix + macro] = indent


def _imports(forms: Sequence[Datum]) -> Iterator[tuple[str, str]]:
    """Yield path and prefix of every import of a file."""
    for form in forms:
        if not isinstance(form, ListDatum) or head_of(form) != "import" or len(form.items) < 2:
            continue
        values = [item.value if isinstance(item, Atom) else None for item in form.items]
        prefix = values[3] if len(values) > 3 and values[2] == Keyword("prefix") else ""
        if type(values[1]) is str and values[1].endswith(".scene"):
            yield values[1], str(prefix or "")


def _resolved(folder: Path, name: str) -> Path | None:
    """Return the path of an imported file; None if it does not exist or is too large."""
    try:
        path = (folder / name).resolve()
        return path if path.is_file() and path.stat().st_size <= _MAX_FILE_SIZE else None
    except (OSError, ValueError, RuntimeError):
        return None


def _text_of(path: Path) -> str | None:
    """Return the text of a file; None if it cannot be read."""
    try:
        return read_regular(path).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError):
        return None
