"""Reading and writing Minecraft build files: Litematica, Sponge schematics, structures, data packs."""

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

from scenelang.backends.files import atomic_write, atomic_write_all, write_text
from scenelang.backends.minecraft.blocks import (
    AIR,
    AIR_STATE,
    NOTHING,
    RENAMES,
    BlockState,
    Build,
    load_table,
    merged,
    trimmed,
    unified,
)
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
from scenelang.backends.minecraft.voxels import NAMESPACE
from scenelang.grammar.diagnostics import Diagnostic, SceneError, suggest


@dataclass(frozen=True, slots=True)
class Lost:
    """Numbers of items in a file that a build cannot represent.

    ``block_entities`` are contents of blocks (items in chests, text on signs), ``entities`` animals, item frames,
    boats.
    """

    block_entities: int = 0
    entities: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class LoadedBuild:
    """The build of a file, in the smallest box, and the contents that were dropped."""

    build: Build
    lost: Lost


def build_of(origin: Triple, size: Triple, numbers: npt.NDArray[np.uint32], states: Sequence[BlockState]) -> Build:
    """Return the build of cells in file order: x fastest, then z, then y; raises Damaged for an index out of range."""
    x, y, z = size
    if len(numbers) and int(numbers.max()) >= len(states):
        raise Damaged(f"block index {int(numbers.max()):,} is out of range (palette size {len(states):,})")
    cells = np.ascontiguousarray(numbers.reshape(y, z, x).transpose(2, 0, 1))
    return trimmed(unified(origin, cells, states or (AIR_STATE,)))


def in_file_order(build: Build) -> npt.NDArray[np.uint32]:
    """Return the indices of all cells (N,): x fastest, then z, then y."""
    return build.cells.transpose(1, 2, 0).reshape(-1)


def joined(builds: Sequence[Build]) -> Build:
    """Merge ``builds``; later ones replace earlier ones except for their air.

    Raises Damaged if the bounding box is too large.
    """
    non_empty = [build for build in builds if build.cells.size]
    if len(non_empty) < 2:
        return non_empty[0] if non_empty else trimmed(Build((0, 0, 0), np.zeros((0, 0, 0), np.uint32), (AIR_STATE,)))
    lows: npt.NDArray[Any] = np.array([build.origin for build in non_empty])
    low = lows.min(axis=0)
    x, y, z = ((lows + [build.size for build in non_empty]).max(axis=0) - low).tolist()
    cells = np.zeros(checked_size((x, y, z)), np.uint32)
    states: list[BlockState] = [AIR_STATE]
    for build in non_empty:
        corner = (np.array(build.origin) - low).tolist()
        target = cells[tuple(slice(a, a + n) for a, n in zip(corner, build.size))]
        np.copyto(target, build.cells + np.uint32(len(states)), where=build.cells != AIR)
        states += build.palette
    a, b, c = low.tolist()
    return unified((a, b, c), cells, states)


# Block states in the notation of files.


_NAME = re.compile(r"(?:[a-z0-9_.-]+:)?[a-z0-9_./-]+")
_WORD = re.compile(r"[a-z0-9_]+")
_MAX_NAME_LENGTH = 200  # characters of a name
_MAX_PROPERTIES = 64  # of one block


def state_of_text(text: str) -> BlockState:
    """Parse a state such as ``minecraft:oak_log[axis=x]``; raises Damaged."""
    name, bracket, rest = text.partition("[")
    if bracket and not rest.endswith("]"):
        raise Damaged(f"`{text[:60]}` is not a valid block state")
    pairs = [pair.partition("=") for pair in rest[:-1].split(",") if pair]
    return _state(name, {key: value for key, _, value in pairs})


def state_of_tag(tag: Any) -> BlockState:
    """Return the state of a compound with ``Name`` and ``Properties``; raises Damaged."""
    name = tag.get("Name") if isinstance(tag, dict) else None
    properties = tag.get("Properties", {}) if isinstance(tag, dict) else None
    if not isinstance(name, str) or not isinstance(properties, dict):
        raise Damaged("an entry of its palette is not a block")
    return _state(name, properties)


