"""The ratios of `make bench`, by commit, so that a regression is seen."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path

PATH = Path(__file__).with_name("history.jsonl")
SLOWER = 1.25  # times the ratio of the commit before, which noise alone does not reach


def commit() -> str | None:
    """Return the commit that is checked out, with ``+`` if files differ from it, or None outside a repository."""

    def git(*words: str) -> str:
        done = subprocess.run(["git", "-C", str(PATH.parent), *words], capture_output=True, text=True, check=False)
        return done.stdout.strip() if done.returncode == 0 else ""

    name = git("rev-parse", "--short", "HEAD")
    lines = git("status", "--porcelain", "--untracked-files=no").splitlines()
    changed = [line for line in lines if PATH.name not in line]
    return name + "+" * bool(changed) if name else None


def entries(path: Path = PATH) -> dict[str, dict[str, float]]:
    """Return the ratios of the commits by row, the oldest first."""
    lines = path.read_text("utf-8").splitlines() if path.exists() else []
    return {entry["commit"]: entry["ratios"] for entry in map(json.loads, lines)}


def record(name: str, ratios: Mapping[str, float], path: Path = PATH) -> None:
    """Add the ratios of a commit, or replace them in its place."""
    known = entries(path)  # a commit that is measured again keeps its place
    known[name] = {row: float(f"{ratio:.3g}") for row, ratio in ratios.items()}
    lines = [json.dumps({"commit": key, "ratios": value}) for key, value in known.items()]
    path.write_text("\n".join(lines) + "\n", "utf-8")


def slower(before: Mapping[str, float], now: Mapping[str, float]) -> Iterator[str]:
    """Iterate over the rows that take longer than before, beside what they are compared with."""
    for row, ratio in now.items():
        if row in before and ratio > SLOWER * before[row]:
            yield f"{row}: x{before[row]:.2f} -> x{ratio:.2f}"


def report(ratios: Mapping[str, float], path: Path = PATH) -> None:
    """Record the ratios of the current commit, and print what is slower than in the last one."""
    name = commit()
    if name is None:
        return
    known = entries(path)
    others = [value for key, value in known.items() if key != name]
    record(name, ratios, path)
    print(f"\nrecorded as {name} in {path.name}")
    if not others:
        return
    best = {row: min(each[row] for each in others if row in each) for row in set().union(*others)}
    rows = list(slower(best, ratios))
    print("slower than at best:" if rows else f"nothing is more than {SLOWER:.2f} times as slow as at best")
    for row in rows:
        print(f"  {row}")
