"""Effects of an edit on the objects of a scene: how far it moves them, whether it deforms them, whether they stay
supported.

An object is a body of the facts of a frame (``backends/facts``). ``repairing`` proposes edits; this module rates them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.trials import ranked_moves, weight_of

if TYPE_CHECKING:
    from scenelang.backends.geometry.arrangement import Vector
    from scenelang.backends.geometry.lint import CheckedFrame, Finding
    from scenelang.backends.surfaces.distance import IntArray
    from scenelang.backends.surfaces.solids import FloatArray

BoolArray = npt.NDArray[np.bool_]

# Moving the parts of an object against each other costs four times as much as moving the whole object as far, so that
# a cabinet that is in a wall is moved by the numbers that place it, and not by those of one board. An object that is
# in no finding costs twice. Both are weights of preference; docs/relations.md has the share of faults repaired with
# them (`python benchmarks/repairs.py`).
_DEFORMATION_COST = 4.0
_UNINVOLVED_COST = 2.0
_MAX_WAYS = 8  # to contacts of one finding that are tried, those of the least effort
_LEVEL_SHARE = 0.1  # of the square of a way out that is level: steeper ones do not lead sideways
_MEANT_DEPTH = 4.0  # contact tolerances: of an overlap that joins two objects
_NEGLIGIBLE_SHARE = 1e-3  # of the longest component of a translation: smaller components are rounding
_FRAME_MOTION_TOLERANCE = 1e-6  # relative to the size of the frame: smaller motions are rounding
_DEPTH_TOLERANCE = 1.0  # contact tolerances by which a penetration may grow


def rows_of(primitives: IntArray | None, at: int) -> IntArray:
    """Return the rows of the layout that hold the two corners of primitives, whose frame begins at primitive ``at``."""
    if primitives is None:
        return np.zeros(0, np.int64)
    return np.stack([2 * (primitives + at), 2 * (primitives + at) + 1], axis=1).reshape(-1)


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """Alternative translations of one set of corners relative to another, each of which resolves a finding.

    The motion of a set is the weighted mean of its corners.

    Attributes
    ----------
    rows, others
        Rows of the layout: the corners to move, and those relative to which they move (none for the world).
    weights, other_weights
        Shares of these corners, which sum to 1.
    moves
        Translations in scene units.
    efforts
        Weights of their lengths; empty for 1. Moves that have some are guesses, which no new form makes.
    """

    rows: IntArray
    weights: FloatArray
    others: IntArray
    other_weights: FloatArray
    moves: tuple[Vector, ...]
    efforts: tuple[float, ...] = ()

    @classmethod
    def between(cls, rows: IntArray, others: IntArray, moves: tuple[Vector, ...]) -> Aim:
        """Return the aim with equal weights of all corners."""
        return cls(rows, _equal(rows), others, _equal(others), moves)

    def of(self, motion: FloatArray) -> FloatArray:
        """Return the relative motion, (3,) or (3, K), that a motion (N, 3) or (N, 3, K) of all corners causes."""
        moved = np.tensordot(self.weights, motion[self.rows], 1)
        return np.asarray(moved - np.tensordot(self.other_weights, motion[self.others], 1), np.float64)


def _equal(rows: IntArray) -> FloatArray:
    """Return equal weights that sum to 1."""
    return np.full(len(rows), 1.0 / max(len(rows), 1))


@dataclass(frozen=True, slots=True, eq=False)
class ObjectCorners:
    """Assignment of the corners of a layout to objects.

    Attributes
    ----------
    labels
        Object number (N,) of each corner.
    counts
        Number of corners of each object.
    """

    labels: IntArray
    counts: IntArray

    @classmethod
    def of(cls, frames: Sequence[tuple[CheckedFrame, int, int]]) -> ObjectCorners:
        """Return the objects of frames, each given with the position of its first primitive and their number."""
        labels = [np.zeros(0, np.int64)]
        for frame, at, count in frames:
            frame_labels = np.arange(count) + at  # a primitive without a solid is an object
            facts = frame.facts
            firsts = np.array([members[0] for members in facts.bodies.members], np.int64)
            frame_labels[facts.solids.row] = at + facts.solids.row[firsts[facts.bodies.body]]
            labels.append(frame_labels)
        _, numbers, counts = np.unique(np.repeat(np.concatenate(labels), 2), return_inverse=True, return_counts=True)
        return cls(numbers, counts)

    def cost(self, motion: FloatArray, rows: IntArray, every: IntArray) -> float:
        """Return the cost of a motion of all corners, in scene units.

        Parameters
        ----------
        motion
            Displacement (N, 3) of each corner.
        rows
            Corners of equal findings, whose objects count as one: a row of ten chairs is moved for the price of one.
        every
            Corners of all findings; other objects cost twice as much.
        """
        mean, rest = self._split(motion)
        weights = np.full(len(self.counts), _UNINVOLVED_COST)
        weights[self.labels[every]] = 1.0 / max(len(np.unique(self.labels[rows])), 1)
        deformation = np.zeros(len(self.counts))
        np.maximum.at(deformation, self.labels, np.linalg.norm(rest, axis=1))
        return float(weights @ np.linalg.norm(mean, axis=1) + _DEFORMATION_COST * deformation.sum())

    def is_deforming(self, motion: FloatArray, least: float) -> bool:
        """Return whether a motion (N, 3) moves corners of an object apart by more than a length."""
        return bool(np.abs(self._split(motion)[1]).max(initial=0.0) > least)

    def least_extents(self, corners: FloatArray) -> FloatArray:
        """Return the shortest side (N,) of the box of each corner's object."""
        low, high = np.full((len(self.counts), 3), np.inf), np.full((len(self.counts), 3), -np.inf)
        np.minimum.at(low, self.labels, corners)
        np.maximum.at(high, self.labels, corners)
        return np.asarray((high - low).min(axis=1)[self.labels], np.float64)

    def _split(self, motion: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Split a motion into the mean of each object (K, 3) and the deviation of each corner from it (N, 3)."""
        sums = [np.bincount(self.labels, motion[:, axis], len(self.counts)) for axis in range(3)]
        mean: FloatArray = np.stack(sums, axis=1) / np.maximum(self.counts, 1)[:, None]
        return mean, motion - mean[self.labels]


# --- aims of findings -----------------------------------------------------------------------------------------------


def aims_of(frame: CheckedFrame, finding: Finding, at: int) -> Iterator[Aim]:
    """Yield the motions that would resolve a finding: of the objects that move together, and of the solid it names.

    Parameters
    ----------
    at
        Position of the frame's first primitive in the layout.
    """
    facts = frame.facts
    row, members = facts.solids.row, frame.members(finding)
    rows = np.concatenate([facts.bodies.members[int(body)] for body in members]) if len(members) else np.zeros(0, int)
    if finding.shift is not None:
        yield from _balancing(frame, rows, finding.shift, at)
    moves = tuple(dict.fromkeys((*_tried(frame, finding), *_separations(frame, finding))))
    none, body = rows_of(None, at), rows_of(row[[finding.body]], at)
    own = rows_of(row[rows], at)
    if finding.kind in ("floating", "tips") and len(members):
        ways = ranked_moves(facts, members)[:_MAX_WAYS]
        if ways:
            efforts, reached = zip(*ways)
            yield Aim(own, _equal(own), none, _equal(none), reached, efforts)
    if not moves:
        return
    if finding.other is None:
        yield Aim.between(own, none, moves)
        yield Aim.between(body, none, moves)
        return
    other_body = np.flatnonzero(facts.bodies.body == facts.bodies.body[finding.other])
    others = rows_of(row[np.setdiff1d(other_body, rows)], at)
    yield Aim.between(own, others, moves)
    yield Aim.between(body, rows_of(row[[finding.other]], at), moves)
    if finding.kind == "deep":
        out = tuple(_ways_out(frame, finding))
        yield Aim(own, _equal(own), others, _equal(others), out, (1.0,) * len(out))


def _balancing(frame: CheckedFrame, rows: IntArray, shift: Vector, at: int) -> Iterator[Aim]:
    """Yield the motion of the solids of an unbalanced object over its feet, each by its share of the mass."""
    solids = frame.solids
    mass, low = solids.masses[0][rows], solids.boxes[0]
    feet = rows[low[rows, 1] <= low[rows, 1].min() + solids.touch]
    heavy, standing = rows_of(solids.row[rows], at), rows_of(solids.row[feet], at)
    yield Aim(heavy, np.repeat(mass / mass.sum() / 2.0, 2), standing, _equal(standing), (shift,))


def effort_of(move: FloatArray) -> float:
    """Return the weight of the length of a translation: objects are put down more often than moved aside."""
    x, y, z = (float(component) for component in np.round(move / max(float(np.abs(move).max()), 1e-12), 6))
    return weight_of((x, y, z))


def _tried(frame: CheckedFrame, finding: Finding) -> Iterator[Vector]:
    """Yield the translation that resolves a finding in the scene, or the way of an outlier to its place."""
    move = finding.move if finding.kind == "outlier" else frame.tried_move(finding)
    if move is not None:
        yield move


def _separations(frame: CheckedFrame, finding: Finding) -> tuple[Vector, ...]:
    """Return the translations that separate two solids, the shortest first."""
    if finding.kind not in ("hidden", "coplanar", "deep") or finding.other is None:
        return ()
    if finding.move is not None:
        least = _NEGLIGIBLE_SHARE * max(map(abs, finding.move))
        x, y, z = (component if abs(component) > least else 0.0 for component in finding.move)
        level = (x * x + z * z) / (x * x + y * y + z * z)
        shortest: tuple[Vector, ...] = ((x, y, z),)
        if finding.kind == "deep" and _LEVEL_SHARE < level < 1.0:  # what stands on the ground leaves sideways
            shortest = ((x / level, 0.0, z / level), *shortest)
        return shortest
    low, high = frame.solids.boxes
    i, j = finding.body, finding.other
    moves: list[Vector] = []
    for axis in range(3):
        up, down = high[j, axis] - low[i, axis], low[j, axis] - high[i, axis]
        if finding.kind == "coplanar":
            # Coplanar faces are separated by little: four contact tolerances are no contact, and hardly visible.
            up, down = (math.copysign(4.0 * frame.solids.touch, length) for length in (up, down))
        for length in (up,) if axis == 1 else (up, down):  # an object is not moved below the one that it penetrates
            x, y, z = (float(length) if k == axis else 0.0 for k in range(3))
            moves.append((x, y, z))
    return tuple(sorted(moves, key=lambda move: math.hypot(*move)))


def _ways_out(frame: CheckedFrame, finding: Finding) -> list[Vector]:
    """Return the ways by which a whole body leaves the solids of another one, level or upward, the shortest first.

    The shortest way out of one solid of a car may lead into the next; the way out of a wall leads into its house.
    """
    solids, body = frame.solids, frame.facts.bodies.body
    assert finding.other is not None
    own, others = (np.flatnonzero(body == body[k]) for k in (finding.body, finding.other))
    low, high = solids.boxes
    moves: list[Vector] = []
    for axis in range(3):
        across = [k for k in range(3) if k != axis]
        first, second = (each.reshape(-1) for each in np.meshgrid(own, others, indexing="ij"))
        meets = (np.minimum(high[first], high[second]) - np.maximum(low[first], low[second]))[:, across] > solids.touch
        first, second = first[meets.all(axis=1)], second[meets.all(axis=1)]
        ends = np.stack([low[second, axis] - high[first, axis], high[second, axis] - low[first, axis]], axis=1)
        for side, sign in ((1, 1.0), (0, -1.0))[: 1 if axis == 1 else 2]:
            length, is_in = 0.0, np.ones(len(ends), bool)
            while is_in.any():
                is_in = (ends[:, 0] < length) & (ends[:, 1] > length)
                length = sign * float((sign * ends[is_in, side]).max()) if is_in.any() else length
            if length:
                x, y, z = (length if k == axis else 0.0 for k in range(3))
                moves.append((x, y, z))
    return sorted(moves, key=lambda move: math.hypot(*move))


# --- relations after an edit ----------------------------------------------------------------------------------------


def is_sound_motion(before: CheckedFrame, after: CheckedFrame, motion: FloatArray) -> bool:
    """Return whether objects that a motion (N, 3) of the corners of a frame moves relate to each other as before.

    The parts of an object stay joined, and what rested on an object rests on it, unless gravity would have moved it.
    """
    moved = _moved(before, after, motion)
    return not moved.any() or not (
        _sinks_ground(before, after)
        or _is_torn(before, after, moved)
        or _is_deformed(before, motion, moved)
        or _is_parted(before, after, moved)
        or _loses_support(before, after)
    )


def is_deforming_motion(before: CheckedFrame, motion: FloatArray) -> bool:
    """Return whether a motion (N, 3) of the corners of a frame moves parts of a body that holds as it is apart."""
    length = np.linalg.norm(motion, axis=1).reshape(-1, 2).max(axis=1)[before.solids.row]
    return _is_deformed(before, motion, np.asarray(length > _FRAME_MOTION_TOLERANCE * before.solids.size, bool))


def is_deeper_motion(before: CheckedFrame, after: CheckedFrame, motion: FloatArray) -> bool:
    """Return whether a motion (N, 3) of the corners of a frame pushes a solid deeper into another object."""
    moved = _moved(before, after, motion)
    return bool(moved.any()) and _is_deeper(before, after, moved)


def _moved(before: CheckedFrame, after: CheckedFrame, motion: FloatArray) -> BoolArray:
    """Return which solids (N,) move; none if the frames have different solids."""
    old, new = before.solids, after.solids
    if len(old) != len(new) or (old.row != new.row).any() or not len(old):
        return np.zeros(len(old), bool)
    length = np.linalg.norm(motion, axis=1).reshape(-1, 2).max(axis=1)[old.row]
    return np.asarray(length > _FRAME_MOTION_TOLERANCE * old.size, bool)


def _sinks_ground(before: CheckedFrame, after: CheckedFrame) -> bool:
    """Return whether the ground is lower than before: what is put below it is found to stand on a new one."""
    return after.facts.ground.height < before.facts.ground.height - before.solids.touch


def _is_torn(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether a part of a body touches none of the parts that it touched."""
    touching = {tuple(pair) for pair in after.facts.contacts.pairs.tolist()}
    pairs, body = before.facts.contacts.pairs, before.facts.bodies.body
    joints = pairs[body[pairs[:, 0]] == body[pairs[:, 1]]]
    is_attached: dict[int, bool] = {}
    for i, j in joints[moved[joints].any(axis=1)].tolist():
        for k in (i, j):
            is_attached[k] = is_attached.get(k, False) or (i, j) in touching
    return not all(is_attached.values())


def _is_deformed(before: CheckedFrame, motion: FloatArray, moved: BoolArray) -> bool:
    """Return whether parts of a body that holds as it is move apart: a pot without its knob, out of a cup's way."""
    facts = before.facts
    of_solids = motion.reshape(-1, 2, 3)[before.solids.row]
    return any(
        verdict.holds
        and bool(moved[rows].any())
        and bool((np.ptp(of_solids[rows], axis=0) > _FRAME_MOTION_TOLERANCE * before.solids.size).any())
        for rows, verdict in zip(facts.bodies.members, facts.verdicts, strict=True)
    )


def _loses_support(before: CheckedFrame, after: CheckedFrame) -> bool:
    """Return whether gravity would move a body that held before."""
    then, now = before.facts, after.facts
    return any(
        verdict.holds and not now.verdicts[int(now.bodies.body[members[0]])].holds
        for members, verdict in zip(then.bodies.members, then.verdicts, strict=True)
    )


def _is_parted(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether a body that was in its place touches none of those it stood on, or one less beside it."""
    facts = before.facts
    body, verdicts = facts.bodies.body, facts.verdicts
    touching = set(map(tuple, body[after.facts.contacts.pairs].tolist()))
    stood, stands = set[int](), set[int]()
    # Deeper overlaps may be what is repaired: of two objects in each other, none of their contacts is meant.
    deep = {(k.body, k.other) for k in facts.statics.links if k.depth > _MEANT_DEPTH * before.solids.touch}
    for link in facts.statics.links:
        if link.row < 0 or not moved[facts.contacts.pairs[link.row]].any():
            continue
        holds = verdicts[link.body].holds and verdicts[link.other].holds
        pair = (link.body, link.other)
        is_meant = holds and pair not in deep
        touches = pair in touching or pair[::-1] in touching
        if abs(float(link.normal[1])) > 0.5:
            upper = link.body if link.normal[1] > 0.0 else link.other
            stood |= {upper} if is_meant else set()
            stands |= {upper} if touches else set()
        elif is_meant and not touches:
            return True
    return not stood <= stands


def _is_deeper(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether a moved solid penetrates another object deeper than before."""
    old, new, body = before.facts.contacts, after.facts.contacts, before.facts.bodies.body
    room = _DEPTH_TOLERANCE * after.solids.touch
    rows = np.flatnonzero((body[new.pairs[:, 0]] != body[new.pairs[:, 1]]) & moved[new.pairs].any(axis=1))
    before_rows = {tuple(pair): row for row, pair in enumerate(old.pairs.tolist())}
    for pair, deep in zip(new.pairs[rows].tolist(), new.depths(rows)[0].tolist()):
        row = before_rows.get(tuple(pair))
        if deep > room and deep > (0.0 if row is None else old.depth(row)) + room:
            return True
    return False
