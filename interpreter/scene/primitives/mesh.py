"""Triangle meshes, and geometric queries on closed meshes: rays, samples, containment, volume, area.

These are the fallbacks of primitives without a closed form.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]
    IntArray = npt.NDArray[np.int64]
    BoolArray = npt.NDArray[np.bool_]

_BATCH_PAIRS = 1 << 20  # ray-triangle pairs per batch
_EDGE_TOLERANCE = 1e-12  # of barycentric coordinates, so that no ray passes between adjacent triangles
_RAY_DIRECTION = (0.5390, 0.6471, 0.5393)  # direction of containment rays; unlikely to be parallel to an edge


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Triangle mesh.

    Attributes
    ----------
    vertices : (V, 3)
        Positions.
    normals : (V, 3) or None
        Outward unit normals; None if all faces are flat.
    faces : (F, 3)
        Vertex indices, counter-clockwise seen from outside.
    colors : (F, 3) or None
        Linear sRGB, if the faces have their own colors.
    part : (F,) or None
        For each face, the index in ``part_words`` of the word of its part; None if there is one part.
    joints : (F, 3) or None
        For each corner, the number of its point in the closed surface: vertices that differ in normals only share it.
        None if vertices at the same place are the same point.
    uv : (F, 3, 2) or None
        Texture coordinates of the corners, u to the right and v upwards; nan where there are none.
    image : (F,) or None
        For each face, the index in ``images`` of its color image, -1 without one.
    images
        Linear sRGB images (H, W, 3), which ``tint`` (F, 3) multiplies.
    """

    vertices: FloatArray
    normals: FloatArray | None
    faces: IntArray
    colors: FloatArray | None = None
    part: IntArray | None = None
    part_words: tuple[str, ...] = ()
    joints: IntArray | None = None
    uv: FloatArray | None = None
    image: IntArray | None = None
    images: tuple[npt.NDArray[np.float32], ...] = ()
    tint: FloatArray | None = None

    @property
    def corners(self) -> FloatArray:
        """Corners of the triangles (F, 3, 3)."""
        corners: FloatArray = np.asarray(self.vertices[self.faces], np.float64)
        return corners

    @property
    def shading(self) -> FloatArray:
        """Normals of a mesh that has them."""
        assert self.normals is not None, "call `faceted` on a mesh of flat faces before using its normals"
        return self.normals

    def faceted(self) -> Mesh:
        """Return the mesh with normals; a mesh without normals gets three separate vertices per triangle."""
        if self.normals is not None:
            return self
        corners = self.corners
        normals = np.repeat(triangle_normals(corners), 3, axis=0)
        return Mesh(corners.reshape(-1, 3), normals, np.arange(3 * len(corners)).reshape(-1, 3), self.colors)


def flat_mesh(vertices: Any, faces: Any) -> Mesh:
    """Return a mesh of flat faces from ``vertices`` (V, 3) and ``faces`` (F, 3), which may be nested sequences."""
    return Mesh(np.asarray(vertices, np.float64), None, np.asarray(faces, np.int64))


def empty() -> Mesh:
    """Return the empty mesh."""
    return Mesh(np.zeros((0, 3)), None, np.zeros((0, 3), np.int64))


