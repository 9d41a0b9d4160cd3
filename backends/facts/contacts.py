"""Contacts of solids: gaps, penetration depths, directions of separation, and the region in which two solids meet."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from scenelang.backends.facts.tolerances import SLIM, TOUCH_OF_SOLIDS
from scenelang.backends.surfaces.convex import MAX_PAIRS, Bodies, hull_of, plane_axes, signed_area
from scenelang.backends.surfaces.distance import IntArray, neighbors
from scenelang.backends.surfaces.solids import FloatArray
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Ratios

BoolArray = npt.NDArray[np.bool_]

_SIDES = 64  # of round solids whose outermost points are taken
_THICKNESS = 1e-3  # of the contact tolerance, of a region: a thicker one would make a disc of a point
_MAX_POINTS = 8  # of a region: its convex hull is simplified to the extreme points in so many directions


class Contacts:
    """The M touching pairs of N solids; depths are computed for the pairs that are asked about.

    The tolerance of a pair is that of the frame, or less for small solids. Axis-aligned boxes, of which walls of bricks
    are made, are compared by their extents; all others by GJK and separating directions, concave ones by Manifold.

    Attributes
    ----------
    pairs : (M, 2)
        Numbers of the two solids, the smaller first, sorted.
    gaps : (M,)
        Distances in scene units, 0 where they overlap.
    room : (M,)
        Contact tolerance of the pair, in scene units.
    complete
        Whether all pairs were compared.
    """

    def __init__(self, solids: Bodies, before: Contacts | None = None, moved: BoolArray | None = None) -> None:
        """Compare all solids, or only those that ``moved`` (N,) since ``before``."""
        self.solids = solids
        if before is None or moved is None:
            pairs, gaps, self.complete = solids.contacts
        else:
            pairs, gaps, self.complete = _compared_again(solids, before, moved)
        room = rooms_of(solids, pairs)
        near = gaps <= room
        self.pairs, self.gaps, self.room = pairs[near], gaps[near], room[near]
        self._depth, self._along = np.full(len(self.pairs), np.nan), np.zeros((len(self.pairs), 3))
        if before is not None and moved is not None:
            old = {tuple(pair): row for row, pair in enumerate(before.pairs.tolist())}
            for row in np.flatnonzero(~moved[self.pairs].any(axis=1)).tolist():
                same = old[tuple(self.pairs[row].tolist())]
                self._depth[row], self._along[row] = before._depth[same], before._along[same]

    def __len__(self) -> int:
        return len(self.pairs)

    def depths(self, rows: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the penetration depths (K,) of contacts, and the directions (K, 3) in which the second solid leaves.

        The depth is 0 where the solids only touch.
        """
        missing = rows[np.isnan(self._depth[rows])]
        aligned = self.solids.aligned[self.pairs[missing]].all(axis=1)
        for chosen, measure in ((missing[aligned], self._depths_of_boxes), (missing[~aligned], self.solids.overlaps)):
            if len(chosen):
                depth, self._along[chosen] = measure(self.pairs[chosen])
                self._depth[chosen] = np.maximum(depth, 0.0)
        return self._depth[rows], self._along[rows]

    def depth(self, row: int) -> float:
        """Return the penetration depth of a contact."""
        return float(self.depths(np.array([row]))[0][0])

    def along(self, row: int) -> FloatArray:
        """Return the direction (3,) in which the second solid of a contact leaves the first."""
        return np.asarray(self.depths(np.array([row]))[1][0], np.float64)

    def _depths_of_boxes(self, pairs: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return depths (M,) and separating directions (M, 3) of pairs of axis-aligned boxes."""
        low, high = self.solids.boxes
        (a, b), rows = pairs.T, np.arange(len(pairs))
        right, left = high[a] - low[b], high[b] - low[a]  # translations that separate them to either side
        shared = np.minimum(right, left)
        axis = np.argmin(shared, axis=1)
        along = np.zeros((len(pairs), 3))
        along[rows, axis] = np.where(right[rows, axis] <= left[rows, axis], 1.0, -1.0)
        return shared[rows, axis], along


def _compared_again(solids: Bodies, before: Contacts, moved: BoolArray) -> tuple[IntArray, FloatArray, bool]:
    """Return the touching pairs (M, 2), sorted, their distances, and whether all were compared."""
    near, complete = neighbors(*solids.boxes, solids.touch, MAX_PAIRS)
    pairs, gaps = solids.touching(near[moved[near].any(axis=1)])
    same = ~moved[before.pairs].any(axis=1)
    pairs, gaps = np.concatenate([before.pairs[same], pairs]), np.concatenate([before.gaps[same], gaps])
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    return pairs[order], gaps[order], complete


def rooms_of(solids: Bodies, pairs: IntArray) -> FloatArray:
    """Return the contact tolerances (M,) of pairs (M, 2) of solids, in scene units."""
    low, high = solids.boxes
    diagonal = np.linalg.norm(high - low, axis=1)
    return np.asarray(np.minimum(solids.touch, TOUCH_OF_SOLIDS * diagonal[pairs].min(axis=1)), np.float64)


def own_sides(solids: Bodies, rows: IntArray) -> FloatArray:
    """Return the sides (K, 3) of solids along their own axes, ascending; those of a slanted rod are not its box's."""
    return np.sort(2.0 * np.linalg.norm(solids.solids.matrices[rows, :, :3], axis=1), axis=1)


def are_slim(solids: Bodies, rows: IntArray) -> BoolArray:
    """Return which solids (K,) are rods: at least four times as long as broad."""
    sides = own_sides(solids, rows)
    return np.asarray(sides[:, 2] >= SLIM * sides[:, 1], bool)


def axes_of(solids: Bodies, rows: IntArray) -> FloatArray:
    """Return unit vectors (K, 3) along the axes of round solids, across which their sections have two equal sides."""
    matrices = solids.solids.matrices[rows][:, :, :3]
    lengths = np.linalg.norm(matrices, axis=1)
    along = np.argmin(np.abs(np.roll(lengths, -1, axis=1) - np.roll(lengths, -2, axis=1)), axis=1)
    chosen = np.take_along_axis(matrices, along[:, None, None], axis=2)[:, :, 0]
    return np.asarray(chosen / np.linalg.norm(chosen, axis=1, keepdims=True), np.float64)


def region_of(solids: Bodies, contacts: Contacts, row: int) -> FloatArray:
    """Return points (K, 3) whose convex hull is the region in which the solids of a contact meet, K at most 8."""
    i, j = contacts.pairs[row].tolist()
    along, depth, room = contacts.along(row), contacts.depth(row), float(contacts.room[row])
    if solids.aligned[i] and solids.aligned[j]:
        return _common_face(solids, i, j, along)
    thin = _THICKNESS * room  # of the region: a thicker one would be broader than an edge
    push = 0.0  # of what overlaps: it lies in a hollow of its own shape
    if depth <= room:
        push = depth - thin if depth > thin else -float(contacts.gaps[row]) - thin
    points = solids.common_points(i, j, along * push)
    if len(points):
        return extreme_points(points, along)
    if any(not solids.exact[k] and (not solids.hollow[k] or solids.surface(k) is None) for k in (i, j)):
        return _common_face(solids, i, j, along)  # an open mesh counts as its box
    low, high = solids.boxes
    outermost = solids.solids.take(np.array([i, j])).support(np.stack([along, -along]))
    for k, other, direction, point in ((i, j, along, outermost[0]), (j, i, -along, outermost[1])):
        # Of a slanted rod on a floor, its end; of a sheet, the corners that lie on it.
        vertices = np.vstack([point[None], vertices_of(solids, k)])
        vertices = vertices[(vertices - point) @ direction >= -room]
        vertices = vertices[((vertices >= low[other] - room) & (vertices <= high[other] + room)).all(axis=1)]
        if len(vertices):
            return extreme_points(vertices, along)
    return _common_face(solids, i, j, along)


def _common_face(solids: Bodies, i: int, j: int, along: FloatArray) -> FloatArray:
    """Return the corners (4, 3) of the common face of the boxes of two solids."""
    return np.asarray(rectangles_of(solids, np.array([[i, j]]), along[None])[0], np.float64)


def rectangles_of(solids: Bodies, pairs: IntArray, along: FloatArray) -> FloatArray:
    """Return the corners (M, 4, 3) of the common faces of pairs (M, 2) of boxes, perpendicular to normals (M, 3)."""
    (low, high), rows = solids.boxes, np.arange(len(pairs))
    lower, upper = np.maximum(low[pairs[:, 0]], low[pairs[:, 1]]), np.minimum(high[pairs[:, 0]], high[pairs[:, 1]])
    lower, upper = np.minimum(lower, upper), np.maximum(lower, upper)
    corners = np.repeat(((lower + upper) / 2.0)[:, None], 4, axis=1)
    across = np.array([[1, 2], [0, 2], [0, 1]])[np.argmax(np.abs(along), axis=1)]
    for axis, (x, y, z, w) in zip(across.T, ((0, 1, 1, 0), (0, 0, 1, 1))):
        ends = np.stack([lower[rows, axis], upper[rows, axis]])
        for corner, end in enumerate((x, y, z, w)):
            corners[rows, corner, axis] = ends[end]
    return corners


@lru_cache(maxsize=256)
def _vertices(form: CanonicalForm, ratios: Ratios) -> FloatArray:
    """Return the vertices (K, 3) of a primitive in its own frame."""
    return np.asarray(form.mesh(_SIDES, ratios).vertices, np.float64)


def vertices_of(solids: Bodies, i: int) -> FloatArray:
    """Return the vertices (K, 3) of a solid in the world; of a concave one those of its surface."""
    if solids.hollow[i] and (surface := solids.surface(i)) is not None:
        return np.asarray(surface.to_mesh64().vert_properties[:, :3], np.float64)
    form, ratios = solids.solids.form(i)
    matrix = solids.solids.matrices[i]
    return np.asarray(_vertices(form, ratios) @ matrix[:, :3].T + matrix[:, 3], np.float64)


def extreme_points(points: FloatArray, normal: FloatArray) -> FloatArray:
    """Return at most 8 corners of the convex hull of points (K, 3), seen along a normal."""
    angles = np.arange(_MAX_POINTS) * (2.0 * np.pi / _MAX_POINTS) + 0.1
    directions = plane_axes(normal) @ np.stack([np.cos(angles), np.sin(angles)])
    return np.asarray(points[np.unique(np.argmax(points @ directions, axis=0))], np.float64)


def area_of(points: FloatArray, normal: FloatArray) -> float:
    """Return the area of the convex hull of points (K, 3), seen along a normal."""
    return signed_area(hull_of(points @ plane_axes(normal)))
