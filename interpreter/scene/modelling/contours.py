"""Profiles: contours (K, 2) of points, outer ones counter-clockwise and holes clockwise.

A point is inside if the contours wind around it, in whichever direction (``NON_ZERO``); by ``EVEN_ODD``, if a ray from
it crosses them an odd number of times. Booleans and offsets are those of Clipper2 (Johnson,
https://www.angusj.com/clipper2), by way of Manifold.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.loading import np, require
from scenelang.interpreter.scene.modelling.curves import bezier
from scenelang.interpreter.scene.modelling.operations import SEGMENTS

if TYPE_CHECKING:
    import numpy.typing as npt
    from manifold3d import CrossSection

    FloatArray = npt.NDArray[np.float64]
    IntArray = npt.NDArray[np.int64]

Contours = tuple["FloatArray", ...]
Point2 = tuple[float, float]

TEXT_EXTRA = "'scenelang[text]'"  # what installs fontTools, as error messages show it
NON_ZERO, EVEN_ODD = "NonZero", "EvenOdd"  # fill rules of Manifold
MAX_CROSSINGS = 4_000_000  # pairs of edges that may cross in one operation: about 3 s
MAX_COORDINATE = 1e9  # Clipper2 computes with 64-bit integers
MAX_OFFSET = 1_000_000  # points of an offset profile before it is simplified
_MAX_CURVE_PIECES = 256  # straight pieces of a flattened curve, however small the tolerance is
_EQUAL_DISTANCE = 1e-9  # of the size: points that close are one; cross products that small are 0
_NEGLIGIBLE_AREA = 1e-6  # of the box of a contour; Manifold rounds its points to about nine digits
_NEGLIGIBLE_SINE = 1e-15  # sines and cosines that small are rounding errors of 0


# --- shapes ----------------------------------------------------------------------------------------------------------


def on_circle(radius: float, angles: FloatArray) -> FloatArray:
    """Return points (K, 2) at angles from the x axis toward the y axis; those on an axis are exactly on it."""
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.asarray(radius * np.where(np.abs(unit) < _NEGLIGIBLE_SINE, 0.0, unit), np.float64)


def regular_polygon(sides: int, radius: float) -> FloatArray:
    """Return a regular polygon (sides, 2) around the origin with its first corner at the top.

    ``radius`` is the distance of its corners from the origin.
    """
    return on_circle(radius, math.pi / 2.0 + math.tau * np.arange(sides) / sides)


def star(points: int, outer: float, inner: float) -> FloatArray:
    """Return a star around the origin, (2 * points, 2), with its first tip at the top.

    ``outer`` and ``inner`` are the distances of its tips and of the corners between them from the origin.
    """
    corners = regular_polygon(2 * points, 1.0)
    return np.asarray(corners * np.where(np.arange(2 * points) % 2 == 0, outer, inner)[:, None], np.float64)


def rectangle(width: float, height: float, radius: float, segments: int) -> FloatArray:
    """Return a rectangle around the origin, counter-clockwise, (K, 2).

    Parameters
    ----------
    width, height
        Size along x and y.
    radius
        Radius of its rounded corners, 0 for sharp ones.
    segments
        Number of sides that a full circle of this radius would have.
    """
    x, y = width / 2.0, height / 2.0
    if radius == 0.0:
        return np.array([[-x, -y], [x, -y], [x, y], [-x, y]])
    quarter = np.linspace(0.0, math.pi / 2.0, max(1, segments // 4) + 1)
    centers = [(x - radius, y - radius), (radius - x, y - radius), (radius - x, radius - y), (x - radius, radius - y)]
    corners = [on_circle(radius, quarter + k * math.pi / 2.0) + center for k, center in enumerate(centers)]
    return _distinct(np.concatenate(corners))


def _distinct(points: FloatArray) -> FloatArray:
    """Drop the points of a contour that are equal to the one before."""
    size = float(np.ptp(points, axis=0).max(initial=0.0))
    is_new = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1) > _EQUAL_DISTANCE * size
    return np.asarray(points[is_new], np.float64)


def arc(radius: float, start: float, end: float, segments: int | None) -> FloatArray:
    """Return the points (N, 2) of an arc around the origin, with both of its ends.

    Parameters
    ----------
    radius
        Radius of the arc.
    start, end
        Angles in radians from the x axis toward the y axis.
    segments
        Number of segments; by default, as fine as a full circle.
    """
    count = segments or max(1, math.ceil(abs(end - start) / math.tau * SEGMENTS))
    return on_circle(radius, np.linspace(start, end, count + 1))


def area_of(contour: FloatArray) -> float:
    """Return the area of a contour, negative if it is clockwise."""
    x, y = (contour - contour[0]).T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2.0)


# --- operations ------------------------------------------------------------------------------------------------------


def section_of(contours: Sequence[FloatArray], rule: str = NON_ZERO) -> CrossSection:
    """Return the cross-section bounded by contours, by a fill rule of Manifold.

    Raises SceneError("value") for coordinates that its whole numbers cannot express.
    """
    import manifold3d

    if any(len(contour) and not np.abs(contour).max() <= MAX_COORDINATE for contour in contours):
        raise SceneError("value", f"the coordinates of a profile must be within {MAX_COORDINATE:.0e} of 0")
    points = [np.asarray(contour, np.float64) for contour in contours]
    return manifold3d.CrossSection(points, manifold3d.FillRule[rule])


def contours_of(section: CrossSection) -> Contours:
    """Return the contours of a cross-section; those without an area are dropped."""
    polygons = (np.array(polygon, np.float64) for polygon in section.to_polygons())
    return tuple(polygon for polygon in polygons if len(polygon) >= 3)


def normalized(contours: Sequence[FloatArray], rule: str = NON_ZERO) -> Contours:
    """Return contours without overlaps that bound the same area.

    Parameters
    ----------
    contours : sequence of (K, 2)
        Closed polygons, which may cross themselves and each other.
    rule
        Fill rule of Manifold, which decides what is inside: ``NON_ZERO`` or ``EVEN_ODD``.

    Returns
    -------
    tuple of (K, 2)
        Outer contours counter-clockwise, holes clockwise.

    Raises
    ------
    SceneError
        "value" if coordinates are too large.
    LimitError
        "size" if the edges may cross too often.
    """
    check_crossings("a profile", contours)
    return contours_of(section_of(contours, rule))


def untouching(contours: Contours) -> list[Contours]:
    """Return the parts of a profile without overlaps, each an outer contour with its holes, if some meet at a corner.

    Surfaces over parts that meet would be joined there, along edges with four faces.
    """
    corners = np.concatenate(contours) if contours else np.zeros((0, 2))
    if len(contours) < 2 or len(np.unique(corners, axis=0)) == len(corners):
        return [contours]
    return [contours_of(part) for part in section_of(contours).decompose()]


def combined(name: str, kind: str, profiles: Sequence[Contours], rule: str = NON_ZERO) -> Contours:
    """Return a boolean of profiles.

    Parameters
    ----------
    name
        Builtin that is named in errors.
    kind
        Operation of Manifold: Add, Subtract or Intersect.
    profiles
        Operands; all others are subtracted from the first.
    rule
        Fill rule of each profile, ``NON_ZERO`` or ``EVEN_ODD``.
    """
    import manifold3d

    check_crossings(name, [contour for profile in profiles for contour in profile])
    sections = [section_of(profile, rule) for profile in profiles]
    return contours_of(manifold3d.CrossSection.batch_boolean(sections, manifold3d.OpType[kind]))


def offset(
    contours: Contours, distance: float, join: str, segments: int, limit: float = 4.0, rule: str = NON_ZERO
) -> Contours:
    """Return a profile grown by a distance, or shrunk by a negative one.

    Parameters
    ----------
    distance
        In scene units.
    join
        Join of Manifold at corners: Square, Round or Miter.
    segments
        Sides of a full circle, for round joins.
    limit
        Maximum length of a miter, as a multiple of the distance.
    """
    import manifold3d

    check_crossings("offset-profile", contours)
    _check_offset(contours, segments)
    grown = section_of(contours, rule).offset(distance, manifold3d.JoinType[join], limit, segments)
    return contours_of(grown.simplify(abs(distance) * 1e-6))


def _check_offset(contours: Contours, segments: int) -> None:
    """Raise LimitError("size") if round joints would have too many points.

    A joint has the share of ``segments`` that its angle has of a full turn.
    """
    total = 0.0
    for contour in contours:  # the angles by which it turns at its corners, in full turns, give the points of arcs
        side = np.roll(contour, -1, axis=0) - contour
        angle = np.arctan2(side[:, 1], side[:, 0])
        turn = np.abs((np.roll(angle, -1) - angle + math.pi) % math.tau - math.pi)
        total += len(contour) + segments * float(turn.sum()) / math.tau
    if total > MAX_OFFSET:
        message = f"`offset-profile` would make about {total:,.0f} points, more than {MAX_OFFSET:,}"
        raise LimitError("size", message, hint="use fewer :segments")


def hull(contours: Sequence[FloatArray]) -> Contours:
    """Return the convex hull of contours."""
    return contours_of(section_of(contours).hull())


def minkowski(base: Contours, tool: Contours) -> Contours:
    """Return the Minkowski sum of a profile and a convex tool.

    It is the union of the base, moved to a point of the tool, and of the area that the tool sweeps along each edge: the
    convex hull of the tool at both ends.
    """
    import manifold3d

    corners = np.concatenate(tool)
    pieces = [section_of(base).translate(corners.mean(axis=0).tolist())]
    for contour in base:
        for start, end in zip(contour, np.roll(contour, -1, axis=0), strict=True):
            pieces.append(manifold3d.CrossSection.hull_points(np.concatenate([corners + start, corners + end])))
    return contours_of(manifold3d.CrossSection.batch_boolean(pieces, manifold3d.OpType.Add))


def check_crossings(name: str, contours: Sequence[FloatArray]) -> int:
    """Return an upper bound of the number of edges that cross; raises LimitError("size") if it is too high.

    Edges cross only if their ranges overlap along both axes; the smaller number of the two counts.
    """
    if not contours:
        return 0
    starts = np.concatenate(contours)
    ends = np.concatenate([np.roll(contour, -1, axis=0) for contour in contours])
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    pairs = min(_overlaps(low[:, axis], high[:, axis]) for axis in (0, 1))
    if pairs > MAX_CROSSINGS:
        message = f"`{name}` of {len(starts):,} points has up to {pairs:,} crossings, more than {MAX_CROSSINGS:,}"
        raise LimitError("size", message, hint="use fewer :segments, or combine fewer profiles at once")
    return pairs


def _overlaps(low: FloatArray, high: FloatArray) -> int:
    """Return the number of pairs of intervals that overlap, by sorting."""
    order = np.argsort(low)
    reached = np.searchsorted(low[order], high[order], "right")
    return int(np.sum(reached - np.arange(len(low)) - 1))


_MAX_COMPARED_PAIRS = 200_000  # of edges: a test of more would take longer than the operation on the profile


def crossing_of(contour: FloatArray) -> tuple[float, float] | None:
    """Return a point at which a contour crosses itself, or None; edges that only touch do not cross.

    A contour is not tested, and None returned, if it has so many edges that the test would take long.
    """
    if len(contour) < 4 or _is_star_shaped(contour):
        return None
    starts, ends = contour, np.roll(contour, -1, axis=0)
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    pair_counts = [_overlaps(low[:, axis], high[:, axis]) for axis in (0, 1)]
    axis = int(np.argmin(pair_counts))
    if pair_counts[axis] > _MAX_COMPARED_PAIRS:
        return None
    # Edges in the order of their lower ends along the axis: each is compared with those that begin before it ends.
    order = np.argsort(low[:, axis])
    reached = np.searchsorted(low[order, axis], high[order, axis], "right")
    counts = reached - np.arange(len(order)) - 1
    first = np.repeat(np.arange(len(order)), counts)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    one, other = order[first], order[second]
    crossed = _are_crossed(starts[one], ends[one], starts[other], ends[other])
    if not crossed.any():
        return _shared_corner(contour)
    at = int(np.argmax(crossed))
    a, b, c, d = starts[one[at]], ends[one[at]], starts[other[at]], ends[other[at]]
    share = float(_cross(c - a, d - c) / _cross(b - a, d - c))
    x, y = (a + share * (b - a)).tolist()
    return x, y


def _shared_corner(contour: FloatArray) -> tuple[float, float] | None:
    """Return a corner at which a contour without crossing edges crosses itself, or None.

    The area of a simple contour is the same by its corners, by winding and by parity.
    """
    areas = [abs(area_of(contour)), *(section_of([contour], rule).area() for rule in (NON_ZERO, EVEN_ODD))]
    if max(areas) - min(areas) <= _NEGLIGIBLE_AREA * float(np.prod(np.ptp(contour, axis=0))):
        return None
    _, first, counts = np.unique(contour, axis=0, return_index=True, return_counts=True)
    x, y = contour[first[counts > 1].min() if (counts > 1).any() else 0].tolist()
    return x, y


def _cross(u: FloatArray, v: FloatArray) -> FloatArray:
    """Return the cross products (...,) of vectors (..., 2) in the plane."""
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0], np.float64)


def _are_crossed(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which segments from a to b cross those from c to d, all (N, 2), at an inner point of both.

    Each segment must have its ends on different sides of the line through the other one.
    """
    scale = np.linalg.norm(b - a, axis=1) * np.linalg.norm(d - c, axis=1)
    near = _EQUAL_DISTANCE * np.maximum(scale, 1e-300)
    left, right = _cross(b - a, c - a), _cross(b - a, d - a)
    below, above = _cross(d - c, a - c), _cross(d - c, b - c)
    first = (np.minimum(left, right) < -near) & (np.maximum(left, right) > near)
    second = (np.minimum(below, above) < -near) & (np.maximum(below, above) > near)
    return np.asarray(first & second, np.bool_)


