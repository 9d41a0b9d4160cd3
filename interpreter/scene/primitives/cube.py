"""The primitive "cube": a box centered at the origin."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.primitives import forms
from scenelang.interpreter.scene.primitives.base import SCALE, WHITE, Placed, Point, Primitive, Symmetry
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Chart, Mesh, Ratios, Triple

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.forms import BoolArray, FloatArray, Interval


_SQUARE = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))


class BlockForm(CanonicalForm):
    """The cube [-1, 1]^3."""

    name = "block"
    is_curved = False

    def intervals(self, o: Triple, d: Triple, ratios: Ratios) -> Sequence[Interval]:
        return [forms.between(*(forms.slab(o[k], d[k]) for k in range(3)))]

    def normals(self, points: FloatArray, ratios: Ratios) -> FloatArray:
        # of the face whose plane is nearest
        normals = np.zeros_like(points)
        axis = np.argmax(np.abs(points), axis=1)
        rows = np.arange(len(points))
        normals[rows, axis] = np.sign(points[rows, axis])
        return normals

    def support(self, directions: FloatArray, ratios: Ratios) -> FloatArray:
        return np.sign(directions)  # a zero component gives the middle of an edge or face

    def contains(self, u: FloatArray, v: FloatArray, w: FloatArray, ratios: Ratios) -> BoolArray:
        inside: BoolArray = np.maximum(np.maximum(np.abs(u), np.abs(v)), np.abs(w)) <= 1.0
        return inside

    def mesh(self, segments: int, ratios: Ratios) -> Mesh:
        """Return six squares of two triangles with four vertices each."""
        squares = []
        for axis in range(3):
            for sign in (-1.0, 1.0):
                u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
                normal = sign * np.eye(3)[axis]
                v = sign * v
                corners = np.stack([normal - u - v, normal + u - v, normal + u + v, normal - u + v])
                squares.append(Mesh(corners, np.tile(normal, (4, 1)), np.array([[0, 1, 2], [0, 2, 3]])))
        return forms.joined(*squares)

    def face_count(self, segments: Any, ratios: Ratios) -> Any:
        return 12 + 0 * segments

    def vertex_count(self, segments: int, ratios: Ratios) -> int:
        return 24

    def charts(self, half: Sequence[float], ratios: Ratios) -> list[Chart]:
        return [forms.rectangle_chart(half, axis, side) for axis in range(3) for side in (-1.0, 1.0)]

    def volume(self, ratios: Ratios) -> float:
        return 8.0

    def outline(self) -> tuple[FloatArray, ...] | None:
        return tuple(corner[:, None] for corner in self.hull(()))

    def flat_faces(self, ratios: Ratios) -> Iterator[tuple[int, float, FloatArray]]:
        for axis in range(3):
            for side in (-1.0, 1.0):
                yield axis, side, np.insert(np.array(_SQUARE), axis, side, axis=1)

    def mitsuba(self, ratios: Ratios) -> list[dict[str, Any]]:
        return [{"type": "cube"}]


BLOCK = BlockForm()


def placed_block(size: Point, *, corner: bool = False) -> Placed:
    """Return a box of ``size``, centered at the origin, or with its minimum corner there if ``corner`` is set."""
    x, y, z = size[0] / 2.0, size[1] / 2.0, size[2] / 2.0
    cx, cy, cz = (x, y, z) if corner else (0.0, 0.0, 0.0)
    return Placed(BLOCK, (), (x, 0.0, 0.0, cx, 0.0, y, 0.0, cy, 0.0, 0.0, z, cz))


@dataclass(frozen=True, slots=True)
class Cube(Primitive):
    """Box of ``size`` centered at the origin."""

    word = "cube"
    doc = "a box centered at the origin"
    attributes = (SCALE,)
    symmetry = Symmetry(edges=True)

    size: Point = WHITE

    @property
    def is_flat(self) -> bool:
        return 0.0 in self.size

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        x, y, z = self.size
        half = 0.5 * (abs(a) * x + abs(b) * y + abs(c) * z)
        return -half, half

    def placed(self) -> Placed | None:
        return placed_block(self.size)


@dataclass(frozen=True, slots=True)
class Semantic(Cube):
    """Box of ``size`` centered at the origin, with a default color derived from its word."""

    word = ""
    doc = "a semantic primitive: a box of its `:scale`, centered at the origin"
    is_solid = False
    is_semantic = True
    symmetry = Symmetry(unknown=True)

    def color_seed(self, word: str, attributes: Mapping[str, Any]) -> tuple[str, float, float] | None:
        return word, 0.34, 0.93
