"""Running a command and measuring it from outside: wall time, resident memory of its children, what it says."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from hostile.cases import Case
from hostile.programs import ROOT

_PAGE = os.sysconf("SC_PAGE_SIZE")
GIVEN_UP = 300.0
MOST_OUTPUT = 20_000_000  # `flatten` writes what it is asked for
MOST_SAID = 200_000
_NEVER = re.compile(r"Traceback|internal error| at 0x[0-9a-f]{6}")
_CONTROLS = re.compile(r"[\x00-\x08\x1b]")  # a program's own log is cleaned for a terminal only


@dataclass(frozen=True)
class Base:
    """What a command costs that does almost nothing, from its start and from that of its child."""

    seconds: float
    working: float
    resident: int


@dataclass(frozen=True)
class Measured:
    """``working``: seconds since the command's child began, before which modules are loaded; None without a child."""

    seconds: float
    working: float | None
    resident: int
    code: int
    out: str
    err: str


def children(pid: int) -> list[int]:
    found: list[int] = []
    try:
        for task in os.listdir(f"/proc/{pid}/task"):
            found += map(int, Path(f"/proc/{pid}/task/{task}/children").read_text().split())
    except OSError:
        pass
    return found + [below for child in found for below in children(child)]


def resident(pid: int) -> int:
    try:
        with open(f"/proc/{pid}/statm") as statm:
            return int(statm.read().split()[1]) * _PAGE
    except (OSError, IndexError, ValueError):
        return 0


Measure = Callable[[Sequence[str], Path], Measured]


def measure(words: Sequence[str], folder: Path) -> Measured:
    """A command in a process of its own, start-up included."""
    command = [sys.executable, "-P", "-m", "scenelang", *words]
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        start = time.monotonic()
        running = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=err)
        most, pids, looked, forked = 0, [], 0.0, 0.0
        try:
            while running.poll() is None:
                now = time.monotonic()
                if now - looked > 0.02:
                    pids, looked = children(running.pid), now
                    forked = forked or (now if pids else 0.0)
                most = max([most, *map(resident, pids)])
                if now - start > GIVEN_UP:
                    break
                time.sleep(0.002)
        finally:
            took = time.monotonic() - start
            for pid in [*children(running.pid), running.pid] if running.poll() is None else []:
                os.kill(pid, 9)
            running.wait()
        said = [_text(stream) for stream in (out, err)]
    return Measured(took, start + took - forked if forked else None, most, running.returncode, *said)


def _text(stream: object) -> str:
    stream.seek(0)  # type: ignore[attr-defined]
    return stream.read(MOST_OUTPUT + 1).decode(errors="replace")  # type: ignore[attr-defined, no-any-return]


def base(folder: Path, options: Sequence[str], rounds: int = 3, by: Measure = measure) -> Base:
    (folder / "trivial.scene").write_text(ROOT)
    found = [by(("run", "trivial.scene", *options), folder) for _ in range(rounds)]
    working = sorted(f.working or 0.0 for f in found)[rounds // 2]
    return Base(sorted(f.seconds for f in found)[rounds // 2], working, max(f.resident for f in found))


def past(found: Measured, start: Base) -> float:
    """Seconds past start-up."""
    return found.seconds - start.seconds if found.working is None else found.working - start.working


def run_case(case: Case, folder: Path, limits: Sequence[str], by: Measure = measure) -> Measured:
    folder.mkdir()
    (folder / case.file).write_text(case.text, newline="")
    if case.make is not None:
        case.make(folder)
    return by((case.word, case.file, *limits, *case.options), folder)


def faults(case: Case, found: Measured, start: Base, seconds: float, memory: int, spare: float = 1.0) -> list[str]:
    """What is wrong with a run, in words; ``seconds`` and ``memory`` are the limits, ``spare`` the seconds beyond."""
    wrong = []
    if past(found, start) > seconds + spare:
        wrong.append(f"{past(found, start):.2f} s")
    if found.resident - start.resident > 1.1 * memory:
        wrong.append(f"{(found.resident - start.resident) / 1e6:.0f} MB")
    if found.code not in (0, 1):
        wrong.append(f"exit status {found.code}")
    told = _NEVER.search(found.out + found.err) or _CONTROLS.search(found.out)
    if told is not None:
        wrong.append(f"says {told.group()!r}")
    if len(found.err) > MOST_SAID or len(found.out) > MOST_OUTPUT:
        wrong.append(f"{len(found.err):,} characters said, {len(found.out):,} written")
    if found.code == 1 and not re.search(r"\bE\d\d\d\b", found.err):
        wrong.append("no code")
    return wrong


class Nursery:
    """Runs commands one after the other in copies of a process that is loaded already."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        paths = [str(Path(__file__).parent.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
        command = [sys.executable, "-P", "-m", "hostile.nursery"]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, env=environment, stdin=pipe, stdout=pipe, text=True, cwd=folder)

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(GIVEN_UP)

    def measure(self, words: Sequence[str], folder: Path) -> Measured:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        out, err = folder.with_suffix(".out"), folder.with_suffix(".err")
        request = {"words": list(words), "folder": str(folder), "out": str(out), "err": str(err)}
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        pid = int(self._process.stdout.readline())
        most = self._watched(pid, time.monotonic())
        code, took = self._process.stdout.readline().split()
        said = [path.read_bytes()[: MOST_OUTPUT + 1].decode(errors="replace") for path in (out, err)]
        return Measured(float(took), None, most, int(code), *said)

    def run(
        self, words: Sequence[str], folder: Path, text: str = "", timeout: float = GIVEN_UP
    ) -> subprocess.CompletedProcess[str]:
        """A command to its end, with ``text`` as its standard input and the environment of this process."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with tempfile.TemporaryDirectory() as name:
            given, out, err = (Path(name) / part for part in ("given", "out", "err"))
            given.write_text(text, "utf-8")
            request = {"words": list(words), "folder": str(folder), "out": str(out), "err": str(err)}
            request |= {"given": str(given), "environment": dict(os.environ)}
            self._process.stdin.write(json.dumps(request) + "\n")
            self._process.stdin.flush()
            pid = int(self._process.stdout.readline())
            late = threading.Timer(timeout, os.kill, (pid, 9))
            late.start()
            code = int(self._process.stdout.readline().split()[0])
            late.cancel()
            assert code != -9, f"it took longer than {timeout} s"
            said = [path.read_bytes().decode("utf-8", "backslashreplace") for path in (out, err)]
        return subprocess.CompletedProcess(list(words), code, *said)

    @staticmethod
    def _watched(pid: int, start: float) -> int:
        """The most that the copy and what it starts held, until it is gone."""
        most, pids, looked = 0, [], 0.0
        while is_running(pid):
            now = time.monotonic()
            if now - looked > 0.02:
                pids, looked = children(pid), now
            most = max([most, *map(resident, pids)])
            if now - start > GIVEN_UP:
                os.kill(pid, 9)
                break
            time.sleep(0.002)
        return most


def is_running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
