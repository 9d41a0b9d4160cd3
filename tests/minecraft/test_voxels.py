"""Voxelisation: the reference's cells on the corpus, the slow oracle on random programs, mistakes and limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from searching import many
from transpile.cases import CORPUS, IMITATIONS, Case, scene_of, translated

from minecraft.oracle import Cuboid, laid, of_build, of_golden
from minecraft.scenes import BLOCKS, CUBOIDS, STEPS, group, placed, primitive
from scenelang.backends.minecraft.voxels import Voxels, ignored, voxelised
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.pose import translation
from scenelang.interpreter.values.values import IDENTITY, Matrix

MINECRAFT = [case for case in (*CORPUS, *IMITATIONS) if "set_cuboid" in case.text]


def built(text: str) -> Voxels:
    return voxelised(scene_of("a.scene", text).root)


def cells(text: str) -> dict[tuple[int, int, int], str]:
    return of_build(built(text).build)


@pytest.mark.parametrize("case", MINECRAFT, ids=lambda case: case.name)
@pytest.mark.sampled(3)
def test_corpus_cell_by_cell(case: Case) -> None:
    golden = case.golden_scene()
    scene = scene_of(case.name, translated(case).text)
    assert len(scene.frames) == len(golden["frames"])
    for root, frame in zip(scene.frames, golden["frames"]):
        expected = laid(of_golden(frame["primitives"]))
        assert expected
        assert of_build(voxelised(root).build) == expected


def test_there_are_responses_and_imitations() -> None:
    assert len(MINECRAFT) >= 20


# --- random scenes ---------------------------------------------------------------------------------------------------


def expected_of(root: Entity) -> dict[tuple[int, int, int], str]:
    """The oracle's cells of an expanded scene."""
    flat = flatten_entity(root, snap_blocks=False)
    cuboids = []
    for i, matrix in zip(flat.index.tolist(), flat.matrices):
        attributes = flat.primitives[i].embedding.attributes
        assert flat.primitives[i].shape is not None
        size = tuple(round(a * b) for a, b in zip(flat.primitives[i].shape.size, np.diagonal(matrix[:, :3])))
        state = attributes.get("block-type")
        cuboids.append(
            Cuboid(tuple(matrix[:, 3]), size, None if state == "minecraft:air" else state, attributes.get("fill", True))
        )
    return laid(cuboids)


@settings(max_examples=many(80), deadline=None)
@given(st.lists(CUBOIDS, max_size=25))
def test_overlap_deletes_hollow_and_negative_coordinates(cuboids: list[Cuboid]) -> None:
    root = placed(cuboids)
    build = voxelised(root).build
    assert of_build(build) == expected_of(root)
    assert build.palette[0].name == "minecraft:air"
    assert set(np.unique(build.cells).tolist()) | {0} == set(range(len(build.palette)))
    for axis in range(3):  # the smallest box
        solid = (build.cells != 0).any(axis=tuple({0, 1, 2} - {axis}))
        assert not len(solid) or (solid[0] and solid[-1])


@settings(max_examples=many(60), deadline=None)
@given(st.data())
def test_shared_entities(data: st.DataObject) -> None:
    """Repeated entities, nested, laid whole and under fractional moves and scales, beside their own deletes."""
    inner = placed(data.draw(st.lists(CUBOIDS, min_size=8, max_size=14)))
    middle = group(*[(inner, translation(*step)) for step in data.draw(st.lists(STEPS, min_size=1, max_size=3))])
    moves = data.draw(st.lists(st.tuples(STEPS, st.sampled_from([1, 2, 0.5])), min_size=1, max_size=4))
    parts: list[tuple[Entity, Matrix]] = []
    for (x, y, z), step in moves:
        parts.append((data.draw(st.sampled_from([inner, middle])), translation(x * step, y * step, z * step)))
        parts.append((primitive(data.draw(CUBOIDS)), translation(x, y, z)))
    root = group(*parts)
    if data.draw(st.booleans()):
        root = group((root, Matrix((2.0, 0, 0, 0.5, 0, 1.0, 0, -3.25, 0, 0, 3.0, 0))), (root, IDENTITY))
    assert of_build(voxelised(root).build) == expected_of(root)


