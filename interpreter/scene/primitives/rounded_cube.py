"""The primitive "rounded-cube": a box with rounded edges and corners."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.primitives import forms
from scenelang.interpreter.scene.primitives.base import (
    SCALE,
    WHITE,
    Attribute,
    Placed,
    Point,
    Primitive,
    Symmetry,
    length_of,
)
from scenelang.interpreter.scene.primitives.cube import placed_block
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Chart, Mesh, Ratios, Triple
from scenelang.interpreter.scene.primitives.mesh import areas_of
from scenelang.interpreter.scene.primitives.sphere import placed_ball

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.forms import BoolArray, FloatArray, Interval

ROUNDING = Attribute(
    "radius", "radius of the edges and corners, at most half the shortest side; default .1",
    "a number", 0.1, length_of, "rounding", ("Number",), 0.0,
    aliases=("r", "rad", "bevel", "fillet", "corner-radius", "edge-radius"), former="rounding",
)  # fmt: skip


_MIN_FACE_AREA = 1e-14  # in the unit cube: faces of less are degenerate, where a ratio is 0


class RoundedForm(CanonicalForm):
    """Box with half sizes x, y, z, dilated by r (a Minkowski sum with a ball); the ratios are (x, y, z, r)."""

    name = "rounded_cube"
    is_doubly_curved = True
    ratios = 4

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        """Return the interval of a convex union of three boxes, twelve cylinders at the edges and eight corner balls.

        Only rays that meet the bounding box are intersected with these 23 pieces.
        """
        shape = np.broadcast_shapes(*(np.shape(x) for x in (*o, *d, *ratios)))
        enter, leave = np.full(shape, np.inf), np.full(shape, -np.inf)
        first, last = forms.between(*(forms.slab(o[k], d[k], ratios[k] + ratios[3]) for k in range(3)))
        near = np.broadcast_to(first <= last, shape)
        ox, oy, oz, dx, dy, dz, x, y, z, r = (np.broadcast_to(value, shape)[near] for value in (*o, *d, *ratios))
        if ox.size:
            enter[near], leave[near] = _ray_interval((ox, oy, oz), (dx, dy, dz), (x, y, z), r)
        return [(enter, leave)]

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        # away from the nearest point of the inner box
        half = np.stack(np.broadcast_arrays(*ratios[:3]), axis=-1)
        normals: FloatArray = points - np.clip(points, -half, half)
        return normals

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        # of a Minkowski sum: the sum of the supports of box and ball
        half = np.stack(np.broadcast_arrays(*ratios[:3]), axis=-1)
        points: FloatArray = np.sign(directions) * half + forms.unit(directions) * np.asarray(ratios[3])[..., None]
        return points

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray, ratios: Ratios) -> BoolArray:
        a, b, c = (np.maximum(np.abs(p) - half, 0.0) for p, half in zip((u, v, w), ratios[:3], strict=True))
        inside: BoolArray = a * a + b * b + c * c <= ratios[3] ** 2
        return inside

    def mesh(self, segments: int, ratios: Ratios) -> Mesh:
        """Return a sphere mesh that is cut along its three symmetry planes and pulled apart."""
        half, r = np.array([float(x) for x in ratios[:3]]), float(ratios[3])
        quarter = np.linspace(0.0, math.pi / 2.0, max(2, segments // 4) + 1)
        azimuths = np.concatenate([quarter + k * math.pi / 2.0 for k in range(4)])
        elevations = np.concatenate([quarter - math.pi / 2.0, quarter])
        sides_x = np.repeat([1.0, 1.0, -1.0, -1.0], len(quarter))
        sides_z = np.repeat([1.0, -1.0, -1.0, 1.0], len(quarter))
        sides_y = np.repeat([-1.0, 1.0], len(quarter))
        columns, rows = len(azimuths), len(elevations)
        horizontal, vertical = np.cos(elevations)[:, None], np.sin(elevations)[:, None]
        horizontal[[0, -1]] = 0.0
        normals = np.stack(
            [horizontal * np.sin(azimuths), np.broadcast_to(vertical, (rows, columns)), horizontal * np.cos(azimuths)],
            axis=2,
        )
        normals[np.abs(normals) < 1e-12] = 0.0  # sines and cosines of right angles, which are not exactly 0
        signs = np.stack(np.broadcast_arrays(sides_x[None], sides_y[:, None], sides_z[None]), axis=2)
        vertices = (r * normals + signs * half).reshape(-1, 3)
        column = np.arange(columns)
        after = (column + 1) % columns
        faces = []
        for low in range(0, (rows - 1) * columns, columns):
            high = low + columns
            faces.append(np.stack([low + column, low + after, high + after], axis=1))
            faces.append(np.stack([low + column, high + after, high + column], axis=1))
        corners = np.arange(0, columns, len(quarter))  # of the bottom square; those of the top square follow
        top = (rows - 1) * columns + corners
        faces.append(np.array([[top[0], top[1], top[2]], [top[0], top[2], top[3]]]))
        faces.append(np.array([[corners[0], corners[2], corners[1]], [corners[0], corners[3], corners[2]]]))
        every = np.concatenate(faces)
        return Mesh(vertices, normals.reshape(-1, 3), every[areas_of(vertices[every]) > _MIN_FACE_AREA])

    def face_count(self, segments: Any, ratios: Ratios) -> Any:
        return segments * segments + 12 * segments + 24

    def vertex_count(self, segments: int, ratios: Ratios) -> int:
        return (segments + 4) * (segments // 2 + 2)

    def charts(self, half: Sequence[float], ratios: Ratios) -> list[Chart]:
        size = half[0]
        inner, r = [size * float(x) for x in ratios[:3]], size * float(ratios[3])
        faces = [forms.rectangle_chart(inner, k, side, inner[k] + r) for k in range(3) for side in (-1.0, 1.0)]
        return [*faces, *(_edge_chart(inner, r, axis) for axis in range(3)), _corner_chart(inner, r)]

    def volume(self, ratios: Ratios) -> float:
        x, y, z, r = (float(ratio) for ratio in ratios)
        faces, edges = 8.0 * (x * y + y * z + z * x), 2.0 * (x + y + z)
        # Steiner's formula for the parallel body of a box.
        return 8.0 * x * y * z + faces * r + math.pi * r * r * edges + 4.0 / 3.0 * math.pi * r**3

    def thickness(self, ratios: tuple[float, ...]) -> float:
        return min(ratios[:3]) + ratios[3]

    def hull(self, ratios: Ratios) -> FloatArray:
        return forms.box_corners([ratio + ratios[3] for ratio in ratios[:3]])

    def flat_faces(self, ratios: Ratios) -> Iterator[tuple[int, float, FloatArray]]:
        square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        half, r = np.array([float(x) for x in ratios[:3]]), float(ratios[3])
        for axis, side in product(range(3), (-1.0, 1.0)):
            corners = np.insert(square, axis, 0.0, axis=1) * half
            corners[:, axis] = side * (half[axis] + r)
            yield axis, side, corners


def _ray_interval(o: Triple, d: Triple, half: Triple, r: FloatArray) -> Interval:
    """Return the interval of rays inside the union of the boxes, cylinders and balls."""
    slabs = [forms.slab(o[k], d[k], half[k]) for k in range(3)]
    parts = []
    for axis in range(3):
        j, k = (axis + 1) % 3, (axis + 2) % 3
        parts.append(forms.between(forms.slab(o[axis], d[axis], half[axis] + r), slabs[j], slabs[k]))
        for a, b in product((-1.0, 1.0), repeat=2):
            tube = forms.in_tube((o[j] - a * half[j], o[k] - b * half[k]), (d[j], d[k]), r)
            parts.append(forms.between(tube, slabs[axis]))
    for signs in product((-1.0, 1.0), repeat=3):
        center = tuple(o[k] - signs[k] * half[k] for k in range(3))
        parts.append(forms.in_ball((center[0], center[1], center[2]), d, r))
    return forms.in_any(*parts)


def _edge_chart(half: Sequence[float], r: float, axis: int) -> Chart:
    """Return the four rounded edges along ``axis`` as a cylinder whose quarters are pulled apart."""
    tube = forms.tube_chart(r, half[axis])
    order = [(axis + 2) % 3, axis, (axis + 1) % 3]  # the axes that x, y and z of the cylinder are mapped to

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Map the unit square to a quarter of the cylinder at each edge."""
        places, normals = np.empty((2, len(u), 3))
        along, outward = tube.place(u, v)
        places[:, order], normals[:, order] = along, outward
        for k in (order[0], order[2]):
            places[:, k] += np.where(normals[:, k] < 0.0, -half[k], half[k])
        return places, normals

    return Chart(tube.area, place)


