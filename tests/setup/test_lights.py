"""Lights of a program in draft and final images: their irradiance against closed forms, shadows, and environment."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import scenelang as sl
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.film import PictureOptions
from scenelang.backends.pictures.stage import film, staging_of
from scenelang.backends.pictures.surroundings import settled
from scenelang.backends.surfaces.lights import Light, lights_of
from scenelang.grammar.diagnostics import SceneError

PLANE = """
(bind "plane" (lambda () (transform (call "cube" :scale [8 .1 8] :color [1 1 1]) (translate [0 -.05 0]))))
(bind "block" (lambda () (transform (call "cube" :scale [.6 .1 .6] :color [1 1 1]) (translate [0 1 0]))))
"""
QUALITIES = ("draft", "final")
DARK = '(environment "studio" :strength 0)(render-settings :ground "none")'


def radiance(
    lights: str, look: str = "[0 0 0]", quality: str = "draft", word: str = "plane", side: int = 16
) -> np.ndarray:
    """The mean radiance (3,) in the middle of the image of a point on the plane, seen from the side."""
    text = f'{PLANE}(bind "all" (lambda () {word}))(scene "all"){DARK}{lights}'
    text += f"(camera :eye (+ {look} [3 5 6]) :look-at {look} :fov 1)"
    settings = {"samples": 64, "denoise": "off"} if quality == "final" else {}
    image = sl.evaluate(text).render(size=(side, side), quality=quality, settings=settings)
    return np.asarray(image.radiance, np.float64).mean(axis=(0, 1))


PLAIN = '(call "plane")'


def point(power: float, height: float, x: float) -> float:
    """The irradiance of a plane at a distance x from the foot of a point at a height: P cos / 4 pi d^2."""
    return power * height / (4 * math.pi * math.hypot(height, x) ** 3)


def disk_from_rectangle(power: float, side: float, height: float, x: float) -> float:
    """The irradiance of a plane by a square above it that shines down, by integration in fine steps."""
    steps = (np.arange(400) + 0.5) / 400 * side - side / 2
    a, b = np.meshgrid(steps, steps)
    square = (a - x) ** 2 + b**2 + height**2
    return float(power / (math.pi * side**2) * (height**2 / square**2).mean() * side**2)


CASES = [
    ("(light :position [0 2 0] :power 100)", 0.0, point(100, 2, 0)),
    ("(light :position [0 2 0] :power 100)", 2.0, point(100, 2, 2)),
    ("(light :position [0 2 0] :power 100 :radius .3)", 1.0, point(100, 2, 1)),
    ("(light :position [0 2 0] :power 100 :angle 60)", 0.5, point(100, 2, 0.5)),
    ("(light :position [0 2 0] :power 100 :angle 60 :blend .4)", 0.5, point(100, 2, 0.5)),
    ("(light :position [0 2 0] :power 100 :angle 40)", 1.0, 0.0),
    ("(light :position [0 2 0] :power 100 :size [1 1])", 0.0, disk_from_rectangle(100, 1, 2, 0)),
    ("(light :position [0 2 0] :power 100 :size 1)", 1.5, disk_from_rectangle(100, 1, 2, 1.5)),
    ("(light :direction [0 -1 0] :strength 2)", 1.0, 2.0),
    ("(light :direction [1 -1 0] :strength 2 :angle 4)", 1.0, 2.0 * math.sqrt(0.5)),
]  # fmt: skip


@pytest.mark.parametrize(("lights", "x", "irradiance"), CASES)
def test_irradiance_of_a_plane_in_drafts(lights: str, x: float, irradiance: float) -> None:
    expected = irradiance / math.pi
    assert radiance(lights, f"[{x} 0 0]", word=PLAIN) == pytest.approx(expected, rel=0.03, abs=1e-6)


@pytest.mark.parametrize(("lights", "x", "irradiance"), CASES)
def test_irradiance_of_a_plane_in_final_images(lights: str, x: float, irradiance: float) -> None:
    pytest.importorskip("mitsuba")
    expected = irradiance / math.pi
    assert radiance(lights, f"[{x} 0 0]", "final", PLAIN) == pytest.approx(expected, rel=0.03, abs=1e-4)


def test_a_spot_fades_the_same_in_both() -> None:
    pytest.importorskip("mitsuba")
    lights = "(light :position [0 2 0] :power 100 :angle 60 :blend .5)"
    angle = math.degrees(math.atan(0.8 / 2))
    expected = point(100, 2, 0.8) / math.pi * (30 - angle) / 15
    for quality in ("draft", "final"):
        assert radiance(lights, "[.8 0 0]", quality, PLAIN)[0] == pytest.approx(expected, rel=0.03)


def test_colors_and_several_lights_add() -> None:
    lights = '(light :position [0 2 0] :power 100 :color [1 .5 0])(light :position [0 2 0] :power 50 :color "#00f")'
    unit = point(100, 2, 0) / math.pi
    assert radiance(lights, word=PLAIN) == pytest.approx([unit, unit / 2, unit / 2], rel=0.03)


@pytest.mark.parametrize("light", ["(light :position [0 3 0] :power 100)", "(light :direction [0 -1 0])",
                                   "(light :position [0 3 0] :angle 90 :power 100)",
                                   "(light :position [0 3 0] :power 100 :size .1)",
                                   "(light :position [0 3 0] :power 100 :radius .1)"])  # fmt: skip
def test_a_block_throws_a_shadow(light: str) -> None:
    both = '(union (call "plane") (call "block"))'
    assert radiance(light, "[0 0 0]", word=both).max() < 0.01  # the plane under the block, which is [-.3, .3] at y = 1
    assert radiance(light, "[1.5 0 0]", word=both) == pytest.approx(radiance(light, "[1.5 0 0]", word=PLAIN), rel=0.03)


def test_no_light_leaves_a_closed_solid() -> None:
    can = '(call "cylinder" :radius 1 :p0 [0 0 0] :p1 [0 2 0])'
    for below in ('(render-settings :ground "white")', '(render-settings :ground "none")'):
        for lamp in ("(light :position [0 1 0] :power 300)", "(light :position [.5 .3 0] :power 300 :radius .1)"):
            text = (
                f'{PLANE}(bind "all" (lambda () (union {can} {PLAIN if "none" in below else ""})))(scene "all"){lamp}'
            )
            text += f'(environment "studio" :strength 0){below}(camera :azimuth 30 :elevation 25)'
            assert sl.evaluate(text).render(size=(64, 64)).radiance.max() < 1e-6
    text = f'(bind "all" (lambda () {can}))(light :position [0 1 0] :power 300)(camera :eye [.5 1 0] :look-at [-1 1 0])'
    assert sl.evaluate(text).render(size=(16, 16)).radiance.min() > 0.1  # the inside is lit


def test_penumbras_are_those_of_final_images() -> None:
    pytest.importorskip("mitsuba")
    both = '(union (call "plane") (call "block"))'
    light = "(light :position [0 3 0] :power 100 :radius .3)"
    shares = []
    for quality in ("draft", "final"):
        row = [radiance(light, f"[{x} 0 0]", quality, both)[0] / radiance(light, f"[{x} 0 0]", quality, PLAIN)[0]
               for x in (0.2, 0.35, 0.45, 0.55, 0.8)]  # fmt: skip
        shares.append(row)
    assert shares[1][0] < 0.2 < 0.9 < shares[1][-1]
    assert shares[0] == pytest.approx(shares[1], abs=0.12)


def test_power_is_chosen_so_that_white_is_white() -> None:
    # The default power makes a white surface that faces the lamp white at the center of the scene, here (0 -.05 0).
    assert radiance("(light :position [0 2 0])", word=PLAIN)[0] == pytest.approx((2.05 / 2) ** 2, rel=0.03)
    assert radiance("(light :direction [0 -1 0])", word=PLAIN)[0] == pytest.approx(1.0, rel=0.03)


def test_lights_put_out_the_key_light() -> None:
    scene = f'{PLANE}(bind "all" (lambda () {PLAIN}))(scene "all")'
    for more, has_key, strength in (
        ("(light :position [0 2 0])", False, 0.1),
        ('(light :position [0 2 0])(environment "sunny")', True, 1.0),
        ("(render-settings :exposure 1)", True, 1.0),
    ):
        lighting = settled(sl.evaluate(scene + more).graph, PictureOptions()).lighting
        assert lighting is not None
        assert (lighting.has_key, lighting.strength) == (has_key, strength)
    options = PictureOptions(environment="sunny", stated=("environment",))
    lighting = settled(sl.evaluate(scene + "(light :position [0 2 0])").graph, options).lighting
    assert lighting is not None
    assert lighting.has_key


def test_a_light_of_a_size_is_seen_in_both() -> None:
    pytest.importorskip("mitsuba")
    text = f'{PLANE}(bind "all" (lambda () {PLAIN}))(scene "all"){DARK}'
    text += "(light :position [0 2 0] :radius .5 :power 20)(camera :eye [0 2 6] :look-at [0 2 0] :fov 20)"
    expected = 20 / (4 * math.pi**2 * 0.25)
    for quality in ("draft", "final"):
        image = np.asarray(sl.evaluate(text).render(size=(16, 16), quality=quality).radiance)
        assert image[8, 8] == pytest.approx(expected, rel=0.02)
        assert image[0, 0] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(("roughness", "tolerance"), [(0.1, 0.2), (0.5, 0.3)])
def test_metal_mirrors_the_ground_that_a_lamp_lights(roughness: float, tolerance: float) -> None:
    pytest.importorskip("mitsuba")
    text = f"""(bind "all" (lambda () (call "sphere" :radius 1 :metallic 1 :roughness {roughness})))(scene "all")
    (environment "studio" :strength 0)(render-settings :ground "white")
    (light :position [4 3 4] :power 300)(camera :eye [0 0 8] :look-at [.2 -.5 0] :fov 1)"""
    draft, final = (
        np.asarray(sl.evaluate(text).render(size=(8, 8), quality=quality).radiance).mean() for quality in QUALITIES
    )
    assert draft == pytest.approx(final, rel=tolerance)


def test_words_that_a_light_shines_at() -> None:
    text = f'{PLANE}(bind "all" (lambda () (union (call "plane") (call "block"))))(scene "all")'
    (light,) = lights_of(sl.evaluate(text + '(light :position [0 3 0] :angle 30 :look-at "block")').graph)
    assert light.direction == pytest.approx((0, -1, 0))
    assert light.kind == "spot"
    with pytest.raises(SceneError, match='looks at "blick"'):
        lights_of(sl.evaluate(text + '(light :position [0 3 0] :size 1 :look-at (string-append "bl" "ick"))').graph)
    with pytest.raises(SceneError, match="at the point"):
        lights_of(sl.evaluate(text + "(light :position [0 3 0] :angle 30 :look-at [0 3 0])").graph)


def test_many_lights_and_odd_places_are_drawn() -> None:
    lights = "".join(f"(light :position [{x} {y} 0] :power 1)" for x in (-1, 0, 1) for y in (-9, 0, 0.001, 1e6))
    assert np.isfinite(radiance(lights + "(light :direction [0 1 0] :angle 179)", side=8, word=PLAIN)).all()


def test_exported_scenes_of_mitsuba_have_the_camera_and_lights(tmp_path: Path) -> None:
    mi = pytest.importorskip("mitsuba")
    text = f"""{PLANE}(bind "all" (lambda () (union (call "plane") (call "block"))))(scene "all"){DARK}
    (camera "main" :eye [3 5 6] :look-at "block" :fov 50)
    (light :position [2 2 0] :power 100)(light :position [-2 3 0] :angle 60 :power 90 :blend .2)
    (light :position [0 3 2] :size [1 2] :look-at [0 0 0] :power 80)(light :position [1 2 2] :radius .2 :power 30)
    (light :direction [0 -1 -1] :strength .3)(light :direction [1 -1 0] :angle 0 :strength .2)
    (render-settings :size [32 24])"""
    text = text.replace('(render-settings :ground "none")', "").replace(":size [32 24]", ':size [32 24] :ground "none"')
    scene = sl.evaluate(text)
    scene.export(tmp_path / "a.xml")
    mi.set_variant("scalar_rgb")
    exported = np.array(mi.render(mi.load_file(str(tmp_path / "a.xml")), spp=128))
    drawn = scene.render(quality="final", settings={"samples": 128, "denoise": "off"}).radiance
    assert exported.shape == drawn.shape == (24, 32, 3)
    assert exported.mean() == pytest.approx(float(np.mean(drawn)), rel=0.03)
    assert np.median(np.abs(exported - drawn)) < 0.03 * float(np.mean(drawn))


MOVING = """
(bind "ball" (lambda () (call "sphere" :radius .5)))
(bind "film" (lambda () (frames (for/list ((x (list 0 1 2 3 4)))
  (union (call "cube") (transform (call "ball") (translate [x 2 0])))))))
