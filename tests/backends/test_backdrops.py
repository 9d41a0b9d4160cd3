"""The tone of the backdrop shows the outline of what is before it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sampling import only
from silhouettes import EXAMPLES, loaded, outline_contrast

import scenelang as sl
from scenelang.backends.pictures.backdrops import backdrops, clearest, lightness
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.draft import toned
from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend
from scenelang.backends.pictures.stage import staging_of, still
from scenelang.backends.surfaces.environments import ENVIRONMENTS, FADED, faded
from scenelang.backends.surfaces.image_files import encode, from_srgb

CURRENT = ENVIRONMENTS["studio"].backdrop


def test_lightness_is_that_of_cie() -> None:
    assert lightness(np.array([[0.0, 0.0, 0.0], [0.18418651851244416] * 3, [1.0, 1.0, 1.0]])) == pytest.approx(
        [0.0, 50.0, 100.0], abs=1e-3
    )


@pytest.mark.parametrize("gray", [0.001, 0.02, 0.1, 0.3, 0.6, 0.9])
def test_the_chosen_tone_differs_from_the_scene(gray: float) -> None:
    own = lightness(np.full((9, 3), gray))
    tones = [lightness(np.array([tone] * 9)) for tone in backdrops(CURRENT)]
    chosen = clearest((own, tone) for tone in tones)
    assert abs(tones[chosen][0] - own[0]) >= 20.0
    assert all(abs(tone[0] - own[0]) < 22.0 for tone in tones[:chosen])


def test_the_clearest_tone_is_taken_where_none_is_clear() -> None:
    assert clearest((np.zeros(3), np.full(3, light)) for light in (3.0, 7.0, 5.0)) == 1


def test_a_tone_is_not_clear_where_much_of_the_outline_is_faint() -> None:
    """Half of the sides of a board of light and dark squares are clear before the first tone, and the median with them;
    before the second, all of the outline is."""
    own = np.repeat((80.0, 30.0), (45, 55))
    assert clearest((own, np.full(100, light)) for light in (68.0, 5.0)) == 1


def test_the_first_tone_is_that_of_the_environment() -> None:
    assert backdrops((0.1, 0.2, 0.3))[0] == pytest.approx((0.1, 0.2, 0.3))


# The camera of these is inside the scene, or is the program's own.
ENCLOSING = {"dolly", "still-life"}
PROGRAMS = {path.stem: path for path in sorted(EXAMPLES.rglob("*.scene")) if path.stem not in ENCLOSING}
GLOSSY = {"mug", "vase", "bottle"}  # whose rims are as bright as a light backdrop


@pytest.mark.parametrize("name", only(GLOSSY, PROGRAMS))
def test_outlines_of_examples_are_visible(name: str) -> None:
    assert outline_contrast(loaded(PROGRAMS[name]), PictureOptions(width=640, height=480)) >= 20.0


TRANSLATED = Path(__file__).parents[1] / "transpile" / "scenes"


@pytest.mark.parametrize(
    "path", [EXAMPLES / "paper" / "chessboard.scene", TRANSLATED / "solar-system-dict-of-parameters.scene"]
)
def test_outlines_are_visible_in_final_images(path: Path) -> None:
    """Half of the outline of a board of light and dark squares was faint, and the lines of orbits cover half of their
    pixels: 17 each."""
    pytest.importorskip("mitsuba")
    options = PictureOptions(width=640, height=480, labels=False, settings={"samples": 4})
    assert outline_contrast(loaded(path), options) >= 20.0


@pytest.mark.parametrize("name", ["mug", "chair"])
def test_small_images_have_the_tone_of_large_ones(name: str) -> None:
    graph = loaded(PROGRAMS[name])
    tones = set()
    for size in ((64, 48), (160, 120), (640, 480)):
        staging = staging_of(graph, [0], 1_000_000)
        tones.add(toned(staging, still(graph, Viewpoint(), None, *size)).backdrop)
    assert len(tones) == 1


def test_a_scene_that_fills_the_picture_keeps_the_tone(make: Any) -> None:
    wall = make.scene(make.primitive("cube", color=(1, 1, 1)))
    options = PictureOptions(width=64, height=48, camera=Viewpoint(0, 0, distance=0.7))
    staging = staging_of(wall, [0], 10)
    assert toned(staging, still(wall, options.camera, None, 64, 48)).backdrop == CURRENT


@pytest.mark.parametrize("strength", [0.2, 0.5])
@pytest.mark.parametrize("gray", [0.05, 0.4, 0.9])
def test_a_weak_studio_has_no_horizon(make: Any, strength: float, gray: float) -> None:
    """The tone is a share of the backdrop's own light, which the ground can reflect."""
    ball = make.scene(make.primitive("sphere", color=(gray, gray, gray)))
    options = PictureOptions(
        width=64, height=48, environment=f"studio,strength={strength}", camera=Viewpoint(elevation=2, distance=12)
    )
    picture = draw(ball, options, picture_backend("draft")).picture.astype(int)
    assert np.abs(np.diff(picture[:, :6], 2, axis=0)).max() <= 8  # the light falls off smoothly; a line is a jump


