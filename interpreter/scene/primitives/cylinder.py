"""The primitive "cylinder": a solid cylinder between two points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.primitives import forms
from scenelang.interpreter.scene.primitives.base import ORIGIN, P0, P1, RADIUS, Placed, Point, Primitive, Symmetry
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Chart, Mesh, Ratios, Triple

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.forms import BoolArray, FloatArray, Interval

_ROUND_FACE_SIDES = 48  # of the polygon that approximates a round face when overlaps of faces are measured


def disk_outline(y: float) -> FloatArray:
    """Return the unit disk at height ``y`` as half axes and center (3, 3)."""
    return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, y], [0.0, 1.0, 0.0]])


def round_face(side: float) -> FloatArray:
    """Return the corners (K, 3) of a polygon that approximates the unit disk at height ``side``."""
    angle = np.linspace(0.0, 2.0 * np.pi, _ROUND_FACE_SIDES, endpoint=False)
    return np.stack([np.cos(angle), np.full(len(angle), side), np.sin(angle)], axis=1)


class CylinderForm(CanonicalForm):
    """The cylinder x^2 + z^2 <= 1 between y = -1 and y = 1."""

    name = "cylinder"

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        return [forms.between(forms.in_tube((o[0], o[2]), (d[0], d[2])), forms.slab(o[1], d[1]))]

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        # a point belongs to a cap if it is closer to its plane than to the side
        normals = np.zeros_like(points)
        cap = np.abs(points[:, 1]) > np.hypot(points[:, 0], points[:, 2])
        normals[:, 0], normals[:, 2] = np.where(cap, 0.0, points[:, 0]), np.where(cap, 0.0, points[:, 2])
        normals[:, 1] = np.where(cap, points[:, 1], 0.0)
        return normals

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        # a point of the rim of a cap; along the axis, its center would do as well
        point = np.empty_like(directions)
        across = np.hypot(directions[:, 0], directions[:, 2])
        safe = np.where(across > 0.0, across, 1.0)
        point[:, 0], point[:, 2] = directions[:, 0] / safe, directions[:, 2] / safe
        point[:, 1] = np.sign(directions[:, 1])
        return point

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray, ratios: Ratios) -> BoolArray:
        inside: BoolArray = (u * u + w * w <= 1.0) & (np.abs(v) <= 1.0)
        return inside

    def mesh(self, segments: int, ratios: Ratios) -> Mesh:
        return forms.joined(
            forms.side_mesh(segments, 1.0), forms.cap_mesh(segments, 1.0), forms.cap_mesh(segments, -1.0)
        )

    def face_count(self, segments: Any, ratios: Ratios) -> Any:
        return 4 * segments

    def charts(self, half: Sequence[float], ratios: Ratios) -> list[Chart]:
        x, y, _ = half
        return [forms.tube_chart(x, y), forms.disk_chart(x, y, 1.0), forms.disk_chart(x, -y, -1.0)]

    def volume(self, ratios: Ratios) -> float:
        return 2.0 * math.pi

    def outline(self) -> tuple[FloatArray, ...] | None:
        return disk_outline(-1.0), disk_outline(1.0)

    def flat_faces(self, ratios: Ratios) -> Iterator[tuple[int, float, FloatArray]]:
        for side in (-1.0, 1.0):
            yield 1, side, round_face(side)

    def mitsuba(self, ratios: Ratios) -> list[dict[str, Any]]:
        """Return the side and two disks, because Mitsuba's cylinder has no caps."""
        side = {"type": "cylinder", "p0": (0, -1, 0), "p1": (0, 1, 0), "radius": 1.0}
        return [side, *({"type": "disk", "to_world": _cap(y)} for y in (1.0, -1.0))]


def _cap(y: float) -> FloatArray:
    """Return the pose of the unit disk as a cap of the cylinder, facing outward."""
    return np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, y, y], [0.0, -y, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


CYLINDER = CylinderForm()


def disk_interval(
    p0: Point, p1: Point, r0: float, r1: float, direction: tuple[float, float, float]
) -> tuple[float, float]:
    """Return the extent of the convex hull of two parallel disks along a direction, as minimum and maximum.

    Parameters
    ----------
    p0, p1
        Centers; the disks are perpendicular to the line between them.
    r0, r1
        Radii; 0 for the apex of a cone.
    direction
        Vector, not necessarily of length 1.
    """
    a, b, c = direction
    (x0, y0, z0), (x1, y1, z1) = p0, p1
    u, v, w = x1 - x0, y1 - y0, z1 - z0
    length = math.sqrt(u * u + v * v + w * w)
    start = a * x0 + b * y0 + c * z0
    end = a * x1 + b * y1 + c * z1
    if length == 0.0:
        return start, start
    # |n x d| is the length of the projection of d onto the plane of the disk; |d|^2 - (n.d)^2 would cancel.
    i, j, k = v * c - w * b, w * a - u * c, u * b - v * a
    across = math.sqrt(i * i + j * j + k * k)
    reach, apex = r0 * across / length, r1 * across / length
    return min(start - reach, end - apex), max(start + reach, end + apex)


@dataclass(frozen=True, slots=True)
class Cylinder(Primitive):
    """Solid cylinder with its axis from ``p0`` to ``p1``."""

    word = "cylinder"
    doc = "a solid cylinder with its axis from :p0 to :p1"
    attributes = (RADIUS, P0, P1)
    symmetry = Symmetry(axis=True)

    radius: float = 1.0
    p0: Point = ORIGIN
    p1: Point = (0.0, 1.0, 0.0)

    @property
    def is_flat(self) -> bool:
        return self.radius == 0.0 or self.p0 == self.p1

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        return disk_interval(self.p0, self.p1, self.radius, self.radius, (a, b, c))

    def placed(self) -> Placed | None:
        rows = forms.axis_rows(self.p0, self.p1, self.radius)
        return None if rows is None else Placed(CYLINDER, (), rows)
