"""How the transpiler is put together: functions over a context in modules that import one way."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = "scenelang.interpreter.transpile"
FILES = {
    ".".join((PACKAGE, *path.relative_to(ROOT / "interpreter" / "transpile").with_suffix("").parts)): path
    for path in (ROOT / "interpreter" / "transpile").rglob("*.py")
    if path.name != "__init__.py"
}
DEEPEST, LONGEST = 3, 1000


def imported(path: Path) -> Iterator[str]:
    """The modules of the transpiler that a file imports anywhere, for checking types only as well."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)} & FILES.keys()


def test_modules_import_one_way() -> None:
    graph = {name: set(imported(path)) for name, path in FILES.items()}
    assert len(graph) > 20
    assert any(graph.values())
    TopologicalSorter(graph).prepare()  # raises CycleError


def test_classes_have_few_ancestors() -> None:
    bases = {
        node.name: {ast.unparse(base).split("[")[0].rpartition(".")[2] for base in node.bases}
        for path in (ROOT / "interpreter").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ClassDef)
    }

    def ancestors(name: str) -> set[str]:
        direct = bases[name] & bases.keys() - {name}
        return direct.union(*(ancestors(base) for base in direct))

    assert len(bases) > 50
    assert {name: found for name in bases if len(found := ancestors(name)) > DEEPEST} == {}
