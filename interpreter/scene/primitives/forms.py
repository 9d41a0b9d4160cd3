"""Canonical forms: the shapes of primitives up to an affine pose, inside the cube [-1, 1]^3, processed in batches.

Backends group primitives by form and call the methods of the form: ray intersection, support, triangles. Parameters
that no affine pose can express are the ``ratios`` of a form, numbers beside each instance's pose, which are passed to
every method as arrays; a torus has one. Ten thousand different tori are therefore still one call.

A primitive that is not a canonical form under a pose is a triangle mesh everywhere, because tracing a mesh of a million
triangles ray by ray is too slow, and the image renderer treats triangles as solids.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.primitives.mesh import Mesh, joined

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]
    IntArray = npt.NDArray[np.int64]
    BoolArray = npt.NDArray[np.bool_]
    Interval = tuple[npt.NDArray[np.floating], npt.NDArray[np.floating]]

Triple = tuple[Any, Any, Any]
Ratios = tuple[Any, ...]  # floats, or arrays that broadcast with the other arguments
Rows = tuple[float, float, float, float, float, float, float, float, float, float, float, float]
TINY = 1e-200  # replaces zero denominators


class CanonicalForm:
    """Canonical form.

    ``ratios`` is the number of shape parameters. In ray methods, ``o`` and ``d`` are tuples of three arrays (or floats)
    that broadcast: origin and direction of the rays, the direction never zero. Ray arithmetic produces infinities and
    NaNs on purpose, so callers must use ``numpy.errstate(all="ignore")``.
    """

    name: ClassVar[str]
    ratios: ClassVar[int] = 0
    shading_ratios: ClassVar[int] = 0  # how many of them, the last ones, change normals only
    # Whether it has no flat face, like a ball; such primitives may overlap on purpose.
    is_rounded: ClassVar[bool] = False
    is_convex: ClassVar[bool] = True
    is_curved: ClassVar[bool] = True  # whether its mesh depends on the number of segments
    is_closed: ClassVar[bool] = True  # whether rays cross the surface an even number of times
    is_triangle: ClassVar[bool] = False
    is_doubly_curved: ClassVar[bool] = False  # in two directions at a point, as a sphere is
    is_one_sided: ClassVar[bool] = False  # a face of a closed surface: only rays against its normal, +z, can see it
    # Whether its Mitsuba shapes overlap, which is visible in transparent materials.
    overlaps: ClassVar[bool] = False
    # Below this ratio of the shortest to the longest half axis, Mitsuba's shapes are inaccurate in single precision.
    min_aspect_ratio: ClassVar[float] = 0.0

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        """Return the intervals of ray parameters inside the form, as pairs (enter, leave).

        An interval with ``enter > leave`` is empty. A convex form has one interval.
        """
        raise NotImplementedError

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        """Return outward normals (N, 3), not normalized, at surface points (N, 3)."""
        raise NotImplementedError

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        """Return the farthest points (N, 3) of the convex hull of the form along ``directions`` (N, 3)."""
        raise NotImplementedError

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray, ratios: Ratios) -> BoolArray:
        """Return whether the points (u, v, w) lie inside or on the surface."""
        raise NotImplementedError

    def mesh(self, segments: int, ratios: Ratios) -> Mesh:
        """Return the closed surface; a full circle has ``segments`` >= 3 sides, with vertices on the true surface."""
        raise NotImplementedError

    def segments_within(self, tolerance: float, radius: float) -> int:
        """Return the segments of a mesh within ``tolerance`` of the surface, of which ``radius`` is the largest.

        Where a surface is curved in two directions, the sagittas of both add up: with the whole tolerance for each, a
        sphere within 1 mm was up to 1.93 mm off.
        """
        return segments_within(tolerance / 2.0 if self.is_doubly_curved else tolerance, radius)

    def face_count(self, segments: Any, ratios: Ratios) -> Any:
        """Return the approximate number of triangles of ``mesh``; ``segments`` may be an array."""
        raise NotImplementedError

    def vertex_count(self, segments: int, ratios: Ratios) -> int:
        """Return the approximate number of vertices of ``mesh``."""
        return int(self.face_count(segments, ratios))

    def charts(self, half: Sequence[float], ratios: Ratios) -> list[Chart]:
        """Return the surface as charts that can be sampled uniformly.

        ``half`` are the three scale factors of the pose, which keep circular cross-sections circular.
        """
        raise NotImplementedError

    def volume(self, ratios: Ratios) -> float:
        """Return the volume of the form itself, without a pose; it scales by the determinant of the pose."""
        raise NotImplementedError

    # --- optional properties ---

    def hull(self, ratios: Ratios) -> FloatArray:
        """Return a few points whose convex hull contains the form.

        The points have the shape (K, 3), or (N, K, 3) if the ``ratios``, the shape parameters of the form, are arrays
        (N,) of several instances. They are the corners of the cube [-1, 1]^3 unless a form has tighter ones.
        """
        return np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])

    def outline(self) -> tuple[FloatArray, ...] | None:
        """Return points, disks and ellipsoids with the same convex hull as the form, or None if there are none.

        Each piece is an array (3, K): K - 1 half axes and the center. The pieces must not depend on the ratios.
        """
        return None

    def thickness(self, ratios: tuple[float, ...]) -> float:
        """Return the minimum thickness relative to the bounding cube."""
        return 1.0

    def flat_faces(self, ratios: Ratios) -> Iterator[tuple[int, float, FloatArray]]:
        """Iterate over the flat faces perpendicular to an axis: the axis, the side (-1 or 1), the corners (K, 3)."""
        return iter(())

    def mitsuba(self, ratios: Ratios) -> list[dict[str, Any]]:
        """Return Mitsuba shapes that together represent the form exactly, as plain data with poses (4, 4).

        An empty list means that the mesh is used.
        """
        return []

    def usd(self, ratios: Ratios) -> tuple[str, dict[str, tuple[str, Any]]] | None:
        """Return the OpenUSD schema that represents the form exactly, or None to use the mesh.

        Returns
        -------
        tuple of (str, dict)
            Name of the schema, and for each attribute its type (as in ``Sdf.ValueTypeNames``) and value.
        """
        return None

    def gltf(self, ratios: Ratios) -> dict[str, Any] | None:
        """Return the ``extras`` of a glTF mesh that describe the exact form, or None.

        glTF has no analytic shapes, so the mesh itself contains triangles.
        """
        return {"form": self.name, "ratios": list(ratios)} if ratios else None


# --- surface sampling ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Chart:
    """Area-preserving chart of a part of a surface.

    ``place(u, v)`` maps parameters (K,) in [0, 1) to points and unit normals (K, 3).
    """

    area: float
    place: Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


def on_circle(radius: FloatArray, fraction: FloatArray, y: FloatArray) -> FloatArray:
    """Return points (K, 3) on circles around the y axis; ``fraction`` is the angle in full turns."""
    angle = 2.0 * math.pi * fraction
    return np.stack([radius * np.sin(angle), y, radius * np.cos(angle)], axis=1)


def rectangle_chart(half: Sequence[float], axis: int, side: float, distance: float | None = None) -> Chart:
    """Return the chart of a face of a box around the origin.

    The parameter u runs along the longer side of the face, v along the shorter one.

    Parameters
    ----------
    half : (3,)
        Half sizes of the box.
    axis, side
        Direction of the normal: an axis (0 to 2), and 1 along it or -1 against it.
    distance
        Distance of the face from the origin; by default, the half size of the box along the axis.
    """
    long, short = sorted((k for k in range(3) if k != axis), key=lambda k: -half[k])
    offset = half[axis] if distance is None else distance

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Map the unit square to points and normals."""
        places, normals = np.zeros((2, len(u), 3))
        places[:, axis], normals[:, axis] = side * offset, side
        places[:, long], places[:, short] = (2.0 * u - 1.0) * half[long], (2.0 * v - 1.0) * half[short]
        return places, normals

    return Chart(4.0 * half[long] * half[short], place)


