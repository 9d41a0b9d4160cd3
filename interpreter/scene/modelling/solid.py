"""The primitive of computed solids: what ``difference``, ``extrude`` and the other procedures return in a scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.scene.modelling.expressions import Expression
from scenelang.interpreter.scene.primitives.base import Primitive, Symmetry, color_of

if TYPE_CHECKING:
    from scenelang.interpreter.scene.modelling.computing import ComputedSolid
    from scenelang.interpreter.scene.primitives.mesh import Mesh


@dataclass(frozen=True, slots=True, kw_only=True)
class SolidShape(Primitive):
    """A solid, computed when its surface or size is needed; its faces have their own colours unless it has one."""

    word = "solid"
    doc = "a computed solid"
    is_solid = False  # its expression, which is no attribute, determines it
    symmetry = Symmetry(unknown=True)

    expression: Expression = Expression("union-solid")

    @classmethod
    def of(cls, expression: Expression, attributes: Mapping[str, Any]) -> SolidShape:
        """Return the solid of an expression; raises SceneError("attribute") for invalid attributes."""
        made = cls.from_attributes(expression.operation, attributes)  # checks the material
        color = attributes.get("color")
        return cls(expression=expression, color=made.color if color is None else color_of("solid", color))

    def defining_attributes(self) -> dict[str, Any]:
        return {"solid": self.expression.digest, "color": list(self.color)}

    def display_name(self, word: str) -> str | None:
        return None

    @property
    def computed(self) -> ComputedSolid:
        """The surface; raises SceneError and LimitError."""
        from scenelang.interpreter.scene.modelling.computing import computed

        return computed(self.expression)

    @property
    def is_flat(self) -> bool:
        return False

    @property
    def cost(self) -> int:
        return 64

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        hull = self.computed.hull
        along = hull[:, 0] * a + hull[:, 1] * b + hull[:, 2] * c
        return float(along.min()), float(along.max())

    def triangulate(self, tolerance: float) -> Mesh:
        """Return the surface, whatever the tolerance: the segments of its operands decide."""
        return self.computed.mesh

    def volume(self) -> float:
        return self.computed.volume

    def area(self) -> float:
        return self.computed.area