def _corner_chart(half: Sequence[float], r: float) -> Chart:
    """Return the eight rounded corners as a sphere whose octants are pulled apart."""
    ball = forms.sphere_chart(r)

    def place(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Map the unit square to an octant of the sphere at each corner."""
        places, normals = ball.place(u, v)
        return places + np.where(normals < 0.0, -1.0, 1.0) * np.array(half), normals

    return Chart(ball.area, place)


ROUNDED = RoundedForm()


@dataclass(frozen=True, slots=True)
class RoundedCube(Primitive):
    """Box of ``size`` with edges and corners of radius ``rounding``, centered at the origin.

    The rounding is clamped to half the shortest side, so that a cube of any size accepts any value.
    """

    word = "rounded-cube"
    doc = "a box with rounded edges and corners, centered at the origin"
    attributes = (SCALE, ROUNDING)
    symmetry = Symmetry(edges=True)

    size: Point = WHITE
    rounding: float = 0.1

    @property
    def is_flat(self) -> bool:
        return 0.0 in self.size

    @classmethod
    def comparison_key(cls, given: Mapping[str, Any]) -> tuple[str, tuple[float, float, float] | None]:
        scale, rounding = given.get("scale") or 1.0, given.get("radius")
        x, y, z = map(abs, scale if isinstance(scale, (list, tuple)) else (scale, scale, scale))
        r = cls(size=(x, y, z), rounding=abs(0.1 if rounding is None else rounding)).radius
        return " ".join(f"{r / side if side else 0.0:.4g}" for side in (x, y, z)), None

    @property
    def radius(self) -> float:
        """Radius of the edges: the rounding, limited to half the shortest side."""
        return min(self.rounding, min(self.size) / 2.0)

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        r = self.radius
        x, y, z = (side / 2.0 - r for side in self.size)
        half = abs(a) * x + abs(b) * y + abs(c) * z + r * math.sqrt(a * a + b * b + c * c)
        return -half, half

    def placed(self) -> Placed | None:
        # scaled to a largest half side of 1; extreme roundings are a cube or a ball
        r, s = self.radius, max(self.size) / 2.0
        if r <= 1e-9 * s:  # invisible in single precision: sharp edges
            return placed_block(self.size)
        inner = [max(0.0, side / 2.0 - r) for side in self.size]
        if max(inner) <= 1e-12 * s:
            return placed_ball(r)
        ratios = (inner[0] / s, inner[1] / s, inner[2] / s, r / s)
        return Placed(ROUNDED, ratios, (s, 0.0, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, 0.0, s, 0.0))
