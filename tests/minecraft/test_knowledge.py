"""What is known of blocks: the table, defaults, impossible properties, names that the game has not."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenelang.backends.minecraft.blocks import ALIASES, RENAMES, BlockState, jaro_winkler, load_table
from scenelang.backends.minecraft.connections import resolve

TABLE = load_table()
ROWS: list[Any] = json.loads(Path(__file__).with_name("blocks-26.1.json").read_text("utf-8"))  # of minecraft-data


def states(row: Any) -> list[BlockState]:
    """Every state in the game's own order: the last property changes fastest."""
    found: list[tuple[tuple[str, str], ...]] = [()]
    for state in row["states"]:
        values = state.get("values", ["true", "false"])
        found = [(*each, (state["name"], value)) for each in found for value in values]
    return [BlockState(f"minecraft:{row['name']}", tuple(sorted(each))) for each in found]


# --- the table -------------------------------------------------------------------------------------------------------


def test_the_table_is_of_one_version() -> None:
    assert (TABLE.version, TABLE.data_version) == ("26.1", 4786)
    assert len(TABLE.blocks) > 1_100


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["name"])
def test_states_are_those_of_the_game(row: Any) -> None:
    every = states(row)
    assert len(every) == row["maxStateId"] - row["minStateId"] + 1
    kind = TABLE.blocks[f"minecraft:{row['name']}"]
    assert all(kind.allows(state) for state in every)
    assert resolve(row["name"]).state == every[row["defaultState"] - row["minStateId"]]
    for state in every:
        assert resolve(state.name, dict(state.properties)).state == state


def test_every_block_resolves_to_itself() -> None:
    for name, kind in TABLE.blocks.items():
        found = resolve(name)
        assert found.state.name == name
        assert kind.allows(found.state)
        assert not found.warnings
        assert kind.color is None or all(0 <= n <= 255 for n in kind.color)
        assert 0.0 < kind.opacity <= 1.0


@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("stone", "cube"),
        ("glass", "cube"),
        ("oak_slab", "slab"),
        ("oak_stairs", "stairs"),
        ("iron_bars", "pane"),
        ("oak_fence", "fence"),
        ("oak_fence_gate", "gate"),
        ("brick_wall", "wall"),
        ("poppy", "plant"),
        ("torch", "thin"),
        ("chest", "box"),
        ("water", "fluid"),
        ("oak_door", "door"),
        ("oak_trapdoor", "trapdoor"),
        ("cave_air", "air"),
    ],
)
def test_shapes(name: str, shape: str) -> None:
    assert TABLE.blocks[f"minecraft:{name}"].shape == shape


def test_looks() -> None:
    def of(name: str) -> Any:
        return TABLE.blocks[f"minecraft:{name}"]

    red, green, blue = of("red_wool").color
    assert red > 130 > 80 > max(green, blue)
    red, green, blue = of("oak_leaves").color
    assert green > max(red, blue)  # tinted, though the picture is grey
    red, green, blue = of("water").color
    assert blue > max(red, green)
    assert of("stone").opacity == 1.0
    assert of("glass").opacity < 0.5 < of("ice").opacity < 1.0
    assert of("glowstone").light == 15
    assert of("barrier").color is None


# --- properties ------------------------------------------------------------------------------------------------------


def test_defaults_fill_what_is_missing() -> None:
    found = resolve("minecraft:oak_stairs", {"facing": "east"})
    assert str(found.state) == "minecraft:oak_stairs[facing=east,half=bottom,shape=straight,waterlogged=false]"
    assert found.given == {"facing"}


@pytest.mark.parametrize(
    ("name", "given", "told", "hint"),
    [
        ("oak_stairs", {"fasing": "east"}, "`facing`, `half`, `shape` and `waterlogged`", "did you mean `facing`?"),
        (
            "oak_stairs",
            {"facing": "nort"},
            "must be `north`, `south`, `west` or `east`; `nort` is ignored",
            "did you mean `north`?",
        ),
        ("stone", {"facing": "north"}, "it has no properties", None),
        ("chain", {"axis": "w"}, "minecraft:iron_chain", None),
    ],
)
def test_impossible_properties(name: str, given: dict[str, str], told: str, hint: str | None) -> None:
    """What a block does not take is left out, with a warning; its other properties are laid as they are given."""
    found = resolve(name, {**given, "waterlogged": "true"} if name == "oak_stairs" else given)
    (warning,) = found.warnings
    assert warning.name == "block-property"
    assert told in warning.message
    assert warning.hint == hint
    assert TABLE.blocks[found.state.name].allows(found.state)
    assert name != "oak_stairs" or dict(found.state.properties)["waterlogged"] == "true"


