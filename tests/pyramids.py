"""A package that adds the primitive "pyramid", as somebody else would write and install one: one file, one class."""

from __future__ import annotations

from dataclasses import dataclass

from scenelang.interpreter.scene.primitives import Attribute, Primitive
from scenelang.interpreter.scene.primitives.base import length_of
from scenelang.interpreter.scene.primitives.mesh import Mesh, flat_mesh


@dataclass(frozen=True, slots=True)
class Pyramid(Primitive):
    """A pyramid over the square of ``base`` around the origin, ``height`` high."""

    word = "pyramid"
    doc = "a pyramid over a square around the origin"
    attributes = (
        Attribute("base", "the side of a pyramid's square; default 1", "a number", 1.0, length_of),
        Attribute("height", "how high a pyramid is; default 1", "a number", 1.0, length_of),
    )

    base: float = 1.0
    height: float = 1.0

    def triangulate(self, tolerance: float) -> Mesh:
        b = self.base / 2.0
        corners = [(-b, 0.0, b), (b, 0.0, b), (b, 0.0, -b), (-b, 0.0, -b), (0.0, self.height, 0.0)]
        return flat_mesh(corners, [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (0, 2, 1), (0, 3, 2)])
