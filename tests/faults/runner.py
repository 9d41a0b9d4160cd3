"""Runs the tests of each fault in a process of its own, forked from one that has collected all tests.

A pytest plug-in that takes the place of the loop over the tests, with the interpreter of the checkout. The fault is written into the file, for processes that tests start, and into the
functions that are loaded. Where importing a module already runs the line, a fresh process runs the tests.
"""

from __future__ import annotations

import gc
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import pytest
from _pytest.main import pytest_runtestloop as run_items

from faults.patches import Fault, Place, read_records, with_fault
from faults.reach import Plan, plans

MARKERS = "not gpu and not slow and not browser"
TIMEOUT = 60.0
STARTING = 60.0  # further seconds for a process that collects its tests itself
MEMORY = 5_000_000_000
_CANNOT = 77  # the exit status where the loaded functions cannot be changed


@dataclass(frozen=True, slots=True)
class Result:
    fault: Fault
    result: str  # caught, survived, unreached, missing
    how: str = ""  # test, timeout, memory, crash
    test: str = ""
    reaching: int = 0
    ran: int = 0
    seconds: float = 0.0
    fresh: bool = False


@contextmanager
def planted(tree: Path, place: Place, fault: Fault, serial: int) -> Iterator[str]:
    """The fault in the file of the checkout; a time of its own, so that no compiled file is mistaken for its."""
    path = tree / place.path
    before, stat = path.read_bytes(), path.stat()
    changed = with_fault(before.decode(), place, fault)
    try:
        path.write_text(changed, "utf-8")
        os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns + (1000 + serial) * 1_000_000_000))
        yield changed
    finally:
        path.write_bytes(before)
        os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))


def codes_of(code: CodeType) -> Iterator[CodeType]:
    yield code
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from codes_of(inner)


def replace_codes(path: Path, source: str, functions: list[FunctionType]) -> None:
    """The loaded functions of a module as ``source`` has them."""
    compiled = codes_of(compile(source, str(path), "exec", dont_inherit=True))
    codes = {(code.co_qualname, code.co_firstlineno): code for code in compiled}
    for function in functions:
        old = function.__code__
        new = codes.get((old.co_qualname, old.co_firstlineno), old)
        if new != old:
            function.__code__ = new


