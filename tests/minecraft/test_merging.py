"""Cells merged into few cuboids."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from searching import many

from scenelang.backends.minecraft.blocks import Cells, Cuboids, merged

GRIDS = arrays.arrays(np.uint32, arrays.array_shapes(min_dims=3, max_dims=3, max_side=5), elements=st.integers(0, 3))


def laid(shape: tuple[int, ...], cuboids: Cuboids) -> Cells:
    """The cells that cuboids fill; each cell once."""
    cells = np.zeros(shape, np.uint32)
    for low, size, number in zip(cuboids.low.tolist(), cuboids.size.tolist(), cuboids.number.tolist()):
        where = tuple(slice(a, a + n) for a, n in zip(low, size))
        assert not cells[where].any()
        cells[where] = number
    return cells


@given(GRIDS)
@settings(max_examples=many(300))
def test_cuboids_fill_the_same_cells(cells: Cells) -> None:
    cuboids = merged(cells)
    assert (laid(cells.shape, cuboids) == cells).all()
    assert (cuboids.size > 0).all()


@given(GRIDS, arrays.arrays(np.bool_, (4, 3)))
@settings(max_examples=many(300))
def test_cells_are_joined_only_along_their_axes(cells: Cells, along: np.ndarray) -> None:
    cuboids = merged(cells, along)
    assert (laid(cells.shape, cuboids) == cells).all()
    assert (along[cuboids.number] | (cuboids.size == 1)).all()


@pytest.mark.parametrize("axis", range(3))
def test_a_hollow_box_takes_six_cuboids_and_a_filled_one_one(axis: int) -> None:
    shape = [7, 7, 7]
    shape[axis] = 9
    cells = np.ones(shape, np.uint32)
    assert len(merged(cells)) == 1
    cells[1:-1, 1:-1, 1:-1] = 0
    assert len(merged(cells)) == 6
    cells[1:-1, 1:-1, 1:-1] = 2
    assert len(merged(cells)) == 7


def test_cuboids_come_from_the_ground_up() -> None:
    cells = np.zeros((3, 3, 3), np.uint32)
    cells[2, 0, 1], cells[0, 2, 0], cells[1, 0, 2] = 1, 2, 3
    assert merged(cells).number.tolist() == [1, 3, 2]


def test_empty_grids_have_no_cuboids() -> None:
    assert len(merged(np.zeros((0, 0, 0), np.uint32))) == 0
    assert len(merged(np.zeros((2, 3, 4), np.uint32))) == 0


def test_grids_that_are_looked_at_in_slabs() -> None:
    cells = np.ones((40, 400, 400), np.uint32)
    cells[20, 7, 3] = 0
    assert (laid(cells.shape, merged(cells)) == cells).all()
