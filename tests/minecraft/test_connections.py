"""Arms and corners as the game makes them, in small builds whose states one can look up there."""

from __future__ import annotations

import numpy as np
import pytest
from transpile.cases import CORPUS, IMITATIONS, Case, scene_of, translated

from minecraft.oracle import of_build
from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, Build, load_table
from scenelang.backends.minecraft.connections import Settled, settled
from scenelang.backends.minecraft.voxels import Voxels, voxelised

MINECRAFT = [case for case in (*CORPUS, *IMITATIONS) if "set_cuboid" in case.text]
Cell = tuple[int, int, int]


def state_of(text: str) -> BlockState:
    name, _, given = text.rstrip("]").partition("[")
    pairs = tuple(sorted((pair.split("=")[0], pair.split("=")[1]) for pair in given.split(",") if pair))
    return BlockState(f"minecraft:{name}", pairs)


def settle(blocks: dict[Cell, str]) -> Settled:
    """Blocks by cell, as a program would ask for them."""
    low = np.min(list(blocks), axis=0)
    cells = np.zeros(np.max(list(blocks), axis=0) - low + 1, np.uint32)
    palette = [AIR_STATE]
    for cell, text in blocks.items():
        state = state_of(text)
        if state not in palette:
            palette.append(state)
        cells[tuple(np.array(cell) - low)] = palette.index(state)
    x, y, z = low.tolist()
    return settled(Voxels(Build((x, y, z), cells, tuple(palette)), (None,) * len(palette), ()))


def look(blocks: dict[Cell, str], cell: Cell = (0, 0, 0)) -> dict[str, str]:
    """The properties of one cell in the end."""
    build = settle(blocks).build
    where = np.array(cell) - np.array(build.origin)
    return dict(build.palette[int(build.cells[tuple(where)])].properties)


def arms(properties: dict[str, str]) -> dict[str, str]:
    """The sides with an arm, by their first letters."""
    return {
        side[0]: properties[side]
        for side in ("north", "east", "south", "west")
        if properties[side] not in ("false", "none")
    }


NORTH, EAST, SOUTH, WEST, UP = (0, 0, -1), (1, 0, 0), (0, 0, 1), (-1, 0, 0), (0, 1, 0)


@pytest.mark.parametrize(
    ("block", "neighbor", "meets"),
    [
        ("oak_fence", "oak_fence", True),
        ("oak_fence", "birch_fence", True),
        ("oak_fence", "nether_brick_fence", False),
        ("nether_brick_fence", "nether_brick_fence", True),
        ("oak_fence", "stone", True),
        ("oak_fence", "oak_leaves", False),
        ("oak_fence", "oak_slab", False),
        ("oak_fence", "oak_slab[type=double]", True),
        ("oak_fence", "cobblestone_wall", False),
        ("oak_fence", "glass_pane", False),
        ("oak_fence", "oak_fence_gate[facing=north]", True),
        ("oak_fence", "oak_fence_gate[facing=east]", False),
        ("oak_fence", "oak_stairs[facing=west]", True),
        ("oak_fence", "oak_stairs[facing=east]", False),
        ("oak_fence", "torch", False),
        ("glass_pane", "iron_bars", True),
        ("glass_pane", "cobblestone_wall", True),
        ("glass_pane", "glass", True),
        ("glass_pane", "oak_fence", False),
        ("glass_pane", "jack_o_lantern", False),
        ("cobblestone_wall", "brick_wall", True),
        ("cobblestone_wall", "iron_bars", True),
        ("cobblestone_wall", "oak_fence", False),
        ("cobblestone_wall", "oak_fence_gate[facing=north]", True),
        ("cobblestone_wall", "stone", True),
    ],
)
def test_what_meets_what_to_the_east(block: str, neighbor: str, meets: bool) -> None:
    found = arms(look({(0, 0, 0): block, EAST: neighbor}))
    assert found == ({"e": "low" if block.endswith("_wall") else "true"} if meets else {})


def test_all_sides() -> None:
    stone = dict.fromkeys((NORTH, EAST, SOUTH, WEST), "stone")
    for block in ("oak_fence", "glass_pane", "iron_bars"):
        assert arms(look({(0, 0, 0): block, **stone})) == dict.fromkeys("nesw", "true")
    for side, letter in ((NORTH, "n"), (EAST, "e"), (SOUTH, "s"), (WEST, "w")):
        assert arms(look({(0, 0, 0): "oak_fence", side: "stone"})) == {letter: "true"}


def test_what_the_program_sets_stays() -> None:
    assert arms(look({(0, 0, 0): "oak_fence[east=false,west=true]", EAST: "stone", NORTH: "stone"})) == {
        "w": "true",
        "n": "true",
    }
    assert (
        look({(0, 0, 0): "oak_stairs[facing=north,shape=straight]", NORTH: "oak_stairs[facing=west]"})["shape"]
        == "straight"
    )


def wall(*others: tuple[Cell, str]) -> dict[str, str]:
    return look({(0, 0, 0): "cobblestone_wall", **dict(others)})


