"""The primitive "torus": a tube around a ring in the plane y = 0.

Ray intersection: with the origin moved to the point of the ray that is nearest to the center, the quartic in the ray
parameter has no cubic term. Its extrema are the roots of a cubic in closed form (Cardano's formula, or Viète's with
three cosines if all are real). Between the extrema the quartic is monotone, so every root has its own bracket, in which
Newton's method safeguarded by bisection converges: only intersections of rays that graze the surface within rounding
are missed. The hit points lie within 1e-10 of the surface of a torus in the unit cube, which a test verifies.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.primitives import forms
from scenelang.interpreter.scene.primitives.base import RADIUS, Attribute, Placed, Primitive, Symmetry, length_of
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Chart, Mesh, Ratios, Triple
from scenelang.interpreter.scene.primitives.sphere import placed_ball

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.forms import BoolArray, FloatArray, Interval

_MAX_ITERATIONS = 60  # of Newton's method; bisection alone reaches double precision in 53
_TABLE_SIZE = 4097  # samples of the cumulative area around the tube

TUBE = Attribute(
    "tube",
    "radius of the tube of a torus, in scene units; default .25",
    "a number",
    0.25,
    length_of,
    "tube",
    ("Number",),
    0.0,
)


class TorusForm(CanonicalForm):
    """All points within 1 - R of the circle with radius R in the plane y = 0; the ratio is R.

    If the tube is thicker than the ring is wide there is no hole, and the surface is the part that is visible from
    outside (a spindle torus without its inner part). The form is not convex; ``support`` is that of its convex hull,
    which the geometric lint, made for convex bodies, uses for a ring.
    """

    name = "torus"
    is_doubly_curved = True
    ratios = 1
    is_rounded = True
    is_convex = False

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        # Only rays that meet both the bounding ball and the slab of the tube's height are intersected with the quartic.
        shape = np.broadcast_shapes(*(np.shape(x) for x in (*o, *d, *ratios)))
        enter, leave = np.full((2, *shape), np.inf), np.full((2, *shape), -np.inf)
        tube = 1.0 - np.asarray(ratios[0])
        first, last = forms.between(forms.in_ball(o, d), forms.slab(o[1], d[1], tube))
        near = np.broadcast_to(first <= last, shape)
        ox, oy, oz, dx, dy, dz, r = (np.broadcast_to(x, shape)[near] for x in (*o, *d, ratios[0]))
        if ox.size:
            roots = _crossings(np.stack([ox, oy, oz]), np.stack([dx, dy, dz]), r)
            for k in range(2):
                is_pair = np.isfinite(roots[2 * k + 1])
                enter[k][near] = np.where(is_pair, roots[2 * k], np.inf)
                leave[k][near] = np.where(is_pair, roots[2 * k + 1], -np.inf)
        return [(enter[k], leave[k]) for k in range(2)]

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        """Return the vectors from the nearest points of the ring in the middle of the tube."""
        across = np.hypot(points[:, 0], points[:, 2])
        share = 1.0 - ratios[0] / np.maximum(across, 1e-12)
        return np.stack([points[:, 0] * share, points[:, 1], points[:, 2] * share], axis=1)

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        # the farthest point of the ring, and from there that of the tube
        ring = np.asarray(ratios[0])
        point = forms.unit(directions) * (1.0 - ring)[..., None]
        flat = directions.copy()
        flat[:, 1] = 0.0
        farthest: FloatArray = point + forms.unit(flat) * ring[..., None]
        return farthest

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray, ratios: Ratios) -> BoolArray:
        away = np.sqrt(u * u + w * w) - ratios[0]
        inside: BoolArray = away * away + v * v <= (1.0 - ratios[0]) ** 2
        return inside

    def mesh(self, segments: int, ratios: Ratios) -> Mesh:
        # A profile around the tube, revolved; the ends meet at the innermost point, or on the axis if there is no hole.
        ring = float(ratios[0])
        tube, end = 1.0 - ring, _max_tube_angle(ring)
        sides = self._tube_sides(segments, ring)
        angle = np.linspace(-end, end, sides + 1)
        cosine, sine = np.cos(angle), np.sin(angle)
        radius = ring + tube * cosine
        if end < math.pi:
            radius[[0, -1]] = 0.0  # where the surface meets the axis
        else:
            cosine[-1], sine[-1], radius[-1] = cosine[0], sine[0], radius[0]
        return forms.revolved_mesh(radius, tube * sine, np.stack([cosine, sine], axis=1), segments)

    def face_count(self, segments: Any, ratios: Ratios) -> Any:
        return 2 * segments * self._tube_sides(segments, ratios[0])

    def vertex_count(self, segments: int, ratios: Ratios) -> int:
        return int(segments * (self._tube_sides(segments, float(ratios[0])) + 1))

    def _tube_sides(self, segments: Any, ring: Any) -> Any:
        """Return the number of sides of the tube, for the same distance from the true circle as along the ring."""
        return np.maximum(6, np.ceil(segments * np.sqrt(1.0 - ring))).astype(np.int64)

    def charts(self, half: Sequence[float], ratios: Ratios) -> list[Chart]:
        # The area grows unevenly around the tube, so u is mapped through a table of its cumulative sum.
        ring, size = float(ratios[0]), half[0]
        tube, end = 1.0 - ring, _max_tube_angle(ring)
        angles = np.linspace(-end, end, _TABLE_SIZE)
        reached = ring * angles + tube * np.sin(angles)  # proportional to the area (Pappus's theorem)
        total = float(reached[-1] - reached[0])

        def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
            """Map the unit square, by inverting the cumulative area around the tube."""
            angle = np.interp(reached[0] + u * total, reached, angles)
            normals = forms.on_circle(np.cos(angle), v, np.sin(angle))
            places = forms.on_circle(ring + tube * np.cos(angle), v, tube * np.sin(angle))
            return size * places, normals

        return [Chart(2.0 * math.pi * tube * total * size * size, place)]

    def volume(self, ratios: Ratios) -> float:
        """Integrate cylindrical shells around the axis, starting at the axis if the disk of the tube reaches it."""
        ring = float(ratios[0])
        tube = 1.0 - ring

        def reached(x: float) -> float:
            """Return the antiderivative of the shells at ``x`` from the center of the tube's disk."""
            root = math.sqrt(max(tube * tube - x * x, 0.0))
            angle = math.asin(min(1.0, max(-1.0, x / tube)))
            return ring * (x * root + tube * tube * angle) - 2.0 / 3.0 * root**3

        return 2.0 * math.pi * (reached(tube) - reached(-min(ring, tube)))

    def thickness(self, ratios: tuple[float, ...]) -> float:
        return 1.0 - ratios[0]

    def hull(self, ratios: Ratios) -> FloatArray:
        return forms.box_corners((1.0, 1.0 - np.asarray(ratios[0]), 1.0))


