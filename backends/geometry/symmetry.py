"""Parts of one body that break the mirror symmetry of its other parts: an ear that is too low, a lid beside its axis.

No noun decides, and no word: solids are compared by their outlines. Only what belongs to one body is compared, so
that what stands on a table or hangs on a wall may stand where it likes; and a part must be nearly at its place to be
wrong, since handles, taps and chimneys are on one side on purpose.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from scenelang.backends.facts.frame import FrameFacts
from scenelang.backends.facts.tolerances import Tolerance
from scenelang.backends.surfaces.distance import IntArray
from scenelang.backends.surfaces.solids import FloatArray

SAME = Tolerance(0.01, "of the solid's extent", "outlines that a program computes agree to rounding")
ASIDE = Tolerance(0.1, "of the part's extent", "a part that misses its place by less looks right")
NEAR_MIDDLE = Tolerance(0.25, "of the part's extent", "what is farther from the middle is on one side on purpose")
NEAR_IMAGE = Tolerance(1.5, "of the part's extent", "what is farther from the mirror image is another part")
OTHER_SIZE = Tolerance(1.15, "times the size", "less is not seen")
MOST_FIT = Tolerance(0.5, "of the solids of a body", "if fewer fit a plane, the body has no symmetry")

_MIN_SOLIDS = 4
_MIN_UNITS = 3
_MAX_SOLIDS = 200  # of an object that is examined: the comparison is quadratic
_MAX_COMPARISONS = 400_000  # pairs of solids in all
_MAX_PLANES = 3  # of an axis that are examined, the most frequent first

# Directions in which outlines are compared: to the sides and the edges of a box.
_DIRECTIONS = np.array([d for d in product((-1.0, 0.0, 1.0), repeat=3) if 0 < np.abs(d).sum() < 3])
_SIDES = [[int(np.flatnonzero((sign * side == _DIRECTIONS).all(axis=1))[0]) for sign in (-1, 1)] for side in np.eye(3)]
_MIRRORED = [
    [int(np.flatnonzero((d * (1.0 - 2.0 * side) == _DIRECTIONS).all(axis=1))[0]) for d in _DIRECTIONS]
    for side in np.eye(3)
]


@dataclass(frozen=True, slots=True, eq=False)
class Asymmetry:
    """A part that breaks a symmetry.

    Attributes
    ----------
    rows
        Its solids.
    counterpart
        Solids of which it should be the mirror image, none of what should be in the middle.
    evidence
        What is wrong, after the name of the part.
    move
        Translation in the world that would put it right, None if it has another size or turn.
    """

    rows: IntArray
    counterpart: IntArray
    evidence: str
    move: tuple[float, float, float] | None


def asymmetries(facts: FrameFacts) -> Iterator[Asymmetry]:
    """Yield the one part of each object, or part of an object, that breaks the mirror symmetry of its other parts.

    An object is what one reading joins to one body. Of equal ones, instances of one entity, one is examined.
    """
    ancestry, seen, left = facts.ancestry, set[tuple[int, int]](), _MAX_COMPARISONS
    first, last = ancestry.ranges(ancestry.primitives[facts.solids.row])
    for instance, rows in _objects(facts, first, last + 1):
        key = (int(ancestry.node[instance]), int(rows[0] - first[instance]))
        if key in seen or facts.ground.solids[rows].any():
            continue
        seen.add(key)
        left -= len(rows) ** 2
        if left < 0:
            return
        units = _units(facts, instance, rows)
        for axes in _axes(facts, ancestry.poses[instance], rows):
            outlines = _Outlines(facts, axes, rows)
            part = next(outlines.asymmetries(), None) or outlines.off_axis(units)
            if part is not None:
                yield part
                break


def _objects(facts: FrameFacts, first: IntArray, end: IntArray) -> Iterator[tuple[int, IntArray]]:
    """Yield instances with the solids of objects, and of their parts that have several solids: a head on its body."""
    bodies = facts.bodies
    joined = bodies.joined[bodies.body]
    if len(np.unique(facts.clusters)) == 1 and not facts.ground.solids.any():  # the scene is one object
        joined = np.zeros_like(joined)
    parts = _parts(facts, joined, first, end)
    order = np.argsort(joined, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(joined[order])) + 1):
        if len(rows) < _MIN_UNITS:
            continue
        if len(rows) <= _MAX_SOLIDS:
            yield innermost(facts, first, end, rows), rows
        for instance in parts.get(int(joined[rows[0]]), ()):
            if end[instance] - first[instance] < len(rows):
                yield instance, np.arange(first[instance], end[instance])


def _parts(facts: FrameFacts, joined: IntArray, first: IntArray, end: IntArray) -> dict[int, list[int]]:
    """Return for each object the instances with several solids, all of the object; ``joined`` (N,) is that of each."""
    changes = np.concatenate([[0], np.cumsum(np.diff(joined) != 0)])
    several = np.flatnonzero((end - first >= _MIN_UNITS) & (end - first <= _MAX_SOLIDS))
    parts: dict[int, list[int]] = {}
    for instance in several[changes[first[several]] == changes[end[several] - 1]].tolist():
        if not facts.ancestry.entity(instance).is_primitive:
            parts.setdefault(int(joined[first[instance]]), []).append(instance)
    return parts


def _units(facts: FrameFacts, instance: int, rows: IntArray) -> IntArray:
    """Return the child (N,) of an instance that each solid is in."""
    ancestry = facts.ancestry
    depth = int(ancestry.depth[instance]) + 1
    return np.asarray(ancestry.at_depth(depth)[ancestry.primitives[facts.solids.row[rows]]], np.int64)


def _axes(facts: FrameFacts, pose: FloatArray, rows: IntArray) -> Iterator[FloatArray]:
    """Yield the axes (3, 3) in which an object may be symmetric: those of its instance, and of its largest solid."""
    own = unit_columns(pose[:, :3])
    yield own
    low, high = facts.solids.boxes
    largest = rows[np.argmax(np.prod(high[rows] - low[rows], axis=1))]
    other = unit_columns(facts.solids.solids.matrices[largest][:, :3])
    if np.abs(other.T @ other - np.eye(3)).max() < 1e-6 and np.sort(np.abs(own.T @ other), axis=None)[-3] < 1.0 - 1e-6:
        yield other


def unit_columns(matrices: FloatArray) -> FloatArray:
    """Return matrices (..., 3, 3) with columns of unit length: the directions of the axes of poses."""
    lengths = np.linalg.norm(matrices, axis=-2, keepdims=True)
    return np.asarray(matrices / np.maximum(lengths, 1e-300), np.float64)


def innermost(facts: FrameFacts, first: IntArray, end: IntArray, rows: IntArray) -> int:
    """Return the innermost instance around solids; instances have the solids from ``first`` to before ``end``."""
    ancestry, lowest, highest = facts.ancestry, rows.min(), rows.max()
    instance = int(ancestry.primitives[facts.solids.row[lowest]])
    while end[instance] <= highest:
        instance = int(ancestry.parent[instance])
    return instance


class _Outlines:
    """Outlines of the N solids of an object, along some axes.

    Attributes
    ----------
    reach : (N, 18)
        How far each solid extends from the origin in each of ``_DIRECTIONS``.
    centers, sizes : (N, 3)
        Of the boxes of the solids.
    """

    def __init__(self, facts: FrameFacts, axes: FloatArray, rows: IntArray) -> None:
        self.rows, self.axes = rows, axes
        solids = facts.solids.solids.take(rows)
        directions = _DIRECTIONS @ self.axes.T
        self.reach = np.stack([solids.support(np.tile(d, (len(rows), 1))) @ d for d in directions], axis=1)
        under, over = (np.stack([self.reach[:, side[end]] for side in _SIDES], axis=1) for end in (0, 1))
        self.centers, self.sizes = (over - under) / 2.0, over + under
        self.names = np.array([solids.kinds[form].name for form in solids.forms.tolist()])
        self.own_sizes = np.sort(np.linalg.norm(solids.matrices[:, :, :3], axis=1), axis=1)
        self.touch = SAME * self.sizes.max(axis=1)

    def asymmetries(self) -> Iterator[Asymmetry]:
        """Yield the parts that break a symmetry that most solids have."""
        for axis in self._level_axes():
            for plane in self._planes(axis) if len(self.rows) >= _MIN_SOLIDS else ():
                fitting, paired = self._fit(axis, plane, np.arange(len(self.rows)))
                strays = np.flatnonzero(~fitting)
                if len(strays) and fitting.sum() >= max(MOST_FIT * len(fitting), _MIN_SOLIDS - 1):
                    part = self._aside(axis, plane, strays)
                    if part is None and paired.any():
                        part = self._unlike(axis, plane, self._two_sided(axis, plane, strays))
                    if part is not None:
                        yield part
                        return

    def off_axis(self, units: IntArray) -> Asymmetry | None:
        """Return the one of at least three units (N,) that is a little beside the vertical axis of all others."""
        numbers, unit = np.unique(units, return_inverse=True)
        members = [np.flatnonzero(unit.reshape(-1) == k) for k in range(len(numbers))]
        axes = list(self._level_axes())
        if len(members) < _MIN_UNITS or len(axes) != 2:
            return None
        extents = np.array([self._extent(rows) for rows in members])
        middles = np.array([(self.centers[rows] - self.sizes[rows] / 2.0).min(axis=0) for rows in members])
        offsets = middles + extents / 2.0
        offsets = offsets - np.median(offsets, axis=0)
        away = np.abs(offsets) > SAME * extents.max(axis=1, keepdims=True)
        for axis, other in (axes, axes[::-1]):
            odd = np.flatnonzero(away[:, axis])
            if len(odd) == 1 and not away[:, other].any():
                rows, offset, extent = members[odd[0]], float(offsets[odd[0], axis]), float(extents[odd[0], axis])
                if ASIDE * extent <= abs(offset) <= NEAR_MIDDLE * extent:
                    evidence = f"is {abs(offset):.3g} beside the axis that the other {len(members) - 1} parts share"
                    move = self._move(-offset * np.eye(3)[axis])
                    return Asymmetry(self.rows[rows], self.rows[:0], evidence, move)
        return None

    def _level_axes(self) -> Iterator[int]:
        """Yield the axes that are not vertical: few things are symmetric from top to bottom."""
        yield from (axis for axis in range(3) if abs(self.axes[1, axis]) <= 0.9)

    def _two_sided(self, axis: int, plane: float, strays: IntArray) -> IntArray:
        """Return the stray solids that have a counterpart on the other side: handles and doors have none."""
        left, right = (
            strays[side] for side in (self.centers[strays, axis] < plane, self.centers[strays, axis] >= plane)
        )
        if not len(left) or not len(right):
            return strays[:0]
        far = np.linalg.norm(self._mirrored(axis, plane, left)[:, None] - self.centers[right][None], axis=2)
        far[self.names[left][:, None] != self.names[right][None]] = np.inf
        pairs = [(i, int(np.argmin(far[i]))) for i in range(len(left)) if np.isfinite(far[i]).any()]
        pairs = [(i, j) for i, j in pairs if int(np.argmin(far[:, j])) == i]
        pairs = [(i, j) for i, j in pairs if far[i, j] <= NEAR_IMAGE * float(self.sizes[[left[i], right[j]]].max())]
        return np.array([*(left[i] for i, _ in pairs), *(right[j] for _, j in pairs)], np.int64)

    def _planes(self, axis: int) -> list[float]:
        """Return the coordinates of planes midway between most solids of equal outline, or through their centers."""
        level = _DIRECTIONS[:, axis] == 0.0
        keys = np.concatenate([self.reach[:, level], self.sizes[:, [axis]]], axis=1)
        first, second = np.nonzero(np.triu(np.abs(keys[:, None] - keys[None]).max(axis=2) <= self.touch[:, None]))
        middles = np.sort((self.centers[first, axis] + self.centers[second, axis]) / 2.0)
        edges = np.flatnonzero(np.diff(middles) > self.touch.min()) + 1
        planes = sorted(np.split(middles, edges), key=len, reverse=True)
        return [float(np.median(plane)) for plane in planes[:_MAX_PLANES]]

    def _image(self, axis: int, plane: float, which: IntArray) -> FloatArray:
        """Return the reach (K, 18) of the mirror images of solids."""
        return np.asarray(self.reach[which][:, _MIRRORED[axis]] + 2.0 * plane * _DIRECTIONS[:, axis], np.float64)

    def _mirrored(self, axis: int, plane: float, which: IntArray) -> FloatArray:
        """Return the centers (K, 3) of the mirror images of solids."""
        centers = self.centers[which].copy()
        centers[:, axis] = 2.0 * plane - centers[:, axis]
        return np.asarray(centers, np.float64)

    def _fit(self, axis: int, plane: float, which: IntArray) -> tuple[np.ndarray, np.ndarray]:
        """Return which solids have a mirror image among them, and which have one that is another solid."""
        gaps = np.abs(self._image(axis, plane, which)[:, None] - self.reach[which][None]).max(axis=2)
        same = (gaps <= self.touch[which][:, None]) & (self.names[which][:, None] == self.names[which][None])
        return same.any(axis=1), same.any(axis=1) & ~np.diagonal(same)

    def _extent(self, which: IntArray) -> FloatArray:
        """Return the extents (3,) of solids together."""
        low, high = self.centers[which] - self.sizes[which] / 2.0, self.centers[which] + self.sizes[which] / 2.0
        return np.asarray(high.max(axis=0) - low.min(axis=0), np.float64)

    def _aside(self, axis: int, plane: float, strays: IntArray) -> Asymmetry | None:
        """Return the part that is symmetric about a plane a little beside that of all other solids."""
        low = (self.centers[strays, axis] - self.sizes[strays, axis] / 2.0).min()
        extent = float(self._extent(strays)[axis])
        own = float(low + extent / 2.0)
        offset = own - plane
        if not ASIDE * extent <= abs(offset) <= NEAR_MIDDLE * extent or not self._fit(axis, own, strays)[0].all():
            return None
        rest = len(self.rows) - len(strays)
        evidence = f"is {abs(offset):.3g} beside the middle of its body: the other {rest} shapes are symmetric about it"
        return Asymmetry(self.rows[strays], self.rows[:0], evidence, self._move(-offset * np.eye(3)[axis]))

    def _unlike(self, axis: int, plane: float, strays: IntArray) -> Asymmetry | None:
        """Return the part that is not at the place, or of the size, of the mirror image of another."""
        if not len(strays):
            return None
        first, second = np.split(strays, 2)
        image = self._image(axis, plane, first)
        offsets = self.centers[second] - self._mirrored(axis, plane, first)
        rest, extent = len(self.rows) - len(strays), float(self._extent(second).max())
        if np.linalg.norm(offsets - offsets[0], axis=1).max() > extent:
            return None  # several parts differ
        fit = f"the other {rest} shapes are symmetric"
        length = float(np.linalg.norm(offsets[0]))
        moved = image + offsets @ _DIRECTIONS.T - self.reach[second]
        if (np.abs(moved).max(axis=1) <= self.touch[second]).all():
            if np.ptp(offsets, axis=0).max() > self.touch[second].min():
                return None
            if not ASIDE * extent <= length <= NEAR_IMAGE * extent:
                return None
            evidence = f"is {length:.3g} from the mirror image of its counterpart: {fit}"
            return Asymmetry(self.rows[second], self.rows[first], evidence, self._move(-offsets[0]))
        if length > NEAR_IMAGE * extent:
            return None
        stays = np.abs(offsets).max(axis=1) <= self.touch[second]
        if (
            stays.all()
            and (np.abs(self.own_sizes[first] - self.own_sizes[second]).max(axis=1) <= self.touch[second]).all()
        ):
            evidence = f"is turned otherwise than the mirror image of its counterpart: {fit}"
            return Asymmetry(self.rows[second], self.rows[first], evidence, None)
        ratios = np.maximum(self.own_sizes[second], 1e-300) / np.maximum(self.own_sizes[first], 1e-300)
        ratio = float(ratios.flat[np.argmax(np.abs(np.log(ratios)))])
        if max(ratio, 1.0 / ratio) < OTHER_SIZE:
            if np.abs(moved).max() < ASIDE * extent:
                return None
            evidence = f"has another shape or turn than the mirror image of its counterpart: {fit}"
            return Asymmetry(self.rows[second], self.rows[first], evidence, None)
        how = f"{max(ratio, 1.0 / ratio):.3g} times as {'large' if ratio > 1.0 else 'small'} as its counterpart"
        return Asymmetry(self.rows[second], self.rows[first], f"is {how} on the other side: {fit}", None)

    def _move(self, offset: FloatArray) -> tuple[float, float, float]:
        """Return a translation in the world."""
        x, y, z = (self.axes @ offset).tolist()
        return x, y, z
