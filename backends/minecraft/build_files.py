"""What a file of a build holds once it is read."""

from __future__ import annotations

import gzip
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import AIR, AIR_STATE, NOTHING, BlockState, Build, trimmed, unified
from scenelang.backends.minecraft.nbt import Damaged, Triple, checked_size
from scenelang.backends.minecraft.table import RENAMES
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
