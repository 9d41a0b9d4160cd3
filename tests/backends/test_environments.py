"""Environments by name, by the hour and from files, and tone curves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend
from scenelang.backends.surfaces.daylight import daylight
from scenelang.backends.surfaces.dome import Dome, Panorama, directions_of, solid_angles
from scenelang.backends.surfaces.environments import agx, clipped, environment_of, studio_for, tone
from scenelang.backends.surfaces.image_files import encode
from scenelang.backends.surfaces.panoramas import LUMINANCE, panorama_from, radiance_image, without_sun
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError

UP = np.array([[0.0, 1.0, 0.0]])
RIGHT = np.array([1.0, 0.0, 0.0])


def gradient(height: int = 32) -> np.ndarray:
    """Return an image that is different in every pixel and color."""
    row, column = np.mgrid[0:height, 0 : 2 * height]
    return np.stack([0.1 + row / height, 0.2 + column / height, 0.3 + row * column / height**2], axis=2)


@pytest.mark.parametrize("ending", [".hdr", ".exr"])
def test_images_are_read_as_mitsuba_wrote_them(tmp_path: Path, ending: str) -> None:
    mi = pytest.importorskip("mitsuba")
    image = gradient()
    path = tmp_path / f"sky{ending}"
    mi.Bitmap(image.astype(np.float32)).write(str(path))
    read = panorama_from(str(path)).image[:, ::-1]
    step = image.max(axis=2, keepdims=True) / 128.0 if ending == ".hdr" else 1e-3 * image  # 8 bits share an exponent
    assert (np.abs(read - image) <= step).all()


def test_radiance_files_without_runs_are_read() -> None:
    pixels = np.array([[[128, 64, 32, 129], [0, 0, 0, 0]]], np.uint8)
    data = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + pixels.tobytes()
    assert radiance_image(data).tolist() == [[[1.0, 0.5, 0.25], [0.0, 0.0, 0.0]]]


@pytest.mark.parametrize("data", [
    b"", b"P6\n", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n\x02\x02",
    b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99999999 +X 99999999\n",
    b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n\x02\x02\x00\x08" + b"\x00" * 40,
])  # fmt: skip
def test_broken_files_are_diagnostics(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.hdr").write_bytes(data)
    with pytest.raises(SceneError, match="not an image that can be read"):
        environment_of(str(tmp_path / "a.hdr"))


@pytest.mark.parametrize(
    ("pixels", "key"),
    [([[1.0, 1.0]], 0.0), ([[4.0, 1.0]], 0.0), ([[1.0] * 4, [0.5] * 4], 0.0), ([[1.0, 9.0, 1.0, 1.0], [0.5] * 4], 0.0)],
)
def test_an_image_of_few_pixels_is_large_areas_of_light(tmp_path: Path, pixels: list[list[float]], key: float) -> None:
    mi = pytest.importorskip("mitsuba")
    image = np.repeat(np.array(pixels, np.float32)[:, :, None], 3, axis=2)
    mi.Bitmap(image).write(str(tmp_path / "a.exr"))
    chosen = environment_of(str(tmp_path / "a.exr"))
    assert np.array(chosen.key).max() == key
    assert chosen.ambient == pytest.approx((1.0, 1.0, 1.0), abs=0.02)
    above = image[: max(1, len(image) // 2)].mean()
    assert chosen.strength == pytest.approx(1.0 / above, rel=0.05)


def test_the_sun_of_an_image_becomes_the_key_light() -> None:
    """A uniform sky with a disk whose light is known: the split keeps all of it, at its place."""
    image = np.full((256, 512, 3), 0.4)
    toward = directions_of(256)
    azimuth, elevation = np.radians(50.0), np.radians(35.0)
    middle = np.array([np.sin(azimuth) * np.cos(elevation), np.sin(elevation), np.cos(azimuth) * np.cos(elevation)])
    disk = toward @ middle > np.cos(np.radians(2.0))
    image[disk] += [900.0, 800.0, 600.0]
    rest, sun = without_sun(Panorama(image))
    assert sun is not None
    assert (sun.azimuth, sun.elevation, sun.radius) == pytest.approx((50.0, 35.0, 2.0), abs=0.4)
    power = (solid_angles(256) * disk).sum() / np.pi
    assert sun.light == pytest.approx(np.array([900.0, 800.0, 600.0]) * power, rel=1e-6)
    assert rest.image == pytest.approx(np.full((256, 512, 3), 0.4))


def test_an_image_without_a_sun_has_no_key_light() -> None:
    assert without_sun(Panorama(gradient()))[1] is None


@pytest.mark.parametrize("text", ["sky", "sky,hour=7", "sky,hour=17.5,haze=6", "sky,hour=12,haze=2"])
def test_a_white_horizontal_surface_is_white_by_day(text: str) -> None:
    environment = environment_of(text)
    key = np.array(environment.key) * np.sin(np.radians(environment.height))
    assert (np.array(environment.ambient) + key) @ LUMINANCE == pytest.approx(1.0)
    dome = studio_for(RIGHT, text).dome
    assert dome.irradiance(UP, above=True)[0] == pytest.approx(np.array(environment.ambient), rel=0.02)


def test_the_sun_goes_from_east_to_west() -> None:
    morning, noon, evening = (daylight(hour, 3.0) for hour in (8.0, 12.0, 16.0))
    assert (noon.azimuth, noon.elevation) == pytest.approx((0.0, 45.0))
    assert morning.azimuth == pytest.approx(-evening.azimuth)
    assert morning.azimuth > 0.0
    late = daylight(17.7, 3.0)
    assert late.sun[0] / late.sun[2] > 3.0 * noon.sun[0] / noon.sun[2]
    assert noon.sun @ LUMINANCE * np.pi == pytest.approx(95.0, abs=20.0)  # kilolux at the ground under a clear sky


@pytest.mark.parametrize("hour", [9.0, 12.0, 15.0])
def test_the_sky_is_like_that_of_another_model(hour: float) -> None:
    """Mitsuba's ``sunsky`` follows Hosek and Wilkie (2012), who fitted simulated skies: the patterns of
    a clear one agree. In haze, Preetham's is known to be too bright at the zenith."""
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("scalar_rgb")
    light = daylight(hour, 2.0)
    a, e = np.radians(light.azimuth), np.radians(light.elevation)
    sun = [float(np.sin(a) * np.cos(e)), float(np.sin(e)), float(np.cos(a) * np.cos(e))]
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # theirs has +z up
    sky = mi.load_dict({
        "type": "sunsky", "sun_direction": (upright @ sun).tolist(), "sun_scale": 0.0, "turbidity": 2.0,
    })  # fmt: skip
    toward = directions_of(12)[:6].reshape(-1, 3)
    away = toward @ np.array(sun) < np.cos(np.radians(20.0))
    hit, other = mi.SurfaceInteraction3f(), []
    for direction in toward[away]:
        hit.wi = mi.Vector3f(*(-upright @ direction))
        other.append(np.array(sky.eval(hit)) @ LUMINANCE)
    ours = Dome(light.panorama).radiance(toward[away]) @ LUMINANCE
    assert np.corrcoef(np.log(ours), np.log(np.maximum(other, 1e-6)))[0, 1] > 0.9


