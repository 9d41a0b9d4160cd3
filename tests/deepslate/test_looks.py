"""Models, textures and the states of a build: what the page is given."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from deepslate.packs import COLORS, as_json, pack_files, png, write_zip

from scenelang.backends.deepslate.looks import (
    MISSING,
    BlockLook,
    BlockLooks,
    atlas_of,
    flat_model,
    layer_at,
    looks_of,
    texture_from,
    textures_of,
)
from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, load_table
from scenelang.grammar.diagnostics import SceneError


def state(name: str, **properties: str) -> BlockState:
    return BlockState(f"minecraft:{name}", tuple(sorted(properties.items())))


def looks(path: Path, *states: BlockState) -> BlockLooks:
    return looks_of((AIR_STATE, *states), [layer_at(path)])


def changed(tmp_path: Path, **files: Any) -> Path:
    """The pack with other models."""
    models = {f"assets/minecraft/models/block/{name}.json": as_json(data) for name, data in files.items()}
    return write_zip(tmp_path / "changed.zip", pack_files() | models)


def test_only_what_the_build_needs_is_taken(pack: Path) -> None:
    found = looks(pack, state("stone"))
    assert found.states == (BlockLook(()), BlockLook(({"model": "minecraft:block/stone", "x": 0, "y": 0},)))
    assert set(found.models) == {"minecraft:block/stone"}
    assert set(found.atlas.places) == {"minecraft:block/stone", MISSING}
    assert found.plain == ()


def test_models_come_without_parents_and_with_full_names(pack: Path) -> None:
    found = looks(pack, state("oak_log", axis="x"))
    (part,) = found.states[1].parts
    assert (part["x"], part["y"]) == (90, 90)
    (element,) = found.models["minecraft:block/oak_log"]["elements"]
    assert element["to"] == [16.0, 16.0, 16.0]
    assert element["faces"]["up"] == {"texture": "minecraft:block/oak_log", "rotation": 0, "cullface": "up"}


def test_parts_depend_on_properties(pack: Path) -> None:
    alone = looks(pack, state("oak_fence", east="false", west="false"))
    joined = looks(pack, state("oak_fence", east="false", west="true"))
    assert [part["model"] for part in alone.states[1].parts] == ["minecraft:block/fence_post"]
    assert [part["model"] for part in joined.states[1].parts] == ["minecraft:block/fence_post", "minecraft:block/stone"]


def test_the_first_layer_wins_and_others_fill_in(pack: Path, tmp_path: Path) -> None:
    own = write_zip(tmp_path / "own.zip", {"assets/minecraft/textures/block/stone.png": png((255, 0, 0, 255))})
    found = looks_of((AIR_STATE, state("stone")), [layer_at(own), layer_at(pack)])
    left, top, *_ = found.atlas.places["minecraft:block/stone"]
    assert tuple(pixels(found)[top, left]) == (255, 0, 0, 255)


def test_a_block_that_no_layer_has_is_a_cube_of_its_average_color(pack: Path) -> None:
    found = looks(pack, state("stone"), state("dirt"))
    (part,) = found.states[2].parts
    left, top, *_ = found.atlas.places[part["model"]]
    assert tuple(pixels(found)[top, left]) == (0x8A, 0x63, 0x46, 255)
    assert found.plain == ("minecraft:dirt",)


def test_a_model_that_no_layer_has_is_told_of(tmp_path: Path) -> None:
    gone = {"assets/minecraft/models/block/cube.json", "assets/minecraft/models/block/fence_post.json"}
    path = write_zip(tmp_path / "part.zip", {name: data for name, data in pack_files().items() if name not in gone})
    fence = state("oak_fence", east="false", north="false", south="false", waterlogged="false", west="true")
    found = looks(path, state("stone"), state("glass"), fence)
    assert found.plain == ("minecraft:glass", "minecraft:oak_fence", "minecraft:stone")
    assert [len(found.models[look.parts[0]["model"]]["elements"]) for look in found.states[1:]] == [1, 1, 3]
    assert found.atlas.translucent == {"scenelang:plain/2"}, "glass stays clear"
    (warning,) = found.warnings
    assert warning.code == "W619"
    assert "`minecraft:glass`, `minecraft:oak_fence`, `minecraft:stone`" in warning.message


def test_a_warning_names_eight_blocks(pack: Path) -> None:
    wools = [
        state(f"{color}_wool") for color in ("red", "blue", "lime", "pink", "gray", "cyan", "black", "white", "brown")
    ]
    (warning,) = looks(pack, state("stone"), *wools).warnings
    assert warning.message.count("_wool`") == 8
    assert "`, ..;" in warning.message
    assert looks(pack, state("stone")).warnings == ()


def test_no_block_of_the_game_vanishes(tmp_path: Path) -> None:
    """With a definition of every block whose model holds no boxes, as the game's of what it draws by itself."""
    kinds = load_table().blocks.values()
    empty = as_json({"variants": {"": {"model": "block/empty"}}})
    files = {f"assets/minecraft/blockstates/{kind.name.partition(':')[2]}.json": empty for kind in kinds}
    files["assets/minecraft/models/block/empty.json"] = as_json({"textures": {"particle": "block/stone"}})
    states = [BlockState(kind.name, tuple(sorted(kind.defaults.items()))) for kind in kinds]
    found = looks_of(states, [layer_at(write_zip(tmp_path / "empty.zip", files))])
    for one, look in zip(states, found.states, strict=True):
        boxes = [element for part in look.parts for element in found.models[part["model"]]["elements"]]
        assert boxes or load_table().blocks[one.name].color is None, one


