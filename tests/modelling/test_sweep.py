"""Sweeps, lofts, height fields, and the noise that makes terrain."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import value

from scenelang.interpreter.scene.modelling import contours as shapes
from scenelang.interpreter.scene.modelling import curves, sweeping
from scenelang.interpreter.scene.modelling.computing import OPERATIONS, ComputedSolid, computed
from scenelang.interpreter.scene.modelling.operations import Expression
from scenelang.interpreter.values.values import Array
from scenelang.stdlib import random

FloatArray = npt.NDArray[np.float64]
Arrays = Callable[[str], FloatArray]
Numbers = Callable[[str], float]
Refuses = Callable[[str, str], str]


sweep_of = OPERATIONS["sweep"]


def sweep(profile: FloatArray, path: FloatArray, twist: float = 0.0) -> ComputedSolid:
    parameters = {"profile": (profile,), "path": np.asarray(path, np.float64), "twist": twist, "taper": np.ones(2)}
    return computed(Expression("sweep", parameters))


def check_closed(solid: ComputedSolid) -> None:
    """Every edge belongs to two faces, once in each direction, after joining what is split for normals."""
    _, place = np.unique(np.round(solid.mesh.vertices, 9), axis=0, return_inverse=True)
    faces = place.reshape(-1)[solid.mesh.faces]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert sorted(map(tuple, edges.tolist())) == sorted(map(tuple, edges[:, ::-1].tolist()))


# --- sweeps ----------------------------------------------------------------------------------------------------------


def test_along_z_it_is_an_extrusion(number: Numbers, array: Arrays) -> None:
    for measure in ("(volume {})", "(compute-shape-max {})", "(compute-shape-min {})"):
        swept, extruded = (
            np.asarray(value(measure.format(each)))
            for each in ("(sweep (star 5 1 .5) [[0 0 0] [0 0 1] [0 0 3]])", "(extrude (star 5 1 .5) 3)")
        )
        assert np.allclose(swept, extruded, atol=1e-7)


def test_a_circle_along_a_line_is_a_cylinder(number: Numbers) -> None:
    area = 32.0 * math.sin(math.tau / 64.0)
    assert number("(volume (sweep (circle 1) [[1 2 3] [3 3 5]]))") == pytest.approx(3.0 * area)


@pytest.mark.parametrize(
    ("profile", "path"),
    [
        ("(circle .3)", "(polyline (circle 2) :closed #t)"),
        ("(rectangle .5 1)", "(bezier [[0 0 0] [3 0 0] [3 0 5] [8 0 5]])"),
        ("(star 5 .4 .2)", "(helix 2 3 2)"),
        ("(rectangle .5 1)", "[[0 0 0] [4 0 0] [4 0 4] [8 0 4]]"),
        (
            "(profile-difference (circle .4) (circle .3))",
            "(catmull-rom [[0 0 0] [4 0 0] [6 4 0] [4 8 4] [0 6 6] [-2 2 3]] :closed #t)",
        ),
        ("(circle .2)", "(catmull-rom [[0 0 0] [4 2 0] [4 0 4] [0 -2 4] [-2 1 2]] :closed #t)"),
    ],
)
def test_the_volume_is_area_times_length(number: Numbers, profile: str, path: str) -> None:
    """Pappus's theorem, for profiles with their center on the path; where the profile turns, its sides are not flat."""
    volume = number(f"(volume (sweep {profile} {path}))")
    assert volume == pytest.approx(number(f"(* (profile-area {profile}) (path-length {path}))"), rel=1e-4)


def test_mitred_corners_keep_the_width(array: Arrays) -> None:
    sizes = array("(compute-shape-sizes (sweep (rectangle 1 1) [[0 0 0] [5 0 0] [5 0 5]]))")
    assert np.allclose(sizes, [5.5, 1.0, 5.5])


def test_a_closed_sweep_has_no_ends(number: Numbers) -> None:
    square = "[[0 0 0] [4 0 0] [4 0 4] [0 0 4]]"
    assert number(f"(volume (sweep (rectangle 1 1) {square} :closed #t))") == pytest.approx(16.0)
    solid = sweep(shapes.rectangle(0.3, 0.6, 0.0, 4), _knot())
    check_closed(solid)
    assert solid.volume > 0.0


