"""Thirty hostile programs as commands under limits below a second: each ends, in its memory, in good form; and through
the MCP server, which answers while they run. `make test-hostile` runs all of them, and measures when they end."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hostile.cases import Case, every
from hostile.measuring import Base, Measured, Nursery, base, faults, run_case
from mcp_server.conftest import Agent, served
from searching import places
from support import PATIENCE, below, is_running, wait_for_work

from scenelang.sandbox.supervision import is_supported

pytestmark = pytest.mark.skipif(not is_supported(), reason="hard limits need Linux")
SECONDS, MEMORY = 0.3, 300_000_000
LIMITS = ("--max-seconds", "0.3", "--max-memory", "300M")
_COMMANDS = (
    "huge_arguments: trim by a long cut set", "huge_arguments: search almost equal texts", "huge_arguments: join long pieces",
    "huge_arguments: solve", "huge_arguments: samples kept", "huge_arguments: insert in front", "shared data: sort",
    "shared data: error", "shared data: flatten", "shared data: list to set", "deep data: equality", "cyclic data: table key",
    "collisions: set", "collisions: list to table", "errors: long list in an error", "errors: nested errors", "output: lines",
    "output: long lines", "formats: many fields", "integers: squares", "macros: doubling", "macros: computed memory",
    "scenes: union of doublings", "scenes: frames without end", "assets: doubling nodes", "assets: picture bomb",
    "texts: nested", "python: names assigned", "embeddings: huge sparse", "imports: device",
)  # fmt: skip
CHOSEN = tuple(_COMMANDS[i] for i in places(len(_COMMANDS)))  # every third as usual


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[Base, dict[str, tuple[Case, Measured]]]:
    """All of them, two at a time, beside what a trivial program costs."""
    root = tmp_path_factory.mktemp("hostile")
    cases = {case.name: case for case in every() if case.name in CHOSEN}
    assert len(cases) == len(CHOSEN)
    with ThreadPoolExecutor(2) as pool:
        halves = list(pool.map(lambda number: _half(root, cases, number), (0, 1)))
    return halves[0][0], halves[0][1] | halves[1][1]


def _half(root: Path, cases: dict[str, Case], number: int) -> tuple[Base, dict[str, tuple[Case, Measured]]]:
    """Every second case, by a process of its own, so that start-up is paid twice and not thirty times."""
    folder = root / f"half-{number}"
    folder.mkdir()
    nursery = Nursery(folder)
    try:
        start = base(folder, LIMITS, by=nursery.measure)
        found = {}
        for name in CHOSEN[number::2]:
            place = root / name.replace(" ", "-").replace("'", "").replace(":", "").replace(",", "")
            found[name] = cases[name], run_case(cases[name], place, LIMITS, nursery.measure)
        return start, found
    finally:
        nursery.close()


@pytest.mark.search
@pytest.mark.parametrize("name", CHOSEN)
def test_a_hostile_command_ends_at_its_limits(
    name: str, measured: tuple[Base, dict[str, tuple[Case, Measured]]]
) -> None:
    start, found = measured
    case, result = found[name]
    assert faults(case, result, start, SECONDS, MEMORY, spare=math.inf) == []  # how late does not count here


def test_the_table_is_long() -> None:
    names = [case.name for case in every()]
    assert len(names) == len(set(names))
    assert len(names) >= 280


# What never ends and takes little memory.
HOLDING = (
    "huge_arguments: contains in almost equal texts", "huge_arguments: sort long texts", "huge_arguments: format of a long list",
    "huge_arguments: transpose of nested lists", "collisions: table merged", "errors: long list in an error",
    "errors: error with a set", "errors: unknown keyword", "output: long lines", "formats: many fields", "integers: division",
    "integers: text times",
)  # fmt: skip
ENDLESS = ("--max-seconds", "1000000", "--max-steps", "1000G", "--max-memory", "300M")


@pytest.fixture(scope="module")
def agent(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Agent, int]]:
    """An agent, and the number of its server's process."""
    folder = tmp_path_factory.mktemp("agent") / "project"
    folder.mkdir()
    before = below(os.getpid())
    with served(folder, *ENDLESS) as agent:
        agent.call("help", name="sort")
        yield agent, next(pid for pid in below(os.getpid()) if pid not in before)


@pytest.mark.parametrize("name", HOLDING)
@pytest.mark.sampled(4)
def test_the_server_answers_while_a_hostile_program_runs(name: str, agent: tuple[Agent, int]) -> None:
    asking, server = agent
    (case,) = (case for case in every() if case.name == name)
    idle = below(server)
    running = asking.begin("run", program=case.text)
    worker = wait_for_work(server, 0.3, idle)
    asking.begin("help", name="sort").result(PATIENCE)
    assert not running.done()
    running.cancel()
    after = asking.told("run", program='(bind "a" (lambda () (call "cube")))')  # comes when the other has ended
    assert after["ok"]
    assert not is_running(worker)
