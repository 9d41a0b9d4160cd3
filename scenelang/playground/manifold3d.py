"""The interface of ``manifold3d`` over npm's ``manifold-3d``, for Pyodide: the same library, compiled to WebAssembly.

The worker registers the loaded JavaScript module as ``manifold_js`` and puts this file on the module path as
``manifold3d``. Only what ``interpreter/scene/modelling`` calls is here. Meshes cross in 32-bit floats, as the
JavaScript interface has no others, so that volumes agree with the desktop's to about 1e-6.
"""

from __future__ import annotations

from array import array
from enum import Enum
from typing import Any

import numpy as np
from js import Array, Float32Array, Uint32Array
from manifold_js import module as _module
from pyodide.ffi import to_js


class Error(Enum):
    """Status of a solid."""

    NoError = 0
    NonFiniteVertex = 1
    NotManifold = 2
    VertexOutOfBounds = 3
    PropertiesWrongLength = 4
    MissingPositionProperties = 5
    MergeVectorsDifferentLengths = 6
    MergeIndexOutOfBounds = 7
    TransformWrongLength = 8
    RunIndexWrongLength = 9
    FaceIDWrongLength = 10
    InvalidConstruction = 11
    ResultTooLarge = 12


class OpType(Enum):
    """Boolean operation, by the name of the static method that does it."""

    Add = "union"
    Subtract = "difference"
    Intersect = "intersection"


class FillRule(Enum):
    """Rule for what is inside a profile."""

    EvenOdd = "EvenOdd"
    NonZero = "NonZero"
    Positive = "Positive"
    Negative = "Negative"


class JoinType(Enum):
    """Form of the corners of a grown profile."""

    Square = "Square"
    Round = "Round"
    Miter = "Miter"


def _floats(values: Any) -> Any:
    return Float32Array.new(to_js(array("f", np.asarray(values, np.float64).ravel().tolist())))


def _whole(values: Any) -> Any:
    return Uint32Array.new(to_js(array("I", np.asarray(values, np.int64).ravel().tolist())))


def _points(values: Any) -> Any:
    """Return an array of points as a JavaScript array of arrays."""
    return to_js(np.asarray(values, np.float64).tolist())


def _numbers(proxy: Any, kind: Any) -> Any:
    """Return a typed array of JavaScript as an array."""
    flat = proxy.to_py().tolist()
    return np.array(flat, kind) if flat else np.zeros(0, kind)


class Mesh64:
    """Triangles with the numbers of the surfaces that they come from."""

    def __init__(
        self, vert_properties: Any, tri_verts: Any, merge_from_vert: Any = (), merge_to_vert: Any = (),
        run_index: Any = (), run_original_id: Any = (),
    ) -> None:  # fmt: skip
        self.vert_properties, self.tri_verts = vert_properties, tri_verts
        self.merge_from_vert, self.merge_to_vert = merge_from_vert, merge_to_vert
        self.run_index, self.run_original_id = run_index, run_original_id

    def _to_js(self) -> Any:
        options: dict[str, Any] = {
            "numProp": 3,
            "vertProperties": _floats(self.vert_properties),
            "triVerts": _whole(self.tri_verts),
        }
        if len(self.merge_from_vert):
            options |= {"mergeFromVert": _whole(self.merge_from_vert), "mergeToVert": _whole(self.merge_to_vert)}
        if len(self.run_original_id):
            options |= {"runIndex": _whole(self.run_index), "runOriginalID": _whole(self.run_original_id)}
        return _module.Mesh.new(_object(options))


def _object(options: dict[str, Any]) -> Any:
    from js import Object

    return Object.fromEntries(to_js(list(options.items())))


class _Wrapped:
    """Object of JavaScript, whose memory is freed with it."""

    __slots__ = ("_js",)

    def __init__(self, js: Any) -> None:
        self._js = js

    def __del__(self) -> None:
        js = getattr(self, "_js", None)
        if js is not None:
            js.delete()


