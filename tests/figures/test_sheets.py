"""Contact sheets and comparisons: cells, captions, scales, one backdrop, and what is marked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import evaluate

import scenelang as sl
from scenelang.backends.pictures.film import PictureOptions, picture_backend
from scenelang.backends.pictures.sheets import (
    CELL,
    MARKS,
    SheetOptions,
    arranged,
    cells_of_frames,
    cells_of_scenes,
    cells_of_views,
    check_wanted,
    compared,
    sheet_of,
    values_in,
)
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError

BOX = '(param side 1) (bind "it" (lambda () (call "cube" :scale [4 side 2] :color [.8 .2 .1])))'
FILM = '(bind "it" (lambda () (frames (for/list ((t (range 8))) (transform (call "cube") (translate [t 0 0]))))))'
DRAFT = picture_backend("draft")
SMALL = PictureOptions(width=80, height=60, environment="flat", ground="none")


def extent(pixels: np.ndarray) -> tuple[int, int]:
    """Width and height of the object in an image, which differs from its corner."""
    mask = (pixels[:, :, :3].astype(int) != pixels[0, 0, :3].astype(int)).any(axis=2)
    return int(mask.any(axis=0).sum()), int(mask.any(axis=1).sum())


def test_views_from_a_side_have_one_scale() -> None:
    cells = cells_of_views(evaluate(BOX), SMALL, ("front", "right", "top", "three-quarter"))
    assert [cell.caption for cell in cells] == ["front", "right", "top", "three-quarter"]
    front, right, top = (
        extent(sheet_of([cell], SMALL, DRAFT).pixels[10 : 10 + 60, 10 : 10 + 80]) for cell in cells[:3]
    )
    assert front == (pytest.approx(73, abs=1), pytest.approx(18, abs=1))
    assert right == (pytest.approx(36, abs=1), pytest.approx(18, abs=1))
    assert top == (pytest.approx(73, abs=1), pytest.approx(36, abs=1))
    assert not cells[3].shot.camera.is_parallel


def test_cells_are_in_rows_with_captions_below() -> None:
    images = [np.full((30, 40, 3), value, np.uint8) for value in (10, 60, 110, 160, 210)]
    sheet = arranged(images, ["a", "b", "c", "d", "e"], columns=2)
    assert sheet.captions == ("a", "b", "c", "d", "e")
    width = 2 * (40 + 10) + 10
    assert sheet.pixels.shape[1] == width
    step = (sheet.pixels.shape[0] - 10) / 3
    for k in range(5):
        x, y = 10 + k % 2 * 50, 10 + round(k // 2 * step)
        assert (sheet.pixels[y : y + 30, x : x + 40] == images[k]).all()
        assert (sheet.pixels[y + 31 : y + round(step), x : x + 40] < 128).any()  # the caption
    assert (sheet.pixels[:, :10] == 255).all()


def test_frames_of_a_film_and_angles_of_a_turntable() -> None:
    assert [cell.caption for cell in cells_of_frames(evaluate(FILM), SMALL, 4)] == [f"frame {k}" for k in (0, 2, 4, 6)]
    turned = cells_of_frames(evaluate(BOX), SMALL, 4)
    assert [cell.caption for cell in turned] == ["0°", "90°", "180°", "270°"]
    assert len({cell.shot.camera.eye.round(6).tobytes() for cell in turned}) == 4


def test_a_sheet_has_each_frame_of_a_film_once() -> None:
    captions = [cell.caption for cell in cells_of_frames(evaluate(FILM), SMALL, 20)]
    assert captions == [f"frame {k}" for k in range(8)]


def test_scenes_to_scale_have_one_camera() -> None:
    small, large = (evaluate(f'(bind "it" (lambda () (call "cube" :scale {side})))') for side in (1, 2))
    one, other = cells_of_scenes([("a", small), ("b", large)], SMALL, to_scale=True)
    assert one.shot.camera is other.shot.camera
    assert (one.shot.frame, other.shot.frame) == (0, 1)
    alone = cells_of_scenes([("a", small), ("b", large)], SMALL, to_scale=False)
    assert alone[0].shot.camera.eye != pytest.approx(alone[1].shot.camera.eye)


def test_the_first_cell_decides_the_backdrop() -> None:
    white, black = (evaluate(f'(bind "it" (lambda () (call "cube" :color [{c} {c} {c}])))') for c in (1, 0.02))
    options = PictureOptions(width=64, height=64)
    single = [
        sheet_of(cells_of_scenes([("a", s)], options, to_scale=True), options, DRAFT).pixels for s in (white, black)
    ]
    assert np.abs(single[0][14, 14].astype(int) - single[1][14, 14].astype(int)).max() > 40  # they would differ
    both = sheet_of(cells_of_scenes([("a", white), ("b", black)], options, to_scale=True), options, DRAFT).pixels
    assert np.abs(both[14, 14].astype(int) - both[14, 14 + 74].astype(int)).max() <= 3


# --- comparison ------------------------------------------------------------------------------------------------------


def parts(*places: str) -> object:
    shapes = " ".join(
        f'(transform (call "cube" :color [{c}]) (translate [{x} 0 0]))' for c, x in (p.split("@") for p in places)
    )
    return evaluate(f'(bind "it" (lambda () (union {shapes})))')


def test_what_differs_is_marked_in_its_color() -> None:
    before = parts(".5 .5 .5@-3", ".5 .5 .5@0", ".5 .5 .5@3")
    after = parts(".5 .5 .5@-3", ".1 .1 .9@0", ".5 .5 .5@3", ".9 .1 .1@6")
    front = sl.Camera(azimuth=0, elevation=0, orthographic=True)
    options = PictureOptions(width=200, height=60, environment="flat", ground="none", camera=front)
    found = compared([("A", before), ("B", after)], options, DRAFT, 1e-5)  # type: ignore[list-item]
    assert found.counts == {"removed": 0, "added": 1, "moved": 0, "recolored": 1}
    assert not found.equal
    # Units from -3.5 to 6.5 take 91 % of 200 pixels.
    column = lambda x, side: 10 + side * 210 + round(100 + (x - 1.5) * 18.2)
    row = 10 + 30
    assert found.pixels[row, column(-3, 0)].tolist() == found.pixels[row, column(-3, 1)].tolist()
    gray, marked = found.pixels[row, column(-3, 0)].astype(float), found.pixels[row, column(0, 0)].astype(float)
    assert marked == pytest.approx(0.55 * gray + 0.45 * np.array(MARKS["recolored"]), abs=2)
    ring = found.pixels[row, column(6.5, 1) + 1].astype(float)
    assert ring == pytest.approx(MARKS["added"], abs=40)
    assert found.pixels[row, column(6, 0)].tolist() == found.pixels[12, 12].tolist()  # nothing there in A


def test_equal_scenes_have_no_marks() -> None:
    scene = sl.Scene(evaluate(BOX))
    found = scene.comparison(scene, size=(60, 40))
    assert found.equal
    assert (found.pixels[10:50, 10:70] == found.pixels[10:50, 80:140]).all()


def test_moved_and_removed_parts() -> None:
    found = compared(
        [("A", parts(".5 .5 .5@0", ".9 .1 .1@2", ".1 .9 .1@4")), ("B", parts(".5 .5 .5@0", ".9 .1 .1@3"))],  # type: ignore[list-item]
        SMALL, DRAFT, 1e-5,
    )  # fmt: skip
    assert found.counts == {"removed": 1, "added": 0, "moved": 1, "recolored": 0}


# --- options ---------------------------------------------------------------------------------------------------------


def test_the_api_draws_sheets(tmp_path: Path) -> None:
    scene = sl.evaluate(BOX)
    assert scene.sheet(size=(40, 30)).captions == ("front", "right", "top", "three-quarter")
    assert scene.sheet(["top"], size=(40, 30)).captions == ("top",)
    varied = scene.sheet(vary={"side": [1, 2]}, size=(40, 30), columns=2)
    assert varied.captions == ("side = 1", "side = 2")
    assert scene.sheet(seeds=3, size=(40, 30)).captions == ("seed 0", "seed 1", "seed 2")
    assert scene.sheet(frames=2, size=(40, 30), figure=sl.Figure(outline=1.0)).save(tmp_path / "a.png").exists()
    with pytest.raises(SceneError, match="exclude"):
        scene.sheet(["top"], frames=2)


def test_a_seed_changes_what_is_random() -> None:
    scene = sl.evaluate('(bind "it" (lambda () (call "cube" :scale (+ 1 (random)))))')
    assert scene.with_seed(1).extents[0] != scene.with_seed(2).extents[0]
    assert scene.with_seed(1).extents[0] == scene.with_seed(1).extents[0]


def test_values() -> None:
    assert values_in("a = 1, 2") == ("a", ["1", "2"])
    for text in ("a", "=1", "a=", "a=1,,2"):
        with pytest.raises(SceneError):
            values_in(text)


@pytest.mark.parametrize(
    ("wanted", "scenes", "is_comparison"),
    [
        (SheetOptions(views=("top",), frames=2), 1, False), (SheetOptions(frames=0), 1, False), (SheetOptions(seeds=101), 1, False),
        (SheetOptions(frames=2), 2, False), (SheetOptions(), 1, True), (SheetOptions(seeds=2), 2, True), (SheetOptions(columns=0), 1, False),
    ],
)  # fmt: skip
def test_sheets_that_mean_nothing(wanted: SheetOptions, scenes: int, is_comparison: bool) -> None:
    with pytest.raises(SceneError):
        check_wanted(wanted, scenes, is_comparison=is_comparison)


@pytest.mark.parametrize(
    "options",
    [
        [], ["--views", "top,isometric"], ["--frames", "3"], ["--vary", "side=1,2,3", "--columns", "3"], ["--seeds", "2"],
        ["--views", "front", "--outline", "--section", "z=50%", "--background", "white"], ["--quality", "draft", "--callouts"],
    ],
)  # fmt: skip
def test_the_command_draws_sheets(tmp_path: Path, options: list[str]) -> None:
    program, image = tmp_path / "a.scene", tmp_path / "a.png"
    program.write_text(BOX)
    assert main(["sheet", str(program), "-o", str(image), "--size", "60x40", "-q", *options]) == 0
    assert image.stat().st_size > 0


def test_the_command_compares_and_draws_several_files(tmp_path: Path) -> None:
    from PIL import Image

    one, other, image = tmp_path / "a.scene", tmp_path / "b.scene", tmp_path / "a.png"
    one.write_text(BOX)
    other.write_text(BOX.replace(".8 .2 .1", ".1 .2 .8"))
    for options in ([], ["--compare"]):
        assert main(["sheet", str(one), str(other), "-o", str(image), "-q", *options]) == 0
        with Image.open(image) as opened:
            assert opened.width == 2 * (CELL[0] + 10) + 10


@pytest.mark.parametrize(
    "options",
    [
        ["-o", "a.gif"], ["-o", "a.exr"], ["--views", "sideways"], ["--views", ""], ["--views", "top,,front"], ["--vary", ""], ["--vary", "height=1"], ["--vary", "side"], ["--compare"],
        ["--ground", "transparent"], ["--frames", "0"], ["--frames", "1000"], ["--size", "4000x4000", "--frames", "4"],
    ],
)  # fmt: skip
def test_the_command_refuses_with_a_hint(
    tmp_path: Path, options: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.scene").write_text(BOX)
    output = [] if "-o" in options else ["-o", "a.png"]
    assert main(["sheet", "a.scene", *output, "--size", "40x30", *options]) != 0
    shown = capsys.readouterr().err
    assert "error" in shown
    assert "Traceback" not in shown
    assert not list(tmp_path.glob("a.[pge]*"))