def tag_of_state(state: BlockState) -> dict[str, Any]:
    """Return a state as the compound that ``state_of_tag`` reads."""
    tag: dict[str, Any] = {"Name": state.name}
    return {**tag, "Properties": dict(state.properties)} if state.properties else tag


def _state(name: str, properties: Mapping[str, Any]) -> BlockState:
    """Return a validated block state; raises Damaged."""
    if len(name) > _MAX_NAME_LENGTH or not _NAME.fullmatch(name):
        raise Damaged(f"`{name[:60]}` is not a valid block name")
    if len(properties) > _MAX_PROPERTIES:
        raise Damaged(f"`{name}` has too many properties ({len(properties)})")
    for pair in properties.items():
        if not all(isinstance(word, str) and len(word) <= _MAX_NAME_LENGTH and _WORD.fullmatch(word) for word in pair):
            raise Damaged(f"`{name}` has an invalid property")
    full = name if ":" in name else NAMESPACE + name
    if full in NOTHING:
        return AIR_STATE
    return BlockState(full, tuple(sorted(properties.items())))


# Versions of the game and their numbers in files.


# Data versions are from npm's minecraft-data 3.117 (common/protocolVersions.json), data pack formats from the table at
# https://minecraft.wiki/w/Pack_format; minor formats exist since 1.21.9.
_RELEASES = """
1.13 1519 4, 1.13.1 1628 4, 1.13.2 1631 4, 1.14 1952 4, 1.14.1 1957 4, 1.14.2 1963 4, 1.14.3 1968 4, 1.14.4 1976 4,
1.15 2225 5, 1.15.1 2227 5, 1.15.2 2230 5, 1.16 2566 5, 1.16.1 2567 5, 1.16.2 2578 6, 1.16.3 2580 6, 1.16.4 2584 6,
1.16.5 2586 6, 1.17 2724 7, 1.17.1 2730 7, 1.18 2860 8, 1.18.1 2865 8, 1.18.2 2975 9, 1.19 3105 10, 1.19.1 3117 10,
1.19.2 3120 10, 1.19.3 3218 10, 1.19.4 3337 12, 1.20 3463 15, 1.20.1 3465 15, 1.20.2 3578 18, 1.20.3 3698 26,
1.20.4 3700 26, 1.20.5 3837 41, 1.20.6 3839 41, 1.21 3953 48, 1.21.1 3955 48, 1.21.2 4080 57, 1.21.3 4082 57,
1.21.4 4189 61, 1.21.5 4325 71, 1.21.6 4435 80, 1.21.7 4438 81, 1.21.8 4440 81, 1.21.9 4554 88.0, 1.21.10 4556 88.0,
1.21.11 4671 94.1, 26.1 4786 101.1, 26.1.1 4788 101.1, 26.1.2 4790 101.1
"""
DEFAULT = "26.1"  # version of the block table


@dataclass(frozen=True, slots=True)
class GameVersion:
    """A release of the game.

    ``data_version`` is its number in files; ``pack_format`` the major and minor data pack format, the minor one None
    for versions without it.
    """

    name: str
    data_version: int
    pack_format: tuple[int, int | None]

    def is_before(self, name: str) -> bool:
        """Return whether this version is older than the release ``name``."""
        return self.data_version < _VERSIONS[name].data_version


def game_version(text: str = DEFAULT) -> GameVersion:
    """Return the release named ``text``, from 1.13 to 26.1.2; raises SceneError("value") for others."""
    name = text.strip().lower().removeprefix("v")
    if name in _VERSIONS:
        return _VERSIONS[name]
    message = (
        f"unknown Minecraft version `{text[:30]}`; supported are releases from 1.13 to {next(reversed(_VERSIONS))}"
    )
    raise SceneError("value", message, hint=suggest(name[:30], _VERSIONS))


