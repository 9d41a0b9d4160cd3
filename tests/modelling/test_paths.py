"""Paths: curves, lengths, frames and what is placed along them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import value

from scenelang.interpreter.scene.modelling import curves
from scenelang.interpreter.values.values import Matrix, list_items

FloatArray = npt.NDArray[np.float64]
Arrays = Callable[[str], FloatArray]
Numbers = Callable[[str], float]
Refuses = Callable[[str, str], str]

POINTS = st.lists(st.tuples(*[st.floats(-10.0, 10.0)] * 3), min_size=3, max_size=12)


def path_through(points: list[tuple[float, float, float]]) -> FloatArray | None:
    """A path through points that are well apart, without sharp turns back; else None."""
    path = curves.without_repeats(np.array(points))
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    if len(path) < 3 or steps.min() < 0.01:
        return None
    directions = np.diff(path, axis=0) / steps[:, None]
    return path if np.sum(directions[:-1] * directions[1:], axis=1).min() > -0.99 else None


@pytest.mark.parametrize(
    ("expression", "length"),
    [
        ("[[0 0 0] [3 0 0] [3 4 0]]", 7.0),
        ("(polyline [[0 0] [3 0] [3 4]] :closed #t)", 12.0),
        ("(helix 1 0 1 :segments 1000)", math.tau),
        ("(helix 2 3 -4 :segments 1000)", math.hypot(4.0 * math.tau * 2.0, 3.0)),
        ("(bezier [[0 0 0] [1 2 0] [2 4 0]])", math.hypot(2.0, 4.0)),
        ("(bezier [[0 0] [1 0] [2 0] [3 0] [4 0] [5 0] [6 0]] :chained #t)", 6.0),
        ("(catmull-rom [[0 0 0] [1 0 0] [3 0 0]])", 3.0),
        ("(resample-path [[0 0 0] [3 0 0] [3 4 0]] 8)", 7.0),
    ],
)
def test_lengths(number: Numbers, expression: str, length: float) -> None:
    assert number(f"(path-length {expression})") == pytest.approx(length, rel=1e-5)


def test_a_bezier_curve_is_its_polynomial(array: Arrays) -> None:
    control = np.array([[0, 0, 0], [1, 3, 0], [2, -1, 4], [5, 5, 5], [0, 1, 2]], float)
    t = np.linspace(0.0, 1.0, 9)[:, None]
    wanted = sum(math.comb(4, i) * t**i * (1 - t) ** (4 - i) * control[i] for i in range(5))
    assert np.allclose(array("(bezier [[0 0 0] [1 3 0] [2 -1 4] [5 5 5] [0 1 2]] :segments 8)"), wanted)


def test_a_catmull_rom_spline_goes_through_its_points(array: Arrays) -> None:
    points = "[[0 0 0] [1 2 0] [3 1 1] [4 0 0]]"
    wanted = np.array([[0, 0, 0], [1, 2, 0], [3, 1, 1], [4, 0, 0]], float)
    assert np.allclose(array(f"(catmull-rom {points} :segments 7)")[::7], wanted)
    closed = array(f"(catmull-rom {points} :closed #t :segments 7)")
    assert np.allclose(closed[::7], [*wanted, wanted[0]])
    assert np.array_equal(closed[0], closed[-1])
    assert array("(catmull-rom [[0 0] [1 2] [3 1]])").shape == (33, 2)


def test_a_helix_turns_like_ring(array: Arrays) -> None:
    path = array("(helix 2 4 1 :segments 4)")
    assert np.allclose(path, [[0, 0, 2], [2, 1, 0], [0, 2, -2], [-2, 3, 0], [0, 4, 2]])


def test_places_on_a_path(array: Arrays) -> None:
    path = "[[0 0 0] [3 0 0] [3 1 0]]"
    assert np.allclose(array(f"(point-at {path} [0 .5 1])"), [[0, 0, 0], [2, 0, 0], [3, 1, 0]])
    assert np.allclose(array(f"(tangent-at {path} [0 .5 .75 1])"), [[1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0]])
    assert np.allclose(array(f"(point-at {path} .75)"), [3, 0, 0])


def test_tangents_of_a_curve_turn_evenly(array: Arrays) -> None:
    tangents = array("(tangent-at (polyline (circle 1) :closed #t) (linspace 0 1 101))")
    angles = np.unwrap(np.arctan2(tangents[:, 1], tangents[:, 0]))
    assert np.allclose(np.diff(angles), math.tau / 100.0, atol=1e-3)


# --- frames ----------------------------------------------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(POINTS)
def test_frames_are_orthonormal_and_follow_the_path(points: list[tuple[float, float, float]]) -> None:
    path = path_through(points)
    if path is None:
        return
    frames = curves.frames_of(path)
    for axes in (frames.axes, frames.posed_at(np.linspace(0.0, 1.0, 50))[1]):
        assert np.allclose(axes @ np.swapaxes(axes, 1, 2), np.eye(3), atol=1e-9)
        assert np.allclose(np.linalg.det(axes), 1.0)
    assert np.allclose(frames.axes[:, :, 2], np.diff(path, axis=0) / np.diff(frames.along)[:, None])


@settings(max_examples=60, deadline=None)
@given(POINTS)
def test_frames_turn_no_more_than_the_path(points: list[tuple[float, float, float]]) -> None:
    path = path_through(points)
    if path is None:
        return
    axes = curves.frames_of(path).axes
    turn = np.einsum("nij,nij->n", axes[:-1], axes[1:])  # the trace of the rotation from one to the next
    wanted = np.sum(axes[:-1, :, 2] * axes[1:, :, 2], axis=1)
    assert np.allclose((turn - 1.0) / 2.0, wanted, atol=1e-7)


def test_frames_of_a_curve_do_not_flip(array: Arrays) -> None:
    for path in ("(helix 1 2 5)", "(catmull-rom [[0 0 0] [0 2 0] [0 2 2] [2 2 2] [2 0 2]])"):
        points = array(path)
        axes = curves.frames_of(points).axes
        assert np.einsum("nx,nx->n", axes[:-1, :, 1], axes[1:, :, 1]).min() > 0.9


def test_frames_of_a_planar_path_stay_upright(array: Arrays) -> None:
    poses = [np.array(pose).reshape(3, 4) for pose in list_items(value("(frame-at (helix 2 0 1) (linspace 0 1 20))"))]
    assert all(np.allclose(pose[:, 1], [0, 1, 0]) for pose in poses)


def test_the_frames_of_a_closed_path_meet(array: Arrays) -> None:
    path = array("(catmull-rom [[0 0 0] [2 1 0] [2 0 2] [0 -1 2] [-1 2 1]] :closed #t)")
    frames = curves.frames_of(path)
    assert frames.closed
    assert abs(frames.roll) > 0.01
    _, axes = frames.posed_at(np.array([0.0, 1.0]))
    assert np.allclose(axes[0], axes[1], atol=1e-9)


def test_rotation_minimising_frames_agree_with_the_total_torsion(array: Arrays) -> None:
    """Of a helix, the frame turns against the principal normal by the torsion times the length."""
    frames = curves.frames_of(array("(helix 1 2 1 :segments 1000)"))
    rise = 2.0 / math.tau
    torsion, length = rise / (1.0 + rise**2), math.hypot(math.tau, 2.0)
    inwards = -frames.points[:-1] * [1.0, 0.0, 1.0]
    angle = np.unwrap(np.arctan2(*(np.einsum("nx,nx->n", inwards, frames.axes[:, :, k]) for k in (1, 0))))
    assert abs(angle[-1] - angle[0]) == pytest.approx(torsion * length, rel=2e-3)


def test_frames_at_the_start(array: Arrays) -> None:
    assert value("(frame-at [[1 2 3] [1 2 4]] 0)") == Matrix((1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3))
    upwards = np.array(value("(frame-at [[0 0 0] [0 1 0]] 0)")).reshape(3, 4)
    assert np.allclose(upwards[:, :3], [[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    upright = np.array(value("(frame-at (helix 1 3 1) .9 :upright #t)")).reshape(3, 4)
    assert upright[1, 0] == pytest.approx(0.0)
    assert upright[1, 1] > 0.5


# --- placement -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "count"),
    [
        ("[[0 0 0] [4 0 0]] :spacing 1", 5),
        ("[[0 0 0] [4 0 0]] :spacing 1.5", 3),
        ("[[0 0 0] [.9 0 0]] :spacing .3", 4),
        ("[[0 0 0] [4 0 0]] :count 7", 7),
        ("[[0 0 0] [4 0 0]] :count 1", 1),
        ("[[0 0 0] [4 0 0]] :count 0", 0),
        ("(polyline [[0 0 0] [1 0 0] [1 1 0] [0 1 0]] :closed #t) :spacing 1", 4),
        ("(polyline [[0 0 0] [1 0 0] [1 1 0] [0 1 0]] :closed #t) :count 4", 4),
    ],
)
def test_along(number: Numbers, array: Arrays, arguments: str, count: int) -> None:
    assert number(f'(length (along (call "cube") {arguments}))') == count


def test_along_calls_a_function_with_the_index(array: Arrays) -> None:
    line = "[[0 0 0] [9 0 0]] :count 4"
    assert np.allclose(
        array(f'(compute-shape-max (along (lambda (i) (call "cube" :scale (+ i 1))) {line} :turn #f))'),
        [11.0, 2.0, 2.0],
    )


def test_along_turns_copies(array: Arrays) -> None:
    sizes = '(compute-shape-sizes (along (call "cube" :scale [1 1 3]) [[0 0 0] [9 0 0]] :count 1 {}))'
    assert np.allclose(array(sizes.format("")), [3, 1, 1])
    assert np.allclose(array(sizes.format(":turn #f")), [1, 1, 3])


def test_look_at(array: Arrays, refuses: Refuses) -> None:
    pose = np.array(value("(look-at [1 2 3] [4 2 7])")).reshape(3, 4)
    assert np.allclose(pose[:, 2], [0.6, 0.0, 0.8])
    assert np.allclose(pose[:, 1], [0.0, 1.0, 0.0])
    assert np.allclose(pose[:, 3], [1.0, 2.0, 3.0])
    assert np.linalg.det(pose[:, :3]) == pytest.approx(1.0)
    assert "different points" in refuses("value", "(look-at [1 2 3] [1 2 3])")
    assert "`up`" in refuses("value", "(look-at [0 0 0] [0 5 0])")


@pytest.mark.parametrize(
    ("expression", "part"),
    [
        ("(path-length [[0 0 0]])", "two different points"),
        ("(path-length [[1 1 1] [1 1 1]])", "two different points"),
        ("(path-length [1 2 3])", "two different points"),
        ("(point-at [[0 0 0] [1 0 0]] 1.5)", "from 0 to 1"),
        ("(bezier [[0 0] [1 1] [2 2]] :chained #t)", "4, 7, 10"),
        ("(bezier (zeros '(100 3)))", "65 control points"),
        ("(helix 1 1 0)", "not 0"),
        ("(helix 1 1 1e9)", "100,000"),
        ("(resample-path [[0 0 0] [1 0 0]] 1)", "two points"),
        ("(resample-path [[0 0 0] [1 0 0]] 1000000)", "100,000"),
        ("(catmull-rom [[0 0 0] [1 0 0]] :closed #t)", "three points"),
        ("(catmull-rom [[0 0 0] [1 0 0]] :segments 0)", "1 to 1,024"),
        ("(polyline [[0 0 nan] [1 0 0]])", "finite"),
    ],
)
def test_wrong_use(refuses: Refuses, expression: str, part: str) -> None:
    assert part in refuses("value", expression)


def test_along_needs_one_of_its_keywords(refuses: Refuses) -> None:
    assert ":count or :spacing" in refuses("user", '(along (call "cube") [[0 0 0] [1 0 0]])')
    assert "above 0" in refuses("user", '(along (call "cube") [[0 0 0] [1 0 0]] :spacing -1)')