def _knot() -> FloatArray:
    t = np.linspace(0.0, math.tau, 201)
    path = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1)
    path[-1] = path[0]
    return path


def test_twist_and_taper(number: Numbers, array: Arrays) -> None:
    assert number("(volume (sweep (rectangle 1 1) [[0 0 0] [0 0 3]] :taper 0))") == pytest.approx(1.0)
    assert number("(volume (sweep (rectangle 1 1) [[0 0 0] [0 0 3]] :taper [2 1]))") == pytest.approx(4.5)
    twisted = number("(volume (sweep (rectangle 1 1) [[0 0 0] [0 0 4]] :twist 3))")
    assert twisted == pytest.approx(4.0, rel=0.05)
    assert number("(volume (sweep (circle .3 :segments 8) (helix 2 0 1) :twist tau))") > 0.0


def test_a_path_that_crosses_itself_counts_once(number: Numbers) -> None:
    cross = "[[-2 0 0] [2 0 0] [2 0 2] [0 0 2] [0 0 -2]]"
    volume = number(f"(volume (sweep (rectangle 1 1) {cross}))")
    assert volume == pytest.approx(number(f"(- (path-length {cross}) 1)"))


def test_coils_that_touch_are_joined(number: Numbers) -> None:
    coil = "(helix 1 1 3)"
    volume = number(f"(volume (sweep (circle .3) {coil}))")
    assert 0.7 < volume / number(f"(* (profile-area (circle .3)) (path-length {coil}))") < 0.8


@pytest.mark.parametrize(
    "path",
    [
        [[0, 0, 0], [1, 0, 0], [0, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0, 0.1, 0]],
        [[0, 0, 0], [1, 0, 0], [1, 0.1, 0], [0, 0.1, 0]],
        [[0, 0, 0], [2, 0, 0], [2, 0.05, 0.05], [2, 3, 0], [2.1, 3, 0.1], [0, 3, 1]],
    ],
)
def test_tight_bends_of_convex_profiles_are_joined_by_bevels(path: list[list[float]]) -> None:
    profile = shapes.on_circle(0.3, math.tau * np.arange(24) / 24)
    solid = sweep(profile, np.array(path))
    check_closed(solid)
    longest = max(math.dist(a, b) for a, b in pairwise(path))
    assert solid.volume > 0.9 * longest * shapes.area_of(profile)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(*[st.floats(-3.0, 3.0)] * 3), min_size=3, max_size=7), st.integers(3, 9))
def test_any_path_gives_a_valid_solid(points: list[tuple[float, float, float]], sides: int) -> None:
    profile = shapes.regular_polygon(sides, 0.4)
    path = np.round(points, 2)
    if (np.linalg.norm(np.diff(path, axis=0), axis=1) > 0.05).sum() < 2:
        return
    solid = sweep(profile, path)
    longest = np.linalg.norm(np.diff(path, axis=0), axis=1).max()
    total = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert 0.5 * shapes.area_of(profile) * longest - 0.5 < solid.volume < 4.0 * shapes.area_of(profile) * (total + 1.0)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(*[st.floats(-2.0, 2.0)] * 3), min_size=3, max_size=8), st.booleans())
def test_runs_that_do_not_meet_give_the_union_of_all_segments(
    points: list[tuple[float, float, float]], is_smooth: bool
) -> None:
    path = np.round(points, 2)
    if (np.linalg.norm(np.diff(path, axis=0), axis=1) < 0.05).any():
        return
    path = curves.catmull_rom(path, False, 5) if is_smooth else path
    parameters = {"profile": (shapes.rectangle(0.4, 0.2, 0.0, 4),), "path": path, "twist": 0.0, "taper": np.ones(2)}
    found = sweep_of(parameters, []).volume()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sweeping, "_runs", lambda frames, reach, folded: [(i, i + 1) for i in np.flatnonzero(~folded)])
        assert sweep_of(parameters, []).volume() == pytest.approx(found, rel=1e-5)