def joined(*meshes: Mesh) -> Mesh:
    """Concatenate meshes, all of which must have normals and no colors."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.shading for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]),
    )


def posed(mesh: Mesh, matrices: FloatArray) -> Mesh:
    """Return one copy of ``mesh``, which must have normals, for each of the invertible poses (K, 3, 4).

    The faces of mirrored copies are reversed, so that they stay counter-clockwise seen from outside.
    """
    count, size = len(matrices), len(mesh.vertices)
    vertices, normals, mirrored = posed_points(mesh.vertices, mesh.shading, matrices)
    starts = (np.arange(count) * size)[:, None, None]
    faces = np.where(mirrored[:, None, None], mesh.faces[:, ::-1], mesh.faces) + starts
    colors = None if mesh.colors is None else np.tile(mesh.colors, (count, 1))
    return Mesh(vertices.reshape(-1, 3), normals.reshape(-1, 3), faces.reshape(-1, 3), colors)


def posed_points(
    vertices: FloatArray, normals: FloatArray, matrices: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return positions and unit normals (K, V, 3) under each of the poses (K, 3, 4), and which poses mirror (K,).

    Normals without a direction, such as those under a singular pose, are not of unit length.
    """
    linear = matrices[:, :, :3]
    points = vertices @ np.swapaxes(linear, 1, 2) + matrices[:, None, :, 3]
    cofactors = cofactors_of(linear)  # normals transform with the inverse transpose, up to a factor
    mirrored = np.einsum("ni,ni->n", linear[:, :, 0], cofactors[:, :, 0]) < 0.0
    directions = normals @ np.swapaxes(cofactors, 1, 2)
    directions *= np.where(mirrored, -1.0, 1.0)[:, None, None]
    length = np.sqrt(np.einsum("nvi,nvi->nv", directions, directions))
    directions /= np.where(length > 0.0, length, 1.0)[:, :, None]
    return points, directions, mirrored


_CYCLIC = [0, 1, 2, 0, 1]  # rows and columns, so that slices of three are cyclic permutations


def cofactors_of(linear: FloatArray) -> FloatArray:
    """Return the cofactor matrices of (N, 3, 3), ``det(A) inv(A).T``.

    Their columns are cross products of columns of A.
    """
    m = linear[:, _CYCLIC][:, :, _CYCLIC]
    cofactors: FloatArray = m[:, 1:4, 1:4] * m[:, 2:5, 2:5] - m[:, 2:5, 1:4] * m[:, 1:4, 2:5]
    return cofactors


def inverses_of(linear: FloatArray) -> FloatArray:
    """Return the inverses of invertible matrices (N, 3, 3)."""
    cofactors = cofactors_of(linear)
    determinant = np.einsum("ni,ni->n", linear[:, :, 0], cofactors[:, :, 0])
    inverses: FloatArray = np.swapaxes(cofactors, 1, 2) / determinant[:, None, None]
    return inverses


def triangle_normals(corners: FloatArray) -> FloatArray:
    """Return the unit normals (F, 3) of triangles (F, 3, 3), counter-clockwise seen from outside.

    The normals of degenerate triangles are zero.
    """
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit: FloatArray = normals / np.where(length > 0.0, length, 1.0)
    return unit


# --- smooth surfaces -------------------------------------------------------------------------------------------------


def smoothed(
    vertices: FloatArray, faces: IntArray, surface: IntArray, degrees: float
) -> tuple[FloatArray, IntArray, IntArray]:
    """Compute normals of a closed mesh that are smooth within a surface and split at sharp edges.

    Corners at a vertex share a normal if a path of faces joins them, all of one ``surface`` (F,), that turns by at most
    ``degrees`` at each edge. A normal is the mean of its faces' normals, weighted by their angles and areas, so that
    large flat faces stay flat next to narrow round ones, such as fillets.

    Parameters
    ----------
    vertices : (V, 3)
        Positions.
    faces : (F, 3)
        Vertex indices.
    surface : (F,)
        Number of the surface of each face; normals are never shared across surfaces.
    degrees
        Largest angle between adjacent faces that share normals.

    Returns
    -------
    normals : (N, 3)
        Unit normals.
    corners : (F, 3)
        Index of the normal of each corner.
    vertex : (N,)
        Index of the vertex of each normal.
    """
    corners = vertices[faces]
    flat = triangle_normals(corners)
    label = _joined_corners(len(vertices), faces, _smooth_edges(len(vertices), faces, surface, flat, degrees))
    representatives, group = np.unique(label, return_inverse=True)
    group = group.reshape(-1)
    weights = (_corner_angles(corners) * areas_of(corners)[:, None]).reshape(-1)
    weighted = np.repeat(flat, 3, axis=0) * weights[:, None]
    normals = np.stack([np.bincount(group, weighted[:, k], len(representatives)) for k in range(3)], axis=1)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    fallback = np.repeat(flat, 3, axis=0)[representatives]  # where the normals of all faces cancel
    unit: FloatArray = np.where(length > 1e-300, normals / np.where(length > 0.0, length, 1.0), fallback)
    return unit, group.reshape(-1, 3).astype(np.int64), faces.reshape(-1)[representatives]


