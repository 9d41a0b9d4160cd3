"""Names of blocks that the game had once, or that people say, and how alike two names are."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence

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
