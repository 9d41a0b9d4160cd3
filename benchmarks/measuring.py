"""What a row of the benchmark is, and how its figures come about.

A *probe* measures once: seconds of processor time, unless its row says otherwise. A row measures ours and what is
beside it in turns (ours, other, ours, other, ...), in a process of its own, and reports medians; a minimum tells of the
one run that nothing disturbed, on one side only. The collector of garbage is off on both sides: with it on, plain
Python objects beside ours take up to three times as long, by how many objects the process happened to have before.
"""

from __future__ import annotations

import gc
import json
import os
import re
import resource
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
ROOT = HERE.parent
PEERS = ROOT / ".venv" / "bench" / "bin" / "python"
DEPTH = 100_000  # calls that a deep program may nest
NOT_INSTALLED = 3  # how a process ends that lacks what it measures

Probe = Callable[[], float]


class Absent(Exception):
    """What a row needs is not on this machine; the message says what."""


@dataclass(frozen=True)
class Goal:
    """The most that a row may show of "ratio", "instructions" (their ratio), "ours" in seconds or "memory" in bytes."""

    most: float
    of: str = "ratio"


@dataclass(frozen=True)
class Pair:
    """Probes of ours and of the other, of which one row can have several: a program each."""

    ours: Probe
    other: Probe | None = None


@dataclass(frozen=True)
class Row:
    """A row: ``pairs`` prepares it, in its own process. ``summary`` makes one figure of those of several pairs."""

    name: str
    pairs: Callable[[], Iterable[Pair]]
    other: str = ""
    goals: tuple[Goal, ...] = ()
    rounds: int = 5
    counts: bool = False
    summary: Callable[[Sequence[float]], float] = statistics.median


@dataclass(frozen=True)
class Figures:
    """What a row shows: seconds, instructions of ours and their ratio, bytes of ours."""

    ours: float
    other: float | None = None
    ratio: float | None = None
    instructions: int | None = None
    instruction_ratio: float | None = None
    memory: float | None = None

    def reached(self, goal: Goal) -> bool | None:
        """Return whether a goal is reached; None if the figure could not be measured."""
        by_name = {
            "ratio": self.ratio,
            "instructions": self.instruction_ratio,
            "ours": self.ours,
            "memory": self.memory,
        }
        shown = by_name[goal.of]
        return None if shown is None else shown <= goal.most


def figures_of(row: Row) -> Figures:
    """Measure a row in this process."""
    medians, memory = [], []
    for pair in row.pairs():
        medians.append(interleaved(pair, row.rounds))
        memory += pair.ours.memory_used if isinstance(pair.ours, Child) else []
    if not medians:
        raise Absent("there is no such program")
    others = [other for _, other in medians if other is not None]
    ratios = [ours / other for ours, other in medians if other is not None]
    return Figures(
        row.summary([ours for ours, _ in medians]),
        row.summary(others) if others else None,
        row.summary(ratios) if ratios else None,
        memory=statistics.median(memory) if memory else None,
    )


def interleaved(pair: Pair, rounds: int) -> tuple[float, float | None]:
    """Return the medians of measurements in turns: ours, other, ours, other, ..."""
    ours, others = [], []
    for _ in range(rounds):
        ours.append(pair.ours())
        if pair.other is not None:
            others.append(pair.other())
    return statistics.median(ours), statistics.median(others) if others else None


# --- probes -------------------------------------------------------------------------------------------------------


def clocked(action: Callable[[], Any], collecting: bool = False) -> float:
    """Seconds of processor time of an action."""
    gc.collect()
    if not collecting:
        gc.disable()
    try:
        started = time.process_time()
        kept = action()  # freeing what it returns is not part of it
        taken = time.process_time() - started
        del kept
    finally:
        gc.enable()
    return taken


@dataclass(frozen=True)
class Timed:
    """The probe of an action in this process, on what ``prepare`` returns; ``deep`` gives it a stack for recursion."""

    action: Callable[[Any], Any]
    prepare: Callable[[], Any] = lambda: None
    collecting: bool = False
    deep: bool = False

    def __call__(self) -> float:
        return self._prepared(lambda state: clocked(partial(self.action, state), self.collecting))

    def forked(self) -> tuple[int, int]:
        """Run nothing, and the action, in processes that are forked where the action would begin; return their ids."""
        if not self.deep:
            self()  # imports of the first run are not the action's; of a program, they are .2 % of what `fib` takes
        return self._prepared(lambda state: (_fork(lambda: None), _fork(partial(self.action, state))))

    def _prepared(self, use: Callable[[Any], Any]) -> Any:
        if not self.deep:
            return use(self.prepare())
        from scenelang.session.session import run_with_room

        return run_with_room(lambda: use(self.prepare()), DEPTH)


def timed(action: Callable[[], Any], *, collecting: bool = False) -> Timed:
    """Return the probe of an action that needs no preparation."""
    return Timed(lambda _: action(), collecting=collecting)