def _max_tube_angle(ring: float) -> float:
    """Return the angle around the tube, from its outermost point, where the surface meets the axis.

    Returns pi if it does not.
    """
    tube = 1.0 - ring
    return math.pi if ring > tube else math.acos(-ring / tube)


def _crossings(o: FloatArray, d: FloatArray, ring: FloatArray) -> FloatArray:
    """Return the ray parameters (4, N) where rays (3, N) cross the surface in ascending order, padded with infinity."""
    length = np.sqrt((d * d).sum(axis=0))
    d = d / length
    start = -(o * d).sum(axis=0)
    o = o + start * d  # the point nearest to the center
    k = (o * o).sum(axis=0) + ring * ring - (1.0 - ring) ** 2
    flat = 4.0 * ring * ring
    c2 = 2.0 * k - flat * (d[0] * d[0] + d[2] * d[2])
    c1 = -2.0 * flat * (o[0] * d[0] + o[2] * d[2])
    c0 = k * k - flat * (o[0] * o[0] + o[2] * o[2])
    reach = np.sqrt(np.maximum(1.0 - (o * o).sum(axis=0), 0.0))

    def value(t: FloatArray) -> FloatArray:
        """Return the quartic, negative inside the surface."""
        quartic: FloatArray = ((t * t + c2) * t + c1) * t + c0
        return quartic

    ends = np.concatenate([-reach[None], np.clip(_extrema(c2, c1), -reach, reach), reach[None]])
    inside = value(ends) < 0.0
    inside[[0, -1]] = False  # the end points lie on the bounding sphere
    roots = np.full((4, len(k)), np.inf)
    for i in range(4):
        rows = np.flatnonzero(inside[i] != inside[i + 1])
        if len(rows):
            root = _root(c2[rows], c1[rows], c0[rows], ends[i, rows], ends[i + 1, rows], inside[i, rows])
            # A spindle torus also satisfies the quartic on its inner part, which is not part of the surface.
            outer = root * root + k[rows] >= 0.0
            roots[i, rows] = np.where(outer, (root + start[rows]) / length[rows], np.inf)
    return np.sort(roots, axis=0)


