"""What an edit does to the things of a scene: how far it moves them, whether it bends them, and whether they rest.

A thing is what a person would lift: parts that touch, and what one word is made of. ``repairing`` looks for edits; here
they are weighed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from scenelang.backends.geometry.arrangement import Vector
    from scenelang.backends.geometry.lint import CheckedFrame, Finding
    from scenelang.backends.surfaces.convex import Bodies
    from scenelang.backends.surfaces.distance import IntArray
    from scenelang.backends.surfaces.solids import FloatArray

BoolArray = npt.NDArray[np.bool_]

_BENT = 4.0  # what bending a thing costs, of moving it as far
_OTHERS = 2.0  # what moving a thing costs that is in no finding
_ROOM = -0.02  # of a group's breadth: how far inside its support the centre of mass of what was moved is
_SMALL = 1e-3  # of a translation: less is rounding


def rows_of(primitives: IntArray | None, at: int) -> IntArray:
    """Return the rows of the layout for primitives of a frame that begins at ``at``: two corners of each."""
    if primitives is None:
        return np.zeros(0, np.int64)
    return np.stack([2 * (primitives + at), 2 * (primitives + at) + 1], axis=1).reshape(-1)


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """Translations of a mean of some corners relative to that of others, each of which would do.

    ``rows`` and ``others`` are rows of the layout, ``weights`` and ``other_weights`` their shares, which sum to 1.
    """

    rows: IntArray
    weights: FloatArray
    others: IntArray
    other_weights: FloatArray
    moves: tuple[Vector, ...]

    @classmethod
    def between(cls, rows: IntArray, others: IntArray, moves: tuple[Vector, ...]) -> Aim:
        return cls(rows, _equal(rows), others, _equal(others), moves)

    def of(self, motion: FloatArray) -> FloatArray:
        """Return what a motion (N, 3) or (N, 3, K) of all corners does for the aim."""
        own = np.tensordot(self.weights, motion[self.rows], 1)
        return np.asarray(own - np.tensordot(self.other_weights, motion[self.others], 1), np.float64)


def _equal(rows: IntArray) -> FloatArray:
    return np.full(len(rows), 1.0 / max(len(rows), 1))


@dataclass(frozen=True, slots=True, eq=False)
class Rearranged:
    """The thing (N,) of each corner of a layout, and the number of corners of each thing."""

    thing: IntArray
    counts: IntArray

    @classmethod
    def of(cls, frames: Sequence[tuple[CheckedFrame, int, int]]) -> Rearranged:
        """Return the things of frames, each with the position of its first primitive and their number."""
        from scenelang.backends.surfaces.convex import clusters

        labels = [np.zeros(0, np.int64)]
        for frame, at, count in frames:
            own = np.arange(count) + at
            contacts, row = frame.contacts, frame.bodies.row
            lifted = ~contacts.loose & (contacts.owner > 1)
            first = dict(zip(contacts.owner[lifted].tolist(), np.flatnonzero(lifted).tolist()))
            pairs = [(i, first[owner]) for i, owner in enumerate(contacts.owner.tolist()) if lifted[i]]
            own[row] = at + row[clusters(len(row), [*enumerate(contacts.object_of.tolist()), *pairs])]
            labels.append(own)
        _, thing, counts = np.unique(np.repeat(np.concatenate(labels), 2), return_inverse=True, return_counts=True)
        return cls(thing, counts)

    def cost(self, motion: FloatArray, rows: IntArray, every: IntArray) -> float:
        """Return what a motion (N, 3) of all corners costs: how far things move, twice for those that no finding is
        about (``every``), and how much they are bent. Those of equal findings (``rows``) count as one."""
        mean, rest = self._split(motion)
        weights = np.full(len(self.counts), _OTHERS)
        weights[self.thing[every]] = 1.0 / max(len(np.unique(self.thing[rows])), 1)
        bent = np.zeros(len(self.counts))
        np.maximum.at(bent, self.thing, np.linalg.norm(rest, axis=1))
        return float(weights @ np.linalg.norm(mean, axis=1) + _BENT * bent.sum())

    def least(self, corners: FloatArray) -> FloatArray:
        """Return the least extent (N,) of the box of each corner's thing."""
        low, high = np.full((len(self.counts), 3), np.inf), np.full((len(self.counts), 3), -np.inf)
        np.minimum.at(low, self.thing, corners)
        np.maximum.at(high, self.thing, corners)
        return np.asarray((high - low).min(axis=1)[self.thing], np.float64)

    def _split(self, motion: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the mean motion of each thing, and the rest of the motion of each corner."""
        sums = [np.bincount(self.thing, motion[:, axis], len(self.counts)) for axis in range(3)]
        mean: FloatArray = np.stack(sums, axis=1) / np.maximum(self.counts, 1)[:, None]
        return mean, motion - mean[self.thing]


# --- what resolves a finding of the lint -----------------------------------------------------------------------------


def aims_of(frame: CheckedFrame, finding: Finding, cluster: IntArray, at: int) -> Iterator[Aim]:
    """Yield what would resolve a finding: translations of its thing, and of the part of it that it names."""
    from scenelang.backends.geometry.lint import ground_height
    from scenelang.backends.geometry.stability import loads_of

    bodies, thing = frame.bodies, frame.contacts.object_of
    if finding.shift is not None:
        members, shares, feet = loads_of(bodies, frame.contacts, finding.body, ground_height(bodies))
        heavy, standing = rows_of(bodies.row[members], at), rows_of(bodies.row[feet], at)
        yield Aim(heavy, np.repeat(shares / 2.0, 2), standing, _equal(standing), (finding.shift,))
    moves = (*_moves(bodies, finding), *_falls(frame, cluster, finding))
    if not moves:
        return
    rows, none = rows_of(bodies.row[thing == thing[finding.body]], at), rows_of(None, at)
    body = rows_of(bodies.row[[finding.body]], at)
    if finding.other is None:
        yield Aim.between(rows, none, moves)
        yield Aim.between(body, none, moves)
    elif thing[finding.body] == thing[finding.other]:
        yield Aim.between(body, rows_of(bodies.row[[finding.other]], at), moves)
    else:
        others = rows_of(bodies.row[[finding.other]], at)
        yield Aim.between(rows, others, moves)
        yield Aim.between(body, others, moves)


def _falls(frame: CheckedFrame, cluster: IntArray, finding: Finding) -> Iterator[Vector]:
    """Yield how far the things that touch the subject of a finding can fall: to the ground, and to what is below."""
    from scenelang.backends.geometry.lint import ground_height

    if finding.kind not in ("hovering", "hanging", "unstable", "tipping"):
        return
    bodies = frame.bodies
    low, high = bodies.boxes
    if finding.kind == "hanging":  # it touches only what it is to fall from
        cluster = frame.contacts.object_of
    own = cluster == cluster[finding.body]
    foot, least, most = float(low[own, 1].min()), low[own].min(axis=0), high[own].max(axis=0)
    below = ~own & (high[:, 1] <= foot + bodies.touch)
    for axis in (0, 2):
        below &= (low[:, axis] < most[axis]) & (high[:, axis] > least[axis])
    heights = {ground_height(bodies), *([float(high[below, 1].max())] if below.any() else [])}
    yield from ((0.0, height - foot, 0.0) for height in sorted(heights, reverse=True) if foot - height > bodies.touch)


def _moves(bodies: Bodies, finding: Finding) -> tuple[Vector, ...]:
    """Return the translations that would resolve a finding: its own, or those that separate the two boxes."""
    if finding.move is not None:
        least = _SMALL * max(map(abs, finding.move))
        x, y, z = (each if abs(each) > least else 0.0 for each in finding.move)
        return ((x, y, z),)
    if finding.other is None or finding.kind == "twin" or finding.shift is not None:
        return ()
    low, high = bodies.boxes
    i, j = finding.body, finding.other
    moves: list[Vector] = []
    for axis in range(3):
        up, down = high[j, axis] - low[i, axis], low[j, axis] - high[i, axis]
        if finding.kind == "fighting":
            up, down = (math.copysign(4.0 * bodies.touch, each) for each in (up, down))
        for length in (up,) if axis == 1 else (up, down):  # nothing is put under what it was in
            x, y, z = (float(length) if k == axis else 0.0 for k in range(3))
            moves.append((x, y, z))
    return tuple(sorted(moves, key=lambda move: math.hypot(*move)))


# --- whether things rest after an edit -------------------------------------------------------------------------------


def is_sound_motion(before: CheckedFrame, after: CheckedFrame, motion: FloatArray) -> bool:
    """Return whether what a motion (N, 3) of the corners of a frame moves rests as it did: parts stay together, nothing
    loses what carries it or stands without room.

    This is stricter than the lint, which reports only what is nearly always a mistake.
    """
    moved = _moved(before, after, motion)
    return not moved.any() or not (
        _is_torn(before, after, moved) or _is_left(before, after, moved) or _is_loose(before, after, moved)
    )


def is_deeper_motion(before: CheckedFrame, after: CheckedFrame, motion: FloatArray) -> bool:
    """Return whether a motion (N, 3) of the corners of a frame sets anything deeper into another thing than it was."""
    moved = _moved(before, after, motion)
    return bool(moved.any()) and _is_deeper(before, after, moved)


def _moved(before: CheckedFrame, after: CheckedFrame, motion: FloatArray) -> BoolArray:
    """Return which bodies (N,) are moved, none if others are in the frame."""
    old, new = before.bodies, after.bodies
    if len(old) != len(new) or (old.row != new.row).any() or not len(old):
        return np.zeros(len(old), bool)
    length = np.linalg.norm(motion, axis=1).reshape(-1, 2).max(axis=1)[old.row]
    return np.asarray(length > _STILL * old.size, bool)


_STILL = 1e-6  # of the frame's size


def _is_torn(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether a part of a thing touches none of the parts that it touched."""
    touching = {tuple(pair) for pair in after.contacts.pairs.tolist()}
    own = before.contacts.pairs[~before.contacts.apart]
    kept: dict[int, bool] = {}
    for i, j in own[moved[own].any(axis=1)].tolist():
        for k in (i, j):
            kept[k] = kept.get(k, False) or (i, j) in touching
    return not all(kept.values())


def _is_left(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether a thing that stood on something touches it only at the side, or a thing touches nothing more."""
    things = before.contacts.object_of
    return bool((_hold(after, things) < _hold(before, things)).any())


_STANDS, _TOUCHES = 2, 1


def _hold(frame: CheckedFrame, things: IntArray) -> IntArray:
    """Return for each number of a thing (N,) whether it stands on something, touches something, or neither."""
    from scenelang.backends.geometry.lint import ground_height

    bodies, contacts = frame.bodies, frame.contacts
    low, high = bodies.boxes
    found = np.zeros(len(things), np.int64)
    pairs = contacts.pairs[things[contacts.pairs[:, 0]] != things[contacts.pairs[:, 1]]]
    found[things[pairs]] = _TOUCHES
    resting = contacts.pairs[contacts.rests]
    middle = (low + high)[:, 1]
    found[things[np.where(middle[resting[:, 0]] >= middle[resting[:, 1]], resting[:, 0], resting[:, 1])]] = _STANDS
    found[things[low[:, 1] <= ground_height(bodies) + bodies.touch]] = _STANDS
    return found


def _is_deeper(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether what was moved is deeper in another thing than it was."""
    known = dict(zip(map(tuple, before.contacts.pairs.tolist()), before.contacts.depth.tolist()))
    pairs, depth = after.contacts.pairs, after.contacts.depth
    near = after.contacts.apart & moved[pairs].any(axis=1) & (depth > _DEEPER * after.bodies.touch)
    room = _DEEPER * after.bodies.touch
    return any(
        deep > max(known.get(tuple(pair), 0.0), 0.0) + room
        for pair, deep in zip(pairs[near].tolist(), depth[near].tolist())
    )


_DEEPER = 1.0  # contact tolerances


def _is_loose(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether what was moved stands with its centre of mass so near to the edge that it may fall."""
    from scenelang.backends.geometry.lint import ground_height
    from scenelang.backends.geometry.stability import unstable

    ground = [ground_height(frame.bodies) for frame in (before, after)]
    group = after.contacts.group
    found = {fault.body for fault in unstable(after.bodies, after.contacts, ground[1], (_ROOM, _ROOM)) if fault.shift}
    found = {body for body in found if moved[group == group[body]].any()}
    return bool(found) and not found <= {
        fault.body for fault in unstable(before.bodies, before.contacts, ground[0], (_ROOM, _ROOM))
    }