def test_posts_of_walls() -> None:
    line = ((EAST, "cobblestone_wall"), (WEST, "cobblestone_wall"))
    assert wall()["up"] == "true"
    assert wall(line[0])["up"] == "true"  # an end
    assert wall(*line)["up"] == "false"
    assert wall(*line, (NORTH, "cobblestone_wall"))["up"] == "true"
    assert wall(*line, (NORTH, "stone"), (SOUTH, "stone"))["up"] == "false"  # a crossing
    assert wall(*line, (UP, "torch"))["up"] == "true"
    assert wall(*line, (UP, "oak_fence"))["up"] == "true"
    under = wall(*line, (UP, "stone"))
    assert (under["east"], under["west"], under["up"]) == ("tall", "tall", "false")
    low = wall(*line, (UP, "oak_slab[type=top]"))
    assert (low["east"], low["up"]) == ("low", "false")


def test_a_post_goes_down_through_all_walls() -> None:
    blocks = {(x, y, 0): "cobblestone_wall" for x in (-1, 0, 1) for y in range(4)}
    blocks[0, 4, 0] = "torch"
    assert all(look(blocks, (0, y, 0))["up"] == "true" for y in range(4))
    assert look(blocks, (0, 0, 0))["east"] == "tall"
    assert look(blocks, (0, 3, 0))["east"] == "low"
    del blocks[0, 4, 0]
    assert all(look(blocks, (0, y, 0))["up"] == "false" for y in range(4))


@pytest.mark.parametrize(
    ("where", "other", "shape"),
    [
        (NORTH, "oak_stairs[facing=west]", "outer_left"),
        (NORTH, "oak_stairs[facing=east]", "outer_right"),
        (SOUTH, "oak_stairs[facing=west]", "inner_left"),
        (SOUTH, "stone_brick_stairs[facing=east]", "inner_right"),
        (SOUTH, "oak_stairs[facing=south]", "straight"),
        (EAST, "oak_stairs[facing=west]", "straight"),
        (NORTH, "oak_stairs[facing=west,half=top]", "straight"),
        (NORTH, "oak_planks", "straight"),
    ],
)
def test_corners_of_stairs_that_face_north(where: Cell, other: str, shape: str) -> None:
    assert look({(0, 0, 0): "oak_stairs[facing=north]", where: other})["shape"] == shape


def test_a_row_of_stairs_goes_on_past_a_corner() -> None:
    blocks = {(0, 0, 0): "oak_stairs[facing=north]", NORTH: "oak_stairs[facing=west]", EAST: "oak_stairs[facing=north]"}
    assert look(blocks)["shape"] == "straight"


def test_a_roof_around_a_square() -> None:
    """Stairs that climb to the middle from all sides: the corners are outer ones."""
    blocks: dict[Cell, str] = {}
    for i in range(5):
        blocks[i, 0, 0] = "oak_stairs[facing=south]"
        blocks[i, 0, 4] = "oak_stairs[facing=north]"
    for k in range(1, 4):
        blocks[0, 0, k] = "oak_stairs[facing=east]"
        blocks[4, 0, k] = "oak_stairs[facing=west]"
    shapes = {cell: look(blocks, cell)["shape"] for cell in blocks}
    corners = {(0, 0, 0): "outer_left", (4, 0, 0): "outer_right", (0, 0, 4): "outer_right", (4, 0, 4): "outer_left"}
    assert {cell: shape for cell, shape in shapes.items() if shape != "straight"} == corners


# --- whole builds ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", MINECRAFT, ids=lambda case: case.name)
@pytest.mark.sampled(3)
def test_the_corpus_becomes_states_that_the_game_has(case: Case) -> None:
    blocks = load_table().blocks
    voxels = voxelised(scene_of(case.name, translated(case).text).root)
    found = settled(voxels)
    dropped = [warning for warning in found.warnings if warning.name == "block-property"]
    assert len(dropped) == (case.name == "minecraft-city-houses-loop-kwargs")  # beetroots of age 6: there is no such
    build = found.build
    assert all(blocks[state.name].allows(state) for state in build.palette)
    assert len(set(build.palette)) == len(build.palette)
    assert np.array_equal(build.cells == 0, voxels.build.cells == 0)
    assert set(np.unique(build.cells).tolist()) | {0} == set(range(len(build.palette)))


def test_equal_states_become_one_and_each_unknown_block_warns_once() -> None:
    found = settle({(0, 0, 0): "oak_log", EAST: "oak_log[axis=y]", UP: "marble", NORTH: "marble"})
    assert len(found.build.palette) == 3
    assert len(found.warnings) == 1
    assert set(of_build(found.build).values()) == {"minecraft:oak_log[axis=y]", "minecraft:quartz_block"}


def test_nothing() -> None:
    build = Build((0, 0, 0), np.zeros((0, 0, 0), np.uint32), (AIR_STATE,))
    assert settled(Voxels(build, (None,), ())).build.palette == (AIR_STATE,)
