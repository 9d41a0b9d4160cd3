"""Cameras, environment and settings of a program in pictures: placement, words, frames, and what a command overrides."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import scenelang as sl
from scenelang.backends.pictures import film as film_of_pictures
from scenelang.backends.pictures.camera import PRESETS, Camera, Viewpoint, parse_viewpoint
from scenelang.backends.pictures.declared import ProgramView, view_of
from scenelang.backends.pictures.film import PictureOptions, render
from scenelang.backends.pictures.stage import film, staging_of, still
from scenelang.backends.pictures.surroundings import settled
from scenelang.backends.surfaces.environments import ENVIRONMENTS, GROUNDS, IMAGES, SKY
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError, UsageError
from scenelang.interpreter.scene import setup

SCENE = """
(bind "ball" (lambda () (call "sphere" :radius .5)))
(bind "row" (lambda () (for/union ((x (list 0 2 4))) (transform (call "ball") (translate [x 0 1])))))
(bind "room" (lambda () (union (transform (call "row") (@ (translate [0 3 0]) (scale 2))) (call "cube"))))
(scene "room")
"""
FILM = """
(bind "ball" (lambda () (call "sphere" :radius .5)))
(bind "film" (lambda () (frames (for/list ((x (list 0 1 2 3 4)))
  (union (call "cube") (transform (call "ball") (translate [x 2 0])))))))
