"""The primitive "cone": a solid cone from its base to its apex."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.primitives import forms
from scenelang.interpreter.scene.primitives.base import ORIGIN, P0, P1, RADIUS, Placed, Point, Primitive, Symmetry
from scenelang.interpreter.scene.primitives.cylinder import disk_interval, disk_outline, round_face
from scenelang.interpreter.scene.primitives.forms import TINY, CanonicalForm, Chart, Mesh, Ratios, Triple

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.forms import BoolArray, FloatArray, Interval


class ConeForm(CanonicalForm):
    """The cone x^2 + z^2 <= ((1 - y) / 2)^2 between y = -1 and the apex at y = 1.

    Mitsuba has no cone, so it is a mesh there.
    """

    name = "cone"

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        # The quadratic of the double cone, cut to the slab between base and apex.
        # Radius of the cone at the height of o, and its derivative along the ray.
        radius, growth = 0.5 - 0.5 * o[1], -0.5 * d[1]
        a = d[0] * d[0] + d[2] * d[2] - growth * growth
        a = np.where(np.abs(a) < TINY, TINY, a)
        b = o[0] * d[0] + o[2] * d[2] - radius * growth
        c = o[0] * o[0] + o[2] * o[2] - radius * radius
        low, high, discriminant = _quadratic(a, b, c)
        # If a < 0, the ray is inside the double cone outside the roots; the radius grows toward the lower nappe.
        steep = a < 0.0
        enter = np.where(steep, np.where(growth > 0.0, high, -np.inf), np.where(discriminant < 0.0, np.inf, low))
        leave = np.where(steep, np.where(growth > 0.0, np.inf, low), high)
        return [forms.between((enter, leave), forms.slab(o[1], d[1]))]

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        # A point belongs to the base if it is closer to its plane than to the side, whose normal rises by 1 : 2.
        normals = np.zeros_like(points)
        radius = np.hypot(points[:, 0], points[:, 2])
        base = np.abs(points[:, 1] + 1.0) < np.abs(0.5 - 0.5 * points[:, 1] - radius)
        scale = np.where(base, 0.0, 1.0 / np.maximum(radius, 1e-12))
        normals[:, 0], normals[:, 2] = points[:, 0] * scale, points[:, 2] * scale
        normals[:, 1] = np.where(base, -1.0, 0.5)
        return normals

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        # a point of the rim of the base, or the apex if that is farther
        point = np.empty_like(directions)
        across = np.hypot(directions[:, 0], directions[:, 2])
        safe = np.where(across > 0.0, across, 1.0)
        point[:, 0], point[:, 2] = directions[:, 0] / safe, directions[:, 2] / safe
        point[:, 1] = -1.0
        point[directions[:, 1] > across - directions[:, 1]] = (0.0, 1.0, 0.0)
        return point

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray, ratios: Ratios) -> BoolArray:
        inside: BoolArray = (u * u + w * w <= ((1.0 - v) / 2.0) ** 2) & (np.abs(v) <= 1.0)
        return inside

    def mesh(self, segments: int, ratios: Ratios) -> Mesh:
        return forms.joined(forms.side_mesh(segments, 0.0), forms.cap_mesh(segments, -1.0))

    def face_count(self, segments: Any, ratios: Ratios) -> Any:
        return 4 * segments

    def vertex_count(self, segments: int, ratios: Ratios) -> int:
        return 3 * segments

    def charts(self, half: Sequence[float], ratios: Ratios) -> list[Chart]:
        x, y, _ = half
        return [_side_chart(x, y), forms.disk_chart(x, -y, -1.0)]

    def volume(self, ratios: Ratios) -> float:
        return 2.0 / 3.0 * math.pi

    def hull(self, ratios: Ratios) -> FloatArray:
        return np.array([[-1.0, -1, -1], [1, -1, -1], [-1, -1, 1], [1, -1, 1], [0, 1, 0]])

    def outline(self) -> tuple[FloatArray, ...] | None:
        return disk_outline(-1.0), np.array([[0.0], [1.0], [0.0]])

    def flat_faces(self, ratios: Ratios) -> Iterator[tuple[int, float, FloatArray]]:
        yield 1, -1.0, round_face(-1.0)


def _quadratic(a: Any, b: Any, c: Any) -> tuple[Any, Any, Any]:
    """Return the roots of a t^2 + 2 b t + c, smaller first, and the discriminant divided by 4.

    Adding quantities of equal sign in ``q`` avoids cancellation (Numerical Recipes, section 5.6).
    """
    discriminant = b * b - a * c
    q = -(b + np.copysign(np.sqrt(np.maximum(discriminant, 0.0)), b))
    q = np.where(q == 0.0, TINY, q)
    first, second = q / a, c / q
    return np.minimum(first, second), np.maximum(first, second), discriminant


def _side_chart(radius: float, half: float) -> Chart:
    """Return the chart of the side of a cone around the y axis, from ``y = half`` (the apex) to ``y = -half``."""
    slant = math.hypot(radius, 2.0 * half)

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Map ``u``, ``v`` (K,) in [0, 1) to points and unit normals (K, 3) of the cone's side.

        ``v`` is the angle in full turns. ``u`` is the share of the area between the cone's apex and the point, which
        grows with the square of their distance.
        """
        distance = np.sqrt(u)  # from the apex, as a share of the slant height
        normals = forms.on_circle(2.0 * half / slant + 0.0 * u, v, radius / slant + 0.0 * u)
        return forms.on_circle(radius * distance, v, half - 2.0 * half * distance), normals

    return Chart(math.pi * radius * slant, place)


CONE = ConeForm()


@dataclass(frozen=True, slots=True)
class Cone(Primitive):
    """Solid cone with its base around ``p0`` and its apex at ``p1``."""

    word = "cone"
    doc = "a solid cone with its base centered at :p0 and its apex at :p1"
    attributes = (RADIUS, P0, P1)
    symmetry = Symmetry(axis=True)

    radius: float = 1.0
    p0: Point = ORIGIN
    p1: Point = (0.0, 1.0, 0.0)

    @property
    def is_flat(self) -> bool:
        return self.radius == 0.0 or self.p0 == self.p1

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        return disk_interval(self.p0, self.p1, self.radius, 0.0, (a, b, c))

    def placed(self) -> Placed | None:
        rows = forms.axis_rows(self.p0, self.p1, self.radius)
        return None if rows is None else Placed(CONE, (), rows)
