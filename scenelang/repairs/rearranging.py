"""Effects of an edit on the objects of a scene: how far it moves them, whether it deforms them, whether they stay
supported.

An object is what a person would lift as one: parts that touch and belong to one word (``backends/geometry/stability``
forms them). ``repairing`` proposes edits; this module rates them.
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

# Moving the parts of an object against each other costs four times as much as moving the whole object as far, so that
# a cabinet that is in a wall is moved by the numbers that place it, and not by those of one board. An object that is
# in no finding costs twice. Both are weights of preference; docs/relations.md has the share of faults repaired with
# them (`python benchmarks/repairs.py`).
_DEFORMATION_COST = 4.0
_UNINVOLVED_COST = 2.0
# Margin of `unstable`, relative to the breadth of a group: negative, because a moved object must not only be balanced
# but have its center of mass inside its support by 2 % of its breadth.
_BALANCE_MARGIN = -0.02
_NEGLIGIBLE_SHARE = 1e-3  # of the longest component of a translation: smaller components are rounding
_MOTION_TOLERANCE = 1e-6  # relative to the size of the frame: smaller motions are rounding
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
    """

    rows: IntArray
    weights: FloatArray
    others: IntArray
    other_weights: FloatArray
    moves: tuple[Vector, ...]

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
        from scenelang.backends.surfaces.convex import clusters

        labels = [np.zeros(0, np.int64)]
        for frame, at, count in frames:
            frame_labels = np.arange(count) + at  # until they are joined, every primitive is an object
            contacts, row = frame.contacts, frame.bodies.row
            # Bodies of one instance belong together even if they do not touch, except shapes that a program arranges.
            has_owner = ~contacts.loose & (contacts.owner > 1)
            first = dict(zip(contacts.owner[has_owner].tolist(), np.flatnonzero(has_owner).tolist()))
            pairs = [(i, first[owner]) for i, owner in enumerate(contacts.owner.tolist()) if has_owner[i]]
            frame_labels[row] = at + row[clusters(len(row), [*enumerate(contacts.object_of.tolist()), *pairs])]
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


# --- aims of lint findings ------------------------------------------------------------------------------------------


def aims_of(frame: CheckedFrame, finding: Finding, cluster: IntArray, at: int) -> Iterator[Aim]:
    """Yield the motions that would resolve a finding: of its object, and of the part that it names.

    Parameters
    ----------
    cluster
        Number (N,) of the group of touching bodies that each body is in.
    at
        Position of the frame's first primitive in the layout.
    """
    from scenelang.backends.geometry.lint import ground_height
    from scenelang.backends.geometry.stability import loads_of

    bodies, object_of = frame.bodies, frame.contacts.object_of
    if finding.shift is not None:
        members, shares, feet = loads_of(bodies, frame.contacts, finding.body, ground_height(bodies))
        # An unbalanced object: its load, each body by its share of the mass, moves over its feet.
        heavy, standing = rows_of(bodies.row[members], at), rows_of(bodies.row[feet], at)
        yield Aim(heavy, np.repeat(shares / 2.0, 2), standing, _equal(standing), (finding.shift,))
    moves = (*_moves(bodies, finding), *_falls(frame, cluster, finding))
    if not moves:
        return
    rows, none = rows_of(bodies.row[object_of == object_of[finding.body]], at), rows_of(None, at)
    body = rows_of(bodies.row[[finding.body]], at)
    if finding.other is None:
        yield Aim.between(rows, none, moves)
        yield Aim.between(body, none, moves)
    elif object_of[finding.body] == object_of[finding.other]:
        yield Aim.between(body, rows_of(bodies.row[[finding.other]], at), moves)
    else:
        others = rows_of(bodies.row[[finding.other]], at)
        yield Aim.between(rows, others, moves)
        yield Aim.between(body, others, moves)


def _falls(frame: CheckedFrame, cluster: IntArray, finding: Finding) -> Iterator[Vector]:
    """Yield the drops of a finding's cluster of touching objects: to the highest body below it, and to the ground."""
    from scenelang.backends.geometry.lint import ground_height

    if finding.kind not in ("hovering", "hanging", "unstable", "tipping"):
        return
    bodies = frame.bodies
    low, high = bodies.boxes
    if finding.kind == "hanging":  # the only contact is with the support that it falls from
        cluster = frame.contacts.object_of
    in_cluster = cluster == cluster[finding.body]
    foot, least, most = float(low[in_cluster, 1].min()), low[in_cluster].min(axis=0), high[in_cluster].max(axis=0)
    below = ~in_cluster & (high[:, 1] <= foot + bodies.touch)
    for axis in (0, 2):
        below &= (low[:, axis] < most[axis]) & (high[:, axis] > least[axis])
    heights = {ground_height(bodies), *([float(high[below, 1].max())] if below.any() else [])}
    yield from ((0.0, height - foot, 0.0) for height in sorted(heights, reverse=True) if foot - height > bodies.touch)