def _is_star_shaped(contour: FloatArray) -> bool:
    """Return whether a contour turns once around its middle, so that it cannot cross itself; most profiles do."""
    away = contour - contour.mean(axis=0)
    turns = _cross(away, np.roll(away, -1, axis=0))
    angles = np.arctan2(turns, np.sum(away * np.roll(away, -1, axis=0), axis=1))
    return bool((turns > 0.0).all() or (turns < 0.0).all()) and abs(abs(float(angles.sum())) - math.tau) < 1e-6


_MAX_CUTS = 32  # levels of cuts; each takes the time of sorting


def apart(contours: Sequence[FloatArray]) -> list[list[FloatArray]]:
    """Return contours in groups that straight cuts along the axes separate, such as the letters of a text."""
    nonempty = [contour for contour in contours if len(contour)]
    low = np.array([contour.min(axis=0) for contour in nonempty]).reshape(-1, 2)
    high = np.array([contour.max(axis=0) for contour in nonempty]).reshape(-1, 2)
    groups: list[list[int]] = []
    waiting = [(np.arange(len(nonempty)), 0)] if nonempty else []
    while waiting:
        group, depth = waiting.pop()
        pieces = max((_separated(group, low[:, axis], high[:, axis]) for axis in (0, 1)), key=len)
        if len(pieces) == 1 or depth == _MAX_CUTS:
            groups.append(sorted(group.tolist()))
        else:
            waiting += [(piece, depth + 1) for piece in pieces]
    return [[nonempty[index] for index in group] for group in sorted(groups)]


