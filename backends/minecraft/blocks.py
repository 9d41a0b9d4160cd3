"""Grids of blocks, their decomposition into cuboids, and the blocks of one version of the game.

Cells have integer coordinates: x to the right (the game's east), y up, z as in the program (the game's south). A cell
``(x, y, z)`` is the unit cube with this minimum corner.
"""

from __future__ import annotations

import gzip
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import permutations
from typing import Any

import numpy as np
import numpy.typing as npt

Cells = npt.NDArray[np.uint32]
AIR = 0  # index of air in every palette
SIDES = ("north", "east", "south", "west")  # clockwise from above: +2 is opposite, +3 is left


@dataclass(frozen=True, slots=True, order=True)
class BlockState:
    """A block with its properties, sorted by name.

    For example ``minecraft:oak_stairs`` with ``(("facing", "north"), ("half", "top"))``.
    """

    name: str
    properties: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        """Return the game's notation: ``minecraft:oak_stairs[facing=north,half=top]``."""
        shown = ",".join(f"{name}={value}" for name, value in self.properties)
        return f"{self.name}[{shown}]" if shown else self.name


AIR_STATE = BlockState("minecraft:air")
# Blocks without content; when requested or read from a file they are treated as air.
NOTHING = frozenset({"minecraft:air", "minecraft:cave_air", "minecraft:void_air", "minecraft:structure_void"})


@dataclass(frozen=True, slots=True, eq=False)
class Build:
    """Blocks in a box of cells.

    ``cells[x, y, z]`` is the index in ``palette`` of the block at ``origin + (x, y, z)``. ``palette[0]`` is air; every
    other entry is unique and used.
    """

    origin: tuple[int, int, int]
    cells: Cells  # (X, Y, Z)
    palette: tuple[BlockState, ...]

    @property
    def size(self) -> tuple[int, int, int]:
        """Number of cells along x, y and z."""
        x, y, z = self.cells.shape
        return x, y, z


# Greedy merging: the cells of a grid as few uniform cuboids. Cells are merged into runs along z, runs into sheets along
# y, sheets into cuboids along x; other orders of the axes are tried too, and the result with the fewest cuboids is
# used.


IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

_BATCH_CELLS = 1 << 22  # cells processed per batch
# above this many cells, only one order of the axes is tried, since each order takes as long
_MAX_CELLS_FOR_ALL_ORDERS = 4_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Cuboids:
    """Disjoint uniform cuboids of cells: the cells ``low <= c < low + size`` are all ``number``.

    Sorted by y, z, x of ``low``: from the ground up.
    """

    low: IntArray  # (N, 3)
    size: IntArray  # (N, 3)
    number: IntArray  # (N,)

    def __len__(self) -> int:
        return len(self.number)


def merged(cells: Cells, along: BoolArray | None = None) -> Cuboids:
    """Return all cells (X, Y, Z) that are not AIR as cuboids, in cells from the grid's corner.

    ``along[n]`` (3,) selects the axes along which cells with index ``n`` may be merged; by default all.
    """
    candidates = [_merged(cells, (2, 1, 0), along)]
    if len(candidates[0]) > 1 and np.count_nonzero(cells) <= _MAX_CELLS_FOR_ALL_ORDERS:
        candidates += [_merged(cells, order, along) for order in permutations(range(3), 3) if order != (2, 1, 0)]
    best = min(candidates, key=len)
    order = np.lexsort((best.low[:, 0], best.low[:, 2], best.low[:, 1]))
    return _rows(best, order)


def _merged(cells: Cells, order: tuple[int, ...], along: BoolArray | None) -> Cuboids:
    """Return cells merged into runs, sheets and cuboids along the axes in ``order``."""
    first, second, third = order
    boxes = _runs(cells, first, along)
    return _joined(_joined(boxes, second, along), third, along)


