"""Paths: points along which to sweep profiles and to place objects (docs/solids.md)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Registry
from scenelang.interpreter.scene.modelling import curves
from scenelang.interpreter.scene.modelling.operations import SEGMENTS
from scenelang.interpreter.values.values import Matrix, Vector, make_list
from scenelang.stdlib.operands import Numpy, from_numpy, to_numpy
from scenelang.stdlib.profiles import MAX_POINTS, finite, points_of, positive, segment_count

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("paths")
define = registry.define

_MAX_DEGREE = 64  # of a Bezier curve: with more control points, each hardly changes it
_BLOCK_POSES = 4096  # between two checks of the limits
_EXPECTED_POINTS = "at least two different points [x y z]"


# --- arguments -------------------------------------------------------------------------------------------------------


def _points(rt: Runtime, name: str, value: Any) -> Numpy:
    """Return at least two different points (N, 2) or (N, 3), without repetitions."""
    points = curves.without_repeats(points_of(rt, name, value, _EXPECTED_POINTS, (2, 3), 2))
    if len(points) < 2:
        raise SceneError("value", f"`{name}` expects {_EXPECTED_POINTS}, got {show(value, 60)}")
    return points


def path_of(rt: Runtime, name: str, value: Any) -> Numpy:
    """Return an argument that is a path: points (N, 3), at least two, none equal to the one before.

    Points [x y] get z = 0. Raises SceneError("value"), which names the builtin ``name``, for anything else.
    """
    points = _points(rt, name, value)
    return points if points.shape[1] == 3 else np.pad(points, ((0, 0), (0, 1)))


def _shares(rt: Runtime, name: str, value: Any) -> tuple[Numpy, bool]:
    """Return shares (T,) of a path's length, and whether there is just one, given as a number."""
    shares = np.asarray(to_numpy(rt, value, name), np.float64)
    if shares.ndim > 1 or not ((shares >= 0.0) & (shares <= 1.0)).all():
        raise SceneError("value", f"`{name}` expects a share of the length from 0 to 1, got {show(value, 40)}")
    rt.meter.check_size(3 * shares.size, "an array")
    return shares.reshape(-1), shares.ndim == 0


def _check_points(rt: Runtime, points: int) -> None:
    """Raise SceneError if a path would have too many points."""
    if points > MAX_POINTS:
        raise SceneError("value", f"a path has at most {MAX_POINTS:,} points, not {points:,}", "use fewer :segments")
    rt.meter.check_size(3 * points, "an array")


# --- curves ----------------------------------------------------------------------------------------------------------


@define(
    "polyline", "points::ArrayLike [:closed::Boolean]", "Array",
    "Return the path of straight lines through points. `:closed` returns to the first one: a path is closed if it ends "
    "where it begins.",
    ("(polyline [[0 0 0] [1 0 0] [1 2 0]] :closed #t)",
     "[[0.0 0.0 0.0] [1.0 0.0 0.0] [1.0 2.0 0.0] [0.0 0.0 0.0]]"),
    picture='(sweep (circle .1) (polyline [[0 0 0] [2 0 0] [2 1 0] [1 1 1]]) :color (color "gold"))',
)  # fmt: skip
def polyline(rt: Runtime, points: Any, closed: bool = False) -> Any:
    path = _points(rt, "polyline", points)
    return from_numpy(np.concatenate([path, path[:1]]) if closed and not curves.is_closed(path) else path)


