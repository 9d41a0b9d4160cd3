"""Triangle surfaces of primitives, in their own frames, shared or merged by the export formats."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.solids import keeps_own_colors, own_mesh
from scenelang.backends.pictures.appearance import Look, look_of
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.runtime.values import IDENTITY, Matrix
from scenelang.interpreter.scene.entity import Entity, primitive_count
from scenelang.interpreter.scene.flatten import FlatFrame, flatten_entity
from scenelang.interpreter.scene.primitives import Primitive
from scenelang.interpreter.scene.primitives.forms import CanonicalForm
from scenelang.interpreter.scene.primitives.mesh import Mesh, posed

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

SEGMENTS = 64


@dataclass(frozen=True, slots=True, eq=False)
class ExportSurface:
    """A triangle mesh with normals.

    ``vertices`` and unit ``normals`` (V, 3); ``faces`` (F, 3), counter-clockwise seen from outside; ``colors`` (V, 3)
    linear sRGB if the surface has its own, which multiply the look's colour.
    """

    vertices: FloatArray
    normals: FloatArray
    faces: IntArray
    colors: FloatArray | None = None

    def under(self, matrices: FloatArray) -> ExportSurface:
        """Return copies of the surface under the poses (K, 3, 4), concatenated."""
        mesh = posed(Mesh(self.vertices, self.normals, self.faces), matrices)
        colors = None if self.colors is None else np.tile(self.colors, (len(matrices), 1))
        return ExportSurface(mesh.vertices, _unit_normals(mesh.shading), mesh.faces, colors)


def surface_of(entity: Entity, segments: int = SEGMENTS) -> ExportSurface | None:
    """Return the triangles of a primitive, None if it is invisible (removed blocks, a cylinder of zero length).

    Round primitives have ``segments`` sides and vertices on the exact surface. A mesh file's own colours are used
    unless the primitive has a ``:color``. Raises SceneError for unreadable files.
    """
    solid = solid_of(entity)
    return None if solid is None else solid.own_surface(segments)


def vertex_count(entity: Entity, segments: int) -> int:
    """Return the approximate number of vertices of ``surface_of``."""
    shape = entity.shape
    placed = None if shape is None else shape.placed()
    if placed is not None:
        return placed.form.vertex_count(segments, placed.ratios)
    mesh = None if shape is None else own_mesh(shape)
    return 0 if mesh is None else 3 * len(mesh.faces)


def is_round(shape: Primitive) -> bool:
    """Whether the shape's surface depends on the number of sides."""
    placed = shape.placed()
    return placed is not None and placed.form.is_curved


def _of_mesh(mesh: Mesh, own_colors: bool) -> ExportSurface:
    """Return the surface of a mesh; if it has colours or no normals, its triangles share no vertices."""
    if mesh.normals is not None and not own_colors:
        return ExportSurface(mesh.vertices, _unit_normals(mesh.normals), mesh.faces)
    corners = mesh.corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat = np.repeat(_unit_normals(normals), 3, axis=0)
    shading = flat if mesh.normals is None else _unit_normals(mesh.normals[mesh.faces].reshape(-1, 3))
    colors = None if mesh.colors is None or not own_colors else np.repeat(mesh.colors, 3, axis=0)
    return ExportSurface(corners.reshape(-1, 3), shading, np.arange(3 * len(corners)).reshape(-1, 3), colors)


def _unit_normals(normals: FloatArray) -> FloatArray:
    """Normalise ``normals``; degenerate ones point up."""
    largest = np.abs(normals).max(axis=1, keepdims=True, initial=0.0)
    sound = np.isfinite(largest[:, 0]) & (largest[:, 0] > 0.0)
    out = np.where(sound[:, None], normals / np.where(sound[:, None], largest, 1.0), (0.0, 1.0, 0.0))
    unit: FloatArray = out / np.linalg.norm(out, axis=1, keepdims=True)
    return unit


# --- shared meshes -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Solid:
    """A primitive as a shared mesh and the pose (12 floats) that places it in the primitive's frame.

    ``form`` is the canonical form with the ``ratios``, whose surface is ``unit_surface``. It is None if ``shape`` has
    its own surface: a mesh, or a flat primitive, whose normals cannot be derived from a form's. ``own_colors``: use
    those of the mesh.
    """

    form: CanonicalForm | None
    ratios: tuple[float, ...]
    shape: Primitive
    pose: Matrix
    own_colors: bool = False

    @property
    def key(self) -> Hashable:
        """Cache key of the shared mesh."""
        return (self.form, self.ratios) if self.form is not None else (self.shape.key, self.own_colors)

    def surface(self, segments: int = SEGMENTS) -> ExportSurface | None:
        """Return the triangles of the shared mesh, without the pose."""
        return self.own_surface(segments) if self.form is None else unit_surface(self.form, self.ratios, segments)

    def own_surface(self, segments: int = SEGMENTS) -> ExportSurface | None:
        """Return the triangles in the primitive's frame."""
        placed = self.shape.placed()
        if placed is not None:
            return unit_surface(placed.form, placed.ratios, segments).under(placed.matrix[None])
        mesh = own_mesh(self.shape)
        return None if mesh is None else _of_mesh(mesh, self.own_colors)


