"""The benchmarks import what there is, and the history of their ratios."""

from __future__ import annotations

import ast
import runpy
from collections.abc import Iterator
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "benchmarks"
HISTORY = runpy.run_path(str(FOLDER / "history.py"))


def test_a_commit_is_recorded_once_and_keeps_its_place(tmp_path: Path) -> None:
    path = tmp_path / "history.jsonl"
    for name, ratio in (("a", 1.0), ("b", 2.0), ("a", 3.123)):
        HISTORY["record"](name, {"fib": ratio}, path)
    assert HISTORY["entries"](path) == {"a": {"fib": 3.12}, "b": {"fib": 2.0}}
    assert list(HISTORY["entries"](path)) == ["a", "b"]


def test_rows_that_got_slower_are_told() -> None:
    before = {"fib": 3.0, "loop": 1.5, "gone": 1.0}
    assert list(HISTORY["slower"](before, {"fib": 3.9, "loop": 1.6, "new": 9.0})) == ["fib: x3.00 -> x3.90"]


def imported_names() -> Iterator[tuple[str, str, str]]:
    """What the benchmarks import of the package: file, module, name."""
    for path in sorted(FOLDER.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("scenelang."):
                yield from ((path.name, str(node.module), each.name) for each in node.names)


def names_in(module: str) -> set[str]:
    """What a module of the package defines or imports, by its text."""
    parts = module.split(".")[1:]
    places = [folder.joinpath(*parts) for folder in (FOLDER.parent, FOLDER.parent / "scenelang")]
    folder = next((place for place in places if (place / "__init__.py").exists()), None)
    path = folder / "__init__.py" if folder else next(p for p in places if p.with_suffix(".py").exists())
    names = {each.stem for each in folder.glob("*.py")} if folder else set()
    for node in ast.parse(path.with_suffix(".py").read_text("utf-8")).body:
        names |= {name.id for name in ast.walk(node) if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)}
        names |= {each.asname or each.name for each in getattr(node, "names", ())} | {getattr(node, "name", "")}
    return names


def test_benchmarks_import_what_there_is() -> None:
    found = list(imported_names())
    assert len(found) > 50
    known = {module: names_in(module) for module in {row[1] for row in found}}
    assert [row for row in found if row[2] not in known[row[1]]] == []
