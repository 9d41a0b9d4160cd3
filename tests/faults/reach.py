"""Which tests can see a fault, from what the probes wrote, and in which order they are tried."""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from faults.patches import Fault, Place, index_of, place_of

sys.path.insert(0, str(Path(__file__).with_name("hook")))
from fault_probe import lines_of

BUDGET = 25.0  # seconds of tests for one fault
EARLY = 12.0  # the same where a new process collects them first
AT_FIRST = 3  # tests of each file that are tried before further ones


@dataclass(frozen=True, slots=True)
class Test:
    name: str
    seconds: float

    @property
    def file(self) -> str:
        return self.name.partition("::")[0]

    @property
    def function(self) -> str:
        return self.name.partition("[")[0]


@dataclass(frozen=True, slots=True)
class Plan:
    """The tests to try for a fault; ``early`` where importing the modules runs its line already."""

    fault: Fault
    place: Place | None = None  # None where the checkout has no such line
    tests: tuple[str, ...] = ()
    reaching: int = 0
    early: bool = False


@dataclass(frozen=True, slots=True)
class Reached:
    """The tests that pass without faults and reach a line; ``early`` where importing the modules runs it already."""

    tests: tuple[Test, ...]
    early: bool


class Reach:
    """What the probes of one checkout wrote in ``folder``."""

    def __init__(self, tree: Path, folder: Path) -> None:
        self.tree = tree
        names: list[str] = json.loads((folder / "names.json").read_text("utf-8"))
        self.early = set(json.loads((folder / "imports.json").read_text("utf-8")))
        self.tests: dict[str, Test] = {}
        self.by_probe: dict[str, set[str]] = defaultdict(set)
        self.by_process: dict[str, set[str]] = defaultdict(set)
        with (folder / "tests.jsonl").open() as rows:
            for row in map(json.loads, rows):
                if row["outcome"] == "passed":
                    self.tests[row["test"]] = Test(row["test"], row["seconds"])
                    for number in row["hits"]:
                        self.by_probe[names[number]].add(row["test"])
        self._add_processes(folder / "processes.txt")

    def _add_processes(self, path: Path) -> None:
        """A process says once that a line ran. Later tests that share it, such as a language server, may reach it too."""
        with path.open(errors="replace") as rows:
            for row in rows:
                test, _, probe = row.rstrip("\n").partition("\t")
                test = test.rpartition(" (")[0]
                if test in self.tests:
                    self.by_probe[probe].add(test)
                    self.by_process[probe].add(self.tests[test].file)

    def reached(self, place: Place) -> Reached:
        lines = lines_of((self.tree / place.path).read_text("utf-8"))
        probe = f"{place.path}:{lines[place.number]}"
        found = self.by_probe.get(probe, set())
        shared = self.by_process.get(probe, set())
        found = found | {name for name, test in self.tests.items() if test.file in shared}
        if early := probe in self.early:  # its effect is in what the module made, so any test of the module may see it
            found = found.union(*(self.by_probe.get(f"{place.path}:{line}", ()) for line in set(lines.values())))
        return Reached(tuple(self.tests[name] for name in sorted(found)), early)


def plan(fault: Fault, place: Place, reached: Reached) -> Plan:
    tests = affordable(in_order(reached.tests, 1 if reached.early else AT_FIRST), EARLY if reached.early else BUDGET)
    return Plan(fault, place, tuple(test.name for test in tests), len(reached.tests), reached.early)


def plans(tree: Path, folder: Path, faults: Iterable[Fault]) -> Iterator[Plan]:
    index, reach = index_of(tree), Reach(tree, folder)
    for fault in faults:
        place = place_of(fault, index)
        yield plan(fault, place, reach.reached(place)) if place is not None else Plan(fault)


def in_order(tests: Iterable[Test], at_first: int) -> list[Test]:
    """A few cheap tests of each file first, of different functions; then the rest, file after file."""
    files: dict[str, list[Test]] = defaultdict(list)
    for test in sorted(tests, key=lambda test: (test.seconds, test.name)):
        files[test.file].append(test)
    first = {name: _different(found)[:at_first] for name, found in files.items()}
    cheapest = sorted(files, key=lambda name: (sum(test.seconds for test in first[name]), name))
    rest = {name: [test for test in files[name] if test not in first[name]] for name in files}
    return [test for part in (first, rest) for name in cheapest for test in part[name]]


def _different(tests: Sequence[Test]) -> list[Test]:
    return list({test.function: test for test in reversed(tests)}.values())[::-1]


def affordable(tests: Iterable[Test], budget: float) -> list[Test]:
    """The tests that fit in ``budget``, in their order; the first in any case."""
    chosen: list[Test] = []
    for test in tests:
        if test.seconds <= budget or not chosen:
            chosen.append(test)
            budget -= test.seconds
    return chosen
