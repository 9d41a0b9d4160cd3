"""Programs of OpenSCAD: they convert, check and are formatted, and their volumes are those that OpenSCAD computes."""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import trimesh
from support import calls

import scenelang as sl
from scenelang.backends.openscad.arithmetic import (
    ANY,
    INT,
    NUM,
    UNKNOWN,
    fragments_of,
    joined,
    list_of,
    random_numbers,
    vector,
)
from scenelang.backends.openscad.converting import converted, imported
from scenelang.backends.openscad.syntax import MAX_NESTING
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.formatter import format_text
from scenelang.interpreter.expand.forms import INDENTS

HERE = Path(__file__).parent
PROGRAMS = sorted((HERE / "programs").glob("*.scad"))
VOLUMES = json.loads((HERE / "volumes.json").read_text("utf-8"))


def volume(text: str) -> float:
    """The volume of a converted program's scene."""
    return sl.evaluate(text).measure().volume


def is_closed(mesh: Any) -> bool:
    """Whether a surface runs along each edge as often in one direction as in the other; it may touch itself there."""
    there = Counter(map(tuple, mesh.edges.tolist()))
    return all(count == there[b, a] for (a, b), count in there.items())


def volume_of(program: str) -> float:
    return volume(converted(program)[0])


def error(program: str) -> tuple[str, str, tuple[int, int]]:
    """The code, message and place of a program's mistake."""
    with pytest.raises(SceneError) as caught:
        converted(program)
    span = caught.value.span
    assert span is not None
    return caught.value.name, caught.value.message, span.source.position(span.start)


# --- whole programs --------------------------------------------------------------------------------------------------


def test_there_are_thirty_programs_with_a_volume() -> None:
    assert len(PROGRAMS) >= 30
    assert set(VOLUMES) == {path.stem for path in PROGRAMS}


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
@pytest.mark.sampled(4)
def test_a_program_has_the_volume_that_openscad_gives(
    path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:  # fmt: skip
    text, _ = imported(path)
    assert format_text(text, INDENTS) == text
    program = tmp_path / "a.scene"
    program.write_text(text, "utf-8")
    assert main(["check", str(program)]) == 0
    assert volume(text) == pytest.approx(VOLUMES[path.stem], rel=1e-3)
    made = tmp_path / "a.3mf"
    assert main(["export", str(program), "-o", str(made), "--solid"]) == 0
    capsys.readouterr()
    mesh = trimesh.load(made, force="mesh", process=False)  # merging vertices would join edges that only touch
    assert is_closed(mesh)
    assert abs(mesh.volume) == pytest.approx(VOLUMES[path.stem], rel=1e-3)


def test_the_scene_stands_upright() -> None:
    scene = sl.evaluate(converted("cube([1, 2, 3]);")[0])
    low, high = scene.bounds
    assert [round(float(x), 9) + 0.0 for x in (*low, *high)] == [0, 0, -2, 1, 3, 0]


# --- what becomes of parts of the language ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("program", "expected"),
    [
        ("a = 1; b = a; a = 2; cube(b);", 8),  # the last assignment counts, at the first place
        ("x = 2; module m() { x = x + 1; cube(x); } m();", 27),
        ("function f(n) = n <= 0 ? 0 : n + f(n - 1); cube([f(3), 1, 1]);", 6),
        ("f = function(x) x * 2; cube([f(3), 1, 1]);", 6),
        ("module m(a, b = 2, c) cube([a, b, is_undef(c) ? 1 : c]); m(1); translate([9, 0, 0]) m(c = 3, a = 1);", 8),
        ("for (i = [0 : 2 : 4]) translate([i * 3, 0, 0]) cube(1);", 3),
        ("for (i = [1, 2], j = [0 : i - 1]) translate([i * 5, j * 5, 0]) cube(1);", 3),
        ("cube(len([for (i = [0 : 5]) if (i % 2 == 0) i]));", 27),
        ("cube([for (i = [1 : 3]) i]);", 6),
        ("v = [1, 2, 3]; cube([v * v, 1, 1]);", 14),
        ("m = [[0, 1], [2, 0]]; cube([(m * [3, 4])[1], 1, 1]);", 6),
        ("cube([7 % 4, -7 % 4 + 5, 2 ^ 2]);", 24),
        ("cube([round(2.5), round(-2.5) + 4, ceil(0.5)]);", 3),
        ("if (0) cube(9); else if (\"a\") cube(1);", 1),
        ("difference() { cube(2); if (false) cube(1); for (i = []) cube(1); }", 8),
        ("difference() { cube(2); children_of(); } module children_of() { if (len(\"\") > 0) cube(1); }", 8),
        ("*cube(5); #cube(1); %cube(9);", 1),
        ("cube(5); !cube(1);", 1),
        ("union() { x = 2; cube(x); }", 8),
        ("let (x = 2) cube(x);", 8),
        ("square(3);", 9),
        ("linear_extrude(2) polygon([[0, 0], [0, 2], [2, 0]]);", 4),
        ("linear_extrude(2) minkowski() { square(2); square(1); }", 18),
        ("linear_extrude(1) resize2(); module resize2() offset(delta = 1) square(2);", 16),
        ("hull() { cube(1); translate([1, 0, 0]) cube(1); }", 2),
        ("minkowski() { cube(1); cube(1); }", 8),
        ("resize([2, 0, 4]) cube(1);", 8),
        ("render() cube(1);", 1),
        ("module both() children(); both() cube(2); translate([5, 0, 0]) linear_extrude(1) both() square(1);", 9),
        ("module pick() children(1); pick() { cube(1); cube(2); }", 8),
        ("assert(true, \"yes\"); echo(1); cube(1);", 1),
        ("color(\"red\") { cube(1); color(\"blue\") translate([2, 0, 0]) cube(1); }", 2),
        ("8bit = 2; cube(8bit);", 8),
        ("translate([1, 0]) cube(1);", 1),
        ("cube(1);;", 1),
        ("scale = 2; module list(length) cube(length); list(scale);", 8),
    ],
)  # fmt: skip
def test_a_part_of_the_language(program: str, expected: float) -> None:
    assert volume_of(program) == pytest.approx(expected, rel=1e-9)


