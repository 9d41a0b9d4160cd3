"""What a file of a build holds once it is read."""

from __future__ import annotations

import gzip
import json
import re
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.files import write_text, written_together, written_whole
from scenelang.backends.minecraft.blocks import AIR, AIR_STATE, NOTHING, BlockState, Build, merged, trimmed, unified
from scenelang.backends.minecraft.nbt import (
    Compounds,
    Damaged,
    Long,
    Short,
    Triple,
    array,
    checked_size,
    compound,
    from_packed_longs,
    from_varints,
    how_many,
    listed,
    packed_longs,
    triple_of_array,
    triple_of_compound,
    varints,
    whole,
    write_nbt,
)
from scenelang.backends.minecraft.table import RENAMES, load_table
from scenelang.backends.minecraft.voxels import NAMESPACE
from scenelang.grammar.diagnostics import Diagnostic, SceneError, suggest


@dataclass(frozen=True, slots=True)
class Lost:
    """How many things of a file a build cannot hold: what is inside blocks (the contents of chests, the text of signs)
    and entities (animals, item frames, boats)."""

    block_entities: int = 0
    entities: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class LoadedBuild:
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


# Block states as files name them.


_NAME = re.compile(r"(?:[a-z0-9_.-]+:)?[a-z0-9_./-]+")
_WORD = re.compile(r"[a-z0-9_]+")
_LONGEST = 200  # letters of a name
_MOST = 64  # properties of one block


def state_of_text(text: str) -> BlockState:
    """The state that is written ``minecraft:oak_log[axis=x]``; raises Damaged."""
    name, bracket, rest = text.partition("[")
    if bracket and not rest.endswith("]"):
        raise Damaged(f"`{text[:60]}` is no block")
    pairs = [pair.partition("=") for pair in rest[:-1].split(",") if pair]
    return _state(name, {key: value for key, _, value in pairs})


def state_of_tag(tag: Any) -> BlockState:
    """The state of a compound with ``Name`` and ``Properties``; raises Damaged."""
    name = tag.get("Name") if isinstance(tag, dict) else None
    properties = tag.get("Properties", {}) if isinstance(tag, dict) else None
    if not isinstance(name, str) or not isinstance(properties, dict):
        raise Damaged("an entry of its palette is no block")
    return _state(name, properties)


def tag_of_state(state: BlockState) -> dict[str, Any]:
    """The compound that ``state_of_tag`` reads."""
    tag: dict[str, Any] = {"Name": state.name}
    return {**tag, "Properties": dict(state.properties)} if state.properties else tag


def _state(name: str, properties: Mapping[str, Any]) -> BlockState:
    if len(name) > _LONGEST or not _NAME.fullmatch(name):
        raise Damaged(f"`{name[:60]}` is no name of a block")
    if len(properties) > _MOST:
        raise Damaged(f"`{name}` has {len(properties)} properties")
    for pair in properties.items():
        if not all(isinstance(word, str) and len(word) <= _LONGEST and _WORD.fullmatch(word) for word in pair):
            raise Damaged(f"`{name}` has a property that is none")
    full = name if ":" in name else NAMESPACE + name
    if full in NOTHING:
        return AIR_STATE
    return BlockState(full, tuple(sorted(properties.items())))


# Versions of the game, and what its files call them.