def sphere_chart(radius: float) -> Chart:
    """Return the chart of a sphere around the origin (Archimedes' equal-area cylindrical projection)."""

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Map the unit square to points and normals."""
        y = 1.0 - 2.0 * u
        normals = on_circle(np.sqrt(1.0 - y * y), v, y)
        return radius * normals, normals

    return Chart(4.0 * math.pi * radius * radius, place)


def tube_chart(radius: float, half: float) -> Chart:
    """Return the chart of the side of a cylinder around the y axis, from ``y = -half`` to ``y = half``."""

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Map the unit square to points and normals."""
        return on_circle(radius + 0.0 * u, v, (2.0 * u - 1.0) * half), on_circle(1.0 + 0.0 * u, v, 0.0 * u)

    return Chart(4.0 * math.pi * radius * half, place)


def disk_chart(radius: float, y: float, up: float) -> Chart:
    """Return the chart of a disk around the y axis.

    Parameters
    ----------
    radius
        Radius of the disk.
    y
        Height of the disk.
    up
        y coordinate of its unit normal: 1.0 up, -1.0 down.
    """

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Map the unit square to points and normals: v is the angle in full turns, u the share of the area inside."""
        return on_circle(radius * np.sqrt(u), v, y + 0.0 * u), np.tile([0.0, up, 0.0], (len(u), 1))

    return Chart(math.pi * radius * radius, place)


# --- ray intersection ------------------------------------------------------------------------------------------------


def first_hits(intervals: Iterable[Interval], near: float) -> list[npt.NDArray[np.floating]]:
    """Return for each interval the first boundary above ``near``, infinity if there is none."""
    hits = []
    for enter, leave in intervals:
        hit = np.where(enter > near, enter, leave)
        hits.append(np.where((enter <= leave) & (hit > near), hit, np.inf))
    return hits


def nearest_hit(form: CanonicalForm, o: Triple, d: Triple, ratios: Ratios, near: float) -> npt.NDArray[np.floating]:
    """Return for each ray the first ray parameter above ``near`` at which it meets the surface, infinity for a miss.

    Parameters
    ----------
    form
        The form.
    o, d
        Origins and directions of the rays, each as the three arrays of its coordinates.
    ratios
        Shape parameters of the form.
    near
        Smallest ray parameter, which excludes the surface at the origin of a ray.
    """
    first, *others = first_hits(form.intervals(o, d, ratios), near)
    for other in others:
        first = np.minimum(first, other)
    return first


def slab(o: Any, d: Any, half: Any = 1.0) -> Interval:
    """Return the interval of ray parameters between the planes at ``-half`` and ``half`` of one coordinate.

    ``o`` and ``d`` are this coordinate of the origins and directions of the rays.
    """
    inverse = 1.0 / np.where(np.abs(d) < TINY, TINY, d)
    first, second = (-half - o) * inverse, (half - o) * inverse
    return np.minimum(first, second), np.maximum(first, second)


def between(*intervals: Interval) -> Interval:
    """Return the intersection of the intervals."""
    enter, leave = intervals[0]
    for first, last in intervals[1:]:
        enter, leave = np.maximum(enter, first), np.minimum(leave, last)
    return enter, leave


def in_any(*intervals: Interval) -> Interval:
    """Return the interval from the first entry to the last exit: the union, if it is convex. NaN counts as a miss."""
    enter: Any = np.inf
    leave: Any = -np.inf
    for first, last in intervals:
        hits = first <= last
        enter = np.minimum(enter, np.where(hits, first, np.inf))
        leave = np.maximum(leave, np.where(hits, last, -np.inf))
    return np.asarray(enter), np.asarray(leave)


def in_ball(o: Triple, d: Triple, radius: Any = 1.0) -> Interval:
    """Return the interval of ray parameters in a ball of ``radius`` around the origin; NaN for a miss.

    ``o`` and ``d`` are origins and directions of rays, each as the three arrays of its coordinates.
    """
    a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    b = o[0] * d[0] + o[1] * d[1] + o[2] * d[2]
    c = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - radius * radius
    root = np.sqrt(b * b - a * c)
    return (-b - root) / a, (root - b) / a


def in_tube(o: tuple[Any, Any], d: tuple[Any, Any], radius: Any = 1.0) -> Interval:
    """Return the interval of rays inside an infinite cylinder around an axis; NaN for a miss.

    ``o`` and ``d`` hold the two coordinates perpendicular to the axis.
    """
    a = np.maximum(d[0] * d[0] + d[1] * d[1], TINY)
    b = o[0] * d[0] + o[1] * d[1]
    c = o[0] * o[0] + o[1] * o[1] - radius * radius
    root = np.sqrt(b * b - a * c)
    return (-b - root) / a, (root - b) / a


def unit(vectors: FloatArray) -> FloatArray:
    """Normalize vectors (N, 3); zero vectors stay zero."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    normalized: FloatArray = vectors / np.where(length > 0.0, length, 1.0)
    return normalized


