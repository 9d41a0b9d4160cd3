"""What the formatter must know besides a text: the forms of the language, and macros of the files that it imports."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from scenelang.backends.files import read_regular
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Source
from scenelang.grammar.formatter import format_text, learnt_indents
from scenelang.grammar.layout_styles import head_of
from scenelang.grammar.reader import read
from scenelang.interpreter.expand.forms import INDENTS

_MOST_FILES = 200
_LARGEST_FILE = 4_000_000  # bytes


def formatted(text: str) -> str:
    """A program that imports no macros, in the one style of the language. Raises SceneError for text that does not
    read."""
    return format_text(text, INDENTS)


def indents_of(text: str, folder: Path | None) -> dict[str, int | None]:
    """How forms and the macros of imported files are indented, for ``format_text``. ``folder``: where the text's
    imports are looked for. What cannot be found or read is left out."""
    known = dict(INDENTS)
    if folder is not None and "import" in text:
        _learn(known, Source("<text>", text.removeprefix("\ufeff")), folder, set())
    return known


def _learn(known: dict[str, int | None], source: Source, folder: Path, seen: set[Path]) -> None:
    """Add the macros of the files that ``source`` imports."""
    for name, prefix in _imports(read(source).forms):
        path = _found(folder, name)
        if path is None or path in seen or len(seen) >= _MOST_FILES:
            continue
        seen.add(path)
        text = _text_of(path)
        if text is None:
            continue
        imported = Source(name, text)
        inner = dict(INDENTS)
        _learn(inner, imported, path.parent, seen)
        for macro, indent in learnt_indents(read(imported).forms, inner).items():
            if macro not in INDENTS:
                known[prefix + macro] = indent


def _imports(forms: Sequence[Datum]) -> Iterator[tuple[str, str]]:
    """The path and the prefix of every import of a file."""
    for form in forms:
        if not isinstance(form, ListDatum) or head_of(form) != "import" or len(form.items) < 2:
            continue
        values = [item.value if isinstance(item, Atom) else None for item in form.items]
        prefix = values[3] if len(values) > 3 and values[2] == Keyword("prefix") else ""
        if type(values[1]) is str and values[1].endswith(".scene"):
            yield values[1], str(prefix or "")


def _found(folder: Path, name: str) -> Path | None:
    try:
        path = (folder / name).resolve()
        return path if path.is_file() and path.stat().st_size <= _LARGEST_FILE else None
    except (OSError, ValueError, RuntimeError):
        return None


def _text_of(path: Path) -> str | None:
    try:
        return read_regular(path).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError):
        return None
