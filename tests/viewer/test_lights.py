"""The lights, the environment and the cameras of a program in the page, against drafts."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import scenelang as sl
from scenelang.backends.pictures.camera import Camera, camera_from_json
from scenelang.backends.pictures.film import PictureOptions, render
from scenelang.backends.pictures.stage import unit_size
from scenelang.backends.viewer.packet import packet_of
from scenelang.backends.viewer.start import cameras_of, studio_of

Make = Callable[..., Any]
ONE = (1.0, 1.0, 1.0)
CUBE = '(bind "a" (lambda () (call "cube")))'
LIGHTS = {
    "sun": "(light :direction [-1 -2 -.5] :strength 2 :color [1 .8 .6])",
    "point": "(light :position [1.5 2 .5] :power 60)",
    "sphere": "(light :position [1.5 2.5 .5] :power 90 :radius .4 :color [.6 .8 1])",
    "spot": "(light :position [.5 3 .5] :look-at [2 0 0] :power 300 :angle 70 :blend .6)",
    "area": "(light :position [3 2 1] :look-at [2 0 0] :power 30 :size [1.5 .7])",
    "two": "(light :direction [1 -1 0] :strength 1) (light :position [4 1 0] :power 20)",
    "sky": '(environment "sky" :hour 9 :turn 30) (light :position [1 2 1] :power 20)',
    "studio": '(environment "studio" :strength .5 :turn 120) (render-settings :exposure .7)',
}


def light(program: str) -> dict[str, Any]:
    scene = sl.evaluate(program).graph
    return studio_of(scene, ONE, unit_size(scene))[0]


# --- the packet


def test_lights_put_out_the_key_light_unless_an_environment_is_named() -> None:
    usual, lit, both = light(CUBE), light(LIGHTS["point"] + CUBE), light(f'(environment "studio"){LIGHTS["sun"]}{CUBE}')
    assert usual["lights"] == []
    assert max(usual["key"]) > 0
    assert lit["key"] == [0, 0, 0]
    assert np.allclose(lit["ambient"], 0.1 * np.array(usual["ambient"]))
    assert both["key"] == usual["key"]
    assert [lamp["kind"] for lamp in lit["lights"] + both["lights"]] == ["point", "sun"]


def test_lights_are_in_the_frame_of_the_stage() -> None:
    (lamp,) = light(f"(light :position [1 4 2] :power 100 :radius .5){CUBE}")["lights"]
    scale = 2 / 3**0.5
    assert np.allclose(lamp["position"], np.array([1, 4, 2]) * scale)
    assert np.allclose(lamp["flux"], 100 * scale**2)
    assert lamp["radius"] == pytest.approx(0.5 * scale)


def test_an_environment_and_settings_of_the_program() -> None:
    sunset = light(f'(environment "sunset" :turn 40) (render-settings :ground "checker" :exposure 1){CUBE}')
    assert sunset["isFixed"]
    assert sunset["keyTurn"] == pytest.approx(np.radians(40 - 65))
    assert sunset["backdrop"] is None
    assert sunset["exposure"] == 2
    assert sunset["ground"][0] != sunset["ground"][1]
    assert light(f'(environment "flat"){CUBE}')["isUnlit"]
    assert light(f'(environment "flat"){LIGHTS["point"]}{CUBE}')["lights"] == []


def test_a_sky_travels_as_a_panorama_and_a_gradient_does_not() -> None:
    def columns(program: str) -> dict[str, Any]:
        packet = packet_of(sl.evaluate(program).graph)
        (length,) = struct.unpack("<I", packet[4:8])
        return dict(json.loads(packet[8 : 8 + length])["columns"])

    assert columns(f'(environment "sky" :hour 9){CUBE}')["panorama"][2] == 64 * 128 * 3
    assert "panorama" not in columns(f'(environment "sunset"){CUBE}')


def test_a_light_that_looks_at_nothing_leaves_the_usual_light() -> None:
    assert light(f'(light :position [1 2 3] :look-at "nobody"){CUBE}') == light(CUBE)


MOVING = """(camera "still" :azimuth 10)
(camera "along" :eye (list [0 1 5] [4 1 5]) :look-at [0 0 0])
(camera "after" :eye [0 3 8] :look-at "ball")
(bind "ball" (lambda () (call "sphere" :radius .3)))
(bind "film" (lambda () (frames (for/list ((i 5)) (union (call "cube")
  (transform (call "ball") (translate (list i 1 0))))))))
