"""Transpiled programs are formatted already."""

from __future__ import annotations

from pathlib import Path

import pytest

from formatter.texts import INDENTS
from scenelang import Session
from scenelang.grammar.concrete import LINE_COMMENT, tokens
from scenelang.grammar.formatter import WIDTH, format_text

FOLDER = Path(__file__).parents[1] / "transpile"
RESPONSES = sorted(path for name in ("responses", "programs", "programs2") for path in (FOLDER / name).glob("*.txt"))


@pytest.mark.parametrize("path", RESPONSES, ids=lambda path: path.stem)
def test_transpiled_program_is_formatted(path: Path) -> None:
    session = Session()
    translation = session.transpile(session.source(str(path)))
    assert translation.ok
    assert format_text(translation.text, INDENTS) == translation.text
    assert too_long(translation.text) == []


def too_long(text: str) -> list[str]:
    """The lines that are too long although they could be broken: comments, and one token on a line, cannot."""
    found = list(tokens(text))
    lines = []
    for line in text.splitlines():
        if len(line) > WIDTH and not any(t.kind == LINE_COMMENT and line.endswith(t.text.rstrip()) for t in found):
            words = line.strip().strip("()[]'")
            if not (words.startswith('"') and words.endswith('"')) and '"' not in words:
                lines.append(line)
    return lines
