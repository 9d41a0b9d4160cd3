"""``python -m faults [COMMIT] [FOLDER]`` in the folder of the tests: does the suite notice the planted faults?

faults.json has 300 faults, each one line of one function. The suite runs once with probes, which say what reaches which
line (about half an hour), then the tests of each fault run, up to half a minute of them, until one fails (about
half an hour more). Results are kept a fault at a time, and a second run goes on. Records hold for older commits too,
so that the suites of two commits can be compared: ``make test-faults COMMIT=028eac3``.

Faults that have survived so far are in survivors.json. One more is an error: a test got weaker, or a line that no
test checks was written. A record whose line is gone says so, and is drawn anew with ``faults.candidates``.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

from faults.checkout import ROOT, checkout, plant, probe
from faults.patches import RECORDS, Fault, read_records
from faults.runner import Result

SURVIVORS = RECORDS.with_name("survivors.json")
NOT_CAUGHT = ("survived", "unreached")


def read_results(path: Path) -> list[Result]:
    rows = map(json.loads, path.read_text("utf-8").splitlines())
    return [Result(**{**row, "fault": Fault(**row["fault"])}) for row in rows]


def report(results: list[Result], known: set[Fault]) -> bool:
    """Print what was caught; whether nothing survived that was caught before."""
    counts = Counter(result.result for result in results)
    print(f"{counts['caught']} of {len(results)} faults caught; " + ", ".join(f"{n} {k}" for k, n in counts.items()))
    survived = [result.fault for result in results if result.result in NOT_CAUGHT]
    for fault in survived:
        print(f"{'known' if fault in known else 'NEW  '}  {fault.name}")
    for result in results:
        if result.result == "missing":
            print(f"gone   {result.fault.name}")
    return known.issuperset(survived)


def main(commit: str = "HEAD", folder: str = "") -> int:
    made = checkout(Path(folder or ROOT / ".faults"), commit)
    probe(made)
    plant(made, RECORDS)
    wanted = set(read_records())
    results = [result for result in read_results(made.results) if result.fault in wanted]
    return 0 if report(results, set(read_records(SURVIVORS))) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