"""


def test_cameras_move_over_the_frames() -> None:
    still, along, after = cameras_of(sl.evaluate(MOVING).graph)
    assert [len(camera["poses"]) for camera in (still, along, after)] == [1, 5, 5]
    assert along["poses"][0]["azimuth"] == pytest.approx(0)
    assert along["poses"][4]["azimuth"] == pytest.approx(np.degrees(np.arctan2(4, 5)))
    assert after["poses"][4]["azimuth"] == pytest.approx(np.degrees(np.arctan2(-4, 8)))


# --- the page

SAMPLES = """async (most) => { const { stage, viewpoint } = scenelangPage; scenelangPage.refine = async () => {};
  stage.draw(viewpoint, false);
  while (stage.samples < most) { stage.addSample(viewpoint); await stage.finished(20000); } }"""
CAMERA = "([w, h]) => scenelangPage.viewpoint.json(scenelangPage.packet.box, w, h)"


def compared(page: Any, scene: Any, samples: int) -> tuple[Any, Any, Camera]:
    """What the page shows, the draft by its camera (H, W, 3), and that camera."""
    page.page.evaluate(SAMPLES, samples)
    picture = page.picture().astype(int)
    height, width = picture.shape[:2]
    camera = camera_from_json(page.page.evaluate(CAMERA, [width, height]))
    drawn = render(scene, PictureOptions(width=width, height=height, camera=camera, labels=False))
    return picture, np.asarray(drawn).astype(int), camera


def at(camera: Camera, point: list[float]) -> tuple[int, int]:
    ((x, y),), _ = camera.project(np.array([point]))
    return int(y), int(x)


@pytest.mark.browser
@pytest.mark.parametrize("samples", [0, pytest.param(32, marks=pytest.mark.slow)])
def test_flat_patches_have_the_colors_of_drafts_in_every_light(
    program: Make, serve: Make, show: Make, samples: int
) -> None:
    looks = ["[1 1 1]", "[.5 .1 .05]", "[.05 .3 .9]", "[.2 .2 .2]", "[.8 .8 .8] :coat 1 :roughness .5"]
    looks += ["[.7 .2 .1] :sheen 1", "[.6 .6 .6] :metallic 1 :coat .6"]
    patches = "\n".join(
        f'(transform (call "cube" :scale [1 .01 1] :color {look}) (translate [{i} 0 0]))'
        for i, look in enumerate(looks)
    )
    body = f'(camera :azimuth 20 :elevation 60)\n(bind "patches" (lambda () (union {patches})))'
    paths = [program(f"{lights}\n{body}", f"{name}.scene") for name, lights in LIGHTS.items()]
    page = show(serve(*paths).address, (560, 260)).ready()
    for number, path in enumerate(paths):
        page.page.evaluate("async (number) => { await scenelangPage.choose(number); }", number)
        picture, drawn, camera = compared(page, sl.load(path).graph, samples)
        for i, look in enumerate(looks):
            for dx in (-0.3, 0, 0.3):
                pixel = at(camera, [i + dx, 0.005, 0.2])
                assert np.abs(picture[pixel] - drawn[pixel]).max() <= 3, (path.stem, look, dx)


TABLE = """(camera :azimuth 20 :elevation 40)
(bind "table" (lambda () (union (transform (call "cube" :scale [4 .2 3] :color [.8 .8 .8]) (translate [2 -.1 0]))
  (transform (call "cube" :scale .5 :color [.7 .3 .1]) (translate [1.5 .5 .3]))
  (transform (call "sphere" :radius .3 :color [.9 .7 .3] :metallic 1 :roughness .3) (translate [2.8 .6 .2])))))