# Data versions are those of npm's minecraft-data 3.117 (common/protocolVersions.json), formats of data packs those of
# the table at https://minecraft.wiki/w/Pack_format; the game counts minor formats since 1.21.9.
_RELEASES = """
1.13 1519 4, 1.13.1 1628 4, 1.13.2 1631 4, 1.14 1952 4, 1.14.1 1957 4, 1.14.2 1963 4, 1.14.3 1968 4, 1.14.4 1976 4,
1.15 2225 5, 1.15.1 2227 5, 1.15.2 2230 5, 1.16 2566 5, 1.16.1 2567 5, 1.16.2 2578 6, 1.16.3 2580 6, 1.16.4 2584 6,
1.16.5 2586 6, 1.17 2724 7, 1.17.1 2730 7, 1.18 2860 8, 1.18.1 2865 8, 1.18.2 2975 9, 1.19 3105 10, 1.19.1 3117 10,
1.19.2 3120 10, 1.19.3 3218 10, 1.19.4 3337 12, 1.20 3463 15, 1.20.1 3465 15, 1.20.2 3578 18, 1.20.3 3698 26,
1.20.4 3700 26, 1.20.5 3837 41, 1.20.6 3839 41, 1.21 3953 48, 1.21.1 3955 48, 1.21.2 4080 57, 1.21.3 4082 57,
1.21.4 4189 61, 1.21.5 4325 71, 1.21.6 4435 80, 1.21.7 4438 81, 1.21.8 4440 81, 1.21.9 4554 88.0, 1.21.10 4556 88.0,
1.21.11 4671 94.1, 26.1 4786 101.1, 26.1.1 4788 101.1, 26.1.2 4790 101.1
"""
DEFAULT = "26.1"  # the version of the table of blocks


@dataclass(frozen=True, slots=True)
class GameVersion:
    """A release of the game. ``data_version`` is its number in files; ``pack_format`` the major and minor format of
    data packs, the minor one None for versions that have none."""

    name: str
    data_version: int
    pack_format: tuple[int, int | None]

    def is_before(self, name: str) -> bool:
        """True for versions older than the release ``name``."""
        return self.data_version < _VERSIONS[name].data_version


def game_version(text: str = DEFAULT) -> GameVersion:
    """The release that people call ``text``, from 1.13 to 26.1.2; raises SceneError("value") for others."""
    name = text.strip().lower().removeprefix("v")
    if name in _VERSIONS:
        return _VERSIONS[name]
    message = (
        f"the version `{text[:30]}` of Minecraft is not known; releases from 1.13 to {next(reversed(_VERSIONS))} are"
    )
    raise SceneError("value", message, hint=suggest(name[:30], _VERSIONS))


def _release(text: str) -> GameVersion:
    name, data_version, pack_format = text.split()
    major, _, minor = pack_format.partition(".")
    return GameVersion(name, int(data_version), (int(major), int(minor) if minor else None))


_VERSIONS = {release.name: release for release in map(_release, _RELEASES.split(","))}


# What older versions of the game had of a build's blocks: names, properties, or nothing at all.


# The first version that has the newer of two names in `block_names`.
_RENAMED_IN = {
    "oak_sign": "1.14", "oak_wall_sign": "1.14", "dirt_path": "1.17", "short_grass": "1.20.3", "iron_chain": "1.21.9",
}  # fmt: skip
_WALLS = {"none": "false", "low": "true", "tall": "true"}  # before 1.16 an arm was there or not

Values = Mapping[str, tuple[str, ...]]  # the values of each property


