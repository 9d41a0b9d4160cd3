"""Builds of Minecraft's blocks for the timings: the same cuboids as entities and as a plain Python loop over cells."""

from __future__ import annotations

import gzip
import tempfile
from collections.abc import Iterator
from pathlib import Path

import measuring
from measuring import Goal, Row, timed

from scenelang.backends.minecraft.blocks import Build
from scenelang.backends.minecraft.build_files import game_version, write_schematic
from scenelang.backends.minecraft.export import read
from scenelang.backends.minecraft.voxels import voxelised
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


def laid() -> list[measuring.Pair]:
    """A million blocks in cubes of a thousand."""
    root, cells = entities(cuboids(1_000, 10)), cuboids(1_000, 10)
    return [measuring.Pair(timed(lambda: voxelised(root)), timed(lambda: looped(cells)))]


def laid_ten() -> list[measuring.Pair]:
    root = entities(cuboids(10_000, 10))
    return [measuring.Pair(timed(lambda: voxelised(root)))]


def files(reads: bool) -> Iterator[measuring.Pair]:
    """A thousand cuboids, of which 960,625 blocks stand, written as a schematic or read, and a plain Python loop."""
    build, version = voxelised(entities(cuboids(1_000, 10))).build, game_version()
    with tempfile.TemporaryDirectory() as folder:
        path, plain = Path(folder) / "a.schem", Path(folder) / "a.gz"
        write_schematic(build, path, version)
        written_in_a_loop(build, plain)
        if reads:
            yield measuring.Pair(timed(lambda: read(path)), timed(lambda: read_in_a_loop(plain, build.size)))
        else:
            ours = timed(lambda: write_schematic(build, path, version))
            yield measuring.Pair(ours, timed(lambda: written_in_a_loop(build, plain)))


ROWS = (
    Row("lay 1,000,000 blocks", laid, "a loop over their cells", (Goal(0.1),), rounds=3),
    Row("lay 10,000,000 blocks", laid_ten, goals=(Goal(5.0, "ours"),), rounds=3),
    Row("write 960,000 blocks, .schem", lambda: files(False), "a loop over their box", (Goal(0.3),), rounds=3),
    Row("read 960,000 blocks, .schem", lambda: files(True), "a loop over their box", (Goal(0.5),), rounds=3),
)