def _extrema(c2: FloatArray, c1: FloatArray) -> FloatArray:
    """Return the roots (3, N) of 4 t^3 + 2 c2 t + c1 in ascending order; a single real root is repeated three times."""
    p, q = c2 / 6.0, c1 / 8.0  # t^3 + 3 p t + 2 q
    discriminant = q * q + p * p * p
    size = np.sqrt(np.maximum(-p, 0.0))
    with np.errstate(all="ignore"):
        angle = np.arccos(np.clip(-q / np.where(size > 0.0, size**3, 1.0), -1.0, 1.0)) / 3.0
        three_roots = 2.0 * size * np.cos(angle + np.array([[2.0], [-2.0], [0.0]]) * (math.pi / 3.0))
        root = np.cbrt(-(q + np.copysign(np.sqrt(np.maximum(discriminant, 0.0)), q)))
        one_root = root - np.where(root != 0.0, p / np.where(root != 0.0, root, 1.0), 0.0)
    return np.sort(np.where(discriminant > 0.0, one_root, three_roots), axis=0)


def _root(
    c2: FloatArray, c1: FloatArray, c0: FloatArray, low: FloatArray, high: FloatArray, negative_at_low: BoolArray
) -> FloatArray:
    """Return the root of the quartic in each bracket; ``negative_at_low`` is the sign of the quartic at ``low``.

    Newton's method, with bisection wherever a step would leave the bracket (Numerical Recipes, section 9.4).
    """
    out = t = 0.5 * (low + high)
    left = np.arange(len(t))  # a few brackets take ten times as long as most
    for _ in range(_MAX_ITERATIONS):
        value = ((t * t + c2) * t + c1) * t + c0
        below = (value < 0.0) == negative_at_low  # the root lies above t
        low, high = np.where(below, t, low), np.where(below, high, t)
        with np.errstate(all="ignore"):
            step = t - value / ((4.0 * t * t + 2.0 * c2) * t + c1)
        following = np.where((step > low) & (step < high), step, 0.5 * (low + high))
        # Where the value is that of rounding, t is the root: bisection would lead away from it.
        following = np.where(np.abs(value) <= 1e-15, t, following)
        going = np.flatnonzero(np.abs(following - t) > 1e-15)
        out[left] = following
        if not len(going):
            break
        left, t = left[going], following[going]
        c2, c1, c0, low, high = (x[going] for x in (c2, c1, c0, low, high))
        negative_at_low = negative_at_low[going]
    return out


TORUS = TorusForm()


@dataclass(frozen=True, slots=True)
class Torus(Primitive):
    """All points within ``tube`` of the circle of ``radius`` around the origin in the plane y = 0."""

    word = "torus"
    doc = "a torus around the y axis, centered at the origin"
    attributes = (RADIUS, TUBE)
    symmetry = Symmetry()

    radius: float = 1.0
    tube: float = 0.25

    @property
    def is_flat(self) -> bool:
        return self.tube == 0.0

    @classmethod
    def comparison_key(cls, given: Mapping[str, Any]) -> tuple[str, tuple[float, float, float] | None]:
        values = {name: value for name, value in given.items() if value is not None}
        radius, tube = (abs(values.get(attribute.name, attribute.default)) for attribute in cls.attributes)
        return f"{tube / radius:.4g}" if radius else "ball", (radius + tube, tube, radius + tube)

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        half = self.radius * math.hypot(a, c) + self.tube * math.sqrt(a * a + b * b + c * c)
        return -half, half

    def placed(self) -> Placed | None:
        # scaled to an outer radius of 1; without a ring it is a ball
        if self.tube == 0.0:
            return None
        s = self.radius + self.tube
        if self.radius < 1e-12 * s:
            return placed_ball(self.tube)
        return Placed(TORUS, (self.radius / s,), (s, 0.0, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, 0.0, s, 0.0))
