"""Whole processes: commands beside a bare Python, responses of language models beside the reference, requests."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from measuring import HERE, ROOT, Goal, Pair, Process, Row, command

FIGURE = "examples/paper/chessboard.scene"
PUBLISHED = "tests/corpus/n16-newtons-cradle.scene"
RESPONSES = sorted((ROOT / "tests" / "transpile" / "responses").glob("*.txt"))
LONGEST = sorted(RESPONSES, key=lambda path: path.stat().st_size)[-5:]
BARE = Process((sys.executable, "-c", "pass"))


def responses(paths: Sequence[Path] = RESPONSES) -> Iterator[Pair]:
    """Responses as `run RESPONSE.txt`, and their evaluation by the reference in a process of its own."""
    for path in paths:
        yield Pair(command("run", str(path)), Process((sys.executable, str(HERE / "published.py"), str(path))))


def request() -> list[Pair]:
    """What a request costs: a fork with the modules loaded, the monitor, the way back of the answer."""
    from scenelang.sandbox.worker import Worker

    worker = Worker(_nothing)

    def asked() -> float:
        started = time.perf_counter()
        worker.ask()
        return time.perf_counter() - started

    return [Pair(asked)]


def _nothing() -> None:
    from scenelang.interpreter.values.limits import Limits
    from scenelang.sandbox.supervision import limited

    with limited(Limits()):
        pass


def _beside_bare(*words: str) -> list[Pair]:
    return [Pair(command(*words), BARE)]


ROWS = (
    Row(
        "process `check`, Figure 2", partial(_beside_bare, "check", FIGURE), "bare Python",
        (Goal(8.0, "instructions"),), counts=True,
    ),
    Row(
        "process `--help`", partial(_beside_bare, "--help"), "bare Python",
        (Goal(3.5, "instructions"),), counts=True,
    ),
    Row("process `run`, a program of 4 KB", partial(_beside_bare, "run", PUBLISHED), "bare Python"),
    Row(
        "process `import scenelang`", lambda: [Pair(Process((sys.executable, "-c", "import scenelang")), BARE)],
        "bare Python", counts=True,
    ),
    Row(
        f"process `run RESPONSE.txt`, median of {len(RESPONSES)}", responses, "reference", (Goal(0.3, "ours"),),
        rounds=1,
    ),
    Row(
        "process `run RESPONSE.txt`, slowest of the longest", partial(responses, LONGEST), "reference",
        (Goal(0.3, "ours"),), rounds=3, summary=max,
    ),
    Row("a request in a process of its own, by the clock", request, goals=(Goal(0.005, "ours"),), rounds=20),
)  # fmt: skip