def _separated(group: IntArray, low: FloatArray, high: FloatArray) -> list[IntArray]:
    """Return a group of intervals in pieces with gaps between them."""
    order = group[np.argsort(low[group], kind="stable")]
    reached = np.maximum.accumulate(high[order])
    return np.split(order, np.flatnonzero(low[order[1:]] > reached[:-1]) + 1)


# --- curves of outlines ----------------------------------------------------------------------------------------------


class Unreadable(ValueError):
    """Error in an outline; its text is part of a message for users."""


_COMPONENT_POINTS = 8  # cost of a component: glyphs of an untrusted font may consist of nothing else
_MAX_COMPONENT_DEPTH = 16  # glyphs in glyphs: an untrusted font may nest them without end


class OutlinePen:
    """Records outlines drawn with the methods of fontTools' pens, and makes contours of them.

    Parameters
    ----------
    limit : int
        Maximum number of pieces, including components; more raise Unreadable.
    glyphs : mapping, optional
        Glyphs by name, for components.
    """

    def __init__(self, limit: int, glyphs: Any = None) -> None:
        self._room = limit
        self._glyphs = glyphs
        self._depth = 0
        self._matrix = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
        # For each contour its pieces, each as its points after the end of the piece before.
        self._contours: list[list[list[Point2]]] = []
        self._first: Point2 | None = None

    def _spend(self, count: int) -> None:
        """Count points; raise Unreadable if there are too many."""
        self._room -= count
        if self._room < 0:
            raise Unreadable("the outline has too many points")

    def _placed(self, point: Any) -> Point2:
        """Return a point of a component in the frame of the glyph."""
        a, b, c, d, e, f = self._matrix
        x, y = float(point[0]), float(point[1])
        return a * x + c * y + e, b * x + d * y + f

    def _add(self, points: Sequence[Any]) -> None:
        """Append a line or curve, given by its control points after the first."""
        self._spend(len(points))
        if self._first is None:
            raise Unreadable("a line before the first point")
        if not self._contours[-1]:
            self._contours[-1].append([self._first])
        self._contours[-1].append([self._placed(point) for point in points])

    def moveTo(self, point: Any) -> None:
        """Begin a contour."""
        self._spend(1)
        self._first = self._placed(point)
        self._contours.append([])

    def lineTo(self, point: Any) -> None:
        """Draw a line."""
        self._add([point])

    def curveTo(self, *points: Any) -> None:
        """Draw a cubic curve; fontTools allows more than two control points, which are several curves."""
        from fontTools.pens.basePen import decomposeSuperBezierSegment

        if len(points) <= 3:
            self._add(points)
            return
        self._spend(len(points))
        for piece in decomposeSuperBezierSegment(points):
            self._add(piece)

    def qCurveTo(self, *points: Any) -> None:
        """Draw quadratic curves, between whose control points there are implied ones, as in TrueType."""
        from fontTools.pens.basePen import decomposeQuadraticSegment

        if points[-1] is None:  # a closed curve of control points only
            (x, y), (u, v) = points[-2], points[0]
            start = ((x + u) / 2.0, (y + v) / 2.0)
            self.moveTo(start)
            points = (*points[:-1], start)
        self._spend(len(points))
        for piece in decomposeQuadraticSegment(points) if len(points) > 1 else [points]:
            self._add(piece)

    def closePath(self) -> None:
        """Every outline counts as closed."""

    endPath = closePath

    def addComponent(self, name: str, matrix: Any) -> None:
        """Draw another glyph under a 2x3 matrix."""
        self._spend(_COMPONENT_POINTS)
        if self._depth == _MAX_COMPONENT_DEPTH:
            raise Unreadable("the components of the glyph are nested too deeply")
        before, self._depth = self._matrix, self._depth + 1
        a, b, c, d, e, f = before
        u, v, w, z, s, t = (float(x) for x in matrix)
        x, y = a * s + c * t + e, b * s + d * t + f
        self._matrix = (a * u + c * v, b * u + d * v, a * w + c * z, b * w + d * z, x, y)
        self._glyphs[name].draw(self)
        self._matrix, self._depth = before, self._depth - 1

    @property
    def size(self) -> float:
        """Larger side of the box of all points."""
        points = [point for contour in self._contours for piece in contour for point in piece]
        return float(np.ptp(np.array(points), axis=0).max()) if points else 0.0

    @property
    def pieces(self) -> int:
        """Number of lines and curves."""
        return sum(map(len, self._contours))

    def contours(self, tolerance: float) -> list[FloatArray]:
        """Return the outlines as contours that differ from them by at most ``tolerance``."""
        contours = []
        for pieces in self._contours:
            if len(pieces) < 2:
                continue
            points = [np.array(pieces[0])]
            for before, piece in pairwise(pieces):
                points.append(_flattened(np.array([before[-1], *piece]), tolerance))
            contour = _distinct(np.concatenate(points))
            if len(contour) >= 3:
                contours.append(contour)
        return contours


