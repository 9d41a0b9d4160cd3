"""Builds as colored cubes: the cells that are filled, their colors and shapes, and the parts of the scene."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from searching import many
from transpile.cases import scene_of

from minecraft.oracle import Cuboid, of_build
from minecraft.scenes import CUBOIDS, STEPS, group, placed
from scenelang.backends.minecraft import models
from scenelang.backends.minecraft.blocks import load_table
from scenelang.backends.minecraft.voxels import voxelised
from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.image_files import from_srgb
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, count_words, descendants, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.pose import translation
from scenelang.interpreter.values.values import IDENTITY

Cell = tuple[int, int, int]


def scene(text: str) -> Scene:
    """The scene of a program, or of one expression."""
    return scene_of("a.scene", text if "(bind" in text else f'(bind "thing" (lambda () {text}))')


def drawn(text: str) -> Entity:
    return drawn_scene(scene(text)).root


def filled(root: Entity) -> dict[Cell, str]:
    """The cells that axis-aligned boxes of whole cells fill, by the boxes' words; no cell twice."""
    flat = flatten_entity(root)
    found: dict[Cell, str] = {}
    for i, matrix in zip(flat.index.tolist(), flat.matrices):
        size = np.diagonal(matrix[:, :3])
        assert np.array_equal(matrix[:, :3], np.diag(size))
        low = matrix[:, 3] - size / 2
        assert np.array_equal(low, np.rint(low))
        for cell in np.ndindex(*size.astype(int).tolist()):
            at = tuple((low + cell).astype(int).tolist())
            assert at not in found
            found[at] = flat.primitives[i].word
    return found


def short(cells: dict[Cell, str]) -> dict[Cell, str]:
    return {cell: state.removeprefix("minecraft:") for cell, state in cells.items()}


@settings(max_examples=many(60), deadline=None)
@given(st.lists(CUBOIDS, max_size=15), st.lists(STEPS, min_size=1, max_size=3), st.integers(1, 20))
def test_the_cells_are_those_of_the_build(cuboids: list[Cuboid], steps: list[Cell], parts: int) -> None:
    inner = placed(cuboids)
    root = group(*((inner, translation(*step)) for step in steps), (placed(cuboids[:3]), IDENTITY))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(models, "MAX_PARTS", parts)
        made = drawn_scene(Scene("group", [root], False)).root
    assert filled(made) == short(of_build(voxelised(root).build))


def test_neighbors_are_merged() -> None:
    row = '(for/union ((i (range 30))) (transform (call "set-cuboid" :block-type "stone") (translate [i 0 0])))'
    assert primitive_count(drawn(f'(bind "row" (lambda () {row}))')) == 1


def test_each_cell_stays_with_its_entity() -> None:
    root = drawn("""
      (bind "tree" (lambda () (union (call "set-cuboid" :block-type "oak_log" :scale [1 4 1])
                                     (transform (call "crown") (translate [-1 3 -1])))))
      (bind "crown" (lambda () (call "set-cuboid" :block-type "oak_leaves" :scale [3 2 3])))
      (bind "wood" (lambda () (for/union ((i (range 5))) (transform (call "tree") (translate [(* 9 i) 0 0])))))""")
    counts = count_words(root)
    assert counts == {"wood": 1, "tree": 5, "oak_log": 5, "crown": 5, "oak_leaves": 5}
    trees = {id(part.car) for part in root.children}
    assert len(trees) == 1  # what looks the same is shared
    assert [part.cdr[3] for part in root.children] == [0.0, 9.0, 18.0, 27.0, 36.0]


def test_too_many_parts_are_drawn_as_those_above() -> None:
    text = """
      (bind "brick" (lambda () (call "set-cuboid" :block-type "bricks")))
      (bind "row" (lambda () (for/union ((i (range 10))) (transform (call "brick") (translate [i 0 0])))))
      (bind "wall" (lambda () (for/union ((i (range 10))) (transform (call "row") (translate [0 (* 2 i) 0])))))"""
    assert count_words(drawn(text)) == {"wall": 1, "row": 10, "brick": 100, "bricks": 100}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(models, "MAX_PARTS", 50)
        assert count_words(drawn(text)) == {"wall": 1, "row": 10, "bricks": 10}
        patch.setattr(models, "MAX_PARTS", 5)
        assert count_words(drawn(text)) == {"wall": 1, "bricks": 10}


