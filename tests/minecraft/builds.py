"""Builds for the tests of files: random ones of real states, and a way to compare two."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, Build, load_table, trimmed, unified

NAMES = [
    "stone", "oak_log", "oak_stairs", "oak_fence", "glass_pane", "cobblestone_wall", "oak_door", "torch", "white_wool",
    "stone_slab", "redstone_wire", "chest", "note_block", "water", "short_grass", "iron_chain",
]  # fmt: skip


def all_states(names: list[str]) -> list[BlockState]:
    """Some states of each block: the default one, and one with every property at its last value."""
    found = []
    for name in names:
        kind = load_table().blocks[f"minecraft:{name}"]
        for chosen in (kind.defaults, {key: values[-1] for key, values in kind.values.items()}):
            found.append(BlockState(kind.name, tuple(sorted(chosen.items()))))
    return sorted(set(found))


STATES = all_states(NAMES)


def made(origin: tuple[int, int, int], numbers: Any, states: list[BlockState]) -> Build:
    """A build from an array (X, Y, Z) of numbers, 0 air, others places in ``states`` from 1 on."""
    return trimmed(unified(origin, np.asarray(numbers, np.uint32), [AIR_STATE, *states]))


ORIGINS = st.tuples(*[st.integers(-70, 70)] * 3)
GRIDS = arrays.arrays(
    np.uint32,
    arrays.array_shapes(min_dims=3, max_dims=3, max_side=6),
    elements=st.integers(0, len(STATES)),
    fill=st.integers(0, 2),
).filter(lambda grid: bool(grid.any()))
BUILDS = st.builds(made, ORIGINS, GRIDS, st.just(STATES))


def noise(shape: tuple[int, int, int], count: int, seed: int = 1) -> Build:
    """A build without much order of ``count`` kinds of state that no table knows."""
    rng = np.random.default_rng(seed)
    states = [BlockState("other:block", (("n", str(i)),)) for i in range(count)]
    return made((-3, 4, -7), rng.integers(0, count + 1, shape), states)


def assert_same(a: Build, b: Build) -> None:
    """Both have the same states in the same cells, and keep what a build promises."""
    assert b.origin == a.origin
    assert b.size == a.size
    assert b.palette[0] == AIR_STATE
    assert sorted(a.palette) == sorted(b.palette)
    place = {state: i for i, state in enumerate(a.palette)}
    assert (np.array([place[state] for state in b.palette], np.uint32)[b.cells] == a.cells).all()