def test_settings_change_strength_and_turn() -> None:
    plain, strong = (studio_for(RIGHT, text) for text in ("studio", "studio,strength=2"))
    at = directions_of(8).reshape(-1, 3)
    assert strong.dome.radiance(at) == pytest.approx(2.0 * plain.dome.radiance(at))
    assert np.array(strong.environment.key) == pytest.approx(2.0 * np.array(plain.environment.key))
    for right in (RIGHT, np.array([0.0, 0.0, -1.0])):  # from two cameras
        fixed = studio_for(right, "studio,turn=30")
        assert fixed.key_direction == pytest.approx(studio_for(RIGHT, "studio,turn=30").key_direction)
    turned = studio_for(RIGHT, "sky,hour=15,turn=90").dome
    around = np.array([[0.6, 0.3, 0.74]])
    around /= np.linalg.norm(around)
    quarter = np.stack([-around[:, 2], around[:, 1], around[:, 0]], axis=1)  # what turns to it
    assert turned.radiance(around) == pytest.approx(studio_for(RIGHT, "sky,hour=15").dome.radiance(quarter), rel=1e-6)


@pytest.mark.parametrize(("text", "words"), [
    ("studi", "did you mean"), ("sky,hour=3", "from 6 to 18"), ("studio,hour=9", "unknown setting"),
    ("studio,turn=x", "must be a number"), ("lost.hdr", "cannot read"), ("sky,haze=1", "from 2 to 10"),
    ("studio,strength=nan", "must be"),
])  # fmt: skip
def test_wrong_environments_are_diagnostics(text: str, words: str) -> None:
    with pytest.raises(SceneError) as caught:
        environment_of(text)
    assert words in str(caught.value)


