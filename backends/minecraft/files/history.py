"""What older versions of the game had of a build's blocks: names, properties, or nothing at all."""

from __future__ import annotations

import gzip
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from scenelang.backends.minecraft.asked import NAMESPACE
from scenelang.backends.minecraft.block_names import RENAMES
from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, Build
from scenelang.backends.minecraft.files.versions import GameVersion, game_version
from scenelang.backends.minecraft.palettes import trimmed, unified
from scenelang.grammar.diagnostics import Diagnostic

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