@dataclass(frozen=True, slots=True)
class Era:
    """``values`` are the properties that a block had from the release ``since`` on; None where it was none yet."""

    since: GameVersion
    values: Values | None


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A build in the blocks of one version, and those of its blocks that the version does not have."""

    build: Build
    missing: tuple[str, ...]


def fitted(build: Build, version: GameVersion) -> Fitted:
    """``build`` as ``version`` knows it: blocks under their names of then, with the properties that they had; air in
    place of blocks that came later. Blocks of other namespaces stay as they are."""
    then = [_then(state, version) for state in build.palette[1:]]
    if all(new == old for new, old in zip(then, build.palette[1:])):
        return Fitted(build, ())
    missing = dict.fromkeys(old.name for new, old in zip(then, build.palette[1:]) if new is None)
    states = (AIR_STATE, *(state or AIR_STATE for state in then))
    return Fitted(trimmed(unified(build.origin, build.cells, states)), tuple(missing))


def too_new(missing: tuple[str, ...], version: GameVersion) -> Diagnostic | None:
    """The warning that names the blocks which a version does not have; None where there are none."""
    if not missing:
        return None
    shown = ", ".join(f"`{name}`" for name in missing[:8]) + (", .." if len(missing) > 8 else "")
    return Diagnostic("too-new", f"Minecraft {version.name} does not have {shown}; air is written in their place")


def _then(state: BlockState, version: GameVersion) -> BlockState | None:
    """The state in ``version``; None where the block was none yet."""
    name = state.name.removeprefix(NAMESPACE)
    eras = _eras().get(name)
    properties = state.properties
    if eras is not None:  # else it was always as it is
        values = next((era.values for era in reversed(eras) if era.since.data_version <= version.data_version), None)
        if values is None:
            return None
        properties = tuple(_kept(state, values))
    first = _RENAMED_IN.get(name)
    if first is not None and version.is_before(first):
        return BlockState(NAMESPACE + next(old for old, new in RENAMES if new == name), properties)
    return BlockState(state.name, properties)


def _kept(state: BlockState, values: Values) -> Iterator[tuple[str, str]]:
    """The properties that there were, with values that they had."""
    for name, value in state.properties:
        known = values.get(name, ())
        then = value if value in known else _WALLS.get(value, value)
        if then in known:
            yield name, then


@cache
def _eras() -> Mapping[str, tuple[Era, ...]]:
    """The eras of every block that was not always as it is, oldest first."""
    packed = files("scenelang.backends.minecraft").joinpath("history.tsv.gz").read_bytes()
    lines = (line.split("\t") for line in gzip.decompress(packed).decode("ascii").splitlines())
    return {name: tuple(_era(text) for text in eras) for name, *eras in lines}


def _era(text: str) -> Era:
    release, *properties = text.split()
    if properties == ["-"]:
        return Era(game_version(release), None)
    pairs = (each.split("=") for each in properties)
    return Era(game_version(release), {name: tuple(values.split("|")) for name, values in pairs})


# What a file of a build is made of.


def with_blocks(build: Build) -> Build:
    """``build``; raises SceneError("empty-scene") where it holds no block, for which files have no place."""
    if len(build.palette) < 2 or not build.cells.size:
        raise SceneError("empty-scene", "the scene lays no blocks, so there is nothing to write")
    return build


def as_written(build: Build, version: GameVersion) -> Build:
    """``build`` in the blocks of ``version``; raises SceneError("empty-scene") where that has none of them."""
    return with_blocks(fitted(build, version).build)


# Litematica's schematics, ``.litematic``: one region whose place keeps the program's origin at the paste origin.


_FEWEST_BITS = 2  # of the number of a block
_FIRST_WITH_6 = "1.18"  # the form of the schematic, which has not changed but for its number
_MOST_REGIONS = 1000


def write_litematic(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` for ``version``, whole or not at all; the path that was written. The schematic is called as the
    file is. Raises SceneError: "empty-scene", "file"."""
    build = as_written(build, version)
    numbers = in_file_order(build)
    size = _tag_of_triple(build.size)
    region = {
        "Position": _tag_of_triple(build.origin),
        "Size": size,
        "BlockStatePalette": [tag_of_state(state) for state in build.palette],
        "BlockStates": packed_longs(numbers, _bits(len(build.palette))),
        **{name: [] for name in ("TileEntities", "Entities", "PendingBlockTicks", "PendingFluidTicks")},
    }
    metadata = {
        "Name": path.stem,
        "Author": "",
        "Description": "",
        "EnclosingSize": size,
        "RegionCount": 1,
        "TotalBlocks": int(np.count_nonzero(numbers)),
        "TotalVolume": len(numbers),
        "TimeCreated": Long(0),  # the same build gives the same file
        "TimeModified": Long(0),
    }
    root = {
        "Version": 5 if version.is_before(_FIRST_WITH_6) else 6,
        "SubVersion": 1,
        "MinecraftDataVersion": version.data_version,
        "Metadata": metadata,
    }
    write_nbt(path, "", {**root, "Regions": {path.stem: region}})
    return [path]


