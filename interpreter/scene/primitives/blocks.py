"""The Minecraft primitives: "set-cuboid" places blocks, "delete-blocks" removes them.

Their geometry is that of the cells they fill; the Minecraft backend computes the resulting blocks.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.scene.primitives.base import SCALE, WHITE, Attribute, Placed, Point, Primitive, Symmetry
from scenelang.interpreter.scene.primitives.cube import placed_block

BLOCK_TYPE = Attribute(
    "block-type", 'Minecraft block name, such as "stone"', "a string", accepts=("String",), needed='"stone"'
)
BLOCK_KWARGS = Attribute(
    "block-kwargs",
    "block states, an association list or table; default none",
    "a list or table",
    accepts=("List", "Table"),
)
FILL = Attribute(
    "fill",
    "whether to fill the whole cuboid (#t) or only its six faces (#f); default #t",
    "a boolean",
    True,
    accepts=("Boolean",),
)


@dataclass(frozen=True, slots=True)
class SetCuboid(Primitive):
    """Cuboid of blocks from the origin to ``size``."""

    word = "set-cuboid"
    doc = "a cuboid of Minecraft blocks with a corner at the origin, +z forward"
    attributes: ClassVar[tuple[Attribute, ...]] = (BLOCK_TYPE, BLOCK_KWARGS, SCALE, FILL)
    is_solid = False
    is_block = True
    common_name: ClassVar[str | None] = "block"
    symmetry = Symmetry()

    size: Point = WHITE

    @property
    def is_flat(self) -> bool:
        return 0.0 in self.size

    @property
    def removes_blocks(self) -> bool:
        """Whether it removes blocks instead of placing them."""
        return False

    def defining_attributes(self) -> dict[str, Any]:
        return {"scale": list(self.size), "fill": True}

    def color_seed(self, word: str, attributes: Mapping[str, Any]) -> tuple[str, float, float] | None:
        return str(attributes.get("block-type", "")), 0.45, 0.80  # one hue for each type of block

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        x, y, z = self.size
        middle = 0.5 * (a * x + b * y + c * z)
        half = 0.5 * (abs(a) * x + abs(b) * y + abs(c) * z)
        return middle - half, middle + half

    def placed(self) -> Placed | None:
        return placed_block(self.size, corner=True)


@dataclass(frozen=True, slots=True)
class DeleteBlocks(SetCuboid):
    """Removal of the blocks from the origin to ``size``; it has a size but no geometry."""

    word = "delete-blocks"
    doc = "removes the Minecraft blocks in a cuboid with a corner at the origin, +z forward"
    attributes = (SCALE,)
    has_geometry = False
    has_color = False
    common_name = None

    @property
    def is_flat(self) -> bool:
        return False

    @property
    def removes_blocks(self) -> bool:
        """Whether it removes blocks instead of placing them."""
        return True

    def defining_attributes(self) -> dict[str, Any]:
        return {"scale": list(self.size)}

    def color_seed(self, word: str, attributes: Mapping[str, Any]) -> tuple[str, float, float] | None:
        return None

    def placed(self) -> Placed | None:
        return None
