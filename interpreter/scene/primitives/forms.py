"""Canonical forms: what primitives are up to an affine pose, in the cube [-1, 1]^3, many at a time.

A backend groups what it draws by form and asks the form: where rays meet it, how far it reaches, its triangles. What no
pose can express is a form's ``ratios``, numbers that go into every question; a torus has one. So ten thousand different
tori are still one call.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from scenelang.interpreter.scene.primitives.lazy import np
from scenelang.interpreter.scene.primitives.mesh import Mesh, joined

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]
    IntArray = npt.NDArray[np.int64]
    BoolArray = npt.NDArray[np.bool_]
    Interval = tuple[npt.NDArray[np.floating], npt.NDArray[np.floating]]

Triple = tuple[Any, Any, Any]
Ratios = tuple[Any, ...]  # floats, or arrays that broadcast with what is asked
Rows = tuple[float, float, float, float, float, float, float, float, float, float, float, float]
TINY = 1e-200


class CanonicalForm:
    """One canonical form.

    ``ratios`` is how many numbers tell its members apart. ``o`` and ``d`` are tuples of three arrays (or floats) that
    broadcast: origin and direction of rays, ``d`` never zero. Ray arithmetic runs into infinities on purpose: callers
    hold ``numpy.errstate(all="ignore")``.
    """

    name: ClassVar[str]
    ratios: ClassVar[int] = 0
    # Whether it has no flat face at all, as a ball: such things go into one another on purpose.
    is_rounded: ClassVar[bool] = False
    is_convex: ClassVar[bool] = True
    is_curved: ClassVar[bool] = True  # whether the number of sides matters to its mesh
    is_closed: ClassVar[bool] = True  # whether light passes its surface twice
    # Whether its Mitsuba shapes reach into one another, which is seen where light passes them.
    overlaps: ClassVar[bool] = False
    # Below this ratio of least to greatest half axis its exact Mitsuba shapes, in single precision, dissolve.
    flattest: ClassVar[float] = 0.0

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        """Where rays enter and leave, one pair of ray parameters after the other; the first of a pair is above the
        second where there is none. A convex form has one pair."""
        raise NotImplementedError

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        """Outward normals (N, 3), of any length, at surface points (N, 3)."""
        raise NotImplementedError

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        """Farthest points (N, 3) along ``directions`` (N, 3): of the convex hull, where the form is not convex."""
        raise NotImplementedError

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray, ratios: Ratios) -> BoolArray:
        """Whether the points (u, v, w) lie inside or on the surface."""
        raise NotImplementedError

    def mesh(self, segments: int, ratios: Ratios) -> Mesh:
        """The closed surface; a full circle has ``segments`` >= 3 sides, with vertices on the true surface."""
        raise NotImplementedError

    def face_count(self, segments: Any, ratios: Ratios) -> Any:
        """About how many triangles ``mesh`` makes; ``segments`` may be an array."""
        raise NotImplementedError

    def vertex_count(self, segments: int, ratios: Ratios) -> int:
        """About how many vertices ``mesh`` makes."""
        return int(self.face_count(segments, ratios))

    def charts(self, half: Sequence[float], ratios: Ratios) -> list[Chart]:
        """The surface in pieces that can be sampled, the form stretched by the three ``half`` sizes (those of the pose
        of a primitive, which keeps round forms round)."""
        raise NotImplementedError

    def volume(self, ratios: Ratios) -> float:
        """What the form encloses, before any pose."""
        raise NotImplementedError

    # --- what a form may say beside its geometry ---

    def hull(self, ratios: Ratios) -> FloatArray:
        """Few points (K, 3), or (N, K, 3) for arrays of ratios, whose convex hull holds the form."""
        return np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])

    def outline(self) -> tuple[FloatArray, ...] | None:
        """Points, disks and ellipsoids whose convex hull is that of the form, each (3, K): K - 1 half axes and the
        centre. None where there are no such pieces, or the ratios change them."""
        return None

    def thickness(self, ratios: tuple[float, ...]) -> float:
        """How thick it is where it is thinnest, as a share of the cube that it lies in."""
        return 1.0

    def flat_faces(self, ratios: Ratios) -> Iterator[tuple[int, float, FloatArray]]:
        """The flat faces that look along an axis: the axis, the side (-1 or 1), the corners (K, 3)."""
        return iter(())

    def mitsuba(self, ratios: Ratios) -> list[dict[str, Any]]:
        """Mitsuba's shapes that together are exactly the form, as plain data with poses (4, 4); none where it has no
        such shapes, so that the mesh stands for the form."""
        return []

    def usd(self, ratios: Ratios) -> tuple[str, dict[str, tuple[str, Any]]] | None:
        """A schema of OpenUSD that is exactly the form: its name, and for each attribute its type (as
        ``Sdf.ValueTypeNames`` spells it) and value. None: a mesh."""
        return None

    def gltf(self, ratios: Ratios) -> dict[str, Any] | None:
        """What the ``extras`` of a glTF mesh say of the exact form that its triangles stand for, since glTF has no such
        shapes of its own; None: nothing."""
        return {"form": self.name, "ratios": list(ratios)} if ratios else None


# --- surfaces that are sampled ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Chart:
    """A part of a surface with this ``area``: ``place(u, v)`` gives points and unit normals (K, 3) for numbers (K,) in
    [0, 1), without changing ratios of areas."""

    area: float
    place: Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


def on_circle(radius: FloatArray, turn: FloatArray, y: FloatArray) -> FloatArray:
    """Points (K, 3) about the y axis, ``turn`` in full turns."""
    angle = 2.0 * math.pi * turn
    return np.stack([radius * np.sin(angle), y, radius * np.cos(angle)], axis=1)


def rectangle_chart(half: Sequence[float], axis: int, side: float, away: float | None = None) -> Chart:
    """A face of a block of the half sizes ``half``, ``away`` from the centre; the lattice's steps go along its longer
    side."""
    long, short = sorted((k for k in range(3) if k != axis), key=lambda k: -half[k])
    distance = half[axis] if away is None else away

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        places, normals = np.zeros((2, len(u), 3))
        places[:, axis], normals[:, axis] = side * distance, side
        places[:, long], places[:, short] = (2.0 * u - 1.0) * half[long], (2.0 * v - 1.0) * half[short]
        return places, normals

    return Chart(4.0 * half[long] * half[short], place)


def sphere_chart(radius: float) -> Chart:
    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        y = 1.0 - 2.0 * u
        normals = on_circle(np.sqrt(1.0 - y * y), v, y)
        return radius * normals, normals

    return Chart(4.0 * math.pi * radius * radius, place)


def tube_chart(radius: float, half: float) -> Chart:
    """The side of a cylinder about the y axis."""

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        return on_circle(radius + 0.0 * u, v, (2.0 * u - 1.0) * half), on_circle(1.0 + 0.0 * u, v, 0.0 * u)

    return Chart(4.0 * math.pi * radius * half, place)


def disc_chart(radius: float, y: float, up: float) -> Chart:
    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        return on_circle(radius * np.sqrt(u), v, y + 0.0 * u), np.tile([0.0, up, 0.0], (len(u), 1))

    return Chart(math.pi * radius * radius, place)


# --- rays ------------------------------------------------------------------------------------------------------------


def first_hits(intervals: Iterable[Interval], near: float) -> list[npt.NDArray[np.floating]]:
    """For each interval the first ray parameter above ``near`` on the surface, infinity where there is none."""
    found = []
    for enter, leave in intervals:
        hit = np.where(enter > near, enter, leave)
        found.append(np.where((enter <= leave) & (hit > near), hit, np.inf))
    return found


def nearest_hit(form: CanonicalForm, o: Triple, d: Triple, ratios: Ratios, near: float) -> npt.NDArray[np.floating]:
    """The first ray parameter above ``near`` on the surface, infinity where there is none."""
    first, *others = first_hits(form.intervals(o, d, ratios), near)
    for other in others:
        first = np.minimum(first, other)
    return first


def slab(o: Any, d: Any, half: Any = 1.0) -> Interval:
    """Where rays are between the planes at -half and half of one coordinate."""
    inverse = 1.0 / np.where(np.abs(d) < TINY, TINY, d)
    first, second = (-half - o) * inverse, (half - o) * inverse
    return np.minimum(first, second), np.maximum(first, second)


def between(*intervals: Interval) -> Interval:
    """Where rays are in all of the intervals."""
    enter, leave = intervals[0]
    for first, last in intervals[1:]:
        enter, leave = np.maximum(enter, first), np.minimum(leave, last)
    return enter, leave


def in_any(*intervals: Interval) -> Interval:
    """From the first entry to the last exit: the interval of a convex union. What is not a number is a miss."""
    enter: Any = np.inf
    leave: Any = -np.inf
    for first, last in intervals:
        hits = first <= last
        enter, leave = (
            np.minimum(enter, np.where(hits, first, np.inf)),
            np.maximum(leave, np.where(hits, last, -np.inf)),
        )
    return np.asarray(enter), np.asarray(leave)


def in_ball(o: Triple, d: Triple, radius: Any = 1.0) -> Interval:
    """Where rays are in the ball about the origin; not a number where they miss."""
    a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    b = o[0] * d[0] + o[1] * d[1] + o[2] * d[2]
    c = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - radius * radius
    root = np.sqrt(b * b - a * c)
    return (-b - root) / a, (root - b) / a


def in_tube(o: tuple[Any, Any], d: tuple[Any, Any], radius: Any = 1.0) -> Interval:
    """Where rays are in the endless round tube about an axis, of which ``o`` and ``d`` have the two other coordinates;
    not a number where they miss."""
    a = np.maximum(d[0] * d[0] + d[1] * d[1], TINY)
    b = o[0] * d[0] + o[1] * d[1]
    c = o[0] * o[0] + o[1] * o[1] - radius * radius
    root = np.sqrt(b * b - a * c)
    return (-b - root) / a, (root - b) / a


def unit(vectors: FloatArray) -> FloatArray:
    """Unit vectors; zero where there is no direction."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    found: FloatArray = vectors / np.where(length > 0.0, length, 1.0)
    return found


