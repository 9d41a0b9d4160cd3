"""Scenes that show the subject of an error or a finding; ``pictures/exhibit`` draws them.

The subject of an error is an operand, whose open edges are red. That of a finding are objects that overlap, float or
would fall, with their contact points, while the rest of the scene is nearly transparent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.grammar.datum import dataclass, replace
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.modelling.computing import boundary_edges, welded
from scenelang.interpreter.scene.primitives.base import Point, Primitive
from scenelang.interpreter.scene.primitives.cylinder import Cylinder
from scenelang.interpreter.scene.primitives.mesh import Mesh
from scenelang.interpreter.scene.primitives.sphere import Sphere
from scenelang.interpreter.values.values import IDENTITY, Embedding, Matrix, Pair, Vector

FloatArray = npt.NDArray[np.float64]

_MAX_EDGES = 2_000  # marked edges
_EDGE_RADIUS = 0.006  # of marked edges, relative to the longest side of the mesh
_MARK_RADIUS = 0.015  # relative to the diagonal of the smallest object
_SUBJECT_OPACITY, _OTHER_OPACITY, _REST_OPACITY = 0.45, 0.35, 0.15
_GRAY, _RED, _BLUE = (0.6, 0.6, 0.62), (0.9, 0.02, 0.02), (0.02, 0.1, 0.8)
_YELLOW, _GREEN, _BLACK = (1.0, 0.8, 0.0), (0.0, 0.7, 0.1), (0.02, 0.02, 0.02)
_MAX_MARKS = 80  # points, and lines


@dataclass(frozen=True, slots=True, kw_only=True)
class _ShownMesh(Primitive):
    """A mesh in memory as a primitive of one color."""

    is_solid = False
    mesh: Mesh

    @property
    def is_flat(self) -> bool:
        """Whether it has no extent along an axis: not known, so no."""
        return False

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        """Return the minimum and maximum of ``a x + b y + c z``."""
        along = self.mesh.vertices @ np.array([a, b, c])
        return float(along.min()), float(along.max())

    def triangulate(self, tolerance: float) -> Mesh:
        """Return the mesh, whatever the tolerance."""
        return self.mesh


def exhibit(subject: Entity | Mesh) -> Scene:
    """Return a scene of the subject of an error: an entity, or a mesh with its open edges in red."""
    if isinstance(subject, Entity):
        return Scene(subject.word, [subject], False)
    shown = [_leaf(_ShownMesh(mesh=subject.faceted(), color=_GRAY)), *map(_leaf, _marked(subject))]
    root = Entity("operand", Embedding(), tuple(Pair(entity, IDENTITY) for entity in shown))
    return Scene("operand", [root], False)


def _leaf(shape: Primitive) -> Entity:
    """Return the entity of a shape, in its color."""
    return Entity("edge", Embedding(attributes={"color": Vector(shape.color)}), (), shape)


def _marked(mesh: Mesh) -> list[Cylinder]:
    """Return rods along the open edges of a mesh."""
    vertices, faces, _ = welded(mesh.vertices, mesh.faces)
    size = float(np.ptp(vertices, axis=0).max(initial=0.0))
    ends = vertices[boundary_edges(faces)][:_MAX_EDGES].tolist()
    return [Cylinder(p0=tuple(a), p1=tuple(b), radius=size * _EDGE_RADIUS, color=_RED) for a, b in ends]


# --- findings of lints -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Marks:
    """Contents of an image of a finding.

    Attributes
    ----------
    subject, other
        Primitives of the finding, and those near which, in which or on which they are, by position in depth-first
        order.
    points : (K, 3)
        Contact points; corners of a support polygon.
    lines : (M, 2, 3)
        Gaps, sides of a support polygon, and plumb lines from centers of mass.
    centers : (L, 3)
        Centers of mass.
    """

    subject: frozenset[int]
    other: frozenset[int]
    points: FloatArray
    lines: FloatArray
    centers: FloatArray


def marked_scene(root: Entity, marks: Marks) -> Scene:
    """Return a scene with the subject of a finding in red, the other side in blue, the rest faint, and marks."""
    frame = flatten_entity(root)
    parts: list[Any] = []
    boxes = []
    for row, (number, matrix) in enumerate(zip(frame.index.tolist(), frame.matrices, strict=True)):
        entity = frame.primitives[number]
        if entity.shape is None or not entity.shape.has_geometry or entity.shape.is_block:
            continue
        color, opacity = _look_of(row, marks)
        pose = Matrix(matrix.ravel().tolist())
        given = {**entity.embedding.attributes, "color": Vector(color), "opacity": opacity}
        look = Embedding(None, entity.embedding.text, given)
        parts.append(Pair(Entity(entity.word, look, (), replace(entity.shape, color=color)), pose))
        if row in marks.subject or row in marks.other:
            boxes.append(np.array(entity.shape.box_under(pose)).reshape(2, 3))
    size = min((float(np.linalg.norm(box[1] - box[0])) for box in boxes), default=1.0)
    parts += _signs(marks, size)
    return Scene(root.word, [Entity(root.word, Embedding(), tuple(parts))], False)


def _look_of(row: int, marks: Marks) -> tuple[tuple[float, float, float], float]:
    """Return the color and the opacity of a primitive."""
    if row in marks.subject:
        return _RED, _SUBJECT_OPACITY
    return (_BLUE, _OTHER_OPACITY) if row in marks.other else (_GRAY, _REST_OPACITY)


def _signs(marks: Marks, size: float) -> list[Any]:
    """Return spheres at the points (yellow) and centers of mass (green), and rods along the lines (black)."""
    radius = _MARK_RADIUS * size
    balls = [_ball(point, 1.5 * radius, _YELLOW) for point in _some(marks.points).tolist()]
    balls += [_ball(point, 2.5 * radius, _GREEN) for point in marks.centers.tolist()]
    ends = [(a, b) for a, b in _some(marks.lines).tolist() if math.dist(a, b) > 1e-9 * size]
    bars = [Cylinder(p0=tuple(a), p1=tuple(b), radius=0.6 * radius, color=_BLACK) for a, b in ends]
    return [*balls, *(Pair(_leaf(bar), IDENTITY) for bar in bars)]


def _some(rows: FloatArray) -> FloatArray:
    """Return at most ``_MAX_MARKS`` rows, spread evenly."""
    return rows[np.unique(np.linspace(0, len(rows) - 1, _MAX_MARKS).round().astype(np.int64))] if len(rows) else rows


def _ball(point: Sequence[float], radius: float, color: Point) -> Any:
    """Return a placed sphere."""
    x, y, z = point
    return Pair(_leaf(Sphere(radius=radius, color=color)), Matrix((1.0, 0, 0, x, 0, 1.0, 0, y, 0, 0, 1.0, z)))
