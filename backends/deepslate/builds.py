"""The builds of a scene's frames, as the page draws them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import AIR, AIR_STATE, BlockState, Build
from scenelang.backends.minecraft.connections import settled
from scenelang.backends.minecraft.table import BlockKind, load_table
from scenelang.backends.minecraft.voxels import voxelised
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.scene.entity import Entity

# Which blocks hold water: water itself, and what stands in it.


WATER_TEXTURES = ("minecraft:block/water_still", "minecraft:block/water_flow")
_WATER = frozenset({"minecraft:water", "minecraft:bubble_column"})
_PLANTS = frozenset({"minecraft:kelp", "minecraft:kelp_plant", "minecraft:seagrass", "minecraft:tall_seagrass"})


def is_water(state: BlockState) -> bool:
    """True for a cell of nothing but water."""
    return state.name in _WATER


def is_wet(state: BlockState) -> bool:
    """True for a block with water around it, such as a waterlogged fence."""
    return state.name in _PLANTS or ("waterlogged", "true") in state.properties


# The blocks of a build that can be seen: those with an open side, and what stands around them.


IntArray = npt.NDArray[np.int32]
ByteArray = npt.NDArray[np.uint8]

MOST_SEEN = 2_000_000  # blocks of one frame
CHUNK = 32  # cells along each side of what the page draws at once
SIDES = ((0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1), (-1, 0, 0), (1, 0, 0))  # down, up, north, south, west, east
AROUND = tuple(
    (x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)
)  # the page counts them in the same order
_SLAB = 1 << 22  # cells that are looked at together
_CLEAR = ("glass", "ice", "slime_block", "honey_block")  # no face between two of the same kind, as in the game
# A number for each state: 0 hides nothing, 1 is a solid cube. Of the others, those that are alike but for the last bit
# hide each other's sides; what stands in water is seen itself all the same.
_NO_FAMILY, _SOLID, _WATER_FAMILY, _WET, _OTHERS = 0, 1, 2, 3, 4


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Blocks in the order of chunks. ``cells`` (3, N): from the corner of ``origin``. ``states`` (N,): their numbers in
    the palette. ``around`` (N,): bit ``k`` below 26 is set where a solid cube stands at ``AROUND[k]``, bit ``26 + k``
    where side ``SIDES[k]`` is hidden (of what stands in water, the water's side)."""

    cells: IntArray
    states: npt.NDArray[np.uint32]
    around: npt.NDArray[np.uint32]


def seen(build: Build, corner: tuple[int, int, int]) -> Seen:
    """The blocks of ``build`` with an open side, in cells from ``corner``; raises LimitError for too many."""
    family = _families(build.palette)
    padded = np.zeros(tuple(n + 2 for n in build.size), np.uint8)
    inside = padded[1:-1, 1:-1, 1:-1]
    slab = max(1, _SLAB // max(1, build.cells[:1].size))
    for start in range(0, len(inside), slab):
        inside[start : start + slab] = family[build.cells[start : start + slab]]
    at = _open(build, padded, slab)
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
    """Where a side between two families is not drawn; of what stands in water, the water's side."""
    return np.asarray((other == _SOLID) | ((own > _SOLID) & (own >> 1 == other >> 1)))


def _is_solid(state: BlockState, kind: BlockKind) -> bool:
    whole = kind.shape == "cube" or ("type", "double") in state.properties
    return whole and not kind.transparent and kind.opacity == 1.0


def _is_clear(name: str, kind: BlockKind) -> bool:
    return kind.shape == "fluid" or (kind.shape == "cube" and name.endswith(_CLEAR))


def _open(build: Build, padded: ByteArray, slab: int) -> npt.NDArray[np.int64]:
    """The cells (3, N) of blocks with a side that no neighbour hides."""
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
        if count > MOST_SEEN:
            raise LimitError(
                "size",
                f"more than {MOST_SEEN:,} blocks of the build can be seen, more than one picture of it may show",
                hint="draw a part of the scene, or draw it with another backend",
            )
        parts.append(at)
    return np.concatenate(parts, axis=1)


def _beside(padded: ByteArray, at: npt.NDArray[np.int64], step: tuple[int, int, int]) -> ByteArray:
    return np.asarray(padded[tuple(at + 1 + np.array(step)[:, None])], np.uint8)


MOST_IN_ALL = 8_000_000  # blocks that can be seen, in all frames


@dataclass(frozen=True, slots=True, eq=False)
class Builds:
    """``frames[n]``: what is seen of frame ``n``, in cells from ``corner``, its states numbered as in ``palette``.
    ``warnings``: what was replaced or left out."""

    frames: Mapping[int, Seen]
    corner: tuple[int, int, int]
    palette: tuple[BlockState, ...]
    warnings: tuple[Diagnostic, ...]

    @property
    def box(self) -> tuple[list[int], list[int]]:
        """The low and high corner of what is seen in any frame, in cells from ``corner``."""
        cells = [seen.cells for seen in self.frames.values() if len(seen.states)]
        low = np.min([each.min(axis=1) for each in cells], axis=0)
        high = np.max([each.max(axis=1) for each in cells], axis=0) + 1
        return low.tolist(), high.tolist()


def builds_of(roots: Mapping[int, Entity], limit: int) -> Builds:
    """The builds of frames by number; entities that frames share are laid once.

    Raises SceneError where there are no blocks, or they cannot be laid, and LimitError.
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
            "the scene lays no blocks, so there is nothing to show with the game's looks",
            hint="lay blocks with `set-cuboid`, or draw the scene with another backend",
        )
    return Builds(frames, corner, tuple(palette), tuple(warnings.values()))


def _renumbered(found: Seen, build: Build, palette: dict[BlockState, int]) -> Seen:
    numbers = np.array([palette.setdefault(state, len(palette)) for state in build.palette], np.uint32)
    return replace(found, states=numbers[found.states])


def _check(count: int) -> None:
    if count > MOST_IN_ALL:
        raise LimitError(
            "size",
            f"more than {MOST_IN_ALL:,} blocks can be seen in all frames, more than one page may show",
            hint="show fewer frames or a part of the scene",
        )
