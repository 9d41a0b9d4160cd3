"""The tone of the backdrop shows the outline of what is before it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from scenelang.backends.pictures.backdrops import TONES, lightness, tone_for
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend
from scenelang.backends.surfaces.environments import ENVIRONMENTS
from scenelang.backends.surfaces.image_files import encode, from_srgb

CURRENT = ENVIRONMENTS["studio"].backdrop


def test_lightness_is_that_of_cie() -> None:
    assert lightness(np.array([[0.0, 0.0, 0.0], [0.18418651851244416] * 3, [1.0, 1.0, 1.0]])) == pytest.approx(
        [0.0, 50.0, 100.0], abs=1e-3
    )


@pytest.mark.parametrize("gray", [0.02, 0.1, 0.3, 0.6, 0.9])
def test_the_chosen_tone_differs_from_the_scene(gray: float) -> None:
    assert CURRENT is not None
    solid = np.zeros((60, 80), bool)
    solid[20:40, 30:50] = True
    radiance = np.where(solid[:, :, None], gray, np.array(CURRENT))
    chosen = np.array(tone_for(radiance, solid, ENVIRONMENTS["studio"])) * CURRENT
    assert any(np.allclose(chosen, tone) for tone in TONES)
    difference = lightness(chosen[None]) - lightness(np.array([[gray] * 3]))
    assert abs(float(difference[0])) >= 20.0


def test_a_scene_that_fills_the_picture_keeps_the_tone() -> None:
    assert tone_for(np.ones((8, 8, 3)), np.ones((8, 8), bool), ENVIRONMENTS["studio"]) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize("strength", [0.2, 0.5])
@pytest.mark.parametrize("gray", [0.05, 0.4, 0.9])
def test_a_weak_studio_has_no_horizon(make: Any, strength: float, gray: float) -> None:
    """The tone is a share of the backdrop's own light, which the ground can reflect."""
    ball = make.scene(make.primitive("sphere", color=(gray, gray, gray)))
    options = PictureOptions(
        width=64, height=48, environment=f"studio,strength={strength}", camera=Viewpoint(elevation=2, distance=12)
    )
    picture = draw(ball, options, picture_backend("draft")).picture.astype(int)
    assert np.abs(np.diff(picture[:, :6], axis=0)).max() <= 3


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
    assert np.abs(picture[0, 0].astype(int) - encode(np.array(CURRENT))).max() <= 1


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