def test_other_profiles_may_not_fold(refuses: Refuses) -> None:
    assert "would fold" in refuses("solid", "(volume (sweep (star 5 .3 .1) [[0 0 0] [1 0 0] [1 .1 0] [0 .1 0]]))")


@pytest.mark.parametrize(
    ("name", "expression", "part"),
    [
        ("value", "(sweep (circle 1) [[0 0 0]])", "two different points"),
        ("value", "(sweep (circle 1) (polyline (circle 4) :closed #t) :twist 1)", "do not meet"),
        ("value", "(sweep (circle 1) [[0 0 0] [1 0 0]] :taper -1)", "at least 0"),
        ("solid", "(volume (sweep (list [[0 0] [1 0] [2 0]]) [[0 0 0] [1 0 0]]))", "nothing inside"),
        ("size", "(volume (sweep (circle .01 :segments 1000) (helix 9 9 100)))", "1,000,000 corners"),
        ("size", "(volume (sweep (circle .01 :segments 3) (helix 9 9 500)))", "20,000 points"),
        ("size", "(volume (sweep (circle .3) (helix .2 1 3)))", "folds"),
    ],
)
def test_wrong_sweeps(refuses: Refuses, name: str, expression: str, part: str) -> None:
    assert part in refuses(name, expression)


# --- lofts -----------------------------------------------------------------------------------------------------------


def test_equal_profiles_make_an_extrusion(number: Numbers) -> None:
    profile = '(text-outline "A")'
    loft = number(f"(volume (loft (list {profile} {profile}) :heights [0 2]))")
    assert loft == pytest.approx(number(f"(volume (extrude {profile} 2))"), rel=1e-6)


def test_a_frustum(number: Numbers) -> None:
    assert number("(volume (loft (list (rectangle 2 2) (rectangle 1 1)) :heights [0 3]))") == pytest.approx(7.0)


def test_a_cone_of_different_counts(number: Numbers) -> None:
    volume = number("(volume (loft (list (circle 2 :segments 100) (circle 1 :segments 64)) :heights [0 3]))")
    assert volume == pytest.approx(7.0 * math.pi, rel=5e-3)


def test_corners_are_kept_where_counts_differ(array: Arrays) -> None:
    sizes = array("(compute-shape-sizes (loft (list (rectangle 4 1) (circle .3))))")
    assert np.allclose(sizes, [4.0, 1.0, 1.0])


def test_poses_of_profiles(number: Numbers, array: Arrays) -> None:
    bend = "(loft (list (rectangle 1 1) (rectangle 1 1)) :poses (list (identity-pose) {}))"
    assert number(f"(volume {bend.format('(translate [0 0 -2])')})") == pytest.approx(2.0)
    sizes = array(f"(compute-shape-sizes {bend.format('(@ (translate [3 0 3]) (rotate (/ pi 2) [0 1 0]))')})")
    assert np.allclose(sizes, [3.5, 1.0, 3.5])


@pytest.mark.parametrize(
    ("name", "expression", "part"),
    [
        ("value", "(loft (list (circle 1)))", "at least two profiles"),
        ("value", "(loft (list (circle 1) (circle 1)) :heights [1 0])", "increasing"),
        ("value", "(loft (list (circle 1) (circle 1)) :heights [1 2 3])", "each of 2 profiles, got 3"),
        ("value", "(loft (list (circle 1) (circle 1)) :heights [1 2] :poses (list))", "not both"),
        ("solid", "(volume (loft (list (circle 1) (list (circle 1) (circle .5)))))", "equal numbers of contours, got 1, 2"),
        ("solid", "(volume (loft (list (circle 1) (list (ref (profile-difference (circle 2) (circle 1)) 1)))))", "the same way"),
        ("solid", "(volume (loft (list (list [[0 0] [0 1] [1 0]]) (list [[0 0] [0 1] [1 0]]))))", "nothing inside"),
    ],
)  # fmt: skip
def test_wrong_lofts(refuses: Refuses, name: str, expression: str, part: str) -> None:
    assert part in refuses(name, expression)


