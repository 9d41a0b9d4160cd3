"""The entries of `make bench`, by commit: what rose since the last one, and how figures are written."""

from __future__ import annotations

import datetime
import json
import platform
import statistics
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from measuring import Figures, Goal, Row

PATH = Path(__file__).with_name("history.jsonl")
RISE = 1.05  # times as many instructions as in the last entry, which fails: they differ by .1 % from run to run
STEADY = 0.05  # by how much the control may have moved for times to count
SLOWER = 1.25  # times as long, beside a steady control, which fails: medians differ by 10 % from run to run
Entry = dict[str, Any]


def entry_of(rows: Mapping[str, Row], results: Mapping[str, Figures | str], control: Sequence[float]) -> Entry:
    """Return the entry of a run: figures or reasons of rows by name, the machine, and the control between the rows."""
    middle = statistics.median(control)
    quartiles = statistics.quantiles(control, n=4) if len(control) > 1 else [middle] * 3
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "machine": {"cpu": cpu_model(), "python": platform.python_version()},
        "control": {"seconds": short(middle), "spread": short((quartiles[2] - quartiles[0]) / middle)},
        "rows": {
            name: row_entry(rows[name], figures) for name, figures in results.items() if not isinstance(figures, str)
        },
        "unmeasured": {name: reason for name, reason in results.items() if isinstance(reason, str)},
    }


def row_entry(row: Row, figures: Figures) -> Entry:
    """Return what is kept of a row."""
    kept: Entry = {"ours": short(figures.ours)}
    if figures.other is not None and figures.ratio is not None:
        kept |= {"other": short(figures.other), "beside": row.other, "ratio": short(figures.ratio)}
    if figures.instructions is not None:
        kept["instructions"] = figures.instructions
    if figures.instruction_ratio is not None:
        kept["instruction_ratio"] = short(figures.instruction_ratio)
    if figures.memory is not None:
        kept["memory"] = short(figures.memory)
    if row.goals:
        kept["goals"] = {goal_text(goal): figures.reached(goal) for goal in row.goals}
    return kept


def short(value: float) -> float:
    return float(f"{value:.3g}")


def commit() -> str | None:
    """Return the commit that is checked out, with ``+`` if files differ from it, or None outside a repository."""

    def git(*words: str) -> str:
        done = subprocess.run(["git", "-C", str(PATH.parent), *words], capture_output=True, text=True, check=False)
        return done.stdout.strip() if done.returncode == 0 else ""

    name = git("rev-parse", "--short", "HEAD")
    lines = git("status", "--porcelain", "--untracked-files=no").splitlines()
    changed = [line for line in lines if PATH.name not in line]
    return name + "+" * bool(changed) if name else None


def cpu_model() -> str:
    """Return the name of the processor, as Linux tells it."""
    info = Path("/proc/cpuinfo")
    names = [line for line in info.read_text().splitlines() if line.startswith("model name")] if info.exists() else []
    return names[0].split(":", 1)[1].strip() if names else platform.processor() or platform.machine()


def entries(path: Path = PATH) -> list[Entry]:
    """Return the entries, the oldest first."""
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()] if path.exists() else []


def record(entry: Entry, path: Path = PATH) -> None:
    """Add an entry, in place of an earlier one of the same commit and machine."""

    def key(each: Entry) -> tuple[Any, Any]:
        return each["commit"], each["machine"]

    kept = [each for each in entries(path) if key(each) != key(entry)]
    path.write_text("".join(json.dumps(each) + "\n" for each in [*kept, entry]), "utf-8")


def last_of(known: Sequence[Entry], entry: Entry) -> Entry | None:
    """Return the last entry of another commit and the same Python; others take other numbers of instructions."""
    python, name = entry["machine"]["python"], entry["commit"]
    others = [each for each in known if each["machine"]["python"] == python and each["commit"] != name]
    return others[-1] if others else None


def risen(before: Entry, now: Entry, key: str, limit: float) -> Iterator[str]:
    """Iterate over the rows whose figure ``key`` is more than ``limit`` times that of the entry before."""
    for name, row in now["rows"].items():
        old, new = before["rows"].get(name, {}).get(key), row.get(key)
        if old is not None and new is not None and new > limit * old:
            yield f"{name}: {key} rose by {100 * (new / old - 1):.0f} %"


def is_steady(before: Entry, now: Entry) -> bool:
    """Return whether times can be compared: one machine, and a control that moved by less than 5 %."""
    moved = abs(now["control"]["seconds"] / before["control"]["seconds"] - 1)
    spread = max(now["control"]["spread"], before["control"]["spread"])
    return before["machine"] == now["machine"] and max(moved, spread) < STEADY


def report(entry: Entry, problems: Sequence[str], keeps: bool, path: Path = PATH) -> int:
    """Print what rose since the last entry, record the run if it is kept, and return 1 if anything failed."""
    before = last_of(entries(path), entry)
    failures = list(problems)
    if before is not None:
        failures += risen(before, entry, "instructions", RISE)
        slower = [*risen(before, entry, "ratio", SLOWER), *risen(before, entry, "ours", SLOWER)]
        if is_steady(before, entry):
            failures += slower
        else:
            print("".join(f"only told, since the control moved: {line}\n" for line in slower), end="")
    print("".join(f"FAILED {line}\n" for line in failures), end="")
    if keeps and entry["commit"] is not None:
        record(entry, path)
        print(f"recorded as {entry['commit']} in {path.name}")
    return 1 if failures else 0


# --- figures as text ----------------------------------------------------------------------------------------------


def seconds_text(value: float) -> str:
    """Return seconds as ms or s.

    Examples
    --------
    >>> seconds_text(.0123), seconds_text(2.5)
    ('12.3 ms', '2.50 s')
    """
    return f"{value * 1e3:.3g} ms" if value < 0.9995 else f"{value:.2f} s"


def bytes_text(value: float) -> str:
    """Return bytes as B, KB, MB or GB.

    Examples
    --------
    >>> bytes_text(200), bytes_text(1.5e6)
    ('200 B', '1.5 MB')
    """
    power = min(3, max(0, len(str(int(value))) - 1) // 3)
    return f"{value / 1000**power:.3g} {('B', 'KB', 'MB', 'GB')[power]}"


def goal_text(goal: Goal) -> str:
    """Return a goal as the table has it."""
    if goal.of in ("ours", "memory"):
        return f"<= {seconds_text(goal.most) if goal.of == 'ours' else bytes_text(goal.most)}"
    return f"<= x{goal.most:g}" + " instructions" * (goal.of == "instructions")
