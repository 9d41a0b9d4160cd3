"""Depth of field: the blur of a lens against the closed form, in both qualities."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from scenelang.backends.pictures.camera import Viewpoint
from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend
from scenelang.interpreter.scene import pose

FOCUS, BEHIND, RADIUS, FOV = 4.0, 4.0, 0.4, 40.0
SIZE = 96


def rows_of_light(make: Any, quality: str, aperture: float) -> np.ndarray:
    """Return the radiance along the middle row: a small lamp twice as far away as the focus, before black."""
    lamp = (make.primitive("sphere", radius=0.05, emission=40.0, color=(1, 1, 1)), pose.translation(0, 0, -BEHIND))
    near = (make.primitive("sphere", radius=1e-3, color=(0, 0, 0)), pose.translation(0, 0, 0))
    camera = Viewpoint(0.0, 0.0, distance=FOCUS, fov=FOV, target=(0.0, 0.0, 0.0), aperture=aperture, focus=FOCUS)
    settings = {} if quality == "draft" else {"samples": 256, "denoise": "off"}
    options = PictureOptions(
        width=SIZE, height=SIZE, camera=camera, environment="night", ground="none", settings=settings
    )
    return draw(make.scene(lamp, near), options, picture_backend(quality)).radiance.mean(axis=2)[SIZE // 2]


@pytest.mark.parametrize("quality", ["draft", "final"])
def test_a_point_out_of_focus_is_a_disk_of_the_size_that_the_lens_gives(make: Any, quality: str) -> None:
    if quality == "final":
        pytest.importorskip("mitsuba")
    distance = FOCUS + BEHIND
    focal = SIZE / (2.0 * np.tan(np.radians(FOV) / 2.0))
    # Rays from the rim of the lens through a point at the distance z meet the plane in focus r |z - f| / z off the axis.
    wanted = 2.0 * RADIUS * (distance - FOCUS) / distance * focal / FOCUS
    sharp, blurred = (rows_of_light(make, quality, aperture) for aperture in (0.0, RADIUS))
    assert (sharp > 1.0).sum() <= 3
    lit = np.flatnonzero(blurred > 0.05 * blurred.max())
    assert lit[-1] - lit[0] + 1 == pytest.approx(wanted, abs=4.0)
    assert (lit[-1] + lit[0]) / 2.0 == pytest.approx(SIZE / 2.0, abs=1.5)


def test_what_is_in_focus_stays_where_it_is(make: Any) -> None:
    ball = make.scene(make.primitive("sphere", color=(0.8, 0.2, 0.1)))
    pictures = [
        draw(
            ball,
            PictureOptions(width=SIZE, height=SIZE, ground="none", camera=Viewpoint(20, 10, aperture=aperture)),
            picture_backend("draft"),
        ).picture.astype(float)
        for aperture in (0.0, 0.02)
    ]
    assert np.abs(pictures[0] - pictures[1]).mean() < 2.0


@pytest.mark.parametrize("quality", ["draft", "final"])
def test_the_horizon_of_a_seamless_ground_has_no_seam_through_a_lens(make: Any, quality: str) -> None:
    if quality == "final":
        pytest.importorskip("mitsuba")
    ball = make.scene(make.primitive("sphere", color=(0.8, 0.2, 0.1)))
    camera = Viewpoint(0.0, 8.0, distance=8.0, fov=60.0, aperture=0.3)
    settings = {} if quality == "draft" else {"samples": 32}
    options = PictureOptions(width=SIZE, height=SIZE, camera=camera, ground="seamless", settings=settings)
    column = draw(ball, options, picture_backend(quality)).picture[:, 2].astype(float)
    assert np.abs(np.diff(column, axis=0)).max() < 8
    assert np.abs(np.diff(column, 2, axis=0)).max() < 8, "the light falls off smoothly"
