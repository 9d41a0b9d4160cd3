"""Triangle meshes of the canonical solids (see ``solids``), with normals for smooth surfaces and closed caps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.solids import Form, cofactors_of

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class UnitMesh:
    """``vertices`` and outward unit ``normals`` (V, 3); ``faces`` (F, 3), counter-clockwise from outside."""

    vertices: FloatArray
    normals: FloatArray
    faces: IntArray


def unit_mesh(form: Form, segments: int = 48) -> UnitMesh:
    """The canonical solid as a closed mesh; round ones have ``segments`` >= 3 sides, vertices on the true surface."""
    if form == Form.BALL:
        return _ball(segments)
    if form == Form.BLOCK:
        return _block()
    if form == Form.CYLINDER:
        return _joined(_side(segments, 1.0), _cap(segments, 1.0), _cap(segments, -1.0))
    if form == Form.CONE:
        return _joined(_side(segments, 0.0), _cap(segments, -1.0))
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [-1, 1, 0]])
    return UnitMesh(corners, np.tile([0.0, 0.0, 1.0], (3, 1)), np.array([[0, 1, 2]]))


def _joined(*meshes: UnitMesh) -> UnitMesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return UnitMesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]),
    )


def _circle(segments: int) -> tuple[FloatArray, FloatArray]:
    angle = np.arange(segments) * (2.0 * math.pi / segments)
    return np.cos(angle), np.sin(angle)


def _ball(segments: int) -> UnitMesh:
    """Rings of latitude with the poles on the y axis."""
    rings = max(2, (segments + 1) // 2)
    cosine, sine = _circle(segments)
    height = np.arange(1, rings) * (math.pi / rings)
    y, radius = np.cos(height), np.sin(height)
    body = np.stack(
        [radius[:, None] * sine, np.broadcast_to(y[:, None], (rings - 1, segments)), radius[:, None] * cosine], axis=2
    )
    vertices = np.concatenate([[[0.0, 1.0, 0.0]], body.reshape(-1, 3), [[0.0, -1.0, 0.0]]])
    here = np.arange(segments)
    after = (here + 1) % segments
    last = len(vertices) - 1
    faces = [np.stack([np.zeros_like(here), 1 + here, 1 + after], axis=1)]
    for ring in range(rings - 2):
        top, bottom = 1 + ring * segments, 1 + (ring + 1) * segments
        faces.append(np.stack([top + here, bottom + here, bottom + after], axis=1))
        faces.append(np.stack([top + here, bottom + after, top + after], axis=1))
    start = 1 + (rings - 2) * segments
    faces.append(np.stack([start + here, np.full_like(here, last), start + after], axis=1))
    return UnitMesh(vertices, vertices.copy(), np.concatenate(faces))


def _block() -> UnitMesh:
    """Six squares of two triangles, four vertices each."""
    meshes = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            normal = sign * np.eye(3)[axis]
            v = sign * v
            corners = np.stack([normal - u - v, normal + u - v, normal + u + v, normal - u + v])
            meshes.append(UnitMesh(corners, np.tile(normal, (4, 1)), np.array([[0, 1, 2], [0, 2, 3]])))
    return _joined(*meshes)


def _side(segments: int, top: float) -> UnitMesh:
    """The side from radius 1 at y = -1 to radius ``top`` at y = 1."""
    cosine, sine = _circle(segments)
    ones = np.ones(segments)
    slope = (1.0 - top) / 2.0
    normal = np.stack([sine, slope * ones, cosine], axis=1) / math.hypot(1.0, slope)
    low = np.stack([sine, -ones, cosine], axis=1)
    here = np.arange(segments)
    after = (here + 1) % segments
    if top > 0.0:
        high = np.stack([top * sine, ones, top * cosine], axis=1)
        faces = [
            np.stack([here, after, segments + after], axis=1),
            np.stack([here, segments + after, segments + here], axis=1),
        ]
        return UnitMesh(np.concatenate([low, high]), np.concatenate([normal, normal]), np.concatenate(faces))
    middle = normal + normal[after]  # the apex has one vertex, and one normal, per side
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    apex = np.tile([0.0, 1.0, 0.0], (segments, 1))
    faces = [np.stack([here, after, segments + here], axis=1)]
    return UnitMesh(np.concatenate([low, apex]), np.concatenate([normal, middle]), np.concatenate(faces))


def _cap(segments: int, y: float) -> UnitMesh:
    cosine, sine = _circle(segments)
    rim = np.stack([sine, np.full(segments, y), cosine], axis=1)
    vertices = np.concatenate([rim, [[0.0, y, 0.0]]])
    here = np.arange(segments)
    after = (here + 1) % segments
    center = np.full(segments, segments)
    faces = np.stack([here, after, center] if y > 0 else [after, here, center], axis=1)
    return UnitMesh(vertices, np.tile([0.0, math.copysign(1.0, y), 0.0], (segments + 1, 1)), faces)


def posed(mesh: UnitMesh, matrices: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """``mesh`` under each of the invertible poses (K, 3, 4), one after the other.

    Returns vertices (K V, 3), unit normals (K V, 3) and faces (K F, 3); a mirrored copy's faces are turned, so that
    they stay counter-clockwise from outside.
    """
    linear = matrices[:, :, :3]
    count, size = len(matrices), len(mesh.vertices)
    vertices = mesh.vertices @ np.swapaxes(linear, 1, 2) + matrices[:, None, :, 3]
    cofactors = cofactors_of(linear)
    mirrored = np.einsum("ni,ni->n", linear[:, :, 0], cofactors[:, :, 0]) < 0.0
    normals = mesh.normals @ np.swapaxes(cofactors, 1, 2)
    normals *= np.where(mirrored, -1.0, 1.0)[:, None, None]
    length = np.sqrt(np.einsum("nvi,nvi->nv", normals, normals))
    normals /= np.where(length > 0.0, length, 1.0)[:, :, None]
    faces = (
        np.where(mirrored[:, None, None], mesh.faces[:, ::-1], mesh.faces) + (np.arange(count) * size)[:, None, None]
    )
    return vertices.reshape(-1, 3), normals.reshape(-1, 3), faces.reshape(-1, 3)


def triangle_normals(corners: FloatArray) -> FloatArray:
    """The unit normals (F, 3) of triangles (F, 3, 3), counter-clockwise from outside; zero where there is no area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit: FloatArray = normals / np.where(length > 0.0, length, 1.0)
    return unit