(scene "film")
"""


def placed(text: str, name: str = "", frame: int | None = None, size: tuple[int, int] = (80, 60)) -> Camera:
    return still(sl.evaluate(text).graph, view_of(name), frame, *size).camera


def seen(camera: Camera, point: tuple[float, float, float]) -> np.ndarray:
    return camera.project(np.array([point]))[0][0]


def test_eye_and_target() -> None:
    camera = placed(SCENE + "(camera :eye [3 2 5] :look-at [0 1 0] :fov 40)")
    assert camera.eye == pytest.approx([3, 2, 5])
    assert seen(camera, (0, 1, 0)) == pytest.approx([40, 30])
    assert camera.right[1] == 0.0
    assert 2 * math.degrees(math.atan(30 / camera.focal[1])) == pytest.approx(40)


def test_a_lens_of_50_mm_on_36_by_24() -> None:
    camera = placed(SCENE + "(camera :eye [3 2 5] :lens 50)", size=(90, 60))
    assert 2 * math.degrees(math.atan(45 / camera.focal[0])) == pytest.approx(39.5978, abs=1e-4)  # of the data sheets


@pytest.mark.parametrize(
    ("words", "center"),
    [("row", (4, 3, 2)), ("ball", (4, 3, 2)), ("row/ball[0]", (0, 3, 2)), ("ball[2]", (8, 3, 2)), ("cube", (0, 0, 0)),
     ("room", (4, 1.75, 1.25))],
)  # fmt: skip
def test_words_under_loops_and_transforms(words: str, center: tuple[float, float, float]) -> None:
    # `row` is scaled by 2 and moved: balls of radius 1 at (0 3 2), (4 3 2) and (8 3 2); `room` from (-1 -.5 -.5) to (9 4 3).
    assert seen(placed(f'{SCENE}(camera :eye [3 9 25] :look-at "{words}")'), center) == pytest.approx([40, 30])


def test_angles_are_those_of_the_option() -> None:
    one = placed(SCENE + "(camera :azimuth 40 :elevation 20 :distance 30 :fov 50 :look-at [1 0 0])")
    other = placed(SCENE, "azimuth=40,elevation=20,distance=30,fov=50,target=1:0:0")
    assert np.allclose(one.world_to_camera, other.world_to_camera)
    assert np.allclose(one.intrinsics, other.intrinsics)
    top = placed(SCENE + '(camera :preset "top" :roll 90)')
    assert np.allclose(top.world_to_camera[0, :3], -placed(SCENE, "top").up, atol=1e-12)


def test_roll_turns_the_image_counterclockwise() -> None:
    camera = placed(SCENE + "(camera :eye [0 0 9] :look-at [0 0 0] :roll 30)")
    x, y = seen(camera, (0, 1, 0)) - [40, 30]
    assert math.degrees(math.atan2(-x, -y)) == pytest.approx(30)


def test_a_parallel_projection_shows_what_it_looks_at_as_large() -> None:
    perspective, parallel = (placed(f"{SCENE}(camera :eye [0 0 9] :look-at [0 0 0] {more})") for more in
                             ("", ":orthographic #t"))  # fmt: skip
    assert parallel.is_parallel
    assert seen(parallel, (1, 0, 0)) == pytest.approx(seen(perspective, (1, 0, 0)))


def test_the_lens_is_focused_on_what_it_looks_at() -> None:
    camera = placed(SCENE + "(camera :eye [0 0 9] :look-at [0 0 4] :aperture .2)")
    assert (camera.aperture, camera.focus) == (0.2, 5.0)


def test_values_over_the_frames() -> None:
    text = FILM + "(camera :eye (list [0 0 9] [0 4 9]) :look-at [0 0 0] :fov (list 30 40 60))"
    scene = sl.evaluate(text).graph
    shots = film(scene, ProgramView(), 80, 60, None, None)
    assert [shot.frame for shot in shots] == [0, 1, 2, 3, 4]
    assert [shot.camera.eye[1] for shot in shots] == pytest.approx([0, 1, 2, 3, 4])
    fovs = [2 * math.degrees(math.atan(30 / shot.camera.focal[1])) for shot in shots]
    assert fovs == pytest.approx([30, 35, 40, 50, 60])
    for shot in shots:
        assert np.allclose(still(scene, ProgramView(), shot.frame, 80, 60).camera.eye, shot.camera.eye)


def test_one_value_for_each_frame_is_exact() -> None:
    text = FILM + "(camera :eye (for/list ((i (list 0 1 4 9 16))) [i 0 9]) :look-at [0 0 0])"
    assert [placed(text, frame=k).eye[0] for k in range(5)] == pytest.approx([0, 1, 4, 9, 16])


def test_words_are_followed() -> None:
    text = FILM + '(camera :eye [2 2 20] :look-at "ball")'
    for frame in range(5):
        assert seen(placed(text, frame=frame), (frame, 2, 0)) == pytest.approx([40, 30])


def test_a_still_scene_with_a_path_is_a_film_without_orbit() -> None:
    scene = sl.evaluate(SCENE + "(camera :eye (list [0 0 30] [9 0 30]))").graph
    shots = film(scene, ProgramView(), 80, 60, 4, None)
    assert [shot.camera.eye[0] for shot in shots] == pytest.approx([0, 3, 6, 9])
    around = film(sl.evaluate(SCENE + "(camera :eye [0 5 30] :look-at [0 0 0])").graph, ProgramView(), 80, 60, 4, None)
    assert [np.round(shot.camera.eye, 6).tolist() for shot in around] == [
        [0, 5, 30],
        [30, 5, 0],
        [0, 5, -30],
        [-30, 5, 0],
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('(camera :look-at (string-append "be" "ll"))', 'looks at "bell", which names nothing'),
        ("(camera :eye [1 0 0] :look-at [1 0 0])", "the camera is at the point"),
        ('(camera :preset "topp")', '`camera` names no preset: "topp"'),
    ],
)
def test_errors_are_at_the_declaration(text: str, message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        placed(SCENE + text)
    assert caught.value.span is not None
    assert caught.value.span.text in text


def test_names() -> None:
    text = SCENE + '(camera "main" :eye [0 0 9])(camera "top" :eye [0 0 7])'
    assert [placed(text, name).eye[2] for name in ("", "main", "top")] == [9, 9, 7]
    assert placed(text, "isometric").is_parallel
    with pytest.raises(UsageError) as caught:
        placed(text, "mian")
    assert caught.value.hint == "did you mean `main`?"
    assert placed(SCENE).eye == pytest.approx(still(sl.evaluate(SCENE).graph, Viewpoint(), None, 80, 60).camera.eye)


def test_values_of_a_camera_are_changed() -> None:
    scene = sl.evaluate(f'{SCENE}(camera "main" :eye [0 5 30] :look-at [0 0 0] :fov 20)(camera "lens" :lens 50)').graph
    usual, wide = (still(scene, view_of(text), None, 80, 60).camera for text in ("main", "main,fov=90,target=1:0:0"))
    assert np.allclose(usual.eye, wide.eye)
    assert wide.focal[1] == pytest.approx(30.0)
    assert np.allclose(np.cross(wide.forward, [1, -5, -30]), 0.0)
    around = still(scene, view_of("main,azimuth=90,elevation=0,distance=7"), None, 80, 60).camera
    assert np.allclose(around.eye, [7.0, 0.0, 0.0])
    assert still(scene, view_of("lens,fov=90"), None, 80, 60).camera.focal[1] == pytest.approx(30.0)
    assert view_of("top,azimuth=45") == ProgramView("top", parse_viewpoint("top,azimuth=45"), changes={"azimuth": 45.0})
    for text in ("main,fov=200", "main,follow", "mian,fov=30"):
        with pytest.raises(UsageError):
            still(scene, view_of(text), None, 80, 60)


def test_the_api_takes_the_camera_of_the_program() -> None:
    scene = sl.evaluate(
        SCENE + '(camera "main" :eye [3 2 25])(camera "side" :eye [25 2 3])(render-settings :size [40 30])'
    )
    assert scene.placed().eye == pytest.approx([3, 2, 25])
    assert scene.placed("side").eye == pytest.approx([25, 2, 3])
    image = scene.render()
    assert image.camera.eye[2] == pytest.approx(25)
    assert image.pixels.shape[:2] == (30, 40)
    assert scene.render(camera=sl.Camera(azimuth=0), size=(20, 20)).camera.eye[0] == pytest.approx(4)


def program(tmp_path: Path, more: str) -> str:
    path = tmp_path / "a.scene"
    path.write_text(SCENE + more)
    return str(path)


def size_of(path: Path) -> tuple[int, int]:
    with Image.open(path) as image:
        return image.size


def test_options_of_the_command_come_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = program(
        tmp_path, '(camera "main" :eye [3 2 25])(environment "night")(render-settings :size [40 30] :ground "none")'
    )
    out = tmp_path / "a.png"
    assert main(["render", file, "-o", str(out)]) == 0
    assert size_of(out) == (40, 30)
    night = np.asarray(Image.open(out)).mean()
    assert main(["render", file, "-o", str(out), "--size", "20x10", "--environment", "studio"]) == 0
    assert size_of(out) == (20, 10)
    assert np.asarray(Image.open(out)).mean() > 4 * night
    capsys.readouterr()
    assert main(["render", file, "-o", str(out), "--camera", "mian"]) == 2
    assert "did you mean `main`?" in capsys.readouterr().err


@pytest.mark.parametrize("more", ['(environment "nihgt")', '(render-settings :ground "whit")'])
def test_unknown_names_are_reported_where_they_stand(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: str
) -> None:
    file = program(tmp_path, more)
    for command in (["check", file], ["render", file, "-o", str(tmp_path / "a.png")]):
        assert main(command) == 1
        captured = capsys.readouterr()
        assert "did you mean" in captured.out + captured.err
        assert "a.scene:6" in captured.out + captured.err


def test_labels_take_the_camera_of_the_program(tmp_path: Path) -> None:
    file = program(tmp_path, '(camera "main" :eye [3 2 25])(camera "side" :eye [25 2 3])')
    assert main(["labels", file, "-o", str(tmp_path / "one"), "--size", "32x24"]) == 0
    assert main(["labels", file, "-o", str(tmp_path / "two"), "--size", "32x24", "--camera", "side"]) == 0
    for folder, eye in (("one", [3, 2, 25]), ("two", [25, 2, 3])):
        (camera,) = (tmp_path / folder).rglob("camera.json")
        pose = np.array(json.loads(camera.read_text())["world_to_camera"])
        assert -pose[:3, :3].T @ pose[:3, 3] == pytest.approx(eye)


@pytest.mark.parametrize("command", ["labels", "sheet", "render"])
def test_commands_take_the_quality_of_the_program(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[str] = []
    take = film_of_pictures.picture_backend

    def noted(name: str) -> object:
        drawn.append(name)
        return take("draft")

    monkeypatch.setattr(film_of_pictures, "picture_backend", noted)
    file = program(tmp_path, '(render-settings :quality "final")')
    arguments = ["-o", str(tmp_path / ("maps" if command == "labels" else "a.png")), "--size", "16x12"]
    assert main([command, file, *arguments]) == 0
    assert drawn[-1] == "final"
    assert main([command, file, *arguments, "--quality", "draft"]) == 0
    assert drawn[-1] == "draft"


def test_labels_of_another_quality_are_drawn_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    take = film_of_pictures.picture_backend
    monkeypatch.setattr(film_of_pictures, "picture_backend", lambda name: replace(take("draft"), name=name))
    file, folder = program(tmp_path, ""), tmp_path / "maps"
    digests = set()
    for quality in ("draft", "final"):
        assert main(["labels", file, "-o", str(folder), "--size", "16x12", "--quality", quality]) == 0
        (record,) = folder.rglob("shot.json")
        digests.add(json.loads(record.read_text())["digest"])
    assert len(digests) == 2


def radiance(text: str, **more: object) -> np.ndarray:
    options = PictureOptions(width=40, height=30, **more)  # type: ignore[arg-type]
    return np.asarray(sl.evaluate(SCENE + text).render(size=(40, 30), environment=None).radiance if not more
                      else render(sl.evaluate(SCENE + text).graph, options), np.float64)  # fmt: skip


def test_strength_multiplies_the_light_of_an_environment() -> None:
    ground = '(render-settings :ground "seamless")'  # one tone: a darker scene may have another backdrop
    one, half = (radiance(f'{ground}(environment "studio" :strength {x})') for x in (1, 0.5))
    assert np.allclose(half, 0.5 * one, rtol=1e-5)
    assert np.array_equal(one, radiance(ground))


def test_exposure_is_of_the_picture_and_not_of_the_radiance() -> None:
    text = '(camera :eye [3 2 25])(render-settings :size [40 30] :ground "seamless" {})'  # one tone
    plain, dark = (sl.evaluate(SCENE + text.format(more)).render() for more in ("", ":exposure -1"))
    assert np.array_equal(plain.radiance, dark.radiance)
    lit = dark.radiance.max(axis=2) < 0.7  # below the shoulder of the tone curve
    linear = (dark.pixels[:, :, :3][lit] / 255.0 + 0.055) / 1.055
    assert np.median(linear**2.4 / dark.radiance[lit]) == pytest.approx(0.5, abs=0.02)


def test_a_turned_environment_stands_in_the_world() -> None:
    graph = sl.evaluate(SCENE + '(environment "sunny" :turn 60)').graph
    options = settled(graph, PictureOptions())
    directions = []
    for azimuth in (0, 120):
        shot = still(graph, Viewpoint(azimuth=azimuth), None, 20, 20)
        staging = staging_of(graph, [0], 1000, options.environment, options.ground, None, options.lighting)
        directions.append(staging.stage(shot).studio.key_direction)
    assert np.allclose(*directions)
    assert math.degrees(math.atan2(directions[0][0], directions[0][2])) == pytest.approx(0)  # 60 - 60 of "sunny"


def panorama(folder: Path, name: str) -> None:
    """Write a panorama of 4 x 2 pixels, without runs: red above, blue below."""
    pixels = np.array([[[128, 0, 0, 129]] * 4, [[0, 0, 128, 129]] * 4], np.uint8)
    (folder / name).write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n" + pixels.tobytes())


def test_a_panorama_of_the_folder(tmp_path: Path) -> None:
    panorama(tmp_path, "dawn, east.hdr")
    file = program(tmp_path, '(environment "dawn, east.hdr" :strength 2 :turn 90)')
    scene = sl.load(file)
    image = scene.render(size=(16, 16), camera="front")
    bright = 2.0 / 0.2126  # a white surface below red light has the luminance 1
    assert image.radiance[0, 0] == pytest.approx([bright, 0.0, 0.0], abs=0.1)
    assert image.radiance[-1, 0] == pytest.approx([0.0, 0.0, bright], abs=0.1)
    scene.export(tmp_path / "scene.json")
    assert '"dawn, east.hdr"' in (tmp_path / "scene.json").read_text()
    (item,) = sl.load(tmp_path / "scene.json").graph.setup
    assert item.to_plain() == scene.graph.setup[0].to_plain()


@pytest.mark.parametrize(("name", "message"), [
    ("lost.hdr", "lost.hdr"), ("../outside.hdr", "outside"), ("/etc/outside.hdr", "outside"), ("bad.hdr", "not an image"),
])  # fmt: skip
def test_panoramas_that_a_program_may_not_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, message: str
) -> None:
    folder = tmp_path / "project"
    folder.mkdir()
    panorama(tmp_path, "outside.hdr")
    (folder / "bad.hdr").write_bytes(b"nothing")
    file = program(folder, f'(environment "{name}")')
    assert main(["render", file, "-o", str(folder / "a.png"), "--size", "8x8"]) == 1
    told = capsys.readouterr().err
    assert message in told
    assert ".scene:" in told
    assert told.count("error[") == 1


def test_names_of_programs_are_those_of_the_renderers() -> None:
    assert set(setup.ENVIRONMENTS) == {*ENVIRONMENTS, SKY}
    assert set(setup.GROUNDS) == set(GROUNDS)
    assert set(setup.PRESETS) == set(PRESETS)
    assert setup.PANORAMAS == IMAGES


@pytest.mark.parametrize(("form", "message"), [
    ('(environment "studioo")', '`environment` names no environment: "studioo"'),
    ('(render-settings :ground "gras")', '`render-settings` names no ground: "gras"'),
    ('(camera :preset "isometrik")', '`camera` names no preset: "isometrik"'),
])  # fmt: skip
def test_names_are_checked_without_an_image(form: str, message: str) -> None:
    program = f'{form}\n(bind "a" (lambda () (call "cube")))'
    assert [message in d.message for d in sl.check(program).diagnostics if d.is_error] == [True]
    with pytest.raises(sl.SceneError, match=message):
        sl.evaluate(program)


@pytest.mark.parametrize(("line", "message", "place"), [
    ("(define d [0 0 0])(light :direction d)", "got [0 0 0]", 1),
    ('(render-settings :quality "drafft")', "`:quality` of `render-settings`: unknown quality or backend `drafft`", 1),
    ('(light :position [1 2 3] :size 1 :look-at "vasse")', 'names "vasse", which is no word of the scene', 1),
])  # fmt: skip
def test_a_mistake_is_one_diagnostic_with_its_place(
    line: str, message: str, place: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.scene"
    path.write_text(f'{line}\n(bind "a" (lambda () (call "cube")))\n')
    assert main(["render", str(path), "-o", str(tmp_path / "a.png"), "--size", "8x8"]) == 1
    told = capsys.readouterr().err
    assert message in told
    assert f"a.scene:{place}:" in told
    assert told.count("error[") + told.count("warning[") == 1