def box_corners(half: Sequence[Any]) -> FloatArray:
    """The corners (8, 3) of a block of the three half sizes, or (N, 8, 3) where these are arrays (N,)."""
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    sizes = np.stack(np.broadcast_arrays(*half), axis=-1)
    found: FloatArray = corners * (sizes if sizes.ndim == 1 else sizes[:, None, :])
    return found


# --- meshes of round things about the y axis -------------------------------------------------------------------------


def circle(segments: int) -> tuple[FloatArray, FloatArray]:
    """Cosine and sine (segments,) of even steps round a circle."""
    angle = np.arange(segments) * (2.0 * math.pi / segments)
    return np.cos(angle), np.sin(angle)


def side_mesh(segments: int, top: float) -> Mesh:
    """The side from radius 1 at y = -1 to radius ``top`` at y = 1."""
    cosine, sine = circle(segments)
    ones = np.ones(segments)
    slope = (1.0 - top) / 2.0
    normal = np.stack([sine, slope * ones, cosine], axis=1) / math.hypot(1.0, slope)
    low = np.stack([sine, -ones, cosine], axis=1)
    here = np.arange(segments)
    after = (here + 1) % segments
    if top > 0.0:
        high = np.stack([top * sine, ones, top * cosine], axis=1)
        faces = [
            np.stack([here, after, segments + after], axis=1),
            np.stack([here, segments + after, segments + here], axis=1),
        ]
        return Mesh(np.concatenate([low, high]), np.concatenate([normal, normal]), np.concatenate(faces))
    middle = normal + normal[after]  # the apex has one vertex, and one normal, per side
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    apex = np.tile([0.0, 1.0, 0.0], (segments, 1))
    faces = [np.stack([here, after, segments + here], axis=1)]
    return Mesh(np.concatenate([low, apex]), np.concatenate([normal, middle]), np.concatenate(faces))


