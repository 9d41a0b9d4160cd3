"""What a mesh is made of: primitives of Blender under matrices, which stay exact, and other polygons."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.backends.blender import polygons
from scenelang.backends.blender.corner_orders import ico_order, sphere_tail
from scenelang.backends.blender.polygons import Polygons
from scenelang.interpreter.transpile.evaluation import UnsupportedPython

FloatArray = npt.NDArray[np.float64]

# Primitives of fewer sides, flat-shaded, are meant as prisms and pyramids.
ROUND_SIDES = 16


@dataclass(frozen=True, slots=True)
class PieceForm:
    """Primitive of unit size around z: its kind and what it is made with.

    ``kind`` is "cube", "plane", "sphere", "ico", "cone", "torus" or "circle". ``counts`` are numbers of faces: of a
    sphere segments and rings, of an ico subdivisions, of a cone its sides. ``sizes`` are the radii at the bottom and
    the top of a cone of height 1, or those of a torus. ``fill`` is that of the ends.
    """

    kind: str
    counts: tuple[int, ...] = ()
    sizes: tuple[float, ...] = ()
    fill: str = "NGON"

    def polygons(self) -> Polygons:
        """Return the mesh that Blender makes."""
        if self.kind == "cube":
            return polygons.cube()
        if self.kind == "plane":
            return polygons.grid(*self.counts)
        if self.kind == "sphere":
            return polygons.uv_sphere(*self.counts)
        if self.kind == "ico":
            return polygons.ico_sphere(*self.counts)
        if self.kind == "cone":
            return polygons.cone(self.counts[0], self.sizes[0], self.sizes[1], self.fill)
        if self.kind == "circle":
            return polygons.circle(self.counts[0], self.fill)
        return polygons.torus(self.sizes[0], self.sizes[1], self.counts[0], self.counts[1])

    @property
    def has_known_order(self) -> bool:
        """Whether its corners are in Blender's order."""
        if self.kind == "sphere":
            return sphere_tail(*self.counts) is not None
        return self.kind != "ico" or self.counts[0] == 1 or ico_order(self.counts[0]) is not None

    @property
    def is_closed(self) -> bool:
        """Whether it bounds a volume."""
        return self.kind in ("cube", "sphere", "ico", "torus") or (self.kind == "cone" and self.fill != "NOTHING")

    def is_round(self, is_smooth: bool) -> bool:
        """Return whether it stands for a curved surface, whose polygons do not matter."""
        if self.kind == "ico":
            return is_smooth or self.counts[0] >= 3
        if self.kind in ("sphere", "cone", "torus", "circle"):
            return is_smooth or min(self.counts[:1]) >= ROUND_SIDES
        return False


@dataclass(frozen=True, slots=True, eq=False)
class BooleanPiece:
    """Boolean of solids: ``kind`` is DIFFERENCE, UNION or INTERSECT; the pieces of the base and of each tool."""

    kind: str
    base: tuple[MeshPiece, ...]
    tools: tuple[tuple[MeshPiece, ...], ...]


@dataclass(frozen=True, slots=True, eq=False)
class MeshPiece:
    """Part of a mesh in its object's frame: a form under a matrix (4, 4), or plain polygons.

    ``slot`` is the number of its material. ``bevel`` is the width and the number of segments of a bevel of all edges
    of a cube, in the frame in which its sides are ``bevel_sizes``.
    """

    matrix: FloatArray
    form: PieceForm | None = None
    mesh: Polygons | None = None
    slot: int = 0
    is_smooth: bool = False
    bevel: tuple[float, int] | None = None
    bevel_sizes: tuple[float, ...] = (1.0, 1.0, 1.0)
    operation: BooleanPiece | None = None

    def moved(self, matrix: FloatArray) -> MeshPiece:
        """Return the piece under a further matrix."""
        return replace(self, matrix=matrix @ self.matrix)

    def is_closed(self) -> bool:
        """Return whether it bounds a volume."""
        if self.form is not None:
            return self.form.is_closed
        return self.mesh is None or self.mesh.is_closed()

    def polygons(self) -> Polygons:
        """Return the mesh of the piece in the object's frame."""
        if self.operation is not None:
            raise UnsupportedPython("the corners of the result of a boolean are not known while a script is followed")
        if self.bevel is not None:
            made = beveled_box(np.array(self.bevel_sizes), *self.bevel)
            made = Polygons(made.points / np.array(self.bevel_sizes), made.faces)
        elif self.form is not None:
            made = self.form.polygons()
        else:
            assert self.mesh is not None, "a piece has a form or a mesh"
            made = self.mesh
        if self.form is not None:
            made = Polygons(made.points, made.faces, (self.slot,) * len(made.faces))
        return made.moved(self.matrix)


def polygons_of(pieces: Sequence[MeshPiece]) -> Polygons:
    """Return pieces as one mesh."""
    return polygons.combined(piece.polygons() for piece in pieces)


def corner_levels(width: float, segments: int) -> list[tuple[float, float]]:
    """Return the levels of a beveled corner: what is left of its radius, and its height."""
    angles = [math.pi / 2 * i / segments for i in range(segments + 1)]
    return [(width * math.cos(angle), width * math.sin(angle)) for angle in angles]


def beveled_box(sizes: FloatArray, width: float, segments: int) -> Polygons:
    """Return a box whose edges are beveled, as rings of corners from the bottom to the top.

    Blender's corners are patches of another pattern on the same sphere: the difference is below 2 % of the cube of the
    width.
    """
    x, y, z = (sizes / 2 - width).tolist()
    levels = corner_levels(width, segments)
    rows = [(r, -z - h) for r, h in reversed(levels)] + [(r, z + h) for r, h in levels]
    points: list[tuple[float, float, float]] = []
    for r, height in rows:
        for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
            for i in range(segments + 1):
                angle = math.pi / 2 * (quarter + i / segments)
                points.append((sx * x + r * math.cos(angle), sy * y + r * math.sin(angle), height))
    wide = 4 * (segments + 1)
    at: Callable[[int, int], int] = lambda j, i: j * wide + i % wide
    faces = [
        (at(j, i), at(j, i + 1), at(j + 1, i + 1), at(j + 1, i)) for j in range(len(rows) - 1) for i in range(wide)
    ]
    ends = [tuple(range(wide))[::-1], tuple(range((len(rows) - 1) * wide, len(rows) * wide))]
    return Polygons(np.array(points), (*faces, *ends)).welded(1e-7)
