"""Builds as programs: evaluated, they lay the same blocks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sampling import one_in
from searching import many
from transpile.cases import CORPUS, IMITATIONS, Case, scene_of, translated

from minecraft.builds import BUILDS, STATES, assert_same, made, noise
from scenelang.backends.minecraft.blocks import NOTHING, BlockState, Build, load_table
from scenelang.backends.minecraft.build_files import game_version, write_litematic, write_schematic
from scenelang.backends.minecraft.connections import Settled, settled
from scenelang.backends.minecraft.export import program_text, read
from scenelang.backends.minecraft.voxels import voxelised
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.session.formatting import formatted
from scenelang.session.session import Session

IMPOSSIBLE = {"minecraft-city-houses-loop-kwargs"}  # asks for beetroots of the age 6
MINECRAFT = [case for case in (*CORPUS, *IMITATIONS) if "set_cuboid" in case.text and case.name not in IMPOSSIBLE]


def laid(text: str) -> Settled:
    evaluated = Session().evaluate(Source("a.scene", text))
    assert evaluated.scene is not None, evaluated.diagnostics
    assert not evaluated.diagnostics
    return settled(voxelised(evaluated.scene.root))


@given(build=BUILDS)
@settings(max_examples=many(60), deadline=None)
def test_the_program_lays_the_build(build: Build) -> None:
    text = program_text(build, "house")
    assert formatted(text) == text
    assert_same(build, laid(text).build)


@pytest.mark.parametrize("case", one_in(2, MINECRAFT), ids=lambda case: case.name)
@pytest.mark.sampled(3)
def test_the_corpus_as_files_and_as_programs(case: Case, tmp_path: Path) -> None:
    build = settled(voxelised(scene_of(case.name, translated(case).text).frames[0])).build
    for write, name in ((write_schematic, "a.schem"), (write_litematic, "a.litematic")):
        write(build, tmp_path / name, game_version())
        assert_same(build, read(tmp_path / name).build)
    assert_same(build, laid(program_text(build, case.name)).build)


def test_many_cuboids() -> None:
    rng = np.random.default_rng(1)
    build = made((-9, 0, 3), rng.integers(0, len(STATES) + 1, (20, 20, 20)), STATES)
    text = program_text(build, "house")
    assert "(rows 6" in text
    assert_same(build, laid(text).build)


@given(st.data())
@settings(max_examples=many(100), deadline=None)
def test_every_state_of_the_game(data: st.DataObject) -> None:
    kinds = [kind for kind in load_table().blocks.values() if kind.name not in NOTHING]
    chosen = data.draw(st.lists(st.sampled_from(kinds), min_size=1, max_size=8))
    states = [
        BlockState(kind.name, tuple((key, data.draw(st.sampled_from(kind.values[key]))) for key in sorted(kind.values)))
        for kind in chosen
    ]
    build = made((0, 0, 0), np.arange(1, len(states) + 1).reshape(1, 1, -1), states)
    assert_same(build, laid(program_text(build, "all")).build)


def test_how_it_reads() -> None:
    stairs = BlockState("minecraft:oak_log", (("axis", "x"),)), BlockState("minecraft:oak_log", (("axis", "y"),))
    build = made((-1, 0, 0), [[[1, 1], [2, 0]], [[1, 1], [3, 0]]], [BlockState("minecraft:stone"), *stairs])
    assert (
        program_text(build, "house")
        == """\
; house: Minecraft blocks in a box of 2 x 2 x 2 cells with the lowest corner -1 0 0, as 3 cuboids.

; Cuboids of one block: the first cell along x, y and z, then the number of cells along each.
(define (laid block properties cuboids)
  (for/union (((x y z width height depth) cuboids))
    (transform (call "set-cuboid" :block-type block :block-kwargs properties
                 :scale [width height depth])
               (translate [x y z]))))

; Single blocks: the cell along x, y and z.
(define (laid-singly block properties cells)
  (define one (call "set-cuboid" :block-type block :block-kwargs properties))
  (for/union (((x y z) cells))
    (transform one (translate [x y z]))))

(bind "stone"
  (lambda ()
    (laid "stone" none '((-1 0 0 2 1 2)))))

(bind "oak log axis x"
  (lambda ()
    (laid-singly "oak_log" '(("axis" "x")) '((-1 1 0)))))

(bind "oak log axis y"
  (lambda ()
    (laid-singly "oak_log" none '((0 1 0)))))

(bind "house"
  (lambda ()
    (union (call "stone") (call "oak log axis x") (call "oak log axis y"))))

(scene "house")
"""
    )


@pytest.mark.slow
def test_words_do_not_meet() -> None:
    states = [
        BlockState("minecraft:stone"),
        BlockState("stone:minecraft"),
        BlockState("cube"),
        BlockState("a:b_c"),
        BlockState("a:b/c"),
    ]
    build = made((0, 0, 0), [[[1, 2, 3, 4, 5]]], states)
    text = program_text(build, "stone")
    words = [line.split('"')[1] for line in text.splitlines() if line.startswith("(bind")]
    assert len(set(words)) == 6
    assert "cube" not in words
    assert words[-1] == "stone"
    laid(text)


@pytest.mark.parametrize("name", ["", '"', "a\nb ; (", "house"])
def test_any_name(name: str) -> None:
    build = made((0, 0, 0), [[[1]]], STATES)
    assert_same(build, laid(program_text(build, name)).build)


def test_blocks_of_other_versions() -> None:
    old = [
        BlockState(
            "minecraft:cobblestone_wall", (("east", "true"), ("up", "true"))
        ),  # of 1.15, where sides were booleans
        BlockState("minecraft:grass_path", (("snowy", "false"),)),
        BlockState("other:machine", (("speed", "fast"),)),
    ]
    settled_ = laid(program_text(made((0, 0, 0), [[[1]], [[2]], [[3]]], old), "old"))
    names = {state.name: dict(state.properties) for state in settled_.build.palette}
    assert names["minecraft:cobblestone_wall"]["up"] == "true"
    assert "minecraft:dirt_path" in names
    assert [warning.name for warning in settled_.warnings] == ["unknown-block"]


def test_nothing_to_write() -> None:
    with pytest.raises(SceneError) as raised:
        program_text(made((0, 0, 0), np.zeros((1, 1, 1)), []), "house")
    assert raised.value.name == "empty-scene"


def test_unknown_blocks_by_the_thousand() -> None:
    text = program_text(noise((20, 20, 20), 300), "noise")
    assert text.count("(bind") == 301
