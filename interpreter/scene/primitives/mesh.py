"""Triangle meshes, and what can be asked of any closed one: rays, samples, inside, volume, area.

These are the fallbacks of every primitive that has no closed form of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenelang.interpreter.scene.primitives.lazy import np

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]
    IntArray = npt.NDArray[np.int64]
    BoolArray = npt.NDArray[np.bool_]

_PAIRS = 1 << 20  # of rays and triangles that are looked at together
_SEAM = 1e-12  # by which triangles overlap, so that no ray passes between neighbours
_ASKEW = (0.5390, 0.6471, 0.5393)  # no edge of a made thing lies along it


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """``vertices`` (V, 3); outward unit ``normals`` (V, 3), or None where every face is flat; ``faces`` (F, 3),
    counter-clockwise from outside; ``colors`` (F, 3) linear sRGB where the faces have colours of their own."""

    vertices: FloatArray
    normals: FloatArray | None
    faces: IntArray
    colors: FloatArray | None = None

    @property
    def corners(self) -> FloatArray:
        """The triangles (F, 3, 3)."""
        found: FloatArray = np.asarray(self.vertices[self.faces], np.float64)
        return found

    @property
    def shading(self) -> FloatArray:
        """The normals of a mesh that has them."""
        assert self.normals is not None, "a mesh of flat faces is faceted before its normals are asked for"
        return self.normals

    def faceted(self) -> Mesh:
        """The mesh with normals: where it has none, its triangles share no vertex, so that each keeps its own."""
        if self.normals is not None:
            return self
        corners = self.corners
        normals = np.repeat(triangle_normals(corners), 3, axis=0)
        return Mesh(corners.reshape(-1, 3), normals, np.arange(3 * len(corners)).reshape(-1, 3), self.colors)


def flat_mesh(vertices: Any, faces: Any) -> Mesh:
    """A mesh of flat faces: ``vertices`` (V, 3) and ``faces`` (F, 3), any sequences of numbers."""
    return Mesh(np.asarray(vertices, np.float64), None, np.asarray(faces, np.int64))


def empty() -> Mesh:
    """The mesh of nothing."""
    return Mesh(np.zeros((0, 3)), None, np.zeros((0, 3), np.int64))


def joined(*meshes: Mesh) -> Mesh:
    """The meshes as one, all of which have normals and none colours."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.shading for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]),
    )


def posed(mesh: Mesh, matrices: FloatArray) -> Mesh:
    """``mesh``, which has normals, under each of the invertible poses (K, 3, 4), one after the other.

    A mirrored copy's faces are turned, so that they stay counter-clockwise from outside.
    """
    linear = matrices[:, :, :3]
    count, size = len(matrices), len(mesh.vertices)
    vertices = mesh.vertices @ np.swapaxes(linear, 1, 2) + matrices[:, None, :, 3]
    cofactors = cofactors_of(linear)
    mirrored = np.einsum("ni,ni->n", linear[:, :, 0], cofactors[:, :, 0]) < 0.0
    normals = mesh.shading @ np.swapaxes(cofactors, 1, 2)
    normals *= np.where(mirrored, -1.0, 1.0)[:, None, None]
    length = np.sqrt(np.einsum("nvi,nvi->nv", normals, normals))
    normals /= np.where(length > 0.0, length, 1.0)[:, :, None]
    faces = (
        np.where(mirrored[:, None, None], mesh.faces[:, ::-1], mesh.faces) + (np.arange(count) * size)[:, None, None]
    )
    colors = None if mesh.colors is None else np.tile(mesh.colors, (count, 1))
    return Mesh(vertices.reshape(-1, 3), normals.reshape(-1, 3), faces.reshape(-1, 3), colors)


_AROUND = [0, 1, 2, 0, 1]


def cofactors_of(linear: FloatArray) -> FloatArray:
    """The cofactor matrices of (N, 3, 3): ``det(A) inv(A).T``, whose columns are cross products of A's columns."""
    m = linear[:, _AROUND][:, :, _AROUND]
    found: FloatArray = m[:, 1:4, 1:4] * m[:, 2:5, 2:5] - m[:, 2:5, 1:4] * m[:, 1:4, 2:5]
    return found


def inverses_of(linear: FloatArray) -> FloatArray:
    """The inverses of (N, 3, 3), which are invertible."""
    cofactors = cofactors_of(linear)
    determinant = np.einsum("ni,ni->n", linear[:, :, 0], cofactors[:, :, 0])
    inverses: FloatArray = np.swapaxes(cofactors, 1, 2) / determinant[:, None, None]
    return inverses


