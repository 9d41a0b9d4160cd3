"""Recall and precision of `check --geometry` on everyday scenes (docs/facts.md).

    python benchmarks/everyday.py [FOLDER] [--verbose]

FOLDER has ``sound`` scenes and ``faults`` with `faults.json`; by default those of 2026-11-28, which were written by
people who did not know the rules: 60 sound scenes, and 60 faults planted in others, each with the program that it was
planted in. A fault is found by a warning that names one of its objects; a fault of intention by a note too.
"""

from __future__ import annotations

import argparse
import json
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from scenelang.backends.geometry.lint import check_geometry
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.session.session import Session

HERE = Path(__file__).parent / "everyday"


def findings_of(path: Path) -> list[Diagnostic]:
    """Return what the check reports about a program."""
    scene = Session().evaluate(Source(str(path), path.read_text())).scene
    assert scene is not None, path
    return check_geometry(scene)


def is_note(diagnostic: Diagnostic) -> bool:
    """Return whether a finding is less than a warning."""
    return diagnostic.severity == "note"


def is_found(diagnostics: Sequence[Diagnostic], fault: dict[str, object]) -> bool:
    """Return whether a finding names an object of a fault."""
    objects = [str(word) for word in fault["objects"]]  # type: ignore[attr-defined]
    counted = [d for d in diagnostics if fault["kind"] == "intention" or not is_note(d)]
    return any(re.search(rf'["/]{re.escape(word)}["/]', d.message) for word in objects for d in counted)


def main() -> None:
    """Print a table of the kinds of faults, and the false alarms."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=HERE)
    parser.add_argument("--verbose", action="store_true", help="print each miss and each false alarm")
    options = parser.parse_args()
    caught, total = Counter[str](), Counter[str]()
    for fault in json.loads((options.folder / "faults" / "faults.json").read_text()):
        diagnostics = findings_of(options.folder / "faults" / fault["file"])
        total[fault["kind"]] += 1
        caught[fault["kind"]] += is_found(diagnostics, fault)
        if options.verbose and not is_found(diagnostics, fault):
            print(f"missed {fault['file']}: {fault['what']}", *(d.message for d in diagnostics), sep="\n    ")
    for kind in total:
        print(f"| {kind} | {caught[kind]} of {total[kind]} |")
    for name, paths in (
        ("sound", sorted((options.folder / "sound").glob("*.scene"))),
        ("repaired by hand", sorted((options.folder / "faults").glob("*.good.scene"))),
    ):
        alarmed, alarms, notes = 0, 0, 0
        for path in paths:
            diagnostics = findings_of(path)
            warnings = [d for d in diagnostics if not is_note(d)]
            alarmed, alarms = alarmed + bool(warnings), alarms + len(warnings)
            notes += len(diagnostics) - len(warnings)
            if options.verbose:
                print(
                    *(f"{path.name}: {d.code} {d.message}" for d in diagnostics), sep="\n", end="\n" * bool(diagnostics)
                )
        print(f"{name}: {alarms} false alarms in {alarmed} of {len(paths)} scenes, {notes} notes")


if __name__ == "__main__":
    main()
