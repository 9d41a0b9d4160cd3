"""Minecraft's primitives: "set-cuboid" lays blocks, "delete-blocks" takes them away.

Their geometry is that of the cells that they fill; what stands there in the end, the Minecraft backend says.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from scenelang.interpreter.scene.primitives.base import SCALE, WHITE, Attribute, Placed, Point, Primitive, Symmetry
from scenelang.interpreter.scene.primitives.cube import placed_block

BLOCK_TYPE = Attribute("block-type", 'the kind of block, a string such as "stone"', "a string")
BLOCK_KWARGS = Attribute(
    "block-kwargs", "the block's states, an association list or table; default none", "a list or table"
)
FILL = Attribute("fill", "#t: all blocks, #f: only those of the six faces; default #t", "a boolean", True)


@dataclass(frozen=True, slots=True)
class SetCuboid(Primitive):
    """Blocks from the origin to ``size``."""

    word = "set-cuboid"
    doc = "Minecraft blocks from the origin on, +z forward"
    attributes: ClassVar[tuple[Attribute, ...]] = (BLOCK_TYPE, BLOCK_KWARGS, SCALE, FILL)
    is_solid = False
    is_block = True
    meaning: ClassVar[str | None] = "block"
    turn = Symmetry()

    size: Point = WHITE

    @property
    def is_flat(self) -> bool:
        return 0.0 in self.size

    @property
    def lays_air(self) -> bool:
        """Whether it takes blocks away."""
        return False

    def defining(self) -> dict[str, Any]:
        return {"scale": list(self.size), "fill": True}

    def own_color(self, word: str, attributes: Mapping[str, Any]) -> tuple[str, float, float] | None:
        return str(attributes.get("block-type", "")), 0.45, 0.80

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        x, y, z = self.size
        middle = 0.5 * (a * x + b * y + c * z)
        half = 0.5 * (abs(a) * x + abs(b) * y + abs(c) * z)
        return middle - half, middle + half

    def placed(self) -> Placed | None:
        return placed_block(self.size, corner=True)


@dataclass(frozen=True, slots=True)
class DeleteBlocks(SetCuboid):
    """No blocks from the origin to ``size``: it has no geometry, only a size."""

    word = "delete-blocks"
    doc = "removes Minecraft blocks from the origin on, +z forward"
    attributes = (SCALE,)
    has_geometry = False
    has_color = False
    meaning = None

    @property
    def is_flat(self) -> bool:
        return False

    @property
    def lays_air(self) -> bool:
        return True

    def defining(self) -> dict[str, Any]:
        return {"scale": list(self.size)}

    def own_color(self, word: str, attributes: Mapping[str, Any]) -> tuple[str, float, float] | None:
        return None

    def placed(self) -> Placed | None:
        return None
