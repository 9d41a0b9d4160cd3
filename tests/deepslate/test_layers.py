"""Where the game's looks are read from, and what hostile packs cannot do."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

import pytest
from deepslate.packs import COLORS, DEFINITIONS, as_json, pack_files, png, write_files, write_npm, write_zip

from scenelang.backends.deepslate import looks as module
from scenelang.backends.deepslate.looks import full_name, layer_at, layers_for, number_of
from scenelang.grammar.diagnostics import SceneError


@pytest.mark.parametrize("shape", ["zip", "folder", "npm", "npm-data", "npm-version"])
def test_every_shape_gives_the_same(shape: str, tmp_path: Path) -> None:
    npm = write_npm(tmp_path / "npm")
    path = {
        "zip": write_zip(tmp_path / "pack.zip", pack_files()),
        "folder": write_files(tmp_path / "pack", pack_files()),
        "npm": npm,
        "npm-data": npm / "minecraft-assets/data",
        "npm-version": npm / "minecraft-assets/data/1.21.4",
    }[shape]
    layer = layer_at(path)
    assert layer.definition("minecraft:oak_log") == DEFINITIONS["oak_log"]
    assert layer.model("minecraft:block/stone")["parent"] == "block/cube"
    assert layer.picture("minecraft:block/glass") == png(COLORS["glass"])
    assert layer.definition("minecraft:dirt") is None
    assert layer.model("minecraft:block/dirt") is None
    assert layer.picture("minecraft:block/dirt") is None


def test_the_newest_version_is_taken(tmp_path: Path) -> None:
    for version in ("1.9", "1.21.4", "26.1", "common"):
        write_npm(tmp_path / "npm", version)
    assert layer_at(tmp_path / "npm").name.endswith("26.1")
    assert number_of("1.21.10") > number_of("1.21.9") > number_of("1.9")
    assert number_of("24w45a") == ()


@pytest.mark.parametrize(
    ("name", "full"),
    [
        ("stone", "minecraft:stone"),
        ("block/stone", "minecraft:block/stone"),
        ("mod:block/x.y", "mod:block/x.y"),
        ("../../etc/passwd", None),
        ("block/../x", None),
        ("..:block/x", None),
        ("/etc/passwd", None),
        ("C:\\x", None),
        ("a" * 400, None),
        (None, None),
        (3, None),
    ],
)
def test_names_lead_nowhere_else(name: object, full: str | None) -> None:
    assert full_name(name) == full


def test_links_do_not_lead_out_of_a_folder(tmp_path: Path) -> None:
    pack = write_files(tmp_path / "pack", pack_files())
    (tmp_path / "secret.png").write_bytes(b"secret")
    (pack / "assets/minecraft/textures/block/link.png").symlink_to(tmp_path / "secret.png")
    assert layer_at(pack).picture("minecraft:block/link") is None


def test_a_file_that_unpacks_to_much_is_refused(tmp_path: Path) -> None:
    bomb = {"assets/minecraft/textures/block/stone.png": b"\0" * (module.MAX_PICTURE_BYTES + 1)}
    with pytest.raises(SceneError, match="larger than the limit of 8,000,000 bytes"):
        layer_at(write_zip(tmp_path / "bomb.zip", bomb)).picture("minecraft:block/stone")


def test_a_file_that_lies_about_its_size_is_refused(tmp_path: Path) -> None:
    name = "assets/minecraft/textures/block/stone.png"
    path = write_zip(tmp_path / "bomb.zip", {name: b"\0" * (module.MAX_PICTURE_BYTES + 1)})
    data = bytearray(path.read_bytes())
    at = data.rindex(b"PK\x01\x02")
    data[at + 24 : at + 28] = struct.pack("<I", 10)
    path.write_bytes(data)
    with pytest.raises(SceneError) as raised:
        layer_at(path).picture("minecraft:block/stone")
    assert raised.value.name == "file"


@pytest.mark.parametrize("content", [b"", b"no zip", b"PK\x03\x04 damaged"])
def test_what_is_no_zip_is_said(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "pack.zip").write_bytes(content)
    with pytest.raises(SceneError, match="contains no Minecraft textures"):
        layer_at(tmp_path / "pack.zip")


def test_a_damaged_file_of_a_zip_is_said(tmp_path: Path) -> None:
    path = tmp_path / "pack.zip"
    name = "assets/minecraft/blockstates/stone.json"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(name, "{}")
    data = path.read_bytes().replace(b"{}", b"[]")  # the checksum is wrong now
    path.write_bytes(data)
    with pytest.raises(SceneError, match="cannot read"):
        layer_at(path).definition("minecraft:stone")


@pytest.mark.parametrize("text", [b"{", b"\xff", b"[" * 200_000])
def test_what_is_no_json_is_said(text: bytes, tmp_path: Path) -> None:
    path = write_zip(tmp_path / "pack.zip", {"assets/minecraft/models/block/stone.json": text})
    with pytest.raises(SceneError, match="is not valid JSON"):
        layer_at(path).model("minecraft:block/stone")


def test_without_any_looks_the_user_is_told_what_to_do() -> None:
    with pytest.raises(SceneError) as raised:
        layers_for("")
    assert raised.value.message == "Minecraft's textures were not found on this machine"
    assert "--textures" in (raised.value.diagnostic.hint or "")


def test_a_missing_path_is_named() -> None:
    with pytest.raises(SceneError, match=r"the texture path `nowhere\.zip`"):
        layers_for("nowhere.zip")


def test_the_usual_places_and_their_order(tmp_path: Path, pack: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    game = tmp_path / "home/.minecraft/versions"
    for version in ("1.9", "1.21.10", "1.21.9"):
        write_zip(game / version / f"{version}.jar", pack_files())
    assert [layer.name for layer in layers_for("")] == [str(game / "1.21.10/1.21.10.jar")]
    assert [Path(layer.name).name for layer in layers_for(str(pack))] == ["pack.zip", "1.21.10.jar"]
    monkeypatch.setenv("SCENELANG_MINECRAFT", str(pack))
    assert [Path(layer.name).name for layer in layers_for("")] == ["pack.zip", "1.21.10.jar"]


def test_the_package_of_npm_is_found_where_one_works(tmp_path: Path) -> None:
    write_npm(tmp_path / "home/node_modules/minecraft-assets")
    (layer,) = layers_for("")
    assert layer.definition("minecraft:stone") == DEFINITIONS["stone"]


def test_byte_order_marks_are_read(tmp_path: Path) -> None:
    path = write_zip(tmp_path / "p.zip", {"assets/minecraft/blockstates/a.json": b"\xef\xbb\xbf" + as_json({"x": 1})})
    assert layer_at(path).definition("minecraft:a") == {"x": 1}
