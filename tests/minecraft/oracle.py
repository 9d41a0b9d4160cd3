"""The blocks of a build the slow way: a dictionary of cells, one Python loop, written from the reference's description
and nothing of the package's."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

Cell = tuple[int, int, int]


@dataclass(frozen=True)
class Cuboid:
    """``state`` None deletes."""

    position: tuple[float, float, float]
    size: tuple[int, int, int]
    state: str | None
    fill: bool = True


def laid(cuboids: Iterable[Cuboid]) -> dict[Cell, str]:
    """What stands in each cell in the end."""
    cells: dict[Cell, str] = {}
    for cuboid in cuboids:
        a, b, c = (math.trunc(n) for n in cuboid.position)
        x, y, z = cuboid.size
        for i in range(x):
            for j in range(y):
                for k in range(z):
                    if not cuboid.fill and 0 < i < x - 1 and 0 < j < y - 1 and 0 < k < z - 1:
                        continue
                    if cuboid.state is None:
                        cells.pop((a + i, b + j, c + k), None)
                    else:
                        cells[a + i, b + j, c + k] = cuboid.state
    return cells


def of_golden(primitives: Iterable[Any]) -> Iterable[Cuboid]:
    """The cuboids of one frame of a golden file."""
    for row in primitives:
        if row["shape"] != "block":
            continue
        m = row["matrix"]
        name = row.get("block_type") or "minecraft:air"
        given = ",".join(f"{key}={value}" for key, value in sorted((row.get("block_kwargs") or {}).items()))
        state = None if name == "minecraft:air" else f"{name}[{given}]" if given else name
        position = (m[0][3], m[1][3], m[2][3])
        size = (round(m[0][0]), round(m[1][1]), round(m[2][2]))
        yield Cuboid(position, size, state, row.get("fill", True) is not False)


def of_build(build: Any) -> dict[Cell, str]:
    """A package's build as such a dictionary."""
    x0, y0, z0 = build.origin
    names = [str(state) for state in build.palette]
    found: dict[Cell, str] = {}
    for x, plane in enumerate(build.cells.tolist()):
        for y, row in enumerate(plane):
            for z, number in enumerate(row):
                if number:
                    found[x0 + x, y0 + y, z0 + z] = names[number]
    return found
