"""Which tests reach which lines: each block of each function says that it ran, once a test, in subprocesses too.

Coverage with contexts would do the same several times slower, which matters for twelve thousand tests. A pytest plug-in
(`-p fault_probe`) and an import hook, which `sitecustomize.py` beside this file installs. FAULT_PROBE is the folder for
the results, FAULT_TREE the checkout.
"""

from __future__ import annotations

import ast
import builtins
import fcntl
import hashlib
import json
import marshal
import os
import signal
import sys
import time
from collections.abc import Iterator
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

import pytest

FOLDERS = ("grammar", "interpreter", "stdlib", "backends", "scenelang")
COMPILED = "numba"  # functions that numba compiles cannot hold probes
LONGEST = 20.0  # seconds; a test that takes longer is not used
_HIGH = 400  # above the descriptors that tests count or close

Block = list[ast.stmt]


def blocks_of(tree: ast.Module) -> Iterator[Block]:
    """Blocks of statements that run in functions, outer ones first."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield from _blocks(node.body)


def _blocks(block: Block) -> Iterator[Block]:
    yield block
    for statement in block:
        if not isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            for inner in inner_blocks(statement):
                yield from _blocks(inner)


def inner_blocks(statement: ast.stmt) -> list[Block]:
    parts = [statement, *getattr(statement, "handlers", ()), *getattr(statement, "cases", ())]
    found = [getattr(part, name, None) for part in parts for name in ("body", "orelse", "finalbody")]
    return [block for block in found if block]


def sections(block: Block) -> list[Block]:
    """The parts of a block that begin after a statement from which control may not come back."""
    parts: list[Block] = [[]]
    for statement in block:
        parts[-1].append(statement)
        if inner_blocks(statement):
            parts.append([])
    return [part for part in parts if part]


def lines_of(source: str) -> dict[int, int]:
    """The line of the probe that says whether a line ran, for lines of functions."""
    found: dict[int, int] = {}
    for block in blocks_of(ast.parse(source)):
        for part in sections(block):
            for statement in part:
                inner = inner_blocks(statement)
                last = min(each[0].lineno for each in inner) if inner else (statement.end_lineno or 0) + 1
                found |= dict.fromkeys(range(statement.lineno, max(last, statement.lineno + 1)), part[0].lineno)
    return found


def with_probes(source: str, name: str) -> ast.Module:
    tree = ast.parse(source)
    if COMPILED in source:
        return tree
    for block in list(blocks_of(tree)):
        rebuilt: Block = []
        for part in sections(block):
            probe = ast.parse(
                f"{name!r} in _fault_seen or _fault_hit({name!r})".replace(name, f"{name}:{part[0].lineno}")
            )
            at = 1 if part[0] is block[0] and _is_docstring(part[0]) else 0
            rebuilt += [*part[:at], probe.body[0], *part[at:]]
            for node in ast.walk(probe.body[0]):
                node.lineno = node.end_lineno = part[0].lineno  # type: ignore[attr-defined]
                node.col_offset = node.end_col_offset = 0  # type: ignore[attr-defined]
        block[:] = rebuilt
    return tree


def _is_docstring(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


class _Record:
    """What ran since the last test, and, in other processes than the one of the tests, a line of a file for each."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.seen: set[str] = set()
        self.pid = 0
        opened = os.open(folder / "processes.txt", os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        self.file = fcntl.fcntl(opened, fcntl.F_DUPFD_CLOEXEC, _HIGH)
        os.close(opened)

    def hit(self, name: str) -> None:
        self.seen.add(name)
        if os.getpid() != self.pid:
            try:
                os.write(self.file, f"{os.environ.get('PYTEST_CURRENT_TEST', '')}\t{name}\n".encode())
            except OSError:  # the file is closed or forbidden there
                pass


_record: _Record | None = None


def install() -> None:
    """Put probes into the modules of the checkout as they are imported."""
    global _record
    if "FAULT_PROBE" not in os.environ:
        return
    folder, tree = Path(os.environ["FAULT_PROBE"]), Path(os.environ["FAULT_TREE"])
    _record = _Record(folder)
    builtins._fault_seen, builtins._fault_hit = _record.seen, _record.hit  # type: ignore[attr-defined]
    plain = SourceFileLoader.get_code

    def get_code(self: Any, name: str) -> Any:
        path = Path(self.path)
        if not any(path.is_relative_to(tree / each) for each in FOLDERS):
            return plain(self, name)
        return _compiled(path, str(path.relative_to(tree)))

    SourceFileLoader.get_code = get_code  # type: ignore[method-assign,assignment]


def _compiled(path: Path, name: str) -> Any:
    """The code of a module with probes, kept beside Python's own, where sandboxed processes may read too."""
    source = path.read_bytes()
    kept = path.parent / "__pycache__" / f"{path.stem}.{hashlib.sha256(source).hexdigest()[:16]}.probed"
    try:
        return marshal.loads(kept.read_bytes())
    except OSError:
        code = compile(with_probes(source.decode(), name), str(path), "exec", dont_inherit=True)
    try:
        kept.parent.mkdir(exist_ok=True)
        part = kept.with_suffix(f".{os.getpid()}")
        part.write_bytes(marshal.dumps(code))
        part.replace(kept)
    except OSError:  # a process that may not write
        pass
    return code


class _Overlong(Exception):
    """A test that takes too long to be of use."""


def _too_long(*_: object) -> None:
    raise _Overlong


class Plugin:
    """A line for each test: its outcome, time, and what ran in it and in the fixtures that it shares with others."""

    def __init__(self, record: _Record) -> None:
        self.record = record
        self.shared: dict[int, frozenset[str]] = {}
        self.numbers: dict[str, int] = {}
        self.outcome, self.start = "passed", 0.0
        self.file = (record.folder / "tests.jsonl").open("w")

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Iterator[None]:
        if fixturedef.scope == "function":
            return (yield)
        before = frozenset(self.record.seen)
        self.record.seen.clear()
        try:
            return (yield)
        finally:
            self.shared[id(fixturedef)] = frozenset(self.record.seen)
            self.record.seen.update(before)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: Any) -> Iterator[None]:
        self.record.seen.clear()
        self.outcome, self.start = "passed", time.perf_counter()
        self.fixtures: list[int] = []
        result = yield
        hits = self.record.seen.union(*(self.shared.get(each, frozenset()) for each in self.fixtures))
        numbers = sorted(self.numbers.setdefault(name, len(self.numbers)) for name in hits)
        seconds = round(time.perf_counter() - self.start, 4)
        row = {"test": item.nodeid, "outcome": self.outcome, "seconds": seconds, "hits": numbers}
        print(json.dumps(row), file=self.file, flush=True)
        return result

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: Any) -> Iterator[None]:
        self.fixtures = [id(each) for each in item._request._fixture_defs.values()] if hasattr(item, "_request") else []
        signal.signal(signal.SIGALRM, _too_long)
        signal.setitimer(signal.ITIMER_REAL, LONGEST)
        try:
            return (yield)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)

    def pytest_collection_finish(self) -> None:
        (self.record.folder / "imports.json").write_text(json.dumps(sorted(self.record.seen)))

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.outcome != "passed":
            self.outcome = report.outcome

    def pytest_sessionfinish(self) -> None:
        (self.record.folder / "names.json").write_text(json.dumps(list(self.numbers)))


def pytest_configure(config: pytest.Config) -> None:
    if _record is not None:
        _record.pid = os.getpid()
        config.pluginmanager.register(Plugin(_record))


if __name__ == "__main__":
    print(json.dumps(lines_of(Path(sys.argv[1]).read_text("utf-8"))))
