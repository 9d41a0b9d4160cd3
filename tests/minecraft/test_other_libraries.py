"""Written files read by libraries that have nothing to do with this program."""

from __future__ import annotations

from pathlib import Path

import nbtlib
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from mcschematic import MCSchematic
from searching import many

from minecraft.builds import BUILDS, STATES, assert_same, made, noise
from minecraft.oracle import Cell, of_build
from scenelang.backends.minecraft import build_files
from scenelang.backends.minecraft.blocks import Build
from scenelang.backends.minecraft.build_files import fitted, game_version
from scenelang.backends.minecraft.export import read

IN_A_FOLDER = settings(
    max_examples=many(40), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
SEVERAL = [
    noise((5, 6, 7), 3),
    noise((9, 8, 7), 300),
    made((-9, 0, 3), np.arange(len(STATES) + 1).reshape(1, -1, 1), STATES),
]
MANY = pytest.mark.parametrize("build", SEVERAL, ids=["few states", "many states", "real states"])


def by_mcschematic(path: Path) -> dict[Cell, str]:
    structure = MCSchematic(str(path)).getStructure()
    return dict(structure.blockStateIterator())


@IN_A_FOLDER
@given(build=BUILDS)
def test_mcschematic_reads_version_2(tmp_path: Path, build: Build) -> None:
    older = game_version("1.20.1")
    build_files.write_schematic(build, tmp_path / "a.schem", older)
    assert by_mcschematic(tmp_path / "a.schem") == of_build(fitted(build, older).build)


@MANY
def test_mcschematic_reads_version_3_as_version_2(build: Build, tmp_path: Path) -> None:
    build_files.write_schematic(build, tmp_path / "a.schem", game_version())
    tag = nbtlib.load(tmp_path / "a.schem")["Schematic"]
    assert (tag["Version"], tag["DataVersion"]) == (3, 4786)
    assert [int(n) for n in tag["Offset"]] == list(build.origin)
    blocks = tag["Blocks"]
    renamed = {**tag, "Palette": blocks["Palette"], "BlockData": blocks["Data"]}
    nbtlib.File(renamed, gzipped=True).save(tmp_path / "b.schem")
    assert by_mcschematic(tmp_path / "b.schem") == of_build(build)


@MANY
def test_what_mcschematic_writes(build: Build, tmp_path: Path) -> None:
    from mcschematic import Version

    schematic = MCSchematic()
    for cell, state in of_build(build).items():
        schematic.setBlock(cell, state)
    schematic.save(str(tmp_path), "a", Version.JE_1_20_1)
    assert_same(build, read(tmp_path / "a.schem").build)


@IN_A_FOLDER
@given(build=BUILDS)
def test_nbtlib_reads_structures(tmp_path: Path, build: Build) -> None:
    build_files.write_structure(build, tmp_path / "a.nbt", game_version())
    root = nbtlib.load(tmp_path / "a.nbt")
    assert [int(n) for n in root["size"]] == list(build.size)
    found = {}
    for block in root["blocks"]:
        x, y, z = (int(n) + corner for n, corner in zip(block["pos"], build.origin))
        entry = root["palette"][int(block["state"])]
        properties = ",".join(f"{key}={value}" for key, value in entry.get("Properties", {}).items())
        found[x, y, z] = f"{entry['Name']}[{properties}]" if properties else str(entry["Name"])
    assert found == of_build(build)


@MANY
def test_litemapy(build: Build, tmp_path: Path) -> None:
    litemapy = pytest.importorskip("litemapy", reason="litemapy is GPL-3: `make test-minecraft` brings it")
    build_files.write_litematic(build, tmp_path / "a.litematic", game_version())
    schematic = litemapy.Schematic.load(str(tmp_path / "a.litematic"))
    [region] = schematic.regions.values()
    found = {}
    for x, y, z in region.block_positions():
        state = region[x, y, z]
        if state.id != "minecraft:air":
            properties = ",".join(f"{key}={value}" for key, value in sorted(state.properties()))
            name = f"{state.id}[{properties}]" if properties else state.id
            found[x + region.x, y + region.y, z + region.z] = name
    assert found == of_build(build)
    again = litemapy.Region(3, 4, 5, -2, -2, -2)  # from (2, 3, 4) to (3, 4, 5)
    again[0, 0, 0] = litemapy.BlockState("minecraft:stone")
    again[-1, -1, -1] = litemapy.BlockState("minecraft:dirt")
    litemapy.Schematic(regions={"a": again}).save(str(tmp_path / "b.litematic"))
    expected = {(3, 4, 5): "minecraft:stone", (2, 3, 4): "minecraft:dirt"}
    assert of_build(read(tmp_path / "b.litematic").build) == expected
