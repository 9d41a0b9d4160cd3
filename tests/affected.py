"""``make check``: the tests of what changed since a commit, for less than a minute.

A test file is affected when it changed itself, or reaches a changed module through imports; the nearest come first, until
the time is over. Coverage-based selection (pytest-testmon) would know more,
but needs a traced run of the whole suite first and does not see the processes that many tests start.
"""

from __future__ import annotations

import ast
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TESTS = ROOT / "tests"
FOLDERS = ("grammar", "interpreter", "stdlib", "backends", "scenelang", "tests")
SECONDS = 40.0
ALWAYS = ["tests/test_structure.py"]


def changed(since: str) -> list[Path]:
    """The files that differ from ``since``, new ones too."""
    words = (["diff", "--name-only", since], ["ls-files", "--others", "--exclude-standard"])
    names = dict.fromkeys(name for each in words for name in _git(*each).splitlines())
    return [Path(name) for name in names if (ROOT / name).is_file()]


def _git(*words: str) -> str:
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout


def module_of(path: Path) -> str:
    """The dotted name under which a file of the repository is imported."""
    parts = list(path.with_suffix("").parts)
    if parts[0] == "tests":
        parts = parts[1:]
    elif parts[0] != "scenelang":
        parts = ["scenelang", *parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(path: Path) -> set[str]:
    """The modules that a file imports anywhere in it; of ``from a import b`` both ``a`` and ``a.b``."""
    package = module_of(path.relative_to(ROOT)).split(".")[:-1]
    try:
        return set(_imported(ast.parse(path.read_text("utf-8")), package))
    except SyntaxError:  # a program that tests read
        return set()


def _imported(tree: ast.Module, package: list[str]) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = ".".join([*(package[: len(package) - node.level + 1] if node.level else []), node.module or ""])
            yield base.strip(".")
            yield from (f"{base}.{alias.name}".strip(".") for alias in node.names)


def affected(files: list[Path]) -> list[str]:
    """The test files that reach the changed ``files`` through their imports, nearest first."""
    imports = {path: imported(path) for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.py"))}
    names = {module_of(path.relative_to(ROOT)): path for path in imports}
    importers: dict[Path, set[Path]] = {}
    for path, found in imports.items():
        for name in found & names.keys():
            importers.setdefault(names[name], set()).add(path)
    distance = {ROOT / path: 0 for path in files if path.suffix == ".py"}
    near = list(distance)
    while near:
        further = {path for each in near for path in importers.get(each, ())} - distance.keys()
        distance |= dict.fromkeys(further, max(distance.values()) + 1)
        near = sorted(further)
    tests = [path for path in distance if path.is_relative_to(TESTS) and path.name.startswith("test_")]
    tests.sort(key=lambda path: (distance[path], len(imports[path]), str(path)))
    return [str(path.relative_to(ROOT)) for path in tests]


class Deadline:
    """Ends the run of tests after SECONDS."""

    def __init__(self) -> None:
        self._end = time.monotonic() + SECONDS
        self._session: pytest.Session | None = None

    def pytest_sessionstart(self, session: pytest.Session) -> None:
        self._session = session

    def pytest_runtest_teardown(self) -> None:
        if self._session is not None and time.monotonic() > self._end:
            self._session.shouldstop = f"the {SECONDS:g} seconds of `make check` are over; `make test` runs the rest"


def main(since: str = "HEAD") -> int:
    """Run the tests of what changed since a commit; the exit status."""
    found = affected(changed(since))
    print(f"test files that are affected since {since}: {len(found)}")
    chosen = list(dict.fromkeys([*ALWAYS, *found]))
    markers = "not gpu and not slow and not browser"
    status = pytest.main(["-q", "-x", "--no-header", "-m", markers, *chosen], plugins=[Deadline()])
    return 0 if status in (pytest.ExitCode.OK, pytest.ExitCode.INTERRUPTED) else int(status)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:2]))