def _smooth_edges(
    count: int, faces: IntArray, surface: IntArray, normals: FloatArray, degrees: float
) -> tuple[IntArray, IntArray]:
    """Return pairs of corners (K,) that share a normal: the first of an edge in one face, the last in the other.

    Edges are numbered by their vertices; the neighbor across an edge has it in the opposite direction.
    """
    first, last = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    key, reverse = first * count + last, last * count + first
    order = np.argsort(key, kind="stable")
    place = np.minimum(np.searchsorted(key[order], reverse), len(key) - 1)
    other = order[place]
    face, across = np.arange(len(key)) // 3, other // 3
    smooth = (key[other] == reverse) & (surface[face] == surface[across])
    smooth &= np.einsum("ni,ni->n", normals[face], normals[across]) >= math.cos(math.radians(degrees)) - 1e-12
    chosen = np.flatnonzero(smooth)
    return chosen, 3 * across[chosen] + (other[chosen] + 1) % 3  # the end of the reversed edge


def _joined_corners(count: int, faces: IntArray, pairs: tuple[IntArray, IntArray]) -> IntArray:
    """Return for each corner (3 F,) the smallest one that it is connected to by pairs of corners.

    Connected components by propagation of minima with pointer jumping, over all pairs at once.
    """
    label = np.arange(3 * len(faces))
    while True:
        low = np.minimum(label[pairs[0]], label[pairs[1]])
        new = label.copy()
        for side in pairs:
            np.minimum.at(new, label[side], low)
            np.minimum.at(new, side, low)
        new = new[new]
        if np.array_equal(new, label):
            return label
        label = new


def _corner_angles(corners: FloatArray) -> FloatArray:
    """Return the angles (F, 3) of triangles at their corners, in radians."""
    ahead = np.roll(corners, -1, axis=1) - corners
    back = np.roll(corners, 1, axis=1) - corners
    across = np.linalg.norm(np.cross(ahead, back), axis=2)
    angles: FloatArray = np.arctan2(across, np.einsum("fki,fki->fk", ahead, back))
    return angles


# --- measures and samples --------------------------------------------------------------------------------------------


