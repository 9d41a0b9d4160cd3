"""The programs of this repository are formatted: examples, the standard library, documentation."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from scenelang.grammar.formatter import format_text
from scenelang.session.formatting import indents_of

ROOT = Path(__file__).parents[2]
PROGRAMS = sorted([*ROOT.glob("examples/**/*.scene"), *ROOT.glob("stdlib/*.scene")])
DOCUMENTS = sorted([ROOT / "README.md", *ROOT.glob("docs/*.md")])
BLOCKS = [
    pytest.param(path, match[1], id=f"{path.name}:{text.count(chr(10), 0, match.start()) + 2}")
    for path, text in ((path, path.read_text("utf-8")) for path in DOCUMENTS)
    for match in re.finditer(r"^```scene\n(.*?)^```$", text, re.M | re.S)
]


def test_there_are_programs() -> None:
    assert len(PROGRAMS) > 10
    assert len(BLOCKS) > 10


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: str(path.relative_to(ROOT)))
def test_program_is_formatted(path: Path) -> None:
    text = path.read_text("utf-8")
    assert format_text(text, indents_of(text, path.parent)) == text


@pytest.mark.parametrize(("path", "text"), BLOCKS)
def test_block_is_formatted(path: Path, text: str) -> None:
    assert format_text(text, indents_of(text, path.parent)) == text