def _flattened(control: FloatArray, tolerance: float) -> FloatArray:
    """Return the points of a Bezier curve after its first.

    The number of steps is Wang's bound from the second differences of the control points (Wang, "The subdivision method
    for finding the intersection between two Bezier curves or surfaces", 1984).
    """
    degree = len(control) - 1
    if degree == 1:
        return control[1:]
    bend = float(np.linalg.norm(np.diff(control, 2, axis=0), axis=1).max())
    steps = math.sqrt(degree * (degree - 1) / 8.0 * bend / tolerance) if tolerance > 0.0 else 1.0
    count = min(max(1, math.ceil(steps)), _MAX_CURVE_PIECES)
    return bezier(control, np.arange(1, count + 1) / count)


# --- SVG -------------------------------------------------------------------------------------------------------------


_WRONG = lazy_pattern(r"[^MmZzLlHhVvCcSsQqTtAa0-9eE+\-.,\s]")
_MAX_SVG_CHARACTERS = 1_000_000  # of a path's data
MAX_PIECES = 100_000  # points and control points of outlines


def svg_outline(data: str, tolerance: float | None = None) -> OutlinePen:
    """Return the outlines of the data `d` of an SVG path, with y upward; arcs are within a quarter of ``tolerance``.

    Raises
    ------
    SceneError
        "value" if the data are not a path.
    """
    parse_path = require("fontTools.svgLib.path.parser", TEXT_EXTRA).parse_path
    if len(data) > _MAX_SVG_CHARACTERS:
        raise LimitError("size", f"`svg-path` expects at most {_MAX_SVG_CHARACTERS:,} characters, got {len(data):,}")
    wrong = _WRONG.search(data)
    if wrong is not None:
        raise SceneError("value", f"`svg-path` expects the data of an SVG path, got `{wrong[0]}` at {wrong.start()}")
    pen = OutlinePen(MAX_PIECES)
    try:
        parse_path(re.sub(r"\s+", " ", data), _Upwards(pen), arc_class=_arcs(tolerance))
        is_finite = math.isfinite(pen.size)
    except Unreadable as error:
        raise SceneError("value", f"`svg-path` cannot read `{data[:40]}`: {error}") from None
    except Exception:  # the parser checks little
        message = f"`svg-path` cannot read `{data[:40]}`: a command has too few or malformed numbers"
        raise SceneError("value", message) from None
    if not is_finite:
        raise SceneError("value", "`svg-path` expects finite numbers")
    return pen