class Manifold(_Wrapped):
    """Closed solid."""

    __slots__ = ("_status",)

    def __init__(self, mesh: Mesh64 | None = None) -> None:
        self._status = Error.NoError
        if mesh is None:
            super().__init__(_module.Manifold.union(Array.new()))
            return
        try:
            super().__init__(_module.Manifold.new(mesh._to_js()))
        except Exception as error:  # JavaScript raises where Python's interface has a status
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        text = str(error).replace(" ", "").lower()
        reasons = {"notmanifold": Error.NotManifold, "finite": Error.NonFiniteVertex, "toolarge": Error.ResultTooLarge}
        self._status = next((code for part, code in reasons.items() if part in text), Error.InvalidConstruction)
        super().__init__(_module.Manifold.union(Array.new()))

    @classmethod
    def _of(cls, js: Any) -> Manifold:
        self = cls.__new__(cls)
        self._status = Error.NoError
        self._js = js
        return self

    @classmethod
    def _made(cls, function: Any, *arguments: Any) -> Manifold:
        """Return the solid that a function of JavaScript gives, or an empty one with the status of its error."""
        try:
            return cls._of(function(*arguments))
        except Exception as error:
            self = cls.__new__(cls)
            self._fail(error)
            return self

    @classmethod
    def batch_boolean(cls, operands: list[Manifold], operation: OpType) -> Manifold:
        """Return the union, difference or intersection of solids."""
        return cls._made(getattr(_module.Manifold, operation.value), _list(operands))

    @classmethod
    def batch_hull(cls, operands: list[Manifold]) -> Manifold:
        """Return the convex hull of solids."""
        return cls._made(_module.Manifold.hull, _list(operands))

    @classmethod
    def hull_points(cls, points: Any) -> Manifold:
        """Return the convex hull of points."""
        return cls._made(_module.Manifold.hull, _points(points))

    @classmethod
    def sphere(cls, radius: float, segments: int = 0) -> Manifold:
        """Return a sphere."""
        return cls._made(_module.Manifold.sphere, radius, segments)

    @classmethod
    def reserve_ids(cls, count: int) -> int:
        """Return the first of ``count`` new numbers of surfaces."""
        return int(_module.Manifold.reserveIDs(count))

    def status(self) -> Error:
        """Return whether the solid could be made."""
        if self._status is not Error.NoError:
            return self._status
        name = str(self._js.status())
        return Error.__members__.get(name, Error.InvalidConstruction)

    def is_empty(self) -> bool:
        """Return whether there is nothing."""
        return bool(self._js.isEmpty())

    def num_tri(self) -> int:
        """Return the number of triangles."""
        return int(self._js.numTri())

    def volume(self) -> float:
        """Return the volume."""
        return float(self._js.volume())

    def surface_area(self) -> float:
        """Return the area of the surface."""
        return float(self._js.surfaceArea())

    def bounding_box(self) -> tuple[float, ...]:
        """Return the least and greatest coordinates."""
        box = self._js.boundingBox().to_py()
        return (*box["min"], *box["max"])

    def as_original(self) -> Manifold:
        """Return the solid with one new number for its surface."""
        return self._of(self._js.asOriginal())

    def original_id(self) -> int:
        """Return the number of the surface."""
        return int(self._js.originalID())

    def hull(self) -> Manifold:
        """Return the convex hull."""
        return self._of(self._js.hull())

    def translate(self, offset: Any) -> Manifold:
        """Return the solid at another place."""
        return self._of(self._js.translate(to_js([float(x) for x in offset])))

    def transform(self, matrix: Any) -> Manifold:
        """Return the solid under an affine pose (3, 4)."""
        columns = np.concatenate([np.asarray(matrix, np.float64), np.array([[0.0, 0.0, 0.0, 1.0]])]).T
        return self._of(self._js.transform(to_js(columns.ravel().tolist())))

    def trim_by_plane(self, normal: Any, offset: float) -> Manifold:
        """Return the part in front of a plane."""
        return self._made(self._js.trimByPlane, to_js([float(x) for x in normal]), offset)

    def minkowski_sum(self, other: Manifold) -> Manifold:
        """Return the solid grown by another."""
        return self._made(self._js.minkowskiSum, other._js)

    def minkowski_difference(self, other: Manifold) -> Manifold:
        """Return the solid shrunk by another."""
        return self._made(self._js.minkowskiDifference, other._js)

    def __sub__(self, other: Manifold) -> Manifold:
        return self._made(self._js.subtract, other._js)

    def to_mesh64(self) -> Mesh64:
        """Return the triangles."""
        mesh = self._js.getMesh()
        count = int(mesh.numProp)
        return Mesh64(
            _numbers(mesh.vertProperties, np.float64).reshape(-1, count),
            _numbers(mesh.triVerts, np.int64).reshape(-1, 3),
            _numbers(mesh.mergeFromVert, np.int64),
            _numbers(mesh.mergeToVert, np.int64),
            _numbers(mesh.runIndex, np.int64),
            mesh.runOriginalID.to_py().tolist(),
        )