"""


@pytest.mark.browser
@pytest.mark.parametrize("samples", [0, pytest.param(32, marks=pytest.mark.slow)])
def test_shadows_and_highlights_are_those_of_drafts(program: Make, serve: Make, show: Make, samples: int) -> None:
    kinds = ["sun", "point", "sphere", "spot", "area"]
    paths = [program(f"{LIGHTS[kind]}\n{TABLE}", f"{kind}.scene") for kind in kinds]
    dark = sl.evaluate(f"(light :direction [0 1 0])\n{TABLE}").graph
    page = show(serve(*paths).address, (440, 300)).ready()
    for number, path in enumerate(paths):
        page.page.evaluate("async (number) => { await scenelangPage.choose(number); }", number)
        picture, drawn, camera = compared(page, sl.load(path).graph, samples)
        away = np.abs(picture - drawn).max(axis=2)
        height, width = away.shape
        ambient = np.asarray(render(dark, PictureOptions(width=width, height=height, camera=camera, labels=False)))
        lit = [image.sum(axis=2) > ambient.sum(axis=2, dtype=int) + 60 for image in (picture, drawn)]
        assert 0.1 < lit[1].mean() < 0.98, f"some of it is lit by the {path.stem}, and some is not"
        assert (lit[0] != lit[1]).mean() < 0.02, path.stem
        assert np.median(away) <= 3, path.stem
        assert (away > 25).mean() < 0.02, path.stem


@pytest.mark.browser
def test_cameras_of_the_program_are_views_and_shadows_follow_the_frames(program: Make, serve: Make, show: Make) -> None:
    path = program(f"(light :direction [0 -1 0] :strength 3)\n{MOVING}")
    page = show(serve(path).address, (560, 360)).ready()
    names = page.page.locator("#program-cameras option").all_text_contents()
    assert names == ["still", "along", "after"]
    page.page.locator("#view").select_option(label="along")
    page.page.evaluate("() => scenelangPage.timeline.go(4)")
    scene = sl.load(path).graph
    found = camera_from_json(page.page.evaluate(CAMERA, [560, 360]))
    assert np.allclose(found.eye, [4, 1, 5], atol=1e-3)
    page.page.locator("#view").select_option(label="after")
    dark = []
    for frame in (0, 2):
        page.page.evaluate("(frame) => scenelangPage.timeline.go(frame)", frame)
        picture, _, camera = compared(page, scene, 0)
        spots = [picture[at(camera, [x, -0.5, 0.1])].sum() for x in (2.0, 3.0)]
        dark.append(spots[0] < 0.6 * spots[1])
    assert dark == [False, True], "the ball's shadow is below it"
    page.page.keyboard.press("f")
    before = page.page.evaluate("() => scenelangPage.viewpoint.azimuth")
    page.page.evaluate("() => scenelangPage.timeline.go(4)")
    assert page.page.evaluate("() => scenelangPage.viewpoint.azimuth") == before, "a view of one's own stays"


@pytest.mark.browser
def test_the_ground_reaches_a_low_camera_and_the_horizon(program: Make, serve: Make, show: Make) -> None:
    path = program(f'(environment "sunset") (camera :eye [3 .3 5] :look-at [0 0 0])\n{CUBE}')
    picture, drawn, _ = compared(show(serve(path).address, (440, 300)).ready(), sl.load(path).graph, 0)
    for row in (2, *range(20, len(drawn), 20), len(drawn) - 2):
        column = 3
        assert np.abs(picture[row, column] - drawn[row, column]).max() <= 8, row
    assert np.ptp(drawn[:, 3].sum(axis=1)) > 100, "there is a sky and a ground"


@pytest.mark.browser
def test_metal_mirrors_the_ground_that_lamps_light(program: Make, serve: Make, show: Make) -> None:
    path = program(
        '(environment "studio" :strength 0)(light :position [4 3 4] :power 300)(camera :azimuth 10 :elevation 12)\n'
        '(bind "a" (lambda () (call "sphere" :metallic 1 :roughness .2)))'
    )
    picture, drawn, camera = compared(show(serve(path).address, (300, 240)).ready(), sl.load(path).graph, 0)
    pixel = at(camera, [0.1, -0.6, 0.75])
    assert drawn[pixel].max() > 60
    assert np.abs(picture[pixel] - drawn[pixel]).max() <= 12
