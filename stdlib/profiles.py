"""Profiles: contours of points in the plane of x and y, to extrude, turn, sweep and loft (docs/solids.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime.show import described, show
from scenelang.interpreter.runtime.types import Registry
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.modelling import contours as shapes
from scenelang.interpreter.scene.modelling import curves
from scenelang.interpreter.scene.modelling.contours import Contours
from scenelang.interpreter.scene.modelling.operations import SEGMENTS
from scenelang.interpreter.scene.modelling.outlines import TextStyle, Typeface, bundled, text_outline
from scenelang.interpreter.values.values import NIL, Keyword, MutableList, Pair, Vector, make_list
from scenelang.stdlib.operands import Numpy, from_numpy, items, to_numpy

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("profiles")
define = registry.define

MAX_SEGMENTS = 1024  # sides of a full circle
MAX_POINTS = 100_000  # of a profile or path
_MAX_LENGTH = 1e12  # so that products of lengths are exact enough
_JOINS = {"round": "Round", "miter": "Miter", "square": "Square"}
_RULES = {"nonzero": shapes.NON_ZERO, "even-odd": shapes.EVEN_ODD}
LEFT, _NONZERO, _ROUND = Keyword("left"), Keyword("nonzero"), Keyword("round")
FILL = "[:fill::Keyword]"
_ALIGNMENTS = {"left": 0.0, "center": 0.5, "right": 1.0}


# --- arguments -------------------------------------------------------------------------------------------------------


def segment_count(name: str, value: int, least: int = 3) -> int:
    """Return ``value`` if it is a valid number of segments, at least ``least``.

    Raises SceneError("value"), which names the builtin ``name``, for a number that is too small or too large.
    """
    if not least <= value <= MAX_SEGMENTS:
        raise SceneError("value", f"`{name}` expects {least} to {MAX_SEGMENTS:,} :segments, got {value}")
    return value


def positive(name: str, role: str, value: Any) -> float:
    """Return ``value`` as a positive float.

    Parameters
    ----------
    name, role
        Builtin and argument that the error message names.

    Raises
    ------
    SceneError
        "value" if it is not positive, nan, or too large.
    """
    if value >= _MAX_LENGTH:
        raise _too_large(name, role, value)
    if not value > 0.0:
        raise SceneError("value", f"`{name}` expects a positive number for {role}, got {show(value, 40)}")
    return float(value)


def finite(name: str, role: str, value: Any) -> float:
    """Return ``value`` as a finite float.

    Parameters
    ----------
    name, role
        Builtin and argument that the error message names.

    Raises
    ------
    SceneError
        "value" if it is infinite, nan, or too large.
    """
    if math.isfinite(value) and abs(value) >= _MAX_LENGTH:
        raise _too_large(name, role, value)
    if not -_MAX_LENGTH < value < _MAX_LENGTH:
        raise SceneError("value", f"`{name}` expects a finite number for {role}, got {show(value, 40)}")
    return float(value)


def _too_large(name: str, role: str, value: Any) -> SceneError:
    """Return the error for a length that is too large; ``role`` names the argument."""
    return SceneError("value", f"`{name}` expects a number below {_MAX_LENGTH:,.0f} for {role}, got {show(value, 40)}")


def one_or_two(rt: Runtime, name: str, role: str, value: Any) -> tuple[float, float]:
    """Return one number or two as two; ``role`` names the argument in errors."""
    if type(value) in (int, float):
        return finite(name, role, value), float(value)
    numbers = to_numpy(rt, value, name)
    if numbers.shape != (2,):
        raise SceneError("value", f"`{name}` expects a number or two for {role}, got {show(value, 40)}")
    return finite(name, role, float(numbers[0])), finite(name, role, float(numbers[1]))


def choice(name: str, role: str, value: Any, choices: dict[str, Any]) -> Any:
    """Return the value that a keyword argument stands for.

    Parameters
    ----------
    name, role
        Builtin and argument that the error message names.
    value
        Keyword.
    choices
        Values by the names of the keywords.

    Raises
    ------
    SceneError
        "value" for a keyword that is not in ``choices``, and for other values.
    """
    if type(value) is not Keyword or str(value) not in choices:
        expected = ", ".join(f"`:{keyword}`" for keyword in choices)
        raise SceneError("value", f"`{name}` expects {expected} for {role}, got {show(value, 40)}")
    return choices[str(value)]


def points_of(rt: Runtime, name: str, value: Any, expected: str, widths: Sequence[int], least: int) -> Numpy:
    """Return an argument that is an array of points, (N, D).

    Parameters
    ----------
    name
        Builtin that error messages name.
    value
        The argument.
    expected
        What the builtin expects, for error messages.
    widths
        Allowed numbers of coordinates D.
    least
        Smallest number of points N.

    Raises
    ------
    SceneError
        "value" for other shapes, too many points, or coordinates that are too large or not finite.
    """
    points = np.asarray(to_numpy(rt, value, name), np.float64)
    if points.ndim != 2 or points.shape[1] not in widths or len(points) < least:
        raise SceneError("value", f"`{name}` expects {expected}, got {show(value, 60)}")
    if len(points) > MAX_POINTS:
        raise SceneError("value", f"`{name}` expects at most {MAX_POINTS:,} points, got {len(points):,}")
    if not (np.abs(points) < _MAX_LENGTH).all():
        limit = f"coordinates below {_MAX_LENGTH:,.0f}" if np.isfinite(points).all() else "finite points"
        raise SceneError("value", f"`{name}` expects {limit}")
    rt.charge(len(points) >> 4)
    return points


def profile_of(rt: Runtime, name: str, value: Any) -> Contours:
    """Return an argument that is a profile, as contours (K, 2).

    Parameters
    ----------
    name
        Builtin that error messages name.
    value
        One array of points, or a list of them. A single contour is an outer one, whichever way it goes around.

    Raises
    ------
    SceneError
        "value" if it is something else, or has too many points.
    """
    if type(value) is Entity:
        hint = "a profile is flat, such as `(rectangle 2 1)` or `(circle 1)`"
        raise SceneError("type", f"`{name}` expects a profile, got {described(value, 60)}", hint)
    members = _contours_in(rt, name, value)
    if members is None:
        return (counter_clockwise(_contour(rt, name, value)),)
    rt.meter.check_growth(len(members), "a profile")
    contours = tuple(_contour(rt, name, member) for member in members)
    total = sum(map(len, contours))
    if total > MAX_POINTS:
        raise SceneError("value", f"`{name}` expects a profile of at most {MAX_POINTS:,} points, got {total:,}")
    return contours


def filled(rt: Runtime, name: str, value: Any, fill: Any) -> tuple[Contours, str]:
    """Return a profile as contours, and the rule that fills it.

    Parameters
    ----------
    name
        Builtin that error messages name.
    value
        The profile.
    fill
        ``:nonzero`` or ``:even-odd``; None means ``:nonzero``, with a warning if a contour crosses itself.
    """
    contours = profile_of(rt, name, value)
    if fill is not None:
        return contours, choice(name, ":fill", fill, _RULES)
    place = crossing_place(rt, contours)
    if place is not None:
        hint = "what it winds around is inside; `:fill :even-odd` leaves what it winds around twice, as OpenSCAD does"
        rt.warn("crossing-profile", f"the profile of `{name}` crosses itself at {place}", rt.site, hint)
    return contours, shapes.NON_ZERO


def crossing_place(rt: Runtime, contours: Contours) -> str | None:
    """Return where a contour first crosses itself, such as "[1 1]"; None if none does."""
    for contour in contours:
        rt.charge(len(contour) >> 4)
        point = shapes.crossing_of(contour)
        if point is not None:
            return f"[{point[0]:.4g} {point[1]:.4g}]"
    return None


def counter_clockwise(contour: Numpy) -> Numpy:
    """Return a contour (K, 2) that goes around counter-clockwise."""
    x, y = contour.T
    is_clockwise = float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) < 0.0
    return contour[::-1] if is_clockwise else contour


def _contours_in(rt: Runtime, name: str, value: Any) -> list[Any] | None:
    """Return the members of a list of contours, or None if the value must be a single contour."""
    if type(value) is Pair or value is NIL or type(value) is MutableList:
        members = items(rt, value, name)
        if not members:
            raise SceneError("value", f"`{name}` got an empty profile", "nothing is left of the profile before")
        first = members[0]
        is_list = type(first) not in (int, float, Vector) and to_numpy(rt, first, name).ndim > 1
        return members if is_list else None
    data = to_numpy(rt, value, name)
    return [from_numpy(contour) for contour in data] if data.ndim == 3 else None


def _contour(rt: Runtime, name: str, value: Any) -> Numpy:
    """Return one contour (K, 2)."""
    expected = "a profile: at least three points [x y], or a list of such contours"
    return points_of(rt, name, value, expected, (2,), 3)


def profile_value(rt: Runtime, contours: Contours) -> Any:
    """Return contours as a list of arrays."""
    rt.meter.check_size(2 * sum(map(len, contours)), "an array")
    return make_list([from_numpy(contour) for contour in contours])


# --- shapes ----------------------------------------------------------------------------------------------------------


@define(
    "circle", "radius::Number [:segments::Integer]", "Array",
    "Return the profile of a circle around the origin of the plane of x and y. It is a polygon of `:segments` sides, "
    "64 by default.",
    ("(circle 1 :segments 4)", "[[1.0 0.0] [0.0 1.0] [-1.0 0.0] [0.0 -1.0]]"),
    picture='(extrude (circle 1) .3 :color (color "gold"))',
)  # fmt: skip
def circle(rt: Runtime, radius: Any, segments: int = SEGMENTS) -> Any:
    sides = segment_count("circle", segments)
    angles = math.tau * np.arange(sides) / sides
    return from_numpy(shapes.on_circle(positive("circle", "the radius", radius), angles))


@define(
    "rectangle", "width::Number height::Number [:radius::Number] [:segments::Integer]", "Array",
    "Return the profile of a rectangle around the origin, `width` in x and `height` in y, its corners rounded by "
    "`:radius`. `:segments` are those of a full circle.",
    ("(rectangle 4 2)", "[[-2.0 -1.0] [2.0 -1.0] [2.0 1.0] [-2.0 1.0]]"),
    picture='(extrude (rectangle 3 2 :radius .5) .3 :color (color "gold"))',
)  # fmt: skip
def rectangle(rt: Runtime, width: Any, height: Any, radius: Any = 0, segments: int = SEGMENTS) -> Any:
    sides = positive("rectangle", "the width", width), positive("rectangle", "the height", height)
    if not 0.0 <= radius <= min(sides) / 2.0:
        raise SceneError("value", f"`rectangle` expects a :radius of 0 to half of a side, got {show(radius, 40)}")
    return from_numpy(shapes.rectangle(*sides, float(radius), segment_count("rectangle", segments)))


@define(
    "polygon", "points::ArrayLike", "Array",
    "Return the profile with these corners [x y], counter-clockwise in whichever order they are given. For a hole, "
    "subtract a profile by `profile-difference`.",
    ("(polygon [[0 0] [0 1] [2 0]])", "[[2.0 0.0] [0.0 1.0] [0.0 0.0]]"),
    picture='(extrude (polygon [[0 0] [3 0] [3 1] [1 1] [1 2] [0 2]]) .5 :color (color "gold"))',
)  # fmt: skip
def polygon(rt: Runtime, points: Any) -> Any:
    corners = points_of(rt, "polygon", points, "at least three points [x y]", (2,), 3)
    return from_numpy(corners if shapes.area_of(corners) >= 0.0 else corners[::-1].copy())


@define(
    "regular-polygon", "sides::Integer radius::Number", "Array",
    "Return the profile of a regular polygon around the origin with one corner at the top; `radius` is the distance of "
    "the corners.",
    ("(regular-polygon 4 1)", "[[0.0 1.0] [-1.0 0.0] [0.0 -1.0] [1.0 0.0]]"),
    picture='(extrude (regular-polygon 6 1) .5 :color (color "gold"))',
)  # fmt: skip
def regular_polygon(rt: Runtime, sides: int, radius: Any) -> Any:
    if not 3 <= sides <= MAX_SEGMENTS:
        raise SceneError("value", f"`regular-polygon` expects 3 to {MAX_SEGMENTS:,} sides, got {sides}")
    return from_numpy(shapes.regular_polygon(sides, positive("regular-polygon", "the radius", radius)))


@define(
    "star", "points::Integer outer::Number inner::Number", "Array",
    "Return the profile of a star around the origin with so many points, the first at the top; `outer` and `inner` are "
    "the distances of the points and of the corners between them.",
    ("(array-shape (star 5 1 .4))", "(10 2)"),
    picture='(extrude (star 5 1 .4) .4 :color (color "gold"))',
)  # fmt: skip
def star(rt: Runtime, points: int, outer: Any, inner: Any) -> Any:
    if not 2 <= points <= MAX_SEGMENTS:
        raise SceneError("value", f"`star` expects 2 to {MAX_SEGMENTS:,} points, got {points}")
    return from_numpy(shapes.star(points, positive("star", "`outer`", outer), positive("star", "`inner`", inner)))


@define(
    "arc", "radius::Number start::Number end::Number [:segments::Integer]", "Array",
    "Return the points of an arc around the origin, both ends included, at angles from the x axis towards the y axis. "
    "An arc is part of a contour: a piece of a pie is `(concatenate [[0 0]] (arc r a b))`, and a piece of a ring "
    "`(concatenate (arc outer a b) (arc inner b a))`.",
    ("(arc 2 0 pi :segments 2)", "[[2.0 0.0] [0.0 2.0] [-2.0 0.0]]"),
    picture='(extrude (concatenate (arc 2 0 4) (arc 1.2 4 0)) .5 :color (color "gold"))',
)  # fmt: skip
def arc(rt: Runtime, radius: Any, start: Any, end: Any, segments: int | None = None) -> Any:
    count = None if segments is None else segment_count("arc", segments, 1)
    first, last = finite("arc", "the start", start), finite("arc", "the end", end)
    if not abs(last - first) <= math.tau + 1e-9:
        raise SceneError("value", f"`arc` expects at most a full turn, got {show(last - first, 40)} radians")
    return from_numpy(shapes.arc(positive("arc", "the radius", radius), first, last, count))


@define(
    "spline", "points::ArrayLike [:segments::Integer]", "Array",
    "Return the smooth profile through points [x y], a closed centripetal Catmull-Rom spline with `:segments` steps "
    "between two points, 16 by default. It is counter-clockwise. `catmull-rom` makes open ones.",
    ("(array-shape (spline [[0 0] [2 0] [2 1] [0 1]] :segments 8))", "(32 2)"),
    picture='(extrude (spline [[0 0] [2 -.5] [3 1] [1.5 .8] [.5 2]]) .5 :color (color "gold"))',
)  # fmt: skip
def spline(rt: Runtime, points: Any, segments: int = 16) -> Any:
    expected = "at least three different points [x y]"
    corners = curves.without_repeats(points_of(rt, "spline", points, expected, (2,), 3))
    corners = corners[:-1] if curves.is_closed(corners) else corners
    if len(corners) < 3:
        raise SceneError("value", f"`spline` expects {expected}, got {show(points, 60)}")
    steps = segment_count("spline", segments, 1)
    rt.meter.check_size(2 * steps * len(corners), "an array")
    curve = curves.catmull_rom(corners, True, steps)[:-1]
    return from_numpy(curve if shapes.area_of(curve) >= 0.0 else curve[::-1].copy())


@define(
    "svg-path", f"data::String {FILL} [:tolerance::Number]", "List",
    "Return the profile of the data `d` of an SVG path, with all of its commands. y is upwards, so the numbers are "
    "negated. `:fill` says what is inside, `:nonzero` as in SVG or `:even-odd`; open subpaths count as closed. "
    "`:tolerance` is the largest distance from curves, by default a thousandth of the size.",
    ('(svg-path "M0 0 H4 V-2 H0 Z")', "([[4.0 2.0] [0.0 2.0] [0.0 0.0] [4.0 0.0]])"),
    picture='(extrude (svg-path "M0 -3 C-3 -6 -6 -2 0 2 C6 -2 3 -6 0 -3 Z") 1 :color (color "tomato"))',
)  # fmt: skip
def svg_path(rt: Runtime, data: str, fill: Any = _NONZERO, tolerance: Any = None) -> Any:
    rule = choice("svg-path", ":fill", fill, _RULES)
    rt.charge(len(data) >> 3)
    near = None if tolerance is None else positive("svg-path", ":tolerance", tolerance)
    pen = shapes.svg_outline(data, near)
    rt.charge(pen.pieces)
    contours = pen.contours(pen.size / 1000.0 if near is None else near)
    _charge_for(rt, "svg-path", contours)
    return profile_value(rt, shapes.normalized(contours, rule) if contours else ())


# --- text ------------------------------------------------------------------------------------------------------------


def outline_of(
    rt: Runtime, name: str, text: str, font: str | None, size: Any, align: Any, spacing: Any, line_height: Any
) -> Contours:  # fmt: skip
    """Return the outlines of a text.

    Parameters
    ----------
    name
        Builtin that error messages name.
    text
        Text of one or several lines.
    font
        Font file, as the program names it; None for the built-in font.
    size, align, spacing, line_height
        Keywords of ``text-outline``.

    Raises
    ------
    SceneError
        "value" for an invalid keyword, or a character that the font lacks.
    """
    style = TextStyle(
        positive(name, ":size", size), choice(name, ":align", align, _ALIGNMENTS), finite(name, ":spacing", spacing),
        finite(name, ":line-height", line_height),
    )  # fmt: skip
    contours = text_outline(_typeface(rt, font), text, style, rt.charge)
    rt.meter.check_size(2 * sum(map(len, contours)), "an array")
    return contours


def _typeface(rt: Runtime, file: str | None) -> Typeface:
    """Return the font of a file, or the bundled one."""
    if file is None:
        return bundled()
    if rt.font is None:
        raise SceneError("file", f"cannot read the font {file[:200]}: loading of fonts is disabled here")
    rt.output += 1  # the file may change
    return rt.font(file, rt.charge)


TEXT = "[:size::Number] [:font::String] [:align::Keyword] [:spacing::Number] [:line-height::Number]"


@define(
    "text-outline", f"text::String {TEXT}", "List",
    "Return the profile of a text, the baseline of its first line at y = 0. `:size` is the height of an em, 1 by "
    "default; `:align` puts x = 0 at the `:left`, `:center` or `:right` of each line; `:spacing` is added between "
    "letters and `:line-height`, 1.2 by default, is the distance of lines, both in ems. `:font` is the path of a "
    "TrueType or OpenType file in the project folder; the bundled font, DejaVu Sans, has Latin, Greek and Cyrillic "
    "letters.",
    ('(length (text-outline "io"))', "4"),
    picture='(extrude (text-outline "Aα" :align :center) .2 :color (color "gold"))',
)  # fmt: skip
def outline_of_text(
    rt: Runtime, text: str, size: Any = 1, font: str | None = None, align: Any = LEFT, spacing: Any = 0,
    line_height: Any = 1.2,
) -> Any:  # fmt: skip
    return profile_value(rt, outline_of(rt, "text-outline", text, font, size, align, spacing, line_height))


# --- operations ------------------------------------------------------------------------------------------------------


def _charge_for(rt: Runtime, name: str, contours: Sequence[Numpy]) -> None:
    """Charge for an operation on contours, which takes time for each crossing of edges."""
    rt.charge(1 + (sum(map(len, contours)) >> 2) + (shapes.check_crossings(name, contours) >> 7))


def _combined(rt: Runtime, name: str, kind: str, values: Sequence[Any], fill: Any) -> Any:
    """Return a boolean of profiles; ``kind`` is an operation of Manifold."""
    rt.meter.check_growth(len(values), "a list of profiles")
    profiles = [filled(rt, name, value, fill) for value in values]
    _charge_for(rt, name, [contour for contours, _ in profiles for contour in contours])
    return profile_value(rt, shapes.combined(name, kind, [contours for contours, _ in profiles], profiles[0][1]))


@define(
    "profile-union", f"first others ... {FILL}", "List",
    "Return the contours of what is inside of any profile. `:fill` says what is inside of one that crosses itself or "
    "whose contours overlap: `:nonzero`, what they wind around (the default), or `:even-odd`, what they wind around an "
    "odd number of times.",
    ("(profile-area (profile-union (rectangle 2 2) (+ (rectangle 2 2) [1 0])))", "6.0"),
    picture='(extrude (profile-union (circle 1) (+ (circle .7) [1.2 0])) .4 :color (color "gold"))',
)  # fmt: skip
def profile_union(rt: Runtime, first: Any, *others: Any, fill: Any = None) -> Any:
    return _combined(rt, "profile-union", "Add", (first, *others), fill)


@define(
    "profile-difference", f"base tools ... {FILL}", "List",
    "Return the contours of what remains of a profile without the others. Nothing may remain: an empty list. `:fill` "
    "is that of `profile-union`.",
    ("(profile-area (profile-difference (rectangle 2 2) (rectangle 1 1)))", "3.0"),
    picture='(extrude (profile-difference (rectangle 3 2) (circle .7)) .4 :color (color "gold"))',
)  # fmt: skip
def profile_difference(rt: Runtime, base: Any, *tools: Any, fill: Any = None) -> Any:
    return _combined(rt, "profile-difference", "Subtract", (base, *tools), fill)


@define(
    "profile-intersection", f"first others ... {FILL}", "List",
    "Return the contours of what is inside of all profiles. `:fill` is that of `profile-union`.",
    ("(profile-area (profile-intersection (rectangle 2 2) (+ (rectangle 2 2) [1 0])))", "2.0"),
    picture='(extrude (profile-intersection (circle 1) (+ (circle 1) [.8 0])) .4 :color (color "gold"))',
)  # fmt: skip
def profile_intersection(rt: Runtime, first: Any, *others: Any, fill: Any = None) -> Any:
    return _combined(rt, "profile-intersection", "Intersect", (first, *others), fill)


@define(
    "profile-hull", "first others ...", "List", "Return the convex hull of all profiles.",
    ("(profile-area (profile-hull (rectangle 2 2) (+ (rectangle 2 2) [4 0])))", "12.0"),
    picture='(extrude (profile-hull (circle 1) (+ (circle .4) [2 0])) .4 :color (color "gold"))',
)  # fmt: skip
def profile_hull(rt: Runtime, first: Any, *others: Any) -> Any:
    rt.meter.check_growth(len(others), "a list of profiles")
    contours = [contour for value in (first, *others) for contour in profile_of(rt, "profile-hull", value)]
    rt.charge(1 + (sum(map(len, contours)) >> 2))
    return profile_value(rt, shapes.hull(contours))


@define(
    "profile-minkowski", "base tool", "List",
    "Return the Minkowski sum of two profiles: what a convex `tool`, moved by its origin over all of `base`, covers.",
    ("(profile-area (profile-minkowski (rectangle 2 2) (rectangle 1 1)))", "9.0"),
    picture='(extrude (profile-minkowski (star 5 1 .4) (circle .2)) .3 :color (color "gold"))',
)  # fmt: skip
def profile_minkowski(rt: Runtime, base: Any, tool: Any) -> Any:
    name = "profile-minkowski"
    contours, moved = profile_of(rt, name, base), profile_of(rt, name, tool)
    corners = sum(map(len, contours)) * sum(map(len, moved))
    if corners > MAX_POINTS:
        raise SceneError("value", f"`{name}` expects at most {MAX_POINTS:,} pairs of corners, got {corners:,}")
    rt.charge(1 + corners)
    return profile_value(rt, shapes.minkowski(contours, moved))


@define(
    "offset-profile", f"profile distance::Number [:join::Keyword] [:segments::Integer] [:limit::Number] {FILL}", "List",
    "Return a profile grown by `distance`, or shrunk if it is negative. Outer corners are joined `:round` with "
    "`:segments` of a full circle, `:miter` (a corner beyond `:limit` times the distance, 4 by default, is squared at "
    "one distance) or `:square`. `:fill` is that of `profile-union`.",
    ("(profile-area (offset-profile (rectangle 2 2) 1 :join :miter))", "16.0"),
    picture='(union (extrude (star 5 1 .5) .5 :color (color "gold")) (extrude (offset-profile (star 5 1 .5) .25) .2 '
            ':color (color "slategray")))',
)  # fmt: skip
def offset_profile(
    rt: Runtime, profile: Any, distance: Any, join: Any = _ROUND, segments: int = SEGMENTS, limit: Any = 4,
    fill: Any = None,
) -> Any:  # fmt: skip
    name = "offset-profile"
    contours, rule = filled(rt, name, profile, fill)
    kind, sides = choice(name, ":join", join, _JOINS), segment_count(name, segments)
    length = finite(name, "the distance", distance)
    _charge_for(rt, name, contours)
    rt.charge(sum(map(len, contours)) * (sides if kind == "Round" else 4) >> 6)
    most = positive(name, ":limit", limit)
    if length == 0.0:
        return profile_value(rt, contours if fill is None else shapes.normalized(contours, rule))
    return profile_value(rt, shapes.offset(contours, length, kind, sides, most, rule))


@define(
    "transform-profile", "profile [:move] [:rotate::Number] [:scale]", "Any",
    "Return a profile scaled by `:scale` (one factor, or two for x and y), then rotated by `:rotate` radians from x "
    "towards y, then moved by `:move` [x y]. One contour may be given as an array, and is returned as one; for such, "
    "`(+ profile [x y])` and `(* profile factor)` do the same.",
    ("(transform-profile (rectangle 2 2) :scale [2 1] :move [2 1])", "[[0.0 0.0] [4.0 0.0] [4.0 2.0] [0.0 2.0]]"),
    picture='(extrude (transform-profile (text-outline "R") :scale [-1 1] :rotate .3) .2 :color (color "gold"))',
)  # fmt: skip
def transform_profile(rt: Runtime, profile: Any, move: Any = 0, rotate: Any = 0, scale: Any = 1) -> Any:
    name = "transform-profile"
    is_list = _contours_in(rt, name, profile) is not None
    sx, sy = one_or_two(rt, name, ":scale", scale)
    if sx * sy == 0.0:
        raise SceneError("value", f"`{name}` expects a :scale without 0, got {show(scale, 40)}")
    offset = one_or_two(rt, name, ":move", move)
    angle = finite(name, ":rotate", rotate)
    c, s = math.cos(angle), math.sin(angle)
    matrix = np.array([[sx * c, sx * s], [-sy * s, sy * c]])
    moved = tuple(contour @ matrix + offset for contour in profile_of(rt, name, profile))
    if sx * sy < 0.0:  # a mirror image reverses contours
        moved = tuple(contour[::-1].copy() for contour in moved)
    if not all(np.isfinite(contour).all() for contour in moved):
        raise SceneError("value", f"`{name}` expects finite numbers")
    return profile_value(rt, moved) if is_list else from_numpy(moved[0])


@define(
    "profile-area", f"profile {FILL}", "Float",
    "Return the area of a profile: that of what is inside. `:fill` is that of `profile-union`.",
    ("(profile-area [[0 0] [2 0] [2 1] [0 1]])", "2.0"),
)  # fmt: skip
def profile_area(rt: Runtime, profile: Any, fill: Any = None) -> float:
    contours, rule = filled(rt, "profile-area", profile, fill)
    _charge_for(rt, "profile-area", contours)
    return float(shapes.section_of(contours, rule).area())