def box_corners(half: Sequence[Any]) -> FloatArray:
    """Return the corners (8, 3) of a box with the three half sizes, or (N, 8, 3) for arrays (N,)."""
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    sizes = np.stack(np.broadcast_arrays(*half), axis=-1)
    scaled: FloatArray = corners * (sizes if sizes.ndim == 1 else sizes[:, None, :])
    return scaled


# --- meshes with rotational symmetry around the y axis ---------------------------------------------------------------


def circle(segments: int) -> tuple[FloatArray, FloatArray]:
    """Return cosine and sine (segments,) of equal steps around a circle."""
    angle = np.arange(segments) * (2.0 * math.pi / segments)
    return np.cos(angle), np.sin(angle)


def side_mesh(segments: int, top: float) -> Mesh:
    """Return the side of a cylinder or cone from radius 1 at y = -1 to radius ``top`` at y = 1."""
    cosine, sine = circle(segments)
    ones = np.ones(segments)
    slope = (1.0 - top) / 2.0
    normal = np.stack([sine, slope * ones, cosine], axis=1) / math.hypot(1.0, slope)
    low = np.stack([sine, -ones, cosine], axis=1)
    side = np.arange(segments)
    after = (side + 1) % segments
    if top > 0.0:
        high = np.stack([top * sine, ones, top * cosine], axis=1)
        faces = [
            np.stack([side, after, segments + after], axis=1),
            np.stack([side, segments + after, segments + side], axis=1),
        ]
        return Mesh(np.concatenate([low, high]), np.concatenate([normal, normal]), np.concatenate(faces))
    middle = normal + normal[after]  # the apex has one vertex and one normal per side
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    apex = np.tile([0.0, 1.0, 0.0], (segments, 1))
    faces = [np.stack([side, after, segments + side], axis=1)]
    return Mesh(np.concatenate([low, apex]), np.concatenate([normal, middle]), np.concatenate(faces))


