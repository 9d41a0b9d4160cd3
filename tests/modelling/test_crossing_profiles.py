"""Profiles that cross themselves: what is inside is what they wind around, or by the even-odd rule where that is asked.

The oracles are exact areas (``winding``), closed forms, and OpenSCAD itself where it is installed.
"""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

import pytest
import trimesh
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from searching import many
from support import value
from winding import RULES, Points, crosses, is_simple, moment, signed_area

import scenelang as sl
from scenelang.backends.openscad.converting import converted
from scenelang.grammar.datum import Source
from scenelang.session.session import Options, Session

NEAR = {"rel": 2e-6, "abs": 2e-6}  # profiles have 8 digits
TURN = 16 * math.sin(math.tau / 16)  # of a lathe of 16 sides, instead of tau
SQUARE = "[[0 0] [2 0] [2 2] [0 2]]"

# --- profiles --------------------------------------------------------------------------------------------------------


def star_polygon(sides: int, step: int, radius: float = 1.0, x: float = 2.0) -> Points:
    """The corners of {sides/step} around [x 0]; clockwise if ``step`` is negative."""
    angles = [math.tau * step * k / sides + 0.3 for k in range(sides)]
    return [(x + radius * math.cos(a), radius * math.sin(a)) for a in angles]


def figure_eight(across: int, upwards: int) -> Points:
    """A curve of Lissajous, whose lobes go around in both directions; it crosses itself also at corners."""
    angles = [math.tau * (k + 0.4) / 36 for k in range(36)]
    return [(2.0 + math.sin(across * a), math.sin(upwards * a)) for a in angles]