def cap_mesh(segments: int, y: float) -> Mesh:
    """The unit disk at height ``y``, looking away from the origin."""
    cosine, sine = circle(segments)
    rim = np.stack([sine, np.full(segments, y), cosine], axis=1)
    vertices = np.concatenate([rim, [[0.0, y, 0.0]]])
    here = np.arange(segments)
    after = (here + 1) % segments
    center = np.full(segments, segments)
    faces = np.stack([here, after, center] if y > 0 else [after, here, center], axis=1)
    return Mesh(vertices, np.tile([0.0, math.copysign(1.0, y), 0.0], (segments + 1, 1)), faces)


def turned_mesh(radius: FloatArray, y: FloatArray, normal: FloatArray, segments: int) -> Mesh:
    """The surface that a profile from bottom to top makes as it turns about the y axis: ``radius`` and ``y`` (P,), unit
    ``normal`` (P, 2) outwards and up. Where the radius is 0 at an end, all vertices there are one point."""
    cosine, sine = circle(segments)
    rows = len(radius)
    vertices = np.stack(
        [radius[:, None] * sine, np.broadcast_to(y[:, None], (rows, segments)), radius[:, None] * cosine], axis=2
    )
    normals = np.stack(
        [normal[:, :1] * sine, np.broadcast_to(normal[:, 1:], (rows, segments)), normal[:, :1] * cosine], axis=2
    )
    here = np.arange(segments)
    after = (here + 1) % segments
    faces = []
    for row in range(rows - 1):
        low, high = row * segments, (row + 1) * segments
        if radius[row] > 0.0:
            faces.append(np.stack([low + here, low + after, high + after], axis=1))
        if radius[row + 1] > 0.0:
            faces.append(np.stack([low + here, high + after, high + here], axis=1))
    return Mesh(vertices.reshape(-1, 3), normals.reshape(-1, 3), np.concatenate(faces))


