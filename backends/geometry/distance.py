"""Distance and depth of penetration of pairs of convex solids, many pairs at a time. What is not convex, such as a
ring, counts as its convex hull.

Distance is that of Gilbert, Johnson and Keerthi: the point nearest to the origin of the difference A - B, approached by
simplices of support points. Depth is the least move that parts two solids: the smallest width of the difference over
all directions, which for two blocks is exact by their separating axes and else refined from many directions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.solids import FloatArray, PosedForms
from scenelang.interpreter.scene.primitives.mesh import cofactors_of

# Pairs of boxes that overlap, found by sweeping along one axis.


IntArray = npt.NDArray[np.int64]


def neighbours(low: FloatArray, high: FloatArray, margin: float, most: int) -> tuple[IntArray, bool]:
    """Numbers (M, 2) of the boxes that come within ``margin`` of one another, the smaller number first, and whether
    these are all: there are at most ``most``."""
    low, high = low - margin / 2.0, high + margin / 2.0
    axis = int(np.argmax(np.var(low + high, axis=0))) if len(low) else 0
    order = np.argsort(low[:, axis], kind="stable")
    starts, ends = low[order], high[order]
    last = np.searchsorted(starts[:, axis], ends[:, axis], side="right")
    found: list[IntArray] = []
    total = 0
    for i in range(len(order)):
        others = np.arange(i + 1, last[i])
        if len(others):
            near = ((starts[others] <= ends[i]) & (ends[others] >= starts[i])).all(axis=1)
            chosen = order[others[near]]
            found.append(np.stack([np.full(len(chosen), order[i]), chosen], axis=1))
            total += len(chosen)
            if total > most:
                break
    pairs = np.concatenate(found) if found else np.zeros((0, 2), np.int64)
    return np.sort(pairs, axis=1)[:most], total <= most


def boxes(solids: PosedForms) -> tuple[FloatArray, FloatArray]:
    """The exact axis-aligned boxes of posed solids: least and greatest corners, (N, 3) each."""
    low, high = np.empty((len(solids), 3)), np.empty((len(solids), 3))
    for axis in range(3):
        direction = np.zeros((len(solids), 3))
        direction[:, axis] = 1.0
        high[:, axis] = solids.support(direction)[:, axis]
        low[:, axis] = solids.support(-direction)[:, axis]
    return low, high


Mask = npt.NDArray[np.bool_]

_ROUNDS = 60
_RELATIVE = 1e-7
_STARTS = 8  # directions from which the least width is looked for
_SUBSETS = tuple(subset for size in (1, 2, 3, 4) for subset in combinations(range(4), size))


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """N pairs of posed solids: the first and the second of each."""

    a: PosedForms
    b: PosedForms

    def __len__(self) -> int:
        return len(self.a)

    def take(self, which: npt.NDArray[np.int64] | Mask) -> Pairs:
        return Pairs(self.a.take(which), self.b.take(which))

    def difference(self, directions: FloatArray) -> FloatArray:
        """Support points (N, 3) of A - B."""
        return self.a.support(directions) - self.b.support(-directions)


def distances(pairs: Pairs) -> FloatArray:
    """The distances (N,) between the solids of each pair; 0 where they touch or overlap."""
    count = len(pairs)
    found = np.zeros(count)
    nearest = pairs.difference(pairs.a.matrices[:, :, 3] - pairs.b.matrices[:, :, 3] + 1e-9)
    points = np.zeros((count, 4, 3))
    points[:, 0] = nearest
    active = np.zeros((count, 4), bool)
    active[:, 0] = True
    rows = np.arange(count)
    size = np.abs(nearest).max(axis=1)
    size = size + np.abs(pairs.a.matrices).max(axis=(1, 2)) + np.abs(pairs.b.matrices).max(axis=(1, 2))
    for _ in range(_ROUNDS):
        if not len(rows):
            break
        square = np.einsum("ni,ni->n", nearest, nearest)
        found[rows] = np.sqrt(square)
        new = pairs.difference(-nearest)
        gain = square - np.einsum("ni,ni->n", nearest, new)
        touching = square <= (1e-9 * size) ** 2
        found[rows[touching]] = 0.0
        going = ~touching & (gain > _RELATIVE * square)
        if not going.all():
            rows, pairs, size = rows[going], pairs.take(going), size[going]
            points, active, new, nearest = points[going], active[going], new[going], nearest[going]
        if len(rows):
            slot = np.argmin(active, axis=1)  # a full simplex holds the origin, so there is a free one
            points[np.arange(len(rows)), slot] = new
            active[np.arange(len(rows)), slot] = True
            nearest, active = _nearest_of_simplex(points, active)
    return found


def _nearest_of_simplex(points: FloatArray, active: Mask) -> tuple[FloatArray, Mask]:
    """The point of each simplex that is nearest to the origin (N, 3), and the corners that span its face (N, 4)."""
    count = len(points)
    best = np.full(count, np.inf)
    nearest = np.zeros((count, 3))
    kept = np.zeros((count, 4), bool)
    for subset in _SUBSETS:
        able = active[:, subset].all(axis=1)
        if not able.any():
            continue
        found, valid = _nearest_of_face(points[:, subset])
        square = np.einsum("ni,ni->n", found, found)
        better = able & valid & (square < best * (1.0 - 1e-12))
        if better.any():
            best[better] = square[better]
            nearest[better] = found[better]
            kept[better] = np.isin(np.arange(4), subset)
    return nearest, kept


def _nearest_of_face(corners: FloatArray) -> tuple[FloatArray, Mask]:
    """The point nearest to the origin of the affine hull of K corners (N, K, 3), and whether it lies between them."""
    base, edges = corners[:, 0], corners[:, 1:] - corners[:, :1]
    k = edges.shape[1]
    if k == 0:
        return base, np.ones(len(base), bool)
    gram = np.einsum("nki,nli->nkl", edges, edges)
    right = -np.einsum("nki,ni->nk", edges, base)
    scale = np.einsum("nkk->n", gram) + 1e-300
    determinant = np.linalg.det(gram / scale[:, None, None])
    sound = determinant > 1e-14
    solvable = np.where(sound[:, None, None], gram, np.eye(k))
    shares = np.linalg.solve(solvable, right[:, :, None])[:, :, 0]
    valid = sound & (shares >= -1e-12).all(axis=1) & (shares.sum(axis=1) <= 1.0 + 1e-12)
    return base + np.einsum("nk,nki->ni", shares, edges), valid


# --- depth -----------------------------------------------------------------------------------------------------------


def depths(pairs: Pairs) -> tuple[FloatArray, FloatArray]:
    """For pairs that overlap, how far (N,) and along which unit direction (N, 3) the second one must move to touch the
    first one only. A negative depth is a gap along that direction: the pair does not overlap."""
    directions = np.stack(_candidates(pairs))  # (C, N, 3)
    widths = np.stack([_width(pairs, each) for each in directions])
    order = np.argsort(widths, axis=0)[:_STARTS]
    every = np.arange(len(pairs))
    along = directions[order[0], every]
    depth = widths[order[0], every]
    curved = np.flatnonzero(pairs.a.that_are("is_curved") | pairs.b.that_are("is_curved"))
    for start in order if len(curved) else ():
        deep, way = _refined(pairs.take(curved), directions[start[curved], curved])
        smaller = deep < depth[curved]
        depth[curved] = np.where(smaller, deep, depth[curved])
        along[curved] = np.where(smaller[:, None], way, along[curved])
    return depth, along


def _width(pairs: Pairs, directions: FloatArray) -> FloatArray:
    """How far the second solids must move along unit ``directions`` to leave the first ones."""
    width: FloatArray = np.einsum("ni,ni->n", pairs.difference(directions), directions)
    return np.where(np.einsum("ni,ni->n", directions, directions) > 0.5, width, np.inf)


def _candidates(pairs: Pairs) -> Sequence[FloatArray]:
    """Directions to try, each an array of unit vectors (N, 3): the normals of flat faces, products of edges, the line
    between the centres, and directions all round."""
    normals_a, normals_b = _normals(pairs.a.matrices), _normals(pairs.b.matrices)
    found = [normal for normals in (normals_a, normals_b) for normal in normals]
    found += [np.cross(p, q) for p in _edges(pairs.a.matrices) for q in _edges(pairs.b.matrices)]
    found.append(pairs.b.matrices[:, :, 3] - pairs.a.matrices[:, :, 3])
    found += [np.broadcast_to(direction, (len(pairs), 3)) for direction in _sphere(48)]
    units = [_normalized(direction) for direction in found]
    return [sign * unit for unit in units for sign in (1.0, -1.0)]


def _normals(matrices: FloatArray) -> list[FloatArray]:
    """The normals of the faces x = 1, y = 1 and z = 1 of posed canonical solids."""
    cofactors = cofactors_of(matrices[:, :, :3])
    return [cofactors[:, :, axis] for axis in range(3)]


def _edges(matrices: FloatArray) -> list[FloatArray]:
    return [matrices[:, :, axis] for axis in range(3)]


def _normalized(vectors: FloatArray) -> FloatArray:
    """Unit vectors; zero where there is no direction."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 1e-12, vectors / np.where(length > 1e-12, length, 1.0), 0.0)


def _sphere(count: int) -> FloatArray:
    """Directions spread evenly over a sphere (a spiral of the golden angle)."""
    i = np.arange(count) + 0.5
    height, angle = 1.0 - 2.0 * i / count, np.pi * (3.0 - np.sqrt(5.0)) * i
    radius = np.sqrt(1.0 - height * height)
    return np.stack([radius * np.cos(angle), height, radius * np.sin(angle)], axis=1)


def _refined(pairs: Pairs, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Widths near ``along`` that are least, by steps down the width on the sphere of directions."""
    depth, step = _width(pairs, along), np.full(len(pairs), 0.3)
    for _ in range(40):
        point = pairs.difference(along)
        slope = point - np.einsum("ni,ni->n", point, along)[:, None] * along
        trial = _normalized(along - step[:, None] * _normalized(slope))
        width = _width(pairs, trial)
        better = width < depth
        depth, along = np.where(better, width, depth), np.where(better[:, None], trial, along)
        step = np.where(better, step, step * 0.6)
    return depth, along