def _moves(bodies: Bodies, finding: Finding) -> tuple[Vector, ...]:
    """Return the translations that would resolve a finding, the shortest first.

    They are the one that the finding has, or those that separate the two boxes along an axis.
    """
    if finding.move is not None:
        least = _NEGLIGIBLE_SHARE * max(map(abs, finding.move))
        x, y, z = (component if abs(component) > least else 0.0 for component in finding.move)
        return ((x, y, z),)
    if finding.other is None or finding.kind == "twin" or finding.shift is not None:
        return ()
    low, high = bodies.boxes
    i, j = finding.body, finding.other
    moves: list[Vector] = []
    for axis in range(3):
        up, down = high[j, axis] - low[i, axis], low[j, axis] - high[i, axis]
        if finding.kind == "fighting":
            # Coplanar faces are separated by little: four contact tolerances are no contact, and hardly visible.
            up, down = (math.copysign(4.0 * bodies.touch, length) for length in (up, down))
        for length in (up,) if axis == 1 else (up, down):  # an object is not moved below the one that it penetrates
            x, y, z = (float(length) if k == axis else 0.0 for k in range(3))
            moves.append((x, y, z))
    return tuple(sorted(moves, key=lambda move: math.hypot(*move)))


# --- support after an edit -------------------------------------------------------------------------------------------


def is_sound_motion(before: CheckedFrame, after: CheckedFrame, motion: FloatArray) -> bool:
    """Return whether everything that a motion (N, 3) of the corners of a frame moves is supported as before.

    Parts stay together, and nothing loses its support or comes close to falling. This is stricter than the lint, which
    reports only what is nearly always a mistake.
    """
    moved = _moved(before, after, motion)
    return not moved.any() or not (
        _is_torn(before, after, moved) or _loses_support(before, after, moved) or _loses_balance(before, after, moved)
    )


def is_deeper_motion(before: CheckedFrame, after: CheckedFrame, motion: FloatArray) -> bool:
    """Return whether a motion (N, 3) of the corners of a frame pushes a body deeper into another object."""
    moved = _moved(before, after, motion)
    return bool(moved.any()) and _is_deeper(before, after, moved)


def _moved(before: CheckedFrame, after: CheckedFrame, motion: FloatArray) -> BoolArray:
    """Return which bodies (N,) move; none if the frames have different bodies."""
    old, new = before.bodies, after.bodies
    if len(old) != len(new) or (old.row != new.row).any() or not len(old):
        return np.zeros(len(old), bool)
    length = np.linalg.norm(motion, axis=1).reshape(-1, 2).max(axis=1)[old.row]
    return np.asarray(length > _MOTION_TOLERANCE * old.size, bool)


def _is_torn(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether a part of an object touches none of the parts that it touched."""
    touching = {tuple(pair) for pair in after.contacts.pairs.tolist()}
    joints = before.contacts.pairs[~before.contacts.apart]
    is_attached: dict[int, bool] = {}
    for i, j in joints[moved[joints].any(axis=1)].tolist():
        for k in (i, j):
            is_attached[k] = is_attached.get(k, False) or (i, j) in touching
    return not all(is_attached.values())


def _loses_support(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether an object that stood on something touches it only sideways now, or has no contact any more."""
    labels = before.contacts.object_of
    return bool((_support_of(after, labels) < _support_of(before, labels)).any())


_STANDS, _TOUCHES = 2, 1


def _support_of(frame: CheckedFrame, labels: IntArray) -> IntArray:
    """Return for each object number (N,) ``_STANDS``, ``_TOUCHES``, or 0 if it has no contact."""
    from scenelang.backends.geometry.lint import ground_height

    bodies, contacts = frame.bodies, frame.contacts
    low, high = bodies.boxes
    support = np.zeros(len(labels), np.int64)
    pairs = contacts.pairs[labels[contacts.pairs[:, 0]] != labels[contacts.pairs[:, 1]]]
    support[labels[pairs]] = _TOUCHES
    resting = contacts.pairs[contacts.rests]
    middle = (low + high)[:, 1]  # twice the height of the center: of two bodies, the higher one stands
    support[labels[np.where(middle[resting[:, 0]] >= middle[resting[:, 1]], resting[:, 0], resting[:, 1])]] = _STANDS
    support[labels[low[:, 1] <= ground_height(bodies) + bodies.touch]] = _STANDS
    return support


def _is_deeper(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether a moved body penetrates another object deeper than before."""
    known = dict(zip(map(tuple, before.contacts.pairs.tolist()), before.contacts.depth.tolist()))
    pairs, depth = after.contacts.pairs, after.contacts.depth
    near = after.contacts.apart & moved[pairs].any(axis=1) & (depth > _DEPTH_TOLERANCE * after.bodies.touch)
    room = _DEPTH_TOLERANCE * after.bodies.touch
    return any(
        deep > max(known.get(tuple(pair), 0.0), 0.0) + room
        for pair, deep in zip(pairs[near].tolist(), depth[near].tolist())
    )


def _loses_balance(before: CheckedFrame, after: CheckedFrame, moved: BoolArray) -> bool:
    """Return whether a moved group is balanced so narrowly that it may fall, and was not before."""
    from scenelang.backends.geometry.lint import ground_height
    from scenelang.backends.geometry.stability import unstable

    ground = [ground_height(frame.bodies) for frame in (before, after)]
    group = after.contacts.group
    margins = (_BALANCE_MARGIN, _BALANCE_MARGIN)
    tipping = {fault.body for fault in unstable(after.bodies, after.contacts, ground[1], margins) if fault.shift}
    tipping = {body for body in tipping if moved[group == group[body]].any()}
    return bool(tipping) and not tipping <= {
        fault.body for fault in unstable(before.bodies, before.contacts, ground[0], margins)
    }