def areas_of(corners: FloatArray) -> FloatArray:
    """Return the areas (F,) of triangles (F, 3, 3)."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas: FloatArray = np.linalg.norm(across, axis=1) / 2.0
    return areas


def volume_of(corners: FloatArray) -> float:
    """Return the volume enclosed by the closed surface of triangles (F, 3, 3), by the divergence theorem."""
    if not len(corners):
        return 0.0
    a, b, c = (corners[:, k] - corners[0, 0] for k in range(3))  # relative to a point of the surface, for precision
    return float(np.einsum("ni,ni->n", a, np.cross(b, c)).sum() / 6.0)


def sample_surface(mesh: Mesh, count: int, rng: Any) -> tuple[FloatArray, FloatArray]:
    """Sample ``count`` points uniformly from the surface.

    Returns the points and the normals of their triangles, (K, 3) each, empty if the mesh has no area. ``rng`` is a
    ``numpy.random.Generator``.
    """
    corners = mesh.corners
    cumulative = np.cumsum(areas_of(corners))
    if not len(cumulative) or not 0.0 < cumulative[-1] < np.inf:
        return np.zeros((0, 3)), np.zeros((0, 3))
    which = np.searchsorted(cumulative, rng.random(count) * cumulative[-1], side="right").clip(max=len(cumulative) - 1)
    u, v = rng.random(count), rng.random(count)
    over = u + v > 1.0  # reflect the upper half of the unit square into the triangle
    u, v = np.where(over, 1.0 - u, u)[:, None], np.where(over, 1.0 - v, v)[:, None]
    a, b, c = (corners[which, k] for k in range(3))
    return a + u * (b - a) + v * (c - a), triangle_normals(corners)[which]


# --- ray intersection ------------------------------------------------------------------------------------------------


def first_hits(corners: FloatArray, origins: FloatArray, directions: FloatArray) -> tuple[FloatArray, IntArray]:
    """Intersect rays with triangles.

    Parameters
    ----------
    corners : (F, 3, 3)
        Corners of the triangles.
    origins, directions : (N, 3)
        Rays; the directions need not be normalized.

    Returns
    -------
    t : (N,)
        Smallest positive ray parameter, infinity for a miss.
    triangle : (N,)
        Index of the triangle, -1 for a miss.
    """
    t, which = np.full(len(origins), np.inf), np.full(len(origins), -1, np.int64)
    for rays, parameters, _ in _intersections(corners, origins, directions):
        best = np.argmin(parameters, axis=1)
        t[rays] = parameters[np.arange(len(rays)), best]
        which[rays] = np.where(np.isfinite(t[rays]), best, -1)
    return t, which


def encloses(corners: FloatArray, points: FloatArray) -> BoolArray:
    """Return whether points (N, 3) lie inside the closed surface of triangles (F, 3, 3).

    A ray from an inside point leaves the surface once more often than it enters it.
    """
    inside = np.zeros(len(points), np.bool_)
    directions = np.broadcast_to(np.array(_RAY_DIRECTION), points.shape)
    for rays, parameters, leaves in _intersections(corners, points, directions):
        inside[rays] = np.where(np.isfinite(parameters), np.where(leaves, 1, -1), 0).sum(axis=1) > 0
    return inside


def _intersections(
    corners: FloatArray, origins: FloatArray, directions: FloatArray
) -> Iterator[tuple[IntArray, FloatArray, BoolArray]]:
    """Intersect batches of rays with triangles (Möller and Trumbore 1997), skipping rays that miss the bounding box.

    Yields
    ------
    rays : (K,)
        Indices of the rays.
    t : (K, F)
        Ray parameters, infinity for a miss.
    leaves : (K, F)
        Whether the ray leaves the surface through the triangle.
    """
    if not len(corners):
        return
    with np.errstate(all="ignore"):
        near = np.flatnonzero(_intersects_box(corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), origins, directions))
        a, edge, other = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        batch = max(1, _BATCH_PAIRS // len(corners))
        for start in range(0, len(near), batch):
            rays = near[start : start + batch]
            d, s = directions[rays, None], origins[rays, None] - a  # names of the paper
            p, q = np.cross(d, other), np.cross(s, edge)
            det = np.einsum("kfi,fi->kf", p, edge)
            u = np.einsum("kfi,kfi->kf", s, p) / det
            v = np.einsum("kfi,kfi->kf", np.broadcast_to(d, q.shape), q) / det
            t = np.einsum("kfi,fi->kf", q, other) / det
            hits = (u >= -_EDGE_TOLERANCE) & (v >= -_EDGE_TOLERANCE) & (u + v <= 1.0 + _EDGE_TOLERANCE) & (t > 0.0)
            yield rays, np.where(hits, t, np.inf), det < 0.0


def _intersects_box(low: FloatArray, high: FloatArray, origins: FloatArray, directions: FloatArray) -> BoolArray:
    """Return whether rays (N, 3) intersect a slightly enlarged box (slab method)."""
    margin = 1e-9 * (high - low).max()  # so that rounding errors exclude no ray that meets the box
    safe = np.where(np.abs(directions) < 1e-200, 1e-200, directions)  # divisors that are not zero
    first, second = (low - margin - origins) / safe, (high + margin - origins) / safe
    enter, leave = np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)
    meets: BoolArray = (enter <= leave) & (leave >= 0.0)
    return meets
