"""The history of the benchmarks' ratios."""

from __future__ import annotations

import runpy
from pathlib import Path

HISTORY = runpy.run_path(str(Path(__file__).parents[1] / "benchmarks" / "history.py"))


def test_a_commit_is_recorded_once_and_keeps_its_place(tmp_path: Path) -> None:
    path = tmp_path / "history.jsonl"
    for name, ratio in (("a", 1.0), ("b", 2.0), ("a", 3.123)):
        HISTORY["record"](name, {"fib": ratio}, path)
    assert HISTORY["entries"](path) == {"a": {"fib": 3.12}, "b": {"fib": 2.0}}
    assert list(HISTORY["entries"](path)) == ["a", "b"]


def test_rows_that_got_slower_are_told() -> None:
    before = {"fib": 3.0, "loop": 1.5, "gone": 1.0}
    assert list(HISTORY["slower"](before, {"fib": 3.9, "loop": 1.6, "new": 9.0})) == ["fib: x3.00 -> x3.90"]