@pytest.mark.parametrize("pixel", [np.nan, np.inf, -1.0, 0.0])
def test_images_without_light_are_diagnostics(tmp_path: Path, pixel: float) -> None:
    mi = pytest.importorskip("mitsuba")
    image = np.zeros((8, 16, 3), np.float32)
    image[2, 3] = pixel
    mi.Bitmap(image).write(str(tmp_path / "a.exr"))
    with pytest.raises(SceneError, match=r"not light|is black"):
        environment_of(str(tmp_path / "a.exr"))


def test_a_square_image_is_no_panorama(tmp_path: Path) -> None:
    mi = pytest.importorskip("mitsuba")
    mi.Bitmap(np.ones((8, 8, 3), np.float32)).write(str(tmp_path / "a.hdr"))
    with pytest.raises(SceneError, match="not a panorama"):
        environment_of(str(tmp_path / "a.hdr"))


@pytest.mark.parametrize("environment", ["sky,hour=10", "sky,hour=17.5", "studio,turn=60,strength=0.7"])
def test_draft_and_final_agree(make: Any, environment: str) -> None:
    pytest.importorskip("mitsuba")
    ball = make.scene(make.primitive("sphere", color=(0.6, 0.5, 0.4)))
    pictures = [
        draw(
            ball,
            PictureOptions(
                width=64, height=64, camera=Viewpoint(20, 30), environment=environment, ground="white", settings=more
            ),
            picture_backend(quality),
        ).radiance
        for quality, more in (("draft", {}), ("final", {"samples": 64}))
    ]
    draft, final = (picture[20:44, 20:44].reshape(-1, 3).mean(axis=0) for picture in pictures)
    assert draft == pytest.approx(final, rel=0.1)


def test_exposure_doubles_light_and_keeps_radiance(make: Any) -> None:
    ball = make.scene(make.primitive("sphere", color=(0.1, 0.1, 0.1)))
    plain, bright = (
        draw(ball, PictureOptions(width=32, height=32, ground="seamless", exposure=stops), picture_backend("draft"))
        for stops in (None, 1.0)
    )
    assert (plain.radiance == bright.radiance).all()
    assert (bright.picture.astype(int) >= plain.picture).all()
    assert bright.picture[16, 16].mean() > plain.picture[16, 16].mean() + 10


@pytest.mark.parametrize("quality", ["draft", "final"])
@pytest.mark.parametrize("strength", [0.01, 30.0])
def test_the_exposure_by_the_scene_does_not_depend_on_the_strength_of_the_light(
    make: Any, quality: str, strength: float
) -> None:
    ball = make.scene(make.primitive("sphere", color=(0.3, 0.3, 0.3)))
    settings = {} if quality == "draft" else {"samples": 16}

    def middle(strength: float) -> float:
        options = PictureOptions(
            width=48, height=48, environment=f"studio,strength={strength}", ground="none", exposure="auto",
            settings=settings,
        )  # fmt: skip
        return float(draw(ball, options, picture_backend(quality)).picture[18:30, 18:30].mean())

    assert middle(strength) == pytest.approx(middle(1.0), abs=4.0)
    assert 90 < middle(1.0) < 190


# --- tone curves ----------------------------------------------------------------------------------------------------


def test_agx_is_a_curve_of_grays_that_keeps_hues_and_fades_to_white() -> None:
    stops = np.linspace(-12.0, 4.5, 60)
    grays = np.repeat(2.0 ** stops[:, None], 3, axis=1)
    shown = agx(grays)
    assert np.ptp(shown, axis=1).max() < 0.02
    assert (np.diff(shown.mean(axis=1)) >= -1e-4).all()
    assert shown[0].max() < 0.005
    assert shown[-1].min() > 0.97
    red = agx(np.array([[0.2, 0.02, 0.02], [20.0, 0.4, 0.4]]))
    assert red[0, 0] > 2.5 * red[0, 1]
    assert red[1, 1] > 0.3  # a bright red fades


