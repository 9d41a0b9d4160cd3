"""What ``repair`` makes of planted faults (``faulty``): the share that it resolves, and how far things move for it.

    python benchmarks/repairs.py [--most N] [--seconds S] [--write]

Programs are those of ``planted`` that are reported. A fault counts if the geometry lint finds it. ``--write`` replaces
the table in docs/relations.md.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from faulty import KINDS, Fault, Planter, Program
from planted import half_of, programs

from scenelang.grammar.datum import Source
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.repairs.repairing import Repair, repaired
from scenelang.session.session import Session

DOC = Path(__file__).parent.parent / "docs" / "relations.md"
MARKS = ("<!-- repairs -->", "<!-- end of repairs -->")


@dataclass
class Tally:
    """Resolved and planted faults by kind, ratios of the displacement of a repair to that of its fault."""

    planted: Counter[str] = field(default_factory=Counter)
    resolved: Counter[str] = field(default_factory=Counter)
    ratios: list[float] = field(default_factory=list)
    sound: int = 0
    changed: list[str] = field(default_factory=list)

    def table(self) -> str:
        rows = [f"| {kind} | {self.resolved[kind]} of {self.planted[kind]} |" for kind in KINDS if self.planted[kind]]
        total, done = sum(self.planted.values()), sum(self.resolved.values())
        mean = sum(self.ratios) / max(len(self.ratios), 1)
        facts = (
            f"Things move by {mean:.2f} times the planted displacement in the mean of {len(self.ratios)} repairs. "
            f"{self.sound - len(self.changed)} of {self.sound} sound programs stay as they are."
        )
        return "\n".join(
            [
                "| kind | resolved |",
                "|---|---|",
                *rows,
                f"| all | {done} of {total}, {done / max(total, 1):.0%} |",
                "",
                facts,
            ]
        )


def _without_amounts(message: str) -> str:
    return re.sub(r"[\d.]+(?= )|\(\d+ times\)", "", message).strip()


def add(tally: Tally, program: Program, fault: Fault, sound: Repair, found: Repair) -> str:
    """Count a repair; returns a line about it."""
    known = set(map(_without_amounts, sound.before))
    if set(map(_without_amounts, found.before)) <= known:
        return "not found"
    tally.planted[fault.kind] += 1
    left = [message for message in found.left if _without_amounts(message) not in known]
    if left:
        return f"left: {left[0]}"
    tally.resolved[fault.kind] += 1
    planted = fault.displacement * len(fault.rows) / len(flatten_entity(program.scene.root))
    if planted > 0.0:
        tally.ratios.append(found.displacement / planted)
    return f"resolved, {found.displacement:.4f} for {planted:.4f}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--most", type=int, default=10_000, help="number of programs")
    parser.add_argument("--effort", type=float, default=20.0, help="of one repair, about a second each")
    parser.add_argument("--write", action="store_true", help="write the table into docs/relations.md")
    arguments = parser.parse_args()
    session, tally = Session(), Tally()
    chosen = [program for program in programs(session) if half_of(program.name) == 1 and program.candidates]
    for program in chosen[: arguments.most]:
        sound = repaired(session, Source(program.path, program.text), effort=arguments.effort)
        tally.sound += 1
        if sound.changed and not sound.before:
            tally.changed.append(program.name)
        for fault in Planter(program, seed=1).faults(most=dict.fromkeys(KINDS, 1)):
            found = repaired(session, Source(program.path, fault.text), effort=arguments.effort)
            print(f"{program.name}: {fault.kind}: {add(tally, program, fault, sound, found)}", flush=True)
    print(tally.table())
    if arguments.write:
        pattern = re.compile(f"{re.escape(MARKS[0])}.*?{re.escape(MARKS[1])}", re.DOTALL)
        text = DOC.read_text("utf-8")
        DOC.write_text(pattern.sub(f"{MARKS[0]}\n{tally.table()}\n{MARKS[1]}", text), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