class Runner:
    def __init__(self, tree: Path, plans: list[Plan], results: Path, rest: Path) -> None:
        self.tree, self.plans, self.results, self.rest = tree, plans, results, rest
        self.failed = -1

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: Any) -> bool:
        os.environ["PYTHONDONTWRITEBYTECODE"], sys.dont_write_bytecode = "1", True
        self.session, self.items = session, {item.nodeid: item for item in session.items}
        self.functions: dict[str, list[FunctionType]] = {}
        for each in gc.get_objects():
            if isinstance(each, FunctionType):
                self.functions.setdefault(each.__code__.co_filename, []).append(each)
        gc.collect()
        gc.freeze()
        with self.results.open("a") as file:
            for serial, plan in enumerate(self.plans):
                print(json.dumps(asdict(self._result(plan, serial))), file=file, flush=True)
        return True

    def _result(self, plan: Plan, serial: int) -> Result:
        if plan.place is None:
            return Result(plan.fault, "missing")
        tests = [name for name in plan.tests if name in self.items]
        if not tests:
            return Result(plan.fault, "unreached", reaching=plan.reaching)
        start = time.monotonic()
        how, test, fresh = self._run(plan, tests, serial)
        if how and test in self.items and self._forked(plan.place, None, [test])[0]:  # it fails without the fault too
            tests.remove(test)
            how, test, fresh = self._run(plan, tests, serial)
        seconds = round(time.monotonic() - start, 2)
        result = "caught" if how else "survived"
        return Result(plan.fault, result, how, test, plan.reaching, len(tests), seconds, fresh)

    def _run(self, plan: Plan, tests: list[str], serial: int) -> tuple[str, str, bool]:
        assert plan.place is not None
        with planted(self.tree, plan.place, plan.fault, serial) as source:
            if not plan.early:
                how, test = self._forked(plan.place, source, tests)
                if how != "cannot":
                    return how, test, False
            return *self._fresh(tests), True

    def _forked(self, place: Place, source: str | None, tests: list[str]) -> tuple[str, str]:
        folder = Path(tempfile.mkdtemp(dir=self.rest))
        said, say = os.pipe()
        child = os.fork()
        if not child:
            os.setsid()
            status = 70
            try:
                self.failed = say
                self.session.config._tmp_path_factory._given_basetemp = folder / "tmp"
                status = self._in_child(place, source, tests)
            finally:
                os._exit(status)
        os.close(say)
        how = _end_of(child, TIMEOUT)
        with os.fdopen(said, "rb") as file:
            os.set_blocking(said, False)
            test = (file.read() or b"").decode().partition("\n")[0]
        shutil.rmtree(folder, ignore_errors=True)
        return how, test

    def _in_child(self, place: Place, source: str | None, tests: list[str]) -> int:
        path, session = self.tree / place.path, self.session
        try:
            if source is not None:
                replace_codes(path, source, self.functions.get(str(path), []))
        except ValueError:  # other free variables than before
            return _CANNOT
        session.items = [self.items[test] for test in tests]
        session.config.option.maxfail = 1
        try:
            run_items(session)
        except (session.Failed, session.Interrupted):
            return 1
        return 1 if session.testsfailed else 0

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed and self.failed >= 0:
            os.write(self.failed, f"{report.nodeid}\n".encode())

    def _fresh(self, tests: list[str]) -> tuple[str, str]:
        folder = Path(tempfile.mkdtemp(dir=self.rest))
        (folder / "names").write_text("\n".join(tests), "utf-8")
        words = [sys.executable, "-P", "-m", "pytest", *arguments(), "-x", f"--basetemp={folder / 'tmp'}"]
        with (folder / "log").open("wb") as log:
            words.append(f"@{folder / 'names'}")
            child = subprocess.Popen(words, cwd=self.tree, stdout=log, stderr=log, start_new_session=True)
            how = _end_of(child.pid, TIMEOUT + STARTING)
            child.returncode = 0  # waited for above
        said = (folder / "log").read_text("utf-8", "replace").splitlines()
        test = next((line for line in said if line.startswith(("FAILED ", "ERROR "))), "")
        shutil.rmtree(folder, ignore_errors=True)
        return how, test.removeprefix("FAILED ").partition(" - ")[0]


def _end_of(child: int, timeout: float) -> str:
    """How a process ended: "" for tests that all passed."""
    end, how = time.monotonic() + timeout, ""
    while True:
        pid, status = os.waitpid(child, os.WNOHANG)
        if pid:
            break
        if time.monotonic() > end or _resident(child) > MEMORY:
            how = "timeout" if time.monotonic() > end else "memory"
            os.killpg(child, signal.SIGKILL)
            _, status = os.waitpid(child, 0)
            break
        time.sleep(0.01)
    try:
        os.killpg(child, signal.SIGKILL)  # what tests left behind
    except ProcessLookupError:
        pass
    code = os.waitstatus_to_exitcode(status)
    return how or {0: "", 1: "test", _CANNOT: "cannot"}.get(code, f"crash {code}")


def _resident(pid: int) -> int:
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError):
        return 0


def arguments() -> list[str]:
    return ["-q", "-p", "no:cacheprovider", "--tb=no", "-m", MARKERS]


def run(tree: Path, todo: Iterable[Plan], results: Path) -> int:
    """The results of plans that have none yet, a line for each."""
    rows = map(json.loads, results.read_text("utf-8").splitlines()) if results.is_file() else ()
    done = {Fault(**row["fault"]) for row in rows}
    os.chdir(tree)
    resource.setrlimit(resource.RLIMIT_DATA, (2 * MEMORY, 2 * MEMORY))
    with tempfile.TemporaryDirectory() as rest:
        runner = Runner(tree, [plan for plan in todo if plan.fault not in done], results, Path(rest))
        return int(pytest.main([*arguments(), "tests"], plugins=[runner]))


def main(tree: str, folder: str, records: str, results: str) -> int:
    return run(Path(tree), plans(Path(tree), Path(folder), read_records(Path(records))), Path(results))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
