"""Recall and precision of `check --geometry` on everyday scenes (docs/facts.md).

    python benchmarks/everyday.py [FOLDER] [--verbose] [--repair]

FOLDER has ``sound`` scenes and ``faults`` with `faults.json`; by default those of 2026-11-28, which were written by
people who did not know the rules: 60 sound scenes, and 60 faults planted in others, each with the program that it was
planted in. A fault is found by a warning that names one of its objects; a fault of intention by a note too.
``--repair`` compares what ``repair`` makes of the physical faults with those programs instead: see ``comparison``.
"""

from __future__ import annotations

import argparse
import json
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from scenelang.backends.facts.frame import facts_of
from scenelang.backends.geometry.lint import check_geometry
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.values.values import Matrix
from scenelang.repairs.repairing import repaired
from scenelang.session.session import Session

HERE = Path(__file__).parent / "everyday"
OUTCOMES = ("equal", "near", "alike", "other", "none", "missed")
NEAR = 0.05  # of the scene's size: a repair so near to that by hand differs in taste


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


def root_of(path: Path, text: str) -> Entity:
    """Return the first frame of a program."""
    return Session().evaluate(Source(str(path), text)).require().frames[0]


def corners_of(root: Entity) -> np.ndarray:
    """Return two corners (2N, 3) of the boxes of the primitives of a frame: their places and sizes."""
    frame = flatten_entity(root)
    matrices = [Matrix(tuple(np.asarray(m).ravel().tolist())) for m in frame.matrices]
    boxes = [frame.primitives[k].shape.box_under(m) for k, m in zip(frame.index, matrices)]
    return np.array(boxes, np.float64).reshape(-1, 3)


def rests_of(root: Entity) -> set[tuple[int, ...]]:
    """Return the pairs of bodies of which the first rests on the second, -1 for the ground plane."""
    links = facts_of(root).statics.links
    upright = [link for link in links if abs(float(link.normal[1])) > 0.5]
    return {(k.body, k.other) if k.normal[1] > 0.0 else (k.other, k.body) for k in upright}


def comparison(path: Path, text: str, found: bool) -> str:
    """Return how a repaired text compares with the repair by hand.

    "equal" and "near" tell the places; "alike" moves the same primitives and lets each body rest on the same, where
    no number tells how far; "missed" and "none" are not repaired: nothing was found, or nothing helped.
    """
    faulty, good = path.read_text(), path.with_suffix(".good.scene")
    if text == faulty:
        return "none" if found else "missed"
    root, by_hand = root_of(path, text), root_of(good, good.read_text())
    own, hand, before = (corners_of(each) for each in (root, by_hand, root_of(path, faulty)))
    if own.shape != hand.shape:
        return "other"
    gap, size = float(np.abs(own - hand).max()), float(np.ptp(hand, axis=0).max())
    if gap < NEAR * size:
        return "equal" if gap < 1e-3 * size else "near"
    if own.shape == before.shape:
        is_moved, is_moved_by_hand = (np.abs(each - before).max(axis=1) > 1e-3 * size for each in (own, hand))
        if (is_moved == is_moved_by_hand).all() and rests_of(root) == rests_of(by_hand):
            return "alike"
    return "other"


def repair_of(path: Path) -> str:
    """Return how the repair of a program compares with that by hand."""
    result = repaired(Session(), Source(str(path), path.read_text()))
    outcome = comparison(path, result.text, bool(result.before))
    return "other" if outcome == "alike" and result.left else outcome


def print_repairs(folder: Path, verbose: bool) -> None:
    """Print a line for each fault if ``verbose``, and the sums."""
    results = Counter[str]()
    for fault in json.loads((folder / "faults" / "faults.json").read_text()):
        if fault["kind"] != "intention":
            result = repair_of(folder / "faults" / fault["file"])
            results[result] += 1
            if verbose:
                print(f"{result:6} {fault['file']}: {fault['what']}")
    print(", ".join(f"{results[name]} {name}" for name in OUTCOMES))


def main() -> None:
    """Print a table of the kinds of faults, and the false alarms."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=HERE)
    parser.add_argument("--verbose", action="store_true", help="print each miss and each false alarm")
    parser.add_argument("--repair", action="store_true", help="compare repairs with those by hand")
    options = parser.parse_args()
    if options.repair:
        print_repairs(options.folder, options.verbose)
        return
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