def _runs(cells: Cells, axis: int, along: BoolArray | None) -> Cuboids:
    """Return the runs of equal indices along ``axis``."""
    lines = np.moveaxis(cells, axis, -1)
    slab = max(1, _BATCH_CELLS // max(1, lines[:1].size))
    lows, ends, numbers = [], [], []
    for start in range(0, len(lines), slab):
        part = lines[start : start + slab]
        begins = part != AIR
        same = part[..., 1:] == part[..., :-1]
        if along is not None:
            same &= along[part[..., 1:], axis]
        begins[..., 1:] &= ~same
        stops = part != AIR
        stops[..., :-1] &= ~same
        at = np.argwhere(begins)
        lows.append(at + np.array([start, 0, 0]))
        ends.append(np.nonzero(stops)[2] + 1)
        numbers.append(part[tuple(at.T)])
    rotated, end = np.concatenate(lows or [np.zeros((0, 3), np.int64)]), np.concatenate(ends or [np.zeros(0, np.int64)])
    low = np.empty_like(rotated)
    others = [a for a in range(3) if a != axis]
    low[:, others], low[:, axis] = rotated[:, :2], rotated[:, 2]
    size = np.ones_like(low)
    size[:, axis] = end - rotated[:, 2]
    return Cuboids(low, size, np.concatenate(numbers or [np.zeros(0, np.uint32)]).astype(np.int64))


def _joined(boxes: Cuboids, axis: int, along: BoolArray | None) -> Cuboids:
    """Merge boxes with equal cross-sections that are adjacent along ``axis``."""
    if len(boxes) < 2:
        return boxes
    b, c = (a for a in range(3) if a != axis)
    sides = (boxes.number, boxes.low[:, b], boxes.low[:, c], boxes.size[:, b], boxes.size[:, c])
    order = np.lexsort((boxes.low[:, axis], *sides))
    rows = _rows(boxes, order)
    same = rows.low[1:, axis] == rows.low[:-1, axis] + rows.size[:-1, axis]
    for side in sides:
        same &= side[order][1:] == side[order][:-1]
    if along is not None:
        same &= along[rows.number[1:], axis]
    begins = np.flatnonzero(np.concatenate(([True], ~same)))
    size = rows.size[begins]
    size[:, axis] = np.add.reduceat(rows.size[:, axis], begins)
    return Cuboids(rows.low[begins], size, rows.number[begins])


def _rows(boxes: Cuboids, rows: IntArray) -> Cuboids:
    """Return some of the boxes."""
    return Cuboids(boxes.low[rows], boxes.size[rows], boxes.number[rows])


# Normalisation of builds: a palette of distinct, used states, and the smallest bounding box.


def unified(origin: tuple[int, int, int], cells: Cells, states: Sequence[BlockState]) -> Build:
    """Return the build whose cell (x, y, z) is ``states[cells[x, y, z]]``, with a palette of distinct, used states."""
    used = numbers_in(cells, len(states))
    palette: dict[BlockState, int] = {AIR_STATE: AIR}
    number = np.zeros(len(states), np.uint32)
    for i in np.flatnonzero(used).tolist():
        number[i] = palette.setdefault(states[i], len(palette))
    renumbered = np.empty_like(cells)
    batch = _layers_per_batch(cells)
    for start in range(0, len(cells), batch):
        renumbered[start : start + batch] = number[cells[start : start + batch]]
    return Build(origin, renumbered, tuple(palette))


def trimmed(build: Build) -> Build:
    """Crop ``build`` to the smallest box that contains its blocks; empty if there are none."""
    box = smallest_box(build.cells)
    if not box[0].stop:
        return Build((0, 0, 0), np.zeros((0, 0, 0), np.uint32), (AIR_STATE,))
    x, y, z = (a + side.start for a, side in zip(build.origin, box))
    return Build((x, y, z), np.ascontiguousarray(build.cells[box]), build.palette)


def numbers_in(cells: Cells, count: int) -> npt.NDArray[np.bool_]:
    """Return the mask of the ``count`` indices that occur in some cell."""
    used = np.zeros(count, np.bool_)
    batch = _layers_per_batch(cells)
    for start in range(0, len(cells), batch):
        used |= np.bincount(cells[start : start + batch].reshape(-1), minlength=count) > 0
    return used


def smallest_box(cells: Cells) -> tuple[slice, slice, slice]:
    """Return the smallest box that contains every block; empty slices at 0 without blocks."""
    is_used = [np.zeros(n, np.bool_) for n in cells.shape]
    batch = _layers_per_batch(cells)
    for start in range(0, len(cells), batch):
        solid = cells[start : start + batch] != AIR
        is_used[0][start : start + batch] = solid.any(axis=(1, 2))
        is_used[1] |= solid.any(axis=(0, 2))
        is_used[2] |= solid.any(axis=(0, 1))
    x, y, z = (np.flatnonzero(axis) for axis in is_used)
    return _span(x), _span(y), _span(z)


def _span(places: npt.NDArray[np.int64]) -> slice:
    """Return the slice from the first to the last of ascending positions; empty for none."""
    return slice(int(places[0]), int(places[-1]) + 1) if len(places) else slice(0, 0)


def _layers_per_batch(cells: Cells) -> int:
    """Return the number of layers along x that fit a batch."""
    return max(1, _BATCH_CELLS // max(1, cells[:1].size))


# Blocks that only operators can place, or that do not exist on their own: never used as replacements.
_FOR_OPERATORS = frozenset({
    "command_block", "repeating_command_block", "chain_command_block", "structure_block", "structure_void", "jigsaw",
    "barrier", "light", "test_block", "test_instance_block", "moving_piston", "piston_head", "end_portal",
    "nether_portal", "end_gateway", "spawner", "trial_spawner", "vault", "bubble_column", "fire", "soul_fire",
    "air", "cave_air", "void_air",
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class BlockKind:
    """Properties of a block.

    ``shape``: air, cube (full block), slab, stairs, pane, fence, gate, wall, door, trapdoor, fluid, plant (crossed
    planes), thin (no collision) or box. ``box``: the collision box of the default state in sixteenths of the cell (min
    x, y, z, max x, y, z), None without collision. ``color``: the average of its faces, sRGB from 0 to 255, None if
    invisible; ``opacity`` from 0 to 1. ``light``: the emitted light level, from 0 to 15. ``transparent``: whether light
    passes through. ``values`` are the possible values of each property, ``defaults`` the default values.
    """

    name: str
    shape: str
    color: tuple[int, int, int] | None
    opacity: float
    light: int
    transparent: bool
    hardness: float
    box: tuple[int, int, int, int, int, int] | None
    values: Mapping[str, tuple[str, ...]]
    defaults: Mapping[str, str]

    @property
    def is_for_operators(self) -> bool:
        """Whether the block is a command block, structure block or the like, or is placed only by the game."""
        return self.name.removeprefix("minecraft:") in _FOR_OPERATORS

    def allows(self, state: BlockState) -> bool:
        """Return whether ``state`` has exactly this block's properties, each with a possible value."""
        properties = dict(state.properties)
        return properties.keys() == self.values.keys() and all(
            properties[name] in self.values[name] for name in properties
        )


@dataclass(frozen=True, slots=True)
class BlockTable:
    """Blocks of a version by their full name, ``minecraft:stone``; ``data_version`` is its number in files."""

    version: str
    data_version: int
    blocks: Mapping[str, BlockKind]


@cache
def load_table() -> BlockTable:
    """Return the table included in the package."""
    packed = files("scenelang.backends.minecraft").joinpath("blocks.tsv.gz").read_bytes()
    head, *lines = gzip.decompress(packed).decode("ascii").splitlines()
    _, version, data_version = head.split("\t")
    kinds = [_kind(line.split("\t")) for line in lines]
    return BlockTable(version, int(data_version), {kind.name: kind for kind in kinds})


def _kind(fields: list[str]) -> BlockKind:
    """Return the block of a line of the table; ``extract.write_table`` writes these lines."""
    name, shape, color, opacity, light, transparent, hardness, box, properties = fields
    values: dict[str, tuple[str, ...]] = {}
    defaults: dict[str, str] = {}
    for pair in properties.split():
        key, listed = pair.split("=")
        values[key] = tuple(value.rstrip("*") for value in listed.split("|"))
        defaults[key] = next(value[:-1] for value in listed.split("|") if value.endswith("*"))
    sides = [int(n) for n in box.split(",")] if box else []
    return BlockKind(
        f"minecraft:{name}",
        shape,
        (int(color[:2], 16), int(color[2:4], 16), int(color[4:], 16)) if color else None,
        float(opacity),
        int(light),
        transparent == "1",
        float(hardness),
        (sides[0], sides[1], sides[2], sides[3], sides[4], sides[5]) if sides else None,
        values,
        defaults,
    )


# Former and colloquial names of blocks, and similarity of names.


# The game's own renames: old name, new name. The one that the version has is used.
RENAMES = (
    ("chain", "iron_chain"), ("grass", "short_grass"), ("grass_path", "dirt_path"), ("sign", "oak_sign"),
    ("wall_sign", "oak_wall_sign"), ("standing_sign", "oak_sign"), ("fence", "oak_fence"),
    ("fence_gate", "oak_fence_gate"), ("wooden_door", "oak_door"), ("trapdoor", "oak_trapdoor"),
    ("wooden_button", "oak_button"), ("wooden_pressure_plate", "oak_pressure_plate"), ("melon_block", "melon"),
    ("lit_pumpkin", "jack_o_lantern"), ("hardened_clay", "terracotta"), ("snow_layer", "snow"),
    ("waterlily", "lily_pad"), ("yellow_flower", "dandelion"), ("red_flower", "poppy"), ("web", "cobweb"),
    ("brick_block", "bricks"), ("nether_brick", "nether_bricks"), ("red_nether_brick", "red_nether_bricks"),
    ("end_bricks", "end_stone_bricks"), ("quartz_ore", "nether_quartz_ore"), ("deadbush", "dead_bush"),
    ("noteblock", "note_block"), ("golden_rail", "powered_rail"), ("stonebrick", "stone_bricks"),
    ("reeds", "sugar_cane"), ("mob_spawner", "spawner"), ("slime", "slime_block"), ("magma", "magma_block"),
    ("tallgrass", "short_grass"), ("double_plant", "sunflower"), ("lit_redstone_lamp", "redstone_lamp"),
    ("stained_hardened_clay", "terracotta"),
    ("flowing_water", "water"), ("flowing_lava", "lava"), ("stone_stairs", "cobblestone_stairs"),
)  # fmt: skip
_RENAMED_STARTS = (("silver_", "light_gray_"),)

# Colloquial names of blocks; whole names first, then words within names.
ALIASES = {
    "marble": "quartz_block", "wood": "oak_planks", "planks": "oak_planks", "log": "oak_log", "leaves": "oak_leaves",
    "sapling": "oak_sapling", "stairs": "oak_stairs", "slab": "stone_slab", "door": "oak_door", "bed": "red_bed",
    "wool": "white_wool", "concrete": "white_concrete", "carpet": "white_carpet", "banner": "white_banner",
    "stained_glass": "white_stained_glass", "stained_glass_pane": "white_stained_glass_pane", "brick": "bricks",
    "wall": "cobblestone_wall", "lamp": "redstone_lamp", "steel": "iron_block", "metal": "iron_block",
    "iron": "iron_block", "gold": "gold_block", "diamond": "diamond_block", "emerald": "emerald_block",
    "lapis": "lapis_block", "coal": "coal_block", "copper": "copper_block", "quartz": "quartz_block",
    "soil": "dirt", "earth": "dirt", "road": "dirt_path", "path": "dirt_path", "flower": "poppy", "rose": "poppy",
    "hay": "hay_block", "hay_bale": "hay_block", "tree": "oak_log", "asphalt": "black_concrete",
    "cement": "light_gray_concrete", "plaster": "white_terracotta", "pane": "glass_pane", "bars": "iron_bars",
    "window": "glass_pane", "cloud": "white_wool", "red_brick": "bricks", "red_bricks": "bricks",
    "white_brick": "quartz_bricks", "white_bricks": "quartz_bricks", "gray_bricks": "stone_bricks",
    "fern_block": "moss_block", "mushroom": "red_mushroom",
    "roof_tiles": "bricks", "workbench": "crafting_table", "pillar": "quartz_pillar", "button": "oak_button",
    "pressure_plate": "oak_pressure_plate", "head": "player_head", "coral": "tube_coral",
}  # fmt: skip
_WORDS = {"wooden": "oak", "wood": "oak", "marble": "quartz", "grey": "gray", "steel": "iron", "golden": "gold"}


_COLORS = (
    "white", "orange", "magenta", "light_blue", "yellow", "lime", "pink", "gray", "light_gray", "cyan", "purple",
    "blue", "brown", "green", "red", "black",
)  # fmt: skip
_WOODS = ("oak", "spruce", "birch", "jungle", "acacia", "dark_oak")
_STONES = ("stone", "granite", "polished_granite", "diorite", "polished_diorite", "andesite", "polished_andesite")
_NUMBERED = re.compile(r"([a-z_]+):(\d{1,2})")  # numeric variants before 1.13: wool:14
_OF_COLORS = ("wool", "concrete", "concrete_powder", "carpet", "stained_glass", "stained_glass_pane", "terracotta")
_OF_WOODS = ("planks", "log", "leaves", "sapling", "wooden_slab")


def without_number(name: str) -> str:
    """Convert a name with a numeric variant, from before 1.13: ``wool:14`` becomes ``red_wool``.

    Unknown numbers are dropped. The name has no namespace.
    """
    match = _NUMBERED.fullmatch(name)
    if match is None:
        return name
    kind, number = match[1], int(match[2])
    kind = {"stained_hardened_clay": "terracotta"}.get(kind, kind)
    if kind in _OF_COLORS and number < len(_COLORS):
        return f"{_COLORS[number]}_{kind}"
    if kind in _OF_WOODS and number < len(_WOODS):
        return f"{_WOODS[number]}_{kind.removeprefix('wooden_')}"
    return _STONES[number] if kind == "stone" and number < len(_STONES) else kind


def renamed(name: str, known: Collection[str]) -> str | None:
    """Return the renamed block ``name`` in a version with the ``known`` names, None if it was not renamed."""
    for old, new in RENAMES:
        for candidate, other in ((old, new), (new, old)):
            if name == candidate and other in known:
                return other
    for old, new in _RENAMED_STARTS:
        for candidate, other in ((old, new), (new, old)):
            if name.startswith(candidate) and other + name.removeprefix(candidate) in known:
                return other + name.removeprefix(candidate)
    return None


def alias(name: str, known: Collection[str]) -> str | None:
    """Return the known block for a colloquial name, None if there is no alias."""
    if ALIASES.get(name) in known:
        return ALIASES[name]
    words = "_".join(_WORDS.get(word, word) for word in name.split("_"))
    for candidate in (words, f"{words}s", f"{words}_block", words.removesuffix("_block"), ALIASES.get(words, "")):
        if candidate != name and candidate in known:
            return candidate
    return None


def nearest(name: str, candidates: Sequence[str]) -> tuple[str, float]:
    """Return the most similar candidate, the first of equals, and the similarity of their letters from 0 to 1."""
    scored = ((_likeness(name, candidate), candidate) for candidate in candidates)
    _, best = max(scored, key=lambda pair: pair[0])
    return best, jaro_winkler(name, best)


def _likeness(a: str, b: str) -> float:
    """Return the similarity of two block names: mainly letters in order (Jaro-Winkler), partly whole words.

    The last word is the type of the block and counts extra.
    """
    first, second = a.split("_"), b.split("_")
    shared = len(set(first) & set(second)) / max(len(first), len(second))
    return 0.7 * jaro_winkler(a, b) + 0.2 * shared + 0.1 * (first[-1] == second[-1])


def jaro_winkler(a: str, b: str) -> float:
    """Return the Jaro-Winkler similarity of two strings, from 0 to 1; 1 only for equal strings.

    Source: Winkler, "String comparator metrics and enhanced decision rules in the Fellegi-Sunter model", 1990.
    """
    if not a or not b:
        return float(a == b)
    matches = list(_matches(a, b))
    if not matches:
        return 0.0
    matched_letters = [b[j] for j in sorted(j for _, j in matches)]
    transpositions = sum(a[i] != letter for (i, _), letter in zip(matches, matched_letters)) / 2
    count = len(matches)
    jaro = (count / len(a) + count / len(b) + (count - transpositions) / count) / 3.0
    prefix = next((i for i, (x, y) in enumerate(zip(a[:4], b[:4])) if x != y), min(4, len(a), len(b)))
    return jaro + 0.1 * prefix * (1.0 - jaro)


def _matches(a: str, b: str) -> Iterator[tuple[int, int]]:
    """Yield positions of equal letters within the matching window, each used once, in the order of ``a``."""
    reach = max(0, max(len(a), len(b)) // 2 - 1)
    free = [True] * len(b)
    for i, letter in enumerate(a):
        for j in range(max(0, i - reach), min(len(b), i + reach + 1)):
            if free[j] and b[j] == letter:
                free[j] = False
                yield i, j
                break


# Models that the game draws for a block state, from the block's definition (``blockstates/NAME.json``).


def variants(definition: Mapping[str, Any], properties: Mapping[str, str], every: bool = False) -> Iterator[Any]:
    """Yield the variants applied to a state, each with its ``model``; those of all states with ``every``.

    Of models that the game selects at random, the first.
    """
    for key, variant in definition.get("variants", {}).items():
        required = dict(pair.split("=", 1) for pair in key.split(",") if "=" in pair)
        if every or all(properties.get(name) == value for name, value in required.items()):
            yield _first(variant)
    for part in definition.get("multipart", []):
        if every or _matches_condition(part.get("when", {}), properties):
            yield _first(part["apply"])


def _first(variant: Any) -> Any:
    """Return the first of several variants, or the variant itself."""
    return variant[0] if isinstance(variant, list) else variant


def _matches_condition(when: Mapping[str, Any], properties: Mapping[str, str]) -> bool:
    """Return whether properties satisfy the condition of a part of a multipart definition."""
    if "OR" in when:
        return any(_matches_condition(condition, properties) for condition in when["OR"])
    if "AND" in when:
        return all(_matches_condition(condition, properties) for condition in when["AND"])
    return all(properties.get(key) in str(value).split("|") for key, value in when.items())
