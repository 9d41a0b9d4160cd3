"""Combinators place blocks at whole cells; where truncation changes distances, a warning tells it."""

from __future__ import annotations

import numpy as np
import pytest
from transpile.cases import scene_of

from scenelang.backends.minecraft.connections import settled
from scenelang.backends.minecraft.voxels import voxelised

STONE = '(call "set-cuboid" :block-type "stone")'
WIDE = '(call "set-cuboid" :block-type "oak_planks" :scale [3 1 2])'


def laid(expression: str) -> tuple[list[tuple[int, int, int]], list[str]]:
    """The cells of a build, counted from its first one, and the warnings."""
    voxels = voxelised(scene_of("a.scene", f'(bind "build" (lambda () {expression}))').root)
    found = settled(voxels, similar=None)
    return [tuple(row) for row in np.argwhere(found.build.cells > 0).tolist()], [each.name for each in found.warnings]


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 8])
@pytest.mark.parametrize("spacing", [1, 2, 3, 5])
@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_grids_are_equally_spaced(count: int, spacing: int, axis: str) -> None:
    cells, warnings = laid(f"(grid {STONE} :n{axis} {count} :spacing {spacing})")
    k = "xyz".index(axis)
    assert [cell[k] for cell in sorted(cells)] == [spacing * i for i in range(count)]
    assert not warnings


def test_grids_of_functions_and_of_wide_things() -> None:
    cells, warnings = laid(f"(grid (lambda (i j k) {STONE}) :nx 2 :ny 2 :nz 2 :spacing 1)")
    assert len(cells) == 8
    cells, more = laid(f"(grid {WIDE} :nx 2 :nz 4 :spacing [5 1 3])")
    assert len(cells) == 2 * 4 * 6
    assert {x for x, _, _ in cells} == {0, 1, 2, 5, 6, 7}
    assert not warnings + more


@pytest.mark.parametrize("gap", [0, 1, 2, 3])
@pytest.mark.parametrize("things", [(STONE, STONE), (STONE, WIDE, STONE), (WIDE, WIDE), (STONE,) * 4])
def test_rows_keep_their_gaps(gap: int, things: tuple[str, ...]) -> None:
    cells, warnings = laid(f"(row (list {' '.join(things)}) :gap {gap})")
    expected, at = set(), 0
    for thing in things:
        width = 3 if thing == WIDE else 1
        expected |= set(range(at, at + width))
        at += width + gap
    assert {x for x, _, _ in cells} == expected
    assert not warnings


@pytest.mark.parametrize(
    "expression",
    [
        f"(on-top-of {STONE} {WIDE})",
        f"(align {STONE} {WIDE} :x :center :z :center :y :after)",
        f"(attach {STONE} {WIDE} :at [0 1 0])",
        f"(stack (list {WIDE} {STONE}) :gap 1)",
        f"(jitter (grid {STONE} :nx 4 :spacing 6) :move [2 0 2])",
        f"(scatter 9 {STONE} :size 20 :apart 2 :turn 0)",
        f"(union (row (list {STONE} {WIDE}) :gap 1) (transform (grid {STONE} :nx 2) (translate [0 4 0])))",
    ],
)
def test_other_combinators_keep_to_cells(expression: str) -> None:
    assert not laid(expression)[1]


@pytest.mark.parametrize("x", [-10, -9, 0, 7])
def test_where_it_stands_does_not_matter(x: int) -> None:
    moved = f"(transform {WIDE} (translate [{x} 0 0]))"
    here, there = (
        laid(f"(union {WIDE} (on-top-of {STONE} {WIDE}))"),
        laid(f"(union {moved} (on-top-of {STONE} {moved}))"),
    )
    assert here == there


def test_things_that_are_no_blocks_stay_where_they_were() -> None:
    root = scene_of("a.scene", '(bind "it" (lambda () (grid (call "cube") :nx 2 :spacing .3)))').root
    assert [part.cdr[3] for part in root.children] == [-0.15, 0.15]


@pytest.mark.parametrize(
    ("expression", "warned"),
    [
        (f"(grid {STONE} :nx 4 :spacing 1.5)", True),
        (f"(row (list {STONE} {STONE} {STONE}) :gap .5)", True),
        (f"(ring 5 {STONE} :radius 4 :turn #f)", True),
        (f"(ring 4 {STONE} :radius 4 :turn #f)", False),
        (
            f"(transform (union-loop 3 (lambda (i) (transform {STONE} (translate [i 0 0])))) (translate [-1.5 0 0]))",
            True,
        ),
        (
            f"(transform (union-loop 3 (lambda (i) (transform {STONE} (translate [i 0 0])))) (translate [1.5 0 0]))",
            False,
        ),
        (f"(grid {STONE} :nx 5 :spacing 2)", False),
    ],
)
def test_truncation_that_changes_distances_is_told(expression: str, warned: bool) -> None:
    assert laid(expression)[1] == (["off-cells"] if warned else [])