def cap_mesh(segments: int, y: float) -> Mesh:
    """Return the unit disk at height ``y``, facing away from the origin."""
    cosine, sine = circle(segments)
    rim = np.stack([sine, np.full(segments, y), cosine], axis=1)
    vertices = np.concatenate([rim, [[0.0, y, 0.0]]])
    side = np.arange(segments)
    after = (side + 1) % segments
    center = np.full(segments, segments)
    faces = np.stack([side, after, center] if y > 0 else [after, side, center], axis=1)
    return Mesh(vertices, np.tile([0.0, math.copysign(1.0, y), 0.0], (segments + 1, 1)), faces)


def revolved_mesh(radius: FloatArray, y: FloatArray, normal: FloatArray, segments: int) -> Mesh:
    """Return the surface of revolution of a profile around the y axis.

    Parameters
    ----------
    radius, y : (P,)
        Profile from bottom to top. If the radius at an end is 0, all vertices there are one point.
    normal : (P, 2)
        Unit normals, outward and upward components.
    segments
        Number of sides.
    """
    cosine, sine = circle(segments)
    rows = len(radius)
    vertices = np.stack(
        [radius[:, None] * sine, np.broadcast_to(y[:, None], (rows, segments)), radius[:, None] * cosine], axis=2
    )
    normals = np.stack(
        [normal[:, :1] * sine, np.broadcast_to(normal[:, 1:], (rows, segments)), normal[:, :1] * cosine], axis=2
    )
    side = np.arange(segments)
    after = (side + 1) % segments
    faces = []
    for row in range(rows - 1):
        low, high = row * segments, (row + 1) * segments
        if radius[row] > 0.0:
            faces.append(np.stack([low + side, low + after, high + after], axis=1))
        if radius[row + 1] > 0.0:
            faces.append(np.stack([low + side, high + after, high + side], axis=1))
    return Mesh(vertices.reshape(-1, 3), normals.reshape(-1, 3), np.concatenate(faces))


_MIN_SEGMENTS, _MAX_SEGMENTS = 8, 512  # sides of a full circle


def segments_within(tolerance: float, radius: float) -> int:
    """Return the number of sides of a polygon within ``tolerance`` of its circumscribed circle, from 8 to 512.

    The largest distance, the sagitta, is ``radius * (1 - cos(pi / n))``.
    """
    share = min(1.0, tolerance / radius) if radius > 0.0 else 1.0
    angle = math.acos(1.0 - share)  # 0 if the share is below the precision of a double
    if angle == 0.0:
        return _MAX_SEGMENTS
    return min(_MAX_SEGMENTS, max(_MIN_SEGMENTS, math.ceil(math.pi / angle)))