def test_the_outermost_color_wins() -> None:
    text, _ = converted('color("red") color("blue") cube(1);')
    assert '(color "red")' in text
    assert "blue" not in text


def test_comments_stay() -> None:
    text, _ = converted("// Size.\nsize = 3; // mm\n/* The crate\n * of wood. */\ncube(size);")
    assert text.index("; Size.") < text.index("; mm") < text.index("; The crate") < text.index("; of wood.")


def test_what_is_left_out_is_said() -> None:
    assert [each.message for each in converted('%cube(1); cube(2); linear_extrude(1) text("a");')[1]] == [
        "objects marked `%` are left out", "`text` is drawn in DejaVu Sans, the bundled font",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("radius", "angle", "length", "expected"), [(1, 12, 2, 5), (10, 12, 2, 30), (3, 12, 2, 10), (10, 5, 0.1, 72)]
)
def test_circles_have_the_sides_of_openscad(radius: float, angle: float, length: float, expected: int) -> None:
    assert fragments_of(radius, angle, length) == expected


def test_kinds_join() -> None:
    assert joined(INT, NUM) == NUM
    assert joined(UNKNOWN, INT) == INT
    assert joined(vector(2), vector(3)) == vector(0)
    assert joined(vector(2), list_of(INT)).name == "list"
    assert joined(INT, vector(2)) == ANY


ROWS = re.findall(
    r"^\| `(.*?)` \| `(.*?)` \|", (HERE.parents[1] / "docs" / "from-openscad.md").read_text("utf-8"), re.MULTILINE
)


@pytest.mark.parametrize(("program", "expected"), ROWS)
def test_the_table_of_the_documentation(program: str, expected: str) -> None:
    text, _ = converted(program)
    assert expected in " ".join(text.split())
    assert volume(text) > 0.0