def segments_within(tolerance: float, radius: float) -> int:
    """How many sides a circle needs so that none lies more than ``tolerance`` inside it: 8 to 512."""
    share = min(1.0, tolerance / radius) if radius > 0.0 else 1.0
    return min(512, max(8, math.ceil(math.pi / math.acos(1.0 - share)))) if share > 0.0 else 512


def axis_rows(p0: Sequence[float], p1: Sequence[float], radius: float) -> Rows | None:
    """The pose that takes the canonical axis, from y = -1 to y = 1, to p0 and p1, and what is 1 wide to ``radius``;
    None where these are one point."""
    (x0, y0, z0), (x1, y1, z1) = p0, p1
    u, v, w = x1 - x0, y1 - y0, z1 - z0
    largest = max(abs(u), abs(v), abs(w))
    if largest == 0.0:
        return None
    i, j, k = u / largest, v / largest, w / largest
    length = math.sqrt(i * i + j * j + k * k)
    i, j, k = i / length, j / length, k / length
    # across is the product of the axis with the coordinate axis that it is least along
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
    """The triangle with the corners (-1, -1, 0), (1, -1, 0), (-1, 1, 0): what meshes are made of."""

    name = "triangle"
    is_curved = False
    is_closed = False
    _seam = 1e-9  # by which triangles overlap, so that no ray passes between neighbours

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        t = -o[2] / np.where(np.abs(d[2]) < TINY, TINY, d[2])
        x, y = o[0] + t * d[0], o[1] + t * d[1]
        inside = (x >= -1.0 - self._seam) & (y >= -1.0 - self._seam) & (x + y <= self._seam)
        return [(np.where(inside, t, np.inf), np.where(inside, t, -np.inf))]

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        return np.broadcast_to(np.array([0.0, 0.0, 1.0]), points.shape)

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        found: FloatArray = self.hull(ratios)[np.argmax(directions @ self.hull(ratios).T, axis=1)]
        return found

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


TRIANGLE = TriangleForm()

__all__ = [
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
    "disc_chart",
    "first_hits",
    "in_any",
    "in_ball",
    "in_tube",
    "joined",
    "nearest_hit",
    "on_circle",
    "rectangle_chart",
    "segments_within",
    "side_mesh",
    "slab",
    "sphere_chart",
    "tube_chart",
    "turned_mesh",
    "unit",
]  # fmt: skip