def loaded_litematic(root: Mapping[str, Any]) -> LoadedBuild:
    """What the root compound of a schematic holds, all of its regions in one; raises Damaged."""
    regions = compound(root, "Regions")
    if len(regions) > _MOST_REGIONS:
        raise Damaged(f"it has {len(regions):,} regions, and {_MOST_REGIONS:,} may be read")
    tags = [compound(regions, name) for name in regions]
    build = joined([_region(tag) for tag in tags])
    block_entities = sum(how_many(tag, "TileEntities") for tag in tags)
    return LoadedBuild(build, Lost(block_entities, sum(how_many(tag, "Entities") for tag in tags)))


def _region(tag: Mapping[str, Any]) -> Build:
    """One region. A negative size reaches from the position down, that cell included."""
    position, reach = triple_of_compound(tag, "Position"), triple_of_compound(tag, "Size")
    x, y, z = size = checked_size((abs(reach[0]), abs(reach[1]), abs(reach[2])))
    a, b, c = (at + min(0, n + 1) for at, n in zip(position, reach))
    states = [state_of_tag(entry) for entry in listed(tag, "BlockStatePalette")]
    longs = array(tag, "BlockStates", 64).astype(np.uint64)
    return build_of((a, b, c), size, from_packed_longs(longs, x * y * z, _bits(len(states))), states)


def _bits(count: int) -> int:
    """The bits that the numbers of ``count`` states take."""
    return max(_FEWEST_BITS, (count - 1).bit_length())


def _tag_of_triple(numbers: Triple) -> dict[str, Any]:
    return dict(zip("xyz", numbers))


# Sponge schematics, ``.schem``: what WorldEdit and its kin paste.
#
# The program's origin is the paste origin: the block of the cell c comes to stand at the player's place + c. Versions
# of
# the game from 1.20.3 on get version 3 of the format; older ones version 2, since their WorldEdit reads no newer one.


_FIRST_WITH_3 = "1.20.3"
_LONGEST_SIDE = 0xFFFF  # cells along an axis: lengths are unsigned shorts
_SIDES = ("Width", "Height", "Length")
_OFFSETS = ("WEOffsetX", "WEOffsetY", "WEOffsetZ")
_MOST_STATES = 1 << 20


