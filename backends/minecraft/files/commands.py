"""A build as the game's commands, places relative to where they run."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from scenelang.backends.minecraft.blocks import Build
from scenelang.backends.minecraft.files.versions import GameVersion
from scenelang.backends.minecraft.merging import merged
from scenelang.backends.minecraft.table import load_table

MOST_FILLED = 32_768  # cells of one `fill`
_FIRST_STRICT = "1.21.5"

Triple = tuple[int, int, int]


def commands(build: Build, version: GameVersion) -> Iterator[str]:
    """Commands that lay ``build``, which is in the blocks of ``version``, and whose cell c they put at ``~c``.

    Whole cubes come first, and each kind from the ground up, so that torches find the wall that they hang on. From
    1.21.5 on they are ``strict``: the game leaves the states as they are written.
    """
    cuboids = merged(build.cells)
    states = [str(state) for state in build.palette]
    ending = "" if version.is_before(_FIRST_STRICT) else " strict"
    order = np.argsort(_is_late(build)[cuboids.number], kind="stable")
    lows = (cuboids.low[order] + np.array(build.origin)).tolist()
    for low, size, number in zip(lows, cuboids.size[order].tolist(), cuboids.number[order].tolist()):
        block = states[number] + ending
        for a, b in _cuts(low, size):
            if a == b:
                yield f"setblock {_place(a)} {block}"
            else:
                yield f"fill {_place(a)} {_place(b)} {block}"


def _is_late(build: Build) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """For each number of the palette: whether it is laid after the whole cubes."""
    blocks = load_table().blocks
    kinds = [blocks.get(state.name) for state in build.palette]
    return np.array([kind is None or kind.shape != "cube" for kind in kinds])


def _cuts(low: Triple, size: Triple) -> Iterator[tuple[Triple, Triple]]:
    """The first and the last cell of pieces of a cuboid that one ``fill`` may fill."""
    width = min(size[0], MOST_FILLED)
    depth = min(size[2], MOST_FILLED // width)
    height = min(size[1], MOST_FILLED // (width * depth))
    most = (width, height, depth)
    for corner in product(*(range(0, n, step) for n, step in zip(size, most))):
        x, y, z = (a + b for a, b in zip(low, corner))
        w, h, d = (min(step, n - b) for step, n, b in zip(most, size, corner))
        yield (x, y, z), (x + w - 1, y + h - 1, z + d - 1)


def _place(cell: Triple) -> str:
    x, y, z = cell
    return f"~{x} ~{y} ~{z}"