# --- mistakes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("program", "name", "message", "place"),
    [
        ("cube(", "openscad-syntax", "expected a value", (1, 6)),
        ("cube(1)", "openscad-syntax", "expected a name, got the end of the file", (1, 8)),
        ("\n  cube(1;", "openscad-syntax", "expected `)`, got `;`", (2, 9)),
        ('a = "x', "openscad-syntax", "this string is never closed", (1, 5)),
        ("/* a", "openscad-syntax", "this comment is never closed", (1, 1)),
        ("cube(1); @", "openscad-syntax", "unexpected character '@'", (1, 10)),
        ("cube(sise);", "openscad-syntax", "the variable `sise` is not defined here", (1, 6)),
        ("cub(1);", "openscad-syntax", "the module `cub` is not defined", (1, 1)),
        ("cube(sinn(1));", "openscad-syntax", "the function `sinn` is not defined", (1, 6)),
        ("a = [1].w;", "openscad-syntax", "expected `.x`, `.y` or `.z`, got `.w`", (1, 9)),
        ("include <a.scad>", "openscad-unsupported", "`include <a.scad>`: files are not read", (1, 1)),
        ('import("a.stl");', "openscad-unsupported", "`import`: no files are read", (1, 1)),
        ('surface("a.dat");', "openscad-unsupported", "`surface`: no height maps are read", (1, 1)),
        ("projection() square(1);", "openscad-unsupported", "`projection` of a flat object", (1, 1)),
        ("c = true; projection(cut = c) cube(1);", "openscad-unsupported", "`cut` that is not written out", (1, 11)),
        (
            "linear_extrude(1, twist=90, scale=[1, 2]) square(1);",
            "openscad-unsupported",
            "`twist` with a `scale` of two numbers",
            (1, 1),
        ),
        ("cube(rands(0, 1)[0]);", "openscad-syntax", "`rands` with 2 arguments", (1, 6)),
        ("union() { cube(1); square(1); }", "openscad-unsupported", "flat and solid objects together", (1, 1)),
        ("union() { !cube(1); }", "openscad-unsupported", "`!` inside of other objects", (1, 11)),
        ("x = 3;", "empty-scene", "`<text>` makes no objects", (1, 1)),
    ],
)
def test_a_mistake_has_its_place(program: str, name: str, message: str, place: tuple[int, int]) -> None:
    assert error(program) == (name, message, place)


