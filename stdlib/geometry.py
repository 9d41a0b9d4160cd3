"""Poses: the matrices of the paper's table (docs/language.md, section 6: right-handed, +y up, radians)."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Mismatch, Registry, numbers_of, type_name, vector_of
from scenelang.interpreter.runtime.values import Matrix, Vector
from scenelang.interpreter.scene import parts, pose

registry = Registry("poses")
define = registry.define
_ORIGIN = (0.0, 0.0, 0.0)
_EXACT = 1 << 53


def _point(name: str, what: str, value: Vector) -> Vector:
    if len(value) != 3:
        raise SceneError("value", f"`{name}` wants three numbers for {what}, got {len(value)}: {show(value, 60)}")
    return value


def _finite(name: str, make: Callable[[], Matrix]) -> Matrix:
    try:
        matrix = make()
    except ValueError as error:
        raise SceneError("value", f"`{name}`: {error}") from None
    if not pose.is_finite(matrix):
        raise SceneError("pose", f"`{name}` was given nan, inf or a number too large, so its matrix is not finite")
    return matrix


@define(
    "translate", "offset::Vector", "Matrix", "The pose that moves by `offset`.",
    ("(@ (translate [1 2 3]) [0 0 0])", "[1.0 2.0 3.0]"),
)  # fmt: skip
def translate(rt: Runtime, offset: Vector) -> Matrix:
    if len(offset) == 3:
        x, y, z = offset
        if type(x) is int and -_EXACT < x < _EXACT and -_EXACT < y < _EXACT and -_EXACT < z < _EXACT:
            x, y, z = float(x), float(y), float(z)
        if type(x) is float and isfinite(x + y + z):
            return Matrix((1.0, 0.0, 0.0, x, 0.0, 1.0, 0.0, y, 0.0, 0.0, 1.0, z))
    x, y, z = _point("translate", "`offset`", offset)
    return _finite("translate", lambda: pose.translation(x, y, z))


@define(
    "rotate", "angle::Float axis::Vector [point::Vector]", "Matrix",
    "The right-hand rotation by `angle` radians about `axis` through `point` (the origin when left out).",
    ("(round (@ (rotate (/ pi 2) [0 1 0]) [1 0 0]) 6)", "[0.0 0.0 -1.0]"),
)  # fmt: skip
def rotate(rt: Runtime, angle: Any, axis: Vector, point: Any = _ORIGIN) -> Matrix:
    _point("rotate", "`axis`", axis)
    if point is not _ORIGIN:
        _point("rotate", "`point`", point)
    return _finite("rotate", lambda: pose.rotation(angle, axis, point))


@define(
    "scale", "factors [origin::Vector]", "Matrix",
    "The pose that scales by a number, or by three factors along x, y and z, about `origin`.",
    ("(@ (scale [2 1 1]) [1 1 1])", "[2.0 1.0 1.0]"),
)  # fmt: skip
def scale(rt: Runtime, factors: Any, origin: Any = _ORIGIN) -> Matrix:
    if origin is not _ORIGIN:
        _point("scale", "`origin`", origin)
    if type(factors) in (int, float):
        return _finite("scale", lambda: pose.scaling(factors, factors, factors, origin))
    numbers = numbers_of(factors, rt)
    if numbers is None:
        message = f"`scale` wants a number or three of them, got {type_name(factors)}: {show(factors, 60)}"
        raise SceneError("type", message, "its signature is (scale factors [origin])")
    try:
        x, y, z = _point("scale", "`factors`", vector_of(numbers))
    except Mismatch:
        raise SceneError("pose", "`scale` was given a number too large") from None
    return _finite("scale", lambda: pose.scaling(x, y, z, origin))


@define(
    "reflect", "first::Vector [normal::Vector]", "Matrix",
    "The mirror image in the plane through a point with a normal, `(reflect point normal)`; "
    "`(reflect normal)` for a plane through the origin.",
    ("(@ (reflect [1 0 0]) [1 2 3])", "[-1.0 2.0 3.0]"),
)  # fmt: skip
def reflect(rt: Runtime, first: Vector, normal: Vector | None = None) -> Matrix:
    point: Any = first
    if normal is None:
        point, normal = _ORIGIN, first
    _point("reflect", "the normal", normal)
    if point is not _ORIGIN:
        _point("reflect", "the point", point)
    mirror = normal
    return _finite("reflect", lambda: pose.reflection(point, mirror))


@define(
    "pose", "matrix", "Matrix", "The finite pose that a 4x4 array, mutable array or nested list is.",
    ("(pose [[1 0 0 5] [0 1 0 0] [0 0 1 0] [0 0 0 1]])",
     "[[1.0 0.0 0.0 5.0] [0.0 1.0 0.0 0.0] [0.0 0.0 1.0 0.0] [0.0 0.0 0.0 1.0]]"),
)  # fmt: skip
def to_pose(rt: Runtime, matrix: Any) -> Matrix:
    return parts.pose_from(rt, matrix)
