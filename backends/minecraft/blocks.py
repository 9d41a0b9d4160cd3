"""Blocks in a grid: what stands in each cell of a build.

Cells are whole numbers: x to the right (the game's east), y up, z as in the program (the game's south). A cell ``(x, y,
z)`` is the unit cube from that corner on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Cells = npt.NDArray[np.uint32]
AIR = 0  # the number of what is empty in every palette
SIDES = ("north", "east", "south", "west")  # clockwise from above: opposite is 2 on, to the left 3 on


@dataclass(frozen=True, slots=True, order=True)
class BlockState:
    """A block with its properties, such as ``minecraft:oak_stairs`` with ``(("facing", "north"), ("half", "top"))``,
    sorted by name."""

    name: str
    properties: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        """As the game writes it: ``minecraft:oak_stairs[facing=north,half=top]``."""
        shown = ",".join(f"{name}={value}" for name, value in self.properties)
        return f"{self.name}[{shown}]" if shown else self.name


AIR_STATE = BlockState("minecraft:air")
# What stands for nothing, wherever it is asked for or read: it is laid as air.
NOTHING = frozenset({"minecraft:air", "minecraft:cave_air", "minecraft:void_air", "minecraft:structure_void"})


@dataclass(frozen=True, slots=True, eq=False)
class Build:
    """Blocks in a box of cells: ``cells[x, y, z]`` is the number in ``palette`` of what stands at ``origin + (x, y,
    z)``. ``palette[0]`` is air; every other entry is used and stands there once."""

    origin: tuple[int, int, int]
    cells: Cells  # (X, Y, Z)
    palette: tuple[BlockState, ...]

    @property
    def size(self) -> tuple[int, int, int]:
        """Cells along x, y and z."""
        x, y, z = self.cells.shape
        return x, y, z
