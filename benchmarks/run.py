"""`make bench`: every row with its goal; `make bench ONLY=name` for the rows whose names contain that.

A row is measured in a process of its own (``measuring``). A workload of bare Python, which no change of ours moves, is
measured before each row: it says how steady the machine was. A whole run becomes an entry of ``history.jsonl``.
"""

from __future__ import annotations

import json
import os
import shutil
import statistics
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from importlib import import_module

import history
from measuring import NOT_INSTALLED, VALGRIND, Absent, Figures, Row, clocked, figures_of, instructions_of, print_forks

MODULES = (
    "processes", "language", "reading", "large", "editing", "published",
    "pictures", "exports", "labeled", "solids", "blocks",
)  # fmt: skip
SAID = {True: "reached", False: "MISSED", None: "not measured"}
LONGEST = 600  # seconds of one row, which then failed


def control() -> float:
    """Seconds of a workload in bare Python: calls, numbers, lists, dictionaries."""

    def fib(n: int) -> int:
        return n if n < 2 else fib(n - 1) + fib(n - 2)

    def work() -> int:
        rows = {i: [i, str(i)] for i in range(60_000)}
        return fib(20) + sum(len(row[1]) for row in rows.values())

    return clocked(work)


def chosen(only: str) -> Iterator[tuple[str, Row]]:
    """Iterate over the rows whose names contain ``only``, or the name of whose module it is, each with its module."""
    for module in MODULES:
        for row in import_module(module).ROWS:
            if only in row.name or only == module:
                yield module, row


def measure(module: str, name: str) -> int:
    """Measure one row in this process and print its figures, JSON."""
    row = row_of(module, name)
    try:
        figures = figures_of(row)
    except Absent as absent:
        print(absent, file=sys.stderr)
        return NOT_INSTALLED
    if row.counts:
        try:
            ours, other = instructions_of(row, (sys.executable, __file__, "--forks", module, name))
            figures = replace(figures, instructions=ours, instruction_ratio=ours / other if other else None)
        except Absent:
            pass  # told once, by the parent
    print(json.dumps(asdict(figures)))
    return 0


def row_of(module: str, name: str) -> Row:
    return next(row for row in import_module(module).ROWS if row.name == name)


def measured(module: str, row: Row) -> Figures | str:
    """Measure a row in a process of its own; what there is no figure of is said instead."""
    words = [sys.executable, __file__, "--row", module, row.name]
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        return f"it takes more than {LONGEST} s"
    if done.returncode == NOT_INSTALLED:
        return f"absent: {done.stderr.strip()}"
    if done.returncode:
        return f"ended with {done.returncode}: {(done.stderr.strip().splitlines() or [''])[-1]}"
    return Figures(**json.loads(done.stdout.splitlines()[-1]))


# --- the table ----------------------------------------------------------------------------------------------------


def line_of(row: Row, figures: Figures | str) -> str:
    """Return the line of a row in the table."""
    if isinstance(figures, str):
        return f"{row.name:48} {figures}"
    other = f"{row.other} {history.seconds_text(figures.other)}" if figures.other is not None else ""
    ratio = f"x{figures.ratio:.3g}" if figures.ratio is not None else ""
    more = [
        "" if figures.instructions is None else f"{figures.instructions / 1e6:,.0f} M",
        "" if figures.instruction_ratio is None else f"x{figures.instruction_ratio:.2f}",
        "" if figures.memory is None else history.bytes_text(figures.memory),
    ]
    goals = ", ".join(f"{history.goal_text(goal)} {SAID[figures.reached(goal)]}" for goal in row.goals)
    cells = f"{row.name:48} {history.seconds_text(figures.ours):>8}  {other:36} {ratio:>7}"
    return f"{cells}  {', '.join(filter(None, more)):16} {goals}".rstrip()


def run(only: str) -> int:
    """Measure rows, print the table, and compare a whole run with the history."""
    rows = list(chosen(only))
    if not rows:
        print(f"no row has {only!r} in its name")
        return 2
    name, steadiness, results = history.commit(), [], {}  # the commit at the start: a run takes a while
    for module, row in rows:
        steadiness.append(control())
        results[row.name] = measured(module, row)
        print(line_of(row, results[row.name]), flush=True)
    entry = {"commit": name} | history.entry_of({row.name: row for _, row in rows}, results, steadiness)
    print(f"control: {statistics.median(steadiness) * 1e3:.1f} ms, within {100 * entry['control']['spread']:.0f} %")
    if shutil.which(VALGRIND[0]) is None:
        print("valgrind is absent: no instruction counts")
    problems = [f"{name}: {said}" for name, said in results.items() if isinstance(said, str) and said[:6] != "absent"]
    return history.report(entry, problems, keeps=not only)


def main(words: Sequence[str]) -> int:
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # processes are timed with their bytecode
    if words and words[0] in ("--row", "--forks"):
        if words[0] == "--row":
            return measure(words[1], words[2])
        print_forks(row_of(words[1], words[2]))
        return 0
    return run(words[0] if words else "")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
