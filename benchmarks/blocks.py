"""Builds of Minecraft's blocks for the timings: the same cuboids as entities and as a plain Python loop over cells."""

from __future__ import annotations

import gzip
from pathlib import Path

from scenelang.backends.minecraft.blocks import Build
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.pose import translation
from scenelang.interpreter.scene.primitives import shape_of
from scenelang.interpreter.values.values import ANONYMOUS, Embedding, Pair, Vector

Laid = tuple[tuple[int, int, int], int, str]  # where it begins, its cells along each axis, the block


def cuboids(count: int, edge: int) -> list[Laid]:
    """``count`` overlapping cubes of ``edge`` cells in two kinds of block."""
    return [((7 * i % 190, 11 * i % 180, 13 * i % 170), edge, ("stone", "dirt")[i % 2]) for i in range(count)]


def entities(laid: list[Laid]) -> Entity:
    """The cuboids as one entity."""
    kinds = {(edge, block): _cuboid(edge, block) for _, edge, block in laid}
    parts = tuple(Pair(kinds[edge, block], translation(*start)) for start, edge, block in laid)
    return Entity("build", ANONYMOUS, parts)


def _cuboid(edge: int, block: str) -> Entity:
    attributes = {"block-type": block, "scale": Vector([float(edge)] * 3)}
    return Entity("set-cuboid", Embedding(None, None, attributes), (), shape_of("set-cuboid", attributes))


def looped(laid: list[Laid]) -> dict[tuple[int, int, int], str]:
    """What stands in each cell, one cell after another."""
    cells: dict[tuple[int, int, int], str] = {}
    for (x, y, z), edge, block in laid:
        for i in range(edge):
            for j in range(edge):
                for k in range(edge):
                    cells[x + i, y + j, z + k] = block
    return cells


def written_in_a_loop(build: Build, path: Path) -> None:
    """The numbers of a build's blocks as a schematic orders them, a byte each, one cell after another."""
    cells = build.cells.tolist()
    width, height, depth = build.size
    data = bytearray()
    for y in range(height):
        for z in range(depth):
            for x in range(width):
                data.append(cells[x][y][z])
    path.write_bytes(gzip.compress(data, 5))


def read_in_a_loop(path: Path, size: tuple[int, int, int]) -> dict[tuple[int, int, int], int]:
    """What stands in each cell of such a file."""
    width, _, depth = size
    cells = {}
    for i, number in enumerate(gzip.decompress(path.read_bytes())):
        if number:
            cells[i % width, i // (width * depth), i // width % depth] = number
    return cells