def test_a_state_of_which_the_game_draws_nothing_stays_empty(tmp_path: Path) -> None:
    variants = {"half=lower": {"model": "block/stone"}, "half=upper": {"model": "block/empty"}}
    files = {
        "assets/minecraft/blockstates/pitcher_crop.json": as_json({"variants": variants}),
        "assets/minecraft/models/block/empty.json": as_json({}),
    }
    found = looks(write_zip(tmp_path / "more.zip", pack_files() | files), state("pitcher_crop", half="upper", age="0"))
    assert found.models == {"minecraft:block/empty": {"elements": []}}
    assert found.plain == ()


def test_names_of_a_pack_are_not_those_of_plain_blocks(tmp_path: Path) -> None:
    path = changed(tmp_path, stone={"parent": "block/cube", "textures": {"all": "scenelang:plain/zz"}})
    assert "scenelang:plain/zz" not in looks(path, state("stone")).atlas.places


def test_looks_without_any_of_the_blocks_are_an_error(pack: Path) -> None:
    with pytest.raises(SceneError, match=r"contains none of the build's blocks \(minecraft:dirt\)"):
        looks(pack, state("dirt"))


def test_water_and_chests_bring_their_textures(pack: Path, tmp_path: Path) -> None:
    textures = "assets/minecraft/textures"
    more = {
        f"{textures}/block/water_still.png": png((0, 0, 255, 180), 16, 512),
        f"{textures}/block/water_flow.png": png((0, 0, 255, 180), 32, 1024),
        f"{textures}/entity/chest/normal.png": png((90, 60, 30, 255), 64, 64),
        "assets/minecraft/blockstates/chest.json": as_json({"variants": {"": {"model": "block/none"}}}),
    }
    path = write_zip(tmp_path / "more.zip", pack_files() | more)
    found = looks(path, state("chest", waterlogged="true"))
    sizes = {name: (x1 - x0, y1 - y0) for name, (x0, y0, x1, y1) in found.atlas.places.items()}
    assert sizes["minecraft:block/water_still"] == (16, 16), "the first frame of an animation"
    assert sizes["minecraft:block/water_flow"] == (32, 32)
    assert sizes["minecraft:entity/chest/normal"] == (64, 64)
    assert found.states[1] == BlockLook((), is_special=True, is_wet=True)
    assert found.plain == ()


def test_what_one_sees_through_is_known(pack: Path) -> None:
    assert looks(pack, state("glass"), state("stone")).atlas.translucent == {"minecraft:block/glass"}


def test_every_block_that_stands_in_water_is_wet(pack: Path) -> None:
    blocks = [state("oak_fence", waterlogged="true"), state("kelp_plant"), state("water", level="0"), state("stone")]
    assert [look.is_wet for look in looks(pack, *blocks).states[1:]] == [True, True, False, False]


@pytest.mark.parametrize(
    ("block", "texture"),
    [
        (state("shulker_box", facing="up"), "shulker/shulker"),
        (state("piglin_wall_head", facing="north"), "piglin/piglin"),
    ],
)
def test_boxes_without_a_dye_and_heads_at_walls_are_drawn(block: BlockState, texture: str, tmp_path: Path) -> None:
    more = {
        f"assets/minecraft/textures/entity/{texture}.png": png((90, 60, 30, 255), 64, 64),
        f"assets/minecraft/blockstates/{block.name.partition(':')[2]}.json": as_json(
            {"variants": {"": {"model": "x"}}}
        ),
    }
    found = looks(write_zip(tmp_path / "more.zip", pack_files() | more), block)
    assert found.states[1] == BlockLook((), is_special=True)
    assert f"minecraft:entity/{texture}" in found.atlas.places