# --- height fields ---------------------------------------------------------------------------------------------------


def test_a_height_field_of_an_array(number: Numbers, array: Arrays) -> None:
    field = "(heightfield [[1 2 3] [1 2 3]] :size [4 2] :base 0)"
    assert number(f"(volume {field})") == pytest.approx(16.0)
    assert np.allclose(array(f"(compute-shape-max {field})"), [2, 3, 1])
    assert np.allclose(array(f"(compute-shape-min {field})"), [-2, 0, -1])


def test_a_height_field_of_a_function(number: Numbers) -> None:
    volume = number("(volume (heightfield (lambda (x z) (+ (* x x) z)) :size 2 :base -2 :segments 40))")
    assert volume == pytest.approx(4.0 * (2.0 + 1.0 / 3.0), rel=2e-3)


def test_the_base_is_below(number: Numbers, refuses: Refuses) -> None:
    assert number("(volume (heightfield [[1 1] [1 1]] :size 2))") == pytest.approx(0.4)
    assert "lowest height 1, got 1" in refuses("value", "(heightfield [[1 1] [1 1]] :base 1)")


@pytest.mark.parametrize(
    ("name", "expression", "part"),
    [
        ("value", "(heightfield [1 2 3])", "two rows"),
        ("value", "(heightfield [[1 2]])", "two rows"),
        ("value", "(heightfield [[1 2] [3 4]] :size 0)", "positive"),
        ("type", '(heightfield (lambda (x z) "high"))', "returns numbers"),
        ("size", "(heightfield (zeros '(2000 2000)))", "1,000,000"),
    ],
)
def test_wrong_height_fields(refuses: Refuses, name: str, expression: str, part: str) -> None:
    assert part in refuses(name, expression)


# --- noise -----------------------------------------------------------------------------------------------------------


@settings(max_examples=100, deadline=None)
@given(st.tuples(*[st.floats(-1e6, 1e6)] * 3), st.integers(0, 5))
def test_noise_of_a_point_is_that_of_arrays(point: tuple[float, float, float], seed: int) -> None:
    assert random._noise_at(list(point), seed) == random._gradient_noise(np.array([point]), seed)[0]


def test_noise_is_the_same_everywhere(number: Numbers) -> None:
    assert number("(noise [.5 .25])") == 0.456787109375
    assert number("(noise [-3.75 12.5 .125] :seed 7)") == pytest.approx(0.2325657531619072, abs=1e-15)


def test_noise_is_smooth_and_bounded(array: Arrays) -> None:
    line = array("(noise (stack (list (linspace 0 20 4001) (full 4001 .3)) :axis 1))")
    assert np.abs(np.diff(line)).max() < 0.02
    assert 0.3 < np.abs(line).max() <= 1.0
    assert np.allclose(array("(noise [[1 2 3] [-4 0 7]])"), 0.0)


def test_fractal_noise(number: Numbers, array: Arrays) -> None:
    found = value("(fbm [[.5 .25] [.1 .2]] :octaves 3)")
    assert np.allclose(found, [number("(fbm [.5 .25] :octaves 3)"), number("(fbm [.1 .2] :octaves 3)")])
    assert number("(fbm [.3 .4] :octaves 1)") == number("(noise [.3 .4])")
    grid = value("(fbm (zeros '(4 5 2)))")
    assert isinstance(grid, Array)
    assert grid.data.shape == (4, 5)


def test_smoothstep(array: Arrays) -> None:
    assert np.allclose(array("(smoothstep 1 3 [0 1 1.5 2 3 9])"), [0, 0, 0.15625, 0.5, 1, 1])
    assert np.allclose(array("(smoothstep 3 1 [0 2 4])"), [1, 0.5, 0])


@pytest.mark.parametrize(
    "expression",
    ["(noise [1 2 3 4])", "(noise nan)", "(noise [.5] :seed -1)", "(fbm 1 :octaves 0)", "(smoothstep 1 1 0)"],
)
def test_wrong_noise(refuses: Refuses, expression: str) -> None:
    assert "expects" in refuses("value", expression)
