"""Scenes that show the subject of an error or a finding: an operand with its open edges in red; objects that overlap,
float or would fall, with their contact points, in the scene behind glass. ``pictures/exhibit`` draws them."""

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

_MAX_EDGES = 2_000
_EDGE_RADIUS = 0.006  # of marked edges, relative to the longest side of the mesh
_GREY, _RED, _BLUE = (0.6, 0.6, 0.62), (0.9, 0.02, 0.02), (0.02, 0.1, 0.8)
_YELLOW, _GREEN, _BLACK = (1.0, 0.8, 0.0), (0.0, 0.7, 0.1), (0.02, 0.02, 0.02)
_MAX_MARKS = 80


@dataclass(frozen=True, slots=True, kw_only=True)
class _ShownMesh(Primitive):
    """A mesh that no file contains, in one colour."""

    is_solid = False
    mesh: Mesh

    @property
    def is_flat(self) -> bool:
        return False

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        along = self.mesh.vertices @ np.array([a, b, c])
        return float(along.min()), float(along.max())

    def triangulate(self, tolerance: float) -> Mesh:
        return self.mesh


def exhibit(subject: Entity | Mesh) -> Scene:
    """Return a scene that shows what an error is about: an entity, or a mesh with its open edges in red."""
    if isinstance(subject, Entity):
        return Scene(subject.word, [subject], False)
    shown = [_leaf(_ShownMesh(mesh=subject.faceted(), color=_GREY)), *map(_leaf, _marked(subject))]
    root = Entity("operand", Embedding(), tuple(Pair(entity, IDENTITY) for entity in shown))
    return Scene("operand", [root], False)


def _leaf(shape: Primitive) -> Entity:
    return Entity("edge", Embedding(attributes={"color": Vector(shape.color)}), (), shape)


def _marked(mesh: Mesh) -> list[Cylinder]:
    vertices, faces, _ = welded(mesh.vertices, mesh.faces)
    size = float(np.ptp(vertices, axis=0).max(initial=0.0))
    ends = vertices[boundary_edges(faces)][:_MAX_EDGES].tolist()
    return [Cylinder(p0=tuple(a), p1=tuple(b), radius=size * _EDGE_RADIUS, color=_RED) for a, b in ends]


# --- findings of lints -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Marks:
    """What a picture of a finding shows.

    Attributes
    ----------
    subject, other
        Primitives that the finding is about, and those that they are near, in or on, by position in depth-first order.
    points : (K, 3)
        Where they touch; corners of a polygon of support.
    lines : (M, 2, 3)
        Gaps, sides of a polygon of support, and plumb lines from centres of mass.
    centers : (L, 3)
        Centres of mass.
    """

    subject: frozenset[int]
    other: frozenset[int]
    points: FloatArray
    lines: FloatArray
    centers: FloatArray


def marked_scene(root: Entity, marks: Marks) -> Scene:
    """Return a scene with the subject of a finding in red, the other side in blue, all else behind glass, and marks."""
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
    if row in marks.subject:
        return _RED, 0.45
    return (_BLUE, 0.35) if row in marks.other else (_GREY, 0.15)


def _signs(marks: Marks, size: float) -> list[Any]:
    """Return the points in yellow, the lines in black and the centres of mass in green."""
    radius = 0.015 * size
    found = [_ball(point, 1.5 * radius, _YELLOW) for point in _some(marks.points).tolist()]
    found += [_ball(point, 2.5 * radius, _GREEN) for point in marks.centers.tolist()]
    ends = [(a, b) for a, b in _some(marks.lines).tolist() if math.dist(a, b) > 1e-9 * size]
    bars = [Cylinder(p0=tuple(a), p1=tuple(b), radius=0.6 * radius, color=_BLACK) for a, b in ends]
    return [*found, *(Pair(_leaf(bar), IDENTITY) for bar in bars)]


def _some(rows: FloatArray) -> FloatArray:
    """Return at most ``_MAX_MARKS`` rows, spread evenly."""
    return rows[np.unique(np.linspace(0, len(rows) - 1, _MAX_MARKS).round().astype(np.int64))] if len(rows) else rows


def _ball(point: Sequence[float], radius: float, color: Point) -> Any:
    x, y, z = point
    return Pair(_leaf(Sphere(radius=radius, color=color)), Matrix((1.0, 0, 0, x, 0, 1.0, 0, y, 0, 0, 1.0, z)))
