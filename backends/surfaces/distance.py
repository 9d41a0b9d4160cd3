"""Distance and penetration depth of pairs of convex solids, vectorized over pairs.

Non-convex solids, such as a ring, are replaced by their convex hulls. The distance is computed by the algorithm of
Gilbert, Johnson and Keerthi (1988): the point of the Minkowski difference A - B nearest to the origin is approached by
simplices of support points. The penetration depth is the shortest translation that separates two solids, which is the
minimum width of the difference over all directions: exact for two boxes by the separating axis theorem (Gottschalk, Lin
and Manocha, "OBBTree", 1996), otherwise refined from many directions. MuJoCo, which computes the same, is an extra and
has no cones or shears.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.solids import FloatArray, PosedForms
from scenelang.interpreter.scene.primitives.mesh import cofactors_of

# --- broad phase -----------------------------------------------------------------------------------------------------


IntArray = npt.NDArray[np.int64]

_MIN_CELL = 2.0**-20  # relative to the frame: three indices of 21 bits make a cell number of 63 bits
_BATCH_BOXES = 1 << 18  # boxes looked up at once, which bounds the memory
_OFFSETS = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]


def neighbors(low: FloatArray, high: FloatArray, margin: float, most: int) -> tuple[IntArray, bool]:
    """Return the pairs of boxes that are within a distance of each other.

    Boxes are hashed by their low corners in a hierarchy of grids, whose cells double in size: each box is compared with
    the boxes of at most its size in the 27 cells around it (Mirtich, "Efficient Algorithms for Two-Phase Collision
    Detection", 1997). The time is linear in the number of boxes and pairs.

    Parameters
    ----------
    low, high : (N, 3)
        Corners of the boxes.
    margin
        Distance in the unit of the corners.
    most
        Maximum number of pairs.

    Returns
    -------
    pairs : (M, 2)
        Indices, the smaller first, sorted.
    complete
        Whether there are no further pairs.
    """
    if not len(low):
        return np.zeros((0, 2), np.int64), True
    low, high = low - margin / 2.0, high + margin / 2.0
    least = max(float((high.max(axis=0) - low.min(axis=0)).max()) * _MIN_CELL, 1e-300)
    level = np.ceil(np.log2(np.maximum((high - low).max(axis=1), least))).astype(np.int64)
    batches, total = [np.zeros((0, 2), np.int64)], 0
    for height in np.unique(level).tolist():
        for pairs in _pairs_at_level(low, high, level, height):
            batches.append(pairs)
            total += len(pairs)
            if total > most:
                break
    pairs = np.sort(np.concatenate(batches), axis=1)
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return pairs[:most], total <= most


def _pairs_at_level(low: FloatArray, high: FloatArray, level: IntArray, height: int) -> Iterator[IntArray]:
    """Yield the overlapping pairs (M, 2) whose larger box is at a level of the hierarchy."""
    rows = np.flatnonzero(level <= height)
    place = np.floor((low[rows] - low[rows].min(axis=0)) / 2.0**height).astype(np.int64) + 1
    span = place.max(axis=0) + 2
    key = (place[:, 0] * span[1] + place[:, 1]) * span[2] + place[:, 2]
    order = np.argsort(key, kind="stable")
    key, sorted_rows = key[order], rows[order]
    at_level = np.flatnonzero(level[rows] == height)
    for start in range(0, len(at_level), _BATCH_BOXES):
        batch = at_level[start : start + _BATCH_BOXES]
        for x, y, z in _OFFSETS:
            at = ((place[batch, 0] + x) * span[1] + place[batch, 1] + y) * span[2] + place[batch, 2] + z
            first = np.searchsorted(key, at)
            count = np.searchsorted(key, at, side="right") - first
            me = np.repeat(rows[batch], count)
            other = sorted_rows[np.arange(len(me)) + np.repeat(first - (np.cumsum(count) - count), count)]
            # Boxes of one level are neighbors of each other: only one of the two pairs is taken.
            is_pair = (level[other] < height) | (other > me)
            is_pair &= ((low[me] <= high[other]) & (high[me] >= low[other])).all(axis=1)
            yield np.stack([me[is_pair], other[is_pair]], axis=1)


def boxes(solids: PosedForms) -> tuple[FloatArray, FloatArray]:
    """Return the exact axis-aligned bounding boxes of posed solids: low and high corners, (N, 3) each."""
    low, high = np.empty((len(solids), 3)), np.empty((len(solids), 3))
    for axis in range(3):
        direction = np.zeros((len(solids), 3))
        direction[:, axis] = 1.0
        high[:, axis] = solids.support(direction)[:, axis]
        low[:, axis] = solids.support(-direction)[:, axis]
    return low, high


Mask = npt.NDArray[np.bool_]

_MAX_GJK_STEPS = 60  # pairs that are not finished keep the distance so far, an upper bound
_RELATIVE_GAIN = 1e-7  # of a squared distance: a support point that gains less ends the search
_CONTACT = 1e-9  # relative to the coordinates of a pair: closer solids touch
_BATCH_QUERIES = 100_000  # support points computed at once
_STARTS = 8  # initial directions for minimizing the width
_DIRECTIONS = 48  # candidate directions spread over the sphere
# Descent for the width of curved solids: steps in radians, shortened after each that does not help.
_FIRST_STEP, _STEP_FACTOR, _STEPS = 0.3, 0.6, 40
# Of the edges of a face, scaled so that their squared lengths add up to 1; below it, they are dependent up to rounding.
_MIN_GRAM_DETERMINANT = 1e-14
_WEIGHT_TOLERANCE = 1e-12  # rounding error of barycentric weights
_SUBSETS = tuple(subset for size in (1, 2, 3, 4) for subset in combinations(range(4), size))


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """N pairs of posed solids: the first and the second of each."""

    a: PosedForms
    b: PosedForms

    def __len__(self) -> int:
        return len(self.a)

    def take(self, which: npt.NDArray[np.int64] | Mask) -> Pairs:
        """Return the pairs selected by a mask or by indices."""
        return Pairs(self.a.take(which), self.b.take(which))

    def difference(self, directions: FloatArray) -> FloatArray:
        """Return support points (N, 3) of the Minkowski difference A - B."""
        return self.a.support(directions) - self.b.support(-directions)


def distances(pairs: Pairs) -> FloatArray:
    """Return the distances (N,) between the solids of each pair, by GJK; 0 if they touch or overlap.

    All pairs advance together; finished ones are taken out of the arrays.
    """
    count = len(pairs)
    distance = np.zeros(count)
    # The first direction is along the centers; the offset makes it nonzero where they coincide.
    nearest = pairs.difference(pairs.a.matrices[:, :, 3] - pairs.b.matrices[:, :, 3] + 1e-9)
    points = np.zeros((count, 4, 3))
    points[:, 0] = nearest
    is_corner = np.zeros((count, 4), bool)
    is_corner[:, 0] = True
    rows = np.arange(count)
    size = np.abs(nearest).max(axis=1)
    size = size + np.abs(pairs.a.matrices).max(axis=(1, 2)) + np.abs(pairs.b.matrices).max(axis=(1, 2))
    for _ in range(_MAX_GJK_STEPS):
        if not len(rows):
            break
        square = np.einsum("ni,ni->n", nearest, nearest)
        distance[rows] = np.sqrt(square)
        new = pairs.difference(-nearest)
        gain = square - np.einsum("ni,ni->n", nearest, new)
        touching = square <= (_CONTACT * size) ** 2
        distance[rows[touching]] = 0.0
        unfinished = ~touching & (gain > _RELATIVE_GAIN * square)
        if not unfinished.all():
            rows, pairs, size = rows[unfinished], pairs.take(unfinished), size[unfinished]
            points, is_corner = points[unfinished], is_corner[unfinished]
            new, nearest = new[unfinished], nearest[unfinished]
        if len(rows):
            # A full simplex contains the origin, so its pair is finished: the others have a free slot.
            slot = np.argmin(is_corner, axis=1)
            points[np.arange(len(rows)), slot] = new
            is_corner[np.arange(len(rows)), slot] = True
            nearest, is_corner = _nearest_of_simplex(points, is_corner)
    return distance


def _nearest_of_simplex(points: FloatArray, active: Mask) -> tuple[FloatArray, Mask]:
    """Return the point (N, 3) of each simplex nearest to the origin, and the corners (N, 4) that span its face."""
    count = len(points)
    best = np.full(count, np.inf)
    nearest = np.zeros((count, 3))
    spanning = np.zeros((count, 4), bool)
    for subset in _SUBSETS:
        able = active[:, subset].all(axis=1)
        if not able.any():
            continue
        point, valid = _nearest_of_face(points[:, subset])
        square = np.einsum("ni,ni->n", point, point)
        # Small faces come first, so that of faces that are equally near up to rounding, the smallest one is taken.
        better = able & valid & (square < best * (1.0 - 1e-12))
        if better.any():
            best[better] = square[better]
            nearest[better] = point[better]
            spanning[better] = np.isin(np.arange(4), subset)
    return nearest, spanning


def _nearest_of_face(corners: FloatArray) -> tuple[FloatArray, Mask]:
    """Return the points of N affine hulls that are nearest to the origin, by least squares.

    Parameters
    ----------
    corners : (N, K, 3)
        Corners of each face: 1 (a point) to 4 (a tetrahedron).

    Returns
    -------
    nearest : (N, 3)
        Point of the affine hull of the corners.
    valid : (N,)
        Whether it is in their convex hull; False for corners that are affinely dependent.
    """
    base, edges = corners[:, 0], corners[:, 1:] - corners[:, :1]
    edge_count = edges.shape[1]
    if edge_count == 0:
        return base, np.ones(len(base), bool)
    gram = np.einsum("nki,nli->nkl", edges, edges)
    right_side = -np.einsum("nki,ni->nk", edges, base)
    scale = np.einsum("nkk->n", gram) + 1e-300  # not zero, even if all corners coincide
    is_independent = np.linalg.det(gram / scale[:, None, None]) > _MIN_GRAM_DETERMINANT
    solvable = np.where(is_independent[:, None, None], gram, np.eye(edge_count))
    weights = np.linalg.solve(solvable, right_side[:, :, None])[:, :, 0]  # barycentric, of all corners but the first
    is_inside = (weights >= -_WEIGHT_TOLERANCE).all(axis=1) & (weights.sum(axis=1) <= 1.0 + _WEIGHT_TOLERANCE)
    return base + np.einsum("nk,nki->ni", weights, edges), is_independent & is_inside


# --- penetration depth ---------------------------------------------------------------------------------------------


def depths(pairs: Pairs, enough: float = -np.inf) -> tuple[FloatArray, FloatArray]:
    """Return the penetration depths of overlapping pairs, and the directions of the shortest separating translations.

    Parameters
    ----------
    pairs
        The N pairs of convex solids.
    enough
        Depth up to which the caller needs no exact value: smaller ones are not refined, and are upper bounds.

    Returns
    -------
    depth : (N,)
        Length of the translation; a negative one is a gap, so that the pair does not overlap.
    direction : (N, 3)
        Unit vector along which the second solid of a pair is moved.
    """
    directions = np.stack(_candidates(pairs))  # (C, N, 3)
    widths = _widths(pairs, directions)
    order = np.argsort(widths, axis=0)[:_STARTS]
    every = np.arange(len(pairs))
    along = directions[order[0], every]
    depth = widths[order[0], every]
    curved = np.flatnonzero((pairs.a.that_are("is_curved") | pairs.b.that_are("is_curved")) & (depth > enough))
    batch = len(order) if len(curved) * len(order) <= _BATCH_QUERIES else 1  # few pairs: all starts at once
    for first in range(0, len(order), batch) if len(curved) else ():
        starts = order[first : first + batch, curved]
        rows = np.tile(np.arange(len(curved)), len(starts))
        deep, direction = _refined(pairs.take(curved[rows]), directions[starts.ravel(), curved[rows]])
        best = np.argmin(deep.reshape(starts.shape), axis=0) * len(curved) + np.arange(len(curved))
        smaller = deep[best] < depth[curved]
        depth[curved] = np.where(smaller, deep[best], depth[curved])
        along[curved] = np.where(smaller[:, None], direction[best], along[curved])
    return depth, along


def _widths(pairs: Pairs, directions: FloatArray) -> FloatArray:
    """Return ``_width`` (C, N) for directions (C, N, 3), at once if there are few pairs."""
    count, size = directions.shape[:2]
    if count * size > _BATCH_QUERIES:
        return np.stack([_width(pairs, direction) for direction in directions])
    every = np.tile(np.arange(size), count)
    return _width(pairs.take(every), directions.reshape(-1, 3)).reshape(count, size)


def _width(pairs: Pairs, directions: FloatArray) -> FloatArray:
    """Return the translations (N,) along unit vectors that separate the second solids from the first.

    They are infinite for zero vectors, which come from parallel edges.
    """
    width: FloatArray = np.einsum("ni,ni->n", pairs.difference(directions), directions)
    return np.where(np.einsum("ni,ni->n", directions, directions) > 0.5, width, np.inf)


def _candidates(pairs: Pairs) -> Sequence[FloatArray]:
    """Return candidate separating directions, each an array of unit vectors (N, 3).

    These are face normals, cross products of edges, the line between the centers, and directions all around.
    """
    normals_a, normals_b = _normals(pairs.a.matrices), _normals(pairs.b.matrices)
    directions = [normal for normals in (normals_a, normals_b) for normal in normals]
    directions += [np.cross(p, q) for p in _edges(pairs.a.matrices) for q in _edges(pairs.b.matrices)]
    directions.append(pairs.b.matrices[:, :, 3] - pairs.a.matrices[:, :, 3])
    directions += [np.broadcast_to(direction, (len(pairs), 3)) for direction in _sphere(_DIRECTIONS)]
    units = [_normalized(direction) for direction in directions]
    return [sign * unit for unit in units for sign in (1.0, -1.0)]


def _normals(matrices: FloatArray) -> list[FloatArray]:
    """Return the normals of the faces x = 1, y = 1 and z = 1 of posed canonical solids."""
    cofactors = cofactors_of(matrices[:, :, :3])
    return [cofactors[:, :, axis] for axis in range(3)]


def _edges(matrices: FloatArray) -> list[FloatArray]:
    """Return the directions (N, 3) of the three edges of posed unit boxes."""
    return [matrices[:, :, axis] for axis in range(3)]


def _normalized(vectors: FloatArray) -> FloatArray:
    """Return unit vectors; zero vectors for zero length."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 1e-12, vectors / np.where(length > 1e-12, length, 1.0), 0.0)


def _sphere(count: int) -> FloatArray:
    """Return directions spread evenly over the sphere (Fibonacci lattice)."""
    i = np.arange(count) + 0.5
    height, angle = 1.0 - 2.0 * i / count, np.pi * (3.0 - np.sqrt(5.0)) * i
    radius = np.sqrt(1.0 - height * height)
    return np.stack([radius * np.cos(angle), height, radius * np.sin(angle)], axis=1)


def _refined(pairs: Pairs, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Minimize the width locally, by gradient descent on the sphere of directions starting from ``along``."""
    depth, step = _width(pairs, along), np.full(len(pairs), _FIRST_STEP)
    for _ in range(_STEPS):
        point = pairs.difference(along)
        slope = point - np.einsum("ni,ni->n", point, along)[:, None] * along
        trial = _normalized(along - step[:, None] * _normalized(slope))
        width = _width(pairs, trial)
        better = width < depth
        depth, along = np.where(better, width, depth), np.where(better[:, None], trial, along)
        step = np.where(better, step, step * _STEP_FACTOR)
    return depth, along
