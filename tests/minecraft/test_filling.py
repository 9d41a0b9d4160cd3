"""Scenes filled with blocks: cells against a slow test of every center, thin things, meshes, colors and palettes."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from searching import many
from transpile.cases import scene_of

from scenelang.backends.minecraft import filling
from scenelang.backends.minecraft.blocks import load_table
from scenelang.backends.minecraft.filling import FAMILIES, USUAL, Filled, filled, in_blocks, palette_of
from scenelang.backends.surfaces.image_files import from_srgb
from scenelang.grammar.diagnostics import LimitError, SceneError


def fill(expression: str, longest: int) -> Filled:
    return filled(scene_of("a.scene", f'(bind "thing" (lambda () {expression}))').root, longest)


# What each word means, with the language's defaults, in its own frame.
INSIDE: dict[str, Any] = {
    "cube": lambda x, y, z: max(abs(x), abs(y), abs(z)) <= 0.5,
    "sphere": lambda x, y, z: x * x + y * y + z * z <= 1,
    "cylinder": lambda x, y, z: x * x + z * z <= 1 and 0 <= y <= 1,
    "cone": lambda x, y, z: x * x + z * z <= (1 - y) ** 2 and 0 <= y <= 1,
}
ANGLES = st.floats(-3.1, 3.1).map(lambda a: round(a, 2))
SIZES = st.floats(0.7, 3.0).map(lambda a: round(a, 2))


@settings(max_examples=many(60), deadline=None)
@given(st.sampled_from(sorted(INSIDE)), ANGLES, ANGLES, st.tuples(SIZES, SIZES, SIZES), st.integers(9, 16))
def test_cells_are_filled_where_their_centres_are_inside(
    word: str, a: float, b: float, size: Any, longest: int
) -> None:
    x, y, z = size
    turned = f"(@ (translate [3 -2 .7]) (rotate {a} [0 1 0]) (rotate {b} [1 0 0]) (scale [{x} {y} {z}]))"
    grid = fill(f'(transform (call "{word}") {turned})', longest)
    widths = {"cube": (x, y, z), "sphere": (2 * x, 2 * y, 2 * z)}.get(word, (2 * x, y, 2 * z))
    assume(min(widths) > 1.5 * grid.edge)  # thinner things fill more, so that nothing of them is lost
    scene = scene_of("a.scene", f'(bind "thing" (lambda () (transform (call "{word}") {turned})))')
    matrix = np.array([*scene.root.children[0].cdr, 0, 0, 0, 1]).reshape(4, 4)
    inverse = np.linalg.inv(matrix)
    from scenelang.interpreter.scene.bounds import entity_box

    box = entity_box(scene.root)
    assert box is not None
    low = np.array(box[:3])
    assert max(grid.cells.shape) == longest
    for cell in itertools.product(*map(range, grid.cells.shape)):
        center = low + (np.array(cell) + 0.5) * grid.edge
        p = (inverse @ [*center, 1])[:3]
        nudged = {bool(INSIDE[word](*(p * scale))) for scale in (1 - 1e-9, 1 + 1e-9)}
        assert len(nudged) == 2 or bool(grid.cells[cell]) in nudged


def test_thin_things_are_not_lost() -> None:
    sheet = fill('(union (call "cube" :scale [10 .01 10]) (transform (call "cube") (translate [0 5 0])))', 20)
    assert grid_layer(sheet, 0).all()
    slanted = fill('(transform (call "cube" :scale [10 .001 4]) (rotate .5 [0 0 1]))', 40)
    assert (slanted.cells != 0).any(axis=(1, 2)).all()  # no gap along x
    wire = fill('(call "cylinder" :radius .001 :p0 [0 0 0] :p1 [9 7 5])', 30)
    assert (wire.cells != 0).any(axis=(1, 2)).all()
    assert np.count_nonzero(wire.cells) < 100
    flat = fill('(call "cube" :scale [6 0 3])', 12)
    assert flat.cells.shape == (12, 1, 6)
    assert flat.cells.all()


def grid_layer(grid: Filled, y: int) -> np.ndarray:
    return grid.cells[:, y, :] != 0


def test_later_things_win_and_see_through_nothing_is_left_out() -> None:
    grid = fill('(union (call "cube" :color [1 0 0]) (call "cube" :color [0 0 1]) (call "cube" :opacity 0))', 4)
    assert grid.cells.shape == (4, 4, 4)
    assert {tuple(grid.looks.color[n - 1]) for n in np.unique(grid.cells)} == {(0.0, 0.0, 1.0)}


def test_the_origin_stays_the_origin() -> None:
    grid = fill('(transform (call "cube" :scale [4 4 4]) (translate [12 2 -6]))', 8)
    assert grid.origin == (20, 0, -16)
    assert grid.edge == 0.5


def test_words_without_geometry_are_boxes() -> None:
    assert fill('(call "dragon" :scale [2 1 1])', 8).cells.all()


def test_blocks_are_filled_too() -> None:
    text = '(union (call "set-cuboid" :block-type "red_wool" :scale [2 4 2]) (call "sphere" :radius .5 :color [0 0 1]))'
    build = in_blocks(fill(text, 16), palette_of("wool"))
    assert {state.name for state in build.palette[1:]} == {"minecraft:red_wool", "minecraft:blue_wool"}


def test_large_solids_are_looked_at_in_slabs(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = fill('(call "sphere")', 40)
    monkeypatch.setattr(filling, "_BATCH_CELLS", 3_000)
    assert np.array_equal(fill('(call "sphere")', 40).cells, whole.cells)
    assert np.count_nonzero(whole.cells) == pytest.approx(4 / 3 * math.pi * 20**3, rel=0.01)


# --- meshes ----------------------------------------------------------------------------------------------------------


@pytest.fixture
def ball(tmp_path: Path) -> Path:
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=4, radius=1.0)
    mesh.visual.face_colors = [0, 255, 0, 255]
    mesh.export(tmp_path / "ball.ply")
    return tmp_path


def mesh_scene(folder: Path, expression: str) -> Any:
    from scenelang.grammar.datum import Source
    from scenelang.session.session import Options, Session

    text = f'(bind "thing" (lambda () {expression}))'
    result = Session(Options(project=folder)).evaluate(Source(str(folder / "a.scene"), text))
    assert result.scene is not None, result.diagnostics
    return result.scene.root


def test_meshes_are_filled(ball: Path) -> None:
    grid = filled(mesh_scene(ball, '(call "mesh" :file "ball.ply")'), 30)
    edges = (np.indices(grid.cells.shape).reshape(3, -1).T + 0.5) * grid.edge - 1.0
    away = np.linalg.norm(edges, axis=1).reshape(grid.cells.shape)
    assert (grid.cells[away < 1 - 1e-3] != 0).all()  # every center inside
    assert (grid.cells[away > 1 + grid.edge] == 0).all()  # and at most the cells that the surface goes through
    assert [state.name for state in in_blocks(grid, palette_of("concrete")).palette[1:]] == ["minecraft:lime_concrete"]


def test_open_meshes_are_shells(tmp_path: Path) -> None:
    import trimesh

    box = trimesh.creation.box(extents=(2, 2, 2))
    box.update_faces(box.face_normals[:, 1] < 0.5)  # without its lid
    box.export(tmp_path / "box.ply")
    grid = filled(mesh_scene(tmp_path, '(call "mesh" :file "box.ply")'), 20)
    assert not grid.cells[5:15, 5:, 5:15].any()
    assert grid.cells[:, 0, :].all()
    assert grid.cells[0].all()


# --- colors ---------------------------------------------------------------------------------------------------------


def oklab(srgb: tuple[int, int, int]) -> tuple[float, float, float]:
    """Ottosson's formulas, by hand."""
    r, g, b = (c / 255 / 12.92 if c / 255 <= 0.04045 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in srgb)
    m0 = (0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b) ** (1 / 3)
    m1 = (0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b) ** (1 / 3)
    m2 = (0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b) ** (1 / 3)
    return (
        0.2104542553 * m0 + 0.7936177850 * m1 - 0.0040720468 * m2,
        1.9779984951 * m0 - 2.4285922050 * m1 + 0.4505937099 * m2,
        0.0259040371 * m0 + 0.7827717662 * m1 - 0.8086757660 * m2,
    )


