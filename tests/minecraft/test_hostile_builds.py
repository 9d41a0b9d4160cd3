"""Files of builds that lie: one clear message, little memory."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path
from typing import Any

import nbtlib
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nbtlib import ByteArray, Compound, Int, IntArray, List, LongArray, Short, String
from searching import many, places
from support import peak_bytes

from minecraft.builds import STATES, made
from scenelang.backends.minecraft import nbt
from scenelang.backends.minecraft.build_files import game_version, write_litematic, write_schematic, write_structure
from scenelang.backends.minecraft.export import read
from scenelang.grammar.diagnostics import SceneError

BUILD = made((1, 2, 3), np.arange(24).reshape(2, 3, 4), STATES)
WRITERS = {".schem": write_schematic, ".litematic": write_litematic, ".nbt": write_structure}
BY_ENDING = pytest.mark.parametrize("ending", WRITERS)
SETTINGS = settings(max_examples=many(150), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def refused(path: Path, *words: str, **limits: int) -> None:
    """Reading fails with one message that holds ``words``, and takes little memory."""

    def fail() -> None:
        with pytest.raises(SceneError) as raised:
            read(path, **limits)
        assert raised.value.name == "file"
        for word in words:
            assert word in raised.value.message, raised.value.message
        assert len(raised.value.message) < 400

    assert peak_bytes(fail) < 100_000_000


def read_or_refused(path: Path) -> None:
    try:
        read(path)
    except SceneError as error:
        assert error.name == "file"  # noqa: PT017


def plain(ending: str, folder: Path) -> bytes:
    path = folder / f"good{ending}"
    WRITERS[ending](BUILD, path, game_version())
    return gzip.decompress(path.read_bytes())


@BY_ENDING
@pytest.mark.sampled(3)
def test_every_truncation(ending: str, tmp_path: Path) -> None:
    data = plain(ending, tmp_path)
    path = tmp_path / f"a{ending}"
    for end in places(len(data)):
        path.write_bytes(data[:end])
        refused(path)
    packed = (tmp_path / f"good{ending}").read_bytes()
    for end in range(0, len(packed), 7):
        path.write_bytes(packed[:end])
        refused(path)


@BY_ENDING
@SETTINGS
@given(changes=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), min_size=1, max_size=4))
def test_changed_bytes(ending: str, tmp_path: Path, changes: list[tuple[float, int]]) -> None:
    data = bytearray(plain(ending, tmp_path))
    for at, value in changes:
        data[int(at * len(data))] = value
    path = tmp_path / f"a{ending}"
    path.write_bytes(data)
    read_or_refused(path)


@BY_ENDING
@SETTINGS
@given(data=st.binary(max_size=200))
def test_any_bytes(ending: str, tmp_path: Path, data: bytes) -> None:
    path = tmp_path / f"a{ending}"
    path.write_bytes(data)
    read_or_refused(path)
    path.write_bytes(b"\x0a\0\0" + data)
    read_or_refused(path)


@BY_ENDING
def test_no_file_and_a_folder(ending: str, tmp_path: Path) -> None:
    refused(tmp_path / f"a{ending}", "cannot read")
    (tmp_path / f"a{ending}").mkdir()
    refused(tmp_path / f"a{ending}", "cannot read")


def test_a_bomb(tmp_path: Path) -> None:
    path = tmp_path / "a.schem"
    path.write_bytes(gzip.compress(b"\x0a\0\0" + bytes(50_000_000)))
    refused(path, "decompresses to more than the limit of 1,000,000 bytes", largest=1_000_000)
    path.write_bytes(bytes(2_000_000))
    refused(path, "larger than the limit of 1,000,000", largest=1_000_000)


# --- the binary format -----------------------------------------------------------------------------------------------


def root(payload: bytes) -> bytes:
    """A root compound that holds one tag ``a``, whose kind and payload follow."""
    return b"\x0a\0\0" + payload[:1] + b"\0\x01a" + payload[1:] + b"\0"


DEEP = b"\x0a" + b"\x0a\0\x01a" * 100_000
DEEP_LIST = b"\x09" + b"\x09\0\0\0\x01" * 100_000
ENDLESS = struct.pack(">i", 2**31 - 1)
LIES = {
    "compounds": (DEEP, "nested deeper"),
    "lists": (DEEP_LIST, "nested deeper"),
    "nothing": (b"\x09\0" + ENDLESS, "tag type 0"),
    "long array": (b"\x0c" + ENDLESS, "unexpected end of data"),
    "list of longs": (b"\x09\x04" + ENDLESS, "unexpected end of data"),
    "list of texts": (b"\x09\x08" + ENDLESS, "unexpected end of data"),
    "kind": (b"\x0d", "tag type 13"),
    "tags": (b"\x09\x0a" + ENDLESS + bytes(3_000_000), "tags"),
}


@pytest.mark.parametrize("name", LIES)
def test_lies_of_the_binary_format(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nbt, "MAX_TAGS", 200_000)
    payload, words = LIES[name]
    (tmp_path / "a.nbt").write_bytes(root(payload))
    refused(tmp_path / "a.nbt", words)


# --- the formats -----------------------------------------------------------------------------------------------------


def schematic(**changed: Any) -> Compound:
    blocks = {"Palette": Compound({"minecraft:stone": Int(0)}), "Data": ByteArray([0, 0, 0, 0])}
    tag = {"Version": Int(3), "Width": Short(2), "Height": Short(1), "Length": Short(2), **changed}
    for name in ("Palette", "Data"):
        if name in tag:
            blocks[name] = tag.pop(name)
    return Compound({"Schematic": Compound({"Blocks": Compound(blocks), **tag})})


SCHEMATICS = {
    "version": (schematic(Version=Int(4)), "version 4"),
    "no version": (schematic(Version=String("3")), "`Version`"),
    "huge": (schematic(Width=Short(-1), Height=Short(-1), Length=Short(-1)), "65,535 x 65,535"),
    "large": (schematic(Width=Short(30_000), Height=Short(5), Length=Short(1_000)), "150,000,000"),
    "few": (schematic(Data=ByteArray([0])), "does not match its size of 4"),
    "many": (schematic(Data=ByteArray([0] * 5)), "does not match its size of 4"),
    "unended": (schematic(Data=ByteArray([0, 0, 0, -1])), "does not match its size of 4"),
    "long numbers": (schematic(Data=ByteArray([-1] * 7 + [0, 0, 0, 0])), "too many bytes"),
    "ints": (schematic(Data=IntArray([0] * 4)), "`Data`"),
    "outside": (schematic(Data=ByteArray([0, 1, 0, 0])), "block index 1"),
    "palette": (schematic(Palette=List[Int]([Int(1)])), "`Palette`"),
    "number": (schematic(Palette=Compound({"stone": Int(2**31 - 1)})), "index in its palette"),
    "negative": (schematic(Palette=Compound({"stone": Int(-1)})), "index in its palette"),
    "text": (schematic(Palette=Compound({"stone": String("0")})), "`stone`"),
    "name": (schematic(Palette=Compound({"Stone!\n": Int(0)})), "not a valid block name"),
    "long name": (schematic(Palette=Compound({"a" * 50_000: Int(0)})), "not a valid block name"),
    "state": (schematic(Palette=Compound({"stone[a=b": Int(0)})), "not a valid block state"),
    "property": (schematic(Palette=Compound({'stone[a=") (x"]': Int(0)})), "an invalid property"),
    "offset": (schematic(Offset=IntArray([1, 2])), "`Offset`"),
}


@pytest.mark.parametrize("name", SCHEMATICS)
def test_schematics(name: str, tmp_path: Path) -> None:
    tag, words = SCHEMATICS[name]
    nbtlib.File(tag, gzipped=True).save(tmp_path / "a.schem")
    refused(tmp_path / "a.schem", "is not a valid Sponge schematic", words)


def triple(*numbers: int) -> Compound:
    return Compound({axis: Int(n) for axis, n in zip("xyz", numbers)})


def region(**changed: Any) -> Compound:
    palette = List[Compound]([Compound({"Name": String("minecraft:stone")})])
    tag = {
        "Position": triple(0, 0, 0),
        "Size": triple(1, 1, 1),
        "BlockStatePalette": palette,
        "BlockStates": LongArray([0]),
    }
    return Compound({**tag, **changed})


REGIONS = {
    "far": ({"a": region(), "b": region(Position=triple(2_000_000_000, 0, 0))}, "2,000,000,001"),
    "huge": ({"a": region(Size=triple(-(2**31), 2**31 - 1, 1))}, "invalid size"),
    "few": ({"a": region(Size=triple(100, 100, 100))}, "does not match its size of 1,000,000"),
    "outside": ({"a": region(BlockStates=LongArray([3]))}, "block index 3"),
    "no palette": ({"a": region(BlockStatePalette=List[Compound]([]))}, "block index 0"),
    "no states": ({"a": region(BlockStates=IntArray([0]))}, "`BlockStates`"),
    "text": ({"a": region(Size=String("1"))}, "`Size`"),
    "name": ({"a": region(BlockStatePalette=List[Compound]([Compound({"Name": Int(1)})]))}, "palette"),
    "many": ({str(i): region() for i in range(1001)}, "1,001 regions"),
    "kind": ({"a": String("region")}, "`a`"),
}


@pytest.mark.parametrize("name", REGIONS)
def test_litematica(name: str, tmp_path: Path) -> None:
    regions, words = REGIONS[name]
    nbtlib.File(Compound({"Regions": Compound(regions)}), gzipped=True).save(tmp_path / "a.litematic")
    refused(tmp_path / "a.litematic", "is not a valid Litematica schematic", words)


def placed(state: int, *pos: int) -> Compound:
    return Compound({"state": Int(state), "pos": List[Int]([Int(n) for n in pos])})


def game_structure(**changed: Any) -> Compound:
    palette = List[Compound]([Compound({"Name": String("minecraft:stone")})])
    tag = {"size": List[Int]([Int(1)] * 3), "palette": palette, "blocks": List[Compound]([placed(0, 0, 0, 0)])}
    return Compound({**tag, **changed})


STRUCTURES = {
    "huge": (game_structure(size=List[Int]([Int(2**31 - 1)] * 3)), "invalid size"),
    "negative": (game_structure(size=List[Int]([Int(-1)] * 3)), "invalid size"),
    "two sides": (game_structure(size=List[Int]([Int(1)] * 2)), "`size`"),
    "texts": (game_structure(size=List[String]([String("1")] * 3)), "`size`"),
    "outside": (game_structure(blocks=List[Compound]([placed(0, 1, 0, 0)])), "outside the structure"),
    "below": (game_structure(blocks=List[Compound]([placed(0, 0, -1, 0)])), "outside the structure"),
    "state": (game_structure(blocks=List[Compound]([placed(1, 0, 0, 0)])), "palette size 1"),
    "negative state": (game_structure(blocks=List[Compound]([placed(-1, 0, 0, 0)])), "palette size 1"),
    "no place": (game_structure(blocks=List[Compound]([Compound({"state": Int(0)})])), "`pos`"),
    "kind": (game_structure(blocks=List[List[Int]]([List[Int]([Int(1)])])), "`blocks`"),
    "properties": (game_structure(palette=List[Compound]([Compound({"Name": String("a"), "Properties": Int(1)})])), "palette"),
}  # fmt: skip


@pytest.mark.parametrize("name", STRUCTURES)
def test_structures(name: str, tmp_path: Path) -> None:
    tag, words = STRUCTURES[name]
    nbtlib.File(tag, gzipped=True).save(tmp_path / "a.nbt")
    refused(tmp_path / "a.nbt", "is not a valid structure", words)