def _fork(action: Callable[[], Any]) -> int:
    gc.disable()
    child = os.fork()
    if child == 0:
        try:
            action()
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    return child


@dataclass(frozen=True)
class Process:
    """The probe of a whole process, with its children."""

    words: tuple[str, ...]

    def __call__(self) -> float:
        before = children_seconds()
        done = subprocess.run(self.words, capture_output=True, text=True, check=False, cwd=ROOT)
        if done.returncode == NOT_INSTALLED:
            raise Absent(done.stderr.strip())
        if done.returncode:
            raise RuntimeError(f"{' '.join(self.words)}: {(done.stderr or done.stdout)[-500:]}")
        return children_seconds() - before


def command(*words: str) -> Process:
    """Return the probe of a command of the package; ``python`` starts the script without a search in PATH."""
    return Process((sys.executable, str(Path(sys.executable).with_name("scenelang")), *words))


def children_seconds() -> float:
    """Seconds of processor time of the children of this process that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@dataclass(frozen=True)
class Child:
    """The probe of a script of this folder, in a process of its own: it prints seconds and, as ``memory``, bytes."""

    script: str
    words: tuple[str, ...]
    memory: str = ""
    python: str = sys.executable
    memory_used: list[float] = field(default_factory=list)

    def __call__(self) -> float:
        line = [self.python, str(HERE / self.script), *self.words]
        done = subprocess.run(line, capture_output=True, text=True, check=False)
        if done.returncode == NOT_INSTALLED:
            raise Absent(done.stderr.strip())
        if done.returncode:
            raise RuntimeError(f"{self.script}: {done.stderr[-500:]}")
        shown: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
        self.memory_used.extend([shown[self.memory]] if self.memory else [])
        return shown["seconds"]


def peer(*words: str) -> Child:
    """Return the probe of a task of ``peers.py`` in the environment of the peers; a process of its own each time."""
    return Child("peers.py", words, python=peers_python())


def peer_process(*words: str) -> Process:
    """Return the probe of a task of ``peers.py`` as a command, with the start of its process."""
    return Process((peers_python(), str(HERE / "peers.py"), *words))


def peers_python() -> str:
    """Return the Python of the peers."""
    if not PEERS.exists():
        raise Absent(f"{PEERS.relative_to(ROOT)} is not there: `make bench` makes it")
    return str(PEERS)


def peak_memory() -> int:
    """The most bytes that this process held; what ``getrusage`` tells begins with the parent's."""
    status = Path("/proc/self/status")
    match = re.search(r"VmHWM:\s*(\d+)", status.read_text()) if status.exists() else None
    return (int(match[1]) if match else resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) * 1024


# --- instruction counts -------------------------------------------------------------------------------------------

VALGRIND = ("valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null")
_COUNT = re.compile(r"^==(\d+)== I\s+refs:\s+([\d,]+)", re.M)


def counted(words: Sequence[str]) -> tuple[dict[int, int], str]:
    """Run words under valgrind; return the instructions of each process by its id, and the output."""
    if shutil.which(VALGRIND[0]) is None:
        raise Absent("valgrind is absent: no instruction counts")
    environment = {**os.environ, "PYTHONHASHSEED": "0"}  # the order of sets decides a few per cent
    done = subprocess.run([*VALGRIND, *words], capture_output=True, text=True, check=False, env=environment, cwd=ROOT)
    counts = {int(pid): int(number.replace(",", "")) for pid, number in _COUNT.findall(done.stderr)}
    if done.returncode or not counts:
        raise RuntimeError(f"{' '.join(words)} under valgrind: {done.stderr[-500:]}")
    return counts, done.stdout


def instructions_of(row: Row, forks: Sequence[str]) -> tuple[int, int | None]:
    """Instructions of ours and of the other, of the first pair; ``forks`` are the words that run ``print_forks``.

    An action is what a forked process counts beyond one that was forked in its place and does nothing: they inherit
    the count of their parent. What valgrind does not know, a command does without: of the system calls, ``pidfd_open``,
    so that commands run in one process, without their monitor.
    """
    pair = next(iter(row.pairs()))
    probes = [pair.ours] if pair.other is None else [pair.ours, pair.other]
    if isinstance(pair.ours, Process):
        each = [sum(counted(probe.words)[0].values()) for probe in probes if isinstance(probe, Process)]
    else:
        counts, printed = counted(forks)
        each = [counts[after] - counts[before] for before, after in json.loads(printed.splitlines()[-1])]
    return each[0], each[1] if len(each) > 1 else None


def print_forks(row: Row) -> None:
    """Run the probes of a row in forked processes, and print their ids; under valgrind."""
    pair = next(iter(row.pairs()))
    probes = [probe for probe in (pair.ours, pair.other) if isinstance(probe, Timed)]
    print(json.dumps([probe.forked() for probe in probes]))