HOSTILE: dict[str, Callable[[int], str]] = {
    "brackets": lambda n: "a = " + "(" * n + "1" + ")" * n + ";",
    "lists": lambda n: "a = " + "[" * n,
    "signs": lambda n: "a = " + "-" * n + "1;",
    "not": lambda n: "a = " + "!(" * n,
    "differences": lambda n: "a = 1" + " - 1" * n + ";",
    "indices": lambda n: "a = x" + "[0]" * n + ";",
    "blocks": lambda n: "{" * n,
    "translations": lambda n: "translate([0, 0, 1]) " * n + "cube(1);",
    "conditions": lambda n: "a = 1" + " ? 1 : 1" * n + ";",
    "if": lambda n: "if (1) " * n + "cube(1);",
    "modules": lambda n: "module m() " * n + "cube(1);",
    "for": lambda n: "a = [" + "for (i = [0 : 1]) " * n + "i];",
    "powers": lambda n: "a = 2" + " ^ 2" * n + ";",
    "blocks of a module": lambda n: "module a() " + "{" * (n // 56) + "cube(1);" + "}" * (n // 56) + " a();",
    "assignments": lambda n: "x = 1;" * n,
    "let": lambda n: "a = " + "let (b = 1) " * n + "b;",
    "functions": lambda n: "f = " + "function (x) " * n + "x;",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_twice_the_hostile_text_takes_twice_the_calls(name: str) -> None:
    def convert(count: int) -> None:
        try:
            converted(HOSTILE[name](count))
        except SceneError as found:
            assert found.span is not None  # noqa: PT017

    convert(5_000)
    few, many = (calls(lambda n=n: convert(n)) for n in (1_000, 2_000))
    assert many < 2.3 * few


def test_a_long_text_is_no_program() -> None:
    with pytest.raises(SceneError, match="more than 1,000,000"):
        converted("x = 1;" * 300_000)


def test_the_deepest_nesting_works() -> None:
    depth = MAX_NESTING // 2 - 4
    assert volume_of(f"cube({'(' * depth}2{')' * depth});") == pytest.approx(8)
    assert volume_of(f"a = 1{' + 1' * 3000}; cube([a, 1, 1]);") == pytest.approx(3001)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program, made = tmp_path / "part.scad", tmp_path / "part.scene"
    program.write_text("cube(3);\n%cube(4);\n")
    assert main(["import", str(program), "-o", str(made)]) == 0
    assert "W806" in capsys.readouterr().err
    assert volume(made.read_text()) == pytest.approx(27)
    program.write_text("cube(3);\n  sphere(")
    assert main(["import", str(program)]) == 1
    assert "part.scad:2:10" in capsys.readouterr().err
    program.write_bytes(b"cube(\xff);")
    assert main(["import", str(program)]) == 1
    assert "UTF-8" in capsys.readouterr().err
    assert main(["import", str(tmp_path / "none.scad")]) == 1
    assert "No such file" in capsys.readouterr().err


def test_other_files_are_told_all_formats(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "x.step").touch()
    assert main(["import", str(tmp_path / "x.step")]) == 1
    assert "expected .scad, .schem, .litematic, .nbt" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("program", "wanted"),
    [
        ("offset(3) square(20);", 1995.4272),
        ("offset(1) square(10);", 426.0),
        ("offset(r = 2, $fn = 10) square(20);", 1713.5232),
        ("offset(r = 5, $fn = 7) square(20);", 2610.79815),
        ("offset(r = 2, $fn = 3) square(20);", 1704.0),
        ("offset(-3) difference() { circle(20, $fn = 5); square(4, center = true); }", 1625.8072),
        ("offset(two, $fs = two / 2) polygon([[0, 0], [20, 0], [11, 13]]);", None),
        ("projection() rotate([30, 20, 0]) cube([10, 5, 3]);", 179.746770),
        ("projection(cut = true) translate([0, 0, -1]) rotate([30, 20, 0]) difference() {"
         "cube([10, 5, 30], center = true); cylinder(r = 1, h = 50, center = true, $fn = 32); }", 172.814165),
    ],
)  # fmt: skip
def test_flat_objects_have_the_areas_that_openscad_gives(program: str, wanted: float | None) -> None:
    if wanted is None:  # the number of sides is found out by the program
        wanted = volume_of("linear_extrude(3) offset(2, $fs = 1) polygon([[0, 0], [20, 0], [11, 13]]);")
    assert volume_of(f"two = 2; linear_extrude(3) {program}") == pytest.approx(wanted, rel=5e-6)


@pytest.mark.parametrize(("values", "count"), [
    ("concat(a, [[0, 9]])", 5), ("concat([[1, 2]], [[3, 4]])", 2), ("concat([[1, 2]], [3, 4])", 3), ("concat(1, [[4]])", 2),
    ("[each a, [0, 9]]", 5),
])  # fmt: skip
def test_concatenated_lists_have_all_items(values: str, count: int) -> None:
    squares = "a = [for (i = [0 : 3]) [i, i * i]];"
    assert volume_of(f"{squares} cube(len({values}));") == pytest.approx(count**3)


def test_polygons_of_concatenated_points_have_all_corners() -> None:
    program = "a = [for (i = [0 : 3]) [i, i * i]]; linear_extrude(1) polygon(concat(a, [[0, 9]]));"
    assert volume_of(program) == pytest.approx(17.5)


def test_ranges_without_a_step_rise() -> None:
    """As OpenSCAD has it: [3 : 1] is 1, 2, 3, and [0 : -1] is -1, 0."""
    assert volume_of("difference() { cube(10); for (i = [0 : -1]) translate([i, i, i]) cube(3); }") == pytest.approx(
        973
    )
    assert volume_of("v = [for (i = [3 : 1]) i]; cube([v[0], v[1], v[2]]);") == pytest.approx(6)
    assert volume_of("cube(1); for (i = [0 : 1 : -1]) translate([5, 0, 0]) cube(3);") == pytest.approx(1)


def test_balls_with_an_odd_number_of_sides_have_a_corner_towards_x() -> None:
    """As OpenSCAD's have; the volume of a union shows how it is turned."""
    text, _ = converted("sphere(1, $fn = 5);")
    assert sl.evaluate(text).bounds[:, 0] == pytest.approx([-math.cos(math.pi / 5), 1.0])
    assert volume_of("cube(1); sphere(1, $fn = 5);") == pytest.approx(3.095651, rel=1e-5)


@pytest.mark.parametrize("steps", ["[0 : 1 : -1]", "[0 : 2 : -4]", "[5 : -1 : 9]", "[0 : 1 : n]", "[0 : -n : n]"])
def test_loops_with_a_step_may_be_empty_in_a_boolean(steps: str) -> None:
    body = "translate([i, i, i]) cube(3);"
    assert volume_of(f"n = -1; difference() {{ cube(10); for (i = {steps}) {body} }}") == pytest.approx(1000)


def test_loops_with_a_step_that_certainly_run_need_no_helper() -> None:
    text, _ = converted("difference() { cube(10); for (i = [4 : -2 : -1]) translate([i, i, i]) cube(1); }")
    assert "solid-cut" not in text
    assert volume(text) == pytest.approx(997)


def test_random_numbers_with_a_seed_are_openscads() -> None:
    assert random_numbers(0, 10, 5, 42) == pytest.approx([7.96543, 1.83435, 7.79691, 5.9685, 4.45833], rel=1e-5)
    assert random_numbers(-1, 1, 3, 1) == pytest.approx([0.99437, 0.865115, -0.743751], rel=1e-5)
    assert volume_of("cube([rands(0, 10, 5, 42)[0], 1, 1]);") == pytest.approx(7.96543, rel=1e-5)


def test_random_numbers_without_a_seed_are_the_programs() -> None:
    text, warnings = converted("n = 3; v = rands(1, 2, n); cube([v[0], v[1], v[2]]);")
    assert [warning.message for warning in warnings] == [
        "`rands` draws other numbers than OpenSCAD; `--seed` changes them"
    ]
    assert 1 < volume(text) < 8
    assert sl.evaluate(text, seed=1).measure().volume != volume(text)


def test_the_moment_of_an_animation_is_a_param() -> None:
    text, warnings = converted("translate([10 * $t, 0, 0]) cube([1, 1, 1 + $t]);")
    assert "became a param" in warnings[0].message
    assert volume(text) == pytest.approx(1)
    assert sl.evaluate(text, defines={"moment": 0.5}).measure().volume == pytest.approx(1.5)


# --- turned, empty and colored objects; volumes are those of OpenSCAD 2021.01 ---------------------------------------


@pytest.mark.parametrize(
    ("program", "expected"),
    [
        ("$fn = 7, angle = -100) translate([.5, 0]) square(1);", 0.984808),  # one side
        ("$fn = 12, angle = -20) translate([.5, 0]) square(1);", 0.342020),
        ("$fn = 12, angle = 60) translate([1, 0]) circle(1, $fn = 12);", 3.0),  # two sides, from the axis on
        ("$fa = 30, angle = 50) translate([.5, 0]) square(10);", 421.324599),
        ("$fn = 7, angle = 359) translate([.5, 0]) square(1);", 5.187396),
        ("angle = 33, $fa = 3, $fs = .1) translate([-3, 0]) circle(1);", 5.416814),
        ("angle = .1, $fn = 100) translate([3, 0]) circle(1);", 0.016439),
        (") translate([-3, 0]) circle(1);", 42.797709),
    ],
)
def test_turned_profiles_have_the_sides_of_openscad(program: str, expected: float) -> None:
    assert volume_of(f"rotate_extrude({program}") == pytest.approx(expected, rel=3e-5)


@pytest.mark.parametrize(
    ("angle", "low", "high"),
    [
        (80, [-1.5, -1.4772], [-0.0868, 0]),
        (-80, [-1.5, 0], [-0.0868, 1.4772]),
        (400, [-1.5, -1.4624], [1.3514, 1.4624]),
    ],
)
def test_turned_profiles_are_where_openscad_has_them(angle: float, low: list[float], high: list[float]) -> None:
    profile = "translate([-1.5, 0]) square(1)" if angle < 360 else "translate([.5, 0]) square(1)"
    sides = 4 if angle < 360 else 7
    found = sl.evaluate(converted(f"rotate_extrude($fn = {sides}, angle = {angle}) {profile};")[0]).bounds
    assert found[:, 0] == pytest.approx([low[0], high[0]], abs=1e-3)
    assert -found[::-1, 2] == pytest.approx([low[1], high[1]], abs=1e-3)


def test_profiles_on_both_sides_of_the_axis_are_refused() -> None:
    with pytest.raises(SceneError, match="on both sides of the axis"):
        volume_of("rotate_extrude() square(1, center = true);")


@pytest.mark.parametrize(
    "program",
    [
        "cube([1, -2, 3]);", "cube(-1, center = true);", "sphere(0);", "cylinder(h = 2, r1 = 0, r2 = 0);",
        "cylinder(h = 2, r1 = -1, r2 = 1);", "linear_extrude(0) square(1);", "linear_extrude(1) square([1, 0]);",
        "linear_extrude(2) circle(-1);", "rotate_extrude(angle = 0) square(1);",
    ],
)  # fmt: skip
def test_objects_without_extent_make_nothing(program: str) -> None:
    text, warnings = converted(f"cube(2); {program}")
    assert "makes nothing, as in OpenSCAD" in warnings[0].message
    assert volume(text) == pytest.approx(8)
    assert volume_of(f"difference() {{ cube(2); {program} }}") == pytest.approx(8)
    assert volume_of(f"intersection() {{ cube(2); {program} }}") == 0


def test_sizes_that_the_program_finds_out_may_make_nothing() -> None:
    assert volume_of("module m(s) { cube(s); } m(2); m(-3); m([3, 0, 3]); m([0.5, 0.5, -1]);") == pytest.approx(8)
    assert volume_of("module m(s) cube(s, center = true); m([1, 2, 3]); m(-3);") == pytest.approx(6)
    assert volume_of("module m(r) { sphere(r); cylinder(r, r, 0); } cube(1); m(0); m(-1);") == pytest.approx(1)


@pytest.mark.parametrize(
    ("color", "look"),
    [
        ('"#f008"', '(color "#f00") :opacity 0.5333'), ('"#ff000080"', '(color "#ff0000") :opacity 0.502'),
        ('"transparent"', '(color "black") :opacity 0'), ('"#f008", 0.25', '(color "#f00") :opacity 0.25'),
        ("[1, 0, 0, 0.5], 0.25", "(rgb 255 0 0) :opacity 0.25"), ("[2, -1, 0]", "(rgb 255 0 0)"),
    ],
)  # fmt: skip
def test_colors_with_alpha_have_an_opacity(color: str, look: str) -> None:
    text, warnings = converted(f"color({color}) cube(1);")
    assert f":color {look}" in " ".join(text.split())
    assert not warnings
    assert volume(text) == pytest.approx(1)


def test_colors_of_variables_are_known_too() -> None:
    text, warnings = converted(
        'a = "#f008"; b = "red"; d = "nope"; color(a) cube(1); color(b) cube(1); color(d) cube(1);'
    )
    assert '(color "#f00") :opacity 0.5333' in text
    assert "(color b)" in text
    assert [each.message for each in warnings] == ['the color "nope" is unknown, and left out']
    assert volume(text) == pytest.approx(1)


@pytest.mark.parametrize("color", ["nope", "#ff00zz", "#12345", "#1234567"])
def test_unknown_colors_are_left_out(color: str) -> None:
    text, warnings = converted(f' color("{color}") color("red") cube(1);')
    assert [each.message for each in warnings] == [f'the color "{color}" is unknown, and left out']
    assert warnings[0].span is not None
    assert warnings[0].span.start == 1
    assert '(color "red")' in text  # as in OpenSCAD


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("assert(false) cube(1);", "assertion failed"), ("cube(1); assert(1 == 2, str(\"x\", 2));", "x2"),
        ("module m(x) { if (x < 0) assert(false, \"neg\"); cube(x); } m(-2);", "neg"),
        ("linear_extrude(1) { assert(2 < 1); square(1); }", "assertion failed"),
    ],
)  # fmt: skip
def test_assertions_are_tested_when_the_program_runs(program: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        volume_of(program)


def test_assertions_that_hold_change_nothing() -> None:
    program = "assert(1 < 2) cube(1); for (i = [1 : 2]) { assert(i < 4); translate([3 * i, 0]) cube(i); } assert(true);"
    assert volume_of(program) == pytest.approx(10)
    text, warnings = converted("assert(search(1, [1])) cube(1);")
    assert warnings[0].message == "this assertion is not tested: the function `search`"
    assert volume(text) == pytest.approx(1)


@pytest.mark.parametrize(
    ("settings", "expected"), [("$fs = 0", 77.966866), ("$fa = 0", 76.536684), ("$fa = -1", 76.536684)]
)
def test_the_least_angle_and_length_are_a_hundredth(settings: str, expected: float) -> None:
    """As OpenSCAD has it, with a warning; nothing divides by zero."""
    assert volume_of(f"linear_extrude(1) circle(5, {settings});") == pytest.approx(expected, rel=1e-6)
    late = f"module m(zero) linear_extrude(1) circle(5, {settings.split()[0]} = zero); m(0);"
    assert volume_of(late) == pytest.approx(expected, rel=1e-6)
    assert volume_of(f"rotate_extrude(angle = 50, {settings}) square(1);") > 0
