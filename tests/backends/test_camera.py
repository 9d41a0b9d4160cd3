"""Cameras: framing, directions, and their text form."""

from __future__ import annotations

import numpy as np
import pytest

from scenelang.backends.camera import Camera, axes_of, parse_camera, place
from scenelang.grammar.diagnostics import SceneError

BOXES = [
    ([-1, -1, -1], [1, 1, 1]),
    ([0, 0, 0], [10, 0.1, 2]),
    ([5, 5, 5], [5.001, 9, 5.001]),
    ([1e6, -3, 0], [1e6 + 2, 3, 1]),
]


def corners(low: list[float], high: list[float]) -> np.ndarray:
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])], float)


@pytest.mark.parametrize(("low", "high"), BOXES)
@pytest.mark.parametrize("aspect", [0.5, 1.0, 16 / 9])
@pytest.mark.parametrize("azimuth", [0.0, 30.0, -135.0])
@pytest.mark.parametrize("elevation", [-90.0, 0.0, 25.0, 90.0])
def test_the_whole_box_is_in_view_and_touches_the_margin(
    low: list[float], high: list[float], aspect: float, azimuth: float, elevation: float
) -> None:
    view = place(Camera(azimuth, elevation), np.array(low, float), np.array(high, float), aspect)
    flat, depth = view.project(corners(low, high))
    assert (depth > 0).all()
    assert np.abs(flat).max() == pytest.approx(0.94, abs=1e-3)


def test_a_target_is_in_the_middle_and_everything_still_in_view() -> None:
    view = place(Camera(target=(1.0, 1.0, 1.0)), np.full(3, -1.0), np.full(3, 1.0), 1.0)
    assert view.project(np.ones((1, 3)))[0] == pytest.approx(np.zeros((1, 2)), abs=1e-9)
    assert np.abs(view.project(corners([-1] * 3, [1] * 3))[0]).max() == pytest.approx(0.94, abs=1e-3)


def test_distance_is_kept() -> None:
    view = place(Camera(distance=7.0, target=(1.0, 2.0, 3.0)), np.full(3, -1.0), np.full(3, 1.0), 1.0)
    assert np.linalg.norm(view.eye - [1, 2, 3]) == pytest.approx(7.0)


def test_a_point_can_be_framed() -> None:
    view = place(Camera(), np.ones(3), np.ones(3), 1.0)
    assert np.isfinite(view.eye).all()


def test_directions() -> None:
    _, up, forward = axes_of(0, 0)
    assert forward == pytest.approx([0, 0, -1])
    assert up == pytest.approx([0, 1, 0])
    assert axes_of(90, 0)[2] == pytest.approx([-1, 0, 0], abs=1e-12)  # the camera stands at +x
    assert axes_of(0, 90)[2] == pytest.approx([0, -1, 0], abs=1e-12)
    for axes in (axes_of(33, 71), axes_of(-20, -90)):
        assert np.stack(axes) @ np.stack(axes).T == pytest.approx(np.eye(3), abs=1e-12)
        assert np.cross(axes[0], axes[1]) == pytest.approx(-axes[2])


def test_text() -> None:
    assert parse_camera("azimuth=40, elevation=-20,distance=5,fov=35,target=0:1:-2.5") == Camera(
        40, -20, 5, 35, (0, 1, -2.5)
    )
    assert parse_camera("") == Camera()


@pytest.mark.parametrize(
    "text",
    [
        *("azimut=3", "azimuth", "azimuth=x", "target=1:2", "fov=0", "fov=170", "distance=-1", "distance=0", "5"),
        *("azimuth=nan", "azimuth=1,azimuth=2", "azimuth=1:2", "distance=inf"),
    ],
)
def test_bad_text_is_diagnosed(text: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_camera(text)
    assert caught.value.name == "value"
