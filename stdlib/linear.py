"""Linear algebra: products, lengths, inverses."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter import pose
from scenelang.interpreter.library import Registry
from scenelang.interpreter.runtime import Runtime
from scenelang.interpreter.show import show
from scenelang.interpreter.values import IDENTITY, Matrix, Vector, make_list
from scenelang.stdlib.arraydata import INT64, Numpy, from_numpy, is_array, largest, to_numpy
from scenelang.stdlib.errors import wrong_type

registry = Registry("arrays")


def _shape(data: Numpy) -> str:
    return show(make_list(data.shape))


def matrix_product(rt: Runtime, a: Any, b: Any, name: str = "@") -> Any:
    """The product of two matrices or vectors; a pose moves a point."""
    if type(a) is Matrix:
        if type(b) is Matrix:
            return pose.compose(a, b)
        if type(b) is Vector and len(b) == 3:
            return Vector(map(float, pose.apply(a, b)))
    left, right = to_numpy(rt, a, name), to_numpy(rt, b, name)
    if left.shape == (4, 4) and right.shape == (3,):
        matrix = from_numpy(left)
        if type(matrix) is Matrix:
            return matrix_product(rt, matrix, Vector(right.tolist()))
    return _numpy_product(rt, name, np.matmul, left, right)


def _numpy_product(rt: Runtime, name: str, multiply: Callable[..., Any], left: Numpy, right: Numpy) -> Any:
    if not left.ndim or not right.ndim:
        raise SceneError(
            "type", f"`{name}` wants arrays, got a number", hint="a number times an array is `(* x array)`"
        )
    inner = left.shape[-1]
    if inner != right.shape[-2 if right.ndim > 1 else 0]:
        message = f"`{name}` cannot multiply arrays of the shapes {_shape(left)} and {_shape(right)}"
        raise SceneError("value", message, hint="the columns of the first must be as many as the rows of the second")
    size = max(1, left.size // max(1, inner)) * max(1, right.size // max(1, inner))
    rt.meter.check_size(size, "an array")
    rt.charge(size * inner >> (6 if left.dtype.kind == right.dtype.kind == "f" else 4))
    if left.dtype.kind == right.dtype.kind == "i" and largest(left) * largest(right) * max(1, inner) >= INT64:
        left = left.astype(float)
    try:
        with np.errstate(all="ignore"):
            return from_numpy(multiply(left, right))
    except ValueError:
        message = f"`{name}` cannot multiply arrays of the shapes {_shape(left)} and {_shape(right)}"
        raise SceneError("value", message) from None


@registry.define("@", "a::Any more::Any ...", "Any",
                 "The matrix product, of any number of matrices: `(@ A B)` as a pose applies B first. A pose moves a "
                 "point: `(@ pose [x y z])`.",
                 ("(list (@ (translate [1 0 0]) [5 6 7]) (@ [[1 2] [3 4]] [1 1]))", "([6.0 6.0 7.0] [3 7])"),
                 "matmul")  # fmt: skip
def matmul(rt: Runtime, a: Any, *more: Any) -> Any:
    if not more and not is_array(a):
        return from_numpy(to_numpy(rt, a, "@"))
    for other in more:
        a = matrix_product(rt, a, other)
    return a


@registry.define("dot", "a::Any b::Any", "Any", "The dot product of two vectors; of matrices, their product.",
                 ("(dot [1 2 3] [4 5 6])", "32"))  # fmt: skip
def dot(rt: Runtime, a: Any, b: Any) -> Any:
    if type(a) is Vector and type(b) is Vector and len(a) == len(b) == 3:
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return _numpy_product(rt, "dot", np.dot, to_numpy(rt, a, "dot"), to_numpy(rt, b, "dot"))


@registry.define("cross", "a::Vector b::Vector", "Vector",
                 "The cross product: at right angles to both, by the right-hand rule.",
                 ("(cross [1 0 0] [0 1 0])", "[0 0 1]"))  # fmt: skip
def cross(rt: Runtime, a: Vector, b: Vector) -> Any:
    if len(a) != 3 or len(b) != 3:
        raise SceneError("value", f"`cross` wants two vectors of length 3, got lengths {len(a)} and {len(b)}")
    (ax, ay, az), (bx, by, bz) = a, b
    return from_numpy(to_numpy(rt, Vector((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))))


def _flat(rt: Runtime, name: str, value: Any) -> list[float]:
    flat: list[float] = list(value) if type(value) is Vector else to_numpy(rt, value, name).ravel().tolist()
    if len(flat) > 16:
        rt.charge(len(flat) >> 4)
    return flat


def _length(numbers: list[float]) -> float:
    total = 0.0
    for number in numbers:
        total += float(number) * float(number)
    return math.sqrt(total) if 1e-300 < total < math.inf else math.hypot(*numbers)


@registry.define("norm", "v::Any", "Float", "The length of a vector: the root of the sum of squares.",
                 ("(norm [3 4])", "5.0"))  # fmt: skip
def norm(rt: Runtime, v: Any) -> float:
    return _length(_flat(rt, "norm", v))


@registry.define("normalize", "v::Vector", "Vector", "The vector of length 1 in the same direction.",
                 ("(normalize [0 3 4])", "[0.0 0.6 0.8]"))  # fmt: skip
def normalize(rt: Runtime, v: Vector) -> Any:
    length = norm(rt, v)
    if length == 0.0:
        raise SceneError("domain", "a vector of length 0 has no direction, so it cannot be normalized")
    rt.charge(len(v) >> 4)
    return Vector([x / length for x in v])


@registry.define("distance", "a::Any b::Any", "Float", "The distance between two points.",
                 ("(distance [1 1 0] [4 5 0])", "5.0"))  # fmt: skip
def distance(rt: Runtime, a: Any, b: Any) -> float:
    left, right = _flat(rt, "distance", a), _flat(rt, "distance", b)
    if len(left) != len(right):
        message = f"`distance` wants points of as many coordinates, got {len(left)} and {len(right)}"
        raise SceneError("value", message)
    return _length([x - y for x, y in zip(left, right)])


# --- square matrices -------------------------------------------------------------------------------------------


def _square(rt: Runtime, name: str, value: Any) -> Numpy:
    data = to_numpy(rt, value, name)
    if data.ndim != 2 or data.shape[0] != data.shape[1]:
        raise wrong_type(name, "a square matrix", value)
    rt.charge(data.shape[0] ** 3 >> 6)
    return data.astype(float)


def _singular(name: str) -> SceneError:
    return SceneError("domain", f"`{name}` got a matrix without an inverse: it flattens space")


@registry.define("inverse", "matrix::Any", "Array", "The inverse of a square matrix; of a pose, what undoes it.",
                 ("(@ (inverse (translate [1 2 3])) [1 2 3])", "[0.0 0.0 0.0]"))  # fmt: skip
def inverse(rt: Runtime, matrix: Any) -> Any:
    data = _square(rt, "inverse", matrix)
    try:
        result = np.linalg.inv(data)
    except np.linalg.LinAlgError:
        raise _singular("inverse") from None
    if data.shape == (4, 4) and data[3].tolist() == [0, 0, 0, 1]:
        result[3] = (0, 0, 0, 1)
    return from_numpy(result)


@registry.define("determinant", "matrix::Any", "Float",
                 "The determinant: the factor by which a matrix scales volumes, negative when it mirrors.",
                 ("(determinant [[2 0] [0 3]])", "6.0"))  # fmt: skip
def determinant(rt: Runtime, matrix: Any) -> Any:
    return float(np.linalg.det(_square(rt, "determinant", matrix)))


@registry.define("solve", "matrix::Any right::Any", "Array", "The vector x with `(@ matrix x)` equal to `right`.",
                 ("(solve [[2 0] [0 4]] [2 2])", "[1.0 0.5]"))  # fmt: skip
def solve(rt: Runtime, matrix: Any, right: Any) -> Any:
    data, wanted = _square(rt, "solve", matrix), to_numpy(rt, right, "solve")
    if not wanted.ndim or wanted.shape[0] != data.shape[0]:
        raise SceneError("value", f"`solve` wants {data.shape[0]} numbers on the right, got the shape {_shape(wanted)}")
    try:
        return from_numpy(np.linalg.solve(data, wanted))
    except np.linalg.LinAlgError:
        raise _singular("solve") from None


@registry.define(
    "identity-pose", "", "Matrix", "The pose that moves nothing.", ("(equal? (identity-pose) (eye 4))", "#t")
)
def identity_pose(rt: Runtime) -> Any:
    return IDENTITY
