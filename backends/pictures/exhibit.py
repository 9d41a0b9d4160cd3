"""Pictures of what an error is about: an operand that is no solid, with its open edges in red."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scenelang.backends.files import check_folder
from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import UsageError
from scenelang.interpreter.runtime.values import IDENTITY, Embedding, Pair, Vector
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.modelling.computing import boundary_edges, welded
from scenelang.interpreter.scene.primitives.base import Primitive
from scenelang.interpreter.scene.primitives.cylinder import Cylinder
from scenelang.interpreter.scene.primitives.mesh import Mesh

_MAX_EDGES = 2_000
_EDGE_RADIUS = 0.006  # of marked edges, relative to the longest side of the mesh
_GREY, _RED = (0.6, 0.6, 0.62), (0.9, 0.02, 0.02)


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


def check_picture(output: Path) -> None:
    """Check before the work starts that ``output`` can be a picture; raises UsageError, and SceneError("file")."""
    if output.suffix.lower() != ".png":
        raise UsageError("value", f"--picture writes PNG files, not `{output}`")
    check_folder(output)


def save_exhibit(subject: Entity | Mesh, path: Path) -> None:
    """Write a picture (640 x 480, PNG) of what an error is about; raises SceneError if it has nothing to show."""
    from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend, save_image

    save_image(draw(exhibit(subject), PictureOptions(width=640, height=480), picture_backend("draft")), path)