# Maximum distance of a cubic curve from the quarter of a unit circle that it approximates. It falls with the sixth
# power of the angle (Goldapp, "Approximation of circular arcs by cubic polynomials", 1991).
_QUARTER_ERROR = 2.7253e-4
_MAX_ARC_STEPS = 250  # of a flattened curve, less than ``_MAX_CURVE_PIECES``


def _arcs(tolerance: float | None) -> Any:
    """Return the class that draws elliptical arcs; fontTools' makes a curve of each quarter, however large it is."""
    from fontTools.svgLib.path.arc import EllipticalArc

    class Arc(EllipticalArc):  # type: ignore[misc, unused-ignore]
        """Elliptical arc as cubic curves, as many as the tolerance requires."""

        def draw(self, pen: Any) -> None:
            """Draw the arc, or a line if its radii are 0 (SVG 1.1, F.6.2)."""
            if not self._parametrize():
                if self.target_point != self.current_point:
                    pen.lineTo((self.target_point.real, self.target_point.imag))
                return
            quarters = abs(self.theta_arc) / (math.pi / 2.0)
            count = math.ceil(quarters - 1e-3)
            if tolerance is not None:
                ratio = min(max(self.rx, self.ry) / tolerance, 1e18)
                steps = abs(self.theta_arc) * math.sqrt(ratio / 8.0)  # of the flattened arc
                exact = quarters * (4.0 * _QUARTER_ERROR * ratio) ** (1.0 / 6.0)
                count = max(count, math.ceil(exact), math.ceil(steps / _MAX_ARC_STEPS))
            for curve in _arc_curves(self.theta1, self.theta_arc, max(1, count)):
                points = (self.center_point + point for point in curve)
                placed = [complex(self.rx * p.real, self.ry * p.imag) * cmath.rect(1.0, self.angle) for p in points]
                pen.curveTo(*((point.real, point.imag) for point in placed))

    return Arc


def _arc_curves(start: float, turn: float, count: int) -> Iterator[tuple[complex, complex, complex]]:
    """Yield the control points after the first of cubic curves along an arc of the unit circle."""
    step = turn / count
    arm = 4.0 / 3.0 * math.tan(step / 4.0) * 1j
    for number in range(count):
        before, after = (cmath.rect(1.0, start + (number + part) * step) for part in (0, 1))
        yield before * (1.0 + arm), after * (1.0 - arm), after


class _Upwards:
    """Pen that forwards the drawing of an SVG path to another one, with y upward."""

    def __init__(self, pen: OutlinePen) -> None:
        self._pen = pen

    def __getattr__(self, name: str) -> Any:
        draw = getattr(self._pen, name)
        return lambda *points: draw(*((x, -y) for x, y in points))
