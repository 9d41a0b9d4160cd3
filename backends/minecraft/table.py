"""The blocks of one version of the game, read from the table that ``extract`` wrote."""

from __future__ import annotations

import gzip
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from scenelang.backends.minecraft.blocks import BlockState

# What only operators can place, or what is no block of its own: never laid in place of another block.
_FOR_OPERATORS = frozenset({
    "command_block", "repeating_command_block", "chain_command_block", "structure_block", "structure_void", "jigsaw",
    "barrier", "light", "test_block", "test_instance_block", "moving_piston", "piston_head", "end_portal",
    "nether_portal", "end_gateway", "spawner", "trial_spawner", "vault", "bubble_column", "fire", "soul_fire",
    "air", "cave_air", "void_air",
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class BlockKind:
    """What is known of a block.

    ``shape``: air, cube (one whole cell), slab, stairs, pane, fence, gate, wall, door, trapdoor, fluid, plant (crossed
    planes), thin (nothing that stops a walker) or box. ``box``: what stops one, in sixteenths of the cell (min x, y, z,
    max x, y, z), of the default state; None where nothing does. ``color``: the average of its faces, sRGB from 0 to
    255, None where nothing is drawn; ``opacity`` from 0 to 1. ``light``: that it gives, from 0 to 15. ``transparent``:
    light goes through. ``values`` are the possible values of each property, ``defaults`` what it has otherwise.
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
        """True for commands, structures and the like, and for what the game alone places."""
        return self.name.removeprefix("minecraft:") in _FOR_OPERATORS

    def allows(self, state: BlockState) -> bool:
        """True where ``state`` has exactly this block's properties, each with a possible value."""
        given = dict(state.properties)
        return given.keys() == self.values.keys() and all(given[name] in self.values[name] for name in given)


@dataclass(frozen=True, slots=True)
class BlockTable:
    """Every block of a version by its full name, ``minecraft:stone``; ``data_version`` is what files call it."""

    version: str
    data_version: int
    blocks: Mapping[str, BlockKind]


@cache
def load_table() -> BlockTable:
    """The table that comes with the package."""
    packed = files("scenelang.backends.minecraft").joinpath("blocks.tsv.gz").read_bytes()
    head, *lines = gzip.decompress(packed).decode("ascii").splitlines()
    _, version, data_version = head.split("\t")
    kinds = [_kind(line.split("\t")) for line in lines]
    return BlockTable(version, int(data_version), {kind.name: kind for kind in kinds})


def _kind(fields: list[str]) -> BlockKind:
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


# Names of blocks that the game had once, or that people say, and how alike two names are.


# The game's own renames: the older name, the newer one. Whichever the version knows is meant.
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

# What people say for blocks that the game calls otherwise, whole names first, then words within names.
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
_NUMBERED = re.compile(r"([a-z_]+):(\d{1,2})")  # as before 1.13: wool:14
_OF_COLORS = ("wool", "concrete", "concrete_powder", "carpet", "stained_glass", "stained_glass_pane", "terracotta")
_OF_WOODS = ("planks", "log", "leaves", "sapling", "wooden_slab")


def without_number(name: str) -> str:
    """A name from before 1.13 as it is today: ``wool:14`` as ``red_wool``; other numbers mean nothing. The name has no
    namespace."""
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
    """What the game calls the block ``name`` in the version that has the ``known`` names; None for no rename."""
    for old, new in RENAMES:
        for one, other in ((old, new), (new, old)):
            if name == one and other in known:
                return other
    for old, new in _RENAMED_STARTS:
        for one, other in ((old, new), (new, old)):
            if name.startswith(one) and other + name.removeprefix(one) in known:
                return other + name.removeprefix(one)
    return None


def alias(name: str, known: Collection[str]) -> str | None:
    """The known block that people mean by ``name``; None for no alias."""
    if ALIASES.get(name) in known:
        return ALIASES[name]
    words = "_".join(_WORDS.get(word, word) for word in name.split("_"))
    for candidate in (words, f"{words}s", f"{words}_block", words.removesuffix("_block"), ALIASES.get(words, "")):
        if candidate != name and candidate in known:
            return candidate
    return None


def nearest(name: str, candidates: Sequence[str]) -> tuple[str, float]:
    """The candidate that is most alike, the first of several, and how alike their letters are from 0 to 1."""
    scored = ((_likeness(name, candidate), candidate) for candidate in candidates)
    _, best = max(scored, key=lambda pair: pair[0])
    return best, jaro_winkler(name, best)


def _likeness(a: str, b: str) -> float:
    """Mostly letters in their order (Jaro-Winkler), partly whole words, the last of which says what a block is."""
    first, second = a.split("_"), b.split("_")
    shared = len(set(first) & set(second)) / max(len(first), len(second))
    return 0.7 * jaro_winkler(a, b) + 0.2 * shared + 0.1 * (first[-1] == second[-1])


def jaro_winkler(a: str, b: str) -> float:
    """The Jaro-Winkler likeness of two texts, from 0 to 1; 1 only for equal texts."""
    if not a or not b:
        return float(a == b)
    places = list(_matches(a, b))
    if not places:
        return 0.0
    in_order = [b[j] for j in sorted(j for _, j in places)]
    swapped = sum(a[i] != letter for (i, _), letter in zip(places, in_order)) / 2
    count = len(places)
    jaro = (count / len(a) + count / len(b) + (count - swapped) / count) / 3.0
    prefix = next((i for i, (x, y) in enumerate(zip(a[:4], b[:4])) if x != y), min(4, len(a), len(b)))
    return jaro + 0.1 * prefix * (1.0 - jaro)


def _matches(a: str, b: str) -> Iterator[tuple[int, int]]:
    """Places of equal letters that are near one another, each used once, in the order of ``a``."""
    reach = max(0, max(len(a), len(b)) // 2 - 1)
    free = [True] * len(b)
    for i, letter in enumerate(a):
        for j in range(max(0, i - reach), min(len(b), i + reach + 1)):
            if free[j] and b[j] == letter:
                free[j] = False
                yield i, j
                break


# Which models the game draws for a state of a block, from the block's definition (``blockstates/NAME.json``).


def variants(definition: Mapping[str, Any], properties: Mapping[str, str], every: bool = False) -> Iterator[Any]:
    """What is applied for a state, each with its ``model``; of all states where ``every``. Of models among which the
    game chooses by chance, the first."""
    for key, variant in definition.get("variants", {}).items():
        wanted = dict(pair.split("=", 1) for pair in key.split(",") if "=" in pair)
        if every or all(properties.get(name) == value for name, value in wanted.items()):
            yield _first(variant)
    for part in definition.get("multipart", []):
        if every or _holds(part.get("when", {}), properties):
            yield _first(part["apply"])


def _first(variant: Any) -> Any:
    return variant[0] if isinstance(variant, list) else variant


def _holds(when: Mapping[str, Any], properties: Mapping[str, str]) -> bool:
    if "OR" in when:
        return any(_holds(each, properties) for each in when["OR"])
    if "AND" in when:
        return all(_holds(each, properties) for each in when["AND"])
    return all(properties.get(key) in str(value).split("|") for key, value in when.items())
