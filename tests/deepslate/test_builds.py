"""Which blocks can be seen, of one frame and of several."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from deepslate.packs import scene_of
from hypothesis import given, settings
from hypothesis import strategies as st
from searching import many

from scenelang.backends.deepslate import builds as deepslate_builds
from scenelang.backends.deepslate.builds import AROUND, SIDES, Builds, builds_of, seen
from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, Build
from scenelang.backends.minecraft.connections import settled
from scenelang.backends.minecraft.voxels import voxelised
from scenelang.grammar.diagnostics import LimitError, SceneError

STATES = (
    AIR_STATE,
    BlockState("minecraft:stone"),
    BlockState("minecraft:glass"),
    BlockState("minecraft:oak_planks"),
    BlockState("minecraft:torch"),
    BlockState("minecraft:water", (("level", "0"),)),
    BlockState("minecraft:seagrass"),
)
SOLID, GLASS, WATER, WET = (1, 3), 2, 5, 6


def builds(body: str) -> Builds:
    return builds_of(dict(enumerate(scene_of(body).frames)), 1000)


def plainly(cells: np.ndarray) -> dict[tuple[int, ...], tuple[int, int]]:
    """What is seen, cell by cell: the state, and the bits of what stands around."""
    found = {}

    def at(place: tuple[int, ...]) -> int:
        inside = all(0 <= n < size for n, size in zip(place, cells.shape))
        return int(cells[place]) if inside else 0

    for place in product(*(range(n) for n in cells.shape)):
        own = at(place)
        beside = [at(tuple(np.add(place, step))) for step in SIDES]
        hidden = [
            other in SOLID or (own == other == GLASS) or (own in (WATER, WET) and other in (WATER, WET))
            for other in beside
        ]
        is_seen = not all(other in SOLID for other in beside) if own == WET else not all(hidden)
        around = [at(tuple(np.add(place, step))) in SOLID for step in AROUND]
        if own and is_seen:
            found[place] = own, sum(bit << k for k, bit in enumerate([*around, *hidden]))
    return found


@given(st.integers(0, 2**32 - 1), st.tuples(*[st.integers(1, 5)] * 3))
@settings(max_examples=many(40), deadline=None)
def test_what_is_seen_is_what_a_plain_loop_finds(seed: int, size: tuple[int, int, int]) -> None:
    cells = np.random.default_rng(seed).integers(0, len(STATES), size).astype(np.uint32)
    found = seen(Build((3, -2, 5), cells, STATES), (3, -2, 5))
    places = [tuple(place) for place in found.cells.T.tolist()]
    assert dict(zip(places, zip(found.states.tolist(), found.around.tolist()))) == plainly(cells)
    assert len(set(places)) == len(places)


def test_slabs_of_cells_make_no_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    cells = np.random.default_rng(1).integers(0, len(STATES), (9, 4, 4)).astype(np.uint32)
    whole = seen(Build((0, 0, 0), cells, STATES), (0, 0, 0))
    monkeypatch.setattr(deepslate_builds, "_SLAB", 40)
    parts = seen(Build((0, 0, 0), cells, STATES), (0, 0, 0))
    assert (whole.cells == parts.cells).all()
    assert (whole.around == parts.around).all()


def test_blocks_come_in_the_order_of_chunks() -> None:
    cells = np.ones((70, 1, 70), np.uint32)
    found = seen(Build((0, 0, 0), cells, STATES), (-40, 0, 5))
    chunks = [tuple(chunk) for chunk in (found.cells // deepslate_builds.CHUNK).T.tolist()]
    starts = [chunk for chunk, before in zip(chunks, [None, *chunks]) if chunk != before]
    assert len(starts) == len(set(chunks)), "every chunk in one piece"


def test_a_filled_cube_shows_its_shell_only() -> None:
    (frame,) = builds('(block "stone" 0 0 0 20 20 20)').frames.values()
    assert len(frame.states) == 20**3 - 18**3


def test_too_many_blocks_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deepslate_builds, "MAX_VISIBLE", 100)
    with pytest.raises(LimitError, match="more than the limit of 100 visible blocks"):
        builds('(block "stone" 0 0 0 20 1 20)')


def test_frames_share_one_palette_and_one_corner() -> None:
    found = builds(
        """(frames (list (block "stone" 5 0 0 1 1 1)
                         (union (block "glass" 2 0 0 1 1 1) (block "stone" 5 0 0 1 1 1))))"""
    )
    assert [state.name for state in found.palette] == ["minecraft:air", "minecraft:stone", "minecraft:glass"]
    assert found.corner == (5, 0, 0)
    assert found.frames[0].states.tolist() == [1]
    assert sorted(zip(found.frames[1].cells[0].tolist(), found.frames[1].states.tolist())) == [(-3, 2), (0, 1)]
    assert found.box == ([-3, 0, 0], [1, 1, 1])


def test_equal_frames_are_laid_once() -> None:
    root = scene_of('(block "stone" 0 0 0 1 1 1)').frames[0]
    found = builds_of({0: root, 1: root}, 1000)
    assert found.frames[0] is found.frames[1]


def test_a_frame_without_blocks_is_empty() -> None:
    found = builds('(frames (list (block "air" 0 0 0 1 1 1) (block "stone" 0 0 0 1 1 1)))')
    assert len(found.frames[0].states) == 0
    assert len(found.frames[1].states) == 1


def test_a_scene_without_blocks_is_an_error() -> None:
    with pytest.raises(SceneError, match="the scene places no blocks") as raised:
        builds('(call "cube")')
    assert raised.value.name == "empty-scene"


def test_what_is_left_out_or_replaced_is_told() -> None:
    found = builds('(union (call "cube") (block "chain" 0 0 0 1 1 1) (block "stonee" 0 1 0 1 1 1))')
    assert {warning.name for warning in found.warnings} >= {"no-block", "unknown-block"}


def test_states_are_whole() -> None:
    scene = scene_of('(block "oak_fence" 0 0 0 2 1 1)')
    found = builds_of({0: scene.frames[0]}, 1000)
    assert set(found.palette) == set(settled(voxelised(scene.frames[0])).build.palette)
