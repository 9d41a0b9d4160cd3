"""Visible blocks of the frames of a scene, in the form that the page draws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import AIR, AIR_STATE, BlockKind, BlockState, Build, load_table
from scenelang.backends.minecraft.connections import settled
from scenelang.backends.minecraft.voxels import voxelised
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.scene.entity import Entity

# Blocks that contain water: water itself, and waterlogged blocks.


WATER_TEXTURES = ("minecraft:block/water_still", "minecraft:block/water_flow")
_WATER = frozenset({"minecraft:water", "minecraft:bubble_column"})
_PLANTS = frozenset({"minecraft:kelp", "minecraft:kelp_plant", "minecraft:seagrass", "minecraft:tall_seagrass"})


def is_water(state: BlockState) -> bool:
    """Whether the cell contains only water."""
    return state.name in _WATER


def is_wet(state: BlockState) -> bool:
    """Whether the block is surrounded by water, such as a waterlogged fence."""
    return state.name in _PLANTS or ("waterlogged", "true") in state.properties


# Visible blocks of a build: those with an exposed side, and occlusion by their neighbors.


IntArray = npt.NDArray[np.int32]
ByteArray = npt.NDArray[np.uint8]

MAX_VISIBLE = 2_000_000  # blocks of one frame
CHUNK = 32  # cells along each axis of a buffer of the page
SIDES = ((0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1), (-1, 0, 0), (1, 0, 0))  # down, up, north, south, west, east
AROUND = tuple(
    (x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)
)  # same order as in the page's script
_SLAB = 1 << 22  # cells processed per batch
# blocks whose faces between two of the same kind are hidden, as in the game
_CLEAR = ("glass", "ice", "slime_block", "honey_block")
# A family number per state for face culling: 0 hides nothing, 1 is an opaque cube. Others hide each other's sides if
# they differ only in the last bit; waterlogged blocks are visible nevertheless.
_NO_FAMILY, _SOLID, _WATER_FAMILY, _WET, _OTHERS = 0, 1, 2, 3, 4


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Visible blocks, grouped by chunk.

    ``cells`` (3, N) are relative to the corner, ``states`` (N,) their palette indices. ``around`` (N,): bit ``k`` below
    26 is set if an opaque cube is at ``AROUND[k]``, bit ``26 + k`` if side ``SIDES[k]`` is hidden (for waterlogged
    blocks, the water's side).
    """

    cells: IntArray
    states: npt.NDArray[np.uint32]
    around: npt.NDArray[np.uint32]