@define(
    "bezier", "points::ArrayLike [:segments::Integer] [:chained::Boolean]", "Array",
    "Return the points of the Bezier curve with these control points, in `:segments` steps, 32 by default. With "
    "`:chained`, cubic curves that share their ends, of 4, 7, 10, ... control points. They may be [x y] or [x y z].",
    ("(bezier [[0 0] [1 2] [2 0]] :segments 2)", "[[0.0 0.0] [1.0 1.0] [2.0 0.0]]"),
    picture='(sweep (circle .1) (bezier [[0 0 0] [0 2 0] [2 -1 0] [2 1 1]]) :color (color "gold"))',
)  # fmt: skip
def bezier(rt: Runtime, points: Any, segments: int = 32, chained: bool = False) -> Any:
    control = points_of(rt, "bezier", points, "at least two control points [x y z]", (2, 3), 2)
    steps = segment_count("bezier", segments, 1)
    if chained:
        if len(control) % 3 != 1:
            message = f"`bezier` expects 4, 7, 10, ... control points with :chained, got {len(control)}"
            raise SceneError("value", message, "the end of each cubic curve is the start of the next one")
        _check_points(rt, len(control) // 3 * steps)
        rt.charge(len(control))
        return from_numpy(curves.chained_bezier(control, steps))
    if len(control) > _MAX_DEGREE + 1:
        hint = "join cubic curves by :chained, or use `catmull-rom`"
        raise SceneError(
            "value", f"`bezier` expects at most {_MAX_DEGREE + 1} control points, got {len(control)}", hint
        )
    rt.charge(1 + (len(control) ** 2 * steps >> 8))  # de Casteljau's algorithm is quadratic in the degree
    return from_numpy(curves.bezier(control, np.arange(steps + 1) / steps))


@define(
    "catmull-rom", "points::ArrayLike [:closed::Boolean] [:segments::Integer]", "Array",
    "Return a smooth path through points [x y] or [x y z], a centripetal Catmull-Rom spline with `:segments` steps "
    "between two points, 16 by default.",
    ("(round (ref (catmull-rom [[0 0 0] [1 1 0] [2 0 0]] :segments 2) 1) 3)", "[0.5 0.625 0.0]"),
    picture='(sweep (circle .1) (catmull-rom [[0 0 0] [1 1 0] [2 0 1] [1 0 2] [-1 1 1]] :closed #t) :color (color '
            '"gold"))',
)  # fmt: skip
def catmull_rom(rt: Runtime, points: Any, closed: bool = False, segments: int = 16) -> Any:
    points_given = _points(rt, "catmull-rom", points)
    is_closed = curves.is_closed(points_given) or closed
    corners = points_given[:-1] if curves.is_closed(points_given) else points_given
    if is_closed and len(corners) < 3:
        raise SceneError("value", f"`catmull-rom` expects at least three points of a closed path, got {len(corners)}")
    steps = segment_count("catmull-rom", segments, 1)
    _check_points(rt, steps * len(corners))
    return from_numpy(curves.catmull_rom(corners, is_closed, steps))


@define(
    "helix", "radius::Number height::Number turns::Number [:segments::Integer]", "Array",
    "Return a helix around the y axis, from [0 0 radius] upwards by `height`. It turns from +z towards +x, or the "
    "other way if `turns` is negative; `:segments` are those of a turn, 64 by default.",
    ("(round (helix 1 2 .5 :segments 4) 6)", "[[0.0 0.0 1.0] [1.0 1.0 0.0] [0.0 2.0 -1.0]]"),
    picture='(sweep (circle .12) (helix 1 1.5 3) :color (color "gold"))',
)  # fmt: skip
def helix(rt: Runtime, radius: Any, height: Any, turns: Any, segments: int = SEGMENTS) -> Any:
    steps = segment_count("helix", segments)
    count = finite("helix", "the turns", turns)
    if count == 0.0:
        raise SceneError("value", "`helix` expects turns that are not 0")
    _check_points(rt, int(abs(count) * steps) + 2)
    width, rise = positive("helix", "the radius", radius), finite("helix", "the height", height)
    return from_numpy(curves.helix(width, rise, count, steps))


@define(
    "resample-path", "path::ArrayLike count::Integer", "Array",
    "Return so many points of a path at equal distances along it, both ends included.",
    ("(resample-path [[0 0 0] [4 0 0]] 3)", "[[0.0 0.0 0.0] [2.0 0.0 0.0] [4.0 0.0 0.0]]"),
)  # fmt: skip
def resample_path(rt: Runtime, path: Any, count: int) -> Any:
    points = _points(rt, "resample-path", path)
    if count < 2:
        raise SceneError("value", f"`resample-path` expects at least two points, got {count}")
    _check_points(rt, count)
    return from_numpy(curves.points_at(points, np.linspace(0.0, 1.0, count)))


# --- places ----------------------------------------------------------------------------------------------------------


@define(
    "path-length", "path::ArrayLike", "Float", "Return the length of a path.",
    ("(path-length [[0 0 0] [3 0 0] [3 4 0]])", "7.0"),
)  # fmt: skip
def path_length(rt: Runtime, path: Any) -> float:
    return float(curves.lengths_to(path_of(rt, "path-length", path))[-1])


@define(
    "point-at", "path::ArrayLike t::ArrayLike", "Array",
    "Return the point of a path at a share of its length, 0 at the start and 1 at the end. For a vector of shares, the "
    "array of points.",
    ("(point-at [[0 0 0] [3 0 0] [3 1 0]] .5)", "[2.0 0.0 0.0]"),
)  # fmt: skip
def point_at(rt: Runtime, path: Any, t: Any) -> Any:
    shares, is_one = _shares(rt, "point-at", t)
    points = curves.points_at(path_of(rt, "point-at", path), shares)
    return Vector(points[0].tolist()) if is_one else from_numpy(points)


@define(
    "tangent-at", "path::ArrayLike t::ArrayLike", "Array",
    "Return the direction of a path, of length 1, at a share of its length; for a vector of shares, the array of "
    "directions. A corner has the direction of the line after it; a curve, of joints below 20 degrees, turns evenly.",
    ("(tangent-at [[0 0 0] [3 0 0] [3 1 0]] .9)", "[0.0 1.0 0.0]"),
)  # fmt: skip
def tangent_at(rt: Runtime, path: Any, t: Any) -> Any:
    shares, is_one = _shares(rt, "tangent-at", t)
    _, axes = _frames(rt, "tangent-at", path).posed_at(shares)
    return Vector(axes[0, :, 2].tolist()) if is_one else from_numpy(axes[:, :, 2].copy())


def _frames(rt: Runtime, name: str, value: Any) -> curves.PathFrames:
    """Return the rotation-minimizing frames of a path."""
    points = path_of(rt, name, value)
    rt.charge(len(points) >> 3)
    return curves.frames_of(points)


@define(
    "frame-at", "path::ArrayLike t::ArrayLike [:upright::Boolean]", "Any",
    "Return the pose at a share of a path's length that maps the origin to the path and +z to its direction; for a "
    "vector of shares, the list of poses. At the start, +y is as far upwards as possible; the pose does not turn about "
    "the path (rotation-minimising frames). Around a closed path, the turn that remains is spread evenly. With "
    "`:upright`, +y is as far upwards as possible everywhere.",
    ("(@ (frame-at [[0 0 0] [3 0 0]] 1) [0 0 2])", "[5.0 0.0 0.0]"),
    picture='(let ((path (helix 2 1.5 1))) (union (sweep (circle .04) path) (map (lambda (t) (transform (call "cube" '
            ':scale [.5 .2 .1] :color (color "gold")) (frame-at path t))) (->list (linspace 0 1 12)))))',
)  # fmt: skip
def frame_at(rt: Runtime, path: Any, t: Any, upright: bool = False) -> Any:
    shares, is_one = _shares(rt, "frame-at", t)
    frames, matrices = _frames(rt, "frame-at", path), []
    for start in range(0, len(shares), _BLOCK_POSES):  # so that the limits are checked in between
        block = shares[start : start + _BLOCK_POSES]
        rt.charge(1 + (len(block) >> 1))
        points, axes = frames.posed_at(block)
        if upright:
            axes = curves.upright_frames(axes[:, :, 2])
        poses = np.concatenate([axes, points[:, :, None]], axis=2).reshape(-1, 12)
        matrices += [Matrix(numbers) for numbers in poses.tolist()]
    return matrices[0] if is_one else make_list(matrices)