class CrossSection(_Wrapped):
    """Area of the plane."""

    __slots__ = ()

    def __init__(self, contours: Any, rule: FillRule = FillRule.Positive) -> None:
        polygons = Array.of(*[_points(contour) for contour in contours])
        super().__init__(_module.CrossSection.new(polygons, rule.value))

    @classmethod
    def _of(cls, js: Any) -> CrossSection:
        self = cls.__new__(cls)
        self._js = js
        return self

    @classmethod
    def batch_boolean(cls, operands: list[CrossSection], operation: OpType) -> CrossSection:
        """Return the union, difference or intersection of areas."""
        return cls._of(getattr(_module.CrossSection, operation.value)(_list(operands)))

    @classmethod
    def hull_points(cls, points: Any) -> CrossSection:
        """Return the convex hull of points."""
        return cls._of(_module.CrossSection.hull(Array.of(_points(points))))

    @classmethod
    def square(cls, size: Any) -> CrossSection:
        """Return a rectangle."""
        return cls._of(_module.CrossSection.square(to_js([float(x) for x in size])))

    def to_polygons(self) -> list[Any]:
        """Return the contours."""
        return [np.array(polygon, np.float64) for polygon in self._js.toPolygons().to_py()]

    def is_empty(self) -> bool:
        """Return whether there is no area."""
        return bool(self._js.isEmpty())

    def area(self) -> float:
        """Return the area."""
        return float(self._js.area())

    def bounds(self) -> tuple[float, float, float, float]:
        """Return the least and greatest coordinates."""
        box = self._js.bounds().to_py()
        return (*box["min"], *box["max"])

    def translate(self, offset: Any) -> CrossSection:
        """Return the area at another place."""
        return self._of(self._js.translate(to_js([float(x) for x in offset])))

    def offset(self, distance: float, join: JoinType, limit: float, segments: int) -> CrossSection:
        """Return the area grown by a distance."""
        return self._of(self._js.offset(distance, join.value, limit, segments))

    def simplify(self, epsilon: float) -> CrossSection:
        """Return the area without details below a size."""
        return self._of(self._js.simplify(epsilon))

    def hull(self) -> CrossSection:
        """Return the convex hull."""
        return self._of(self._js.hull())

    def decompose(self) -> list[CrossSection]:
        """Return the connected parts."""
        return [self._of(part) for part in self._js.decompose()]

    def __xor__(self, other: CrossSection) -> CrossSection:
        return self._of(self._js.intersect(other._js))

    def extrude(self, height: float, divisions: int = 0, twist: float = 0.0, taper: Any = (1.0, 1.0)) -> Manifold:
        """Return the solid above the area."""
        return Manifold._made(self._js.extrude, height, divisions, twist, to_js([float(x) for x in taper]))

    def revolve(self, segments: int = 0, angle: float = 360.0) -> Manifold:
        """Return the solid around the second axis."""
        return Manifold._made(self._js.revolve, segments, angle)


def _list(operands: Any) -> Any:
    """Return wrapped objects as an array of JavaScript."""
    return Array.of(*[operand._js for operand in operands])


def triangulate(contours: Any) -> Any:
    """Return the triangles of a profile, as indices of its points."""
    polygons = [_points(contour) for contour in contours]
    return np.array(_module.triangulate(Array.of(*polygons)).to_py(), np.int64).reshape(-1, 3)