def seen(build: Build, corner: tuple[int, int, int]) -> Seen:
    """Return the blocks of ``build`` with an exposed side, in cells from ``corner``; raises LimitError for too many."""
    family = _families(build.palette)
    padded = np.zeros(tuple(n + 2 for n in build.size), np.uint8)
    inside = padded[1:-1, 1:-1, 1:-1]
    slab = max(1, _SLAB // max(1, build.cells[:1].size))
    for start in range(0, len(inside), slab):
        inside[start : start + slab] = family[build.cells[start : start + slab]]
    at = _exposed(build, padded, slab)
    own = padded[tuple(at + 1)]
    around = np.zeros(at.shape[1], np.uint32)
    for k, step in enumerate(AROUND):
        around |= (_beside(padded, at, step) == _SOLID).astype(np.uint32) << np.uint32(k)
    for k, step in enumerate(SIDES):
        hidden = _hidden(own, _beside(padded, at, step))
        around |= hidden.astype(np.uint32) << np.uint32(26 + k)
    states = build.cells[tuple(at)]
    cells = at + (np.array(build.origin) - np.array(corner))[:, None]
    order = np.lexsort((*cells[::-1], *(cells // CHUNK)[::-1]))
    return Seen(cells[:, order].astype(np.int32), states[order], around[order])


def _families(palette: Sequence[BlockState]) -> ByteArray:
    table = load_table().blocks
    clear = sorted({state.name for state in palette if _is_clear(state.name, table[state.name])})
    number = {name: min(_OTHERS + 2 * i, 254) for i, name in enumerate(clear)}

    def family(state: BlockState) -> int:
        if _is_solid(state, table[state.name]):
            return _SOLID
        if is_water(state):
            return _WATER_FAMILY
        return _WET if is_wet(state) else number.get(state.name, _NO_FAMILY)

    return np.array([family(state) for state in palette], np.uint8)


def _hidden(own: ByteArray, other: ByteArray) -> npt.NDArray[np.bool_]:
    """Return where a side between two families is hidden; for waterlogged blocks, the water's side."""
    return np.asarray((other == _SOLID) | ((own > _SOLID) & (own >> 1 == other >> 1)))


def _is_solid(state: BlockState, kind: BlockKind) -> bool:
    whole = kind.shape == "cube" or ("type", "double") in state.properties
    return whole and not kind.transparent and kind.opacity == 1.0


def _is_clear(name: str, kind: BlockKind) -> bool:
    return kind.shape == "fluid" or (kind.shape == "cube" and name.endswith(_CLEAR))


def _exposed(build: Build, padded: ByteArray, slab: int) -> npt.NDArray[np.int64]:
    """Return the cells (3, N) of blocks with a side that no neighbor hides."""
    parts, count = [np.zeros((3, 0), np.int64)], 0
    x, y, z = build.size
    for start in range(0, x, slab):
        end = min(start + slab, x)
        own = padded[start + 1 : end + 1, 1:-1, 1:-1]
        hidden = np.ones(own.shape, np.bool_)
        for i, j, k in SIDES:
            other = padded[start + 1 + i : end + 1 + i, 1 + j : 1 + j + y, 1 + k : 1 + k + z]
            hidden &= _hidden(own, other) & ((own != _WET) | (other == _SOLID))
        at = np.array(np.nonzero((build.cells[start:end] != AIR) & ~hidden), np.int64)
        at[0] += start
        count += at.shape[1]
        if count > MAX_VISIBLE:
            raise LimitError(
                "size",
                f"the build has more than the limit of {MAX_VISIBLE:,} visible blocks for a picture",
                hint="draw a part of the scene, or draw it with another backend",
            )
        parts.append(at)
    return np.concatenate(parts, axis=1)


def _beside(padded: ByteArray, at: npt.NDArray[np.int64], step: tuple[int, int, int]) -> ByteArray:
    return np.asarray(padded[tuple(at + 1 + np.array(step)[:, None])], np.uint8)


MAX_VISIBLE_IN_ALL = 8_000_000  # visible blocks in all frames


@dataclass(frozen=True, slots=True, eq=False)
class Builds:
    """The visible blocks of frames.

    ``frames[n]`` are those of frame ``n``, in cells from ``corner``, with states as indices into ``palette``.
    ``warnings`` are about replaced and ignored blocks.
    """

    frames: Mapping[int, Seen]
    corner: tuple[int, int, int]
    palette: tuple[BlockState, ...]
    warnings: tuple[Diagnostic, ...]

    @property
    def box(self) -> tuple[list[int], list[int]]:
        """Low and high corner of the visible blocks of all frames, in cells from ``corner``."""
        cells = [seen.cells for seen in self.frames.values() if len(seen.states)]
        low = np.min([each.min(axis=1) for each in cells], axis=0)
        high = np.max([each.max(axis=1) for each in cells], axis=0) + 1
        return low.tolist(), high.tolist()


def builds_of(roots: Mapping[int, Entity], limit: int) -> Builds:
    """Return the builds of frames by number; entities shared by frames are computed once.

    Raises SceneError if there are no blocks or they cannot be placed, and LimitError.
    """
    palette: dict[BlockState, int] = {AIR_STATE: 0}
    warnings: dict[str, Diagnostic] = {}
    done: dict[int, Seen] = {}
    frames: dict[int, Seen] = {}
    corner: tuple[int, int, int] | None = None
    for number, root in roots.items():
        if id(root) not in done:
            whole = settled(voxelised(root, limit))
            build = whole.build
            warnings |= {warning.message: warning for warning in whole.warnings}
            if corner is None and len(build.palette) > 1:
                corner = build.origin
            done[id(root)] = _renumbered(seen(build, corner or build.origin), build, palette)
            _check(sum(len(each.states) for each in done.values()))
        frames[number] = done[id(root)]
    if corner is None:
        raise SceneError(
            "empty-scene",
            "the scene places no blocks, so there is nothing to draw",
            hint="place blocks with `set-cuboid`, or use another backend",
        )
    return Builds(frames, corner, tuple(palette), tuple(warnings.values()))


def _renumbered(before: Seen, build: Build, palette: dict[BlockState, int]) -> Seen:
    numbers = np.array([palette.setdefault(state, len(palette)) for state in build.palette], np.uint32)
    return replace(before, states=numbers[before.states])


def _check(count: int) -> None:
    if count > MAX_VISIBLE_IN_ALL:
        raise LimitError(
            "size",
            f"the frames have more than the limit of {MAX_VISIBLE_IN_ALL:,} visible blocks for a page",
            hint="show fewer frames or a part of the scene",
        )
