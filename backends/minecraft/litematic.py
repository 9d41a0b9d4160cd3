"""Litematica's schematics, ``.litematic``: one region whose place keeps the program's origin at the paste origin."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.minecraft.blocks import Build
from scenelang.backends.minecraft.build_files import (
    GameVersion,
    LoadedBuild,
    Lost,
    as_written,
    build_of,
    in_file_order,
    joined,
    state_of_tag,
    tag_of_state,
)
from scenelang.backends.minecraft.nbt import (
    Damaged,
    Long,
    Triple,
    array,
    checked_size,
    compound,
    from_packed_longs,
    how_many,
    listed,
    packed_longs,
    triple_of_compound,
    write_nbt,
)

_FEWEST_BITS = 2  # of the number of a block
_FIRST_WITH_6 = "1.18"  # the form of the schematic, which has not changed but for its number
_MOST_REGIONS = 1000


def write(build: Build, path: Path, version: GameVersion) -> list[Path]:
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


def loaded(root: Mapping[str, Any]) -> LoadedBuild:
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