def solid_of(entity: Entity) -> Solid | None:
    """Return the solid of a primitive, None if it is invisible."""
    shape = entity.shape
    if shape is None:
        return None
    placed = shape.placed()
    if placed is None:
        mesh = own_mesh(shape)
        return None if mesh is None else Solid(None, (), shape, IDENTITY, keeps_own_colors(entity, mesh))
    if not np.linalg.det(placed.matrix[:, :3]):
        return Solid(None, (), shape, IDENTITY)
    return Solid(placed.form, placed.ratios, shape, Matrix(placed.rows))


def unit_surface(form: CanonicalForm, ratios: tuple[float, ...], segments: int = SEGMENTS) -> ExportSurface:
    """Return the triangles of the canonical form."""
    mesh = form.mesh(segments, ratios)
    return ExportSurface(mesh.vertices, mesh.shading, mesh.faces)


# Merged meshes of everything below an entity, for ``--depth`` and ``--instance-limit``.


MAX_VERTICES = 24_000_000
WHITE = (1.0, 1.0, 1.0)
_COARSER = (SEGMENTS, 48, 32, 24, 16, 12, 8)


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """The triangles of one material; the look's colour is white because ``surface.colors`` (V, 3) contains it."""

    look: Look
    surface: ExportSurface


def merged(entity: Entity, segments: int = SEGMENTS) -> tuple[Patch, ...]:
    """Return all primitives below ``entity``, in its frame, as one patch per material, ignoring colour."""
    frame = flatten_entity(entity, snap_blocks=False)
    found: dict[Look, list[ExportSurface]] = {}
    for number, primitive in enumerate(frame.primitives):
        look = look_of(primitive)
        surface = None if look.opacity == 0.0 else surface_of(primitive, segments)
        if surface is None:
            continue
        copies = surface.under(np.asarray(frame.matrices[frame.index == number]))
        found.setdefault(replace(look, color=WHITE), []).append(_painted(copies, look))
    return tuple(Patch(look, joined(surfaces)) for look, surfaces in found.items())


def _painted(surface: ExportSurface, look: Look) -> ExportSurface:
    """Return the surface with the look's colour on every vertex."""
    own = np.ones((len(surface.vertices), 3)) if surface.colors is None else surface.colors
    return replace(surface, colors=own * np.array(look.color))


def joined(surfaces: Sequence[ExportSurface]) -> ExportSurface:
    """Concatenate coloured surfaces."""
    if len(surfaces) == 1:
        return surfaces[0]
    starts = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    colors = [np.ones_like(s.vertices) if s.colors is None else s.colors for s in surfaces]
    return ExportSurface(
        np.concatenate([surface.vertices for surface in surfaces]),
        np.concatenate([surface.normals for surface in surfaces]),
        np.concatenate([surface.faces + start for surface, start in zip(surfaces, starts, strict=False)]),
        np.concatenate(colors),
    )


def segments_for(entities: Sequence[Entity], what: str, hint: str | None = None) -> int:
    """Return the largest number of sides of round primitives for which the merged ``entities`` fit; raises LimitError.

    ``what`` names the file in the message, ``hint`` is the hint of the error.
    """
    shapes = [(frame, np.bincount(frame.index)) for frame in _frames(entities, what, hint)]
    for segments in _COARSER:
        total = sum(
            int(count) * vertex_count(primitive, segments)
            for frame, counts in shapes
            for primitive, count in zip(frame.primitives, counts.tolist(), strict=True)
        )
        if total <= MAX_VERTICES:
            return segments
        if not any(p.shape is not None and is_round(p.shape) for frame, _ in shapes for p in frame.primitives):
            break
    raise LimitError(
        "primitives", f"{what} would have {total:,} vertices, more than the limit of {MAX_VERTICES:,}", hint=hint
    )


def _frames(entities: Sequence[Entity], what: str, hint: str | None) -> list[FlatFrame]:
    total = sum(primitive_count(entity) for entity in entities)
    if 3 * total > MAX_VERTICES:  # check before anything is expanded
        raise LimitError("primitives", f"{what} would have {total:,} primitives, more than the limit", hint=hint)
    return [flatten_entity(entity, snap_blocks=False) for entity in entities]