LOOP = {"parent": "block/loop"}


@pytest.mark.parametrize(
    "model",
    [
        LOOP,
        {"elements": [{"from": [0, 0], "to": [1, 1, 1], "faces": {}}]},
        {"elements": [{"from": [0, 0, 0], "to": [1, 1, 1e300], "faces": {}}]},
        {"elements": [{"from": [0, 0, 0], "to": [1, 1, 1], "faces": {"up": {"texture": "#a", "rotation": 45}}}]},
        {"elements": [{"from": [0, 0, 0], "to": [1, 1, 1], "faces": {"up": {"texture": "#a", "uv": ["x", 0, 0, 0]}}}]},
        {"elements": [{"from": [0, 0, 0], "to": [1, 1, 1], "faces": {}, "rotation": {"axis": "w", "angle": 1}}]},
        {"elements": [{}] * 3000},
        {"elements": "boxes"},
        {"elements": 7},
        ["no", "model"],
    ],
)
def test_malformed_models_are_said(model: Any, tmp_path: Path) -> None:
    path = changed(tmp_path, stone=model, loop=LOOP)
    with pytest.raises(SceneError, match="the model `minecraft:block/stone` of the resource pack is malformed"):
        looks(path, state("stone"))


def test_loops_of_textures_end(tmp_path: Path) -> None:
    path = changed(tmp_path, stone={"parent": "block/cube", "textures": {"all": "#a", "a": "#b", "b": "#a"}})
    model = looks(path, state("stone")).models["minecraft:block/stone"]
    assert set(textures_of(model)) == {MISSING}


def test_textures_that_lead_elsewhere_are_missing() -> None:
    face = {"texture": "../../../secret"}
    given = {"elements": [{"from": [0, 0, 0], "to": [1, 1, 1], "faces": {"up": face}}]}
    assert set(textures_of(flat_model("minecraft:x", lambda _: given))) == {MISSING}


@pytest.mark.parametrize(
    "definition",
    [
        [],
        {"variants": []},
        {"variants": {"": {"model": "../x"}}},
        {"variants": {"": []}},
        {"variants": {"": {"model": "block/stone", "y": 30}}},
        {"multipart": [{"when": {"OR": 3}, "apply": {"model": "block/stone"}}]},
    ],
)
def test_malformed_definitions_are_said(definition: Any, tmp_path: Path) -> None:
    name = "assets/minecraft/blockstates/stone.json"
    path = write_zip(tmp_path / "changed.zip", pack_files() | {name: as_json(definition)})
    with pytest.raises(SceneError, match="the definition of `minecraft:stone` in the resource pack is malformed"):
        looks(path, state("stone"))


@pytest.mark.parametrize("data", [b"", b"no picture", b"\x89PNG\r\n\x1a\n"])
def test_what_is_no_picture_is_said(data: bytes) -> None:
    with pytest.raises(SceneError, match="is not a valid image"):
        texture_from(data, "minecraft:block/stone")


def test_huge_pictures_are_refused() -> None:
    with pytest.raises(SceneError, match="is too large"):
        texture_from(png((0, 0, 0, 255), 5000, 10), "minecraft:block/stone")


def test_textures_do_not_overlap_in_the_atlas() -> None:
    rng = np.random.default_rng(1)
    sizes = rng.choice([16, 32, 64], (60, 2))
    textures = {f"t{i}": np.full((h, w, 4), i + 1, np.uint8) for i, (h, w) in enumerate(sizes.tolist())}
    atlas = atlas_of(textures)
    sheet = np.asarray(image(atlas.png))
    assert sheet.shape == (atlas.side, atlas.side, 4)
    for i, name in enumerate(textures):
        left, top, right, bottom = atlas.places[name]
        assert (sheet[top:bottom, left:right] == i + 1).all()
        assert (bottom - top, right - left) == tuple(sizes[i])


def image(data: bytes) -> Any:
    from PIL import Image

    return Image.open(io.BytesIO(data))


def pixels(found: BlockLooks) -> Any:
    return np.asarray(image(found.atlas.png))


def test_colors_survive(pack: Path) -> None:
    found = looks(pack, state("stone"))
    left, top, *_ = found.atlas.places["minecraft:block/stone"]
    assert tuple(pixels(found)[top, left]) == COLORS["stone"]
