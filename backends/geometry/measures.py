"""Measures of single objects for declarations: tilt, outline, block types, lines of sight and free ways on the ground.

Each takes an object of an ``Arrangement``; ``relations`` compares the result with what a declaration states.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from itertools import product

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.arrangement import Arrangement, PlacedObject
from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.flatten import flatten_entity

_DISTINCT = 0.02  # of the largest moment: principal axes whose moments differ by less span a plane of axes
_SEEN_POINTS = 96  # points of an object's surface that are looked at; the share is known to a tenth
_TRIANGLES_AT_A_TIME = 20_000  # of what may hide them: tables of two million entries
_NEAR_END = 1e-6  # of the line of sight: what is hit there is the point itself

# A person who walks: the height that must be free, the height that is stepped over, and the reach of an arm, in metres.
_PERSON_HEIGHT, _STEP_HEIGHT, _ARM_REACH = 1.7, 0.25, 0.7
FREE_RADIUS = 0.25  # half the width of a way that a person walks on, in metres: 0.5 m is a narrow passage
_CELL = 0.05  # of the plan, in metres; larger where the plan would have more cells than the following per side
_MAX_CELLS = 400

# Filled share of the least rectangle around an outline: pi / 4 for a circle and an ellipse, 0.83 for an octagon, 0.75
# for a hexagon, up to 0.9 for a stadium twice as long as wide, 0.95 for a rectangle with well-rounded corners.
_ROUND_FILLS, _OVAL_FILLS, _LEAST_RECTANGLE = (0.76, 0.835), (0.76, 0.93), 0.945
_LEAST_EQUAL_SIDES = 0.93  # shorter side to the longer one of what is called round or square
_MAX_OVAL_SIDES = 0.97


def tilt(arrangement: Arrangement, placed: PlacedObject) -> float:
    """Return the angle in degrees by which an object is tilted: the median of its parts, weighted by their surface.

    A part is tilted by the angle between the vertical and the nearest of its principal axes, or of a plane of these
    where the moments are equal; a ball has none and does not count. So the parts of an upright chair, of which
    no common principal axis is vertical, count as upright.
    """
    angles, weights = [], []
    for body in range(placed.first, placed.last):
        vertices, faces = arrangement.triangles(body)
        covariance, area = _moments(vertices, faces)
        angle = _off_vertical(covariance)
        if angle is not None:
            angles.append(angle)
            weights.append(area)
    if not angles:
        vertical = max(abs(float(arrangement.axis(placed, axis)[1])) for axis in "xyz")
        return math.degrees(math.acos(min(1.0, vertical)))
    order = np.argsort(angles)
    total = np.cumsum(np.array(weights)[order])
    return float(np.array(angles)[order][int(np.searchsorted(total, 0.5 * total[-1]))])


def _moments(vertices: FloatArray, faces: npt.NDArray[np.int64]) -> tuple[FloatArray, float]:
    """Return the covariance (3, 3) of a surface about its center, and its area."""
    corners = vertices[faces]
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    total = float(areas.sum())
    if total <= 0.0:
        return np.zeros((3, 3)), 0.0
    corners = corners - (areas @ corners.mean(axis=1)) / total
    sums = corners.sum(axis=1)
    # The second moments of a triangle (a, b, c): area / 12 (a a' + b b' + c c' + (a + b + c)(a + b + c)').
    second = np.einsum("n,nki,nkj->ij", areas, corners, corners) + np.einsum("n,ni,nj->ij", areas, sums, sums)
    return np.asarray(second / (12.0 * total), np.float64), total


def _off_vertical(covariance: FloatArray) -> float | None:
    """Return the angle in degrees between the vertical and the nearest space of principal axes; None for a ball."""
    values, vectors = np.linalg.eigh(covariance)
    if values[2] <= 0.0 or values[2] - values[0] <= _DISTINCT * values[2]:
        return None
    upward = np.abs(vectors[1])  # cosines between the axes and the vertical
    spaces: list[list[int]] = [[0]]
    for axis in (1, 2):
        if values[axis] - values[axis - 1] <= _DISTINCT * values[2]:
            spaces[-1].append(axis)
        else:
            spaces.append([axis])
    nearest = max(math.hypot(*upward[space].tolist()) for space in spaces)
    return math.degrees(math.acos(min(1.0, nearest)))


def outlines(arrangement: Arrangement, placed: PlacedObject, axis: str) -> frozenset[str]:
    """Return the names of the outline of an object, seen along an axis of the scene: a square is rectangular too."""
    import manifold3d

    kept = [number for number in range(3) if number != "xyz".index(axis)]
    points = np.concatenate([vertices for vertices, _ in _surfaces(arrangement, placed)])[:, kept]
    section = manifold3d.CrossSection.hull_points(points)
    hull = np.concatenate([np.asarray(ring) for ring in section.to_polygons()] or [np.zeros((0, 2))])
    if len(hull) < 3:
        return frozenset()
    short, long = _least_rectangle(hull)
    fill, sides = section.area() / max(short * long, 1e-300), short / max(long, 1e-300)
    names = []
    if _ROUND_FILLS[0] <= fill <= _ROUND_FILLS[1] and sides >= _LEAST_EQUAL_SIDES:
        names.append("round")
    if _OVAL_FILLS[0] <= fill <= _OVAL_FILLS[1] and sides <= _MAX_OVAL_SIDES:
        names.append("oval")
    if fill >= _LEAST_RECTANGLE:
        names += ["rectangular", *(["square"] if sides >= _LEAST_EQUAL_SIDES else [])]
    return frozenset(names)


def _least_rectangle(hull: FloatArray) -> tuple[float, float]:
    """Return the sides of the least rectangle around a convex polygon (N, 2), the shorter one first.

    One of its sides lies on an edge of the polygon (Freeman and Shapira, 1975).
    """
    edges = np.roll(hull, -1, axis=0) - hull
    lengths = np.linalg.norm(edges, axis=1)
    along = edges[lengths > 0.0] / lengths[lengths > 0.0, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    widths, heights = np.ptp(hull @ along.T, axis=0), np.ptp(hull @ across.T, axis=0)
    best = int(np.argmin(widths * heights))
    short, long = sorted((float(widths[best]), float(heights[best])))
    return short, long


def block_types(entity: Entity) -> dict[str, float]:
    """Return the volumes of the Minecraft blocks that an object places, by their types without namespace."""
    flat = flatten_entity(entity)
    scales = np.bincount(flat.index, np.abs(np.linalg.det(flat.matrices[:, :3, :3])), len(flat.primitives))
    volumes: dict[str, float] = {}
    for part, scale in zip(flat.primitives, scales.tolist()):
        size, name = getattr(part.shape, "size", None), part.embedding.attributes.get("block-type")
        if size is not None and isinstance(name, str) and not getattr(part.shape, "removes_blocks", False):
            plain = name.removeprefix("minecraft:")
            volumes[plain] = volumes.get(plain, 0.0) + scale * math.prod(float(x) for x in size)
    return volumes


# --- lines of sight --------------------------------------------------------------------------------------------------


def visible_share(arrangement: Arrangement, seen: PlacedObject, eye: PlacedObject) -> float:
    """Return the share of points of an object's surface that nothing else hides from the top of another.

    The eyes of people are near their tops; the center of a chair would see the edge of the table. Neither object hides
    points: the share of a lone object is 1.
    """
    under, over = arrangement.box(eye)
    origin = np.array([(under[0] + over[0]) / 2.0, over[1], (under[2] + over[2]) / 2.0])
    points = _sampled(arrangement, seen)
    low, high = arrangement.bodies.boxes
    near, far = np.minimum(points.min(axis=0), origin), np.maximum(points.max(axis=0), origin)
    between = ((low <= far) & (high >= near)).all(axis=1) & arrangement.bodies.opaque
    for placed in (seen, eye):
        between[placed.first : placed.last] = False
    hidden = np.zeros(len(points), bool)
    for body in np.flatnonzero(between).tolist():
        vertices, faces = arrangement.triangles(body)
        for start in range(0, len(faces), _TRIANGLES_AT_A_TIME):
            hidden |= _are_hit(origin, points, vertices[faces[start : start + _TRIANGLES_AT_A_TIME]])
    return 1.0 - float(hidden.mean())


def _surfaces(arrangement: Arrangement, placed: PlacedObject) -> list[tuple[FloatArray, npt.NDArray[np.int64]]]:
    """Return vertices and faces of the bodies of an object; raises SceneError if it has no surface."""
    triangles = [arrangement.triangles(body) for body in range(placed.first, placed.last)]
    if not any(len(faces) for _, faces in triangles):
        raise SceneError("declaration-subject", f'"{placed.entity.word}" has no surface that can be seen')
    return triangles


def _sampled(arrangement: Arrangement, placed: PlacedObject) -> FloatArray:
    """Return points (K, 3) of an object's surface: the centers of triangles, spread evenly by area."""
    corners = np.concatenate([vertices[faces] for vertices, faces in _surfaces(arrangement, placed)])
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    total = np.cumsum(areas)
    places = (np.arange(_SEEN_POINTS) + 0.5) / _SEEN_POINTS * total[-1]
    chosen = np.minimum(np.searchsorted(total, places), len(corners) - 1)
    # Points of one large triangle are spread over it by a low-discrepancy sequence (the R2 sequence of Roberts, 2018).
    u = (0.7548776662466927 * np.arange(_SEEN_POINTS)) % 1.0
    v = (0.5698402909980532 * np.arange(_SEEN_POINTS)) % 1.0
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    a, b, c = (corners[chosen, k] for k in range(3))
    return np.asarray(a + u[:, None] * (b - a) + v[:, None] * (c - a), np.float64)