def _release(text: str) -> GameVersion:
    """Return a release from its line: name, data version and pack format."""
    name, data_version, pack_format = text.split()
    major, _, minor = pack_format.partition(".")
    return GameVersion(name, int(data_version), (int(major), int(minor) if minor else None))


_VERSIONS = {release.name: release for release in map(_release, _RELEASES.split(","))}


# Conversion to older versions of the game: block names, properties, and missing blocks.


# The first version with the newer of two names in `RENAMES`.
_RENAMED_IN = {
    "oak_sign": "1.14", "oak_wall_sign": "1.14", "dirt_path": "1.17", "short_grass": "1.20.3", "iron_chain": "1.21.9",
}  # fmt: skip
_WALL_ARMS = {"none": "false", "low": "true", "tall": "true"}  # before 1.16 the arms of walls were boolean

Values = Mapping[str, tuple[str, ...]]  # the possible values of each property


@dataclass(frozen=True, slots=True)
class Era:
    """Properties of a block from the release ``since`` on; ``values`` is None if the block did not exist."""

    since: GameVersion
    values: Values | None


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A build converted to one version, and the names of blocks that the version lacks."""

    build: Build
    missing: tuple[str, ...]


def fitted(build: Build, version: GameVersion) -> Fitted:
    """Convert ``build`` to ``version``, with the names and properties of that version.

    Blocks added later become air, because one line that the game cannot read prevents the whole function from loading.
    Blocks of other namespaces are unchanged. The history of blocks is derived from minecraft-data (``extract.py``).
    """
    converted = [_converted(state, version) for state in build.palette[1:]]
    if all(new == old for new, old in zip(converted, build.palette[1:])):
        return Fitted(build, ())
    missing = dict.fromkeys(old.name for new, old in zip(converted, build.palette[1:]) if new is None)
    states = (AIR_STATE, *(state or AIR_STATE for state in converted))
    return Fitted(trimmed(unified(build.origin, build.cells, states)), tuple(missing))


def too_new(missing: tuple[str, ...], version: GameVersion) -> Diagnostic | None:
    """Return the warning that lists blocks missing in a version, None if there are none."""
    if not missing:
        return None
    shown = ", ".join(f"`{name}`" for name in missing[:8]) + (", .." if len(missing) > 8 else "")
    return Diagnostic("too-new", f"Minecraft {version.name} does not have {shown}; air is written instead")


def _converted(state: BlockState, version: GameVersion) -> BlockState | None:
    """Return the state in ``version``, None if the block did not exist."""
    name = state.name.removeprefix(NAMESPACE)
    eras = _eras().get(name)
    properties = state.properties
    if eras is not None:  # otherwise the block has never changed
        values = next((era.values for era in reversed(eras) if era.since.data_version <= version.data_version), None)
        if values is None:
            return None
        properties = tuple(_existing_properties(state, values))
    first = _RENAMED_IN.get(name)
    if first is not None and version.is_before(first):
        return BlockState(NAMESPACE + next(old for old, new in RENAMES if new == name), properties)
    return BlockState(state.name, properties)


def _existing_properties(state: BlockState, values: Values) -> Iterator[tuple[str, str]]:
    """Yield the properties and values that existed, converting walls."""
    for name, value in state.properties:
        known = values.get(name, ())
        converted = value if value in known else _WALL_ARMS.get(value, value)
        if converted in known:
            yield name, converted


@cache
def _eras() -> Mapping[str, tuple[Era, ...]]:
    """Return the eras of every block that has changed, oldest first."""
    packed = files("scenelang.backends.minecraft").joinpath("history.tsv.gz").read_bytes()
    lines = (line.split("\t") for line in gzip.decompress(packed).decode("ascii").splitlines())
    return {name: tuple(_era(text) for text in eras) for name, *eras in lines}


def _era(text: str) -> Era:
    """Return an era from its text: a release, then properties with their values, or a dash."""
    release, *properties = text.split()
    if properties == ["-"]:
        return Era(game_version(release), None)
    pairs = (pair.split("=") for pair in properties)
    return Era(game_version(release), {name: tuple(values.split("|")) for name, values in pairs})


# Preconditions of files.


def with_blocks(build: Build) -> Build:
    """Return ``build``; raises SceneError("empty-scene") if it contains no blocks, which files cannot represent."""
    if len(build.palette) < 2 or not build.cells.size:
        raise SceneError("empty-scene", "the scene places no blocks, so there is nothing to write")
    return build


def as_written(build: Build, version: GameVersion) -> Build:
    """Convert ``build`` to ``version``; raises SceneError("empty-scene") if that has none of its blocks."""
    return with_blocks(fitted(build, version).build)


# Litematica schematics, ``.litematic``: one region, positioned so that the program's origin is the paste origin.


_MIN_BITS = 2  # per block index, as Litematica has it
_FIRST_WITH_6 = "1.18"  # version 6 of the schematic format, which differs from version 5 only in its number
_MAX_REGIONS = 1000  # of a file that is read


def write_litematic(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` for ``version`` atomically and return the path; the schematic is named after the file.

    Raises SceneError: "empty-scene", "file".
    """
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
        "TimeCreated": Long(0),  # makes the output reproducible
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
    """Return the build in a schematic's root compound, with all regions merged; raises Damaged."""
    regions = compound(root, "Regions")
    if len(regions) > _MAX_REGIONS:
        raise Damaged(f"it has {len(regions):,} regions, more than the limit of {_MAX_REGIONS:,}")
    tags = [compound(regions, name) for name in regions]
    build = joined([_region(tag) for tag in tags])
    block_entities = sum(how_many(tag, "TileEntities") for tag in tags)
    return LoadedBuild(build, Lost(block_entities, sum(how_many(tag, "Entities") for tag in tags)))