STARS = [(n, k) for n in range(5, 13) for k in range(2, (n + 1) // 2) if math.gcd(n, k) == 1]
PROFILES: dict[str, Points] = {
    "bow": [(0, 0), (2, 2), (2, 0), (0, 2)],
    "bow turned": [(0, 2), (2, 0), (2, 2), (0, 0)],
    "hook": [(0, 0), (4, 0), (4, 3), (1, 3), (1, 1), (3, 1), (3, 4), (0, 4)],
    "twice": [(0, 0), (3, 0), (3, 3), (0, 3), (0, 0), (2, 0), (2, 2), (0, 2)],
    **{f"eight {p}:{q}": figure_eight(p, q) for p, q in ((1, 2), (1, 4), (2, 3), (3, 4))},
    **{f"{n}/{k * sign}": star_polygon(n, k * sign) for n, k in STARS for sign in (1, -1)},
}


def written(contours: Iterable[Points]) -> str:
    texts = [f"[{' '.join(f'[{x!r} {y!r}]' for x, y in contour)}]" for contour in contours]
    return texts[0] if len(texts) == 1 else f"(list {' '.join(texts)})"


def spelled(points: Points) -> str:
    """A contour in OpenSCAD."""
    return f"[{', '.join(f'[{x!r}, {y!r}]' for x, y in points)}]"


def number(expression: str) -> float:
    return float(value(expression))


def volume_of(program: str) -> float:
    return sl.evaluate(converted(program)[0]).measure().volume


def warnings(expression: str) -> list[str]:
    result = Session(Options()).evaluate(Source("<test>", f'(bind "it" (lambda () {expression}))'))
    return [d.message for d in result.diagnostics if d.code == "W627"]


EVERYWHERE = {
    "area": "(profile-area {p}{f})",
    "extrude": "(volume (extrude {p} 1{f}))",
    "twisted": "(volume (extrude {p} 1 :twist 1e-9 :slices 2{f}))",
    "sweep": "(volume (sweep {p} [[0 0 0] [0 0 .5] [0 0 1]]{f}))",
    "union": "(profile-area (profile-union {p}{f}))",
    "in a square": "(profile-area (profile-intersection {p} (rectangle 99 99){f}))",
    "around": "(- 9801 (profile-area (profile-difference (rectangle 99 99) {p}{f})))",
    "offset": "(profile-area (offset-profile (offset-profile {p} 1e-7 :join :miter{f}) -1e-7 :join :miter))",
    "no offset": "(profile-area (offset-profile {p} 0{f}))",
    "polygon": "(profile-area (polygon {p}){f})",
    "moved": "(profile-area (transform-profile {p} :scale [-1 1] :rotate 1){f})",
}  # fmt: skip
CELLS = [(name, way, rule) for name in PROFILES for way in EVERYWHERE for rule in (None, *RULES)]


@pytest.mark.parametrize(("name", "way", "rule"), CELLS)
@pytest.mark.sampled(12)
def test_every_operation_has_the_area_inside(name: str, way: str, rule: str | None) -> None:
    points = PROFILES[name]
    expression = EVERYWHERE[way].format(p=written([points]), f=f" :fill :{rule}" if rule else "")
    assert number(expression) == pytest.approx(moment([points], RULES[rule or "nonzero"]), **NEAR)


@pytest.mark.parametrize("rule", [None, *RULES])
@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.sampled(6)
def test_a_lathe_has_the_volume_of_the_rings(name: str, rule: str | None) -> None:
    """Pappus's theorem, for a polygon of 16 sides."""
    found = number(f"(volume (lathe {written([PROFILES[name]])} :segments 16{f' :fill :{rule}' if rule else ''}))")
    assert found == pytest.approx(TURN * moment([PROFILES[name]], RULES[rule or "nonzero"], lambda x: x), **NEAR)


@pytest.mark.parametrize(("n", "k"), STARS)
def test_offset_stars_are_stars(n: int, k: int) -> None:
    """All sides of {n/k} are at one distance from its middle, which grows by that of the offset."""
    points, apothem = star_polygon(n, k), math.cos(math.pi * k / n)
    for distance in (0.2, -0.5 * apothem):
        found = number(f"(profile-area (offset-profile {written([points])} {distance} :join :miter :limit 99))")
        area = moment([points], RULES["nonzero"]) * ((apothem + distance) / apothem) ** 2
        assert found == pytest.approx(area, rel=1e-5)


def test_a_loft_wants_the_outline() -> None:
    bow = written([PROFILES["bow"]])
    with pytest.raises(sl.SceneError, match=r"crosses itself at \[1 1\]"):
        number(f"(volume (loft (list {bow} {bow})))")
    outlines = f"(list (profile-union {bow}) (profile-union {bow}))"
    assert number(f"(volume (loft {outlines} :heights [0 3]))") == pytest.approx(6.0)


# --- several contours ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("contours", "nonzero", "even_odd"),
    [
        (f"(list {SQUARE} (+ {SQUARE} [1 1]))", 7.0, 6.0),
        (f"(list {SQUARE} (* {SQUARE} .5))", 4.0, 3.0),
        (f"(list {SQUARE} (+ [[0 0] [0 1] [1 1] [1 0]] [.5 .5]))", 3.0, 3.0),
        (f"(list {SQUARE} [[1 1] [1 3] [3 3] [3 1]])", 6.0, 6.0),
        (f"(list {SQUARE} {SQUARE})", 4.0, None),
        ("(list [[0 0] [2 2] [2 0] [0 2]] (+ [[0 0] [2 2] [2 0] [0 2]] [5 0]))", 4.0, 4.0),
    ],
)
def test_contours_overlap_or_are_holes(contours: str, nonzero: float, even_odd: float | None) -> None:
    for way in ("area", "extrude", "twisted", "sweep", "union", "in a square"):
        assert number(EVERYWHERE[way].format(p=contours, f="")) == pytest.approx(nonzero), way
        if even_odd is not None:
            assert number(EVERYWHERE[way].format(p=contours, f=" :fill :even-odd")) == pytest.approx(even_odd), way


GRID = st.tuples(st.integers(-4, 4), st.integers(-4, 4))
CONTOURS = st.lists(GRID, min_size=3, max_size=9)


def check_random(contours: list[Points], rule: str | None, ways: Iterable[str]) -> None:
    if len(contours) == 1 and signed_area(contours[0]) < 0:
        contours = [contours[0][::-1]]
    expected = moment(contours, RULES[rule or "nonzero"])
    assume(expected > 0.0)
    for way in ways:
        found = number(EVERYWHERE[way].format(p=written(contours), f=f" :fill :{rule}" if rule else ""))
        assert found == pytest.approx(expected, abs=1e-5), way


RANDOM = given(st.lists(CONTOURS, min_size=1, max_size=2), st.sampled_from([None, *RULES]))


@settings(max_examples=many(300), deadline=None)
@RANDOM
def test_random_profiles(contours: list[Points], rule: str | None) -> None:
    check_random(contours, rule, ("area", "extrude", "union"))


@settings(max_examples=many(300), deadline=None)
@RANDOM
@example([[(0, 0), (0, -2), (-2, -2), (1, -1), (-2, -2)]], None)
@example([[(-4, 0), (-2, -2), (3, 4), (-4, -4)], [(-2, -3), (-2, -2), (-3, -1)]], None)
def test_random_sweeps(contours: list[Points], rule: str | None) -> None:
    """What is inside may be several contours that touch along edges."""
    check_random(contours, rule, ("sweep", "twisted"))


# --- the finding -----------------------------------------------------------------------------------------------------


@settings(max_examples=many(300), deadline=None)
@given(st.lists(GRID, min_size=4, max_size=9))
@example(PROFILES["bow"])
@example(PROFILES["twice"])
@example([(0, 0), (1, 1), (2, 2), (2, 0), (1, 1), (0, 2)])
def test_there_is_a_finding_exactly_for_profiles_that_cross(points: Points) -> None:
    """Also where the crossing is at a corner; what only touches itself may have one or not."""
    area, other = (moment([points], rule) for rule in RULES.values())
    assume(area > 0.0)
    found = warnings(f"(extrude {written([points])} 1)")
    assert len(found) <= 1
    if crosses(points) or area != other:
        assert found
    if is_simple(points):
        assert not found
    assert warnings(f"(extrude {written([points])} 1 :fill :nonzero)") == []


@pytest.mark.parametrize("operation", ["(extrude {} 1)", "(lathe {})", "(sweep {} [[0 0 0] [0 0 1]])"])
def test_the_finding_says_where(operation: str) -> None:
    builtin = operation[1:].partition(" ")[0]
    assert warnings(operation.format(written([PROFILES["bow"]]))) == [
        f"the profile of `{builtin}` crosses itself at [1 1]"
    ]


# --- fonts, SVG and OpenSCAD -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.sampled(4)
def test_paths_of_svg_wind(name: str) -> None:
    data = "M" + " L".join(f"{x!r} {-y!r}" for x, y in PROFILES[name]) + "Z"
    for fill, rule in (("", "nonzero"), (" :fill :nonzero", "nonzero"), (" :fill :even-odd", "even-odd")):
        expected = moment([PROFILES[name]], RULES[rule])
        assert number(f'(profile-area (svg-path "{data}"{fill}))') == pytest.approx(expected, **NEAR)


def test_letters_wind(tmp_path: Path) -> None:
    """Glyphs whose contours overlap, as those of variable fonts do."""
    from fontTools.fontBuilder import FontBuilder
    from fontTools.pens.ttGlyphPen import TTGlyphPen

    squares = [[(0, 0), (0, 600), (600, 600), (600, 0)], [(300, 300), (300, 900), (900, 900), (900, 300)]]
    glyphs = {}
    for name, contours in {".notdef": [], "a": squares, "b": [[(0, 0), (600, 600), (600, 0), (0, 600)]]}.items():
        pen = TTGlyphPen(None)
        for contour in contours:
            pen.moveTo(contour[0])
            for point in contour[1:]:
                pen.lineTo(point)
            pen.closePath()
        glyphs[name] = pen.glyph()
    font = FontBuilder(1000, isTTF=True)
    font.setupGlyphOrder(list(glyphs))
    font.setupCharacterMap({97: "a", 98: "b"})
    font.setupGlyf(glyphs)
    font.setupHorizontalMetrics(dict.fromkeys(glyphs, (1000, 0)))
    font.setupHorizontalHeader(ascent=900, descent=0)
    font.setupNameTable({"familyName": "Crossing", "styleName": "Regular"})
    font.setupOS2()
    font.setupPost()
    font.save(tmp_path / "a.ttf")
    for letter, area in (("a", 0.63), ("b", 0.18)):
        program = tmp_path / "a.scene"
        program.write_text(f'(bind "it" (lambda () (text "{letter}" :font "a.ttf" :depth 2)))')
        assert sl.load(program).measure().volume == pytest.approx(2.0 * area, rel=1e-5)


SCAD = {
    "extrude": "linear_extrude(1) polygon({p});",
    "twist": "linear_extrude(1, twist = 30, slices = 4) polygon({p});",
    "offset": "linear_extrude(1) offset(delta = 0.05) polygon({p});",
    "revolve": "rotate_extrude($fn = 16) polygon({p});",
    "cut": "linear_extrude(1) difference() {{ square(9, center = true); polygon({p}); }}",
    "variable": "p = {p}; q = [for (i = [0 : len(p) - 1]) p[i]]; linear_extrude(1) polygon(q);",
    "twice": "linear_extrude(1) polygon(concat({p}, [[0, 0], [2, 0], [2, 2], [0, 2]]), paths = [[for (i = [0 : len({p}) - 1]) i], [for (i = [0 : 3]) len({p}) + i]]);",
}  # fmt: skip


def test_the_bow_tie_has_the_volume_of_openscad() -> None:
    assert volume_of("linear_extrude(1) polygon([[0, 0], [2, 2], [2, 0], [0, 2]]);") == pytest.approx(2.0)


@pytest.mark.parametrize("way", ["extrude", "variable"])
@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.sampled(6)
def test_polygons_of_openscad_are_filled_by_even_and_odd(name: str, way: str) -> None:
    found = volume_of(SCAD[way].format(p=spelled(PROFILES[name])))
    assert found == pytest.approx(moment([PROFILES[name]], RULES["even-odd"]), **NEAR)


@settings(max_examples=many(200), deadline=None)
@given(CONTOURS)
def test_random_polygons_of_openscad(points: Points) -> None:
    """Unless nothing is inside, which is an error when the program runs."""
    expected = moment([points], RULES["even-odd"])
    assume(expected > 0.0)
    assert volume_of(SCAD["extrude"].format(p=spelled(points))) == pytest.approx(expected, abs=1e-5)


@pytest.mark.skipif(shutil.which("openscad") is None, reason="needs OpenSCAD")
@pytest.mark.parametrize("way", SCAD)
@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.sampled(20)
def test_volumes_are_those_that_openscad_computes(name: str, way: str, tmp_path: Path) -> None:
    program = SCAD[way].format(p=spelled(PROFILES[name]))
    given, made = tmp_path / "a.scad", tmp_path / "a.off"
    given.write_text(program)
    subprocess.run(["openscad", "-o", str(made), str(given)], check=True, timeout=600, capture_output=True)
    expected = abs(float(trimesh.load(made, process=True).volume))
    near = 1e-3 if way == "twist" else 2e-4  # slices of parts that meet overlap, which a sum over faces counts twice
    assert volume_of(program) == pytest.approx(expected, rel=near, abs=1e-4)
