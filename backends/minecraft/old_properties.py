"""Properties that blocks had in earlier versions of the game, or that another block has now: what they mean today.

A rule applies only where the block that the version knows does not take the property as it is given, so that nothing
that is right today is changed. The properties that were dropped or given to another block since 1.13 are those of
`history.tsv.gz`; before 1.13, kinds of one block were properties of it: its colour, wood or stone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from scenelang.backends.minecraft.table import BlockKind, BlockTable, renamed
from scenelang.backends.minecraft.voxels import NAMESPACE

_KINDS = ("variant", "type", "color", "wood_type", "material", "block_type")  # what told kinds of a block apart
_STANDING = ("torch", "redstone_torch", "soul_torch", "copper_torch")
_WALLS = {"true": "low", "false": "none"}  # until 1.16 an arm was there or not
_SAID = {"silver": "light_gray", "wood_old": "oak", "normal": "", "default": "", "all": "", "y": ""}
_FAMILIES = (  # blocks whose kinds had names of their own
    "stone", "dirt", "sand", "planks", "log", "tallgrass", "short_grass", "double_plant", "sunflower", "red_flower",
    "poppy", "yellow_flower", "dandelion", "prismarine", "stonebrick", "stone_bricks", "quartz_block",
)  # fmt: skip
_WHOLE = {
    ("quartz_block", "lines_x"): ("quartz_pillar", ("axis", "x")),
    ("quartz_block", "lines_y"): ("quartz_pillar", ("axis", "y")),
    ("quartz_block", "lines_z"): ("quartz_pillar", ("axis", "z")),
    ("stonebrick", "mossy_stonebrick"): ("mossy_stone_bricks", None),
    ("stonebrick", "cracked_stonebrick"): ("cracked_stone_bricks", None),
    ("stonebrick", "chiseled_stonebrick"): ("chiseled_stone_bricks", None),
    ("dirt", "podzol"): ("podzol", None),
    ("stone_slab", "wood_old"): ("petrified_oak_slab", None),
    ("sandstone", "smooth_sandstone"): ("cut_sandstone", None),
    ("red_sandstone", "smooth_red_sandstone"): ("cut_red_sandstone", None),
    ("prismarine", "dark_prismarine"): ("dark_prismarine", None),
    ("prismarine", "prismarine_bricks"): ("prismarine_bricks", None),
    ("tallgrass", "dead_bush"): ("dead_bush", None),
    ("double_plant", "syringa"): ("lilac", None),
    ("double_plant", "double_rose"): ("rose_bush", None),
    ("double_plant", "paeonia"): ("peony", None),
    ("double_plant", "double_grass"): ("tall_grass", None),
    ("double_plant", "double_fern"): ("large_fern", None),
    ("red_flower", "houstonia"): ("azure_bluet", None),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Modern:
    """A block as the version has it: its ``kind``, the properties that it takes, and those of the given ones that mean
    nothing to it."""

    kind: BlockKind
    given: dict[str, str]
    dropped: dict[str, str]


def modern(name: str, kind: BlockKind, given: Mapping[str, str], table: BlockTable) -> Modern:
    """What the block asked for as ``name``, which the version has as ``kind``, is with the properties ``given``."""
    kept: dict[str, str] = {}
    dropped: dict[str, str] = {}
    for key, value in sorted(given.items(), key=lambda pair: pair[0] not in _KINDS):  # which block it is comes first
        if value in kind.values.get(key, ()):
            kept[key] = value
            continue
        change = _moved(name, kind, key, value, table)
        if change is None:
            dropped[key] = value
            continue
        kind, more = change
        kept |= more
    late = {key: value for key, value in kept.items() if value not in kind.values.get(key, ())}
    return Modern(kind, {key: value for key, value in kept.items() if key not in late}, dropped | late)


Change = tuple[BlockKind, dict[str, str]]


def _moved(name: str, kind: BlockKind, key: str, value: str, table: BlockTable) -> Change | None:
    """The block that now has what ``key`` said of the block, and the properties that say it there; None where there is
    none."""
    plain = kind.name.removeprefix(NAMESPACE)
    if key in _KINDS:
        return _kind_of(name.removeprefix(NAMESPACE), plain, value, table)
    if plain == "cauldron" and key == "level":  # filled ones are blocks of their own since 1.17
        filled = table.blocks.get(NAMESPACE + "water_cauldron")
        if value == "0":
            return kind, {}
        return (filled, {"level": value}) if filled is not None and value in filled.values.get("level", ()) else None
    if plain in _STANDING and key == "facing":
        return _torch(kind, plain, value, table)
    if plain == "sponge" and key == "wet":
        wet = table.blocks.get(NAMESPACE + "wet_sponge")
        return (kind, {}) if value == "false" else (wet, {}) if wet is not None and value == "true" else None
    if key == "axis" and value == "none" and plain.endswith("_log"):
        bark = table.blocks.get(NAMESPACE + plain.removesuffix("log") + "wood")
        return None if bark is None else (bark, {})
    same = dict(_renamed(kind, key, value))
    return (kind, same) if same and all(v in kind.values.get(k, ()) for k, v in same.items()) else None


def _renamed(kind: BlockKind, key: str, value: str) -> Iterator[tuple[str, str]]:
    """The property of the same block that says today what ``key`` did."""
    if key in kind.values and value in _WALLS:
        yield key, _WALLS[value]
    elif key == "half" and kind.shape == "slab":
        yield "type", value
    elif key == "half" and value in ("top", "bottom", "upper", "lower"):
        yield "half", {"top": "upper", "bottom": "lower", "upper": "top", "lower": "bottom"}[value]
    elif key == "decayable":
        yield "persistent", {"true": "false", "false": "true"}.get(value, "")
    elif key == "facing" and value in ("up", "down") and "face" in kind.values:
        yield "face", {"up": "floor", "down": "ceiling"}[value]
    elif key == "rotation" and "facing" in kind.values and value.isdecimal() and int(value) < 16:
        yield "facing", ("south", "west", "north", "east")[(int(value) + 2) // 4 % 4]
    elif key == "facing" and "rotation" in kind.values and value in ("south", "west", "north", "east"):
        yield "rotation", str(4 * ("south", "west", "north", "east").index(value))
    elif key == "facing" and "axis" in kind.values and "facing" not in kind.values:
        yield "axis", {"north": "z", "south": "z", "east": "x", "west": "x"}.get(value, "y")
    elif key == "axis" and "facing" in kind.values and value in "xyz":
        yield "facing", {"x": "east", "y": "up", "z": "south"}[value]


def _torch(kind: BlockKind, plain: str, value: str, table: BlockTable) -> Change | None:
    """Torches on walls are blocks of their own since 1.13."""
    if value == "up":
        return kind, {}
    wall = f"{plain.removesuffix('torch')}wall_torch"
    on_wall = table.blocks.get(NAMESPACE + wall)
    return (on_wall, {"facing": value}) if on_wall is not None and value in on_wall.values["facing"] else None


def _kind_of(asked: str, plain: str, value: str, table: BlockTable) -> Change | None:
    """The block that is the kind ``value`` of the block ``asked``, which is called ``plain`` today."""
    value = value.replace(" ", "_")
    whole = _WHOLE.get((asked, value)) or _WHOLE.get((plain, value))
    if whole is not None:
        found = table.blocks.get(NAMESPACE + whole[0])
        return None if found is None else (found, dict([whole[1]] if whole[1] is not None else []))
    said = _SAID.get(value, value)
    if not said:
        return table.blocks[NAMESPACE + plain], {}
    for base in dict.fromkeys((plain, asked)):
        for name in _named(said, base):
            full = NAMESPACE + name if NAMESPACE + name in table.blocks else None
            if full is None:
                newer = renamed(name, {known.removeprefix(NAMESPACE) for known in table.blocks})
                full = None if newer is None else NAMESPACE + newer
            if full is not None:
                return table.blocks[full], {}
    return None


def _named(value: str, base: str) -> Iterator[str]:
    """How a block may be called that is the kind ``value`` of ``base``, the likeliest first."""
    last = base.rpartition("_")[2]
    yield f"{value}_{base}"
    if "smooth_" in value:
        yield value.replace("smooth_", "polished_")
    for word in ("oak_", "white_", "red_", "stone_", "cobblestone_"):
        if base.startswith(word):
            yield f"{value}_{base.removeprefix(word)}"
    yield f"{value}_{last}"
    if value.endswith(("s", "es")):
        yield f"{value.removesuffix('s')}_{last}"
    if base in _FAMILIES:
        yield value