def _region(tag: Mapping[str, Any]) -> Build:
    """Return one region. A negative size extends from the position, inclusive, in the negative direction."""
    position, reach = triple_of_compound(tag, "Position"), triple_of_compound(tag, "Size")
    x, y, z = size = checked_size((abs(reach[0]), abs(reach[1]), abs(reach[2])))
    a, b, c = (at + min(0, n + 1) for at, n in zip(position, reach))
    states = [state_of_tag(entry) for entry in listed(tag, "BlockStatePalette")]
    longs = array(tag, "BlockStates", 64).astype(np.uint64)
    return build_of((a, b, c), size, from_packed_longs(longs, x * y * z, _bits(len(states))), states)


def _bits(count: int) -> int:
    """Return the number of bits per index for ``count`` states."""
    return max(_MIN_BITS, (count - 1).bit_length())


def _tag_of_triple(numbers: Triple) -> dict[str, Any]:
    return dict(zip("xyz", numbers))


# Sponge schematics, ``.schem``: the format of WorldEdit and others. The program's origin is the paste origin: the block
# of cell c is pasted at the player's position + c. For versions of the game from 1.20.3 on the format version is 3, for
# older ones 2, because their WorldEdit cannot read version 3.


_FIRST_WITH_3 = "1.20.3"
_MAX_SIDE = 0xFFFF  # cells along an axis: lengths are unsigned shorts
_SIDES = ("Width", "Height", "Length")
_OFFSETS = ("WEOffsetX", "WEOffsetY", "WEOffsetZ")
_MAX_STATES = 1 << 20  # palette index that is accepted from files


