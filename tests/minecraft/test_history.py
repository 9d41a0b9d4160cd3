"""Builds for older versions of the game, against states that minecraft-data lists for these versions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, Build, load_table
from scenelang.backends.minecraft.build_files import fitted, game_version, too_new
from scenelang.backends.minecraft.connections import resolve
from scenelang.cli.main import main


def built(*states: BlockState) -> Build:
    cells = np.arange(1, len(states) + 1, dtype=np.uint32).reshape(-1, 1, 1)
    return Build((0, 0, 0), cells, (AIR_STATE, *states))


def then(name: str, version: str, **properties: str) -> str:
    """A block as a version has it, with its defaults and these properties."""
    found = fitted(built(resolve(name, properties).state), game_version(version))
    (state,) = found.build.palette[1:]
    return str(state).removeprefix("minecraft:")


@pytest.mark.parametrize(
    ("name", "version", "properties", "wanted"),
    [
        ("stone", "1.13", {}, "stone"),
        ("oak_leaves", "1.18.2", {}, "oak_leaves[distance=7,persistent=false]"),
        ("oak_leaves", "1.19", {}, "oak_leaves[distance=7,persistent=false,waterlogged=false]"),
        ("lantern", "1.15.2", {"hanging": "true"}, "lantern[hanging=true]"),
        ("lantern", "1.16.2", {}, "lantern[hanging=false,waterlogged=false]"),
        ("short_grass", "1.20.2", {}, "grass"),
        ("short_grass", "1.20.3", {}, "short_grass"),
        ("dirt_path", "1.16.5", {}, "grass_path"),
        ("iron_chain", "1.16.2", {"axis": "x"}, "chain[axis=x,waterlogged=false]"),
        ("iron_chain", "1.21.9", {"axis": "x"}, "iron_chain[axis=x,waterlogged=false]"),
        ("oak_sign", "1.13.2", {"rotation": "3"}, "sign[rotation=3,waterlogged=false]"),
        (
            "cobblestone_wall", "1.15.2", {"north": "tall", "east": "low"},
            "cobblestone_wall[east=true,north=true,south=false,up=true,waterlogged=false,west=false]",
        ),
        (
            "cobblestone_wall", "1.16", {"north": "tall"},
            "cobblestone_wall[east=none,north=tall,south=none,up=true,waterlogged=false,west=none]",
        ),
    ],
)  # fmt: skip
def test_states_of_then(name: str, version: str, properties: dict[str, str], wanted: str) -> None:
    assert then(name, version, **properties) == wanted


def test_blocks_that_came_later_are_air_and_told() -> None:
    build = built(BlockState("minecraft:stone"), BlockState("minecraft:cherry_planks"), BlockState("minecraft:dirt"))
    found = fitted(build, game_version("1.16"))
    assert found.missing == ("minecraft:cherry_planks",)
    assert [str(state) for state in found.build.palette] == ["minecraft:air", "minecraft:stone", "minecraft:dirt"]
    assert found.build.cells.reshape(-1).tolist() == [1, 0, 2]
    warning = too_new(found.missing, game_version("1.16"))
    assert warning is not None
    assert "Minecraft 1.16 does not have `minecraft:cherry_planks`" in warning.message
    assert too_new((), game_version("1.16")) is None


def test_nothing_changes_for_the_tables_version() -> None:
    kinds = load_table().blocks.values()
    build = built(*(BlockState(kind.name, tuple(sorted(kind.defaults.items()))) for kind in kinds))
    assert fitted(build, game_version("26.1")).build is build
    assert fitted(build, game_version("26.1.2")).build is build


def test_blocks_of_other_namespaces_stay() -> None:
    build = built(BlockState("create:cog", (("axis", "x"),)))
    assert fitted(build, game_version("1.13")).build is build


@pytest.mark.parametrize("ending", [".mcfunction", ".schem", ".litematic", ".nbt", ".zip"])
def test_the_user_is_told(ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = '(bind "a" (lambda () (union (call "set-cuboid" :block-type "stone") (transform (call "set-cuboid" :block-type "cherry_planks") (translate [2 0 0])))))'
    (tmp_path / "a.scene").write_text(text, "utf-8")
    assert (
        main(["export", str(tmp_path / "a.scene"), "-o", str(tmp_path / f"a{ending}"), "--mc-version", "1.16.5"]) == 0
    )
    assert "W620" in capsys.readouterr().err
    assert b"cherry" not in (tmp_path / f"a{ending}").read_bytes()
