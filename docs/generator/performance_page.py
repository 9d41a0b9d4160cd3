"""The page of speed, from the last entry of the history of `make bench`."""

from __future__ import annotations

import json
import runpy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from generator.markdown import NOTICE, table

HISTORY = Path(__file__).parents[2] / "benchmarks" / "history.jsonl"
_TEXTS = runpy.run_path(str(HISTORY.with_suffix(".py")))
_SAID = {True: "reached", False: "**missed**", None: "not measured"}
_PAGE = """{notice}
# Speed

`make bench` measures this table, `make bench ONLY=fib` some of its rows.

Commit {commit}, {date}, Python {python}, {cpu}. A workload of bare Python between the rows took {control};
the middle half of its runs lay within {spread:.0f} % of that, which is what a time may owe to other work.

{table}
{unmeasured}
- **Times** are seconds of processor time, or by the clock where a row says so: medians of runs in turns (ours, the
  other, ours, the other), in a process of its own for each row. The collector of garbage is off on both sides unless
  the row says otherwise.
- **Instructions** are counted by cachegrind: ours in millions, and their ratio to the other's. Other work does not
  change them. Commands run without their monitor there, since valgrind lacks a system call that it uses.
- **Python** beside a program is the same computation in functions and classes as one writes them.
- **The reference** is the tests' model of the authors' package, which runs the Python of a language model in CPython.
- **Strangers' programs** (`benchmarks/strangers`) are by people who knew the language and not its interpreter; nobody
  tunes to them.
- **Memory** is that of ours: in MB and GB in all, in B and KB of a line or a primitive.

A row fails if it takes more than 5 % more instructions than in the last entry of the same Python; if it takes more
time, only when the workload of bare Python moved by less than 5 %.
"""


def performance_page() -> str:
    """Return the page with the table of all rows, Markdown."""
    entry = json.loads(HISTORY.read_text("utf-8").splitlines()[-1])
    rows = [_cells(name, row) for name, row in entry["rows"].items()]
    return _PAGE.format(
        notice=NOTICE,
        commit=entry["commit"],
        date=entry["date"],
        **entry["machine"],
        control=_TEXTS["seconds_text"](entry["control"]["seconds"]),
        spread=100 * entry["control"]["spread"],
        unmeasured=_unmeasured(entry.get("unmeasured", {})),
        table="\n".join(table(("", "ours", "beside it", "ratio", "instructions", "goal"), rows)),
    )


def _unmeasured(reasons: Mapping[str, str]) -> str:
    """Return a paragraph with the rows of which the run has no figures; empty without any."""
    if not reasons:
        return ""
    return f"Without figures in this run: {', '.join(reasons)}.\n"


def _cells(name: str, row: dict[str, Any]) -> tuple[str, ...]:
    seconds = _TEXTS["seconds_text"]
    counts = [f"{row['instructions'] / 1e6:,.0f} M"] if "instructions" in row else []
    counts += [f"x{row['instruction_ratio']:.2f}"] if "instruction_ratio" in row else []
    return (
        name,
        seconds(row["ours"]) + (f", {_TEXTS['bytes_text'](row['memory'])}" if "memory" in row else ""),
        f"{row['beside']}: {seconds(row['other'])}" if "other" in row else "",
        f"x{row['ratio']:.3g}" if "ratio" in row else "",
        ", ".join(counts),
        ", ".join(f"{goal} {_SAID[reached]}" for goal, reached in row.get("goals", {}).items()),
    )