def write_schematic(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` for ``version`` atomically and return the path.

    Raises SceneError: "empty-scene", "unsupported" for more than 65,535 cells along an axis, "file".
    """
    build = as_written(build, version)
    if max(build.size) > _MAX_SIDE:
        raise SceneError(
            "unsupported",
            f"a schematic can have at most {_MAX_SIDE:,} cells along each axis, not {max(build.size):,}",
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
    """Return the build in the root compound of a schematic of version 1, 2 or 3; raises Damaged."""
    tag = compound(root, "Schematic") if "Schematic" in root else root
    version = whole(tag, "Version")
    if version not in (1, 2, 3):
        raise Damaged(f"unsupported schematic version {version}, expected 1 to 3")
    blocks, data = (compound(tag, "Blocks"), "Data") if version == 3 else (tag, "BlockData")
    x, y, z = (whole(tag, name) & _MAX_SIDE for name in _SIDES)
    size = checked_size((x, y, z))
    numbers = from_varints(array(blocks, data, 8).view(np.uint8), x * y * z)
    build = build_of(_origin(tag, version), size, numbers, _schematic_palette(compound(blocks, "Palette")))
    lost = Lost(how_many(blocks, "BlockEntities", "TileEntities"), how_many(tag, "Entities"))
    return LoadedBuild(build, lost)


def _origin(tag: Mapping[str, Any], version: int) -> Triple:
    """Return the position of the first cell relative to the paste origin.

    Before version 3 WorldEdit stores it in the metadata; ``Offset`` is then the position in the world it was copied
    from.
    """
    metadata = tag.get("Metadata")
    if version < 3 and isinstance(metadata, dict) and all(name in metadata for name in _OFFSETS):
        x, y, z = (whole(metadata, name) for name in _OFFSETS)
        return x, y, z
    return triple_of_array(tag, "Offset") if "Offset" in tag else (0, 0, 0)


def _schematic_palette(tag: Mapping[str, Any]) -> list[Any]:
    """Return the states by index; missing indices are air."""
    numbers = [whole(tag, text) for text in tag]
    if any(not 0 <= number < _MAX_STATES for number in numbers):
        raise Damaged("an index in its palette is out of range")
    states = [AIR_STATE] * (max(numbers, default=-1) + 1)
    for text, number in zip(tag, numbers):
        states[number] = state_of_text(text)
    return states


# The game's structures, ``.nbt``, loaded by structure blocks and ``/place template``. The game saves structures of at
# most 48 cells along an axis. A larger build becomes several files, ``house-0-0-0.nbt``, ``house-48-0-0.nbt`` and so
# on: the numbers are the offset of the piece, in cells along x, y and z, from the lowest corner of the build, to be
# used as the relative position when loading. Cells without a block are not in the file and do not change the world. The
# game's only paste origin is the lowest corner; the program's origin is stored in an additional field, which the game
# ignores, so that reading a file restores the positions of its blocks.


LARGEST = 48  # cells of a structure along each axis, a limit of the game
_ORIGIN = "ScenelangOrigin"
# Layout of an entry of the list of blocks, including the tag headers.
_BLOCK = np.dtype([
    ("before_pos", "S11"), ("pos", ">i4", 3), ("before_state", "S8"), ("state", ">i4"), ("end", "u1"),
])  # fmt: skip
_BEFORE_POS = b"\x09\x00\x03pos\x03\x00\x00\x00\x03"
_BEFORE_STATE = b"\x03\x00\x05state"


def write_structure(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` for ``version`` atomically and return the paths; only ``path`` if one piece is enough.

    Raises SceneError: "empty-scene", "file".
    """
    build = as_written(build, version)
    pieces = list(_pieces(build))
    is_one = max(build.size) <= LARGEST
    names = [path.name if is_one else f"{path.stem}-{x}-{y}-{z}{path.suffix}" for (x, y, z), _ in pieces]
    with atomic_write_all(path.parent, path) as folder:
        for name, (_, piece) in zip(names, pieces):
            write_nbt(folder / name, "", _root(piece, version))
    return [path.parent / name for name in names]


def _pieces(build: Build) -> Iterator[tuple[Triple, Build]]:
    """Yield the non-empty pieces of at most LARGEST cells along each axis, with their offsets in the build."""
    for x, y, z in product(*(range(0, n, LARGEST) for n in build.size)):
        cells = build.cells[x : x + LARGEST, y : y + LARGEST, z : z + LARGEST]
        if cells.any():
            a, b, c = build.origin
            yield (x, y, z), unified((a + x, b + y, c + z), cells, build.palette)


def _root(piece: Build, version: GameVersion) -> dict[str, Any]:
    """Return the root compound of a structure."""
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
    """Return the build in the root compound of a structure, using the first of several palettes; raises Damaged."""
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
    """Return the states of a structure, of the first palette if there are several."""
    if "palettes" in root:
        choices = listed(root, "palettes")
        palette = choices[0] if choices and isinstance(choices[0], list) else []
    else:
        palette = listed(root, "palette")
    return [state_of_tag(entry) for entry in palette]


def _blocks(blocks: list[Any], size: Triple, states: int) -> tuple[Any, Any]:
    """Return the cells (N, 3) of blocks and their state indices (N,); raises Damaged for invalid ones."""
    if not all(isinstance(block, dict) for block in blocks):
        raise Damaged("an entry of `blocks` is not a compound")
    at = np.array([triple_of_array(block, "pos") for block in blocks], np.int64).reshape(-1, 3)
    number = np.array([whole(block, "state") for block in blocks], np.int64)
    if len(at) and ((at < 0) | (at >= size)).any():
        raise Damaged("the position of a block is outside the structure")
    if len(at) and not 0 <= int(number.min()) <= int(number.max()) < states:
        raise Damaged(f"a block index is out of range (palette size {states:,})")
    return at, number


# Data packs, ``.zip``, and single functions, ``.mcfunction``: the build as game commands. A pack ``house.zip`` is put
# into a world's ``datapacks`` folder; ``/function house:build`` then places the build around the player, with the
# program's origin in the player's cell. The game runs at most 65,536 commands per function call, including called
# functions, so a larger build is placed in parts, one per tick; a marker stores the position, which scheduled functions
# do not have.


# A build as game commands with positions relative to where they run.


MAX_FILL = 32_768  # cells of one `fill`, a limit of the game
_FIRST_STRICT = "1.21.5"


def place_commands(build: Build, version: GameVersion) -> Iterator[str]:
    """Yield commands that place ``build``, already converted to ``version``, with cell c at ``~c``.

    Full cubes come first, each kind from the ground up, so that torches find the wall they are attached to. From 1.21.5
    on commands are ``strict``: the game does not update block states.
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
    """Return the mask of palette entries that are placed after the full cubes."""
    blocks = load_table().blocks
    kinds = [blocks.get(state.name) for state in build.palette]
    return np.array([kind is None or kind.shape != "cube" for kind in kinds])


def _cuts(low: Triple, size: Triple) -> Iterator[tuple[Triple, Triple]]:
    """Yield the first and last cells of pieces of a cuboid that fit one ``fill``."""
    width = min(size[0], MAX_FILL)
    depth = min(size[2], MAX_FILL // width)
    height = min(size[1], MAX_FILL // (width * depth))
    most = (width, height, depth)
    for corner in product(*(range(0, n, step) for n, step in zip(size, most))):
        x, y, z = (a + b for a, b in zip(low, corner))
        w, h, d = (min(step, n - b) for step, n, b in zip(most, size, corner))
        yield (x, y, z), (x + w - 1, y + h - 1, z + d - 1)


def _place(cell: Triple) -> str:
    """Return a cell as coordinates relative to where the command runs."""
    x, y, z = cell
    return f"~{x} ~{y} ~{z}"


MAX_COMMANDS = 60_000  # of a function: below the game's limit of 65,536 per call, which nested calls share
_FIRST_TO_SCHEDULE = "1.14"
_FIRST_WITH_MARKERS = "1.17"
_FIRST_SINGULAR = "1.21"  # its folder is `function`, formerly `functions`
_DATE = (1980, 1, 1, 0, 0, 0)  # fixed, so that the output is reproducible


def write_datapack(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` as a data pack for ``version`` atomically and return the path.

    Raises SceneError: "empty-scene", "unsupported" for too many commands before 1.14, "file".
    """
    name = _namespace(path)
    lines = list(place_commands(as_written(build, version), version))
    folder = f"data/{name}/{'functions' if version.is_before(_FIRST_SINGULAR) else 'function'}"
    with atomic_write(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as pack:
        _add_text(pack, "pack.mcmeta", json.dumps({"pack": _metadata(name, version)}, indent=2))
        for function, body in _functions(name, lines, version):
            _add_text(pack, f"{folder}/{function}.mcfunction", "\n".join([*body, ""]))
    return [path]


def write_function(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` as one function for ``version`` atomically and return the path.

    Raises SceneError: "empty-scene", "unsupported" for more than MAX_COMMANDS commands, "file".
    """
    lines = list(place_commands(as_written(build, version), version))
    if len(lines) > MAX_COMMANDS:
        message = f"the build requires {len(lines):,} commands, more than the limit of {MAX_COMMANDS:,} per function"
        raise SceneError("unsupported", message, hint="write a data pack, `.zip`, which places it in parts")
    write_text(path, "\n".join([*lines, ""]))
    return [path]


def _namespace(path: Path) -> str:
    """Return the file's name reduced to characters allowed in function names."""
    return re.sub(r"[^a-z0-9_.-]+", "_", path.stem.lower()).strip("_") or "scene"


def _metadata(name: str, version: GameVersion) -> dict[str, object]:
    """Return the content of ``pack.mcmeta``.

    Since 1.21.9 it contains the first and last supported format with minor numbers
    (https://minecraft.wiki/w/Pack.mcmeta).
    """
    major, minor = version.pack_format
    described = {"description": f"{name}: /function {name}:build"}
    if minor is None:
        return {"pack_format": major, **described}
    return {"min_format": [major, minor], "max_format": [major, minor], **described}


def _functions(name: str, lines: Sequence[str], version: GameVersion) -> Iterator[tuple[str, list[str]]]:
    """Yield the names of the pack's functions and their commands, ``build`` first."""
    if len(lines) <= MAX_COMMANDS:
        yield "build", list(lines)
        return
    if version.is_before(_FIRST_TO_SCHEDULE):
        limit = f"the limit of {MAX_COMMANDS:,} in Minecraft {version.name}"
        message = f"the build requires {len(lines):,} commands, more than {limit}"
        raise SceneError("unsupported", message, hint="write a `.schem` or `.nbt`, or use version 1.14 or later")
    marker = f"@e[tag=scenelang.{name},limit=1]"
    forget = f"kill @e[tag=scenelang.{name}]"
    yield "build", [forget, f"summon {_marker(name, version)}", f"schedule function {name}:step/1 1t"]
    starts = range(0, len(lines), MAX_COMMANDS)
    for part, start in enumerate(starts, 1):
        following = f"schedule function {name}:step/{part + 1} 1t" if part < len(starts) else forget
        yield f"step/{part}", [f"execute at {marker} run function {name}:part/{part}", following]
        yield f"part/{part}", list(lines[start : start + MAX_COMMANDS])


def _marker(name: str, version: GameVersion) -> str:
    """Return an invisible entity to summon where ``build`` runs."""
    if version.is_before(_FIRST_WITH_MARKERS):
        return f'minecraft:armor_stand ~ ~ ~ {{Tags:["scenelang.{name}"],Marker:1b,Invisible:1b,NoGravity:1b}}'
    return f'minecraft:marker ~ ~ ~ {{Tags:["scenelang.{name}"]}}'


def _add_text(pack: zipfile.ZipFile, name: str, text: str) -> None:
    """Add a text file to a data pack, reproducibly."""
    info = zipfile.ZipInfo(name, _DATE)
    info.compress_type = zipfile.ZIP_DEFLATED
    pack.writestr(info, text)