def distance(one: tuple[float, float, float], other: tuple[float, float, float]) -> float:
    """Lightness by half, hue twice, written with angles."""
    (l1, a1, b1), (l2, a2, b2) = one, other
    c1, c2 = math.hypot(a1, b1), math.hypot(a2, b2)
    hue = 2 * math.sqrt(c1 * c2) * math.sin((math.atan2(b1, a1) - math.atan2(b2, a2)) / 2)
    return math.hypot((l1 - l2) / 2, c1 - c2, 2 * hue)


@pytest.mark.parametrize(
    ("color", "block"),
    [
        ("red", "red_"), ("white", "white_"), ("black", "black_"), ("gold", "yellow_"), ("royalblue", "blue_"),
        ("forestgreen", "lime_"), ("hotpink", "pink_"), ("gray", "gray_"), ("saddlebrown", "brown_"),
    ],
)  # fmt: skip
def test_colors_of_everyday(color: str, block: str) -> None:
    build = in_blocks(fill(f'(call "cube" :color (color "{color}"))', 1), palette_of("wool,concrete"))
    (found,) = (state.name.removeprefix("minecraft:").removeprefix("light_") for state in build.palette[1:])
    assert found.startswith(block)


@settings(max_examples=many(60), deadline=None)
@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_colors_become_the_nearest_block(color: tuple[int, int, int]) -> None:
    red, green, blue = from_srgb(np.array(color) / 255).tolist()
    build = in_blocks(
        fill(f'(call "cube" :color [{red:.9f} {green:.9f} {blue:.9f}])', 1), palette_of("concrete,terracotta")
    )
    (found,) = (state.name for state in build.palette[1:])
    blocks = load_table().blocks
    near = {
        name: distance(oklab(kind.color), oklab(color))
        for name, kind in blocks.items()
        if kind.color and name.endswith(("_concrete", "terracotta")) and "glazed" not in name
    }
    assert near[found] <= min(near.values()) + 1e-6


