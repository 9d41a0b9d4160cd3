"""The primitive "sphere": a ball centered at the origin."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.primitives import forms
from scenelang.interpreter.scene.primitives.base import RADIUS, Placed, Point, Primitive, Symmetry
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Chart, Mesh, Ratios, Triple

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.forms import BoolArray, FloatArray, Interval


class BallForm(CanonicalForm):
    """The ball x^2 + y^2 + z^2 <= 1."""

    name = "ball"
    is_doubly_curved = True
    is_rounded = True
    min_aspect_ratio = 0.02

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        return [forms.in_ball(o, d)]

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        return points

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        return forms.unit(directions)

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray, ratios: Ratios) -> BoolArray:
        inside: BoolArray = u * u + v * v + w * w <= 1.0
        return inside

    def mesh(self, segments: int, ratios: Ratios) -> Mesh:
        """Return a UV sphere with the poles on the y axis."""
        rings = max(2, (segments + 1) // 2)
        cosine, sine = forms.circle(segments)
        height = np.arange(1, rings) * (math.pi / rings)
        y, radius = np.cos(height), np.sin(height)
        body = np.stack(
            [radius[:, None] * sine, np.broadcast_to(y[:, None], (rings - 1, segments)), radius[:, None] * cosine],
            axis=2,
        )
        vertices = np.concatenate([[[0.0, 1.0, 0.0]], body.reshape(-1, 3), [[0.0, -1.0, 0.0]]])
        side = np.arange(segments)
        after = (side + 1) % segments
        last = len(vertices) - 1
        faces = [np.stack([np.zeros_like(side), 1 + side, 1 + after], axis=1)]
        for ring in range(rings - 2):
            top, bottom = 1 + ring * segments, 1 + (ring + 1) * segments
            faces.append(np.stack([top + side, bottom + side, bottom + after], axis=1))
            faces.append(np.stack([top + side, bottom + after, top + after], axis=1))
        start = 1 + (rings - 2) * segments
        faces.append(np.stack([start + side, np.full_like(side, last), start + after], axis=1))
        return Mesh(vertices, vertices.copy(), np.concatenate(faces))

    def face_count(self, segments: Any, ratios: Ratios) -> Any:
        return segments * segments

    def vertex_count(self, segments: int, ratios: Ratios) -> int:
        return segments * (segments // 2)

    def charts(self, half: Sequence[float], ratios: Ratios) -> list[Chart]:
        return [forms.sphere_chart(half[0])]

    def volume(self, ratios: Ratios) -> float:
        return 4.0 / 3.0 * math.pi

    def outline(self) -> tuple[FloatArray, ...] | None:
        return (np.concatenate([np.eye(3), np.zeros((3, 1))], axis=1),)

    def mitsuba(self, ratios: Ratios) -> list[dict[str, Any]]:
        return [{"type": "sphere"}]


BALL = BallForm()


def placed_ball(radius: float, center: Point = (0.0, 0.0, 0.0)) -> Placed:
    """Return a ball of ``radius`` around ``center``."""
    r, (x, y, z) = radius, center
    return Placed(BALL, (), (r, 0.0, 0.0, x, 0.0, r, 0.0, y, 0.0, 0.0, r, z))


@dataclass(frozen=True, slots=True)
class Sphere(Primitive):
    """Ball centered at the origin."""

    word = "sphere"
    doc = "a ball centered at the origin"
    attributes = (RADIUS,)
    symmetry = Symmetry()

    radius: float = 1.0

    @property
    def is_flat(self) -> bool:
        return self.radius == 0.0

    @classmethod
    def comparison_key(cls, given: Mapping[str, Any]) -> tuple[str, tuple[float, float, float] | None]:
        radius = given.get("radius")
        return "", (1.0, 1.0, 1.0) if radius is None else (radius, radius, radius)

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        half = self.radius * math.sqrt(a * a + b * b + c * c)
        return -half, half

    def placed(self) -> Placed | None:
        return placed_ball(self.radius)