def write_schematic(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` for ``version``, whole or not at all; the path that was written.

    Raises SceneError: "empty-scene", "unsupported" for more than 65,535 cells along an axis, "file".
    """
    build = as_written(build, version)
    if max(build.size) > _LONGEST_SIDE:
        raise SceneError(
            "unsupported",
            f"a schematic holds {_LONGEST_SIDE:,} cells along each axis; {max(build.size):,} are too many",
        )
    head = {
        "DataVersion": version.data_version,
        "Metadata": {**dict(zip(_OFFSETS, build.origin)), "WorldEdit": {"Origin": np.zeros(3, np.int32)}},
        **{name: Short(n) for name, n in zip(_SIDES, build.size)},
        "Offset": np.array(build.origin, np.int32),
    }
    palette = {str(state): i for i, state in enumerate(build.palette)}
    data = varints(in_file_order(build))
    if version.is_before(_FIRST_WITH_3):
        blocks = {"PaletteMax": len(palette), "Palette": palette, "BlockData": data, "BlockEntities": []}
        write_nbt(path, "Schematic", {"Version": 2, **head, **blocks})
    else:
        blocks = {"Palette": palette, "Data": data, "BlockEntities": []}
        write_nbt(path, "", {"Schematic": {"Version": 3, **head, "Blocks": blocks}})
    return [path]


def loaded_schematic(root: Mapping[str, Any]) -> LoadedBuild:
    """What the root compound of a schematic of version 1, 2 or 3 holds; raises Damaged."""
    tag = compound(root, "Schematic") if "Schematic" in root else root
    version = whole(tag, "Version")
    if version not in (1, 2, 3):
        raise Damaged(f"it is a schematic of version {version}, and this program reads 1 to 3")
    blocks, data = (compound(tag, "Blocks"), "Data") if version == 3 else (tag, "BlockData")
    x, y, z = (whole(tag, name) & _LONGEST_SIDE for name in _SIDES)
    size = checked_size((x, y, z))
    numbers = from_varints(array(blocks, data, 8).view(np.uint8), x * y * z)
    build = build_of(_origin(tag, version), size, numbers, _schematic_palette(compound(blocks, "Palette")))
    lost = Lost(how_many(blocks, "BlockEntities", "TileEntities"), how_many(tag, "Entities"))
    return LoadedBuild(build, lost)


def _origin(tag: Mapping[str, Any], version: int) -> Triple:
    """Where the first cell stands from the paste origin. WorldEdit keeps that beside ``Offset`` before version 3, and
    writes where in the world it was taken from as ``Offset``."""
    metadata = tag.get("Metadata")
    if version < 3 and isinstance(metadata, dict) and all(name in metadata for name in _OFFSETS):
        x, y, z = (whole(metadata, name) for name in _OFFSETS)
        return x, y, z
    return triple_of_array(tag, "Offset") if "Offset" in tag else (0, 0, 0)


def _schematic_palette(tag: Mapping[str, Any]) -> list[Any]:
    """The states by their numbers; numbers that are missing stand for air."""
    numbers = [whole(tag, text) for text in tag]
    if any(not 0 <= number < _MOST_STATES for number in numbers):
        raise Damaged("a number in its palette is none")
    states = [AIR_STATE] * (max(numbers, default=-1) + 1)
    for text, number in zip(tag, numbers):
        states[number] = state_of_text(text)
    return states


# The game's own structures, ``.nbt``: what structure blocks and ``/place template`` load.
#
# The game saves no structure larger than 48 cells along an axis. A larger build becomes several files beside one
# another, ``house-0-0-0.nbt``, ``house-48-0-0.nbt`` and so on: the numbers are how far, in cells along x, y and z, the
# piece stands from the lowest corner of the build, so each is loaded with these numbers as its relative position. A
# cell
# without a block is not in the file, and keeps what stands there. The game knows no paste origin but the lowest
# corner;
# where the program's origin is stands in a field of our own that it skips, so that reading a file gives its blocks
# their
# places.


LARGEST = 48  # cells of a structure along each axis
_ORIGIN = "ScenelangOrigin"
# One entry of the list of blocks: the tags before its numbers as they stand in the file.
_BLOCK = np.dtype([
    ("before_pos", "S11"), ("pos", ">i4", 3), ("before_state", "S8"), ("state", ">i4"), ("end", "u1"),
])  # fmt: skip
_BEFORE_POS = b"\x09\x00\x03pos\x03\x00\x00\x00\x03"
_BEFORE_STATE = b"\x03\x00\x05state"


def write_structure(build: Build, path: Path, version: GameVersion) -> list[Path]:
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


def loaded_structure(root: Mapping[str, Any]) -> LoadedBuild:
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


# Data packs, ``.zip``, and single functions, ``.mcfunction``: the build as commands that the game runs.
#
# A pack called ``house.zip`` goes into the folder ``datapacks`` of a world; ``/function house:build`` then lays the
# build around the player, the program's origin in the player's own cell. The game runs at most 65,536 commands for
# one,
# those of called functions counted in, so a larger build is laid part by part, each in a tick of its own; a marker
# keeps
# the place, since functions that are scheduled know of none.


# A build as the game's commands, places relative to where they run.


MOST_FILLED = 32_768  # cells of one `fill`
_FIRST_STRICT = "1.21.5"


def place_commands(build: Build, version: GameVersion) -> Iterator[str]:
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


MOST_COMMANDS = 60_000  # of a function, some way below what the game allows
_FIRST_TO_SCHEDULE = "1.14"
_FIRST_WITH_MARKERS = "1.17"
_FIRST_SINGULAR = "1.21"  # its folder is `function`, and was `functions` before
_DATE = (1980, 1, 1, 0, 0, 0)  # the same build gives the same file


def write_datapack(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` as a data pack for ``version``, whole or not at all; the path that was written.

    Raises SceneError: "empty-scene", "unsupported" for too many commands before 1.14, "file".
    """
    name = _namespace(path)
    lines = list(place_commands(as_written(build, version), version))
    folder = f"data/{name}/{'functions' if version.is_before(_FIRST_SINGULAR) else 'function'}"
    with written_whole(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as pack:
        _add_text(pack, "pack.mcmeta", json.dumps({"pack": _about(name, version)}, indent=2))
        for function, body in _functions(name, lines, version):
            _add_text(pack, f"{folder}/{function}.mcfunction", "\n".join([*body, ""]))
    return [path]


def write_function(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` as one function for ``version``, whole or not at all; the path that was written.

    Raises SceneError: "empty-scene", "unsupported" for more than MOST_COMMANDS commands, "file".
    """
    lines = list(place_commands(as_written(build, version), version))
    if len(lines) > MOST_COMMANDS:
        message = f"the build takes {len(lines):,} commands, and one function runs {MOST_COMMANDS:,}"
        raise SceneError("unsupported", message, hint="write a data pack, `.zip`, which lays it part by part")
    write_text(path, "\n".join([*lines, ""]))
    return [path]


def _namespace(path: Path) -> str:
    """The file's name in the letters that names of functions may have."""
    return re.sub(r"[^a-z0-9_.-]+", "_", path.stem.lower()).strip("_") or "scene"


def _about(name: str, version: GameVersion) -> dict[str, object]:
    """What ``pack.mcmeta`` says. Since 1.21.9 the game wants the first and the last format that fit, each with its
    minor number (https://minecraft.wiki/w/Pack.mcmeta)."""
    major, minor = version.pack_format
    described = {"description": f"{name}: /function {name}:build"}
    if minor is None:
        return {"pack_format": major, **described}
    return {"min_format": [major, minor], "max_format": [major, minor], **described}


def _functions(name: str, lines: Sequence[str], version: GameVersion) -> Iterator[tuple[str, list[str]]]:
    """The functions of the pack and their commands, ``build`` first."""
    if len(lines) <= MOST_COMMANDS:
        yield "build", list(lines)
        return
    if version.is_before(_FIRST_TO_SCHEDULE):
        message = (
            f"the build takes {len(lines):,} commands, and Minecraft {version.name} runs {MOST_COMMANDS:,} of a pack"
        )
        raise SceneError("unsupported", message, hint="write a `.schem` or `.nbt`, or choose version 1.14 or later")
    marker = f"@e[tag=scenelang.{name},limit=1]"
    forget = f"kill @e[tag=scenelang.{name}]"
    yield "build", [forget, f"summon {_marker(name, version)}", f"schedule function {name}:step/1 1t"]
    starts = range(0, len(lines), MOST_COMMANDS)
    for part, start in enumerate(starts, 1):
        then = f"schedule function {name}:step/{part + 1} 1t" if part < len(starts) else forget
        yield f"step/{part}", [f"execute at {marker} run function {name}:part/{part}", then]
        yield f"part/{part}", list(lines[start : start + MOST_COMMANDS])


def _marker(name: str, version: GameVersion) -> str:
    """What is summoned where ``build`` runs, without body or look."""
    if version.is_before(_FIRST_WITH_MARKERS):
        return f'minecraft:armor_stand ~ ~ ~ {{Tags:["scenelang.{name}"],Marker:1b,Invisible:1b,NoGravity:1b}}'
    return f'minecraft:marker ~ ~ ~ {{Tags:["scenelang.{name}"]}}'


def _add_text(pack: zipfile.ZipFile, name: str, text: str) -> None:
    info = zipfile.ZipInfo(name, _DATE)
    info.compress_type = zipfile.ZIP_DEFLATED
    pack.writestr(info, text)