def test_what_is_no_block_stays_where_it_is() -> None:
    root = drawn("""
      (bind "lamp" (lambda () (union (call "set-cuboid" :block-type "stone" :scale [1 3 1])
        (transform (call "sphere" :radius .5) (@ (translate [.5 3.5 .5]) (rotate .3 [1 0 0]))))))
      (bind "ball" (lambda () (call "sphere" :radius 2)))
      (bind "place" (lambda () (union (transform (call "lamp") (translate [2.6 0 -3.2]))
                                      (transform (call "ball") (translate [9.5 .5 0])))))""")
    flat = flatten_entity(root)
    by_word = {flat.primitives[i].word: m for i, m in zip(flat.index.tolist(), flat.matrices) if i >= 0}
    spheres = [
        m[:, 3].tolist() for i, m in zip(flat.index.tolist(), flat.matrices) if flat.primitives[i].word == "sphere"
    ]
    assert np.allclose(sorted(spheres), [[3.1, 3.5, -2.7], [9.5, 0.5, 0.0]])
    assert by_word["stone"][:, 3].tolist() == [2.5, 1.5, -2.5]


def test_scenes_without_blocks_are_themselves() -> None:
    plain = scene('(call "cube")')
    assert drawn_scene(plain) is plain


def test_a_single_primitive_and_nothing_at_all() -> None:
    assert filled(drawn('(call "set-cuboid" :block-type "stone" :scale [2 1 1])')) == {
        (0, 0, 0): "stone",
        (1, 0, 0): "stone",
    }
    gone = drawn('(union (call "set-cuboid" :block-type "stone") (call "delete-blocks"))')
    assert primitive_count(gone) == 0


def test_frames_of_a_film_keep_their_number() -> None:
    film = """(bind "film" (lambda ()
      (frames (for/list ((i (range 3))) (transform (call "set-cuboid" :block-type "stone") (translate [i 0 0]))))))"""
    made = drawn_scene(scene(film))
    assert made.animated
    assert [filled(root) for root in made.frames] == [{(i, 0, 0): "stone"} for i in range(3)]


# --- looks -----------------------------------------------------------------------------------------------------------


def only(root: Entity) -> Entity:
    """The one kind of primitive in a scene."""
    (found,) = {id(e): e for e in descendants(root) if e.is_primitive}.values()
    return found


@pytest.mark.parametrize("name", ["stone", "glass", "water", "red_wool", "oak_leaves", "ice"])
def test_colors_and_opacity_come_from_the_table(name: str) -> None:
    kind = load_table().blocks[f"minecraft:{name}"]
    assert kind.color is not None
    look = look_of(only(drawn(f'(call "set-cuboid" :block-type "{name}")')))
    assert np.allclose(look.color, from_srgb(np.array(kind.color) / 255))
    assert look.opacity == kind.opacity


def test_the_programs_own_look_wins() -> None:
    look = look_of(only(drawn(
        '(call "set-cuboid" :block-type "glass" :color [1 0 0] :opacity .9 :roughness .2 :emission 2 :ior 1.3)'
    )))  # fmt: skip
    assert (look.color, look.opacity, look.roughness, look.ior) == ((1, 0, 0), 0.9, 0.2, 1.3)
    assert look.emission == (2.0, 0.0, 0.0)


def boxes(text: str) -> Counter[tuple[float, ...]]:
    """The boxes that a scene draws, in sixteenths."""
    flat = flatten_entity(drawn(text))
    found: Counter[tuple[float, ...]] = Counter()
    for matrix in flat.matrices:
        reach = np.abs(matrix[:, :3]).sum(axis=1) / 2
        found[tuple(np.round(np.concatenate([matrix[:, 3] - reach, matrix[:, 3] + reach]) * 16, 6).tolist())] += 1
    return found


