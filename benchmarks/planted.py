"""Recall and precision of ``check --geometry`` and ``check --physics`` on planted faults: ``make faults``.

Faults are planted in sound programs (``faulty``): the rooms beside this file, the examples and the gallery, the corpus,
and answers of language models as they are transpiled. Thresholds were chosen on half of the programs; the tables are
about the other half, with other random numbers, and that of physics is written into the documentation. ``--tuning``
tells about the first half, with all that is missed or false.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from faulty import KINDS, Fault, Planter, Program

from scenelang.backends.geometry.lint import CheckedFrame
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene
from scenelang.session.session import Session

ROOT = Path(__file__).parent.parent
OVERLAP = frozenset(("deep", "hidden", "twin", "sunk"))
BALANCE = frozenset(("tips", "slides", "falls", "floating"))
CODES: dict[str, frozenset[str]] = {
    "floating": BALANCE, "sunk": OVERLAP | {"sunk"}, "penetrating": OVERLAP, "past the edge": BALANCE,
    "twin": OVERLAP, "buried": OVERLAP, "loop": BALANCE | OVERLAP | {"sunk"}, "scale": OVERLAP, "tilted": BALANCE,
    "hanging": BALANCE, "fighting": frozenset(("coplanar",)), "top-heavy": BALANCE,
}  # fmt: skip
PHYSICAL = ("floating", "past the edge", "tilted", "hanging", "top-heavy")
EXCEPTIONS = {  # findings in unchanged programs that a person who looks closely reports too
    ("t11-bookshelf", "coplanar"): "the fronts of the boards are in the plane of the frame",
    ("response-t09-coke-cans", "coplanar"): "the label is in the plane of the lid",
    ("combinators", "hidden"): "berries that no one sees are inside the fountain",
}
UNSOUND = {  # answers of models whose own faults a person sees, in which nothing is planted
    "response-t03-bramante-staircase": "steps in each other's planes, a skylight in the air",
    "response-t06-son-of-man": "the head floats above the collar, a cloud is inside another",
}
RESTLESS = {  # programs of which a simulation says rightly that they do not rest
    "harbour": "water is no solid, so that the boat falls", "toys": "the wooden man stands in front of his feet",
    "combinators": "balls of the garland hang in the air",
    "response-n10-rubiks-cube": "there are gaps between the pieces",
}  # fmt: skip


@dataclass
class Score:
    """What was found of planted faults, and what else."""

    planted: Counter[str] = field(default_factory=Counter)
    found: Counter[str] = field(default_factory=Counter)
    true: int = 0
    false: list[str] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)
    sound: int = 0

    @property
    def recall(self) -> float:
        return sum(self.found.values()) / max(sum(self.planted.values()), 1)

    @property
    def precision(self) -> float:
        return self.true / max(self.true + len(self.false), 1)

    def table(self) -> str:
        """Return a Markdown table of recall by kind, and a line about precision."""
        rows = [f"| {kind} | {self.found[kind]} of {self.planted[kind]} |" for kind in KINDS if self.planted[kind]]
        total = f"| all | {sum(self.found.values())} of {sum(self.planted.values())}, {self.recall:.1%} |"
        facts = f"{self.sound} sound programs; {self.true} findings about planted faults, {len(self.false)} others: "
        return "\n".join(
            ["| kind | found |", "|---|---|", *rows, total, "", f"{facts}a precision of {self.precision:.1%}."]
        )


def half_of(name: str) -> int:
    """Return 0 for programs that thresholds were chosen on, 1 for those that are reported."""
    return hashlib.sha256(name.encode()).digest()[0] % 2


def programs(session: Session) -> Iterator[Program]:
    """Yield the sound programs."""
    texts: list[tuple[str, str, Path]] = []
    for folder in ("benchmarks/rooms", "examples", "tests/corpus"):
        for path in sorted((ROOT / folder).rglob("*.scene")):
            name = path.stem if path.parent.name != "paper" else f"paper-{path.stem}"
            texts.append((name, path.read_text("utf-8"), path))
    known = {name for name, _, _ in texts}
    for path in sorted((ROOT / "tests" / "transpile" / "responses").glob("*.txt")):
        if ".edit" in path.name or path.stem in known or f"response-{path.stem}" in UNSOUND:
            continue
        translation = session.transpile(session.source(str(path)))
        if translation.ok:
            texts.append((f"response-{path.stem}", translation.text, path))
    for name, text, path in texts:
        yield Program(name, text, session, str(path.with_suffix(".scene")))


def geometry_of(scene: Scene) -> dict[tuple[str, ...], frozenset[int]]:
    """Return the findings of the lint about the first frame: kind and words, and the primitives that each is about."""
    frame = CheckedFrame(scene.root)
    found: dict[tuple[str, ...], frozenset[int]] = {}
    for each in frame.findings:
        if each.note:
            continue
        other = () if each.other is None else frame.solids.words(each.other)
        key = (each.kind, "/".join(frame.solids.words(each.body)), "/".join(other))
        found[key] = found.get(key, frozenset()) | frozenset(frame.solids.row[frame.concerned(each)].tolist())
    return found


def motion_of(scene: Scene) -> dict[tuple[str, ...], frozenset[int]]:
    """Return what does not rest in a simulation, in the same form."""
    from scenelang.backends.physics.grouping import bodies_of
    from scenelang.backends.physics.verdicts import report_of

    bodies = bodies_of(scene.root)
    ranks: dict[int, int] = {}
    for number, node in enumerate(bodies.nodes):
        if node.entity.is_primitive:
            ranks[number] = len(ranks)
    found: dict[tuple[str, ...], frozenset[int]] = {}
    for number, report in enumerate(report_of(scene).bodies):
        if report.kind != "rests" and report.cause is None:  # what goes along is told with its cause
            rows = frozenset(ranks[bodies.parts[part].node] for part in bodies.bodies[number].parts)
            key = (report.kind, "/".join(report.words))
            found[key] = found.get(key, frozenset()) | rows
    return found


def score_geometry(program: Program, faults: Sequence[Fault], score: Score) -> None:
    """Add what the lint finds in a program, and in it with each fault."""
    before = geometry_of(program.scene)
    score.sound += 1
    for key in before:
        if (program.name, key[0]) not in EXCEPTIONS:
            score.false.append(f"{program.name}: {' '.join(key)}")
    for fault in faults:
        scene = program.evaluated(fault.text)
        assert scene is not None
        found = {key: rows for key, rows in geometry_of(scene).items() if key not in before}
        about = {key for key, rows in found.items() if rows & fault.rows}
        _add(score, fault, any(key[0] in CODES[fault.kind] for key in about), len(about))
        score.false += [f"{fault.kind} in {program.name}: {' '.join(key)}" for key in found if key not in about]


def score_physics(program: Program, faults: Sequence[Fault], score: Score) -> None:
    """Add what moves in a program, and in it with each fault; what goes with the thing of a fault is true."""
    if program.name in RESTLESS:
        return
    try:
        before = motion_of(program.scene)
    except SceneError:
        return  # too large, or nothing solid
    score.sound += 1
    score.false += [f"{program.name}: {' '.join(key)}" for key in before]
    for fault in faults if not before else ():
        if fault.kind in PHYSICAL:
            scene = program.evaluated(fault.text)
            assert scene is not None
            found = motion_of(scene)
            _add(score, fault, any(rows & fault.rows for rows in found.values()), min(len(found), 1))


def _add(score: Score, fault: Fault, is_found: bool, true: int) -> None:
    score.planted[fault.kind] += 1
    score.found[fault.kind] += is_found
    score.true += true
    if not is_found:
        score.missed.append(f"{fault.kind} in {fault.program}: {'/'.join(fault.words)} by {fault.displacement:.3g}")


def _written(name: str, table: str, page: Path) -> None:
    text = page.read_text("utf-8")
    start, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    before, _, rest = text.partition(start)
    page.write_text(f"{before}{start}\n{table}\n\n{end}{rest.partition(end)[2]}", "utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tuning", action="store_true", help="the half that thresholds were chosen on; writes nothing")
    parser.add_argument("--only", choices=("geometry", "physics"))
    arguments = parser.parse_args()
    session = Session()
    scores = {"geometry": Score(), "physics": Score()}
    for program in programs(session):
        if half_of(program.name) == (0 if not arguments.tuning else 1):
            continue
        seeds = (0,) if arguments.tuning else (1,) if arguments.only == "physics" else (1, 2)
        faults = [fault for seed in seeds if len(program.bodies) for fault in Planter(program, seed).faults()]
        for name, add in (("geometry", score_geometry), ("physics", score_physics)):
            if arguments.only in (None, name):
                add(program, faults, scores[name])
        print(f"{program.name}: {len(faults)} faults", file=sys.stderr)
    for name, score in scores.items():  # the geometry is judged by scenes of others, in docs/facts.md
        if arguments.only in (None, name):
            print(f"\n{name}\n{score.table()}\n", *(f"  missed: {each}\n" for each in score.missed), end="")
            print(*(f"  false: {each}\n" for each in score.false), end="")
            if name == "physics" and not arguments.tuning:
                _written(f"{name} on planted faults", score.table(), ROOT / "docs" / "physics.md")


if __name__ == "__main__":
    main()
