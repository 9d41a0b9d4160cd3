"""Files of builds: what is written reads back the same; what other programs write is read."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import nbtlib
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from nbtlib import Byte, ByteArray, Compound, Int, IntArray, List, LongArray, Short, String
from searching import many

from minecraft.builds import BUILDS, STATES, assert_same, made, noise
from minecraft.oracle import of_build
from scenelang.backends.minecraft import export
from scenelang.backends.minecraft.blocks import BlockState, Build, load_table
from scenelang.backends.minecraft.build_files import (
    LARGEST,
    GameVersion,
    Lost,
    fitted,
    game_version,
    write_datapack,
    write_function,
    write_litematic,
    write_schematic,
    write_structure,
)
from scenelang.backends.minecraft.export import read
from scenelang.backends.minecraft.nbt import packed_longs
from scenelang.grammar.diagnostics import SceneError

NEWEST = game_version()
BuildWriter = Callable[[Build, Path, GameVersion], list[Path]]
FORMATS: list[tuple[BuildWriter, str, str]] = [
    (write_schematic, ".schem", "26.1"), (write_schematic, ".schem", "1.20.1"), (write_litematic, ".litematic", "26.1"),
    (write_structure, ".nbt", "26.1"),
]  # fmt: skip
BY_FORMAT = pytest.mark.parametrize(
    ("write", "ending", "version"), FORMATS, ids=["schem-3", "schem-2", "litematic", "nbt"]
)
IN_A_FOLDER = settings(
    max_examples=many(40), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
SMALL = made((2, -3, 4), [[[1, 2], [0, 1]]], STATES)


@BY_FORMAT
@IN_A_FOLDER
@given(build=BUILDS)
def test_what_is_written_reads_back(
    write: BuildWriter, ending: str, version: str, tmp_path: Path, build: Build
) -> None:
    path = tmp_path / f"a{ending}"
    assert write(build, path, game_version(version)) == [path]
    loaded = read(path)
    assert_same(fitted(build, game_version(version)).build, loaded.build)
    assert loaded.lost == Lost(0, 0)


@BY_FORMAT
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 127, 128, 129, 300])
def test_numbers_of_states(write: BuildWriter, ending: str, version: str, count: int, tmp_path: Path) -> None:
    build = noise((7, 11, 13), count)
    write(build, tmp_path / f"a{ending}", game_version(version))
    assert_same(build, read(tmp_path / f"a{ending}").build)


@BY_FORMAT
def test_the_same_build_gives_the_same_file(write: BuildWriter, ending: str, version: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{ending}"
    write(SMALL, path, game_version(version))
    first = path.read_bytes()
    write(SMALL, path, game_version(version))
    assert path.read_bytes() == first


WRITERS = [
    (write_schematic, "a.schem"), (write_litematic, "a.litematic"), (write_structure, "a.nbt"), (write_datapack, "a.zip"),
    (write_function, "a.mcfunction"), (export.write, "a.json"),
]  # fmt: skip


@pytest.mark.parametrize(("write", "name"), WRITERS)
def test_nothing_to_write(write: Any, name: str, tmp_path: Path) -> None:
    empty = made((0, 0, 0), np.zeros((2, 2, 2)), [])
    with pytest.raises(SceneError) as raised:
        write(empty, tmp_path / name, NEWEST)
    assert raised.value.name == "empty-scene"
    with pytest.raises(SceneError) as raised:
        write(SMALL, tmp_path / "missing" / name, NEWEST)
    assert raised.value.name == "file"
    assert list(tmp_path.iterdir()) == []


def test_a_schematic_has_short_sides(tmp_path: Path) -> None:
    wide = made((0, 0, 0), np.ones((40_000, 1, 1)), STATES)
    write_schematic(wide, tmp_path / "a.schem", NEWEST)
    assert read(tmp_path / "a.schem").build.size == (40_000, 1, 1)
    with pytest.raises(SceneError, match="65,535") as raised:
        write_schematic(made((0, 0, 0), np.ones((1, 70_000, 1)), STATES), tmp_path / "a.schem", NEWEST)
    assert raised.value.name == "unsupported"


@pytest.mark.parametrize(
    ("write", "ending"), [(write_schematic, ".schem"), (write_litematic, ".litematic"), (write_structure, ".nbt")]
)
def test_states_and_versions_are_those_of_the_table(write: BuildWriter, ending: str, tmp_path: Path) -> None:
    build = made((0, 0, 0), np.arange(len(STATES) + 1).reshape(-1, 1, 1), STATES)
    write(build, tmp_path / f"a{ending}", NEWEST)
    table = load_table()
    assert all(table.blocks[s.name].allows(s) for s in read(tmp_path / f"a{ending}").build.palette)
    root = nbtlib.load(tmp_path / f"a{ending}")
    root = root.get("Schematic", root)
    assert root.get("DataVersion", root.get("MinecraftDataVersion")) == table.data_version == NEWEST.data_version


# --- structures in pieces --------------------------------------------------------------------------------------------


def test_a_large_structure_is_written_in_pieces(tmp_path: Path) -> None:
    build = noise((50, 3, 100), 4)
    paths = write_structure(build, tmp_path / "house.nbt", NEWEST)
    names = [f"house-{x}-0-{z}.nbt" for x in (0, 48) for z in (0, 48, 96)]
    assert [path.name for path in paths] == names
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)
    found: dict[tuple[int, int, int], str] = {}
    for path in paths:
        piece = read(path).build
        assert max(nbtlib.load(path)["size"]) <= LARGEST
        cells = of_build(piece)
        assert not cells.keys() & found.keys()
        found |= cells
    assert found == of_build(build)


def test_a_piece_without_blocks_is_not_written(tmp_path: Path) -> None:
    cells = np.zeros((1, 1, 200))
    cells[0, 0, 0] = cells[0, 0, 199] = 1
    paths = write_structure(made((0, 0, 0), cells, STATES), tmp_path / "a.nbt", NEWEST)
    assert [path.name for path in paths] == ["a-0-0-0.nbt", "a-0-0-192.nbt"]


# --- what other programs write ---------------------------------------------------------------------------------------


def saved(path: Path, root: Compound, name: str = "", gzipped: bool = True) -> Path:
    nbtlib.File(root, gzipped=gzipped, root_name=name).save(path)
    return path


def old_schematic(version: int, **more: Any) -> Compound:
    return Compound({
        "Version": Int(version), "Width": Short(2), "Height": Short(1), "Length": Short(2),
        "Palette": Compound({"minecraft:stone": Int(5), "oak_log[axis=x]": Int(1), "minecraft:cave_air": Int(2)}),
        "BlockData": ByteArray([5, 2, 1, 3]), **more,
    })  # fmt: skip


@pytest.mark.parametrize("gzipped", [True, False])
def test_old_schematics(gzipped: bool, tmp_path: Path) -> None:
    offset = {"Offset": IntArray([100, 60, -9])}
    entities = {"TileEntities": List[Compound]([Compound({"Pos": IntArray([0, 0, 0])})])}
    path = saved(tmp_path / "a.schem", old_schematic(1, **offset, **entities), "Schematic", gzipped)
    loaded = read(path)
    expected = {(100, 60, -9): "minecraft:stone", (100, 60, -8): "minecraft:oak_log[axis=x]"}
    assert of_build(loaded.build) == expected
    assert loaded.lost == Lost(1, 0)
    worldedit = Compound({f"WEOffset{axis}": Int(n) for axis, n in zip("XYZ", (-1, 0, 7))})
    saved(path, old_schematic(2, **offset, Metadata=worldedit, Entities=List[Compound]([Compound()])), "Schematic")
    assert read(path).build.origin == (-1, 0, 7)
    assert read(path).lost == Lost(0, 1)


def region(
    position: tuple[int, int, int], size: tuple[int, int, int], names: list[str], numbers: list[int]
) -> Compound:
    palette = [Compound({"Name": String(name)}) for name in names]
    longs = packed_longs(np.array(numbers, np.uint32), max(2, (len(names) - 1).bit_length())).astype(np.int64)
    triple = lambda numbers: Compound({axis: Int(n) for axis, n in zip("xyz", numbers)})
    return Compound({
        "Position": triple(position), "Size": triple(size), "BlockStatePalette": List[Compound](palette),
        "BlockStates": LongArray(longs), "TileEntities": List[Compound]([Compound()]),
        "Entities": List[Compound]([Compound(), Compound()]),
    })  # fmt: skip


def test_regions_with_negative_sizes(tmp_path: Path) -> None:
    air, stone, dirt = "minecraft:air", "minecraft:stone", "minecraft:dirt"
    regions = {
        "one": region((0, 0, 0), (-2, 1, -3), [air, stone, dirt], [1, 0, 0, 0, 0, 2]),
        "two": region((0, 5, 0), (1, 2, 1), [air, dirt], [1, 1]),
        "three": region((0, 5, 0), (1, 1, 1), [dirt, air, stone], [2]),
        "empty": region((2**31 - 1, 0, 0), (-1, -1, -1), [air], [0]),
    }
    loaded = read(saved(tmp_path / "a.litematic", Compound({"Regions": Compound(regions)})))
    assert of_build(loaded.build) == {(-1, 0, -2): stone, (0, 0, 0): dirt, (0, 5, 0): stone, (0, 6, 0): dirt}
    assert loaded.lost == Lost(4, 8)


def test_structures_of_the_game(tmp_path: Path) -> None:
    palette = List[Compound]([
        Compound({"Name": String("minecraft:chest"), "Properties": Compound({"facing": String("east")})}),
        Compound({"Name": String("minecraft:air")}), Compound({"Name": String("minecraft:stone")}),
    ])  # fmt: skip
    block = lambda x, state, **more: Compound({**more, "state": Int(state), "pos": List[Int]([Int(x), Int(0), Int(0)])})
    chest = block(0, 0, nbt=Compound({"Items": List[Compound]([Compound({"Count": Byte(3)})])}))
    root = {
        "size": List[Int]([Int(4), Int(1), Int(1)]), "blocks": List[Compound]([chest, block(1, 1), block(3, 2)]),
        "entities": List[Compound]([Compound()]),
    }  # fmt: skip
    for named in ({"palette": palette}, {"palettes": List[List[Compound]]([palette, palette])}):
        loaded = read(saved(tmp_path / "a.nbt", Compound({**root, **named})))
        assert of_build(loaded.build) == {(0, 0, 0): "minecraft:chest[facing=east]", (3, 0, 0): "minecraft:stone"}
        assert loaded.lost == Lost(1, 1)


def test_a_few_blocks_among_many_are_different(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    states = rng.integers(0, 3, 3000)
    blocks, names = [], ["minecraft:stone", "minecraft:dirt", "minecraft:chest"]
    for i, state in enumerate(states.tolist()):
        block = {"state": Int(state), "pos": List[Int]([Int(i % 30), Int(i // 300), Int(i // 30 % 10)])}
        chest = {"nbt": Compound({"n": Int(i)})} if i in (0, 1, 40, 2000, 2999) else {}
        other_order = dict(reversed(block.items())) if 500 < i < 1000 else block
        blocks.append(Compound({**other_order, **chest}))
    palette = [Compound({"Name": String(name)}) for name in names]
    root = {
        "size": List[Int]([Int(30), Int(10), Int(10)]),
        "palette": List[Compound](palette),
        "blocks": List[Compound](blocks),
    }
    loaded = read(saved(tmp_path / "a.nbt", Compound(root)))
    assert of_build(loaded.build) == {(i % 30, i // 300, i // 30 % 10): names[state] for i, state in enumerate(states)}
    assert loaded.lost == Lost(5, 0)


def test_other_endings(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"\.schem, \.litematic, \.nbt") as raised:
        read(tmp_path / "a.schematic")
    assert raised.value.name == "file"


# --- the reference's JSON --------------------------------------------------------------------------------------------


@IN_A_FOLDER
@given(build=BUILDS)
def test_the_json_of_the_reference(tmp_path: Path, build: Build) -> None:
    [path] = export.write(build, tmp_path / "a.json", NEWEST)
    data = json.loads(path.read_text("utf-8"))
    assert (data["width"], data["height"], data["depth"]) == build.size
    [frame] = data["frames"]
    found = {}
    for cuboid in frame:
        state = BlockState(cuboid["type"], tuple(sorted(cuboid["properties"].items())))
        for cell in np.ndindex(*np.subtract(cuboid["end"], cuboid["start"])):
            x, y, z = np.add(np.add(cell, cuboid["start"]), build.origin).tolist()
            assert (x, y, z) not in found
            found[x, y, z] = str(state)
    assert found == of_build(build)
    assert set(frame[0]) == {"start", "end", "fill", "type", "properties", "stack"}


def test_frames_share_a_box(tmp_path: Path) -> None:
    one, two = made((0, 0, 0), [[[1]]], STATES), made((-2, 3, 0), [[[1, 1]]], STATES)
    export.write_frames([one, two], tmp_path / "a.json", NEWEST)
    data = json.loads((tmp_path / "a.json").read_text("utf-8"))
    assert (data["width"], data["height"], data["depth"]) == (3, 4, 2)
    assert [frame[0]["start"] for frame in data["frames"]] == [[2, 0, 0], [0, 3, 0]]


# --- versions --------------------------------------------------------------------------------------------------------


def test_versions() -> None:
    assert game_version("v1.20.4 ").data_version == 3700
    assert game_version().data_version == load_table().data_version
    assert game_version("1.21.11").pack_format == (94, 1)
    assert game_version("1.20").is_before("1.20.3")
    with pytest.raises(SceneError, match=r"`1\.21\.99`") as raised:
        game_version("1.21.99")
    assert raised.value.name == "value"
    assert "1.21.9" in str(raised.value.hint)


def test_older_versions_have_older_names(tmp_path: Path) -> None:
    states = [BlockState("minecraft:short_grass"), BlockState("minecraft:oak_sign"), BlockState("minecraft:stone")]
    build = made((0, 0, 0), [[[1, 2, 3]]], states)
    for version, names in {"1.13.2": {"grass", "sign", "stone"}, "1.20.2": {"grass", "oak_sign", "stone"}}.items():
        write_litematic(build, tmp_path / "a.litematic", game_version(version))
        written = {state.name.removeprefix("minecraft:") for state in read(tmp_path / "a.litematic").build.palette}
        assert written == names | {"air"}
    assert fitted(build, NEWEST).build is build


def test_names_beyond_ascii(tmp_path: Path) -> None:
    path = tmp_path / "Haus \U0001f3e0.litematic"
    write_litematic(SMALL, path, NEWEST)
    assert_same(SMALL, read(path).build)
    assert b"Haus \xed\xa0\xbc\xed\xbf\xa0" in gzip.decompress(path.read_bytes())