# Linear colors, most of them without one channel, and the sRGB that Blender 5.0.1 shows of them with its view transform
# AgX (drawn by a seed from 600, and four grays).
BLENDER = [
    ((0, 0.00859035, 0.00030795), (0, 14, 0)),
    ((0.0866635, 0, 0.00353528), (74, 0, 2)),
    ((0.199554, 0.11825, 0), (122, 92, 0)),
    ((0, 0.309991, 0.0220359), (31, 143, 30)),
    ((0, 0.0349414, 0.017112), (1, 44, 30)),
    ((5.11027e-05, 0, 0.0210161), (0, 4, 30)),
    ((0.202967, 0, 9.45446), (183, 195, 255)),
    ((0.000649591, 0.0895014, 0), (13, 75, 0)),
    ((0.0443254, 0.0874809, 0), (58, 75, 0)),
    ((0.00506772, 0.0199554, 0), (13, 29, 0)),
    ((0, 1.60608, 0.0606515), (142, 212, 129)),
    ((0, 0.00637249, 2.30392), (95, 130, 236)),
    ((0, 0.0673867, 3.24514), (120, 153, 243)),
    ((0.0806885, 0.0845903, 0), (77, 75, 0)),
    ((0, 0.0149765, 0.00193782), (0, 23, 2)),
    ((0.0249216, 0.0211165, 0), (37, 31, 0)),
    ((0.0438063, 0.0165119, 0), (51, 28, 0)),
    ((0.811201, 0, 2.92854), (182, 156, 236)),
    ((0.103646, 0, 0.123239), (84, 20, 96)),
    ((0.356528, 0, 0.275954), (156, 44, 142)),
    ((0.691125, 0, 0.797665), (185, 98, 194)),
    ((0.0336319, 0, 0.00662651), (41, 0, 13)),
    ((6.86858, 0, 1.82653), (254, 191, 213)),
    ((0.0741953, 0, 0.0189448), (68, 1, 31)),
    ((6.91702, 5.48851, 6.82839), (243, 240, 243)),
    ((0.693034, 0.698646, 0.321328), (184, 181, 153)),
    ((0.107322, 0.111887, 0.0920824), (90, 91, 83)),
    ((0.542277, 0.330697, 0.738077), (171, 157, 187)),
    ((0.0115812, 0.018086, 0.0219889), (21, 30, 34)),
    ((0.0455821, 0.218649, 0.20448), (60, 128, 125)),
    ((0.382528, 1.27501, 0.706526), (172, 204, 185)),
    ((5.37836, 0.284106, 19.0518), (235, 224, 255)),
    ((4.25466, 2.85362, 1.15799), (236, 224, 207)),
    ((1.29125, 0.56314, 0.498378), (208, 176, 172)),
    ((0.00227661, 0.00227661, 0.00227661), (3, 3, 3)),
    ((0.0424589, 0.0424589, 0.0424589), (52, 52, 52)),
    ((0.79186, 0.79186, 0.79186), (188, 188, 188)),
    ((14.7682, 14.7682, 14.7682), (254, 254, 254)),
]


@pytest.mark.parametrize(("linear", "shown"), BLENDER)
def test_agx_is_that_of_blender(linear: tuple[float, ...], shown: tuple[int, ...]) -> None:
    """Of 600 colors the largest difference was 3.8 levels, of a very bright one."""
    assert np.abs(encode(agx(np.array(linear))).astype(int) - shown).max() <= 3


def test_agx_keeps_the_rest_of_an_image_with_a_nan() -> None:
    shown = agx(np.array([[np.nan, 0.2, 0.2], [0.18, 0.18, 0.18], [-1.0, np.inf, 1e308]]))
    assert np.isnan(shown[0]).all()
    assert shown[1] == pytest.approx([0.18] * 3, abs=1e-3)
    assert ((shown[2] >= 0.0) & (shown[2] <= 1.0)).all()
    assert agx(np.zeros((2, 0, 3))).shape == (2, 0, 3)


def test_all_curves_are_for_single_colors_and_images() -> None:
    image = np.random.default_rng(0).random((4, 5, 3)) * 3.0
    for curve in (tone, agx, clipped):
        assert curve(image).shape == image.shape
        assert curve(image)[2, 3] == pytest.approx(curve(image[2, 3]))


def test_an_image_is_drawn_with_agx(make: Any) -> None:
    ball = make.scene(make.primitive("sphere", color=(0.5, 0.5, 0.5)))
    image = draw(ball, PictureOptions(width=32, height=32, tone="agx"), picture_backend("draft"))
    inner = image.radiance[16, 16]
    shown = agx(inner)
    encoded = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055) * 255
    assert np.abs(image.picture[16, 16] - encoded).max() <= 2
    with pytest.raises(SceneError, match="tone"):
        draw(ball, PictureOptions(tone="acgx"), picture_backend("draft"))


def test_the_message_of_a_wrong_exposure_names_auto(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["render", "a.scene", "--exposure", "bright"])
    assert "from -30 to 30, got `bright`; or `auto`" in capsys.readouterr().err