(scene "film")
"""


def lights_of_shots(text: str, frames: int | None = None) -> list[list[Light]]:
    """The lights of the images of a video, in the world."""
    graph = sl.evaluate(text).graph
    options = settled(graph, PictureOptions())
    shots = film(graph, Viewpoint(), 20, 20, frames, None)
    numbers = [shot.frame for shot in shots]
    staging = staging_of(graph, numbers, 100, lighting=options.lighting)
    back = -staging.center * staging.scale
    return [[one.scaled(back, 1.0 / staging.scale) for one in staging.stage(shot).lights] for shot in shots]


def test_lights_over_the_frames() -> None:
    moving = "(light :position (list [0 3 0] [4 3 0] [4 3 8]) :power (list 100 0))(light :direction [0 -1 0])"
    every = lights_of_shots(MOVING + moving)
    places = [(0, 3, 0), (2, 3, 0), (4, 3, 0), (4, 3, 4), (4, 3, 8)]
    assert np.array([one.position for one, _ in every]) == pytest.approx(np.array(places))
    assert [one.power for one, _ in every] == pytest.approx([100, 75, 50, 25, 0])
    assert len({sun for _, sun in every}) == 1
    still = f'(bind "a" (lambda () {PLAIN})){PLANE}(scene "a")'
    every = lights_of_shots(still + "(light :direction (list [1 -1 0] [-1 -1 0]))", 3)
    assert [one.direction for (one,) in every][1] == pytest.approx((0, -1, 0))


def test_a_light_follows_what_it_looks_at() -> None:
    every = lights_of_shots(MOVING + '(light :position [2 6 0] :angle 20 :look-at "ball")')
    for x, (one,) in enumerate(every):
        assert np.cross(one.direction, [x - 2, -4, 0]) == pytest.approx([0, 0, 0], abs=1e-9)


def test_a_moving_light_is_drawn_at_its_frame() -> None:
    text = MOVING + '(light :position (list [-3 0 3] [3 0 3]) :power 100)(environment "studio" :strength 0)'
    scene = sl.evaluate(text + '(render-settings :ground "none")(camera :eye [0 0 9] :look-at [0 0 0] :fov 8)')
    first, last = (scene.render(size=(16, 16), frame=k).radiance for k in (0, 4))
    assert first[:, :8].mean() > 1.01 * first[:, 8:].mean()
    assert last[:, 8:].mean() > 1.01 * last[:, :8].mean()


def test_the_rim_of_fabric_is_lit_by_lamps_in_drafts_as_in_final_images() -> None:
    """The upper edge of a velvet ball before a lamp; without the rim a draft has less than half of the radiance."""
    pytest.importorskip("mitsuba")
    text = f"""(bind "all" (lambda () (call "sphere" :radius 1 :material "velvet" :color (color "teal"))))(scene "all"){DARK}
    (light :position [0 5 -2] :power 300)(camera :eye [0 0 8] :look-at [0 .85 0] :fov 1)"""
    draft, final = (
        np.asarray(sl.evaluate(text).render(size=(8, 8), quality=quality).radiance).mean() for quality in QUALITIES
    )
    assert draft == pytest.approx(final, rel=0.1)
