"""Texts as people write them and what the formatter makes of them; SCENELANG_UPDATE_GOLDENS=1 writes the latter."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from formatter.texts import INDENTS
from scenelang.grammar.formatter import format_text

CASES = sorted((Path(__file__).parent / "cases").glob("*.in.scene"))
UPDATE = bool(os.environ.get("SCENELANG_UPDATE_GOLDENS"))


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.name.split(".")[0])
def test_case(path: Path) -> None:
    golden = path.with_name(path.name.replace(".in.", ".out."))
    done = format_text(path.read_text("utf-8"), INDENTS)
    if UPDATE:
        golden.write_text(done, "utf-8")
    assert done == golden.read_text("utf-8")
    assert format_text(done, INDENTS) == done
