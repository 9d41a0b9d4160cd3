"""Builds whose properties are of earlier versions of the game: each is laid, as what it was."""

from __future__ import annotations

from pathlib import Path

import pytest
from transpile.cases import scene_of

from scenelang.backends.base import BackendOptions
from scenelang.backends.minecraft.blocks import load_table
from scenelang.backends.minecraft.connections import resolve
from scenelang.backends.minecraft.export import SCHEM
from scenelang.grammar.diagnostics import Diagnostic

TABLE = load_table()

# What a program of its time says, and what the game calls it today.
OLD = {
    "cauldron[level=3]": "water_cauldron[level=3]",
    "cauldron[level=0]": "cauldron",
    "cobblestone_wall[east=true,west=false]": "cobblestone_wall[east=low,west=none]",
    "brick_wall[north=true]": "brick_wall[north=low]",
    "stone[variant=granite]": "granite",
    "stone[variant=smooth_andesite]": "polished_andesite",
    "planks[variant=dark_oak]": "dark_oak_planks",
    "wool[color=silver]": "light_gray_wool",
    "stained_hardened_clay[color=cyan]": "cyan_terracotta",
    "stained_glass[color=red]": "red_stained_glass",
    "log[axis=x,variant=spruce]": "spruce_log[axis=x]",
    "oak_log[axis=none]": "oak_wood",
    "stone_slab[half=top,variant=brick]": "brick_slab[type=top]",
    "wooden_slab[half=bottom,variant=birch]": "birch_slab[type=bottom]",
    "leaves[decayable=false,variant=jungle]": "jungle_leaves[persistent=true]",
    "torch[facing=east]": "wall_torch[facing=east]",
    "torch[facing=up]": "torch",
    "redstone_torch[facing=north]": "redstone_wall_torch[facing=north]",
    "sponge[wet=true]": "wet_sponge",
    "sponge[wet=false]": "sponge",
    "sandstone[type=smooth_sandstone]": "cut_sandstone",
    "stonebrick[variant=mossy_stonebrick]": "mossy_stone_bricks",
    "quartz_block[variant=lines_z]": "quartz_pillar[axis=z]",
    "prismarine[variant=prismarine_bricks]": "prismarine_bricks",
    "oak_door[half=top]": "oak_door[half=upper]",
    "lever[facing=up]": "lever[face=floor]",
    "tallgrass[type=fern]": "fern",
    "double_plant[half=upper,variant=paeonia]": "peony[half=upper]",
    "bed[color=blue,facing=east]": "blue_bed[facing=east]",
    "dirt[variant=podzol]": "podzol",
}


def parsed(text: str) -> tuple[str, dict[str, str]]:
    name, _, rest = text.removesuffix("]").partition("[")
    return name, dict(pair.split("=") for pair in rest.split(",") if pair)


@pytest.mark.parametrize("old", list(OLD))
def test_old_states_are_what_they_were(old: str) -> None:
    found = resolve(*parsed(old))
    name, wanted = parsed(OLD[old])
    assert found.state.name == f"minecraft:{name}"
    assert wanted.items() <= dict(found.state.properties).items()
    assert not [each for each in found.warnings if each.name == "block-property"]
    assert TABLE.blocks[found.state.name].allows(found.state)


@pytest.mark.parametrize("old", [*OLD, "anvil[damage=1]", "oak_stairs[facing=up]", "lantern[facing=north]"])
def test_no_property_loses_a_build(old: str, tmp_path: Path) -> None:
    told: list[Diagnostic] = []
    moved = f'(transform (call "set-cuboid" :block-type "{old}") (translate [3 0 0]))'
    text = f'(bind "build" (lambda () (union {moved} (call "set-cuboid" :block-type "stone"))))'
    SCHEM.run(scene_of("a.scene", text), tmp_path / "a.schem", BackendOptions(warn=told.append))
    assert (tmp_path / "a.schem").stat().st_size > 0
    left_out = [each for each in told if each.name == "block-property"]
    assert bool(left_out) == (old not in OLD)
    assert all(each.span is not None for each in left_out)


def test_every_state_of_today_stays_as_it_is() -> None:
    for kind in TABLE.blocks.values():
        for name, values in kind.values.items():
            for value in values:
                found = resolve(kind.name, {name: value})
                assert found.state.name == kind.name
                assert dict(found.state.properties)[name] == value
                assert not found.warnings