def axis_rows(p0: Sequence[float], p1: Sequence[float], radius: float) -> Rows | None:
    """Return the pose that maps the canonical axis, y = -1 to y = 1, to p0 and p1, and unit radius to ``radius``.

    Returns None if p0 and p1 are equal.
    """
    (x0, y0, z0), (x1, y1, z1) = p0, p1
    u, v, w = x1 - x0, y1 - y0, z1 - z0
    largest = max(abs(u), abs(v), abs(w))
    if largest == 0.0:
        return None
    i, j, k = u / largest, v / largest, w / largest
    length = math.sqrt(i * i + j * j + k * k)
    i, j, k = i / length, j / length, k / length
    # The first perpendicular is the cross product with the coordinate axis that is least parallel to the axis.
    if abs(i) <= abs(j) and abs(i) <= abs(k):
        a, b, c = 0.0, k, -j
    elif abs(j) <= abs(k):
        a, b, c = -k, 0.0, i
    else:
        a, b, c = j, -i, 0.0
    size = radius / math.sqrt(a * a + b * b + c * c)
    a, b, c = a * size, b * size, c * size
    e, f, g = b * k - c * j, c * i - a * k, a * j - b * i
    return (
        a, u / 2.0, e, (x0 + x1) / 2.0,
        b, v / 2.0, f, (y0 + y1) / 2.0,
        c, w / 2.0, g, (z0 + z1) / 2.0,
    )  # fmt: skip


class TriangleForm(CanonicalForm):
    """The triangle with the corners (-1, -1, 0), (1, -1, 0), (-1, 1, 0), the element of meshes."""

    name = "triangle"
    is_curved = False
    is_closed = False
    is_triangle = True
    _seam = 1e-9  # tolerance at the edges, so that no ray passes between adjacent triangles

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        t = -o[2] / np.where(np.abs(d[2]) < TINY, TINY, d[2])
        x, y = o[0] + t * d[0], o[1] + t * d[1]
        inside = (x >= -1.0 - self._seam) & (y >= -1.0 - self._seam) & (x + y <= self._seam)
        return [(np.where(inside, t, np.inf), np.where(inside, t, -np.inf))]

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        return np.broadcast_to(np.array([0.0, 0.0, 1.0]), points.shape)

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        corners = self.hull(ratios)
        points: FloatArray = corners[np.argmax(directions @ corners.T, axis=1)]
        return points

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray, ratios: Ratios) -> BoolArray:
        return np.zeros(np.broadcast_shapes(np.shape(u), np.shape(v), np.shape(w)), np.bool_)

    def mesh(self, segments: int, ratios: Ratios) -> Mesh:
        return Mesh(self.hull(ratios), np.tile([0.0, 0.0, 1.0], (3, 1)), np.array([[0, 1, 2]]))

    def face_count(self, segments: Any, ratios: Ratios) -> Any:
        return 1 + 0 * segments

    def vertex_count(self, segments: int, ratios: Ratios) -> int:
        return 3

    def volume(self, ratios: Ratios) -> float:
        return 0.0

    def hull(self, ratios: Ratios) -> FloatArray:
        return np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0]])

    def outline(self) -> tuple[FloatArray, ...] | None:
        return tuple(corner[:, None] for corner in self.hull(()))


class FaceForm(TriangleForm):
    """A triangle of a closed surface, counter-clockwise seen from outside."""

    name = "face"
    is_one_sided = True


class SmoothFaceForm(FaceForm):
    """A triangle of a closed smooth surface: the nine ratios are the normals at its corners, in the dual of its frame.

    A normal n in the world is ``l = M.T n`` there, whatever the pose M; l is interpolated linearly.
    """

    name = "smooth-face"
    ratios = 9
    shading_ratios = 9
    is_curved = True

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        second, third = (points[:, 0] + 1.0) / 2.0, (points[:, 1] + 1.0) / 2.0  # barycentric coordinates
        shares = (1.0 - second - third, second, third)
        rows = [sum(share * ratios[3 * corner + k] for corner, share in enumerate(shares)) for k in range(3)]
        return np.stack(np.broadcast_arrays(*rows), axis=1)


TRIANGLE = TriangleForm()
FACE = FaceForm()
SMOOTH_FACE = SmoothFaceForm()

__all__ = [
    "FACE",
    "SMOOTH_FACE",
    "TRIANGLE",
    "CanonicalForm",
    "Chart",
    "Mesh",
    "Ratios",
    "Rows",
    "Triple",
    "axis_rows",
    "between",
    "box_corners",
    "cap_mesh",
    "circle",
    "disk_chart",
    "first_hits",
    "in_any",
    "in_ball",
    "in_tube",
    "joined",
    "nearest_hit",
    "on_circle",
    "rectangle_chart",
    "revolved_mesh",
    "segments_within",
    "side_mesh",
    "slab",
    "sphere_chart",
    "tube_chart",
    "unit",
]  # fmt: skip