@pytest.mark.parametrize("quality", ["draft", "final"])
def test_outlines_are_visible_whatever_the_color(make: Any, quality: str) -> None:
    """Two pixels inside the outline and two outside differ by 20 of CIE's L* or more."""
    for gray in (0.03, 0.35, 0.62, 0.95):
        ball = make.scene(make.primitive("sphere", color=(gray, gray, gray)))
        camera = Viewpoint(0.0, 15.0, distance=3.6)
        options = PictureOptions(
            width=120, height=120, camera=camera, settings={} if quality == "draft" else {"samples": 16}
        )
        picture = draw(ball, options, picture_backend(quality)).picture
        light = lightness(from_srgb(picture / 255.0))
        row = light[60]
        edge = int(np.argmax(np.abs(np.diff(row[:60]))))
        assert abs(row[edge + 3] - row[edge - 2]) >= 20.0


def test_a_ground_that_is_asked_for_stays(make: Any) -> None:
    ball = make.scene(make.primitive("sphere", color=(0.9, 0.9, 0.9)))
    options = PictureOptions(width=64, height=48, ground="seamless", camera=Viewpoint(elevation=8, distance=30))
    picture = draw(ball, options, picture_backend("draft")).picture
    assert np.abs(picture[0, 0].astype(int) - encode(FADED * np.array(CURRENT))).max() <= 1


@pytest.mark.parametrize("quality", ["draft", "final"])
def test_the_light_on_a_seamless_ground_falls_off(make: Any, quality: str) -> None:
    """Seen from above beside a small ball, the ground has the share of its light by the distance from the scene."""
    ball = make.scene(make.primitive("sphere", radius=1.0))
    camera = Viewpoint(elevation=90, distance=60, fov=50)
    options = PictureOptions(
        width=121, height=121, camera=camera, ground="seamless", settings={} if quality == "draft" else {"samples": 16}
    )
    radiance = draw(ball, options, picture_backend(quality)).radiance[60, 80:, 0]
    across = (np.arange(80, 121) - 60.0) / 60.5 * np.tan(np.radians(25)) * 61.0  # the ground is 61 below the camera
    assert CURRENT is not None
    assert radiance == pytest.approx(CURRENT[0] * faded(across / np.sqrt(3.0)), rel=0.04)


def test_objects_before_the_faded_ground_keep_their_colors(make: Any) -> None:
    """Final images are darkened behind the objects alone, their edges included."""
    plate = make.scene(make.primitive("cube", scale=(1, 1, 0.02), color=(0.6, 0.5, 0.4)))
    options = PictureOptions(width=64, height=64, camera=Viewpoint(0, 20, distance=3), settings={"samples": 16})
    final = draw(plate, options, picture_backend("final")).picture.astype(int)
    draft = draw(plate, replace(options, settings={}), picture_backend("draft")).picture.astype(int)
    assert np.abs(final - draft).mean() < 4.0


def test_the_colors_of_the_scene_stay(make: Any) -> None:
    """The tone of the backdrop changes the light of a surface that faces upwards by no level."""
    plate = make.scene(make.primitive("cube", scale=(1, 0.02, 1), color=(0.6, 0.5, 0.4)))
    pictures = [
        draw(
            plate,
            PictureOptions(width=64, height=64, camera=Viewpoint(0, 89, distance=1.2), ground=ground),
            picture_backend("draft"),
        )
        for ground in (None, "seamless")
    ]
    middles = [picture.picture[28:36, 28:36].astype(int) for picture in pictures]
    assert np.abs(middles[0] - middles[1]).max() <= 1


@pytest.mark.parametrize("elevation", [2.0, 30.0])
def test_final_images_do_not_show_the_lights_of_the_studio(make: Any, elevation: float) -> None:
    """Behind the objects is the smooth backdrop, whatever the dome has there: no edges of softboxes."""
    pytest.importorskip("mitsuba")
    ball = make.scene(make.primitive("sphere", color=(0.9, 0.9, 0.9)))
    camera = Viewpoint(40.0, elevation, distance=8, fov=80)
    options = PictureOptions(width=96, height=72, camera=camera, settings={"samples": 4, "denoise": "off"})
    above = draw(ball, options, picture_backend("final")).picture[:12].astype(int)
    assert np.abs(np.diff(above, axis=1)).max() <= 2


@pytest.mark.parametrize("quality", ["draft", "final"])
def test_a_lamp_without_the_key_light_leaves_no_horizon(quality: str) -> None:
    scene = sl.evaluate('(bind "a" (lambda () (call "cube"))) (light "lamp" :position [1 3 2] :power 1e-6)').graph
    settings = {} if quality == "draft" else {"samples": 64}
    camera = Viewpoint(0.0, 4.0, distance=10)
    image = draw(scene, PictureOptions(width=64, height=96, camera=camera, settings=settings), picture_backend(quality))
    column = image.radiance[:60, :8].mean(axis=(1, 2))
    assert np.abs(np.diff(column, 2)).max() < 0.12 * column.max()


def test_glass_lets_a_background_through_in_final_images() -> None:
    pytest.importorskip("mitsuba")
    scene = sl.evaluate('(bind "a" (lambda () (call "sphere" :material "glass")))').graph
    options = PictureOptions(width=48, height=48, ground="none", background="white", settings={"samples": 32})
    picture = draw(scene, options, picture_backend("final")).picture
    assert picture[20:28, 20:28].mean() > 200


@pytest.mark.parametrize("quality", ["draft", "final"])
def test_what_glows_is_seen_before_the_ground_that_it_lights(quality: str) -> None:
    """In final images it makes a light ground as white as itself: the outline of this ball was 11 there."""
    ball = sl.evaluate('(bind "lamp" (lambda () (call "sphere" :emission [5 4 3])))').graph
    settings = {"samples": 8} if quality == "final" else {}
    assert outline_contrast(ball, PictureOptions(width=160, height=120, settings=settings)) >= 20.0
