"""Outlines, styles, callouts and dimensions in images, against closed forms of what is seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import evaluate

import scenelang as sl
from scenelang.backends.pictures import notes
from scenelang.backends.pictures.camera import PRESETS
from scenelang.backends.pictures.drawn_over import callouts_of, covered, zoomed
from scenelang.backends.pictures.figures import Figure, figured
from scenelang.backends.pictures.film import Image, PictureOptions, check
from scenelang.backends.pictures.linework import lines_of
from scenelang.backends.pictures.notes import Callout, Overlay, dimensions_of, place_callouts
from scenelang.backends.pictures.stage import staging_of, still
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError

CUBE = '(bind "it" (lambda () (call "cube" :scale 2 :color [.8 .2 .1])))'
BALL = '(bind "it" (lambda () (call "sphere" :radius 1)))'
TWO = """(bind "red one" (lambda () (call "sphere" :radius 1 :color [1 0 0])))
(bind "blue one" (lambda () (call "sphere" :radius 1 :color [0 0 1])))
(bind "it" (lambda () (union (transform (call "red one") (translate [-2 0 0])) (transform (call "blue one") (translate [2 0 0])))))"""
FRONT = sl.Camera(azimuth=0, elevation=0, orthographic=True)


def scene(program: str) -> sl.Scene:
    return sl.Scene(evaluate(program))


def inked(pixels: np.ndarray) -> np.ndarray:
    return np.asarray(pixels[:, :, :3].astype(int).sum(axis=2) < 250)


def lines(program: str, camera: str, width: float, size: tuple[int, int] = (120, 120)) -> np.ndarray:
    graph = evaluate(program)
    shot = still(graph, PRESETS[camera], None, *size)
    return lines_of(staging_of(graph, [0], 1000).stage(shot), width).ink


def test_the_outline_of_a_square_has_its_length_and_width() -> None:
    # A square of side s: a line of width w around it covers about 4 s w.
    for width in (1.0, 2.0, 4.0):
        ink = lines(CUBE, "elevation", width)
        assert ink.sum() == pytest.approx(4 * 0.91 * 120 * width, rel=0.08)


def test_the_outline_of_a_ball_is_its_circle_alone() -> None:
    ink = lines(BALL, "elevation", 2.0)
    assert ink.sum() == pytest.approx(np.pi * 0.91 * 120 * 2.0, rel=0.08)
    assert ink[30:90, 30:90].max() == 0.0


def test_creases_are_lines() -> None:
    # Nine edges of a cube are seen from a corner, six of them as its outline.
    plain, isometric = lines(CUBE, "elevation", 2.0), lines(CUBE, "isometric", 2.0)
    side = 0.91 * 120 / 2.0
    assert isometric.sum() == pytest.approx(9 * side * 2.0, rel=0.1)
    assert plain[40:80, 40:80].max() == 0.0
    assert isometric[45:75, 45:75].max() > 0.9


def test_touching_objects_are_told_apart_and_jumps_of_depth_have_lines() -> None:
    pair = '(bind "it" (lambda () (union (call "cube") (transform (call "cube") (translate [1 0 0])))))'
    ink = lines(pair, "elevation", 2.0)
    assert ink[60, 58:63].max() > 0.9
    # Two steps of one solid, seen from the front: their faces have one normal and differ in depth.
    steps = '(bind "it" (lambda () (solid-union (call "cube") (transform (call "cube") (translate [0 1 -.5])))))'
    assert lines(steps, "elevation", 2.0)[58:63, 60].max() > 0.9


def test_lines_are_antialiased() -> None:
    ink = lines(BALL, "elevation", 2.0)
    assert ((ink > 0.1) & (ink < 0.9)).sum() > 200


def test_an_outline_changes_only_the_lines() -> None:
    plain = scene(CUBE).render(FRONT, size=(80, 80)).pixels.astype(int)
    lined = (
        scene(CUBE).render(FRONT, size=(80, 80), figure=Figure(outline=2.0, outline_color="#ff0000")).pixels.astype(int)
    )
    changed = (plain != lined).any(axis=2)
    assert 0.5 * 4 * 73 * 2 < changed.sum() < 2 * 4 * 73 * 2
    row = lined[40, 2:6]
    assert (row[:, 0] > row[:, 1] + 100).any()


def test_outlines_keep_alpha() -> None:
    image = scene(BALL).render(FRONT, size=(80, 80), ground="transparent", figure=Figure(outline=3.0))
    assert image.pixels[0, 0, 3] == 0
    assert image.pixels[40, 40, 3] == 255
    assert image.pixels[40, 3, 3] > 200  # the line reaches out of the ball
    assert image.pixels[40, 3, :3].max() < 60


def test_covering_follows_the_closed_form_of_over() -> None:
    picture, alpha = np.full((1, 1, 3), 200, np.uint8), np.full((1, 1), 128, np.uint8)
    image = covered(
        Image(picture, np.zeros((1, 1, 3), np.float32), alpha), np.zeros(3, np.uint8), np.full((1, 1), 0.5, np.float32)
    )
    assert image.alpha is not None
    assert int(image.alpha[0, 0]) == round(255 * (0.5 + 0.5 * 128 / 255))
    assert int(image.picture[0, 0, 0]) == pytest.approx(200 * (1 - 0.5 / (0.5 + 0.5 * 128 / 255)), abs=1)


def test_a_line_drawing_is_black_on_white() -> None:
    pixels = scene(CUBE).render(FRONT, size=(80, 80), figure=Figure(style="line")).pixels
    assert (pixels[40, 40, :3] == 255).all()
    assert (pixels[0, 0, :3] == 255).all()
    assert inked(pixels).sum() > 200


def test_a_wireframe_has_the_edges_of_triangles() -> None:
    line = scene(CUBE).render(FRONT, size=(80, 80), figure=Figure(style="line", outline=1.0)).pixels
    wire = scene(CUBE).render(FRONT, size=(80, 80), figure=Figure(style="wire", outline=2.0)).pixels
    assert not inked(line)[20:60, 20:60].any()
    assert inked(wire)[20:60, 20:60].sum() > 30  # the diagonal of the face


def test_clay_has_one_color() -> None:
    pixels = (
        scene(TWO).render(FRONT, size=(80, 40), environment="flat", ground="none", figure=Figure(style="clay")).pixels
    )
    assert (pixels[20, 10] == pixels[20, 70]).all()


def test_line_drawings_before_backgrounds_and_without() -> None:
    figure = Figure(style="line")
    red = scene(BALL).render(FRONT, size=(60, 60), background="red", figure=figure).pixels
    assert red[0, 0].tolist() == [255, 0, 0, 255]
    assert red[30, 30].tolist() == [255, 255, 255, 255]
    assert scene(BALL).render(FRONT, size=(60, 60), ground="transparent", figure=figure).pixels[0, 0, 3] == 0


# --- callouts --------------------------------------------------------------------------------------------------------


def test_callouts_point_at_their_objects() -> None:
    seen = np.full((20, 40), -1)
    seen[5:15, 2:12], seen[8:12, 28:38] = 0, 1
    one, other = callouts_of(evaluate(TWO).root, ("*",), seen)
    assert (one.text, other.text) == ("red one", "blue one")
    assert seen[int(one.at[1]), int(one.at[0])] == 0
    assert seen[int(other.at[1]), int(other.at[0])] == 1
    assert one.at == (pytest.approx(7, abs=1.1), pytest.approx(10, abs=1.1))


def test_instances_of_one_word_share_a_callout_and_hidden_ones_have_none() -> None:
    row = '(bind "ball" (lambda () (call "sphere"))) (bind "it" (lambda () (for/union ((i 3)) (transform (call "ball") (translate [(* 3 i) 0 0])))))'
    seen = np.array([[0, 1, 1, -1]])
    (only,) = callouts_of(evaluate(row).root, ("*",), seen)
    assert only.text == "ball (3)"
    assert seen[0, int(only.at[0])] == 1
    with pytest.raises(SceneError, match="no object of the callouts is seen"):
        callouts_of(evaluate(row).root, ("ball",), np.full((2, 2), -1))
    with pytest.raises(SceneError):
        callouts_of(evaluate(row).root, ("cat",), seen)


@pytest.mark.parametrize("count", [1, 5, 60])
def test_callouts_do_not_overlap_and_stay_inside(count: int) -> None:
    rng = np.random.default_rng(count)
    size, drawing = (400, 300), Overlay()
    callouts = [Callout(f"part {k}", (float(x), float(y))) for k, (x, y) in enumerate(rng.uniform(80, 220, (count, 2)))]
    place_callouts(callouts, (80, 40, 320, 260), size, drawing)
    font = notes.font_size(*size)
    boxes = []
    for text, (x, y) in drawing.texts:
        half = notes.text_width(text, font) / 2.0
        boxes.append((x - half, y - font / 2, x + half, y + font / 2))
    assert len(boxes) == min(count, 2 * int((300 - font) / (1.35 * font)))
    for k, (left, top, right, bottom) in enumerate(boxes):
        assert left >= 0
        assert top >= 0
        assert right <= 400
        assert bottom <= 300
        for other in boxes[k + 1 :]:
            assert left >= other[2] or other[0] >= right or top >= other[3] or other[1] >= bottom


def test_callouts_leave_room_and_the_camera_says_so() -> None:
    plain, noted = (scene(TWO).render(FRONT, size=(300, 150), figure=Figure(callouts=c)) for c in (None, ("*",)))
    assert noted.camera.focal[0] < 0.9 * plain.camera.focal[0]
    x, _ = noted.camera.project(np.array([[-3.0, 0.0, 0.0]]))
    assert x[0, 0] > notes.text_width("blue one", notes.font_size(300, 150))
    assert inked(noted.pixels)[:, :60].sum() > 20


def test_a_given_camera_is_kept() -> None:
    placed = scene(TWO).placed(FRONT, (300, 150))
    assert scene(TWO).render(placed, figure=Figure(callouts=("*",))).camera.focal == placed.focal


def test_zooming_keeps_the_middle() -> None:
    camera = scene(CUBE).placed(FRONT, (100, 80))
    one, _ = camera.project(np.array([[0.3, 0.2, 0.5]]))
    other, _ = zoomed(camera, 0.5).project(np.array([[0.3, 0.2, 0.5]]))
    assert other - [50, 40] == pytest.approx(0.5 * (one - [50, 40]))


# --- dimensions ------------------------------------------------------------------------------------------------------


def test_dimensions_are_those_of_the_box() -> None:
    graph = evaluate('(bind "it" (lambda () (call "cube" :scale [2 3 4.5])))')
    camera = still(graph, PRESETS["three-quarter"], None, 300, 300).camera
    assert [one.text for one in dimensions_of((-1, -1.5, -2.25, 1, 1.5, 2.25), camera)] == ["2", "3", "4.5"]
    front = still(graph, PRESETS["elevation"], None, 300, 300).camera
    width, height = dimensions_of((-1, -1.5, -2.25, 1, 1.5, 2.25), front)
    assert (width.text, height.text) == ("2", "3")
    assert width.end[0] - width.start[0] == pytest.approx(2 * front.focal[0])
    assert width.away[1] > 0  # below
    assert height.away[0] < 0  # on the left


@pytest.mark.parametrize("preset", ["three-quarter", "isometric", "elevation", "top", "hero"])
def test_dimensions_are_outside_of_the_objects_and_inside_of_the_image(preset: str) -> None:
    image = scene(CUBE).render(
        sl.Camera(**{name: getattr(PRESETS[preset], name) for name in ("azimuth", "elevation", "fov", "orthographic")}),
        size=(240, 200), ground="none", environment="flat", figure=Figure(dimensions="."),
    )  # fmt: skip
    dark = inked(image.pixels)
    assert dark.sum() > 40
    assert not dark[0].any()
    assert not dark[-1].any()
    assert not dark[:, 0].any()
    assert not dark[:, -1].any()


def test_dimensions_of_an_object() -> None:
    with pytest.raises(SceneError):
        scene(TWO).render(FRONT, size=(100, 100), figure=Figure(dimensions="cat"))
    white = TWO.replace("[1 0 0]", "[1 1 1]").replace("[0 0 1]", "[1 1 1]")
    image = scene(white).render(FRONT, size=(200, 100), environment="flat", figure=Figure(dimensions="red one"))
    assert inked(image.pixels)[:, :100].sum() > 20
    assert not inked(image.pixels)[:, 110:].any()


# --- options ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("figure", "message"),
    [
        (Figure(section="q"), "is no section"), (Figure(explode=-1.0), "explode"), (Figure(explode=1.0, explode_axis="w"), "axis"),
        (Figure(outline=0.0), "outline"), (Figure(style="oil"), "style"), (Figure(callouts=("a[",)), "is no path"),
        (Figure(outline_color="blurple"), "blurple"), (Figure(explode_axis="x"), "no effect"), (Figure(explode_depth=1), "no effect"),
    ],
)  # fmt: skip
def test_wrong_figures(figure: Figure, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        check(PictureOptions(figure=figure), [])
    with pytest.raises(SceneError, match=message):
        scene(CUBE).render(size=(8, 8), figure=figure)


def test_videos_have_outlines_but_no_notes() -> None:
    film = scene(CUBE).film(frames=2, size=(40, 40), figure=Figure(outline=2.0, explode=1.0, section="x=50%"))
    assert [inked(image.pixels).any() for image in film] == [True, True]
    for figure in (Figure(callouts=("*",)), Figure(dimensions=".")):
        with pytest.raises(SceneError, match="a video has no"):
            scene(CUBE).film(frames=2, figure=figure)


def test_the_figure_of_a_plain_image_is_the_scene() -> None:
    graph = evaluate(TWO)
    assert figured(graph, Figure()) is graph


@pytest.mark.parametrize(
    "options",
    [
        ["--section", "x=50%"], ["--section=-z=50%"], ["--explode", "1", "--explode-axis", "x"], ["--outline"], ["--outline", "3"],
        ["--style", "line"], ["--style", "wire"], ["--style", "clay"], ["--callouts"], ["--callouts", "red one,blue one"],
        ["--dimensions"], ["--dimensions", "red one"], ["--explode", ".5", "--explode-depth", "1"],
    ],
)  # fmt: skip
def test_the_command_draws_figures(tmp_path: Path, options: list[str]) -> None:
    program, plain, image = tmp_path / "a.scene", tmp_path / "plain.png", tmp_path / "a.png"
    program.write_text(TWO)
    assert main(["render", str(program), "-o", str(plain), "--size", "80x60", "-q"]) == 0
    assert main(["render", str(program), "-o", str(image), "--size", "80x60", "-q", *options]) == 0
    assert image.read_bytes() != plain.read_bytes()


@pytest.mark.parametrize(
    ("options", "output"),
    [
        (["--callouts"], "a.gif"), (["--dimensions"], "a.mp4"), (["--outline"], "a.exr"), (["--section", "w=1"], "a.png"),
        (["--outline-color", "blurple"], "a.png"), (["--callouts", "cat"], "a.png"),
    ],
)  # fmt: skip
def test_the_command_refuses_with_a_hint(
    tmp_path: Path, options: list[str], output: str, capsys: pytest.CaptureFixture[str]
) -> None:
    program = tmp_path / "a.scene"
    program.write_text(TWO)
    assert main(["render", str(program), "-o", str(tmp_path / output), "--size", "40x30", *options]) != 0
    assert "Traceback" not in (shown := capsys.readouterr().err)
    assert "hint" in shown
    assert not (tmp_path / output).exists()