# --- names -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new"),
    [("chain", "iron_chain"), ("grass", "short_grass"), ("grass_path", "dirt_path"), ("sign", "oak_sign")],
)
def test_renames_both_ways(old: str, new: str) -> None:
    found = resolve(old)
    assert (found.state.name, found.warnings) == (f"minecraft:{new}", ())
    blocks = dict(TABLE.blocks)
    kind = blocks.pop(f"minecraft:{new}")
    older = replace(TABLE, blocks={**blocks, f"minecraft:{old}": replace(kind, name=f"minecraft:{old}")})
    found = resolve(new, table=older)
    assert (found.state.name, found.warnings) == (f"minecraft:{old}", ())


def test_every_rename_and_alias_leads_somewhere() -> None:
    for old, new in RENAMES:
        assert f"minecraft:{new}" in TABLE.blocks, (old, new)
    for said, meant in ALIASES.items():
        assert f"minecraft:{meant}" in TABLE.blocks, said


@pytest.mark.parametrize(
    ("asked", "laid"),
    [
        ("silver_wool", "light_gray_wool"), ("oakplanks", "oak_planks"), ("Oak Plank", "oak_planks"), ("marble", "quartz_block"),
        ("wooden_stairs", "oak_stairs"), ("marble_stairs", "quartz_stairs"), ("grey_wool", "gray_wool"),
        ("glass_block", "glass"), ("cobble", "cobblestone"), ("red_brick", "bricks"), ("birch_stair", "birch_stairs"),
        ("dark_gray_concrete", "gray_concrete"), ("create:oak_planks", "oak_planks"),
    ],
)  # fmt: skip
def test_unknown_blocks(asked: str, laid: str) -> None:
    found = resolve(asked)
    assert found.state.name == f"minecraft:{laid}"


def test_the_warning_names_both_and_what_was_dropped() -> None:
    found = resolve("mahogany_stairs", {"facing": "east", "grain": "fine"})
    assert found.state.name.endswith("_stairs")
    assert dict(found.state.properties)["facing"] == "east"
    (warning,) = found.warnings
    assert warning.code == "W616"
    assert "`minecraft:mahogany_stairs`" in warning.message
    assert found.state.name in warning.message
    assert warning.message.endswith("without grain=fine")


@given(
    st.one_of(
        st.text(min_size=1, max_size=30),
        st.sampled_from(["comand_block", "structur_block", "jig_saw", "barier", "lights"]),
    )
)
def test_any_name_gives_a_valid_state_and_no_operators_block(name: str) -> None:
    if f"minecraft:{name}" in TABLE.blocks or not name.strip():
        return
    found = resolve(name)
    kind = TABLE.blocks[found.state.name]
    assert kind.allows(found.state)
    assert not kind.is_for_operators or not found.warnings


def test_similarity_of_meaning_fills_in_where_letters_say_little() -> None:
    def similar(text: str, names: Sequence[str]) -> str:
        assert text == "ancient ruby thing"
        assert "barrier" not in names
        return "redstone_block"

    assert resolve("ancient_ruby_thing", similar=similar).state.name == "minecraft:redstone_block"
    assert resolve("oakplanks", similar=lambda *_: "stone").state.name == "minecraft:oak_planks"
    assert resolve("ancient_ruby_thing", similar=lambda *_: "nonsense").warnings


@pytest.mark.parametrize(
    ("a", "b", "score"),
    [
        ("martha", "marhta", 0.9611),
        ("dixon", "dicksonx", 0.8133),
        ("dwayne", "duane", 0.84),
        ("a", "a", 1.0),
        ("a", "b", 0.0),
        ("", "", 1.0),
    ],
)
def test_jaro_winkler(a: str, b: str, score: float) -> None:
    """The values of Winkler's own examples."""
    assert jaro_winkler(a, b) == pytest.approx(score, abs=1e-4)


def test_long_names_are_no_trouble() -> None:
    found = resolve("x" * 1_000_000)
    assert len(found.warnings[0].message) < 300


@pytest.mark.parametrize(
    ("asked", "found"),
    [
        ("wool:14", "red_wool"), ("minecraft:wool:14", "red_wool"), ("planks:2", "birch_planks"), ("stone:3", "diorite"),
        ("stained_hardened_clay:11", "blue_terracotta"), ("wooden_slab:1", "spruce_slab"), ("log:1", "spruce_log"),
        ("oak_log:1", "oak_log"), ("stained_glass_pane:0", "white_stained_glass_pane"),
    ],
)  # fmt: skip
def test_names_with_numbers(asked: str, found: str) -> None:
    resolved = resolve(asked)
    assert resolved.state.name == f"minecraft:{found}"
    assert not resolved.warnings
