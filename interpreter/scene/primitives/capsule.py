"""The primitive "capsule": all points within a radius of the segment between two points."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.primitives import forms
from scenelang.interpreter.scene.primitives.base import ORIGIN, P0, P1, RADIUS, Placed, Point, Primitive, Symmetry
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Chart, Mesh, Ratios, Triple
from scenelang.interpreter.scene.primitives.sphere import placed_ball

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.forms import BoolArray, FloatArray, Interval


class CapsuleForm(CanonicalForm):
    """Capsule along y from -1 to 1; its ratio is the radius r, so that the straight part ends at 1 - r."""

    name = "capsule"
    is_doubly_curved = True
    ratios = 1
    is_rounded = True
    min_aspect_ratio = 0.02
    overlaps = True

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        # the union of a cylinder and two balls, which is convex
        r = ratios[0]
        side = forms.between(forms.in_tube((o[0], o[2]), (d[0], d[2]), r), forms.slab(o[1], d[1], 1.0 - r))
        hemispheres = (forms.in_ball((o[0], o[1] - y, o[2]), d, r) for y in (1.0 - r, r - 1.0))
        return [forms.in_any(side, *hemispheres)]

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        # away from the nearest point of the segment between the centers of the balls
        straight = 1.0 - ratios[0]
        normals = points.copy()
        normals[:, 1] -= np.clip(points[:, 1], -straight, straight)
        return normals

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        # the point of a ball, moved to the end of the segment on that side
        r = np.asarray(ratios[0])
        points: FloatArray = forms.unit(directions) * r[..., None]
        points[:, 1] += np.sign(directions[:, 1]) * (1.0 - r)
        return points

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray, ratios: Ratios) -> BoolArray:
        r = ratios[0]
        away = np.maximum(np.abs(v) - (1.0 - r), 0.0)
        inside: BoolArray = u * u + away * away + w * w <= r * r
        return inside

    def mesh(self, segments: int, ratios: Ratios) -> Mesh:
        # two quarter circles, revolved; the straight part is between their ends
        r = float(ratios[0])
        quarter = np.linspace(0.0, math.pi / 2.0, max(2, segments // 4) + 1)
        cosine, sine = np.cos(quarter), np.sin(quarter)
        cosine[-1] = 0.0  # exactly, so that the pole is a single point
        radius = np.concatenate([cosine[::-1], cosine])
        height = np.concatenate([-sine[::-1], sine])
        y = r * height + np.repeat([r - 1.0, 1.0 - r], len(quarter))
        return forms.revolved_mesh(r * radius, y, np.stack([radius, height], axis=1), segments)

    def face_count(self, segments: Any, ratios: Ratios) -> Any:
        return segments * segments + 2 * segments

    def vertex_count(self, segments: int, ratios: Ratios) -> int:
        return segments * (segments // 2 + 2)

    def charts(self, half: Sequence[float], ratios: Ratios) -> list[Chart]:
        # ``half[1]`` is half the whole length, radius included
        r, size = float(ratios[0]), half[1]
        straight = size * (1.0 - r)
        ball = forms.sphere_chart(size * r)

        def hemispheres(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
            """Sample a sphere, and pull its halves apart by the straight part."""
            places, normals = ball.place(u, v)
            places[:, 1] += np.where(normals[:, 1] < 0.0, -straight, straight)
            return places, normals

        return [forms.tube_chart(size * r, straight), Chart(ball.area, hemispheres)]

    def volume(self, ratios: Ratios) -> float:
        r = float(ratios[0])
        return 2.0 * math.pi * r * r * (1.0 - r) + 4.0 / 3.0 * math.pi * r**3

    def hull(self, ratios: Ratios) -> FloatArray:
        return forms.box_corners((ratios[0], 1.0, ratios[0]))

    def thickness(self, ratios: tuple[float, ...]) -> float:
        return ratios[0]

    def mitsuba(self, ratios: Ratios) -> list[dict[str, Any]]:
        """Return an open cylinder with a sphere at each end."""
        r = float(ratios[0])
        side = {"type": "cylinder", "p0": (0.0, r - 1.0, 0.0), "p1": (0.0, 1.0 - r, 0.0), "radius": r}
        return [side, *({"type": "sphere", "center": (0.0, y, 0.0), "radius": r} for y in (1.0 - r, r - 1.0))]

    def usd(self, ratios: Ratios) -> tuple[str, dict[str, tuple[str, Any]]] | None:
        r = float(ratios[0])
        return "Capsule", {"axis": ("Token", "Y"), "height": ("Double", 2.0 - 2.0 * r), "radius": ("Double", r)}


CAPSULE = CapsuleForm()
_MAX_STRETCH = 1e12  # of a capsule's length to that of its axis, which vanishes in single precision beyond this


@dataclass(frozen=True, slots=True)
class Capsule(Primitive):
    """Cylinder from ``p0`` to ``p1`` with a hemisphere at each end."""

    word = "capsule"
    doc = "a cylinder from :p0 to :p1 with a hemisphere at each end"
    attributes = (RADIUS, P0, P1)
    symmetry = Symmetry(axis=True)

    radius: float = 1.0
    p0: Point = ORIGIN
    p1: Point = (0.0, 1.0, 0.0)

    @property
    def is_flat(self) -> bool:
        return self.radius == 0.0

    @classmethod
    def comparison_key(cls, given: Mapping[str, Any]) -> tuple[str, tuple[float, float, float] | None]:
        radius, p0, p1 = (given.get(a.name) or a.default for a in cls.attributes)
        length = math.dist(p0, p1)
        return f"{radius / length:.4g}" if length else "ball", None

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        start, end = (a * x + b * y + c * z for x, y, z in (self.p0, self.p1))
        reach = self.radius * math.sqrt(a * a + b * b + c * c)
        return min(start, end) - reach, max(start, end) + reach

    def placed(self) -> Placed | None:
        """Return the canonical capsule under a pose, a ball if the axis is very short, None if the radius is 0.

        The canonical capsule reaches from y = -1 to 1 with its caps, so the axis is extended by the radius at each end.
        """
        if self.radius == 0.0:
            return None
        half_axis = math.dist(self.p0, self.p1) / 2.0
        half_length = half_axis + self.radius
        stretch = half_length / half_axis if half_axis > 0.0 else math.inf
        if not stretch < _MAX_STRETCH:
            return placed_ball(self.radius, self.p0)
        center = [(x + y) / 2.0 for x, y in zip(self.p0, self.p1, strict=True)]
        bottom, top = ([c + stretch * (x - c) for x, c in zip(end, center, strict=True)] for end in (self.p0, self.p1))
        rows = forms.axis_rows(bottom, top, half_length)
        return None if rows is None else Placed(CAPSULE, (self.radius / half_length,), rows)
