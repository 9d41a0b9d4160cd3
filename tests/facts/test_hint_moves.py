"""Every printed "would fix it" is true: the moved scene, built anew, has neither the finding nor another one."""

from __future__ import annotations

import copy
import sys
from pathlib import Path

import numpy as np
import pytest

from scenelang.backends.facts.frame import FrameFacts
from scenelang.backends.geometry.lint import CheckedFrame
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.values.values import Pair
from scenelang.session.session import Session

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
sys.path.append(str(BENCHMARKS))  # behind the tests, whose packages have the names of some benchmarks
from faulty import Planter, Program

session = Session()
ROOMS = sorted((BENCHMARKS / "rooms").glob("*.scene"))
EVERYDAY = sorted((BENCHMARKS / "everyday" / "faults").glob("[0-9][0-9]_*.scene"))
SEEDS = range(1, 3)  # each plants some ten faults in a room, of which each takes a second
_MAX_SOLIDS = 400  # of a scene that is checked again for every finding


class _Mover:
    """Builds a scene anew in which some primitives are translated in world coordinates, and the words stay."""

    def __init__(self, rows: frozenset[int], move: tuple[float, float, float]) -> None:
        self._rows, self._move, self._next = rows, np.array(move), 0

    def moved(self, entity: Entity, pose: np.ndarray) -> tuple[Entity, frozenset[int]]:
        """Return an entity whose chosen primitives are moved, and all its primitives."""
        if entity.is_primitive:
            rows = frozenset([self._next])
            self._next += 1
            return entity, rows
        children, every = [], frozenset[int]()
        for part in entity.children:
            matrix = np.vstack([np.asarray(part.cdr, float).reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])
            built, rows = self.moved(part.car, pose @ matrix)
            if rows and rows <= self._rows:  # all of it moves: the part itself stays as it is, its place changes
                shift = np.eye(4)
                shift[:3, 3] = np.linalg.solve(pose[:3, :3], self._move)
                built, matrix = part.car, shift @ matrix
            children.append(Pair(built, tuple(matrix[:3].ravel().tolist())))
            every |= rows
        result = copy.copy(entity)
        result.children, result.box = tuple(children), None
        return result, every


def warnings_of(root: Entity) -> set[tuple[str, tuple[str, ...], tuple[str, ...]]]:
    """Return the kinds and words of the warnings about a frame."""
    frame = CheckedFrame(root)
    return {
        (f.kind, frame.words(f), () if f.other is None else frame.solids.words(f.other))
        for f in frame.findings
        if not f.note
    }


def false_hints(root: Entity) -> tuple[int, list[str]]:
    """Return the number of moves that are proposed for a frame, and those that are false."""
    frame, proposed, false = CheckedFrame(root), 0, list[str]()
    if not 0 < len(frame.solids) <= _MAX_SOLIDS:
        return 0, []
    before = warnings_of(root)
    for finding in [f for f in frame.findings if f.kind != "coplanar"][:4]:
        move = frame.tried_move(finding)
        if move is None:
            continue
        proposed += 1
        members = frame.members(finding)
        solids = np.concatenate([frame.facts.bodies.members[int(body)] for body in members])
        rows = frozenset(frame.solids.row[solids].tolist())
        moved, _ = _Mover(rows, move).moved(root, np.eye(4))
        facts = FrameFacts(moved)
        body = int(facts.bodies.body[finding.body])
        new = warnings_of(moved) - before
        if new or (finding.kind == "floating" and facts.verdicts[body].kind == "floating"):
            false.append(f"{finding.kind} {'/'.join(frame.words(finding))} by {move}: {sorted(new)}")
    return proposed, false


@pytest.mark.parametrize("path", EVERYDAY, ids=lambda path: path.stem)
@pytest.mark.slow
def test_hints_on_everyday_faults_are_true(path: Path) -> None:
    if ".good" in path.name:
        pytest.skip("has no fault")
    assert false_hints(session.evaluate(session.source(str(path))).require().frames[0])[1] == []


@pytest.mark.parametrize("path", ROOMS, ids=lambda path: path.stem)
@pytest.mark.slow
def test_hints_on_planted_faults_are_true(path: Path) -> None:
    program = Program(path.stem, path.read_text("utf-8"), session, str(path))
    proposed, false = 0, list[str]()
    for seed in SEEDS:
        for fault in Planter(program, seed).faults():
            scene = program.evaluated(fault.text)
            assert scene is not None
            count, wrong = false_hints(scene.frames[0])
            proposed, false = proposed + count, [*false, *wrong]
    assert proposed
    assert false == []