def block(name: str, at: Any = (0, 0, 0), size: Any = (1, 1, 1), **properties: str) -> str:
    pairs = " ".join(f'("{key}" "{value}")' for key, value in properties.items())
    x, y, z = at
    a, b, c = size
    return (
        f'(transform (call "set-cuboid" :block-type "{name}" :scale [{a} {b} {c}] :block-kwargs (quote ({pairs}))) '
        f"(translate [{x} {y} {z}]))"
    )


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (block("oak_slab", size=(3, 1, 2)), {(0, 0, 0, 48, 8, 32): 1}),
        (block("oak_slab", type="top", size=(1, 2, 1)), {(0, 8, 0, 16, 16, 16): 1, (0, 24, 0, 16, 32, 16): 1}),
        (block("oak_slab", type="double", size=(2, 2, 2)), {(0, 0, 0, 32, 32, 32): 1}),
        (block("oak_stairs", facing="east"), {(0, 0, 0, 16, 8, 16): 1, (8, 8, 0, 16, 16, 16): 1}),
        (block("oak_stairs", facing="south", half="top"), {(0, 8, 0, 16, 16, 16): 1, (0, 0, 8, 16, 8, 16): 1}),
        (
            block("oak_stairs", facing="north", shape="inner_left"),
            {(0, 0, 0, 16, 8, 16): 1, (0, 8, 0, 16, 16, 8): 1, (0, 8, 8, 8, 16, 16): 1},
        ),
        (block("oak_stairs", facing="west", shape="outer_right"), {(0, 0, 0, 16, 8, 16): 1, (0, 8, 0, 8, 16, 8): 1}),
        (block("glass_pane", size=(1, 1, 2)), {
            (7, 0, 7, 9, 16, 9): 1, (7, 0, 9, 9, 16, 16): 1, (7, 0, 16, 9, 16, 23): 1, (7, 0, 23, 9, 16, 25): 1,
        }),
        (block("oak_door", facing="north", half="lower"), {(0, 0, 13, 16, 16, 16): 1}),
        (block("oak_door", facing="north", half="lower", open="true"), {(0, 0, 0, 3, 16, 16): 1}),
        (block("oak_door", facing="east", half="lower", open="true", hinge="right"), {(0, 0, 13, 16, 16, 16): 1}),
        (block("oak_trapdoor", half="top"), {(0, 13, 0, 16, 16, 16): 1}),
        (block("oak_trapdoor", open="true", facing="east"), {(0, 0, 0, 3, 16, 16): 1}),
        (block("snow", layers="3"), {(0, 0, 0, 16, 6, 16): 1}),
        (block("ladder", facing="east"), {(0, 0, 0, 3, 16, 16): 1}),
        (block("iron_chain", axis="x"), {(0, 6, 6, 16, 10, 10): 1}),
        (block("end_rod", facing="south"), {(6, 6, 0, 10, 10, 16): 1}),
        (block("oak_button", face="wall", facing="north"), {(5, 6, 14, 11, 10, 16): 1}),
        (block("stone_button", face="ceiling", facing="east"), {(6, 14, 5, 10, 16, 11): 1}),
        (block("wall_torch", facing="south"), {(7, 3, 2, 9, 13, 5): 1}),
        (block("vine", south="true"), {(0, 0, 15.5, 16, 16, 16): 1}),
        (block("water", size=(2, 2, 1)), {(0, 0, 0, 32, 32, 16): 1}),
        (block("white_carpet", size=(2, 1, 2)), {(0, 0, 0, 32, 1, 32): 1}),
        (block("cobblestone_wall"), {(4, 0, 4, 12, 16, 12): 1}),
    ],
)  # fmt: skip
def test_shapes_of_blocks(text: str, wanted: dict[tuple[float, ...], int]) -> None:
    assert boxes(text) == wanted


def test_a_fence_has_rails_to_its_neighbors() -> None:
    found = boxes(block("oak_fence", size=(2, 1, 1)))
    assert found[6, 0, 6, 10, 16, 10] == found[22, 0, 6, 26, 16, 10] == 1
    assert found[10, 12, 7, 16, 15, 9] == found[16, 6, 7, 22, 9, 9] == 1
    assert sum(found.values()) == 6


def test_plants_are_two_sheets_across() -> None:
    flat = flatten_entity(drawn(block("poppy", at=(3, 0, 0))))
    assert len(flat) == 2
    for matrix in flat.matrices:
        assert np.allclose(matrix[[0, 2], 3], [3.5, 0.5])
        assert abs(matrix[0, 0]) == pytest.approx(abs(matrix[2, 0]))
    box = entity_box(drawn(block("poppy")))
    assert box is not None
    assert box[0] > 0.1
    assert box[3] < 0.9


# --- mistakes and limits ---------------------------------------------------------------------------------------------


def test_replaced_blocks_are_told_once() -> None:
    said: list[Diagnostic] = []
    drawn_scene(scene(f"(union {block('marble')} {block('marble', at=(1, 0, 0))})"), warn=said.append)
    assert [each.name for each in said] == ["unknown-block"]


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ('(transform (call "set-cuboid" :block-type "stone") (rotate .5 [0 1 0]))', "blocks"),
        ('(transform (call "set-cuboid" :block-type "stone") (scale .5))', "blocks"),
    ],
)
def test_mistakes_are_told(text: str, name: str) -> None:
    with pytest.raises(SceneError) as caught:
        drawn(text)
    assert caught.value.name == name
    assert caught.value.span is not None


def test_limits() -> None:
    far = f"(union {block('stone')} {block('stone', at=(100000, 100000, 0))})"
    with pytest.raises(LimitError, match="cells"):
        drawn(far)
    with pytest.raises(LimitError, match="2 primitives"):
        drawn_scene(scene(f"(union {block('stone')} {block('stone', at=(2, 0, 0))})"), limit=1)
    with pytest.raises(LimitError, match="4 cubes"):  # plants are not merged
        drawn_scene(scene(block("poppy", size=(2, 1, 2))), limit=3)
