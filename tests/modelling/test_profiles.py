"""Profiles: shapes, SVG paths, booleans, offsets and transforms."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import scenelang as sl
from scenelang.interpreter.scene.modelling import computing
from scenelang.interpreter.scene.modelling import contours as shapes

FloatArray = npt.NDArray[np.float64]
Arrays = Callable[[str], FloatArray]
Contours = Callable[[str], list[FloatArray]]
Numbers = Callable[[str], float]
Refuses = Callable[[str, str], str]


def polygon_area(sides: int, radius: float = 1.0) -> float:
    return sides / 2.0 * radius**2 * math.sin(math.tau / sides)


@pytest.mark.parametrize(
    ("expression", "area"),
    [
        ("(circle 2)", polygon_area(64, 2.0)),
        ("(circle 2 :segments 1000)", polygon_area(1000, 2.0)),
        ("(rectangle 3 2)", 6.0),
        ("(rectangle 3 2 :radius .5 :segments 64)", 6.0 - 1.0 + polygon_area(64, 0.5)),
        ("(rectangle 2 2 :radius 1)", polygon_area(64)),
        ("(regular-polygon 6 1)", polygon_area(6)),
        ("(star 5 1 .5)", 5.0 * 0.5 * math.sin(math.pi / 5.0)),
        ("(polygon [[0 0] [0 2] [3 0]])", 3.0),
        ("(concatenate [[0 0]] (arc 1 0 (/ pi 2)))", polygon_area(64) / 4.0),
        ("(concatenate (arc 2 0 pi) (arc 1 pi 0))", polygon_area(64, 2.0) / 2.0 - polygon_area(64) / 2.0),
        ("(list [[0 0] [4 0] [4 4] [0 4]] [[1 1] [1 2] [2 2] [2 1]])", 15.0),
        ("[[[0 0] [1 0] [1 1]] [[2 0] [3 0] [3 1]]]", 1.0),
        ("(profile-union (circle 1) (+ (rectangle 2 2) [5 0]))", polygon_area(64) + 4.0),
        ("(profile-difference (rectangle 2 2) (rectangle 1 1) (+ (rectangle 2 2) [1 0]))", 1.5),
        ("(profile-intersection (rectangle 2 2) (+ (rectangle 2 2) [1 1]))", 1.0),
        ("(offset-profile (rectangle 2 2) .5 :join :miter)", 9.0),
        ("(offset-profile (rectangle 2 2) .5)", 8.0 + polygon_area(64, 0.5)),
        ("(offset-profile (rectangle 2 2) -.5)", 1.0),
        ("(offset-profile (profile-difference (rectangle 4 4) (rectangle 2 2)) .5 :join :miter)", 24.0),
        ("(transform-profile (rectangle 2 1) :scale [2 -3] :rotate 1 :move [5 6])", 12.0),
        ("(transform-profile (text-outline \"o\") :scale -2)", None),
    ],
)  # fmt: skip
def test_areas(number: Numbers, expression: str, area: float | None) -> None:
    if area is None:
        area = 4.0 * number('(profile-area (text-outline "o"))')
    assert number(f"(profile-area {expression})") == pytest.approx(area, rel=2e-5)


def test_shapes_are_counter_clockwise_and_start_where_they_should(array: Arrays) -> None:
    assert np.allclose(array("(circle 3)")[0], [3.0, 0.0])
    assert np.allclose(array("(regular-polygon 5 3)")[0], [0.0, 3.0])
    assert np.allclose(array("(star 5 3 1)")[0], [0.0, 3.0])
    for expression in ("(spline [[0 0] [0 1] [1 1] [1 0]])", "(polygon [[0 0] [0 1] [1 1]])"):
        assert shapes.area_of(array(expression)) > 0.0


def test_a_spline_goes_through_its_points(array: Arrays) -> None:
    points = np.array([[0, 0], [2, 0], [3, 1], [1, 2]])
    curve = array("(spline [[0 0] [2 0] [3 1] [1 2]] :segments 10)")
    assert np.allclose(curve[::10], points)
    assert len(curve) == 40


# --- SVG -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("data", "area"),
    [
        ("M0 0 H4 V-2 H0 Z", 8.0),
        ("m1,1h4v2h-4z", 8.0),
        ("M0 0L2 0 2 2 0 2", 4.0),
        ("M0 0 2 0 2 2 0 2z m5 0 l1 0 0 1 -1 0z", 5.0),
        ("M-1 0A1 1 0 0 1 1 0A1 1 0 0 1 -1 0Z", math.pi),
        ("M-1 0a1 1 0 1\n1 2 0a1 1 0 1 1-2 0", math.pi),
        ("M-1.7320508 -1A2 1 30 0 1 1.7320508 1A2 1 30 1 1 -1.7320508 -1Z", 2.0 * math.pi),
        ("M1 0A1 1 0 1 1 0 -1L0 0Z", math.pi * 3.0 / 4.0),
        ("M0 0 Q1 2 2 0 T4 0 V-3 H0Z", 12.0),
        ("M0 0C0 1 1 1 1 0S2 -1 2 0L2 -5 0 -5z", 10.0),
    ],
)
def test_commands_of_svg(number: Numbers, data: str, area: float) -> None:
    found = number(f'(profile-area (svg-path "{data}" :tolerance .00001))'.replace("\n", " "))
    assert found == pytest.approx(area, rel=2e-5)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_arcs_of_svg_keep_the_tolerance(contours: Contours, tolerance: float) -> None:
    """A cubic curve for each quarter is 3e-4 radii off."""
    (contour,) = contours(f'(svg-path "M-2 0A2 1 0 0 1 2 0A2 1 0 1 1 -2 0Z" :tolerance {tolerance:.9f})')
    for points in (contour, (contour + np.roll(contour, -1, axis=0)) / 2.0):
        assert np.abs(np.linalg.norm(points / [2.0, 1.0], axis=1) - 1.0).max() <= tolerance + 1e-8


def test_arcs_of_svg_without_a_radius_are_lines(number: Numbers) -> None:
    assert number('(profile-area (svg-path "M0 0 A0 1 0 0 1 2 0 V2 H0Z"))') == pytest.approx(4.0)


def test_arcs_of_svg_that_need_too_many_points_are_refused(refuses: Refuses) -> None:
    assert "too many points" in refuses("value", '(svg-path "M-1 0A1 1 0 0 1 1 0Z" :tolerance 1e-17)')


def test_y_of_svg_is_turned_upwards(contours: Contours) -> None:
    (contour,) = contours('(svg-path "M0 0 L4 0 L4 2 Z")')
    assert contour[:, 1].min() == -2.0
    assert contour[:, 1].max() == 0.0


def test_fill_rules(number: Numbers) -> None:
    nested = '"M0 0h4v4h-4z M1 1h2v2h-2z"'
    assert number(f"(profile-area (svg-path {nested}))") == pytest.approx(16.0)
    assert number(f"(profile-area (svg-path {nested} :fill :even-odd))") == pytest.approx(12.0)
    opposite = '"M0 0h4v4h-4z M1 1v2h2v-2z"'
    assert number(f"(profile-area (svg-path {opposite}))") == pytest.approx(12.0)


@pytest.mark.parametrize("data", ["M", "M0 0 A1 1", "L", "M0 0 C1 2", "M0 0 L1e999 0 0 1", "hello", "M0 0 L1 1 \u0661"])
def test_what_is_no_path_is_an_error(refuses: Refuses, data: str) -> None:
    assert "`svg-path`" in refuses("value", f'(svg-path "{data}")')


def test_svg_of_nothing_is_empty(contours: Contours) -> None:
    assert contours('(svg-path "")') == []
    assert contours('(svg-path "M0 0 L1 1")') == []


# --- operations ------------------------------------------------------------------------------------------------------


def test_results_have_outer_contours_counter_clockwise(contours: Contours) -> None:
    found = contours("(profile-difference (circle 2) (circle 1))")
    assert sorted(round(shapes.area_of(contour), 3) for contour in found) == [-3.137, 12.546]


def test_nothing_may_remain(contours: Contours, refuses: Refuses) -> None:
    assert contours("(profile-difference (circle 1) (circle 2))") == []
    assert contours("(offset-profile (rectangle 1 1) -2)") == []
    assert "empty profile" in refuses("value", "(extrude (profile-difference (circle 1) (circle 2)) 1)")


def test_transforms_keep_what_they_are_given(array: Arrays, contours: Contours) -> None:
    turned = array("(transform-profile [[1 0] [2 0] [2 1]] :rotate (/ pi 2) :move [0 5])")
    assert np.allclose(turned, [[0, 6], [0, 7], [-1, 7]])
    assert len(contours("(transform-profile (list (circle 1) (circle 2)) :scale 2)")) == 2
    assert np.allclose(
        array("(+ (* (rectangle 2 2) 2) [1 0])"), array("(transform-profile (rectangle 2 2) :scale 2 :move [1 0])")
    )


@settings(max_examples=30, deadline=None)
@given(st.integers(3, 12), st.floats(0.3, 3.0), st.floats(0.05, 0.9))
def test_an_offset_there_and_back_gives_the_same(sides: int, radius: float, distance: float) -> None:
    shape = (shapes.regular_polygon(sides, radius),)
    grown = shapes.offset(shape, distance, "Round", 256)
    back = shapes.offset(grown, -distance, "Round", 256)
    areas = [sum(map(shapes.area_of, each)) for each in (shape, grown, back)]
    perimeter = sides * 2.0 * radius * math.sin(math.pi / sides)
    assert areas[1] == pytest.approx(areas[0] + perimeter * distance + math.pi * distance**2, rel=1e-3)
    assert areas[2] == pytest.approx(areas[0], rel=1e-3)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.0, 3.0), st.floats(0.2, 2.0), st.integers(3, 40))
def test_areas_of_booleans_add_up(shift: float, radius: float, sides: int) -> None:
    one = (shapes.regular_polygon(sides, 1.0),)
    other = (shapes.regular_polygon(5, radius) + np.array([shift, 0.1]),)
    area = {
        kind: sum(map(shapes.area_of, shapes.combined("test", kind, [one, other])))
        for kind in ("Add", "Subtract", "Intersect")
    }
    first, second = (sum(map(shapes.area_of, each)) for each in (one, other))
    assert area["Add"] + area["Intersect"] == pytest.approx(first + second, rel=1e-6)
    assert area["Subtract"] == pytest.approx(first - area["Intersect"], rel=1e-6, abs=1e-6)


# --- errors ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "part"),
    [
        ("(circle 0)", "positive number for the radius"),
        ("(circle 1 :segments 2)", "3 to 1,024"),
        ("(rectangle 2 2 :radius 1.5)", "half of a side"),
        ("(regular-polygon 2 1)", "sides"),
        ("(star 1 1 1)", "points"),
        ("(arc 1 0 7)", "full turn"),
        ("(spline [[0 0] [1 1]])", "three different points"),
        ("(spline [[0 0] [1 1] [0 0]])", "three different points"),
        ("(polygon [[0 0 0] [1 1 1] [1 0 0]])", "[x y]"),
        ("(extrude [[0 0] [1 1]] 1)", "a profile"),
        ("(extrude 5 1)", "a profile"),
        ("(profile-area (list (circle 1) 5))", "a profile"),
        ("(offset-profile (circle 1) 1 :join :sharp)", "`:round`, `:miter`, `:square`"),
        ("(transform-profile (circle 1) :scale 0)", "without 0"),
        ("(transform-profile (circle 1) :move [1 2 3])", "a number or two"),
        ("(profile-area (* (circle 1) 1e300))", "coordinates below 1,000,000,000,000"),
        ("(svg-path \"M0 0\" :fill :odd)", "`:nonzero`, `:even-odd`"),
    ],
)  # fmt: skip
def test_wrong_use(refuses: Refuses, expression: str, part: str) -> None:
    assert part in refuses("value", expression)


def test_profiles_that_would_take_too_long_are_errors(refuses: Refuses) -> None:
    lines = "(map (lambda (i) (+ (rectangle {}) [{} {}])) (iota 4500))"
    fence = f"(append {lines.format('900 .01', 0, '(* i .1)')} {lines.format('.01 900', '(* i .1)', 0)})"
    assert "crossings" in refuses("size", f"(apply profile-union {fence})")


def test_a_bound_of_crossings() -> None:
    lines = [shapes.rectangle(1000.0, 0.01, 0.0, 4) + np.array([0.0, i]) for i in range(100)]
    columns = [contour[:, ::-1].copy() for contour in lines]
    assert shapes.check_crossings("test", lines) < 1000
    assert shapes.check_crossings("test", [*lines, *columns]) >= 10_000


def test_points_behind_the_end_of_a_list_are_refused() -> None:
    with pytest.raises(sl.SceneError, match="`polygon` expects a proper list, got one that ends in 5"):
        sl.evaluate('(bind "m" (lambda () (extrude (polygon (cons [0 0] (cons [1 1] (cons [2 4] 5)))) 1)))')


# --- parts that lie apart --------------------------------------------------------------------------------------------


def box_at(x: float, y: float, size: float = 1.0) -> npt.NDArray[np.float64]:
    return np.array([[x, y], [x + size, y], [x + size, y + size], [x, y + size]])


def test_contours_are_taken_apart_where_straight_cuts_are() -> None:
    ring, hole, right, above = box_at(0, 0, 4), box_at(1, 1, 2)[::-1], box_at(5, 0), box_at(0, 6)
    touching, over = box_at(4, 0), box_at(3, 3, 2)
    assert [len(group) for group in shapes.apart([right, ring, above, hole])] == [1, 2, 1]
    assert [len(group) for group in shapes.apart([ring, touching, above])] == [2, 1]
    assert [len(group) for group in shapes.apart([ring, over])] == [2]
    assert shapes.apart([]) == []
    pinwheel = [np.add(a, 0.5) for a in (box_at(0, 0), box_at(2, -0.5), box_at(2.5, 2), box_at(0.5, 2.5))]
    assert sum(map(len, shapes.apart(pinwheel))) == 4


def test_letters_are_extruded_one_by_one(monkeypatch: pytest.MonkeyPatch, number: Numbers) -> None:
    """Manifold's time for a profile grows with the square of its contours."""
    taken: list[int] = []
    section_of = computing.section_of

    def counted(contours: Any, *rule: Any) -> Any:
        taken.append(len(contours))
        return section_of(contours, *rule)

    monkeypatch.setattr(computing, "section_of", counted)
    monkeypatch.setattr(computing.stored, "load", lambda digest: None)  # an earlier run kept it on disk
    words = '"Handgloves and quick brown foxes 0123456789" :size 3.25'
    volume = sl.evaluate(f'(bind "it" (lambda () (text {words} :depth 2)))').measure().volume
    assert volume == pytest.approx(2.0 * number(f"(profile-area (text-outline {words}))"))
    assert len(taken) > 35
    assert max(taken) <= 4
