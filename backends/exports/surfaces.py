"""The triangles of primitives, in the primitive's own frame: what every export writes or merges."""

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
    """``vertices`` and unit ``normals`` (V, 3); ``faces`` (F, 3), counter-clockwise from outside; ``colors`` (V, 3)
    linear sRGB where the surface brings its own, which multiply the look's."""

    vertices: FloatArray
    normals: FloatArray
    faces: IntArray
    colors: FloatArray | None = None

    def under(self, matrices: FloatArray) -> ExportSurface:
        """The copies of the surface under the poses (K, 3, 4), one after the other."""
        mesh = posed(Mesh(self.vertices, self.normals, self.faces), matrices)
        colors = None if self.colors is None else np.tile(self.colors, (len(matrices), 1))
        return ExportSurface(mesh.vertices, _unit_normals(mesh.shading), mesh.faces, colors)


def surface_of(entity: Entity, segments: int = SEGMENTS) -> ExportSurface | None:
    """The triangles of a primitive, round ones with ``segments`` sides and vertices on the true surface; None where
    there is nothing to see (deleted blocks, a cylinder without a length). A mesh file's own colours show unless the
    primitive has a ``:color``. Raises SceneError for unreadable files."""
    solid = solid_of(entity)
    return None if solid is None else solid.own_surface(segments)


def vertex_count(entity: Entity, segments: int) -> int:
    """About how many vertices ``surface_of`` makes."""
    shape = entity.shape
    placed = None if shape is None else shape.placed()
    if placed is not None:
        return placed.form.vertex_count(segments, placed.ratios)
    mesh = None if shape is None else own_mesh(shape)
    return 0 if mesh is None else 3 * len(mesh.faces)


def is_round(shape: Primitive) -> bool:
    """True when the number of sides matters to the shape's surface."""
    placed = shape.placed()
    return placed is not None and placed.form.is_curved


def _of_mesh(mesh: Mesh, own_colors: bool) -> ExportSurface:
    """The surface of a mesh; where it has colours, or no normals, its triangles share no vertex."""
    if mesh.normals is not None and not own_colors:
        return ExportSurface(mesh.vertices, _unit_normals(mesh.normals), mesh.faces)
    corners = mesh.corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat = np.repeat(_unit_normals(normals), 3, axis=0)
    shading = flat if mesh.normals is None else _unit_normals(mesh.normals[mesh.faces].reshape(-1, 3))
    colors = None if mesh.colors is None or not own_colors else np.repeat(mesh.colors, 3, axis=0)
    return ExportSurface(corners.reshape(-1, 3), shading, np.arange(3 * len(corners)).reshape(-1, 3), colors)


def _unit_normals(normals: FloatArray) -> FloatArray:
    """The directions of ``normals``; up where a face without an area has none."""
    largest = np.abs(normals).max(axis=1, keepdims=True, initial=0.0)
    sound = np.isfinite(largest[:, 0]) & (largest[:, 0] > 0.0)
    out = np.where(sound[:, None], normals / np.where(sound[:, None], largest, 1.0), (0.0, 1.0, 0.0))
    unit: FloatArray = out / np.linalg.norm(out, axis=1, keepdims=True)
    return unit


# --- what is shared ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Solid:
    """A primitive as a mesh that many share, and the pose (12 floats) that takes it to the primitive's frame.

    ``form`` is the canonical form with the ``ratios``, whose surface is ``unit_surface``; None where ``shape`` has a
    surface of its own: a mesh, or something flat, whose normals no pose of a form gives. ``own_colors``: those of the
    mesh show.
    """

    form: CanonicalForm | None
    ratios: tuple[float, ...]
    shape: Primitive
    pose: Matrix
    own_colors: bool = False

    @property
    def key(self) -> Hashable:
        """What the shared mesh depends on."""
        return (self.form, self.ratios) if self.form is not None else (self.shape.key, self.own_colors)

    def surface(self, segments: int = SEGMENTS) -> ExportSurface | None:
        """The triangles of the shared mesh, without the pose."""
        return self.own_surface(segments) if self.form is None else unit_surface(self.form, self.ratios, segments)

    def own_surface(self, segments: int = SEGMENTS) -> ExportSurface | None:
        """The triangles in the primitive's frame."""
        placed = self.shape.placed()
        if placed is not None:
            return unit_surface(placed.form, placed.ratios, segments).under(placed.matrix[None])
        mesh = own_mesh(self.shape)
        return None if mesh is None else _of_mesh(mesh, self.own_colors)


def solid_of(entity: Entity) -> Solid | None:
    """The solid that a primitive is; None where there is nothing to see."""
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
    """The canonical form's triangles."""
    mesh = form.mesh(segments, ratios)
    return ExportSurface(mesh.vertices, mesh.shading, mesh.faces)


# One mesh of everything below an entity: what ``--depth`` makes of parts, and ``--instance-limit`` of repetitions.


MOST_VERTICES = 24_000_000
WHITE = (1.0, 1.0, 1.0)
_COARSER = (SEGMENTS, 48, 32, 24, 16, 12, 8)


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """The triangles of one material: ``look`` with its colour white, since ``surface.colors`` (V, 3) has it."""

    look: Look
    surface: ExportSurface


def merged(entity: Entity, segments: int = SEGMENTS) -> tuple[Patch, ...]:
    """All primitives below ``entity``, in its frame, one patch for each material but for the colour."""
    frame = flatten_entity(entity, whole_cells=False)
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
    """The surface with the look's colour on every vertex."""
    own = np.ones((len(surface.vertices), 3)) if surface.colors is None else surface.colors
    return replace(surface, colors=own * np.array(look.color))


def joined(surfaces: Sequence[ExportSurface]) -> ExportSurface:
    """All surfaces, which have colours, as one."""
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
    """How many sides round primitives may have so that the ``entities``, merged, fit; raises LimitError when none do.

    ``what`` names the file in the message, ``hint`` says what to do.
    """
    shapes = [(frame, np.bincount(frame.index)) for frame in _frames(entities, what, hint)]
    for segments in _COARSER:
        total = sum(
            int(count) * vertex_count(primitive, segments)
            for frame, counts in shapes
            for primitive, count in zip(frame.primitives, counts.tolist(), strict=True)
        )
        if total <= MOST_VERTICES:
            return segments
        if not any(p.shape is not None and is_round(p.shape) for frame, _ in shapes for p in frame.primitives):
            break
    raise LimitError(
        "primitives", f"{what} would have {total:,} vertices, more than the {MOST_VERTICES:,} that fit", hint=hint
    )


def _frames(entities: Sequence[Entity], what: str, hint: str | None) -> list[FlatFrame]:
    total = sum(primitive_count(entity) for entity in entities)
    if 3 * total > MOST_VERTICES:  # before anything is expanded
        raise LimitError("primitives", f"{what} would hold {total:,} primitives, more than fit", hint=hint)
    return [flatten_entity(entity, whole_cells=False) for entity in entities]