def test_repeated_entities_are_laid_whole() -> None:
    """2^40 towers one inside the other: nothing may expand them."""
    entity = placed([Cuboid((i, 0, 0), (1, 1, 1), BLOCKS[i % 2]) for i in range(8)])
    for _ in range(40):
        entity = group((entity, IDENTITY), (entity, IDENTITY))
    build = voxelised(group((entity, translation(5, 6, 7)))).build
    assert build.origin == (5, 6, 7)
    assert build.cells[:, 0, 0].tolist() == [1, 2] * 4


def test_a_delete_inside_a_repeated_entity_deletes_what_stood_there() -> None:
    gate = placed(
        [*[Cuboid((i, 0, 0), (1, 3, 1), "minecraft:stone") for i in range(8)], Cuboid((3, 0, 0), (2, 2, 1), None)]
    )
    wall = Cuboid((0, 0, 0), (40, 3, 1), "minecraft:dirt")
    root = group((primitive(wall), IDENTITY), (gate, translation(2, 0, 0)), (gate, translation(20, 0, 0)))
    build = voxelised(root).build
    assert of_build(build) == expected_of(root)
    assert (5, 0, 0) not in of_build(build)
    assert (23, 1, 0) not in of_build(build)


# --- programs --------------------------------------------------------------------------------------------------------


def test_positions_are_truncated_toward_zero() -> None:
    text = """(bind "a" (lambda () (union
      (transform (call "set-cuboid" :block-type "stone" :scale [1 1 1]) (translate [-0.9 2.9 -1.5])))))"""
    assert set(cells(text)) == {(0, 2, -1)}


def test_whole_scales_multiply_even_when_the_steps_are_fractions() -> None:
    text = """(bind "a" (lambda ()
      (transform (transform (call "set-cuboid" :block-type "stone" :scale [10 1 1]) (scale [0.1 2 1] [0 0 0]))
                 (scale [3 1 1] [0 0 0]))))"""
    assert built(text).build.size == (3, 2, 1)


@pytest.mark.parametrize(
    "kwargs",
    [
        '(list (list "facing" "north") (list "waterlogged" #f))',
        '(table "facing" "north" "waterlogged" "False")',
        '\'((facing :north) (waterlogged "false"))',
    ],
)
def test_properties_of_all_kinds(kwargs: str) -> None:
    text = f'(bind "a" (lambda () (call "set-cuboid" :block-type "Oak Stairs" :block-kwargs {kwargs})))'
    assert cells(text) == {(0, 0, 0): "minecraft:oak_stairs[facing=north,waterlogged=false]"}


def test_a_state_within_the_name() -> None:
    text = """(bind "a" (lambda () (call "set-cuboid" :block-type "oak_log[axis=x]" :block-kwargs '(("axis" "z")))))"""
    assert cells(text) == {(0, 0, 0): "minecraft:oak_log[axis=z]"}
    text = """(bind "a" (lambda () (call "set-cuboid" :block-type "minecraft:oak_stairs[facing=east, half=top]")))"""
    assert cells(text) == {(0, 0, 0): "minecraft:oak_stairs[facing=east,half=top]"}


def test_others_are_named_once() -> None:
    voxels = built(
        '(bind "a" (lambda () (union (call "cube") (call "set-cuboid" :block-type "stone") (call "tree") (call "cube"))))'
    )
    assert voxels.others == ("cube", "tree")
    warning = ignored(voxels)
    assert warning is not None
    assert '"cube", "tree"' in warning.message
    assert of_build(voxels.build) == {(0, 0, 0): "minecraft:stone"}


def test_nothing_at_all() -> None:
    build = built('(bind "a" (lambda () (call "cube")))').build
    assert build.size == (0, 0, 0)
    assert len(build.palette) == 1
    assert built('(bind "a" (lambda () (call "delete-blocks" :scale [3 3 3])))').build.size == (0, 0, 0)


