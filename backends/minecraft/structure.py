"""The game's own structures, ``.nbt``: what structure blocks and ``/place template`` load.

The game saves no structure larger than 48 cells along an axis. A larger build becomes several files beside one
another, ``house-0-0-0.nbt``, ``house-48-0-0.nbt`` and so on: the numbers are how far, in cells along x, y and z, the
piece stands from the lowest corner of the build, so each is loaded with these numbers as its relative position. A cell
without a block is not in the file, and keeps what stands there. The game knows no paste origin but the lowest corner;
where the program's origin is stands in a field of our own that it skips, so that reading a file gives its blocks their
places.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.files import written_together
from scenelang.backends.minecraft.blocks import AIR, AIR_STATE, BlockState, Build, trimmed, unified
from scenelang.backends.minecraft.build_files import (
    GameVersion,
    LoadedBuild,
    Lost,
    as_written,
    state_of_tag,
    tag_of_state,
)
from scenelang.backends.minecraft.nbt import (
    Compounds,
    Damaged,
    Triple,
    checked_size,
    how_many,
    listed,
    triple_of_array,
    whole,
    write_nbt,
)

LARGEST = 48  # cells of a structure along each axis
_ORIGIN = "ScenelangOrigin"
# One entry of the list of blocks: the tags before its numbers as they stand in the file.
_BLOCK = np.dtype([
    ("before_pos", "S11"), ("pos", ">i4", 3), ("before_state", "S8"), ("state", ">i4"), ("end", "u1"),
])  # fmt: skip
_BEFORE_POS = b"\x09\x00\x03pos\x03\x00\x00\x00\x03"
_BEFORE_STATE = b"\x03\x00\x05state"


def write(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` for ``version``, whole or not at all; the paths that were written, ``path`` alone where one
    piece is enough. Raises SceneError: "empty-scene", "file"."""
    build = as_written(build, version)
    pieces = list(_pieces(build))
    is_one = max(build.size) <= LARGEST
    names = [path.name if is_one else f"{path.stem}-{x}-{y}-{z}{path.suffix}" for (x, y, z), _ in pieces]
    with written_together(path.parent) as folder:
        for name, (_, piece) in zip(names, pieces):
            write_nbt(folder / name, "", _root(piece, version))
    return [path.parent / name for name in names]


def _pieces(build: Build) -> Iterator[tuple[Triple, Build]]:
    """The parts of at most LARGEST cells along each axis that hold blocks, with where they begin in the build."""
    for x, y, z in product(*(range(0, n, LARGEST) for n in build.size)):
        cells = build.cells[x : x + LARGEST, y : y + LARGEST, z : z + LARGEST]
        if cells.any():
            a, b, c = build.origin
            yield (x, y, z), unified((a + x, b + y, c + z), cells, build.palette)


def _root(piece: Build, version: GameVersion) -> dict[str, Any]:
    at = np.argwhere(piece.cells != AIR)
    blocks = np.zeros(len(at), _BLOCK)
    blocks["before_pos"], blocks["before_state"] = _BEFORE_POS, _BEFORE_STATE
    blocks["pos"], blocks["state"] = at, piece.cells[tuple(at.T)] - 1
    return {
        "DataVersion": version.data_version,
        "size": list(piece.size),
        "palette": [tag_of_state(state) for state in piece.palette[1:]],
        "blocks": Compounds(len(at), blocks.tobytes()),
        "entities": [],
        _ORIGIN: np.array(piece.origin, np.int32),
    }


def loaded(root: Mapping[str, Any]) -> LoadedBuild:
    """What the root compound of a structure holds, the first of several palettes; raises Damaged."""
    size = checked_size(triple_of_array(root, "size"))
    states = _palette(root)
    cells = np.zeros(size, np.uint32)
    blocks = listed(root, "blocks")
    at, number = _blocks(blocks, size, len(states))
    cells[tuple(at.T)] = number + 1
    origin = triple_of_array(root, _ORIGIN) if _ORIGIN in root else (0, 0, 0)
    lost = Lost(sum("nbt" in block for block in blocks), how_many(root, "entities"))
    return LoadedBuild(trimmed(unified(origin, cells, [AIR_STATE, *states])), lost)


def _palette(root: Mapping[str, Any]) -> list[BlockState]:
    if "palettes" in root:
        choices = listed(root, "palettes")
        palette = choices[0] if choices and isinstance(choices[0], list) else []
    else:
        palette = listed(root, "palette")
    return [state_of_tag(entry) for entry in palette]


def _blocks(blocks: list[Any], size: Triple, states: int) -> tuple[Any, Any]:
    """The cells (N, 3) of blocks and the numbers (N,) of their states; raises Damaged where either is none."""
    if not all(isinstance(block, dict) for block in blocks):
        raise Damaged("an entry of `blocks` is no compound")
    at = np.array([triple_of_array(block, "pos") for block in blocks], np.int64).reshape(-1, 3)
    number = np.array([whole(block, "state") for block in blocks], np.int64)
    if len(at) and ((at < 0) | (at >= size)).any():
        raise Damaged("a block stands outside its box")
    if len(at) and not 0 <= int(number.min()) <= int(number.max()) < states:
        raise Damaged(f"a block has a number that is not among the {states:,} of its palette")
    return at, number