def triangle_normals(corners: FloatArray) -> FloatArray:
    """The unit normals (F, 3) of triangles (F, 3, 3), counter-clockwise from outside; zero where there is no area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit: FloatArray = normals / np.where(length > 0.0, length, 1.0)
    return unit


# --- measures --------------------------------------------------------------------------------------------------------


def areas_of(corners: FloatArray) -> FloatArray:
    """The areas (F,) of triangles (F, 3, 3)."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas: FloatArray = np.linalg.norm(across, axis=1) / 2.0
    return areas


def volume_of(corners: FloatArray) -> float:
    """What the closed surface of triangles (F, 3, 3) encloses, by the divergence theorem."""
    if not len(corners):
        return 0.0
    a, b, c = (corners[:, k] - corners[0, 0] for k in range(3))  # from a point of the surface, for precision
    return float(np.einsum("ni,ni->n", a, np.cross(b, c)).sum() / 6.0)


def sampled(mesh: Mesh, count: int, rng: Any) -> tuple[FloatArray, FloatArray]:
    """``count`` uniform points of the surface and the normals of their triangles, (K, 3) each; none where the mesh has
    no area. ``rng`` is a ``numpy.random.Generator``."""
    corners = mesh.corners
    reached = np.cumsum(areas_of(corners))
    if not len(reached) or not 0.0 < reached[-1] < np.inf:
        return np.zeros((0, 3)), np.zeros((0, 3))
    which = np.searchsorted(reached, rng.random(count) * reached[-1], side="right").clip(max=len(reached) - 1)
    u, v = rng.random(count), rng.random(count)
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u)[:, None], np.where(over, 1.0 - v, v)[:, None]
    a, b, c = (corners[which, k] for k in range(3))
    return a + u * (b - a) + v * (c - a), triangle_normals(corners)[which]


# --- rays ------------------------------------------------------------------------------------------------------------


def first_hits(corners: FloatArray, origins: FloatArray, directions: FloatArray) -> tuple[FloatArray, IntArray]:
    """The least ray parameter (N,) above 0 at which rays (N, 3) meet triangles (F, 3, 3), infinity where they meet
    none, and the triangle (N,), -1 where there is none."""
    t, which = np.full(len(origins), np.inf), np.full(len(origins), -1, np.int64)
    for rays, found, _ in _meetings(corners, origins, directions):
        best = np.argmin(found, axis=1)
        t[rays] = found[np.arange(len(rays)), best]
        which[rays] = np.where(np.isfinite(t[rays]), best, -1)
    return t, which


def encloses(corners: FloatArray, points: FloatArray) -> BoolArray:
    """Whether points (N, 3) lie inside the closed surface of triangles (F, 3, 3): a ray from an inside point leaves it
    once more than it enters."""
    inside = np.zeros(len(points), np.bool_)
    directions = np.broadcast_to(np.array(_ASKEW), points.shape)
    for rays, found, leaves in _meetings(corners, points, directions):
        inside[rays] = np.where(np.isfinite(found), np.where(leaves, 1, -1), 0).sum(axis=1) > 0
    return inside


def _meetings(
    corners: FloatArray, origins: FloatArray, directions: FloatArray
) -> Iterator[tuple[IntArray, FloatArray, BoolArray]]:
    """Batches of rays that meet the box of the triangles: their numbers (K,), where they meet each triangle (K, F),
    infinity for those that they do not, and whether they leave through it. Möller and Trumbore (1997)."""
    if not len(corners):
        return
    with np.errstate(all="ignore"):
        near = np.flatnonzero(_meets_box(corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), origins, directions))
        a, edge, other = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        batch = max(1, _PAIRS // len(corners))
        for start in range(0, len(near), batch):
            rays = near[start : start + batch]
            d, s = directions[rays, None], origins[rays, None] - a
            p, q = np.cross(d, other), np.cross(s, edge)
            det = np.einsum("kfi,fi->kf", p, edge)
            u = np.einsum("kfi,kfi->kf", s, p) / det
            v = np.einsum("kfi,kfi->kf", np.broadcast_to(d, q.shape), q) / det
            t = np.einsum("kfi,fi->kf", q, other) / det
            meets = (u >= -_SEAM) & (v >= -_SEAM) & (u + v <= 1.0 + _SEAM) & (t > 0.0)
            yield rays, np.where(meets, t, np.inf), det < 0.0


def _meets_box(low: FloatArray, high: FloatArray, origins: FloatArray, directions: FloatArray) -> BoolArray:
    room = 1e-9 * (high - low).max()
    safe = np.where(np.abs(directions) < 1e-200, 1e-200, directions)
    first, second = (low - room - origins) / safe, (high + room - origins) / safe
    enter, leave = np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)
    meets: BoolArray = (enter <= leave) & (leave >= 0.0)
    return meets
