"""Run every hostile case as a process of its own, under a limit of a second and 300 MB, and print what went past it:
``python -m hostile [part of a name]`` in the folder of the tests."""

from __future__ import annotations

import json
import re
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from hostile.cases import Case, every
from hostile.measuring import Base, Measured, base, faults, past, run_case

SECONDS, MEMORY = 1.0, 300_000_000
LIMITS = ("--max-seconds", "1", "--max-memory", "300M")


def row(case: Case, found: Measured, start: Base) -> tuple[Any, ...]:
    """What is kept and printed of a case."""
    wrong = faults(case, found, start, SECONDS, MEMORY)
    seconds, memory = past(found, start), (found.resident - start.resident) / 1e6
    codes = sorted(set(re.findall(r"\bE\d\d\d\b", found.err)))[:3]
    place = bool(re.search(r"-->", found.err))
    said = "; ".join(wrong) or repr(found.err.strip()[:100])
    sign, seen = "FAIL" if wrong else "ok", " ".join(codes) + ("" if place or not codes else "-")
    print(f"{sign:5}{case.name:45} {seconds:6.2f} s {memory:6.0f} MB {seen:10} {said}", flush=True)
    return case.name, case.word, seconds, memory, found.code, codes, place, wrong


def main(part: str = "", table: str = "", jobs: str = "2") -> int:
    rows, failed = [], 0
    with tempfile.TemporaryDirectory() as name:
        root = Path(name)
        start = base(root, LIMITS)
        print(
            f"start-up: {start.seconds:.2f} s, of which after loading {start.working:.2f} s, {start.resident / 1e6:.0f} MB",
            flush=True,
        )
        cases = [case for case in every() if part in case.name]
        with ThreadPoolExecutor(int(jobs)) as pool:
            folders = [root / str(number) for number in range(len(cases))]
            for case, found in zip(cases, pool.map(lambda pair: run_case(*pair, LIMITS), zip(cases, folders))):
                rows.append(row(case, found, start))
                failed += bool(rows[-1][-1])
    if table:
        Path(table).write_text(json.dumps(rows, indent=1))
    worst = max(rows, key=lambda row: row[2]), max(rows, key=lambda row: row[3])
    print(
        f"{len(rows) - failed} of {len(rows)} pass; longest {worst[0][2]:.2f} s, {worst[0][0]}; most {worst[1][3]:.0f} MB, {worst[1][0]}"
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