def _are_hit(origin: FloatArray, points: FloatArray, corners: FloatArray) -> npt.NDArray[np.bool_]:
    """Return whether triangles (M, 3, 3) hide points (K, 3) from an origin (Moeller and Trumbore, 1997)."""
    ways = points - origin
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    crossed = np.cross(ways[:, None], second[None])  # (K, M, 3)
    determinant = np.einsum("kmi,mi->km", crossed, first)
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = origin - corners[:, 0]
        u = np.einsum("kmi,mi->km", crossed, offset) / determinant
        turned = np.cross(offset, first)
        v = np.einsum("ki,mi->km", ways, turned) / determinant
        along = (turned * second).sum(axis=1)[None] / determinant
        inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (along > _NEAR_END) & (along < 1.0 - _NEAR_END)
    return np.asarray(inside.any(axis=1), bool)


# --- ways on the ground ----------------------------------------------------------------------------------------------


class WalkingPlan:
    """Plan of the ground of one frame: where a person whose half width is ``radius`` can stand."""

    def __init__(self, arrangement: Arrangement, radius: float) -> None:
        self._arrangement = arrangement
        low, high = arrangement.bodies.boxes
        margin = 2.0 * (radius + _ARM_REACH)
        self._low = low.min(axis=0)[[0, 2]] - margin
        extent = high.max(axis=0)[[0, 2]] + margin - self._low
        self._cell = max(_CELL, float(extent.max()) / _MAX_CELLS)
        self._counts = np.maximum(np.ceil(extent / self._cell).astype(np.int64), 1)
        self.free = np.ones(tuple(self._counts.tolist()), bool)
        ground = arrangement.ground
        for body in np.flatnonzero((low[:, 1] < ground + _PERSON_HEIGHT) & (high[:, 1] > ground + _STEP_HEIGHT)):
            points = arrangement.triangles(int(body))[0]
            self.free &= ~self._within([points], radius)

    def _within(self, clouds: Sequence[FloatArray], distance: float) -> npt.NDArray[np.bool_]:
        """Return which cells are at most a distance from the outlines of some points (K, 3)."""
        near = np.zeros(self.free.shape, bool)
        for points in clouds:
            hull = _plan_hull(points[:, [0, 2]])
            first = np.clip(np.floor((hull.min(axis=0) - distance - self._low) / self._cell), 0, self._counts)
            last = np.clip(np.ceil((hull.max(axis=0) + distance - self._low) / self._cell), 0, self._counts)
            (i, j), (k, m) = first.astype(int).tolist(), last.astype(int).tolist()
            if k <= i or m <= j:
                continue
            x = self._low[0] + (np.arange(i, k) + 0.5) * self._cell
            z = self._low[1] + (np.arange(j, m) + 0.5) * self._cell
            cells = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1)
            near[i:k, j:m] |= _distance_to(hull, cells) <= distance
        return near

    def around(self, placed: PlacedObject) -> npt.NDArray[np.bool_]:
        """Return the free cells from which a person reaches an object."""
        clouds = [self._arrangement.triangles(body)[0] for body in range(placed.first, placed.last)]
        return np.asarray(self.free & self._within(clouds, _ARM_REACH), bool)

    def reached(self, starts: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return the free cells to which ways from some cells lead."""
        seen = (starts & self.free).copy()
        cells = deque(zip(*(rows.tolist() for rows in np.nonzero(seen))))
        width, depth = seen.shape
        while cells:
            i, j = cells.popleft()
            for k, m in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
                if 0 <= k < width and 0 <= m < depth and self.free[k, m] and not seen[k, m]:
                    seen[k, m] = True
                    cells.append((k, m))
        return seen


def _plan_hull(points: FloatArray) -> FloatArray:
    """Return the convex hull (N, 2) of points of the plan; the corners of their box where they are on a line."""
    import manifold3d

    rings = manifold3d.CrossSection.hull_points(points).to_polygons()
    if rings:
        return np.asarray(rings[0], np.float64)
    low, high = points.min(axis=0), points.max(axis=0)
    return np.array(list(product(*zip(low, high))))[[0, 2, 3, 1]]


def _distance_to(hull: FloatArray, cells: FloatArray) -> FloatArray:
    """Return the distances (..) of points (.., 2) from a convex polygon (N, 2) that runs counterclockwise."""
    least = np.full(cells.shape[:-1], np.inf)
    outside = np.zeros(cells.shape[:-1], bool)
    for start, end in zip(hull, np.roll(hull, -1, axis=0)):
        edge, away = end - start, cells - start
        share = np.clip((away @ edge) / max(float(edge @ edge), 1e-300), 0.0, 1.0)
        least = np.minimum(least, np.linalg.norm(away - share[..., None] * edge, axis=-1))
        outside |= edge[0] * away[..., 1] - edge[1] * away[..., 0] < 0.0
    return np.where(outside, least, 0.0)
