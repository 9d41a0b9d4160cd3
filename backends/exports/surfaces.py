"""The triangles of primitives, in the primitive's own frame: what every export writes or merges."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.assets import load_asset
from scenelang.backends.meshes import UnitMesh, posed, unit_mesh
from scenelang.backends.solids import Form, local_pose
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.shapes import Kind, Shape
from scenelang.interpreter.values import IDENTITY, Matrix

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

SEGMENTS = 64


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """``vertices`` and unit ``normals`` (V, 3); ``faces`` (F, 3), counter-clockwise from outside; ``colors`` (V, 3)
    linear sRGB where the surface brings its own, which multiply the look's."""

    vertices: FloatArray
    normals: FloatArray
    faces: IntArray
    colors: FloatArray | None = None

    def under(self, matrices: FloatArray) -> Surface:
        """The copies of the surface under the poses (K, 3, 4), one after the other."""
        mesh = UnitMesh(self.vertices, self.normals, self.faces)
        vertices, normals, faces = posed(mesh, matrices)
        colors = None if self.colors is None else np.tile(self.colors, (len(matrices), 1))
        return Surface(vertices, _unit_normals(normals), faces, colors)


def surface_key(shape: Shape) -> Hashable:
    """What the triangles of ``shape`` depend on."""
    kind = Kind.CUBE if shape.kind is Kind.BOX else shape.kind
    return (kind, shape.size, shape.radius, shape.p0, shape.p1, shape.file, shape.root)


def surface_of(entity: Entity, segments: int = SEGMENTS) -> Surface | None:
    """The triangles of a primitive, round ones with ``segments`` sides and vertices on the true surface; None where
    there is nothing to see (deleted blocks, a cylinder without a length). A mesh file's own colours show unless the
    primitive has a ``:color``. Raises SceneError for unreadable files."""
    solid = solid_of(entity)
    return None if solid is None else solid.own_surface(segments)


def vertex_count(entity: Entity, segments: int) -> int:
    """About how many vertices ``surface_of`` makes."""
    shape = entity.shape
    if shape is None:
        return 0
    if shape.kind is Kind.ASSET:
        return 0 if shape.file is None else 3 * len(load_asset(shape.file, shape.root).faces)
    found = local_pose(shape)
    if found is None:
        return 0
    ball = segments * (segments // 2)
    return {Form.BLOCK: 24, Form.BALL: ball, Form.CYLINDER: 4 * segments, Form.CONE: 3 * segments}.get(found[0], 3)


def is_round(shape: Shape) -> bool:
    """True when the number of sides matters to the shape's surface."""
    return shape.kind in (Kind.SPHERE, Kind.CYLINDER, Kind.CONE)


def _faceted(vertices: FloatArray, faces: IntArray, face_colors: FloatArray | None) -> Surface:
    """The surface whose triangles share no vertex, so that each keeps its own normal and colour."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = _unit_normals(normals)
    colors = None if face_colors is None else np.repeat(face_colors, 3, axis=0)
    return Surface(
        corners.reshape(-1, 3), np.repeat(normals, 3, axis=0), np.arange(3 * len(faces)).reshape(-1, 3), colors
    )


def _unit_normals(normals: FloatArray) -> FloatArray:
    """The directions of ``normals``; up where a face without an area has none."""
    largest = np.abs(normals).max(axis=1, keepdims=True, initial=0.0)
    sound = np.isfinite(largest[:, 0]) & (largest[:, 0] > 0.0)
    out = np.where(sound[:, None], normals / np.where(sound[:, None], largest, 1.0), (0.0, 1.0, 0.0))
    unit: FloatArray = out / np.linalg.norm(out, axis=1, keepdims=True)
    return unit


# --- canonical solids ------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Solid:
    """A primitive as a mesh that many share, and the pose (12 floats) that takes it to the primitive's frame.

    ``form`` is the canonical solid (see ``solids``), whose surface is ``unit_surface``; None where ``shape`` has a
    surface of its own: a mesh file, or something flat, whose normals no pose of a solid gives. ``tinted``: the
    primitive's colour stands for those of its file.
    """

    form: Form | None
    shape: Shape
    pose: Matrix
    tinted: bool = False

    @property
    def key(self) -> Hashable:
        """What the shared mesh depends on."""
        return self.form if self.form is not None else (surface_key(self.shape), self.tinted)

    def surface(self, segments: int = SEGMENTS) -> Surface | None:
        """The triangles of the shared mesh, without the pose."""
        return self.own_surface(segments) if self.form is None else unit_surface(self.form, segments)

    def own_surface(self, segments: int = SEGMENTS) -> Surface | None:
        """The triangles in the primitive's frame."""
        if self.shape.kind is Kind.ASSET:
            mesh = load_asset(self.shape.file or "", self.shape.root)
            return _faceted(mesh.vertices, mesh.faces, None if self.tinted else mesh.face_colors)
        found = local_pose(self.shape)
        return None if found is None else unit_surface(found[0], segments).under(found[1][None])


def solid_of(entity: Entity) -> Solid | None:
    """The solid that a primitive is; None where there is nothing to see."""
    shape = entity.shape
    if shape is None:
        return None
    if shape.kind is Kind.ASSET:
        tinted = entity.embedding.attributes.get("color") is not None
        return None if shape.file is None else Solid(None, shape, IDENTITY, tinted)
    found = local_pose(shape)
    if found is None:
        return None
    form, pose = found
    if not np.linalg.det(pose[:, :3]):
        return Solid(None, shape, IDENTITY)
    return Solid(form, shape, Matrix(pose.ravel().tolist()))


def unit_surface(form: Form, segments: int = SEGMENTS) -> Surface:
    """The canonical solid's triangles."""
    mesh = unit_mesh(form, segments)
    return Surface(mesh.vertices, mesh.normals, mesh.faces)
