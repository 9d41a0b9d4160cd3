"""The page of diagnostics: every code with a wrong program of ``tests/bad``, what is said about it, and the same
program fixed, from ``tests/fixed``, where that is short."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from generator.markdown import NOTICE, block, table
from scenelang.grammar.diagnostics import CODES, REMEDIES

ROOT = Path(__file__).parents[2]
BAD = ROOT / "tests" / "bad"
FIXED = ROOT / "tests" / "fixed"
_LARGEST = 1200  # characters of a program that is shown
_PAGE_NAME = re.compile(r"`docs/([\w-]+\.md)`")  # a page of the documentation, as messages name it
_LANGUAGES = {".scene": "scene", ".py": "python"}

FAMILIES = {
    "E1": "Reading",
    "E2": "Forms",
    "E3": "Names",
    "E4": "Running",
    "E5": "Limits",
    "E6": "Scenes",
    "E7": "Files",
    "E8": "A language model's Python",
    "E9": "Language models",
    "W": "Warnings",
    "N": "Notes",
}


def diagnostics_page() -> str:
    """Every code of an error or warning, Markdown."""
    rows = sorted((entry.code, name) for name, entry in CODES.items())
    lines = [
        "# Errors and warnings",
        "",
        NOTICE,
        "",
        'Every error and warning has a code that stays, and a name by which programs test it, `(error-is? e "index")`.',
        "`scenelang explain CODE` shows what stands here. A comment in the first lines of a program, `; command:` or",
        "`; args:`, tells how it was run where that was not by `scenelang run FILE`.",
        "",
    ]
    lines += table(("code", "name", "meaning"), [_row(code, name) for code, name in rows])
    for family, title in FAMILIES.items():
        lines += [f"## {title}", ""]
        for code, name in rows:
            if code.startswith(family):
                lines += _section(code, name)
    return "\n".join(lines).rstrip("\n") + "\n"


def _row(code: str, name: str) -> tuple[str, str, str]:
    return f"[{code}](#{code.lower()}-{name})", f"`{name}`", CODES[name].why


def _section(code: str, name: str) -> Iterator[str]:
    remedy = _PAGE_NAME.sub(r"[`docs/\1`](../\1)", REMEDIES[name])
    yield from (f"### {code} {name}", "", f"{CODES[name].why} {remedy}", "")
    case = shown_case(code)
    if case is None:
        return
    for path in _files(case):
        text = _text(path)
        if text is None:
            continue
        alone = case.is_file() and path.suffix in _LANGUAGES
        if not alone:
            yield from (f"`{path.name}`:", "")
        yield from block(f"{_LANGUAGES[path.suffix]} wrong {code}" if alone else "text", text)
    yield from block("text", _message(case))
    fixed = FIXED / case.name
    if fixed.is_file():
        yield from ("Fixed:", "")
        yield from block(f"{_LANGUAGES[fixed.suffix]} fixed", fixed.read_text("utf-8"))


def shown_case(code: str) -> Path | None:
    """The program of ``tests/bad`` that shows a code: one that has been fixed, else the shortest; None without one."""
    cases = [path for path in sorted(BAD.glob(f"{code}-*")) if path.is_dir() or path.suffix in _LANGUAGES]
    return min(cases, key=lambda path: (not (FIXED / path.name).exists(), _length(path), path.name), default=None)


def _length(case: Path) -> int:
    return sum(path.stat().st_size for path in _files(case))


def _files(case: Path) -> list[Path]:
    return sorted(case.iterdir()) if case.is_dir() else [case]


def _text(path: Path) -> str | None:
    """What can be shown of a file: None for one that is no text, or long."""
    try:
        text = path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        return None
    return text if len(text) <= _LARGEST else None


def _message(case: Path) -> str:
    text = case.with_suffix(".txt") if case.is_file() else BAD / f"{case.name}.txt"
    lines = text.read_text("utf-8").splitlines()
    return "\n".join(line if len(line) <= 160 else f"{line[:160]} ..." for line in lines)
