"""Cameras: framing, directions, and their text form."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scenelang.backends.pictures.camera import (
    PRESETS,
    Camera,
    Viewpoint,
    axes_of,
    camera_from_json,
    camera_to_json,
    parse_viewpoint,
    place,
)
from scenelang.grammar.diagnostics import SceneError

BOXES = [
    ([-1, -1, -1], [1, 1, 1]),
    ([0, 0, 0], [10, 0.1, 2]),
    ([5, 5, 5], [5.001, 9, 5.001]),
    ([1e6, -3, 0], [1e6 + 2, 3, 1]),
]


def corners(low: list[float], high: list[float]) -> np.ndarray:
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])], float)


def flat_of(view: Camera, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Picture positions from -1 to 1, and depths."""
    pixels, depth = view.project(points)
    return pixels / [view.width / 2, view.height / 2] - 1.0, depth


@pytest.mark.parametrize(("low", "high"), BOXES)
@pytest.mark.parametrize("aspect", [0.5, 1.0, 16 / 9])
@pytest.mark.parametrize("azimuth", [0.0, 30.0, -135.0])
@pytest.mark.parametrize("elevation", [-90.0, 0.0, 25.0, 90.0])
def test_the_whole_box_is_in_view_and_touches_the_margin(
    low: list[float], high: list[float], aspect: float, azimuth: float, elevation: float
) -> None:
    view = place(Viewpoint(azimuth, elevation), np.array(low, float), np.array(high, float), round(900 * aspect), 900)
    flat, depth = flat_of(view, corners(low, high))
    assert (depth > 0).all()
    assert np.abs(flat).max() == pytest.approx(0.94, abs=1e-3)


@pytest.mark.parametrize(("low", "high"), [*BOXES, ([-1, 0, -1], [1, 0, 1]), ([0, 0, 0], [1, 8, 3])])
@pytest.mark.parametrize("aspect", [0.5, 1.0, 16 / 9])
@pytest.mark.parametrize(("azimuth", "elevation"), [(0.0, 25.0), (30.0, 25.0), (-135.0, 60.0), (45.0, -35.0)])
@pytest.mark.parametrize("distance", [None, 40.0])
def test_the_box_is_centered_along_both_sides_of_the_picture(
    low: list[float], high: list[float], aspect: float, azimuth: float, elevation: float, distance: float | None
) -> None:
    viewpoint = Viewpoint(azimuth, elevation, distance=distance)
    view = place(viewpoint, np.array(low, float), np.array(high, float), round(900 * aspect), 900)
    flat, _ = flat_of(view, corners(low, high))
    assert flat.max(axis=0) == pytest.approx(-flat.min(axis=0), abs=1e-6)


def test_an_eye_within_the_box_is_placed() -> None:
    view = place(Viewpoint(0, 0, distance=0.5), np.full(3, -1.0), np.ones(3), 100, 100)
    assert view.eye == pytest.approx([0, 0, 0.5], abs=1e-9)


def test_a_target_is_in_the_middle_and_everything_still_in_view() -> None:
    view = place(Viewpoint(target=(1.0, 1.0, 1.0)), np.full(3, -1.0), np.full(3, 1.0), 100, 100)
    assert flat_of(view, np.ones((1, 3)))[0] == pytest.approx(np.zeros((1, 2)), abs=1e-9)
    assert np.abs(flat_of(view, corners([-1] * 3, [1] * 3))[0]).max() == pytest.approx(0.94, abs=1e-3)


def test_distance_is_kept() -> None:
    view = place(Viewpoint(distance=7.0, target=(1.0, 2.0, 3.0)), np.full(3, -1.0), np.full(3, 1.0), 100, 100)
    assert np.linalg.norm(view.eye - [1, 2, 3]) == pytest.approx(7.0)


def test_a_point_can_be_framed() -> None:
    view = place(Viewpoint(), np.ones(3), np.ones(3), 100, 100)
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
    assert parse_viewpoint("azimuth=40, elevation=-20,distance=5,fov=35,target=0:1:-2.5") == Viewpoint(
        40, -20, 5, 35, (0, 1, -2.5)
    )
    assert parse_viewpoint("") == Viewpoint()


def test_presets() -> None:
    assert parse_viewpoint("top,azimuth=10").elevation == 90.0
    assert parse_viewpoint("isometric").orthographic
    assert parse_viewpoint("follow,orbit=90") == replace(PRESETS["follow"], orbit=90.0)
    assert parse_viewpoint("orthographic,aperture=.1,focus=3") == Viewpoint(orthographic=True, aperture=0.1, focus=3.0)


@pytest.mark.parametrize("view", [Viewpoint(), PRESETS["isometric"], PRESETS["top"], Viewpoint(aperture=0.2)])
def test_the_json_form_keeps_the_camera(view: Viewpoint, tmp_path: Path) -> None:
    camera = place(view, np.full(3, -1.0), np.array([1.0, 2.0, 3.0]), 90, 60)
    path = tmp_path / "camera.json"
    path.write_text(json.dumps(camera_to_json(camera)))
    again = parse_viewpoint(str(path))
    assert isinstance(again, Camera)
    points = np.random.default_rng(1).uniform(-1, 1, (20, 3))
    assert again.project(points)[0] == pytest.approx(camera.project(points)[0])
    assert (again.aperture, again.focus, again.projection) == (camera.aperture, camera.focus, camera.projection)
    bigger = again.resized(180, 120)
    assert bigger.project(points)[0] == pytest.approx(2 * camera.project(points)[0])
    moved = camera.rescaled(np.array([0.3, 0.2, 0.1]), 2.5)
    assert moved.project((points - [0.3, 0.2, 0.1]) * 2.5)[0] == pytest.approx(camera.project(points)[0])


GOOD = camera_to_json(place(Viewpoint(), np.zeros(3), np.ones(3), 8, 8))


@pytest.mark.parametrize(
    "change",
    [
        *({"width": 0}, {"width": 1.5}, {"height": "8"}, {"K": [[1, 2], [3, 4]]}, {"K": None}, {"format": "x"}),
        *({"world_to_camera": (2 * np.eye(4)).tolist()}, {"projection": "fisheye"}, {"aperture": -1}, {"focus": "x"}),
        *({"K": [[8, 0, 4], [0, 9, 4], [0, 0, 1]]}, {"world_to_camera": [[float("nan")] * 4] * 4}),
    ],
)
def test_bad_json_is_diagnosed(change: dict[str, object]) -> None:
    with pytest.raises(SceneError) as caught:
        camera_from_json(GOOD | change)
    assert caught.value.name == "value"


@pytest.mark.parametrize(
    "text",
    [
        *("azimut=3", "azimuth", "azimuth=x", "target=1:2", "fov=0", "fov=170", "distance=-1", "distance=0", "5"),
        *("azimuth=nan", "azimuth=1,azimuth=2", "azimuth=1:2", "distance=inf"),
    ],
)
def test_bad_text_is_diagnosed(text: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_viewpoint(text)
    assert caught.value.name == "value"
