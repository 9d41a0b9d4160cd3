"""What a file of a build holds once it is read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import AIR, AIR_STATE, BlockState, Build
from scenelang.backends.minecraft.files.damage import Damaged
from scenelang.backends.minecraft.files.fields import Triple, checked_size
from scenelang.backends.minecraft.palettes import trimmed, unified


@dataclass(frozen=True, slots=True)
class Lost:
    """How many things of a file a build cannot hold: what is inside blocks (the contents of chests, the text of signs)
    and entities (animals, item frames, boats)."""

    block_entities: int = 0
    entities: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """The build of a file, in the smallest box, and what of the file it does not hold."""

    build: Build
    lost: Lost


def build_of(origin: Triple, size: Triple, numbers: npt.NDArray[np.uint32], states: Sequence[BlockState]) -> Build:
    """The build of cells in the order of files: x fastest, then z, then y. Raises Damaged for a number that no state
    has."""
    x, y, z = size
    if len(numbers) and int(numbers.max()) >= len(states):
        raise Damaged(f"it has the block number {int(numbers.max()):,}, and {len(states):,} in its palette")
    cells = np.ascontiguousarray(numbers.reshape(y, z, x).transpose(2, 0, 1))
    return trimmed(unified(origin, cells, states or (AIR_STATE,)))


def in_file_order(build: Build) -> npt.NDArray[np.uint32]:
    """The numbers of all cells (N,): x fastest, then z, then y."""
    return build.cells.transpose(1, 2, 0).reshape(-1)


def joined(builds: Sequence[Build]) -> Build:
    """All of ``builds`` in one, later ones on top; their air takes nothing away. Raises Damaged where the box around
    them is too large."""
    standing = [build for build in builds if build.cells.size]
    if len(standing) < 2:
        return standing[0] if standing else trimmed(Build((0, 0, 0), np.zeros((0, 0, 0), np.uint32), (AIR_STATE,)))
    lows: npt.NDArray[Any] = np.array([build.origin for build in standing])
    low = lows.min(axis=0)
    x, y, z = ((lows + [build.size for build in standing]).max(axis=0) - low).tolist()
    cells = np.zeros(checked_size((x, y, z)), np.uint32)
    states: list[BlockState] = [AIR_STATE]
    for build in standing:
        corner = (np.array(build.origin) - low).tolist()
        target = cells[tuple(slice(a, a + n) for a, n in zip(corner, build.size))]
        np.copyto(target, build.cells + np.uint32(len(states)), where=build.cells != AIR)
        states += build.palette
    a, b, c = low.tolist()
    return unified((a, b, c), cells, states)