def test_places() -> None:
    voxels = built('(bind "a" (lambda () (call "set-cuboid" :block-type "stone")))')
    assert voxels.places[0] is None
    assert voxels.places[1] is not None
    assert voxels.places[1].text.startswith('(call "set-cuboid"')


# --- mistakes and limits ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("pose", "told"),
    [
        ("(rotate 1.5708 [0 1 0])", "rotated"),
        ("(rotate 3.14159265358979 [0 1 0])", "rotated"),
        ("(reflect [0 0 0] [1 0 0])", "rotated"),
        ("(scale 0.5)", "1 x 0.5 x 0.5 cells"),
        ("(scale [1000000.25 1 1] [0 0 0])", "cells large"),
        ("(translate [1e300 0 0])", "too far"),
    ],
)
def test_poses_that_blocks_cannot_have(pose: str, told: str) -> None:
    with pytest.raises(SceneError) as caught:
        built(f'(bind "house" (lambda () (transform (call "set-cuboid" :block-type "stone" :scale [2 1 1]) {pose})))')
    assert caught.value.name == "blocks"
    assert told in caught.value.message
    assert "house > set-cuboid" in caught.value.message
    assert caught.value.span is not None


@pytest.mark.parametrize(
    "attributes",
    [
        "",
        ":block-type 5",
        ':block-type " "',
        ':block-type "stone" :block-kwargs 5',
        ':block-type "stone" :block-kwargs (list (list "a" car))',
    ],
)
def test_attributes_that_are_no_blocks(attributes: str) -> None:
    with pytest.raises(SceneError) as caught:
        built(f'(bind "house" (lambda () (call "set-cuboid" {attributes})))')
    assert caught.value.name == "attribute"
    assert caught.value.span is not None


@pytest.mark.parametrize(
    "cuboids",
    [
        [Cuboid((0, 0, 0), (10**7, 10**7, 10**7), "minecraft:stone")],
        [Cuboid((0, 0, 0), (10**9, 10**9, 10**9), "minecraft:stone", False)],
        [Cuboid((0, 0, 0), (1, 1, 1), "minecraft:stone"), Cuboid((10**6, 10**6, 10**6), (1, 1, 1), "minecraft:stone")],
    ],
)
def test_boxes_that_are_too_large(cuboids: list[Cuboid]) -> None:
    with pytest.raises(LimitError) as caught:
        voxelised(placed(cuboids))
    assert caught.value.name == "size"


def test_far_away_and_huge_deletes_are_fine() -> None:
    far = 10**12
    root = placed(
        [
            Cuboid((far, -far, 5), (2, 1, 1), "minecraft:stone"),
            Cuboid((far + 1, -(10**15), -(10**15)), (10**15, 2 * 10**15, 2 * 10**15), None),
        ]
    )
    build = voxelised(root).build
    assert build.origin == (far, -far, 5)
    assert build.size == (1, 1, 1)


def test_too_many_cuboids() -> None:
    root = placed([Cuboid((i, 0, 0), (1, 1, 1), "minecraft:stone") for i in range(11)])
    with pytest.raises(LimitError) as caught:
        voxelised(root, limit=10)
    assert caught.value.name == "primitives"


@pytest.mark.parametrize("fill", ['"false"', "0", "'()"])
def test_fill_is_true_or_false(fill: str) -> None:
    with pytest.raises(SceneError) as caught:
        built(f'(bind "a" (lambda () (call "set-cuboid" :block-type "stone" :fill {fill})))')
    assert caught.value.name == "attribute"
    assert caught.value.span is not None


@pytest.mark.parametrize("name", ["air", "cave_air", "minecraft:void_air", "structure_void"])
def test_what_is_nothing_deletes(name: str) -> None:
    text = f'(bind "a" (lambda () (union (call "set-cuboid" :block-type "stone" :scale [2 1 1]) (call "set-cuboid" :block-type "{name}"))))'
    assert cells(text) == {(1, 0, 0): "minecraft:stone"}


def test_slivers_are_no_cells() -> None:
    with pytest.raises(SceneError) as caught:
        built('(bind "a" (lambda () (call "set-cuboid" :block-type "stone" :scale [1 1e-7 1])))')
    assert caught.value.name == "blocks"
