"""Sponge schematics, ``.schem``: what WorldEdit and its kin paste.

The program's origin is the paste origin: the block of the cell c comes to stand at the player's place + c. Versions of
the game from 1.20.3 on get version 3 of the format; older ones version 2, since their WorldEdit reads no newer one.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.minecraft.blocks import AIR_STATE, Build
from scenelang.backends.minecraft.build_files import (
    GameVersion,
    LoadedBuild,
    Lost,
    as_written,
    build_of,
    in_file_order,
    state_of_text,
)
from scenelang.backends.minecraft.nbt import (
    Damaged,
    Short,
    Triple,
    array,
    checked_size,
    compound,
    from_varints,
    how_many,
    triple_of_array,
    varints,
    whole,
    write_nbt,
)
from scenelang.grammar.diagnostics import SceneError

_FIRST_WITH_3 = "1.20.3"
_LONGEST = 0xFFFF  # cells along an axis: lengths are unsigned shorts
_SIDES = ("Width", "Height", "Length")
_OFFSETS = ("WEOffsetX", "WEOffsetY", "WEOffsetZ")
_MOST_STATES = 1 << 20


def write(build: Build, path: Path, version: GameVersion) -> list[Path]:
    """Write ``build`` for ``version``, whole or not at all; the path that was written.

    Raises SceneError: "empty-scene", "unsupported" for more than 65,535 cells along an axis, "file".
    """
    build = as_written(build, version)
    if max(build.size) > _LONGEST:
        raise SceneError(
            "unsupported", f"a schematic holds {_LONGEST:,} cells along each axis; {max(build.size):,} are too many"
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


def loaded(root: Mapping[str, Any]) -> LoadedBuild:
    """What the root compound of a schematic of version 1, 2 or 3 holds; raises Damaged."""
    tag = compound(root, "Schematic") if "Schematic" in root else root
    version = whole(tag, "Version")
    if version not in (1, 2, 3):
        raise Damaged(f"it is a schematic of version {version}, and this program reads 1 to 3")
    blocks, data = (compound(tag, "Blocks"), "Data") if version == 3 else (tag, "BlockData")
    x, y, z = (whole(tag, name) & _LONGEST for name in _SIDES)
    size = checked_size((x, y, z))
    numbers = from_varints(array(blocks, data, 8).view(np.uint8), x * y * z)
    build = build_of(_origin(tag, version), size, numbers, _palette(compound(blocks, "Palette")))
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


def _palette(tag: Mapping[str, Any]) -> list[Any]:
    """The states by their numbers; numbers that are missing stand for air."""
    numbers = [whole(tag, text) for text in tag]
    if any(not 0 <= number < _MOST_STATES for number in numbers):
        raise Damaged("a number in its palette is none")
    states = [AIR_STATE] * (max(numbers, default=-1) + 1)
    for text, number in zip(tag, numbers):
        states[number] = state_of_text(text)
    return states