def test_what_is_seen_through_becomes_glass() -> None:
    text = (
        '(union (call "cube" :opacity .3 :color [1 0 0]) (transform (call "cube" :color [1 0 0]) (translate [2 0 0])))'
    )
    build = in_blocks(fill(text, 3), palette_of(USUAL))
    assert {s.name for s in build.palette[1:]} == {"minecraft:red_stained_glass", "minecraft:red_wool"}
    assert not [s for s in in_blocks(fill(text, 3), palette_of("wool")).palette if "glass" in s.name]


@pytest.mark.parametrize("family", FAMILIES)
def test_families_are_building_blocks(family: str) -> None:
    blocks = load_table().blocks
    palette = palette_of(family)
    assert len(palette.states) >= 10
    for state in palette.states:
        kind = blocks[state.name]
        assert kind.shape == "cube"
        assert not kind.is_for_operators
        assert kind.allows(state)
    if family == "all":
        assert not [s for s in palette.states if s.name.endswith(("sand", "gravel", "_powder", "_ore"))]


def test_palettes_name_blocks_too() -> None:
    names = [state.name for state in palette_of("Oak Planks, stone,stone").states]
    assert names == ["minecraft:oak_planks", "minecraft:stone"]


@pytest.mark.parametrize("text", ["", " , ", "wol", "oak_stairs", "torch", "command_block"])
def test_palettes_of_nothing(text: str) -> None:
    with pytest.raises(SceneError) as caught:
        palette_of(text)
    assert caught.value.name == "value"


def test_misspelled_families_get_a_hint() -> None:
    with pytest.raises(SceneError) as caught:
        palette_of("terracota")
    assert "terracotta" in (caught.value.hint or "")


# --- limits ----------------------------------------------------------------------------------------------------------


def test_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(filling, "MAX_CELLS", 999)
    with pytest.raises(LimitError, match="1,000 cells"):
        fill('(call "cube")', 10)
    with pytest.raises(LimitError, match="primitives"):
        filled(scene_of("a.scene", '(bind "a" (lambda () (union (call "cube") (call "sphere"))))').root, 4, limit=1)


def test_nothing_to_fill() -> None:
    with pytest.raises(SceneError) as caught:
        fill("(union)", 4)
    assert caught.value.name == "empty-scene"


def test_things_far_away() -> None:
    with pytest.raises(SceneError) as caught:
        fill('(transform (call "cube") (translate [1e30 0 0]))', 10)
    assert caught.value.name == "unsupported"
